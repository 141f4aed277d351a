//! Surfaces whose curvature is known in closed form, as fragment stores: what the curvature stage is judged by.
//!
//! A surface is the zero set of a function with known gradient and Hessian. Sight lines are followed in small steps and
//! crossings refined by bisection, so a store has every layer of the surface, with exact depths and normals. Curvature
//! comes from the formulas for implicit surfaces (Goldman 2005), the Hessian of depth from implicit differentiation.
//! All signs are for the normal that faces the viewer: positive is convex.

use glam::{DMat2, DMat3, DVec2, DVec3};

use super::raster::depth_key;
use super::store::StoreData;
use super::view::View;

/// A surface in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// All points at a distance from the origin.
    Sphere {
        /// That distance.
        radius: f64,
    },
    /// All points at a distance from the y axis.
    Cylinder {
        /// That distance.
        radius: f64,
    },
    /// All points at a distance `minor` from a circle of radius `major` in the xy plane.
    Torus {
        /// Radius of the circle.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// `z = bend (x² − y²) / 2`.
    Saddle {
        /// Principal curvature at the origin.
        bend: f64,
    },
    /// `normal · p = 0`.
    Plane {
        /// Normal.
        normal: DVec3,
    },
}

/// A shape turned and moved into view space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// What is placed.
    pub shape: Shape,
    /// Rotation from the shape's coordinates to view space.
    pub view_from_shape: DMat3,
    /// Position of the shape's origin in view space.
    pub center_in_view: DVec3,
}

/// What is known of a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Unit normal in view space, facing the viewer.
    pub normal: DVec3,
    /// Cosine between the normal and the direction to the eye.
    pub facing: f64,
    /// Principal curvatures, positive where convex, the larger first.
    pub principal: [f64; 2],
    /// Second derivatives of depth over view x and y, for parallel sight lines.
    pub depth_hessian: DMat2,
}

impl Shape {
    /// Value, gradient and Hessian of the function whose zero set this is.
    fn evaluate(&self, p: DVec3) -> (f64, DVec3, DMat3) {
        let diagonal = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        match *self {
            Shape::Sphere { radius } => (p.dot(p) - radius * radius, 2.0 * p, diagonal(2.0, 2.0, 2.0)),
            Shape::Cylinder { radius } => (
                p.x * p.x + p.z * p.z - radius * radius,
                DVec3::new(2.0 * p.x, 0.0, 2.0 * p.z),
                diagonal(2.0, 0.0, 2.0),
            ),
            Shape::Torus { major, minor } => {
                // (ρ − R)² + z² − r² with ρ the distance from the z axis.
                let rho = p.truncate().length().max(1e-300);
                let u = DVec3::new(p.x / rho, p.y / rho, 0.0);
                let t = DVec3::new(-u.y, u.x, 0.0);
                let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
                let gradient = 2.0 * (rho - major) * u + DVec3::new(0.0, 0.0, 2.0 * p.z);
                let hessian = outer(u) * 2.0 + outer(t) * (2.0 * (rho - major) / rho) + diagonal(0.0, 0.0, 2.0);
                ((rho - major).powi(2) + p.z * p.z - minor * minor, gradient, hessian)
            }
            Shape::Saddle { bend } => (
                p.z - 0.5 * bend * (p.x * p.x - p.y * p.y),
                DVec3::new(-bend * p.x, bend * p.y, 1.0),
                diagonal(-bend, bend, 0.0),
            ),
            Shape::Plane { normal } => (normal.dot(p), normal, DMat3::ZERO),
        }
    }
}

impl Placed {
    fn evaluate(&self, point_in_view: DVec3) -> (f64, DVec3, DMat3) {
        let r = self.view_from_shape;
        let (f, gradient, hessian) = self.shape.evaluate(r.transpose() * (point_in_view - self.center_in_view));
        (f, r * gradient, r * hessian * r.transpose())
    }

    /// What is known at a point of the surface, seen from `to_eye`.
    pub fn known(&self, point_in_view: DVec3, to_eye: DVec3) -> Known {
        let (_, g, h) = self.evaluate(point_in_view);
        let sign = if g.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let length = g.length();
        let trace = h.x_axis.x + h.y_axis.y + h.z_axis.z;
        let sum = sign * (length * length * trace - g.dot(h * g)) / length.powi(3);
        // The adjugate's rows are cross products of the columns.
        let adjugate =
            DMat3::from_cols(h.y_axis.cross(h.z_axis), h.z_axis.cross(h.x_axis), h.x_axis.cross(h.y_axis)).transpose();
        let gauss = g.dot(adjugate * g) / length.powi(4);
        let root = (0.25 * sum * sum - gauss).max(0.0).sqrt();
        let (zx, zy) = (-g.x / g.z, -g.y / g.z);
        let second = |a: usize, b: usize, za: f64, zb: f64| {
            (h.col(a)[b] + h.col(a)[2] * zb + h.col(b)[2] * za + h.col(2)[2] * za * zb) / g.z
        };
        let cross = second(0, 1, zx, zy);
        Known {
            normal: sign * g / length,
            facing: (sign * g / length).dot(to_eye.normalize()),
            principal: [0.5 * sum + root, 0.5 * sum - root],
            // Depth is −z: both minus signs cancel.
            depth_hessian: DMat2::from_cols(
                DVec2::new(second(0, 0, zx, zx), cross),
                DVec2::new(cross, second(1, 1, zy, zy)),
            ),
        }
    }

