//! A picture in linear light, how pictures are put side by side, and how far two of them differ.

pub use crate::math::LinearImage;
use crate::math::color::{linear_from_srgb, srgb_from_linear};
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

/// How far two pictures differ, over all channels of all pixels, in sRGB values from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Largest difference.
    pub max: f64,
    /// Mean difference.
    pub mean: f64,
    /// Share of pixels of which some channel differs by more than 1/255.
    pub visible: f64,
}

/// A difference of one 8-bit step counts as equal; half a step more allows for the rounding of 16-bit values.
const STEP: f64 = 1.5 / 255.0;

/// Compares two pictures as they would be encoded: sRGB values times alpha, and alpha.
///
/// # Errors
/// A sentence for the user if their sizes differ.
pub fn compare(a: &LinearImage, b: &LinearImage) -> Result<Difference, String> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(format!("{}×{} pixels against {}×{}", a.width, a.height, b.width, b.height));
    }
    let mut result = Difference { max: 0.0, mean: 0.0, visible: 0.0 };
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        let (a, b) = (encoded(*a), encoded(*b));
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        let largest = differences.clone().fold(0.0, f64::max);
        result.max = result.max.max(largest);
        result.mean += differences.sum::<f64>();
        result.visible += f64::from(u8::from(largest > STEP));
    }
    let count = a.pixels.len().max(1) as f64;
    result.mean /= 4.0 * count;
    result.visible /= count;
    Ok(result)
}

fn encoded([r, g, b, a]: [f32; 4]) -> [f64; 4] {
    let alpha = if a.is_nan() { 0.0 } else { f64::from(a).clamp(0.0, 1.0) };
    let channel = |c: f32| if alpha > 0.0 { srgb_from_linear(f64::from(c) / f64::from(a)) * alpha } else { 0.0 };
    [channel(r), channel(g), channel(b), alpha]
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

    #[test]
    fn differences_are_measured() {
        let mut a = LinearImage { width: 2, height: 1, pixels: vec![[1.0, 1.0, 1.0, 1.0]; 2] };
        let mut b = a.clone();
        assert_eq!(compare(&a, &b).unwrap(), Difference { max: 0.0, mean: 0.0, visible: 0.0 });
        b.pixels[1] = [0.0, 1.0, 1.0, 1.0];
        let d = compare(&a, &b).unwrap();
        assert!((d.max - 1.0).abs() < 1e-9 && (d.mean - 0.125).abs() < 1e-9 && d.visible == 0.5, "{d:?}");
        b.pixels[1] = [linear_from_srgb(254.0 / 255.0) as f32, 1.0, 1.0, 1.0];
        assert_eq!(compare(&a, &b).unwrap().visible, 0.0);
        // Colour under no coverage is no colour.
        (a.pixels[0], b.pixels[0]) = ([0.5, 0.5, 0.5, 0.0], [0.0; 4]);
        assert!(compare(&a, &b).unwrap().max < 0.01);
        assert!(compare(&a, &LinearImage::clear(1, 2)).is_err());
    }
}
