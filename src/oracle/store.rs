//! The neutral form of a fragment store: the layers of every pixel in depth order, as columns.
//!
//! A read-back from the GPU and the oracle's own [`Layers`] are both brought into this form; every later stage reads
//! nothing else. Layers of a pixel lie at `offsets[pixel] .. offsets[pixel] + counts[pixel]`, pixels in rows from the
//! top, and all fragment columns have the same length: that is what the stages rely on, as they rely on one entry a
//! fragment in every other list that they are given.

use std::ops::Range;

use super::raster::Layers;

/// Layers of all pixels, as columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoreData {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Layers of each pixel.
    pub counts: Vec<u32>,
    /// Whether the pixel lost fragments because its list was full.
    pub overflowed: Vec<bool>,
    /// Index of each pixel's first fragment.
    pub offsets: Vec<usize>,
    /// Depth half of the key; smaller is nearer.
    pub depth_key: Vec<u32>,
    /// Instanced-triangle number.
    pub triangle: Vec<u32>,
    /// Index of the part.
    pub part: Vec<u32>,
    /// Distance along the view, scene units.
    pub depth: Vec<f64>,
    /// Unit normal in view space, facing as the contract says.
    pub normal: Vec<[f32; 3]>,
    /// Whether the outer side of the surface faces the viewer.
    pub side: Vec<bool>,
    /// Linear rgb and straight alpha; alpha is 1 unless the material blends.
    pub base_color: Vec<[f32; 4]>,
    /// Metalness, 0 to 1.
    pub metallic: Vec<f32>,
    /// Perceptual roughness, 0 to 1.
    pub roughness: Vec<f32>,
    /// Ambient occlusion, 1 is open.
    pub occlusion: Vec<f32>,
    /// Emitted light, linear rgb.
    pub emissive: Vec<[f32; 3]>,
    /// Whether base colour is shown as it is.
    pub unlit: Vec<bool>,
    /// Place in the surface's parametrization, radii of the part, and how far it goes over a pixel in x and in y; all zero where
    /// the surface has none. Empty if nobody asked.
    pub parameters: Vec<[f32; 4]>,
}

impl StoreData {
    /// The store that holds all of `layers`.
    pub fn from_layers(layers: &Layers) -> StoreData {
        StoreData::from_nearest_layers(layers, usize::MAX)
    }

    /// The store that holds the `k` nearest layers of every pixel; a pixel with more is marked as overflowed.
    pub fn from_nearest_layers(layers: &Layers, k: usize) -> StoreData {
        let mut store = StoreData { width: layers.width, height: layers.height, ..StoreData::default() };
        for pixel in &layers.pixels {
            let kept = pixel.fragments.len().min(k);
            store.counts.push(kept as u32);
            store.overflowed.push(pixel.fragments.len() > kept);
            store.offsets.push(store.depth.len());
            for f in &pixel.fragments[..kept] {
                let s = &f.surface;
                store.depth_key.push(f.depth_key);
                store.triangle.push(f.triangle);
                store.part.push(f.part);
                store.depth.push(f.depth);
                store.normal.push(f.normal_in_view.as_vec3().to_array());
                store.side.push(f.side);
                store.base_color.push(s.base_color.map(|c| c as f32));
                store.metallic.push(s.metallic as f32);
                store.roughness.push(s.roughness as f32);
                store.occlusion.push(s.occlusion as f32);
                store.emissive.push(s.emissive.map(|c| c as f32));
                store.unlit.push(s.unlit);
                store.parameters.push(f.parameters.map_or([0.0; 4], |p| p.map(|c| c as f32)));
            }
        }
        store
    }

    /// Number of fragments.
    pub fn len(&self) -> usize {
        self.depth.len()
    }

    /// Whether there is no fragment.
    pub fn is_empty(&self) -> bool {
        self.depth.is_empty()
    }

    /// Indices of a pixel's fragments, nearest first.
    pub fn range(&self, pixel: usize) -> Range<usize> {
        self.offsets[pixel]..self.offsets[pixel] + self.counts[pixel] as usize
    }

    /// The pixel of every fragment.
    pub fn pixel_of_fragment(&self) -> Vec<usize> {
        let mut pixels = vec![0; self.len()];
        for pixel in 0..self.counts.len() {
            pixels[self.range(pixel)].fill(pixel);
        }
        pixels
    }

    /// Column and row of a pixel.
    pub fn xy(&self, pixel: usize) -> (u32, u32) {
        let width = self.width.max(1) as usize;
        ((pixel % width) as u32, (pixel / width) as u32)
    }
}

/// A row of pixels one unit wide, seen in parallel; each fragment is (part, depth, slope in x).
#[cfg(test)]
pub(super) fn row(pixels: &[&[(u32, f64, f64)]]) -> (StoreData, super::View) {
    use glam::{DVec2, DVec3};
    let width = pixels.len() as u32;
    let mut store = StoreData { width, height: 1, ..StoreData::default() };
    for fragments in pixels {
        store.offsets.push(store.depth.len());
        store.counts.push(fragments.len() as u32);
        store.overflowed.push(false);
        for &(part, depth, slope) in *fragments {
            store.part.push(part);
            store.depth.push(depth);
            // Depth grows away from the viewer, so a surface that recedes to the right faces right.
            store.normal.push(DVec3::new(slope, 0.0, 1.0).normalize().as_vec3().to_array());
        }
    }
    let half_extent = DVec2::new(0.5 * f64::from(width), 0.5);
    (store, super::View { width, height: 1, perspective: false, half_extent, shift: DVec2::ZERO })
}
