//! From contours to triangles in the plane.
//!
//! Solids of an assembly may share room: a thread in a plain hole, a press fit, an organ in a body that is modelled whole.
//! Their caps would lie in each other, and rounding would choose between them pixel by pixel. So of caps that overlap the
//! smaller part's is whole, and is taken out of the larger one's.

use glam::{DMat4, DVec2, DVec3};
use i_triangle::float::custom::CustomTriangulatable;
use i_triangle::i_overlay::core::fill_rule::FillRule;
use i_triangle::i_overlay::core::overlay_rule::OverlayRule;
use i_triangle::i_overlay::float::simplify::SimplifyShape;
use i_triangle::i_overlay::float::single::SingleFloatOverlay;
use i_triangle::int::validation::Validation;
use rayon::prelude::*;

use super::contours::Contours;
use crate::math::Bounds;

/// A contour in the plane.
type Path = Vec<[f64; 2]>;

/// Axes of a plane and a point in it.
#[derive(Clone, Copy, Debug)]
pub struct PlaneFrame {
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    origin: DVec3,
}

impl PlaneFrame {
    /// Axes of the plane `normal · x = offset`, around the point of it that is nearest to `near`.
    pub fn new(normal: DVec3, offset: f64, near: DVec3) -> PlaneFrame {
        let (u, v) = normal.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(normal) < 0.0 { (v, u) } else { (u, v) };
        PlaneFrame { u, v, normal, origin: near - normal * (normal.dot(near) - offset) }
    }

    fn flat(&self, p: DVec3) -> [f64; 2] {
        [self.u.dot(p - self.origin), self.v.dot(p - self.origin)]
    }

    /// World space from the plane's, moved so that `at` is its origin.
    fn world_from_plane(&self, at: DVec2) -> DMat4 {
        let origin = self.origin + self.u * at.x + self.v * at.y;
        DMat4::from_cols(self.u.extend(0.0), self.v.extend(0.0), self.normal.extend(0.0), origin.extend(1.0))
    }
}

/// The inside of a part in a plane, before it is triangulated.
pub struct Region {
    /// Any number that is the same in one plane.
    pub plane: usize,
    /// Of overlapping regions of a plane the one with the lower rank stays whole.
    pub rank: (bool, f64, u32),
    frame: PlaneFrame,
    paths: Vec<Path>,
    rule: FillRule,
    low: DVec2,
    high: DVec2,
    bounds: Bounds,
}

/// A triangulated region.
pub struct Filled {
    pub positions: Vec<[f32; 2]>,
    pub triangles: Vec<[u32; 3]>,
    pub world_from_cap: DMat4,
    pub bounds: Bounds,
}

impl Region {
    /// The region inside closed contours; none if there are none, or they have no finite extent.
    pub fn new(contours: &Contours, plane: usize, rank: (bool, f64, u32), frame: PlaneFrame) -> Option<Region> {
        let bounds = Bounds::of_points(contours.closed.iter().flatten().copied());
        if bounds.is_empty() || !contours.closed.iter().flatten().all(|p| p.is_finite()) {
            return None;
        }
        let paths: Vec<Path> =
            contours.closed.iter().map(|contour| contour.iter().map(|p| frame.flat(*p)).collect()).collect();
        let points = || paths.iter().flatten().map(|p| DVec2::from(*p));
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        let rule = if contours.directed { FillRule::NonZero } else { FillRule::EvenOdd };
        Some(Region { plane, rank, frame, paths, rule, low, high, bounds })
    }

    fn may_overlap(&self, other: &Region) -> bool {
        self.plane == other.plane && self.low.cmplt(other.high).all() && other.low.cmplt(self.high).all()
    }

    fn goes_before(&self, other: &Region) -> bool {
        let ((a, b, c), (d, e, f)) = (self.rank, other.rank);
        a.cmp(&d).then(b.total_cmp(&e)).then(c.cmp(&f)).is_lt()
    }

    /// Triangles of these shapes of the region; none if they have no area.
    fn triangulated(&self, shapes: &[Vec<Path>], rule: FillRule) -> Option<Filled> {
        // Around its own middle, where 32 bits are finest.
        let middle = 0.5 * (self.low + self.high);
        let moved: Vec<Vec<Path>> = shapes
            .iter()
            .map(|s| s.iter().map(|p| p.iter().map(|v| [v[0] - middle.x, v[1] - middle.y]).collect()).collect())
            .collect();
        let filled = moved.as_slice().custom_triangulate(Validation::with_fill_rule(rule)).to_triangulation::<u32>();
        let positions: Vec<[f32; 2]> = filled.points.iter().map(|p| p.map(|v| v as f32)).collect();
        let corner = |i: u32| DVec2::from(positions[i as usize].map(f64::from));
        let turned = |&[a, b, c]: &[u32; 3]| {
            let area = (corner(b) - corner(a)).perp_dot(corner(c) - corner(a));
            if area < 0.0 { [a, c, b] } else { [a, b, c] }
        };
        let triangles: Vec<[u32; 3]> = filled.indices.chunks_exact(3).map(|t| turned(&[t[0], t[1], t[2]])).collect();
        let world_from_cap = self.frame.world_from_plane(middle);
        (!triangles.is_empty()).then_some(Filled { positions, triangles, world_from_cap, bounds: self.bounds })
    }
}

/// Triangulates regions, without what others of the same plane take from them.
pub fn fill(regions: &[Region]) -> Vec<Option<Filled>> {
    let takers: Vec<Vec<usize>> = regions
        .par_iter()
        .map(|region| {
            let takes = |other: &Region| other.may_overlap(region) && other.goes_before(region);
            (0..regions.len()).filter(|&i| takes(&regions[i])).collect()
        })
        .collect();
    let mut taking = vec![false; regions.len()];
    takers.iter().flatten().for_each(|&i| taking[i] = true);
    // All with the same sense, so that they add up.
    let simple: Vec<Vec<Vec<Path>>> = regions
        .par_iter()
        .zip(&takers)
        .zip(&taking)
        .map(|((region, takers), taking)| {
            let overlaps = *taking || !takers.is_empty();
            if overlaps { region.paths.simplify_shape(region.rule) } else { Vec::new() }
        })
        .collect();
    regions
        .par_iter()
        .zip(&takers)
        .zip(&simple)
        .map(|((region, takers), own)| {
            if takers.is_empty() {
                return region.triangulated(std::slice::from_ref(&region.paths), region.rule);
            }
            let taken: Vec<Vec<Path>> = takers.iter().flat_map(|&i| simple[i].iter().cloned()).collect();
            let left = own.overlay(&taken, OverlayRule::Difference, FillRule::NonZero);
            region.triangulated(&left, FillRule::NonZero)
        })
        .collect()
}
