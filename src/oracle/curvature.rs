//! Curvature of every fragment, from normals and positions along its links.
//!
//! Murray 2016 (section 5.1) takes principal curvatures from the screen-space gradient of normals, as Vergne 2009 does,
//! and shows `κ = tanh(κ₁ + κ₂)`, −1 convex and +1 concave; a missing neighbour is a rim, κ = −1. Here the gradient is a
//! linear regression over up to m samples each way along the links (T31), and there are two kinds:
//! - `ViewCentred`, the paper's: the gradient of `n.xy / n.z`, which is the Hessian of depth;
//! - `Surface`: the shape operator, the change of the normal over the change of the position in the tangent plane (T8).
//!
//! Sharp edges (neighbouring normals farther apart than the crease angle) end the regression and are drawn as lines of
//! the set width, convex or concave; so are rims. With radius 0, crease angle 180° and line width 0 all of this is the
//! paper as printed.
//!
//! # Choices
//! - All regressions of `Surface` are in the tangent plane: `dP` and `dN` are the two-component columns of A and B, also
//!   in the test of `|det A|` and along a single axis. An axis along which the position does not change is absent.
//! - The tangent frame is Duff's (2017): `s = 1` if `n.z ≥ 0`, else −1, `a = −1 / (s + n.z)`, `b = n.x n.y a`,
//!   `e₁ = (1 + s n.x² a, s b, −s n.x)`, `e₂ = (b, s + n.y² a, −n.y)`. For `ViewCentred` the frame is view x and y.
//! - With only one axis, `ViewCentred` has a zero column for the other.
//! - h of a crease is the *height* of a pixel at the fragment. Pixels are square.
//! - Where two nearly parallel axes are averaged, the operator is the mean of their projectors' terms too, so that its
//!   trace is the sum that is reported.
//! - A dot product of normals is clamped to [−1, 1] before it is compared, so 180° never finds a crease.

use glam::{DMat2, DVec2, DVec3, Vec3};

use super::neighbours::{Direction, Link, Neighbours};
use super::store::StoreData;
use super::view::{Extents, View};
use crate::settings::{CurvatureKind, CurvatureSettings, CurvatureUnit};

/// Curvature of all fragments, by fragment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curvature {
    /// κ in [−1, 1] with creases and rims: −1 convex, +1 concave.
    pub kappa: Vec<f64>,
    /// κ₁ + κ₂ (or the Laplacian of depth) in 1 / scene unit, positive where convex, without creases, rims and scale.
    pub sum: Vec<f64>,
    /// The symmetric 2×2 operator (xx, xy, yy) in the frame of the module's text, 1 / scene unit.
    pub operator: Vec<[f64; 3]>,
    /// Whether a threshold (crease angle, crease sign, degenerate frame) is so close that the other answer passes too.
    pub ambiguous: Vec<bool>,
}

/// One sample of the regression: steps along the axis, and normal and position less the fragment's own.
#[derive(Clone, Copy)]
struct Sample {
    s: f64,
    normal: DVec3,
    position: DVec3,
}

/// A sharp edge, `distance` steps away.
#[derive(Clone, Copy)]
struct Crease {
    distance: u32,
    angle: f64,
    convex: bool,
}

/// What the four walks from a fragment find.
#[derive(Default)]
struct Surroundings {
    /// Samples along x and y, the fragment itself not included.
    samples: [Vec<Sample>; 2],
    rim: Option<u32>,
    crease: Option<Crease>,
    ambiguous: bool,
}

