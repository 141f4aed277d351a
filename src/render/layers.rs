//! The layers of a picture, read back: one image for each index, nearest first.
//!
//! The frame is drawn as for [`Renderer::render`], with one sample a pixel, and each band's store is decoded before the next
//! band takes its place. What blending does to a layer's opacity on the way (the same for all under a constant model, ghosts,
//! parts with an opacity of their own) is done here in the same arithmetic, so that the images over each other, front to back,
//! are the picture. Three things of a picture are no layers: the outline of what is selected, the average of what lies behind
//! the k nearest, and what illustrative transparency lets through where it follows its printed form.

use glam::Vec3;

use super::pick::part_alpha;
use super::{Frame, GpuScene, RenderError, Renderer, StoreReadback, frame};
use crate::math::{Camera, LayerImage};
use crate::plan::{self, ViewStats};
use crate::settings::Settings;

/// The layers of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// By index, nearest first; each the smallest rectangle that holds all its pixels.
    pub images: Vec<LayerImage>,
    /// Layers of the deepest pixel.
    pub deepest: u32,
    /// Layers of all pixels that were left out because their index was too high.
    pub left_out: u64,
}

impl Renderer {
    /// Draws a picture with one sample a pixel and reads back its layers, the `most` nearest of each pixel.
    ///
    /// # Errors
    /// [`RenderError`] says what was refused or failed.
    pub fn render_layers(
        &mut self,
        scene: &GpuScene,
        camera: &Camera,
        settings: &Settings,
        size: [u32; 2],
        most: u32,
    ) -> Result<(Frame, Layers), RenderError> {
        let transfer = settings.opacity.transfer.resolve(None)?;
        let view = ViewStats::of(camera);
        let plan = plan::plan_layers(settings, &transfer, &scene.stats, &view, self.gpu.capabilities(), size)?;
        self.collected = Some(Vec::new());
        let drawn = frame::draw(self, scene, camera, settings, &transfer, plan);
        let bands = self.collected.take().unwrap_or_default();
        let frame = drawn?;
        let constant = frame.report.plan.blend_opacity() as f32;
        let ghost = settings.opacity.ghost as f32;
        let world_from_view = camera.view_from_world().inverse();
        let counts = || bands.iter().flat_map(|b| &b.layers.counts).copied();
        let deepest = counts().max().unwrap_or(0);
        let mut layers = Layers {
            images: rectangles(counts(), size[0], deepest.min(most)),
            deepest,
            left_out: counts().map(|count| u64::from(count.saturating_sub(most))).sum(),
        };
        let mut pixel = 0;
        for StoreReadback { layers: store, kappa, lit, .. } in &bands {
            for (&first, &count) in store.offsets.iter().zip(&store.counts) {
                for (image, i) in layers.images.iter_mut().zip(first..first + count as usize) {
                    let part = scene.cut.owner(store.part[i]);
                    let [r, g, b, a] = lit[i];
                    let alpha = part_alpha(&scene.arrangement.look(part), (a * constant).clamp(0.0, 1.0), ghost);
                    let normal = world_from_view.transform_vector3(Vec3::from(store.normal[i]).as_dvec3());
                    let ([left, top], [width, _]) = (image.corner, image.size);
                    let at = ((pixel / size[0] - top) * width + pixel % size[0] - left) as usize;
                    image.depth[at] = store.depth[i] as f32;
                    image.part[at] = part;
                    image.normal[at] = normal.normalize_or_zero().as_vec3().to_array();
                    image.kappa[at] = kappa.get(i).copied().unwrap_or(0.0);
                    image.color[at] = [r * alpha, g * alpha, b * alpha, alpha];
                }
                pixel += 1;
            }
        }
        Ok((frame, layers))
    }
}

/// For each index the smallest rectangle around the pixels that have such a layer, given how many layers each pixel has.
fn rectangles(counts: impl Iterator<Item = u32>, width: u32, layers: u32) -> Vec<LayerImage> {
    // Left, top, right and bottom of the pixels that have exactly so many layers, at most `layers`.
    let mut boxes = vec![[u32::MAX, u32::MAX, 0, 0]; layers as usize + 1];
    let join = |a: &mut [u32; 4], b: [u32; 4]| {
        *a = [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    };
    for (pixel, count) in (0_u32..).zip(counts) {
        let (x, y) = (pixel % width, pixel / width);
        join(&mut boxes[count.min(layers) as usize], [x, y, x, y]);
    }
    // Who has more layers has this one too.
    for i in (1..layers as usize).rev() {
        let deeper = boxes[i + 1];
        join(&mut boxes[i], deeper);
    }
    let image =
        |&[left, top, right, bottom]: &[u32; 4]| LayerImage::empty([left, top], [right - left + 1, bottom - top + 1]);
    boxes[1..].iter().map(image).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_hold_every_pixel_of_a_layer_and_no_more() {
        // 4 by 3: one layer in the corners of a diagonal, three in one pixel, two beside it.
        let counts = [1, 0, 0, 0, 0, 3, 2, 0, 0, 0, 0, 1];
        let found = rectangles(counts.into_iter(), 4, 3);
        let boxes: Vec<([u32; 2], [u32; 2])> = found.iter().map(|l| (l.corner, l.size)).collect();
        assert_eq!(boxes, [([0, 0], [4, 3]), ([1, 1], [2, 1]), ([1, 1], [1, 1])]);
        let few = rectangles(counts.into_iter(), 4, 2);
        assert_eq!(few[1].size, [2, 1], "a third layer has a second before it");
        assert!(rectangles([0, 0].into_iter(), 2, 0).is_empty());
    }
}
