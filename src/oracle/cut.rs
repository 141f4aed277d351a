//! Section planes: which fragments they cut away, and which neighbours are unknown because of them (T10).
//!
//! A plane cuts what lies on the side of its normal. It does not cut its own caps. Surfaces parallel to it (whose height over
//! it changes by less than 1/32 pixel from pixel to pixel) are cut from 1/64 pixel before it, so that a face in the plane
//! goes as a whole; all others exactly. A layer's neighbour is unknown where its
//! tangent plane, half a step beyond the adjacent pixel, lies on the side that is cut away; the plane is given at most the
//! slope of 1 : 20.
//!
//! An answer within a few roundings of the margin is ambiguous.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::neighbours::{Direction, Link, Neighbours};
use super::store::StoreData;
use super::view::View;
use crate::math::Camera;
use crate::scene::CutPlane;

/// Share of a pixel's height by which the cut is off the plane.
const MARGIN: f64 = 1.0 / 64.0;
/// The same as a share of depth: what 32-bit positions round.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;
/// How far a surface is followed into the adjacent pixel, in steps.
const REACH: f64 = 1.5;

/// Section planes as a camera sees them.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewCut {
    planes: Vec<Plane>,
    view: View,
}

#[derive(Clone, Debug, PartialEq)]
struct Plane {
    normal: DVec3,
    height_of_eye: f64,
    caps: Range<u32>,
}

impl Plane {
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) + self.height_of_eye
    }
}

impl ViewCut {
    /// The planes in the view of a camera.
    pub fn new(planes: &[CutPlane], camera: &Camera, view: View) -> ViewCut {
        let view_from_world = camera.view_from_world();
        let eye = view_from_world.inverse().transform_point3(DVec3::ZERO);
        let plane = |p: &CutPlane| Plane {
            normal: view_from_world.transform_vector3(p.normal),
            height_of_eye: p.normal.dot(eye) - p.offset,
            caps: p.caps.clone(),
        };
        ViewCut { planes: planes.iter().map(plane).collect(), view }
    }

    fn margin(&self, depth: f64) -> f64 {
        self.view.pixel_size(depth).y * MARGIN + depth.abs() * ROUNDING
    }

    /// What 32 bits make of a height at a point.
    fn rounding(&self, plane: &Plane, point: DVec3) -> f64 {
        8.0 * f64::from(f32::EPSILON) * (point.length() + plane.height_of_eye.abs())
    }

    /// How much depth changes over a pixel on a surface with this normal.
    fn slope(&self, normal: DVec3, point: DVec3) -> f64 {
        let pixel = self.view.pixel_size(-point.z);
        let sight = if self.view.perspective { point / -point.z } else { DVec3::NEG_Z };
        (normal.x.abs() * pixel.x + normal.y.abs() * pixel.y) / normal.dot(sight).abs().max(1e-9)
    }

    /// Whether a point of a part on a surface with this normal is cut away, and whether what rasterizers and 32 bits round
    /// could change that.
    pub fn cuts(&self, part: u32, point: DVec3, normal: DVec3) -> (bool, bool) {
        let (mut cut, mut uncertain) = (false, false);
        if self.planes.is_empty() {
            return (cut, uncertain);
        }
        let depth_by = self.slope(normal, point) / 256.0 + 1e-6 * -point.z;
        let margin = self.margin(-point.z);
        for plane in self.planes.iter().filter(|p| !p.caps.contains(&part)) {
            let height = plane.height(point);
            let sight = if self.view.perspective { point / -point.z } else { DVec3::NEG_Z };
            let by = depth_by * plane.normal.dot(sight).abs() + self.rounding(plane, point);
            let change: f64 = [Direction::Right, Direction::Down]
                .into_iter()
                .map(|direction| (plane.height(self.on_plane(point, normal, direction)) - height).abs())
                .sum();
            let over = height + if change < 2.0 * margin { margin } else { 0.0 };
            cut |= over > 0.0;
            let either = (margin..4.0 * margin).contains(&change) && height.abs() <= margin + by;
            uncertain |= over.abs() <= by || either;
        }
        (cut, uncertain)
    }

    /// Where the sight line one pixel aside meets the plane through `p` with normal `n`; far away where they do not meet.
    fn on_plane(&self, p: DVec3, n: DVec3, direction: Direction) -> DVec3 {
        let step = self.step(direction);
        if !self.view.perspective {
            return p + step - DVec3::Z * (n.dot(step) / n.z);
        }
        let ray = p / -p.z + step;
        ray * (n.dot(p) / n.dot(ray))
    }

    /// One pixel aside, in view space, at depth 1 under perspective.
    fn step(&self, direction: Direction) -> DVec3 {
        let size = self.view.pixel_size(1.0);
        match direction {
            Direction::Right => DVec3::X * size.x,
            Direction::Left => DVec3::NEG_X * size.x,
            Direction::Down => DVec3::NEG_Y * size.y,
            Direction::Up => DVec3::Y * size.y,
        }
    }

    /// Where the tangent plane through `p` is met by the sight line one pixel aside.
    fn aside(&self, p: DVec3, n: DVec3, direction: Direction) -> DVec3 {
        let step = self.step(direction);
        let slope = n.dot(step);
        if !self.view.perspective {
            return p + step + DVec3::NEG_Z * (slope / n.z.max(0.05));
        }
        let depth = -p.z;
        let ray = p / depth + step;
        ray * (depth + depth * slope / (-n.dot(ray)).max(0.05))
    }

    /// Makes the links unknown whose surface would go on where it is cut away.
    pub fn apply(&self, store: &StoreData, neighbours: &mut Neighbours) {
        for (i, &pixel) in store.pixel_of_fragment().iter().enumerate() {
            let (x, y) = store.xy(pixel);
            let (depth, normal) = (store.depth[i], Vec3::from(store.normal[i]).as_dvec3());
            let p = self.view.position(x, y, depth);
            for direction in Direction::ALL {
                let aside = self.aside(p, normal, direction);
                let (mut unknown, mut uncertain) = (false, false);
                for plane in self.planes.iter().filter(|plane| !plane.caps.contains(&store.part[i])) {
                    let (here, there) = (plane.height(p), plane.height(aside));
                    let over = here + REACH * (there - here) + self.margin(depth);
                    unknown |= over > 0.0;
                    // The slope divides by as little as 1/20.
                    let by = self.rounding(plane, p) + 1e-5 * (there - here).abs();
                    uncertain |= over.abs() <= by;
                }
                let d = direction as usize;
                if unknown {
                    neighbours.links[i][d] = Link::Unknown;
                    neighbours.ambiguous[i][d] = false;
                }
                neighbours.ambiguous[i][d] |= uncertain;
            }
        }
    }
}