/// Estimates the curvature of every fragment from its links.
pub fn curvature(
    store: &StoreData,
    neighbours: &Neighbours,
    view: &View,
    extents: &Extents,
    settings: &CurvatureSettings,
) -> Curvature {
    let frame = Frame::new(store, view, settings);
    let mut result = Curvature::default();
    for i in 0..store.len() {
        let around = frame.walk(store, neighbours, i);
        let (n, pixel) = (frame.normals[i], view.pixel_size(store.depth[i]));
        let (operator, sum, near_degenerate) = match settings.kind {
            CurvatureKind::Surface => surface(n, &around.samples),
            CurvatureKind::ViewCentred => view_centred(n, &around.samples, pixel),
        };
        let unit = match settings.unit {
            CurvatureUnit::View => extents.visible_height,
            CurvatureUnit::Part => extents.part_radius(store.part[i]),
            CurvatureUnit::Scene => extents.scene_radius,
            CurvatureUnit::World => 1.0,
        };
        let scale = settings.scale * unit;
        let mut kappa = (-scale * sum).clamp(-20.0, 20.0).tanh();
        if let Some(crease) = around.crease {
            let strength = (scale * crease.angle / (frame.line * pixel.y)).min(20.0).tanh();
            let edge = if crease.convex { -strength } else { strength };
            let coverage = (0.5 * frame.line + 0.5 - f64::from(crease.distance - 1)).clamp(0.0, 1.0);
            kappa += (edge - kappa) * coverage;
        }
        if let Some(distance) = around.rim {
            let coverage = (frame.line - f64::from(distance - 1)).clamp(0.0, 1.0);
            kappa += (-1.0 - kappa) * coverage;
        }
        result.kappa.push(kappa);
        result.sum.push(sum);
        result.operator.push([operator.x_axis.x, operator.x_axis.y, operator.y_axis.y]);
        result.ambiguous.push(around.ambiguous || near_degenerate);
    }
    result
}

/// What all fragments of a picture share.
struct Frame {
    width: usize,
    height: usize,
    pixel_of: Vec<usize>,
    normals: Vec<DVec3>,
    positions: Vec<DVec3>,
    /// Samples each way.
    m: u32,
    /// Steps each way.
    reach: u32,
    /// Width of lines in pixels.
    line: f64,
    cos_crease: f64,
}

impl Frame {
    fn new(store: &StoreData, view: &View, settings: &CurvatureSettings) -> Frame {
        let shorter = f64::from(store.width.min(store.height));
        let m = (settings.radius * shorter).round().max(1.0) as u32;
        let line = (settings.line_width * shorter).max(1.0);
        let pixel_of = store.pixel_of_fragment();
        let positions = (0..store.len())
            .map(|i| {
                let (x, y) = store.xy(pixel_of[i]);
                view.position(x, y, store.depth[i])
            })
            .collect();
        Frame {
            width: store.width.max(1) as usize,
            height: store.height as usize,
            normals: store.normal.iter().map(|&n| Vec3::from(n).as_dvec3()).collect(),
            positions,
            pixel_of,
            m,
            reach: m.max(line.ceil() as u32),
            line,
            cos_crease: settings.crease_angle.to_radians().cos(),
        }
    }

    fn walk(&self, store: &StoreData, neighbours: &Neighbours, i: usize) -> Surroundings {
        let mut around = Surroundings::default();
        for direction in Direction::ALL {
            let d = direction as usize;
            let sign = if matches!(direction, Direction::Right | Direction::Down) { 1.0 } else { -1.0 };
            let mut a = i;
            for step in 1..=self.reach {
                let b = match neighbours.links[a][d] {
                    Link::Unknown => break,
                    Link::Missing => {
                        around.rim = Some(around.rim.map_or(step, |r| r.min(step)));
                        break;
                    }
                    Link::To(layer) => {
                        let Some(q) = direction.step(self.pixel_of[a], self.width, self.height) else { break };
                        let b = store.offsets[q] + layer as usize;
                        // A read-back may be damaged: a link to nowhere is no link.
                        if b >= store.range(q).end {
                            break;
                        }
                        b
                    }
                };
                let cos = self.normals[a].dot(self.normals[b]).clamp(-1.0, 1.0);
                around.ambiguous |= (cos - self.cos_crease).abs() < 1e-6;
                if cos < self.cos_crease {
                    let (turn, way) = (self.normals[b] - self.normals[a], self.positions[b] - self.positions[a]);
                    if around.crease.is_none_or(|c| step < c.distance) {
                        around.ambiguous |= turn.dot(way).abs() < 1e-5 * turn.length() * way.length();
                        around.crease = Some(Crease { distance: step, angle: cos.acos(), convex: turn.dot(way) > 0.0 });
                    }
                    break;
                }
                if step <= self.m {
                    around.samples[d / 2].push(Sample {
                        s: sign * f64::from(step),
                        normal: self.normals[b] - self.normals[i],
                        position: self.positions[b] - self.positions[i],
                    });
                }
                a = b;
            }
        }
        around
    }
}

