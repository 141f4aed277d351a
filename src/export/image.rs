//! A picture in linear light, how pictures are put side by side, and how they are read from files.

use super::exr::{ExrError, MAGIC, read_exr};
use super::png::{PngError, read_png};
pub use crate::math::LinearImage;
use crate::math::color::linear_from_srgb;
use crate::transfer::hex;

impl LinearImage {
    /// A wholly transparent picture.
    pub fn clear(width: u32, height: u32) -> LinearImage {
        LinearImage { width, height, pixels: vec![[0.0; 4]; width as usize * height as usize] }
    }

    /// Pictures from left to right, aligned at the top, `gap` transparent pixels between them.
    pub fn side_by_side(pictures: &[LinearImage], gap: u32) -> LinearImage {
        let gaps = gap * pictures.len().saturating_sub(1) as u32;
        let width = pictures.iter().map(|p| p.width).sum::<u32>() + gaps;
        let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
        let mut all = LinearImage::clear(width, height);
        let mut left = 0;
        for picture in pictures {
            let rows = picture.pixels.chunks_exact(picture.width.max(1) as usize);
            for (to, from) in all.pixels.chunks_exact_mut(width.max(1) as usize).zip(rows) {
                to[left..left + from.len()].copy_from_slice(from);
            }
            left += (picture.width + gap) as usize;
        }
        all
    }
}

/// A background: `none` (transparent, `None`) or `#rrggbb` in sRGB, as linear light.
///
/// # Errors
/// A sentence for the user.
pub fn parse_background(text: &str) -> Result<Option<[f32; 3]>, String> {
    if text == "none" {
        return Ok(None);
    }
    hex(text)
        .map(|rgb| Some(rgb.map(|v| linear_from_srgb(v) as f32)))
        .ok_or_else(|| format!("background '{text}': expected none or the form #rrggbb"))
}

/// Why a picture could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// It is no PNG, or a broken one.
    #[error(transparent)]
    Png(#[from] PngError),
    /// It is a broken EXR, or one without a picture.
    #[error(transparent)]
    Exr(#[from] ExrError),
}

/// Decodes a PNG or an EXR, told apart by their first bytes, into premultiplied linear light.
///
/// # Errors
/// [`PictureError`] if it is neither, or broken.
pub fn read_picture(bytes: &[u8]) -> Result<LinearImage, PictureError> {
    if bytes.starts_with(&MAGIC) { Ok(read_exr(bytes)?) } else { Ok(read_png(bytes)?) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_parse_strictly() {
        assert_eq!(parse_background("none"), Ok(None));
        assert_eq!(parse_background("#ffffff"), Ok(Some([1.0; 3])));
        assert_eq!(parse_background("#000000"), Ok(Some([0.0; 3])));
        let [r, g, b] = parse_background("#8040Ff").unwrap().unwrap();
        assert!((r - 0.215_860_5).abs() < 1e-6 && (g - 0.051_269_5).abs() < 1e-6 && b == 1.0, "{r} {g} {b}");
        for bad in ["", "white", "ffffff", "#fff", "#fffffff", "#ggffff", "#+12345", "None", " #ffffff"] {
            assert!(parse_background(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn side_by_side_keeps_rows_apart() {
        let picture = |value: f32| LinearImage { width: 2, height: 2, pixels: vec![[value; 4]; 4] };
        let all = LinearImage::side_by_side(&[picture(0.25), picture(0.5), picture(1.0)], 1);
        assert_eq!((all.width, all.height), (8, 2));
        let row = [0.25, 0.25, 0.0, 0.5, 0.5, 0.0, 1.0, 1.0];
        assert_eq!(all.pixels.iter().map(|p| p[0]).collect::<Vec<_>>(), [row, row].concat());
    }
}
