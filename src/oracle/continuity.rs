//! The four neighbours of every fragment by continuity (Carnecky 2013, section 4.4).
//!
//! ε = ε_n + ε_z with ε_n = 1 − n_i · n_j and ε_z a difference between a fragment's depth and where the other's tangent plane
//! crosses its pixel, in radii of the part; infinite across parts.
//!
//! Ours takes the larger of both fragments' |ε_z|, so that ε(i, j) = ε(j, i) (T13). Two fragments are neighbours if each is
//! the other's best; the best pair of two pixels then always is. As printed, ε_z has a sign and only one fragment's slope, and
//! the check of Algorithm 2 does not make links mutual.
//!
//! # Parameters
//! With [`Form::Parameters`] two fragments are as far apart as their places in the surface's parametrization, in radii of the
//! part, if that is at most four times what either's triangle covers over a pixel in that direction (ε = d / (1 + d), which is less than 1); otherwise, and where a
//! fragment has no parameters, they come after all such: ε = 1 + the mutual ε by continuity.
//!
//! # Choices
//! The slope is that of the plane across the stored normal, at most 1 : 20 (as in [`super::neighbours`]); the paper has the
//! triangle's. Both weights are 1, as the paper's are equal. Of equal ε the nearer layer wins.
//!
//! An answer is ambiguous if the two best ε, here or in the check, lie within 1e-6 and what 4 ulp of the depths make.

use glam::{DVec3, Vec3};

use super::neighbours::{Direction, Link, Neighbours, expected_depth, neighbours_expected};
use super::store::StoreData;
use super::view::{Extents, View};
use crate::settings::DepthTerm;

/// How close two ε may be for either to win.
const TOLERANCE: f64 = 1e-6;

/// All neighbours by the measure that the settings name.
pub fn neighbours_by(
    store: &StoreData,
    extents: &Extents,
    view: &View,
    (term, check): (DepthTerm, bool),
) -> Neighbours {
    match term {
        DepthTerm::Printed => neighbours_expected(store, extents, None, check),
        DepthTerm::Slope => neighbours_expected(store, extents, Some(view), check),
        DepthTerm::Continuity => neighbours_by_continuity(store, extents, view, Form::Mutual, check),
        DepthTerm::Parameters => neighbours_by_continuity(store, extents, view, Form::Parameters, check),
        DepthTerm::ContinuityPrinted => neighbours_by_continuity(store, extents, view, Form::Printed, check),
    }
}

/// Which form of the measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The same both ways.
    Mutual,
    /// Signed, by one fragment's slope, with the check of Algorithm 2.
    Printed,
    /// Distance in the parametrization, the same both ways; continuity where that says nothing.
    Parameters,
}

/// How many times what a triangle covers over a pixel two neighbours may be apart in parameters.
const STEPS: f64 = 4.0;

/// Distance of two fragments in the parametrization if they are near in it, and whether that hangs on a rounding error.
fn apart(store: &StoreData, (i, p): (usize, usize), (j, q): (usize, usize)) -> (Option<f64>, bool) {
    let (Some(a), Some(b)) = (store.parameters.get(i), store.parameters.get(j)) else { return (None, false) };
    // Pixels in one row are a step in x apart.
    let axis = if p.abs_diff(q) == 1 && store.width > 1 { 2 } else { 3 };
    let at = |of: &[f32; 4], c: usize| f64::from(of[c]);
    let apart = (at(a, 0) - at(b, 0)).hypot(at(a, 1) - at(b, 1));
    let (least, most) = (at(a, axis).min(at(b, axis)), at(a, axis).max(at(b, axis)));
    let reach = STEPS * most;
    let is_near = least > 0.0 && apart <= reach;
    (is_near.then_some(apart / (1.0 + apart)), least > 0.0 && (apart - reach).abs() <= 1e-6 * (1.0 + reach))
}

