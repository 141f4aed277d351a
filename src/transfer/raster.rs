//! A PNG that holds a function. Its values are plain numbers: a byte over 255, with no colour decoding.

use std::io::Cursor;
use std::sync::Arc;

/// Images wider or higher than this are refused before decoding.
const LARGEST: u32 = 4096;

/// An image named by a transfer function, and its values once [`super::TransferSource::resolve`] has read it.
///
/// Only the path is written to text; two rasters are equal if path and values are.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    path: String,
    pixels: Option<Arc<Pixels>>,
}

#[derive(Debug, PartialEq)]
struct Pixels {
    width: usize,
    height: usize,
    /// Rows from the top.
    values: Vec<[f32; 3]>,
}

impl Raster {
    /// Names an image; a relative path counts from the folder of the file that names it.
    pub fn named(path: String) -> Raster {
        Raster { path, pixels: None }
    }

    /// The path as written.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Whether the image has been read.
    pub(super) fn is_loaded(&self) -> bool {
        self.pixels.is_some()
    }

    /// Decodes a PNG into this raster.
    ///
    /// # Errors
    /// A sentence for the user if the bytes are not a PNG of at most 4096×4096 pixels.
    pub(super) fn load(&mut self, png: &[u8]) -> Result<(), String> {
        let mut reader = image::ImageReader::with_format(Cursor::new(png), image::ImageFormat::Png);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(LARGEST);
        limits.max_image_height = Some(LARGEST);
        reader.limits(limits);
        let decoded = reader.decode().map_err(|e| format!("not a usable PNG: {e}"))?;
        // Through 16 bits, which hold 8 exactly (times 257).
        let rgb = decoded.into_rgb16();
        let values = rgb.pixels().map(|p| p.0.map(|v| (f64::from(v) / 65535.0) as f32)).collect();
        self.pixels = Some(Arc::new(Pixels { width: rgb.width() as usize, height: rgb.height() as usize, values }));
        Ok(())
    }

    /// The value at (x, y) in [0, 1]², y upwards: bilinear between pixel centres, which span the whole range, so that
    /// a 256×256 image is the baked table itself. `None` if the image has not been loaded.
    pub(super) fn sample(&self, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
        let pixels = self.pixels.as_deref()?;
        let (x0, x1, tx) = span(x, pixels.width);
        let (y0, y1, ty) = span(1.0 - y, pixels.height);
        let at = |x: usize, y: usize| pixels.values[y * pixels.width + x].map(f64::from);
        let mix = |a: [f64; 3], b: [f64; 3], t: f64| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
        Some(mix(mix(at(x0, y0), at(x1, y0), tx), mix(at(x0, y1), at(x1, y1), tx), ty))
    }
}

/// The two of `count` entries around `x` in [0, 1] and the weight of the second. NaN reads as 0.
pub(super) fn span(x: f64, count: usize) -> (usize, usize, f64) {
    let last = count.saturating_sub(1);
    let at = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) } * last as f64;
    let first = (at.floor() as usize).min(last);
    (first, (first + 1).min(last), at - first as f64)
}
