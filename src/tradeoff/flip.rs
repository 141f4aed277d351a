//! FLIP, how different two pictures look when one flips to the other: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström,
//! Fairchild, *FLIP: A Difference Evaluator for Alternating Images*, 2020; for pictures of ordinary range.
//!
//! Written here after the paper: the reference implementation takes 8-bit pictures, whose rounding would hide small errors,
//! and would ask for a C++ compiler where Rust alone is enough.
//!
//! Colour: both pictures are blurred by the eye's contrast sensitivity in a linear opponent space, clamped to what a display
//! shows, and compared in CIELAB (Hunt-adjusted) by the HyAB distance. Features: edges and points of the unblurred
//! lightness. The value of a pixel is colour^(1 − feature), 0 for equal and 1 for the farthest. Borders repeat their pixels.

use rayon::prelude::*;

use crate::math::color::linear_from_srgb;

/// Pixels in a degree of the visual field: 0.7 m from a display 0.7 m wide with 3840 pixels, as in the paper.
const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

const QC: f64 = 0.7;
const PC: f64 = 0.4;
const PT: f64 = 0.95;
const QF: f64 = 0.5;
/// Width of the feature filters, degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// XYZ of linear Rec. 709 white.
const WHITE: [f64; 3] = [0.950_428_545_377_180_9, 1.0, 1.088_900_370_798_127_7];

/// Contrast sensitivity as sums of Gaussians: (weight, width) for the achromatic, red-green and blue-yellow channels.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// The widest of them, which sets the radius of all.
const WIDEST: f64 = 0.04;

type Plane = Vec<f64>;

fn xyz(rgb: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = rgb;
    [
        (10_135_552.0 * r + 8_788_810.0 * g + 4_435_075.0 * b) / 24_577_794.0,
        (2_613_072.0 * r + 8_788_810.0 * g + 887_015.0 * b) / 12_288_897.0,
        (1_425_312.0 * r + 8_788_810.0 * g + 70_074_185.0 * b) / 73_733_382.0,
    ]
}

fn linear_rgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.241_003_275 * x - 1.537_398_934 * y - 0.498_615_861 * z,
        -0.969_224_334 * x + 1.875_930_071 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_202 * y + 1.057_148_933 * z,
    ]
}

/// Linear opponent space: Y, Cx, Cz.
fn opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = xyz(rgb);
    let (x, y, z) = (x / WHITE[0], y / WHITE[1], z / WHITE[2]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_of_opponent([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    linear_rgb([(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]])
}

/// CIELAB with the Hunt adjustment: chroma in proportion to lightness.
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = xyz(rgb);
    let (x, y, z) = (f(x / WHITE[0]), f(y / WHITE[1]), f(z / WHITE[2]));
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// The largest compressed distance: green against blue.
fn largest_distance() -> f64 {
    hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC)
}

/// Spreads the compressed distance over [0, 1].
fn color_difference(a: [f64; 3], b: [f64; 3], largest: f64) -> f64 {
    let distance = hyab(a, b).powf(QC);
    let knee = PC * largest;
    if distance < knee { PT / knee * distance } else { PT + (distance - knee) / (largest - knee) * (1.0 - PT) }
}

/// Whether the result is still wanted. What is begun when it no longer is comes out wrong and soon, and is thrown away.
pub type Wanted<'a> = &'a (dyn Fn() -> bool + Sync);

/// Convolves with a kernel along rows and another along columns.
fn convolve(plane: &[f64], width: usize, along_x: &[f64], along_y: &[f64], wanted: Wanted<'_>) -> Plane {
    let height = plane.len() / width;
    let at = |i: usize, offset: usize, radius: usize, end: usize| (i + offset).saturating_sub(radius).min(end - 1);
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width).zip(plane.par_chunks(width)).filter(|_| wanted()).for_each(|(to, from)| {
        for (x, to) in to.iter_mut().enumerate() {
            let radius = along_x.len() / 2;
            *to = along_x.iter().enumerate().map(|(k, w)| w * from[at(x, k, radius, width)]).sum();
        }
    });
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).enumerate().filter(|_| wanted()).for_each(|(y, to)| {
        for (k, w) in along_y.iter().enumerate() {
            let row = at(y, k, along_y.len() / 2, height) * width;
            to.iter_mut().zip(&rows[row..row + width]).for_each(|(to, v)| *to += w * v);
        }
    });
    out
}

fn kernel(radius: i32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|i| value(f64::from(i))).collect()
}

/// The picture as the eye resolves it, one channel.
fn blur(plane: &[f64], width: usize, channel: usize, wanted: Wanted<'_>) -> Plane {
    use std::f64::consts::PI;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussians: Vec<(f64, Vec<f64>)> = SENSITIVITY[channel]
        .iter()
        .map(|&(a, b)| {
            let scale = PI * PI / (b * PIXELS_PER_DEGREE * PIXELS_PER_DEGREE);
            (a * (PI / b).sqrt(), kernel(radius, |x| (-scale * x * x).exp()))
        })
        .collect();
    let total: f64 = gaussians.iter().map(|(weight, g)| weight * g.iter().sum::<f64>().powi(2)).sum();
    let mut sum = vec![0.0; plane.len()];
    for (weight, g) in &gaussians {
        let blurred = convolve(plane, width, g, g, wanted);
        sum.iter_mut().zip(&blurred).for_each(|(s, v)| *s += weight / total * v);
    }
    sum
}