/// ε between fragment `i` of pixel `p` and fragment `j` of the adjacent pixel `q`, and what 32-bit depths may make of it.
fn epsilon(
    store: &StoreData,
    extents: &Extents,
    view: &View,
    form: Form,
    (i, p): (usize, usize),
    (j, q): (usize, usize),
) -> (f64, f64) {
    let normal = |f: usize| -> DVec3 { Vec3::from(store.normal[f]).as_dvec3() };
    let radius = extents.part_radius(store.part[i]);
    let off = |(a, p): (usize, usize), (b, q): (usize, usize)| {
        (expected_depth(store, Some(view), a, p, q) - store.depth[b]) / radius
    };
    let there = off((i, p), (j, q));
    if form == Form::Parameters {
        let (distance, uncertain) = apart(store, (i, p), (j, q));
        let continuity = epsilon(store, extents, view, Form::Mutual, (i, p), (j, q));
        let error = if uncertain { f64::INFINITY } else { continuity.1 };
        return match distance {
            Some(distance) => (distance, if uncertain { error } else { 0.0 }),
            None => (1.0 + continuity.0, error),
        };
    }
    let z = match form {
        Form::Mutual | Form::Parameters => there.abs().max(off((j, q), (i, p)).abs()),
        Form::Printed => there,
    };
    let facing = |f: usize| f64::from(store.normal[f][2]).clamp(0.05, 1.0);
    let ulps = 4.0 * f64::from(f32::EPSILON) * store.depth[i].abs() / radius / facing(i).min(facing(j));
    (1.0 - normal(i).dot(normal(j)) + z, ulps)
}

/// The index with the least value, the first of equals, and whether another is as good but for `tolerance`.
fn least(values: impl Iterator<Item = (usize, (f64, f64))>) -> Option<(usize, f64, bool)> {
    let mut all: Vec<(usize, (f64, f64))> = values.collect();
    // Stable, so that the nearer layer stays first.
    all.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let &(index, (value, error)) = all.first()?;
    let near = all[1..].iter().any(|&(_, (second, other))| second - value <= TOLERANCE + error.max(other));
    Some((index, value, near))
}

/// Finds all neighbours by continuity. Without `check` the best candidate counts as it is.
pub fn neighbours_by_continuity(
    store: &StoreData,
    extents: &Extents,
    view: &View,
    form: Form,
    check: bool,
) -> Neighbours {
    let pixel_of = store.pixel_of_fragment();
    let (width, height) = (store.width.max(1) as usize, store.height as usize);
    let mut result = Neighbours::default();
    for (i, &p) in pixel_of.iter().enumerate() {
        let mut links = [Link::Unknown; 4];
        let mut ambiguous = [false; 4];
        let alike = |f: &usize| store.part[*f] == store.part[i];
        for direction in Direction::ALL {
            let d = direction as usize;
            let Some(q) = direction.step(p, width, height) else { continue };
            links[d] = if store.overflowed[q] { Link::Unknown } else { Link::Missing };
            let measure = |a, b| epsilon(store, extents, view, form, a, b);
            let candidates = store.range(q).filter(alike).map(|j| (j, measure((i, p), (j, q))));
            let Some((j, value, near)) = least(candidates) else { continue };
            ambiguous[d] = near;
            let own = store.range(p).filter(alike);
            let agreed = if !check {
                true
            } else if form != Form::Printed {
                let back = least(own.map(|k| (k, measure((j, q), (k, p)))));
                ambiguous[d] |= back.is_some_and(|(_, _, near)| near);
                back.is_some_and(|(k, ..)| k == i)
            } else {
                let rivals: Vec<_> = own.filter(|&k| k != i).map(|k| measure((k, p), (j, q))).collect();
                ambiguous[d] |= rivals.iter().any(|(e, error)| (e - value).abs() <= TOLERANCE + error);
                !rivals.iter().any(|(e, _)| *e < value)
            };
            if agreed {
                links[d] = Link::To((j - store.offsets[q]) as u32);
            }
        }
        result.links.push(links);
        result.ambiguous.push(ambiguous);
    }
    result
}

