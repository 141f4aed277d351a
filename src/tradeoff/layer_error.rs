//! What became of the layers: a configuration's store against the reference's, pixel by pixel.
//!
//! # Which layer is which
//! Wide keys hold the triangle's number, and a triangle has at most one fragment in a pixel: layers with the same number are
//! the same layer ([`Identity::Triangle`]). Packed keys do not ([`Identity::PartAndDepth`]): there, the layers of a part in a
//! pixel, both stores' in order of depth, are aligned without crossing so that as many as possible are matched, and among those
//! alignments the sum of depth differences is least. Two layers of one part that changed places can therefore not be
//! seen; of two parts, they can.
//!
//! # Where the others went
//! A reference layer without a match is *lost* if its pixel was full and it lies behind the last stored layer, or if keys are
//! wide; it is *merged* otherwise: another fragment with an equal key, or one that is nearer only by quantized depth, took its
//! place. At the very last place of a full pixel the two can be taken for each other; their sum is exact. Layers that the
//! reference does not have are *extra*: always
//! 0 unless something is broken.

use std::collections::HashMap;

use serde::Serialize;

use super::statistics::percentile;
use crate::oracle::neighbours::Direction;
use crate::oracle::{Link, StoreData};
use crate::render::StoreReadback;

/// By what layers are known in the store that is judged. The reference's keys must be wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identity {
    /// The number of the triangle.
    Triangle,
    /// Part and place in the order of depth.
    PartAndDepth,
}

/// Errors of a store. Shares are 0 to 1; `None` where there is nothing to compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LayerError {
    /// Layers of the reference.
    pub layers: u64,
    /// Of those, how many are lost.
    pub lost: u64,
    /// How many became one with another.
    pub merged: u64,
    /// Layers that would have to be moved to put every pixel in the reference's order.
    pub out_of_order: u64,
    /// Layers that the reference does not have.
    pub extra: u64,
    /// Share of the links of matched layers that lead elsewhere, or nowhere, or are unknown, otherwise than the reference's.
    pub neighbours_different: Option<f64>,
    /// 95th percentile of the difference in κ of matched layers.
    pub kappa_p95: Option<f64>,
    /// 95th percentile of the difference in opacity of matched layers.
    pub opacity_p95: Option<f64>,
}

/// The stores cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stores of {found} and {expected} pixels cannot be compared")]
pub struct StoresDiffer {
    /// Pixels of the store.
    pub found: usize,
    /// Pixels of the reference.
    pub expected: usize,
}

/// Judges `store` by `reference`, both of the same view and size.
///
/// # Errors
/// [`StoresDiffer`] if they have not the same pixels.
pub fn layer_error(
    store: &StoreReadback,
    reference: &StoreReadback,
    identity: Identity,
) -> Result<LayerError, StoresDiffer> {
    let (s, r) = (&store.layers, &reference.layers);
    if s.counts.len() != r.counts.len() || (s.width, s.height) != (r.width, r.height) {
        return Err(StoresDiffer { found: s.counts.len(), expected: r.counts.len() });
    }
    let mut result = LayerError { layers: r.len() as u64, ..LayerError::default() };
    // For each layer of the reference, its match in the store.
    let mut matches: Vec<Option<usize>> = vec![None; r.len()];
    for pixel in 0..r.counts.len() {
        match identity {
            Identity::Triangle => match_triangles(s, r, pixel, &mut matches),
            Identity::PartAndDepth => match_parts(s, r, pixel, &mut matches),
        }
        tally_pixel(s, r, pixel, identity, &matches, &mut result);
    }
    let matched: Vec<(usize, usize)> = matches.iter().enumerate().filter_map(|(i, m)| Some((i, (*m)?))).collect();
    result.neighbours_different = neighbours_different(store, reference, &matches, &matched);
    result.kappa_p95 = p95(&matched, &store.kappa, &reference.kappa, |k| f64::from(*k));
    result.opacity_p95 = p95(&matched, &store.lit, &reference.lit, |c| f64::from(c[3]));
    Ok(result)
}

