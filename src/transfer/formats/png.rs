//! Images: a strip of colours over κ, or a map of opacities over (depth, |κ|).
//!
//! An image at least four times as wide as high is a strip, of which the first row counts; any other is a map, of which
//! the red channel counts. We write 16 bits, so that nothing is lost but rounding (1/131070).

use std::io::Cursor;

use image::{ImageBuffer, ImageFormat, Luma, Rgb};

use super::{Format, Imported, assemble, not_written_mode};
use crate::transfer::raster::Raster;
use crate::transfer::{
    ColorFunction, ColorMode, ColorShape, OpacityFunction, OpacityShape, TABLE_SIZE, TransferError, TransferFunction,
};

/// Reads an image.
pub(super) fn read(bytes: &[u8], path: &str, map: Option<&str>) -> Result<Imported, TransferError> {
    if map.is_some() {
        return Err(TransferError::file(path, "a PNG holds no named maps"));
    }
    // The raster is called by its file's name alone: whoever writes it does so beside the image.
    let mut raster = Raster::named(path.to_owned());
    raster.load(bytes).map_err(|reason| TransferError::file(path, reason))?;
    let mut notices = Vec::new();
    let facts = raster.facts().unwrap_or_default();
    if facts.translucent {
        notices.push("ignored: the image's alpha channel".to_owned());
    }
    let [width, height] = facts.size;
    let (color, opacity) = if width >= 4 * height {
        if facts.rows_differ {
            notices.push("ignored: rows of the strip below the first".to_owned());
        }
        (Some(ColorFunction { mode: ColorMode::Tint, shape: ColorShape::Strip(raster) }), None)
    } else {
        if facts.coloured {
            notices.push("ignored: green and blue of a map of opacities".to_owned());
        }
        (None, Some(OpacityFunction { shape: OpacityShape::Image(raster) }))
    };
    assemble(color, opacity, notices).map_err(|reason| TransferError::file(path, reason))
}

/// Writes 256 colours over κ as one row.
pub(super) fn write_strip(function: &TransferFunction, notices: &mut Vec<String>) -> Result<Vec<u8>, TransferError> {
    not_written_mode(function, Format::PngStrip, notices);
    notices.push("ignored: a strip holds no opacity; a name that ends in .opacity.png writes it".to_owned());
    let pixels = function.color.bake().into_iter().flatten().map(sixteen_bits).collect();
    let image = ImageBuffer::<Rgb<u16>, Vec<u16>>::from_raw(TABLE_SIZE as u32, 1, pixels);
    encode(image.map(image::DynamicImage::ImageRgb16))
}

/// Writes 256×256 opacities: depth to the right, |κ| upwards.
pub(super) fn write_map(function: &TransferFunction, notices: &mut Vec<String>) -> Result<Vec<u8>, TransferError> {
    notices.push("ignored: a map of opacities holds no colour".to_owned());
    let table = function.opacity.bake();
    let pixels = table.chunks(TABLE_SIZE).rev().flatten().copied().map(sixteen_bits).collect();
    let size = TABLE_SIZE as u32;
    let image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(size, size, pixels);
    encode(image.map(image::DynamicImage::ImageLuma16))
}

fn sixteen_bits(v: f32) -> u16 {
    (f64::from(v) * 65535.0).round() as u16
}

fn encode(image: Option<image::DynamicImage>) -> Result<Vec<u8>, TransferError> {
    let failed = |reason: &dyn std::fmt::Display| TransferError::file("PNG", reason);
    let image = image.ok_or_else(|| failed(&"a table has the wrong size"))?;
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).map_err(|e| failed(&e))?;
    Ok(bytes)
}