/// Least-squares slope over `s` of values that are zero at the fragment itself (s = 0); `None` without other samples.
fn slope(samples: &[Sample], value: impl Fn(&Sample) -> DVec3) -> Option<DVec3> {
    if samples.is_empty() {
        return None;
    }
    let n = samples.len() as f64 + 1.0;
    let s1: f64 = samples.iter().map(|sample| sample.s).sum();
    let s2: f64 = samples.iter().map(|sample| sample.s * sample.s).sum();
    let mean = samples.iter().map(&value).sum::<DVec3>() / n;
    let product: DVec3 = samples.iter().map(|sample| value(sample) * sample.s).sum();
    Some((product - mean * s1) / (s2 - s1 * s1 / n))
}

/// Duff's orthonormal frame of the plane perpendicular to a unit vector.
pub fn tangent_frame(n: DVec3) -> [DVec3; 2] {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    [DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), DVec3::new(b, s + n.y * n.y * a, -n.y)]
}

/// The shape operator, its trace, and whether the choice between two formulas was close.
fn surface(n: DVec3, samples: &[Vec<Sample>; 2]) -> (DMat2, f64, bool) {
    let [e1, e2] = tangent_frame(n);
    let flat = |v: DVec3| DVec2::new(v.dot(e1), v.dot(e2));
    // Changes of position and normal per pixel, for each axis that is there.
    let axes: Vec<(DVec2, DVec2)> = samples
        .iter()
        .filter_map(|s| Some((flat(slope(s, |s| s.position)?), flat(slope(s, |s| s.normal)?))))
        .filter(|(dp, _)| dp.length_squared() > 0.0)
        .collect();
    let mut close = false;
    if let [(pu, nu), (pv, nv)] = axes[..] {
        let a = DMat2::from_cols(pu, pv);
        let limit = pu.length() * pv.length();
        close = (a.determinant().abs() - 1e-4 * limit).abs() < 1e-5 * limit;
        if a.determinant().abs() >= 1e-4 * limit {
            let s = DMat2::from_cols(nu, nv) * a.inverse();
            let s = (s + s.transpose()) * 0.5;
            return (s, s.x_axis.x + s.y_axis.y, close);
        }
    }
    if axes.is_empty() {
        return (DMat2::ZERO, 0.0, close);
    }
    let mut s = DMat2::ZERO;
    for &(dp, dn) in &axes {
        let t = dp.normalize();
        s += DMat2::from_cols(t * t.x, t * t.y) * (dn.dot(dp) / dp.length_squared());
    }
    s *= 1.0 / axes.len() as f64;
    (s, s.x_axis.x + s.y_axis.y, close)
}

/// The Hessian of depth, as the gradient of n.xy / n.z, and its trace.
fn view_centred(n: DVec3, samples: &[Vec<Sample>; 2], pixel: DVec2) -> (DMat2, f64, bool) {
    let g = |n: DVec3| (n.truncate() / n.z.max(0.05)).extend(0.0);
    let own = g(n);
    let along = |axis: usize| slope(&samples[axis], |s| g(n + s.normal) - own).map_or(DVec2::ZERO, DVec3::truncate);
    // View y is up, image y down.
    let h = DMat2::from_cols(along(0) / pixel.x, -along(1) / pixel.y);
    let h = (h + h.transpose()) * 0.5;
    (h, h.x_axis.x + h.y_axis.y, false)
}

#[cfg(test)]
#[path = "curvature_tests.rs"]
mod tests;
