//! How far a picture is from the reference, as displayed.
//!
//! Both are laid over a background in linear light and encoded as sRGB, and then *not* rounded: a step of 1/255 is the unit,
//! but errors far below one are measured too. Without a background, both are laid over middle grey, where an error of
//! coverage shows whatever the colour.

use serde::{Deserialize, Serialize};

use super::flip::{Wanted, flip_while};
use super::statistics::percentile;
use crate::math::LinearImage;
use crate::math::color::{Premultiplied, linear_from_srgb, srgb_from_linear};

/// Steps of an 8-bit channel.
const STEPS: f64 = 255.0;
/// Pictures are kept in single precision: a difference of exactly one step comes out a little above or below it. So much, in
/// steps, does not count as above.
const ROUNDING: f64 = 1e-3;

/// Errors of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImageError {
    /// Largest difference of a channel, in 8-bit steps, 0 to 255.
    pub maximum: f64,
    /// Mean difference over all channels and pixels, in 8-bit steps.
    pub mean: f64,
    /// Share of pixels of which a channel differs by more than 1/255, 0 to 1.
    pub above_1: f64,
    /// Share of pixels of which a channel differs by more than 8/255, 0 to 1.
    pub above_8: f64,
    /// Mean of FLIP, 0 to 1.
    pub flip_mean: f64,
    /// 99th percentile of FLIP.
    pub flip_p99: f64,
}

/// Errors, and where they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorMap {
    /// The figures.
    pub error: ImageError,
    /// Largest difference of a channel, in 8-bit steps, by pixel.
    pub steps: Vec<f64>,
    /// FLIP by pixel.
    pub flip: Vec<f64>,
}

/// A picture as displayed: sRGB values from 0 to 1, unrounded, over a background in linear light.
pub fn displayed(image: &LinearImage, background: Option<[f32; 3]>) -> Vec<[f64; 3]> {
    let grey = linear_from_srgb(0.5) as f32;
    let [r, g, b] = background.unwrap_or([grey; 3]);
    let over = |p: &[f32; 4]| Premultiplied(*p).over(Premultiplied([r, g, b, 1.0])).0;
    image.pixels.iter().map(over).map(|[r, g, b, _]| [r, g, b].map(|v| srgb_from_linear(f64::from(v)))).collect()
}

/// Two pictures cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a picture of {}x{} pixels cannot be compared with one of {}x{}", found[0], found[1], expected[0], expected[1])]
pub struct SizesDiffer {
    /// Size of the picture.
    pub found: [u32; 2],
    /// Size of the reference.
    pub expected: [u32; 2],
}

/// Compares a picture with the reference.
///
/// # Errors
/// [`SizesDiffer`].
pub fn compare(
    image: &LinearImage,
    reference: &LinearImage,
    background: Option<[f32; 3]>,
) -> Result<ErrorMap, SizesDiffer> {
    // It is wanted to the end.
    Ok(compare_while(image, reference, background, &|| true)?.unwrap_or_default())
}

/// [`compare`], given up soon after `wanted` says no; `None` then.
///
/// # Errors
/// [`SizesDiffer`].
pub fn compare_while(
    image: &LinearImage,
    reference: &LinearImage,
    background: Option<[f32; 3]>,
    wanted: Wanted<'_>,
) -> Result<Option<ErrorMap>, SizesDiffer> {
    let (found, expected) = ([image.width, image.height], [reference.width, reference.height]);
    if found != expected || image.pixels.len() != reference.pixels.len() {
        return Err(SizesDiffer { found, expected });
    }
    let (a, b) = (displayed(image, background), displayed(reference, background));
    let mut sum = 0.0;
    let steps: Vec<f64> = a
        .iter()
        .zip(&b)
        .map(|(a, b)| {
            let off: [f64; 3] = std::array::from_fn(|c| STEPS * (a[c] - b[c]).abs());
            sum += off.iter().sum::<f64>();
            off.into_iter().fold(0.0, f64::max)
        })
        .collect();
    let Some(flip) = flip_while(&a, &b, image.width as usize, wanted) else {
        return Ok(None);
    };
    let count = steps.len().max(1) as f64;
    let above = |limit: f64| steps.iter().filter(|s| **s > limit + ROUNDING).count() as f64 / count;
    let error = ImageError {
        maximum: steps.iter().copied().fold(0.0, f64::max),
        mean: sum / (3.0 * count),
        above_1: above(1.0),
        above_8: above(8.0),
        flip_mean: flip.iter().sum::<f64>() / count,
        flip_p99: percentile(&flip, 0.99).unwrap_or(0.0),
    };
    Ok(Some(ErrorMap { error, steps, flip }))
}