fn match_triangles(s: &StoreData, r: &StoreData, pixel: usize, matches: &mut [Option<usize>]) {
    let places: HashMap<u32, usize> = s.range(pixel).map(|i| (s.triangle[i], i)).collect();
    for i in r.range(pixel) {
        matches[i] = places.get(&r.triangle[i]).copied();
    }
}

fn match_parts(s: &StoreData, r: &StoreData, pixel: usize, matches: &mut [Option<usize>]) {
    let by_part = |data: &StoreData| {
        let mut lists: HashMap<u32, Vec<usize>> = HashMap::new();
        data.range(pixel).for_each(|i| lists.entry(data.part[i]).or_default().push(i));
        lists
    };
    let stored = by_part(s);
    for (part, expected) in by_part(r) {
        let Some(found) = stored.get(&part) else { continue };
        let depths = |data: &StoreData, list: &[usize]| list.iter().map(|&i| data.depth[i]).collect::<Vec<_>>();
        for (i, j) in align(&depths(r, &expected), &depths(s, found)) {
            matches[expected[i]] = Some(found[j]);
        }
    }
}

/// Pairs (index in `a`, index in `b`), without crossings, as many as the shorter list has, with the least sum of differences.
fn align(a: &[f64], b: &[f64]) -> Vec<(usize, usize)> {
    if a.len() < b.len() {
        return align(b, a).into_iter().map(|(i, j)| (j, i)).collect();
    }
    // best[j][i]: the first j of b matched within the first i of a.
    let (n, m) = (a.len(), b.len());
    let mut best = vec![vec![f64::INFINITY; n + 1]; m + 1];
    best[0].fill(0.0);
    for j in 1..=m {
        for i in j..=n {
            best[j][i] = best[j][i - 1].min(best[j - 1][i - 1] + (a[i - 1] - b[j - 1]).abs());
        }
    }
    let mut pairs = Vec::with_capacity(m);
    let (mut i, mut j) = (n, m);
    while j > 0 {
        // Every b must have a partner, so i never falls below j.
        if i > j && best[j][i] == best[j][i - 1] {
            i -= 1;
        } else {
            pairs.push((i - 1, j - 1));
            (i, j) = (i - 1, j - 1);
        }
    }
    pairs.reverse();
    pairs
}

/// Counts what became of the layers of a pixel.
fn tally_pixel(
    s: &StoreData,
    r: &StoreData,
    pixel: usize,
    identity: Identity,
    matches: &[Option<usize>],
    result: &mut LayerError,
) {
    // Ranks in the reference of the matched layers, in the order of the store.
    let mut ranks: Vec<(usize, usize)> = r.range(pixel).filter_map(|i| Some((matches[i]?, i))).collect();
    ranks.sort_unstable();
    result.extra += s.range(pixel).len().saturating_sub(ranks.len()) as u64;
    result.out_of_order += (ranks.len() - longest_ascent(ranks.iter().map(|(_, i)| *i))) as u64;
    let last = ranks.last().map(|(_, i)| *i);
    for i in r.range(pixel).filter(|&i| matches[i].is_none()) {
        let behind = s.overflowed[pixel] && last.is_none_or(|last| i > last);
        if identity == Identity::Triangle || behind {
            result.lost += 1;
        } else {
            result.merged += 1;
        }
    }
}

/// Length of the longest ascending subsequence.
fn longest_ascent(values: impl Iterator<Item = usize>) -> usize {
    // ends[n]: the least last value of an ascent of n + 1 values.
    let mut ends: Vec<usize> = Vec::new();
    for value in values {
        let place = ends.partition_point(|end| *end < value);
        match ends.get_mut(place) {
            Some(end) => *end = value,
            None => ends.push(value),
        }
    }
    ends.len()
}

