//! Triangles on their way into a scene, whatever format they come from: far coordinates, vertices that nothing uses, triangles
//! that have no surface, normals.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{ImportOptions, Notices};
use crate::math::Bounds;
use crate::math::color::linear_from_srgb;
use crate::scene::{Material, NoticeKind, Primitive, compute_normals, mended_normals, weld_positions};

/// Coordinates are moved when their centre is farther from the origin than this many radii: below it, moving them saves less
/// than three of the 24 bits of an `f32`.
const MOVED_RADII: f64 = 8.0;

/// What shows a surface of which a file says no more than where it is: light grey, neither metal nor a mirror.
pub(super) fn plain_material() -> Material {
    Material {
        base_color: [0.6, 0.6, 0.6, 1.0],
        metallic: 0.0,
        roughness: 0.5,
        double_sided: true,
        ..Material::default()
    }
}

/// Where to put the origin of a mesh so that `f32` keeps its coordinates: the centre of their box if that lies far away, else
/// zero. Coordinates that no `f32` can hold count for nothing.
pub(super) fn origin_of(positions: &[[f64; 3]]) -> DVec3 {
    let possible = |p: &&[f64; 3]| p.iter().all(|c| c.abs() <= f64::from(f32::MAX));
    let bounds = Bounds::of_points(positions.iter().filter(possible).map(|&p| DVec3::from(p)));
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let center = 0.5 * bounds.min + 0.5 * bounds.max;
    if center.length() > MOVED_RADII * 0.5 * (bounds.max - bounds.min).length() { center } else { DVec3::ZERO }
}

/// A position relative to `origin`, in `f32`; what does not fit is infinite.
pub(super) fn relative(position: [f64; 3], origin: DVec3) -> [f32; 3] {
    (DVec3::from(position) - origin).as_vec3().to_array()
}

