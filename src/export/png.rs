//! PNG out of premultiplied linear light, and back.
//!
//! The order matters (T26): the background goes under the picture in linear light, then colour is encoded as sRGB, and
//! only then is it rounded, once, to the nearest step of 8 or 16 bits.

use std::io::Cursor;

use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

use super::image::LinearImage;
use crate::math::color::{Premultiplied, linear_from_srgb, srgb_from_linear};

/// Why a picture could not be written or read as PNG.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The picture has no pixels or not as many as its size says.
    #[error("a picture of {width}×{height} with {pixels} pixels cannot be written")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Pixels that are there.
        pixels: usize,
    },
    /// Neither 8 nor 16 bits.
    #[error("{0} bits a channel: expected 8 or 16")]
    Bits(u8),
    /// The encoder or decoder refused.
    #[error("{0}")]
    Codec(#[from] image::ImageError),
}

/// Encodes a picture with `bits` (8 or 16) a channel: over `background` (linear light) as RGB, or, without one, as RGBA
/// with straight alpha.
///
/// # Errors
/// [`PngError`] for an empty picture and bits other than 8 and 16.
pub fn write_png(image: &LinearImage, background: Option<[f32; 3]>, bits: u8) -> Result<Vec<u8>, PngError> {
    let (width, height, pixels) = (image.width, image.height, image.pixels.len());
    if width == 0 || height == 0 || pixels as u64 != u64::from(width) * u64::from(height) {
        return Err(PngError::Size { width, height, pixels });
    }
    let channels = if background.is_some() { 3 } else { 4 };
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(Cursor::new(&mut png));
    match bits {
        8 => {
            let bytes = steps(image, background, channels, 255.0, |v| v as u8);
            let color = if channels == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::Rgba8 };
            encoder.write_image(&bytes, width, height, color)?;
        }
        16 => {
            let words = steps(image, background, channels, 65535.0, |v| v as u16);
            let color = if channels == 3 { ExtendedColorType::Rgb16 } else { ExtendedColorType::Rgba16 };
            encoder.write_image(bytemuck::cast_slice(&words), width, height, color)?;
        }
        _ => return Err(PngError::Bits(bits)),
    }
    Ok(png)
}

/// The picture as a screen shows it: the very steps that [`write_png`] writes with 8 bits, as RGBA. Over `background` alpha
/// is 255; without one it is straight.
pub fn rgba8(image: &LinearImage, background: Option<[f32; 3]>) -> Vec<u8> {
    steps(image, background, 4, 255.0, |v| v as u8)
}

/// Encodes what [`rgba8`] gave: the file that [`write_png`] writes with 8 bits. `opaque` leaves alpha out.
///
/// # Errors
/// [`PngError`] for an empty picture or one of another size.
pub fn png_of_rgba8(rgba: &[u8], size: [u32; 2], opaque: bool) -> Result<Vec<u8>, PngError> {
    let [width, height] = size;
    let pixels = rgba.len() / 4;
    if pixels == 0 || pixels as u64 != u64::from(width) * u64::from(height) {
        return Err(PngError::Size { width, height, pixels });
    }
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(Cursor::new(&mut png));
    if opaque {
        let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        encoder.write_image(&rgb, width, height, ExtendedColorType::Rgb8)?;
    } else {
        encoder.write_image(rgba, width, height, ExtendedColorType::Rgba8)?;
    }
    Ok(png)
}

/// Decodes a PNG into premultiplied linear light.
///
/// # Errors
/// [`PngError::Codec`] if the bytes are not a PNG.
pub fn read_png(png: &[u8]) -> Result<LinearImage, PngError> {
    let rgba = image::ImageReader::with_format(Cursor::new(png), image::ImageFormat::Png).decode()?.into_rgba16();
    let pixels = rgba
        .pixels()
        .map(|p| {
            let [r, g, b, a] = p.0.map(|v| f64::from(v) / 65535.0);
            [linear_from_srgb(r) * a, linear_from_srgb(g) * a, linear_from_srgb(b) * a, a].map(|v| v as f32)
        })
        .collect();
    Ok(LinearImage { width: rgba.width(), height: rgba.height(), pixels })
}