fn neighbours_different(
    store: &StoreReadback,
    reference: &StoreReadback,
    matches: &[Option<usize>],
    matched: &[(usize, usize)],
) -> Option<f64> {
    let (s, r) = (&store.layers, &reference.layers);
    if store.links.len() != s.len() || reference.links.len() != r.len() || matched.is_empty() {
        return None;
    }
    let pixel_of = r.pixel_of_fragment();
    let (width, height) = (r.width.max(1) as usize, r.height as usize);
    let mut different = 0_u64;
    for &(i, j) in matched {
        for direction in Direction::ALL {
            let Some(q) = direction.step(pixel_of[i], width, height) else { continue };
            let d = direction as usize;
            let same = match (reference.links[i][d], store.links[j][d]) {
                (Link::To(a), Link::To(b)) => {
                    matches.get(r.offsets[q] + a as usize).copied().flatten() == Some(s.offsets[q] + b as usize)
                }
                (a, b) => a == b,
            };
            different += u64::from(!same);
        }
    }
    Some(different as f64 / (4 * matched.len()) as f64)
}

fn p95<T>(matched: &[(usize, usize)], found: &[T], expected: &[T], value: impl Fn(&T) -> f64) -> Option<f64> {
    let off: Option<Vec<f64>> =
        matched.iter().map(|&(i, j)| Some((value(found.get(j)?) - value(expected.get(i)?)).abs())).collect();
    percentile(&off?, 0.95)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A store of one row of pixels; a layer is (triangle, part, depth).
    fn store(pixels: &[&[(u32, u32, f64)]]) -> StoreReadback {
        let mut out = StoreReadback::default();
        let layers = &mut out.layers;
        (layers.width, layers.height) = (pixels.len() as u32, 1);
        for pixel in pixels {
            layers.offsets.push(layers.depth.len());
            layers.counts.push(pixel.len() as u32);
            layers.overflowed.push(false);
            for &(triangle, part, depth) in *pixel {
                layers.triangle.push(triangle);
                layers.part.push(part);
                layers.depth.push(depth);
                out.kappa.push(0.0);
                out.lit.push([0.5; 4]);
            }
        }
        out
    }

    const BOTH: [Identity; 2] = [Identity::Triangle, Identity::PartAndDepth];

    #[test]
    fn a_store_against_itself_has_no_error() {
        let s = store(&[&[(1, 0, 1.0), (2, 0, 2.0), (3, 1, 2.5)], &[], &[(2, 0, 2.0)]]);
        for identity in BOTH {
            let e = layer_error(&s, &s, identity).unwrap();
            let expected =
                LayerError { layers: 4, kappa_p95: Some(0.0), opacity_p95: Some(0.0), ..LayerError::default() };
            assert_eq!(e, expected);
        }
        assert!(layer_error(&s, &store(&[&[]]), Identity::Triangle).is_err());
    }

    #[test]
    fn layers_behind_a_full_pixel_are_lost() {
        let all = store(&[&[(1, 0, 1.0), (2, 1, 2.0), (3, 0, 3.0), (4, 1, 4.0)], &[(9, 0, 1.0)]]);
        let mut two = store(&[&[(1, 0, 1.0), (2, 1, 2.0)], &[(9, 0, 1.0)]]);
        two.layers.overflowed[0] = true;
        for identity in BOTH {
            let e = layer_error(&two, &all, identity).unwrap();
            assert_eq!((e.layers, e.lost, e.merged, e.out_of_order, e.extra), (5, 2, 0, 0, 0));
        }
    }

    #[test]
    fn a_tie_of_packed_keys_is_a_merger() {
        let all = store(&[&[(1, 0, 1.0), (2, 0, 1.000_01), (3, 0, 5.0), (4, 1, 6.0)]]);
        // Quantized depths, no triangles; the tie at 1 is one layer.
        let packed = store(&[&[(0, 0, 1.0), (0, 0, 5.01), (0, 1, 6.01)]]);
        let e = layer_error(&packed, &all, Identity::PartAndDepth).unwrap();
        assert_eq!((e.lost, e.merged, e.out_of_order, e.extra), (0, 1, 0, 0));
    }

    #[test]
    fn layers_in_the_wrong_order_are_counted() {
        let all = store(&[&[(1, 0, 1.0), (2, 1, 1.1), (3, 2, 1.2), (4, 3, 1.3)]]);
        for (order, moved) in [([1, 0, 2, 3], 1), ([1, 0, 3, 2], 2), ([3, 0, 1, 2], 1), ([3, 2, 1, 0], 3)] {
            let fragments = [(1, 0, 1.0), (2, 1, 1.0), (3, 2, 1.0), (4, 3, 1.0)];
            let row: Vec<_> = order.iter().map(|&i: &usize| fragments[i]).collect();
            for identity in BOTH {
                assert_eq!(layer_error(&store(&[&row]), &all, identity).unwrap().out_of_order, moved, "{order:?}");
            }
        }
    }

    #[test]
    fn a_layer_from_nowhere_is_extra() {
        let all = store(&[&[(1, 0, 1.0)]]);
        let more = store(&[&[(1, 0, 1.0), (7, 3, 2.0)]]);
        for identity in BOTH {
            let e = layer_error(&more, &all, identity).unwrap();
            assert_eq!((e.extra, e.lost, e.merged), (1, 0, 0));
        }
    }

    #[test]
    fn links_are_compared_by_what_they_lead_to() {
        let right = Direction::Right as usize;
        let left = Direction::Left as usize;
        let mut all = store(&[&[(1, 0, 1.0), (2, 0, 2.0)], &[(3, 0, 1.0), (4, 0, 2.0)]]);
        all.links = vec![[Link::Unknown; 4]; 4];
        (all.links[0][right], all.links[1][right]) = (Link::To(0), Link::To(1));
        (all.links[2][left], all.links[3][left]) = (Link::To(0), Link::To(1));
        // The near layer of the right pixel is gone: the far one is number 0 now.
        let mut some = store(&[&[(1, 0, 1.0), (2, 0, 2.0)], &[(4, 0, 2.0)]]);
        some.links = vec![[Link::Unknown; 4]; 3];
        (some.links[0][right], some.links[1][right]) = (Link::Missing, Link::To(0));
        some.links[2][left] = Link::To(1);
        let e = layer_error(&some, &all, Identity::Triangle).unwrap();
        // One of the twelve links of the three layers that are left.
        assert_eq!((e.lost, e.neighbours_different), (1, Some(1.0 / 12.0)));
        assert_eq!(layer_error(&all, &all, Identity::PartAndDepth).unwrap().neighbours_different, Some(0.0));
    }

    #[test]
    fn planted_errors_of_kappa_and_opacity_are_measured() {
        let row: Vec<_> = (0..100_u32).map(|i| (i, i, f64::from(i))).collect();
        let all = store(&[&row]);
        let mut off = all.clone();
        for i in 0..10 {
            off.kappa[i] = 0.25;
            off.lit[i][3] = 0.625;
        }
        for identity in BOTH {
            let e = layer_error(&off, &all, identity).unwrap();
            assert_eq!((e.kappa_p95, e.opacity_p95), (Some(0.25), Some(0.125)));
        }
        (4..10).for_each(|i| (off.kappa[i], off.lit[i][3]) = (0.0, 0.5));
        let e = layer_error(&off, &all, Identity::Triangle).unwrap();
        assert_eq!((e.kappa_p95, e.opacity_p95), (Some(0.0), Some(0.0)), "four in a hundred");
    }

    #[test]
    fn alignment_is_the_cheapest_without_crossings() {
        assert_eq!(align(&[1.0, 2.0, 3.0], &[2.9]), [(2, 0)]);
        assert_eq!(align(&[1.0, 2.0, 3.0], &[1.9, 2.0]), [(0, 0), (1, 1)]);
        assert_eq!(align(&[2.0], &[1.0, 2.1, 5.0]), [(0, 1)]);
        assert_eq!(align(&[], &[1.0]), []);
        assert_eq!(longest_ascent([3, 1, 2, 5, 4].into_iter()), 3);
    }
}