/// The picture in another size: bilinear between the middles of pixels, in linear light, edges repeated.
pub fn resized(image: &LinearImage, size: [u32; 2]) -> LinearImage {
    let [width, height] = size;
    if (image.width, image.height) == (width, height) || image.pixels.is_empty() {
        return image.clone();
    }
    // Position in the old picture, as two neighbours and the weight of the second.
    let place = |i: u32, new: u32, old: u32| {
        let at = ((f64::from(i) + 0.5) * f64::from(old) / f64::from(new) - 0.5).clamp(0.0, f64::from(old - 1));
        let low = at.floor() as u32;
        (low, (low + 1).min(old - 1), (at - at.floor()) as f32)
    };
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        let (top, bottom, v) = place(y, height, image.height);
        for x in 0..width {
            let (left, right, u) = place(x, width, image.width);
            let at = |x: u32, y: u32| image.pixels[y as usize * image.width as usize + x as usize];
            let corners = [at(left, top), at(right, top), at(left, bottom), at(right, bottom)];
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            pixels.push(std::array::from_fn(|c| corners.iter().zip(weights).map(|(p, w)| w * p[c]).sum()));
        }
    }
    LinearImage { width, height, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, srgb: f64) -> LinearImage {
        let v = linear_from_srgb(srgb) as f32;
        LinearImage { width, height, pixels: vec![[v, v, v, 1.0]; (width * height) as usize] }
    }

    fn with_steps(image: &LinearImage, pixels: usize, steps: f64) -> LinearImage {
        let mut planted = image.clone();
        for pixel in &mut planted.pixels[..pixels] {
            for channel in &mut pixel[..3] {
                let encoded = srgb_from_linear(f64::from(*channel)) + steps / STEPS;
                *channel = linear_from_srgb(encoded) as f32;
            }
        }
        planted
    }

    #[test]
    fn planted_errors_are_measured_as_large_as_they_are() {
        let reference = grey(20, 10, 0.4);
        for (pixels, steps, above_1, above_8) in
            [(50, 12.0, 0.25, 0.25), (100, 3.0, 0.5, 0.0), (200, 0.25, 0.0, 0.0), (1, 140.0, 0.005, 0.005)]
        {
            let error = compare(&with_steps(&reference, pixels, steps), &reference, None).unwrap().error;
            // Single precision of the pictures: a few millionths of a step.
            assert!((error.maximum - steps).abs() < 1e-3, "{error:?}");
            assert!((error.mean - steps * pixels as f64 / 200.0).abs() < 1e-3, "{error:?}");
            assert_eq!((error.above_1, error.above_8), (above_1, above_8));
            assert!(error.flip_p99 >= error.flip_mean - 1e-12 || pixels == 1, "{error:?}");
        }
    }

    #[test]
    fn one_channel_is_a_third_of_the_mean() {
        let reference = grey(4, 4, 0.5);
        let mut planted = reference.clone();
        planted.pixels.iter_mut().for_each(|p| p[1] = linear_from_srgb(0.5 + 6.0 / STEPS) as f32);
        let error = compare(&planted, &reference, None).unwrap().error;
        assert!((error.maximum - 6.0).abs() < 1e-3 && (error.mean - 2.0).abs() < 1e-3, "{error:?}");
    }

    #[test]
    fn equal_pictures_have_exactly_no_error() {
        let image = with_steps(&grey(16, 16, 0.3), 77, 31.0);
        let map = compare(&image, &image, None).unwrap();
        assert_eq!(map.error, ImageError::default());
        assert!(map.steps.iter().chain(&map.flip).all(|v| *v == 0.0));
    }

    #[test]
    fn coverage_shows_over_the_background() {
        let clear = LinearImage { width: 2, height: 1, pixels: vec![[0.0; 4]; 2] };
        let black = LinearImage { pixels: vec![[0.0, 0.0, 0.0, 1.0]; 2], ..clear.clone() };
        assert_eq!(compare(&clear, &black, Some([0.0; 3])).unwrap().error.maximum, 0.0);
        let over_grey = compare(&clear, &black, None).unwrap().error.maximum;
        assert!((over_grey - 127.5).abs() < 1e-3, "{over_grey}");
        let error = compare(&clear, &grey(1, 2, 0.0), None).unwrap_err();
        assert_eq!((error.found, error.expected), ([2, 1], [1, 2]));
    }

    #[test]
    fn resizing_keeps_even_pictures_and_places_edges() {
        let even = resized(&grey(5, 3, 0.6), [20, 9]);
        assert_eq!((even.width, even.height, even.pixels.len()), (20, 9, 180));
        assert!(even.pixels.iter().all(|p| (p[0] - even.pixels[0][0]).abs() < 1e-6));
        let ramp = LinearImage { width: 2, height: 1, pixels: vec![[0.0; 4], [1.0; 4]] };
        let wide: Vec<f32> = resized(&ramp, [4, 1]).pixels.iter().map(|p| p[0]).collect();
        assert_eq!(wide, [0.0, 0.25, 0.75, 1.0]);
    }
}
