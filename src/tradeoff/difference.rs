//! False colours for differences: how far a pixel is from the reference, in steps of 1/255.
//!
//! From black over violet and orange to pale yellow. Lightness rises from each stop to the next by about as much, for every kind
//! of colour vision, so what is lighter is more wrong. The stops double, because one step and two are to be told apart as well
//! as thirty and sixty.

use super::image_error::ErrorMap;

/// Differences in steps of 1/255, and the colours (sRGB) that they have.
pub const STOPS: [(f64, [u8; 3]); 8] = [
    (0.0, [0, 0, 0]),
    (1.0, [38, 30, 92]),
    (2.0, [76, 34, 136]),
    (4.0, [144, 52, 140]),
    (8.0, [206, 72, 98]),
    (16.0, [240, 120, 54]),
    (32.0, [250, 178, 60]),
    (64.0, [252, 240, 164]),
];

/// The colour of a difference: between two stops by the logarithm, below one step in proportion.
pub fn color(steps: f64) -> [u8; 3] {
    between_stops(if steps < 1.0 { steps.max(0.0) } else { 1.0 + steps.log2() })
}

/// The colour of a share from 0 to 1, as FLIP is: evenly along the same stops.
pub fn color_of_share(share: f64) -> [u8; 3] {
    between_stops(share.max(0.0) * (STOPS.len() - 1) as f64)
}

/// The colour at a place along the stops, of which the first is at 0 and the next at 1.
fn between_stops(at: f64) -> [u8; 3] {
    let last = STOPS.len() - 1;
    let at = at.min(last as f64);
    let low = (at as usize).min(last - 1);
    let t = at - low as f64;
    std::array::from_fn(|c| {
        let [a, b] = [STOPS[low].1[c], STOPS[low + 1].1[c]].map(f64::from);
        (a + t * (b - a)).round() as u8
    })
}

/// Every pixel in its colour: 8-bit sRGB, opaque.
pub fn rgba(map: &ErrorMap) -> Vec<u8> {
    let opaque = |steps: &f64| {
        let [r, g, b] = color(*steps);
        [r, g, b, 255]
    };
    map.steps.iter().flat_map(opaque).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LinearImage;
    use crate::math::color::linear_from_srgb;
    use crate::tradeoff::image_error::compare;

    #[test]
    fn known_differences_have_the_colours_of_their_stops() {
        let pixel = |v: f64| [linear_from_srgb(v / 255.0) as f32, 0.1, 0.1, 1.0];
        let reference = LinearImage { width: 5, height: 1, pixels: vec![pixel(100.0); 5] };
        let pixels = [100.0, 101.0, 92.0, 132.0, 250.0].map(pixel).to_vec();
        let map = compare(&LinearImage { pixels, ..reference.clone() }, &reference, None).unwrap();
        let bytes = rgba(&map);
        let found: Vec<&[u8]> = bytes.chunks(4).collect();
        let expected: [[u8; 4]; 5] =
            [[0, 0, 0, 255], [38, 30, 92, 255], [206, 72, 98, 255], [250, 178, 60, 255], [252, 240, 164, 255]];
        for (found, expected) in found.iter().zip(expected) {
            // Single precision of the pictures.
            assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{found:?} {expected:?}");
        }
        assert_eq!(color(0.5), [19, 15, 46], "half of one step: half of its colour");
        assert_eq!(color(2.0 * 2f64.sqrt()), [110, 43, 138], "half-way by the logarithm");
        assert_eq!((color_of_share(0.0), color_of_share(1.0)), (STOPS[0].1, STOPS[7].1));
        assert_eq!((color_of_share(2.0 / 7.0), color_of_share(f64::NAN)), (STOPS[2].1, [0; 3]));
        assert_eq!((color(-1.0), color(f64::NAN), color(1e9)), ([0; 3], STOPS[7].1, STOPS[7].1));
    }

    /// Lightness as CIE L*, seen with all cones or without one kind of them (Machado et al. 2009, in linear sRGB).
    #[test]
    fn lightness_rises_under_every_kind_of_colour_vision() {
        const ALL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        const NO_LONG: [[f64; 3]; 3] =
            [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]];
        const NO_MIDDLE: [[f64; 3]; 3] =
            [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]];
        const NO_SHORT: [[f64; 3]; 3] =
            [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]];
        for eye in [ALL, NO_LONG, NO_MIDDLE, NO_SHORT] {
            let lightness = |rgb: [u8; 3]| {
                let linear = rgb.map(|v| linear_from_srgb(f64::from(v) / 255.0));
                let seen = eye.map(|row| (0..3).map(|c| row[c] * linear[c]).sum::<f64>().clamp(0.0, 1.0));
                let y = 0.2126 * seen[0] + 0.7152 * seen[1] + 0.0722 * seen[2];
                if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
            };
            let all: Vec<f64> = STOPS.iter().map(|s| lightness(s.1)).collect();
            assert!(all.windows(2).all(|w| (5.0..20.0).contains(&(w[1] - w[0]))), "{all:?}");
            let fine: Vec<f64> = (0..=640).map(|i| lightness(color(f64::from(i) / 10.0))).collect();
            assert!(fine.windows(2).all(|w| w[1] > w[0] - 0.5), "no way back between stops");
        }
    }
}