/// Every channel as the nearest whole step of `0..=most`.
fn steps<T: Copy + Default + Send>(
    image: &LinearImage,
    background: Option<[f32; 3]>,
    channels: usize,
    most: f64,
    convert: impl Fn(f64) -> T + Sync,
) -> Vec<T> {
    let mut out = vec![T::default(); image.pixels.len() * channels];
    out.par_chunks_mut(channels).zip(&image.pixels).for_each(|(to, &pixel)| {
        let shown = match background {
            Some([r, g, b]) => Premultiplied(pixel).over(Premultiplied([r, g, b, 1.0])).0,
            None => Premultiplied(pixel).straight(),
        };
        for (i, (to, value)) in to.iter_mut().zip(shown).enumerate() {
            let value = f64::from(value);
            // A NaN alpha becomes 0 in the conversion to a whole number.
            let encoded = if i == 3 { value.clamp(0.0, 1.0) } else { srgb_from_linear(value) };
            *to = convert((encoded * most).round());
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::image::parse_background;

    fn one(pixel: [f32; 4]) -> LinearImage {
        LinearImage { width: 1, height: 1, pixels: vec![pixel] }
    }

    fn decoded(pixel: [f32; 4], background: Option<[f32; 3]>, bits: u8) -> image::DynamicImage {
        image::load_from_memory(&write_png(&one(pixel), background, bits).unwrap()).unwrap()
    }

    #[test]
    fn every_byte_of_a_background_comes_back_exactly() {
        for v in 0..=255_u8 {
            let background = parse_background(&format!("#{v:02x}{v:02x}{v:02x}")).unwrap();
            assert_eq!(decoded([0.0; 4], background, 8).into_rgb8().into_raw(), [v; 3]);
            assert_eq!(decoded([0.0; 4], background, 16).into_rgb16().into_raw(), [u16::from(v) * 257; 3]);
        }
    }

    #[test]
    fn the_background_goes_under_in_linear_light() {
        // Half black over white is 0.5 linear: 188 in sRGB, not 128.
        let image = decoded([0.0, 0.0, 0.0, 0.5], Some([1.0; 3]), 8);
        assert!(matches!(image, image::DynamicImage::ImageRgb8(_)));
        assert_eq!(image.into_rgb8().into_raw(), [188; 3]);
    }

    #[test]
    fn without_a_background_alpha_is_straight() {
        let image = decoded([0.25, 0.0, 0.5, 0.5], None, 8);
        assert!(matches!(image, image::DynamicImage::ImageRgba8(_)));
        assert_eq!(image.into_rgba8().into_raw(), [188, 0, 255, 128]);
        assert_eq!(decoded([0.0; 4], None, 8).into_rgba8().into_raw(), [0; 4]);
    }

    #[test]
    fn values_round_to_the_nearest_step_and_garbage_is_clamped() {
        for (step, offset, expected) in [(100.0, 0.49, 100), (100.0, 0.51, 101), (100.0, -0.49, 100)] {
            let linear = linear_from_srgb((step + offset) / 255.0) as f32;
            assert_eq!(decoded([linear, linear, linear, 1.0], None, 8).into_rgb8().into_raw(), [expected; 3]);
        }
        assert_eq!(decoded([f32::NAN, 7.0, -1.0, 1.0], None, 8).into_rgb8().into_raw(), [0, 255, 0]);
        assert_eq!(decoded([0.0, 0.0, 0.0, f32::NAN], None, 16).into_rgba16().into_raw()[3], 0);
    }

    #[test]
    fn what_a_screen_shows_is_what_is_written() {
        let pixels: Vec<[f32; 4]> = (0..60).map(|i| [i as f32 / 90.0, 0.2, 0.01 * i as f32, 0.7]).collect();
        let image = LinearImage { width: 10, height: 6, pixels };
        for background in [None, Some([0.1, 0.2, 0.3])] {
            let png = png_of_rgba8(&rgba8(&image, background), [10, 6], background.is_some()).unwrap();
            assert_eq!(png, write_png(&image, background, 8).unwrap());
        }
        assert!(png_of_rgba8(&[0; 4], [2, 1], true).is_err());
    }

    #[test]
    fn a_picture_survives_the_way_out_and_back() {
        let pixels: Vec<[f32; 4]> = (0..64)
            .map(|i| {
                let a = (i % 8 + 1) as f32 / 8.0;
                [a * i as f32 / 64.0, a * 0.5, a * (1.0 - i as f32 / 64.0), a]
            })
            .collect();
        let image = LinearImage { width: 8, height: 8, pixels };
        // Half a step of colour and half a step of alpha.
        for (bits, most) in [(8, 1.0 / 255.0), (16, 1.0 / 65535.0)] {
            let back = read_png(&write_png(&image, None, bits).unwrap()).unwrap();
            let encoded = |[r, g, b, a]: [f32; 4]| {
                [r, g, b].map(|c| srgb_from_linear(f64::from(c / a)) * f64::from(a)).into_iter().chain([f64::from(a)])
            };
            for (x, y) in image.pixels.iter().zip(&back.pixels) {
                let off = encoded(*x).zip(encoded(*y)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
                assert!(off < most + 1e-6, "{bits} bits: {x:?} {y:?}");
            }
        }
    }

    #[test]
    fn an_empty_picture_and_odd_bits_are_refused() {
        assert!(matches!(write_png(&LinearImage::clear(0, 4), None, 8), Err(PngError::Size { .. })));
        assert!(matches!(write_png(&one([0.0; 4]), None, 12), Err(PngError::Bits(12))));
        assert!(read_png(b"GIF89a").is_err());
    }
}