/// A colour as files have it, encoded in sRGB from 0 to 1, to linear light.
pub(super) fn linear_color([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    let linear = |c: f32| linear_from_srgb(f64::from(c).clamp(0.0, 1.0)) as f32;
    [linear(r), linear(g), linear(b), if a.is_nan() { 1.0 } else { a.clamp(0.0, 1.0) }]
}

/// Triangles out of corners that know only where they are, three a triangle: those at one place become one vertex, bit for
/// bit; triangles that cannot be drawn are dropped. It has no normals yet.
pub(super) fn welded(corners: &[[f32; 3]], place: &str, notices: &mut Notices) -> Primitive {
    let welded = weld_positions(corners);
    let mut triangles: Vec<[u32; 3]> = welded.ids.par_chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    let mut positions: Vec<[f32; 3]> = welded.firsts.par_iter().map(|&first| corners[first as usize]).collect();
    drop(welded);
    let count = triangles.len();
    clean(&mut triangles, &positions, place, notices);
    if triangles.len() < count {
        let kept = compact(&mut triangles, positions.len() as u64);
        positions = kept.iter().map(|&k| positions[k as usize]).collect();
    }
    Primitive { positions, triangles, ..Primitive::default() }
}

/// What the length of a unit vector may be off by: a little more than bytes make of it.
pub(super) const UNIT: f64 = 2e-2;

/// Makes a unit vector of a normal; gives its number and length where there was something to do, length 0 where it has no
/// direction. What is a unit vector but for rounding stays bit for bit.
fn normalize((number, stored): (usize, &mut [f32; 3])) -> Option<(usize, f64)> {
    let normal = Vec3::from(*stored).as_dvec3();
    let length = normal.length();
    if (length - 1.0).abs() < 1e-4 {
        return None;
    }
    let has_direction = length.is_finite() && length >= 1e-12;
    *stored = if has_direction { (normal / length).as_vec3().to_array() } else { [0.0; 3] };
    Some((number, if has_direction { length } else { 0.0 }))
}

/// Gives a primitive the normals that its file has for its vertices (`stored`), or computes them; says whether they are the
/// file's (and so the vertices still the file's).
pub(super) fn given_normals(
    p: &mut Primitive,
    stored: Option<Vec<[f32; 3]>>,
    options: &ImportOptions,
    place: &str,
    notices: &mut Notices,
) -> bool {
    let given = stored.is_some();
    p.normals = stored.unwrap_or_default();
    let odd: Vec<(usize, f64)> = p.normals.par_iter_mut().enumerate().filter_map(normalize).collect();
    let bad: Vec<usize> = odd.iter().filter(|(_, length)| *length == 0.0).map(|(i, _)| *i).collect();
    let long = odd.iter().filter(|(_, length)| *length > 0.0 && (length - 1.0).abs() > UNIT).count() as u64;
    notices.count(NoticeKind::Repaired, "normals were not of unit length and were normalized", long, place);
    let what = "normals were zero or not finite and were computed";
    notices.count(NoticeKind::Repaired, what, bad.len() as u64, place);
    if !given || bad.len() == p.positions.len() {
        compute_normals(p, options.crease_angle);
        notices.count(NoticeKind::Computed, "primitives without normals were given some", 1, place);
        return false;
    }
    if !bad.is_empty() {
        let mut smooth =
            Primitive { positions: p.positions.clone(), triangles: p.triangles.clone(), ..Primitive::default() };
        compute_normals(&mut smooth, 180.0);
        for i in bad {
            p.normals[i] = smooth.normals[i];
        }
    }
    if options.reweight_normals {
        let [reweighted, interpolated] = mended_normals(p);
        let what = "primitives have normals that are plain averages of their facets; they were re-weighted";
        notices.count(NoticeKind::Computed, what, reweighted.into(), place);
        let what = "primitives have flat normals inside edges of curved facets; they were interpolated";
        notices.count(NoticeKind::Computed, what, interpolated.into(), place);
    }
    true
}

/// Renumbers the vertices of `triangles` so that only used ones are left, in their order; gives the old number of each.
/// All vertices are below `count`.
pub(super) fn compact(triangles: &mut [[u32; 3]], count: u64) -> Vec<u32> {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    // A table where it is not much larger than the triangles; else many small primitives on one big accessor would each
    // pay for all of it.
    if count <= 16 * used.len() as u64 {
        let mut table = vec![u32::MAX; count as usize];
        for &v in &used {
            table[v as usize] = 0;
        }
        used.clear();
        for (v, entry) in table.iter_mut().enumerate().filter(|(_, entry)| **entry == 0) {
            *entry = used.len() as u32;
            used.push(v as u32);
        }
        for v in triangles.as_flattened_mut() {
            *v = table[*v as usize];
        }
    } else {
        used.sort_unstable();
        used.dedup();
        for v in triangles.as_flattened_mut() {
            *v = used.partition_point(|u| u < v) as u32;
        }
    }
    used
}

/// Drops triangles with a non-finite corner or without area, and tells how many.
pub(super) fn clean(triangles: &mut Vec<[u32; 3]>, positions: &[[f32; 3]], place: &str, notices: &mut Notices) {
    let judge = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| Vec3::from(positions[v as usize]).as_dvec3());
        if !(a.is_finite() && b.is_finite() && c.is_finite()) {
            return Judgement::Infinite;
        }
        let (e1, e2, e3) = (b - a, c - a, c - b);
        let longest = e1.length_squared().max(e2.length_squared()).max(e3.length_squared());
        // The differences of f32 are all but exact in f64: this is zero but for rounding, not "thin".
        let has_area = longest > 0.0 && (e1.cross(e2) / longest).length() > 1e-14;
        if has_area { Judgement::Kept } else { Judgement::Flat }
    };
    // Most files have nothing to drop.
    if triangles.par_iter().all(|t| judge(t) == Judgement::Kept) {
        return;
    }
    let (mut infinite, mut flat) = (0, 0);
    triangles.retain(|t| {
        let judgement = judge(t);
        infinite += u64::from(judgement == Judgement::Infinite);
        flat += u64::from(judgement == Judgement::Flat);
        judgement == Judgement::Kept
    });
    notices.count(NoticeKind::Repaired, "triangles with positions that are not finite were dropped", infinite, place);
    notices.count(NoticeKind::Repaired, "triangles without area were dropped", flat, place);
}

#[derive(PartialEq)]
enum Judgement {
    Kept,
    Infinite,
    Flat,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soup_is_welded_and_cleaned() {
        let nan = f32::NAN;
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mut notices = Notices::default();
        let corners = [a, b, c, c, b, d, a, a, b, a, b, [nan, 0.0, 0.0], a, b, [0.5, 0.0, 0.0]];
        let p = welded(&corners, "solid 1", &mut notices);
        assert_eq!((p.positions.len(), p.triangles.len()), (4, 2));
        let told: Vec<String> = notices.into_vec().into_iter().map(|n| n.message).collect();
        assert_eq!(told[0], "1 triangles with positions that are not finite were dropped (solid 1)");
        assert_eq!(told[1], "2 triangles without area were dropped (solid 1)");
    }

    #[test]
    fn only_far_coordinates_are_moved() {
        assert_eq!(origin_of(&[[0.0; 3], [1.0, 2.0, 3.0]]), DVec3::ZERO);
        assert_eq!(origin_of(&[[1e7, 0.0, 0.0], [1e7 + 2.0, 0.0, 0.0]]), DVec3::new(1e7 + 1.0, 0.0, 0.0));
        assert_eq!(origin_of(&[[f64::NAN, 0.0, 0.0], [1e300, 0.0, 0.0]]), DVec3::ZERO);
        assert_eq!(origin_of(&[]), DVec3::ZERO);
        let at = relative([1e7 + 0.001, 0.0, 0.0], DVec3::new(1e7, 0.0, 0.0));
        assert!((at[0] - 0.001).abs() < 1e-8);
    }
}