/// Positive weights are made to sum to 1, negative ones to −1, over the product with `other`.
fn balanced(mut kernel: Vec<f64>, other: &[f64]) -> Vec<f64> {
    let across: f64 = other.iter().sum();
    let positive: f64 = kernel.iter().filter(|v| **v > 0.0).sum::<f64>() * across;
    let negative: f64 = -kernel.iter().filter(|v| **v < 0.0).sum::<f64>() * across;
    kernel.iter_mut().for_each(|v| *v /= if *v < 0.0 { negative } else { positive });
    kernel
}

/// Strength of edges and of points.
fn features(lightness: &[f64], width: usize, wanted: Wanted<'_>) -> [Plane; 2] {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let gauss = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let across = kernel(radius, gauss);
    let edge = balanced(kernel(radius, |x| -x * gauss(x)), &across);
    let point = balanced(kernel(radius, |x| (x * x / (deviation * deviation) - 1.0) * gauss(x)), &across);
    [edge, point].map(|along| {
        let x = convolve(lightness, width, &along, &across, wanted);
        let y = convolve(lightness, width, &across, &along, wanted);
        x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
    })
}

/// What is compared of one picture.
struct Seen {
    lab: Vec<[f64; 3]>,
    features: [Plane; 2],
}

fn seen(shown: &[[f64; 3]], width: usize, wanted: Wanted<'_>) -> Option<Seen> {
    let opponents: Vec<[f64; 3]> = shown.par_iter().map(|p| opponent(p.map(linear_from_srgb))).collect();
    let channel = |c: usize| opponents.iter().map(|p| p[c]).collect::<Plane>();
    let lightness: Plane = opponents.iter().map(|p| (p[0] + 16.0) / 116.0).collect();
    let [y, cx, cz] = [0, 1, 2].map(|c| blur(&channel(c), width, c, wanted));
    let features = features(&lightness, width, wanted);
    let lab = |i: usize| hunt_lab(rgb_of_opponent([y[i], cx[i], cz[i]]).map(|v| v.clamp(0.0, 1.0)));
    wanted().then(|| Seen { lab: (0..shown.len()).into_par_iter().map(lab).collect(), features })
}