/// Links that have no way back: the layer that they lead to is linked elsewhere, or nowhere.
pub fn one_way(store: &StoreData, links: &[[Link; 4]]) -> usize {
    let pixel_of = store.pixel_of_fragment();
    let (width, height) = (store.width.max(1) as usize, store.height as usize);
    let has_no_way_back = |i: usize, direction: Direction| {
        let (Link::To(layer), Some(q)) = (links[i][direction as usize], direction.step(pixel_of[i], width, height))
        else {
            return false;
        };
        let back = links[store.offsets[q] + layer as usize][direction.opposite() as usize];
        back != Link::To((i - store.offsets[pixel_of[i]]) as u32)
    };
    (0..links.len()).map(|i| Direction::ALL.into_iter().filter(|&d| has_no_way_back(i, d)).count()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::store::row;

    fn extents() -> Extents {
        Extents { part_radii: vec![10.0, 10.0], scene_radius: 10.0, visible_height: 1.0, depth_range: [0.0, 10.0] }
    }

    #[test]
    fn epsilon_by_hand() {
        // Slope 1 at depth 2 expects 3 next door, where something flat lies at 3.5; that expects 3.5 here.
        let (store, view) = row(&[&[(0, 2.0, 1.0)], &[(0, 3.5, 0.0)]]);
        let normals = 1.0 - 0.5_f64.sqrt();
        let (mutual, _) = epsilon(&store, &extents(), &view, Form::Mutual, (0, 0), (1, 1));
        assert!((mutual - normals - 0.15).abs() < 1e-7, "the larger of 0.5 and 1.5, over a radius of 10");
        let (back, _) = epsilon(&store, &extents(), &view, Form::Mutual, (1, 1), (0, 0));
        assert_eq!(mutual, back);
        let (printed, _) = epsilon(&store, &extents(), &view, Form::Printed, (0, 0), (1, 1));
        assert!((printed - normals + 0.05).abs() < 1e-7, "3 − 3.5, with its sign");
    }

    #[test]
    fn the_slope_tells_the_faces_of_a_thin_wall_apart() {
        let wall = |x: f64| [(0, 2.0 + 0.4 * x, 0.4), (0, 2.1 + 0.4 * x, 0.4)];
        let (store, view) = row(&[&wall(0.0), &wall(1.0), &wall(2.0)]);
        let found = neighbours_by_continuity(&store, &extents(), &view, Form::Mutual, true);
        assert_eq!(found.links[2][..2], [Link::To(0), Link::To(0)]);
        assert_eq!(found.links[3][..2], [Link::To(1), Link::To(1)]);
        assert_eq!(one_way(&store, &found.links), 0);
        // With its sign, the far face is the best of both: it lies deepest below what is expected.
        let printed = neighbours_by_continuity(&store, &extents(), &view, Form::Printed, true);
        assert_eq!(printed.links[2][0], Link::To(1), "the wrong face");
        assert_eq!(printed.links[2][2], Link::Unknown);
    }

    /// The same row with places in the parametrization: (u, step).
    fn placed(mut store: StoreData, places: &[(f32, f32)]) -> StoreData {
        store.parameters = places.iter().map(|&(u, step)| [u, 0.0, step, 0.0]).collect();
        store
    }

    fn links_by_parameters(store: &StoreData, view: &View) -> Vec<[Link; 4]> {
        let found = neighbours_by_continuity(store, &extents(), view, Form::Parameters, true);
        assert_eq!(one_way(store, &found.links), 0);
        found.links
    }

    /// Two sheets cross between two pixels: depth and normal continue each along the other, parameters do not.
    #[test]
    fn sheets_that_nearly_touch_are_told_apart_by_their_parameters() {
        let (store, view) = row(&[&[(0, 2.0, 0.0), (0, 2.01, 0.0)], &[(0, 2.0, 0.0), (0, 2.01, 0.0)]]);
        // The near layer of the first pixel is the far one of the second: u = 0.10 to 0.11, and 0.70 to 0.71.
        let store = placed(store, &[(0.10, 0.01), (0.70, 0.01), (0.71, 0.01), (0.11, 0.01)]);
        let by_depth = neighbours_by_continuity(&store, &extents(), &view, Form::Mutual, true).links;
        assert_eq!((by_depth[0][0], by_depth[1][0]), (Link::To(0), Link::To(1)));
        let links = links_by_parameters(&store, &view);
        assert_eq!((links[0][0], links[1][0]), (Link::To(1), Link::To(0)));
        assert_eq!((links[2][1], links[3][1]), (Link::To(1), Link::To(0)));
    }

    #[test]
    fn a_seam_and_what_has_no_parameters_go_by_continuity() {
        let (store, view) = row(&[&[(0, 2.0, 0.0), (0, 3.0, 0.0)], &[(0, 2.0, 0.0), (0, 3.0, 0.0)]]);
        // The near sheet jumps from 0.99 to 0.01, as an angle does; the far one goes on.
        let seam = placed(store.clone(), &[(0.99, 0.01), (0.5, 0.01), (0.01, 0.01), (0.51, 0.01)]);
        let by_depth = neighbours_by_continuity(&store, &extents(), &view, Form::Mutual, true).links;
        assert_eq!(links_by_parameters(&seam, &view), by_depth);
        // A pair that is near takes precedence over one beyond a seam, however well that continues.
        let pair = placed(store.clone(), &[(0.99, 0.01), (0.5, 0.01), (0.49, 0.01), (0.98, 0.01)]);
        assert_eq!(links_by_parameters(&pair, &view)[0][0], Link::To(1));
        // Four steps are near, more are not.
        for (u, expected) in [(0.539, Link::To(1)), (0.541, Link::To(0))] {
            let far = placed(store.clone(), &[(0.5, 0.01), (0.1, 0.01), (0.9, 0.01), (u, 0.01)]);
            assert_eq!(links_by_parameters(&far, &view)[0][0], expected, "{u}");
        }
        for none in [store.clone(), placed(store, &[(0.0, 0.0); 4])] {
            assert_eq!(links_by_parameters(&none, &view), by_depth);
        }
    }

    /// T13, whatever parameters say.
    #[test]
    fn links_by_parameters_are_mutual() {
        let mut random = crate::scene::builtin::Random::new(13);
        for _ in 0..50 {
            let lists: Vec<Vec<(u32, f64, f64)>> = (0..6)
                .map(|_| (0..5).map(|_| (0, 2.0 + 4.0 * random.unit(), 4.0 * random.unit() - 2.0)).collect())
                .collect();
            let slices: Vec<&[(u32, f64, f64)]> = lists.iter().map(Vec::as_slice).collect();
            let (store, view) = row(&slices);
            let places: Vec<(f32, f32)> =
                (0..30).map(|_| (random.unit() as f32, 0.1 * random.below(3) as f32 * random.unit() as f32)).collect();
            let links = links_by_parameters(&placed(store, &places), &view);
            assert!(links.iter().flatten().any(|l| matches!(l, Link::To(_))));
        }
    }

    #[test]
    fn parts_stay_apart_and_ends_are_missing_or_unknown() {
        let (mut store, view) = row(&[&[(0, 2.0, 0.0)], &[(1, 2.0, 0.0)], &[(1, 2.1, 0.0), (0, 2.0, 0.0)]]);
        let links = |store: &StoreData| neighbours_by_continuity(store, &extents(), &view, Form::Mutual, true).links;
        assert_eq!(links(&store)[0], [Link::Missing, Link::Unknown, Link::Unknown, Link::Unknown]);
        assert_eq!(links(&store)[1][..2], [Link::To(0), Link::Missing]);
        store.overflowed[1] = true;
        assert_eq!(links(&store)[0][0], Link::Unknown);
    }

    /// T13 on random lists: ours is mutual in every link, as printed most are not.
    #[test]
    fn t13_links_are_mutual_and_as_printed_are_not() {
        let mut state = 5_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        let (mut links, mut printed_links, mut printed_one_way) = (0, 0, 0);
        for _ in 0..100 {
            let lists: Vec<Vec<(u32, f64, f64)>> =
                (0..6).map(|_| (0..5).map(|_| (0, 2.0 + 4.0 * random(), 4.0 * random() - 2.0)).collect()).collect();
            let slices: Vec<&[(u32, f64, f64)]> = lists.iter().map(Vec::as_slice).collect();
            let (store, view) = row(&slices);
            let count = |n: &Neighbours| n.links.iter().flatten().filter(|l| matches!(l, Link::To(_))).count();
            let ours = neighbours_by_continuity(&store, &extents(), &view, Form::Mutual, true);
            assert_eq!(one_way(&store, &ours.links), 0);
            links += count(&ours);
            let printed = neighbours_by_continuity(&store, &extents(), &view, Form::Printed, true);
            printed_links += count(&printed);
            printed_one_way += one_way(&store, &printed.links);
        }
        println!("{links} links of ours; as printed {printed_one_way} of {printed_links} go one way");
        assert!(links > 1000 && 2 * printed_one_way > printed_links);
    }
}
