//! Opacity by the models that illustrative transparency is compared with (Carnecky 2013): adaptive (equation 5), by angle
//! (Hummel 2010), by normal variation (Born 2010); and equal shares for all layer indices.
//!
//! # Choices
//! - An angle counts from 0 (facing the viewer) to 90 degrees.
//! - The normal's turn is that between the neighbours on both sides, over two pixels, or to the one that is there; none where
//!   neither is. It is taken over the image's shorter side, so that it does not depend on the resolution.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};

use super::illustration::adjacency;
use super::neighbours::Link;
use super::store::StoreData;
use super::view::View;
use crate::settings::{OpacityModel, OpacitySettings};

/// The opacity that the model gives each fragment, without the material's own; 1 for models of other modules.
pub fn opacities(store: &StoreData, links: &[[Link; 4]], view: &View, settings: &OpacitySettings) -> Vec<f64> {
    match settings.base_model() {
        OpacityModel::Adaptive => {
            let counts = store.pixel_of_fragment();
            counts.into_iter().map(|p| adaptive(settings.adaptive, store.counts[p])).collect()
        }
        OpacityModel::AngleBased => {
            let s = &settings.angle;
            let pixels = store.pixel_of_fragment();
            let of = |(i, &p): (usize, &usize)| {
                let (x, y) = store.xy(p);
                let eye = view.to_eye(view.position(x, y, store.depth[i])).normalize();
                let cosine = normal(store, i).dot(eye).abs().min(1.0);
                s.low + (s.high - s.low) * cosine.acos() / FRAC_PI_2
            };
            pixels.iter().enumerate().map(of).collect()
        }
        OpacityModel::NormalVariation => {
            let s = &settings.variation;
            let side = f64::from(store.width.min(store.height));
            let of = |(i, around): (usize, &[Option<usize>; 4])| {
                let turn = |ahead: Option<usize>, behind: Option<usize>| {
                    let steps = usize::from(ahead.is_some()) + usize::from(behind.is_some());
                    let ends = [ahead, behind].map(|f| normal(store, f.unwrap_or(i)));
                    (ends[0] - ends[1]) / steps.max(1) as f64
                };
                let (u, v) = (turn(around[0], around[1]), turn(around[2], around[3]));
                let variation = 1.0 - (-s.scale * side * (u.length_squared() + v.length_squared()).sqrt()).exp();
                s.low + (s.high - s.low) * variation
            };
            adjacency(store, links).iter().enumerate().map(of).collect()
        }
        OpacityModel::EqualShare => {
            let s = &settings.equal_share;
            let table = equal_shares(&store.counts, s.share, s.least);
            let pixels = store.pixel_of_fragment();
            pixels.iter().enumerate().map(|(i, &p)| table[(i - store.offsets[p]).min(table.len() - 1)]).collect()
        }
        _ => vec![1.0; store.len()],
    }
}

/// Opacity for each layer index, from the number of layers of every pixel, so that each index is seen as much as any other and
/// all together cover `share` where there are all of them. Indices that less than `least` of the covered pixels have are as
/// opaque as the last that more have; 255 indices are told apart.
pub fn equal_shares(counts: &[u32], share: f64, least: f64) -> Vec<f64> {
    let pixels = |index: u32| counts.iter().filter(|&&c| c > index).count() as f64;
    let first = pixels(0);
    let numbers: Vec<f64> = (0..255).map(pixels).take_while(|&n| n > 0.0 && n >= least * first).collect();
    let seen = share / numbers.iter().map(|n| 1.0 / n).sum::<f64>();
    let mut passed = 1.0;
    let mut table: Vec<f64> = numbers
        .iter()
        .map(|n| {
            let opacity = (seen / n / passed).clamp(0.0, 1.0);
            passed -= seen / n;
            opacity
        })
        .collect();
    table.resize(255, table.last().copied().unwrap_or(0.0));
    table
}

