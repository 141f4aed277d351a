//! Small pictures for the report, as data URIs: the picture, its difference to the reference, and where its error lies.

use std::io::Cursor;

use base64::Engine;
use image::{ExtendedColorType, ImageEncoder};

use super::image_error::{ErrorMap, displayed};
use crate::math::LinearImage;

/// By how much differences are enlarged, so that one 8-bit step can be seen.
pub const DIFFERENCE_GAIN: f64 = 16.0;

/// The three pictures of a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Thumbnails {
    /// The picture.
    pub picture: String,
    /// Its difference to the reference by channel, [`DIFFERENCE_GAIN`] times as large.
    pub difference: String,
    /// FLIP, from black (none) over violet and orange to pale yellow (1).
    pub heat: String,
}

impl Thumbnails {
    /// Makes them, no longer than `side` pixels a side. `image` and `reference` are equal in size.
    pub fn new(
        image: &LinearImage,
        reference: &LinearImage,
        map: &ErrorMap,
        background: Option<[f32; 3]>,
        side: u32,
    ) -> Thumbnails {
        let (a, b) = (displayed(image, background), displayed(reference, background));
        let size = [image.width, image.height];
        let differences: Vec<[f64; 3]> =
            a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|c| DIFFERENCE_GAIN * (a[c] - b[c]).abs())).collect();
        // The largest of what falls together, so that single pixels are not lost.
        let largest = |all: &[[f64; 3]]| std::array::from_fn(|c| all.iter().map(|p| p[c]).fold(0.0, f64::max));
        let heat: Vec<[f64; 3]> = map.flip.iter().map(|v| [*v; 3]).collect();
        let (heat, heat_size) = reduced(&heat, size, side, largest);
        let (difference, difference_size) = reduced(&differences, size, side, largest);
        Thumbnails {
            picture: picture(image, background, side),
            difference: data_uri(&difference, difference_size),
            heat: data_uri(&heat.iter().map(|v| heat_color(v[0])).collect::<Vec<_>>(), heat_size),
        }
    }
}

/// A picture over its background.
pub fn picture(image: &LinearImage, background: Option<[f32; 3]>, side: u32) -> String {
    let mean = |all: &[[f64; 3]]| {
        let n = all.len().max(1) as f64;
        std::array::from_fn(|c| all.iter().map(|p| p[c]).sum::<f64>() / n)
    };
    let (pixels, size) = reduced(&displayed(image, background), [image.width, image.height], side, mean);
    data_uri(&pixels, size)
}

/// A smaller picture of which each pixel is made of those that fall into it.
fn reduced(
    pixels: &[[f64; 3]],
    [width, height]: [u32; 2],
    side: u32,
    fold: impl Fn(&[[f64; 3]]) -> [f64; 3],
) -> (Vec<[f64; 3]>, [u32; 2]) {
    let longest = width.max(height);
    if longest <= side || longest == 0 {
        return (pixels.to_vec(), [width, height]);
    }
    let scaled = |v: u32| ((u64::from(v) * u64::from(side) / u64::from(longest)) as u32).max(1);
    let [w, h] = [scaled(width), scaled(height)];
    let span = |i: u32, new: u32, old: u32| {
        let at = |i: u32| (u64::from(i) * u64::from(old) / u64::from(new)) as usize;
        at(i)..at(i + 1).max(at(i) + 1)
    };
    let mut out = Vec::with_capacity((w * h) as usize);
    let mut inside = Vec::new();
    for y in 0..h {
        for x in 0..w {
            inside.clear();
            for row in span(y, h, height) {
                let columns = span(x, w, width);
                let first = row * width as usize;
                inside.extend_from_slice(&pixels[first + columns.start..first + columns.end]);
            }
            out.push(fold(&inside));
        }
    }
    (out, [w, h])
}

/// From black (0) over violet and orange to pale yellow (1), with rising lightness throughout.
pub fn heat_color(value: f64) -> [f64; 3] {
    const STOPS: [[f64; 3]; 6] = [
        [0.0, 0.0, 0.02],
        [0.20, 0.07, 0.38],
        [0.52, 0.14, 0.48],
        [0.87, 0.29, 0.34],
        [0.99, 0.60, 0.24],
        [0.99, 0.98, 0.80],
    ];
    // The square root: errors of a few hundredths are what is looked for.
    let at = value.clamp(0.0, 1.0).sqrt() * (STOPS.len() - 1) as f64;
    let low = (at as usize).min(STOPS.len() - 2);
    let t = at - low as f64;
    std::array::from_fn(|c| STOPS[low][c] + t * (STOPS[low + 1][c] - STOPS[low][c]))
}

/// An 8-bit PNG as a data URI; empty for a picture without pixels.
fn data_uri(pixels: &[[f64; 3]], [width, height]: [u32; 2]) -> String {
    let bytes: Vec<u8> = pixels.iter().flatten().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(Cursor::new(&mut png));
    match encoder.write_image(&bytes, width, height, ExtendedColorType::Rgb8) {
        Ok(()) => format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(&png)),
        Err(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(uri: &str) -> image::RgbImage {
        let text = uri.strip_prefix("data:image/png;base64,").unwrap();
        let png = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
        image::load_from_memory(&png).unwrap().into_rgb8()
    }

    #[test]
    fn a_single_wrong_pixel_is_seen_in_the_small_pictures() {
        let reference = LinearImage { width: 100, height: 50, pixels: vec![[0.2, 0.2, 0.2, 1.0]; 5000] };
        let mut image = reference.clone();
        image.pixels[2550] = [1.0; 4];
        let map = crate::tradeoff::image_error::compare(&image, &reference, None).unwrap();
        let small = Thumbnails::new(&image, &reference, &map, None, 20);
        let [picture, difference, heat] = [&small.picture, &small.difference, &small.heat].map(|u| decode(u));
        assert_eq!([picture.dimensions(), difference.dimensions(), heat.dimensions()], [(20, 10); 3]);
        assert_eq!(difference.get_pixel(10, 5).0, [255; 3]);
        assert_eq!(difference.get_pixel(0, 0).0, [0; 3]);
        assert!(heat.get_pixel(10, 5).0[0] > 120 && heat.get_pixel(0, 9).0[0] < 5);
        assert_eq!(decode(&super::picture(&reference, None, 200)).dimensions(), (100, 50), "never enlarged");
    }

    #[test]
    fn heat_rises_in_lightness() {
        let lightness = |v: f64| heat_color(v).iter().zip([0.21, 0.72, 0.07]).map(|(c, w)| c * w).sum::<f64>();
        assert!((1..=50).all(|i| lightness(f64::from(i) / 50.0) > lightness(f64::from(i - 1) / 50.0)));
    }
}