/// FLIP of every pixel, 0 to 1, of two pictures as displayed: sRGB values from 0 to 1, rows of `width`, equal in size. It is
/// given up soon after `wanted` says no; `None` then.
pub fn flip_while(a: &[[f64; 3]], b: &[[f64; 3]], width: usize, wanted: Wanted<'_>) -> Option<Vec<f64>> {
    if a == b || width == 0 {
        return Some(vec![0.0; a.len()]);
    }
    let (a, b) = (seen(a, width, wanted)?, seen(b, width, wanted)?);
    let largest = largest_distance();
    let of_pixel = |i: usize| {
        let color = color_difference(a.lab[i], b.lab[i], largest);
        let of = |f: usize| (a.features[f][i] - b.features[f][i]).abs();
        let feature = (std::f64::consts::FRAC_1_SQRT_2 * of(0).max(of(1))).powf(QF);
        color.powf(1.0 - feature.min(1.0))
    };
    Some((0..a.lab.len().min(b.lab.len())).into_par_iter().map(of_pixel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flip(a: &[[f64; 3]], b: &[[f64; 3]], width: usize) -> Vec<f64> {
        flip_while(a, b, width, &|| true).unwrap()
    }

    fn mean(v: &[f64]) -> f64 {
        v.iter().sum::<f64>() / v.len() as f64
    }

    fn uniform(v: [f64; 3]) -> Vec<[f64; 3]> {
        vec![v; 24 * 20]
    }

    #[test]
    fn equal_pictures_have_none_and_the_order_does_not_matter() {
        let a: Vec<[f64; 3]> = (0..480).map(|i| [f64::from(i % 7) / 7.0, f64::from(i % 5) / 5.0, 0.3]).collect();
        let b: Vec<[f64; 3]> = a.iter().map(|p| [p[1], p[0], p[2]]).collect();
        assert!(flip(&a, &a, 24).iter().all(|v| *v == 0.0));
        let (there, back) = (flip(&a, &b, 24), flip(&b, &a, 24));
        assert!(there.iter().zip(&back).all(|(x, y)| (x - y).abs() < 1e-12));
        assert!(there.iter().all(|v| (0.0..=1.0).contains(v)) && mean(&there) > 0.1);
    }

    /// Even pictures have no features, and blurring leaves them alone. Black to white: L* = 100, so HyAB = 100, compressed
    /// 100^0.7 = 25.12. Green (L* 87.73, a* −86.18, b* 83.18) to blue (32.30, 79.19, −107.86), Hunt-adjusted by L*/100:
    /// 55.4 + |(101.2, 107.8)| = 203.3, compressed 41.3, knee at 0.4 of it, 16.5. 0.95 + 0.05 (25.12 − 16.5) / (41.3 − 16.5) =
    /// 0.967.
    #[test]
    fn black_to_white_is_near_one_as_calculated_by_hand() {
        let values = flip(&uniform([0.0; 3]), &uniform([1.0; 3]), 24);
        assert!(values.iter().all(|v| (v - 0.967).abs() < 1e-3), "{}", values[0]);
        // The farthest pair reaches exactly 1.
        let values = flip(&uniform([0.0, 1.0, 0.0]), &uniform([0.0, 0.0, 1.0]), 24);
        assert!(values.iter().all(|v| (v - 1.0).abs() < 1e-6), "{}", values[0]);
    }

    /// Below the knee: grey from L* = 53.39 (sRGB 0.5) to 54.39 has HyAB 1, so FLIP = 0.95 / 16.51.
    #[test]
    fn one_step_of_lightness_is_as_calculated_by_hand() {
        let srgb_of = |l: f64| crate::math::color::srgb_from_linear(((l + 16.0) / 116.0).powi(3));
        let values = flip(&uniform([srgb_of(53.39); 3]), &uniform([srgb_of(54.39); 3]), 24);
        assert!(values.iter().all(|v| (v - 0.95 / 16.51).abs() < 1e-3), "{}", values[0]);
    }

    #[test]
    fn it_is_given_up_when_it_is_no_longer_wanted() {
        use std::sync::atomic::{AtomicU32, Ordering};
        use std::time::Instant;
        let (width, height) = (400, 300);
        let a: Vec<[f64; 3]> = (0..width * height).map(|i| [(i % 251) as f64 / 251.0, 0.4, 0.1]).collect();
        let b: Vec<[f64; 3]> = a.iter().map(|p| [p[1], p[0], p[2]]).collect();
        assert_eq!(flip_while(&a, &b, width, &|| false), None);
        // In the midst of the first rows, and it is asked for no more than every row of what is left.
        let begin = Instant::now();
        let whole = (flip(&a, &b, width), begin.elapsed()).1;
        let asked = AtomicU32::new(0);
        let begin = Instant::now();
        assert_eq!(flip_while(&a, &b, width, &|| asked.fetch_add(1, Ordering::Relaxed) < 20), None);
        assert!(begin.elapsed() < whole / 2, "{:?} of {whole:?}", begin.elapsed());
    }

    #[test]
    fn more_difference_is_more_error() {
        let mut before = 0.0;
        for step in 1..=20 {
            let value = mean(&flip(&uniform([0.2; 3]), &uniform([0.2 + 0.04 * f64::from(step); 3]), 24));
            assert!(value > before, "step {step}: {value} after {before}");
            before = value;
        }
    }

    /// Against NVIDIA's implementation (the crate nv-flip 0.1.2), which takes bytes: gradients, a chequer, noise, a brighter side.
    #[test]
    fn the_values_are_those_of_the_reference_implementation() {
        let (width, height) = (96_usize, 80_usize);
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        };
        let a: Vec<[u8; 3]> = (0..width * height)
            .map(|i| (i % width, i / width))
            .map(|(x, y)| [(2 * x) as u8, (3 * y) as u8, ((x / 8 + y / 8) % 2 * 180) as u8])
            .collect();
        let mut b = a.clone();
        for (i, pixel) in b.iter_mut().enumerate() {
            for v in pixel {
                if i % 97 == 0 {
                    *v = noise();
                } else if i % width > 60 {
                    *v = v.saturating_add(20);
                }
            }
        }
        let shown = |p: &[[u8; 3]]| p.iter().map(|p| p.map(|v| f64::from(v) / 255.0)).collect::<Vec<_>>();
        let values = flip(&shown(&a), &shown(&b), width);
        println!("mean {:.6}", mean(&values));
        assert!((mean(&values) - 0.143_079).abs() < 2e-4, "{}", mean(&values));
        let theirs = [(0, 0, 0.904_41), (10, 10, 0.704_79), (61, 40, 0.290_00), (95, 79, 0.424_15), (48, 5, 0.0)];
        for (x, y, theirs) in theirs {
            let ours = values[y * width + x];
            println!("{x}, {y}: {ours:.5}, {theirs:.5}");
            assert!((ours - theirs).abs() < 1e-3, "{x}, {y}: {ours} and {theirs}");
        }
    }

    #[test]
    fn a_changed_pixel_counts_around_itself_only() {
        let a = vec![[0.5; 3]; 64 * 64];
        let mut b = a.clone();
        b[32 * 64 + 32] = [1.0; 3];
        let values = flip(&a, &b, 64);
        assert!(values[32 * 64 + 32] > 0.2 && values[32 * 64 + 32] >= values[32 * 64 + 36]);
        assert!(values[2 * 64 + 2] < 1e-6);
    }
}