fn normal(store: &StoreData, i: usize) -> DVec3 {
    Vec3::from(store.normal[i]).as_dvec3()
}

/// Equation 5: the opacity with which `layers` together have the opacity `share`.
pub fn adaptive(share: f64, layers: u32) -> f64 {
    1.0 - (1.0 - share).powf(1.0 / f64::from(layers.max(1)))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn adaptive_layers_together_are_as_opaque_everywhere() {
        for n in [1, 2, 7, 100] {
            let alpha = adaptive(0.7, n);
            let sum: f64 = (0..n).map(|i| (1.0 - alpha).powi(i as i32) * alpha).sum();
            assert!((sum - 0.7).abs() < 1e-12, "equation 6, {n} layers");
        }
        assert_eq!((adaptive(0.0, 3), adaptive(1.0, 3)), (0.0, 1.0));
    }

    #[test]
    fn every_layer_index_is_seen_as_much_as_any_other() {
        // Two pixels of one and two layers: 0.3 of each, then the 0.7 that are left of one.
        let table = equal_shares(&[1, 2], 0.9, 0.0);
        assert!((table[0] - 0.3).abs() < 1e-12 && (table[1] - 0.6 / 0.7).abs() < 1e-12);
        let counts: Vec<u32> = (0..1000).map(|i| (i * 7919) % 13).collect();
        let table = equal_shares(&counts, 0.8, 0.0);
        let mut seen = [0.0; 12];
        for &count in &counts {
            let mut passed = 1.0;
            for i in 0..count as usize {
                seen[i] += passed * table[i];
                passed *= 1.0 - table[i];
            }
            assert!(passed >= 0.2 - 1e-12);
        }
        assert!(seen.iter().all(|s| (s - seen[0]).abs() < 1e-9), "{seen:?}");
        // A single deep pixel does not take the picture for itself.
        let mut counts = vec![2; 99];
        counts.push(40);
        let table = equal_shares(&counts, 0.9, 0.1);
        assert!((table[0] - 0.45).abs() < 1e-12 && table[39] == table[1]);
        assert_eq!(equal_shares(&[], 0.9, 0.1), vec![0.0; 255]);
    }

    #[test]
    fn angle_and_variation_by_hand() {
        let tilted = [0.6, 0.0, 0.8];
        let store = StoreData {
            width: 3,
            height: 2,
            counts: vec![1, 1, 1, 0, 0, 0],
            overflowed: vec![false; 6],
            offsets: vec![0, 1, 2, 3, 3, 3],
            depth: vec![1.0; 3],
            normal: vec![[0.0, 0.0, 1.0], tilted, tilted],
            ..StoreData::default()
        };
        let view =
            View { width: 3, height: 2, perspective: false, half_extent: DVec2::new(1.5, 1.0), shift: DVec2::ZERO };
        let end = Link::Missing;
        let links = [[Link::To(0), end, end, end], [Link::To(0), Link::To(0), end, end], [end, Link::To(0), end, end]];
        let mut s = OpacitySettings { model: OpacityModel::AngleBased, ..OpacitySettings::default() };
        let found = opacities(&store, &links, &view, &s);
        assert!((found[0] - 0.1).abs() < 1e-12);
        assert!((found[1] - (0.1 + 0.8 * 0.8_f64.acos() / FRAC_PI_2)).abs() < 1e-7);
        s.model = OpacityModel::NormalVariation;
        s.variation.scale = 0.5;
        let found = opacities(&store, &links, &view, &s);
        // The chord between the two normals is √0.4; two pixels are the shorter side.
        let variation = |turn: f64| 0.1 + 0.85 * (1.0 - (-0.5 * 2.0 * turn).exp());
        for (found, turn) in found.into_iter().zip([0.4_f64.sqrt(), 0.4_f64.sqrt() / 2.0, 0.0]) {
            assert!((found - variation(turn)).abs() < 1e-7);
        }
    }
}
