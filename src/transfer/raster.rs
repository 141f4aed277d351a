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
    translucent: bool,
}

/// What a loaded image is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RasterFacts {
    /// Width and height.
    pub size: [usize; 2],
    /// Whether any pixel is not grey.
    pub coloured: bool,
    /// Whether any pixel's alpha, which nothing here reads, is below 1.
    pub translucent: bool,
    /// Whether any row differs from the first.
    pub rows_differ: bool,
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

    /// What the image is like, once it has been read.
    pub(super) fn facts(&self) -> Option<RasterFacts> {
        let pixels = self.pixels.as_deref()?;
        let mut rows = pixels.values.chunks(pixels.width.max(1));
        let first = rows.next();
        Some(RasterFacts {
            size: [pixels.width, pixels.height],
            coloured: pixels.values.iter().any(|[r, g, b]| r != g || g != b),
            translucent: pixels.translucent,
            rows_differ: rows.any(|row| Some(row) != first),
        })
    }

    /// Width and height, once the image has been read.
    pub(super) fn size(&self) -> Option<[usize; 2]> {
        self.pixels.as_deref().map(|p| [p.width, p.height])
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
        let translucent = decoded.color().has_alpha() && decoded.to_rgba16().pixels().any(|p| p.0[3] < u16::MAX);
        // Through 16 bits, which hold 8 exactly (times 257).
        let rgb = decoded.into_rgb16();
        let values = rgb.pixels().map(|p| p.0.map(|v| (f64::from(v) / 65535.0) as f32)).collect();
        self.pixels =
            Some(Arc::new(Pixels { width: rgb.width() as usize, height: rgb.height() as usize, values, translucent }));
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