    /// The store of this surface as part 0, between two depths. Crossings closer than 1/500 of that range may be missed.
    pub fn store(&self, view: &View, depths: [f64; 2]) -> StoreData {
        const STEPS: u32 = 500;
        let mut store = StoreData { width: view.width, height: view.height, ..StoreData::default() };
        for y in 0..view.height {
            for x in 0..view.width {
                store.offsets.push(store.depth.len());
                let at = |depth: f64| self.evaluate(view.position(x, y, depth)).0;
                let depth_of = |step: u32| depths[0] + (depths[1] - depths[0]) * f64::from(step) / f64::from(STEPS);
                let mut before = at(depths[0]);
                for step in 1..=STEPS {
                    let after = at(depth_of(step));
                    if (before < 0.0) != (after < 0.0) {
                        let (mut low, mut high) = (depth_of(step - 1), depth_of(step));
                        for _ in 0..60 {
                            let middle = 0.5 * (low + high);
                            if (at(middle) < 0.0) == (before < 0.0) { low = middle } else { high = middle }
                        }
                        self.push(&mut store, view.position(x, y, low), view, depths);
                    }
                    before = after;
                }
                let first = store.offsets.last().copied().unwrap_or(0);
                store.counts.push((store.depth.len() - first) as u32);
                store.overflowed.push(false);
            }
        }
        store
    }

    fn push(&self, store: &mut StoreData, point: DVec3, view: &View, depths: [f64; 2]) {
        let to_eye = view.to_eye(point);
        let known = self.known(point, to_eye);
        store.depth_key.push(depth_key((depths[1] + point.z) / (depths[1] - depths[0])));
        store.triangle.push(store.depth.len() as u32);
        store.part.push(0);
        store.depth.push(-point.z);
        store.normal.push(known.normal.as_vec3().to_array());
        store.side.push(self.evaluate(point).1.dot(to_eye) >= 0.0);
        store.base_color.push([0.5, 0.5, 0.5, 1.0]);
        store.metallic.push(0.0);
        store.roughness.push(0.5);
        store.occlusion.push(1.0);
        store.emissive.push([0.0; 3]);
        store.unlit.push(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(shape: Shape) -> Placed {
        Placed { shape, view_from_shape: DMat3::from_rotation_y(0.7), center_in_view: DVec3::new(0.1, 0.2, -3.0) }
    }

    fn assert_principal(shape: Shape, point: DVec3, expected: [f64; 2]) {
        let placed = placed(shape);
        let point = placed.view_from_shape * point + placed.center_in_view;
        let towards = placed.evaluate(point).1;
        let principal = placed.known(point, towards).principal;
        assert!((0..2).all(|i| (principal[i] - expected[i]).abs() < 1e-9), "{shape:?}: {principal:?}");
        let inside = placed.known(point, -towards).principal;
        assert!((inside[0] + expected[1]).abs() < 1e-9, "concave from inside");
    }

    #[test]
    fn principal_curvatures_are_the_textbook_ones() {
        assert_principal(Shape::Sphere { radius: 0.5 }, DVec3::new(0.3, 0.0, 0.4), [2.0, 2.0]);
        assert_principal(Shape::Cylinder { radius: 0.5 }, DVec3::new(0.3, 7.0, 0.4), [2.0, 0.0]);
        let torus = Shape::Torus { major: 1.0, minor: 0.25 };
        assert_principal(torus, DVec3::new(1.25, 0.0, 0.0), [4.0, 0.8]);
        assert_principal(torus, DVec3::new(0.0, 0.75, 0.0), [4.0, -4.0 / 3.0]);
        assert_principal(torus, DVec3::new(1.0, 0.0, 0.25), [4.0, 0.0]);
        assert_principal(Shape::Saddle { bend: 3.0 }, DVec3::ZERO, [3.0, -3.0]);
    }

    #[test]
    fn the_depth_hessian_of_a_sphere_is_the_textbook_one() {
        let sphere = Placed {
            shape: Shape::Sphere { radius: 1.0 },
            view_from_shape: DMat3::IDENTITY,
            center_in_view: DVec3::new(0.0, 0.0, -5.0),
        };
        // depth = 5 − √(1 − x² − y²)
        let known = sphere.known(DVec3::new(0.6, 0.0, -4.2), DVec3::Z);
        assert!((known.depth_hessian.x_axis.x - 1.0 / 0.512).abs() < 1e-12);
        assert!((known.depth_hessian.y_axis.y - 1.0 / 0.8).abs() < 1e-12);
        assert!(known.depth_hessian.x_axis.y.abs() < 1e-12);
        assert!((known.facing - 0.8).abs() < 1e-12);
    }
}
