//! Section planes under the hand: pure functions from a plane, a view and a gesture to a plane.
//!
//! A plane has an *anchor*, the middle of where it meets the box around the model; its handle stands there. **Pulling** moves the
//! plane along its normal: how far is solved for on the normal's image, perspective included, so that the handle stays under
//! the pointer. A normal that points nearly at the viewer, or away, has no image to pull along: then up is along the normal
//! and down against it. **Tilting** turns the normal about the anchor. The normal is laid out flat around the line of sight,
//! as far out as it is turned away from it, and goes with the pointer there: no direction is singular but the one that points
//! straight at the back of what is turned. Every gesture is worked out from where it began, so nothing adds up.
//!
//! Positions are in scene space here; [`Section::offset`] is in the file's coordinates.

use std::f64::consts::PI;

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::math::{Bounds, Camera, Projection};
use crate::scene::{Scene, Section};

/// Sine of the angle to the line of sight below which a normal has no image to pull along.
const FACING: f64 = 0.25;
/// A pull towards the vanishing point is followed until a pixel is worth so many times what it was.
const MOST_STRETCHED: f64 = 50.0;
/// Degrees between directions that tilting snaps to.
pub const SNAP: f64 = 15.0;

/// Space as a viewport shows it; pixels from its left top.
#[derive(Clone, Copy, Debug)]
pub struct View {
    camera: Camera,
    clip_from_world: DMat4,
    size: DVec2,
    /// What lies nearer has no place in the picture.
    nearest: f64,
}

impl View {
    /// Through a camera, of a model in `bounds`, `size` pixels large.
    pub fn new(camera: &Camera, bounds: &Bounds, size: [u32; 2]) -> View {
        let clip = camera.clip_from_view(camera.frustum(bounds), size, DVec2::ZERO);
        let nearest = match camera.projection {
            Projection::Perspective { .. } => 1e-4 * camera.distance(),
            Projection::Orthographic { .. } => 0.0,
        };
        View {
            camera: *camera,
            clip_from_world: clip * camera.view_from_world(),
            size: DVec2::from(size.map(f64::from)),
            nearest,
        }
    }

    /// Pixel times weight, and the weight: linear in the point.
    fn homogeneous(&self, point: DVec4) -> DVec3 {
        let clip = self.clip_from_world * point;
        let half = 0.5 * self.size;
        DVec3::new(half.x * (clip.w + clip.x), half.y * (clip.w - clip.y), clip.w)
    }

    /// Where a point is seen; `None` behind the eye.
    pub fn pixel(&self, point: DVec3) -> Option<DVec2> {
        let h = self.homogeneous(point.extend(1.0));
        let at = h.truncate() / h.z;
        (h.z > self.nearest && at.is_finite()).then_some(at)
    }

    /// Where a line is seen: what of it lies before the eye.
    pub fn line(&self, from: DVec3, to: DVec3) -> Option<[DVec2; 2]> {
        let weight = |p: DVec3| self.homogeneous(p.extend(1.0)).z - 2.0 * self.nearest;
        let (a, b) = (weight(from), weight(to));
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let cut = from.lerp(to, (a / (a - b)).clamp(0.0, 1.0));
        let [from, to] = [if a < 0.0 { cut } else { from }, if b < 0.0 { cut } else { to }];
        Some([self.pixel(from)?, self.pixel(to)?])
    }

    /// Pixels of a scene unit that is seen from the front at a point.
    fn scale_at(&self, point: DVec3) -> f64 {
        let depth = self.homogeneous(point.extend(1.0)).z;
        match self.camera.projection {
            Projection::Perspective { fov_y } => 0.5 * self.size.y / ((0.5 * fov_y).tan() * depth),
            Projection::Orthographic { height } => self.size.y / height,
        }
    }

    /// Right, up and towards the viewer, as seen at a point.
    pub fn axes_at(&self, point: DVec3) -> [DVec3; 3] {
        let (right, up, back) = self.camera.axes();
        let back = match self.camera.projection {
            Projection::Perspective { .. } => (self.camera.position - point).try_normalize().unwrap_or(back),
            Projection::Orthographic { .. } => back,
        };
        let right = up.cross(back).try_normalize().unwrap_or(right);
        [right, back.cross(right), back]
    }
}

/// The box around a model where its parts are, in the file's coordinates.
pub fn in_file(bounds: &Bounds, scene: &Scene) -> Bounds {
    if bounds.is_empty() {
        return Bounds::of_points([scene.origin]);
    }
    Bounds { min: bounds.min + scene.origin, max: bounds.max + scene.origin }
}

/// Least and most of normal · x in a box: where planes of this direction meet it.
pub fn range_of(bounds: &Bounds, normal: DVec3) -> [f64; 2] {
    let along = bounds.corners().map(|c| normal.dot(c));
    [along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// Where a plane meets a box: the corners of a convex polygon, in order, none if they do not meet.
pub fn outline(bounds: &Bounds, normal: DVec3, offset: f64) -> Vec<DVec3> {
    let center = bounds.center();
    let middle = center + normal * (offset - normal.dot(center));
    let reach = bounds.size().length() + (middle - center).length();
    let across = normal.any_orthonormal_vector();
    let along = normal.cross(across);
    // A square that is larger than the box, cut by each of its sides.
    let mut polygon: Vec<DVec3> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(u, v)| middle + reach * (u * across + v * along))
        .into();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for (side, limit) in [(axis, axis.dot(bounds.max)), (-axis, -axis.dot(bounds.min))] {
            let beyond = |p: DVec3| side.dot(p) - limit;
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (i, &to) in polygon.iter().enumerate() {
                let from = polygon[(i + polygon.len() - 1) % polygon.len()];
                let (a, b) = (beyond(from), beyond(to));
                if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                    kept.push(from.lerp(to, a / (a - b)));
                }
                if b <= 0.0 {
                    kept.push(to);
                }
            }
            polygon = kept;
        }
    }
    polygon
}

/// The middle of a convex polygon: of its area, or of its corners if it has none; `None` of none.
pub fn middle_of(polygon: &[DVec3]) -> Option<DVec3> {
    let first = *polygon.first()?;
    let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
    for pair in polygon[1..].windows(2) {
        let area = (pair[0] - first).cross(pair[1] - first).length();
        sum += area * (first + pair[0] + pair[1]) / 3.0;
        whole += area;
    }
    let mean = polygon.iter().copied().sum::<DVec3>() / polygon.len() as f64;
    Some(if whole > 0.0 { sum / whole } else { mean })
}

/// How a plane is pulled along its normal at an anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Direction on the screen along which pulling moves the plane towards its normal: unit length, y down.
    pub toward: DVec2,
    /// Whether that is up because the normal has no image.
    pub facing: bool,
    /// Pixels that the first scene unit is worth.
    first: f64,
    /// Weight of the anchor, and what a unit along the normal adds to it.
    weight: [f64; 2],
}

impl Pull {
    /// For a plane with this normal at an anchor; `None` if that is behind the eye.
    pub fn new(view: &View, anchor: DVec3, normal: DVec3) -> Option<Pull> {
        let at = view.pixel(anchor)?;
        let weight = view.homogeneous(anchor.extend(1.0)).z;
        let along = view.homogeneous(normal.extend(0.0));
        let image = (along.truncate() - at * along.z) / weight;
        let scale = view.scale_at(anchor);
        let sine = normal.cross(view.axes_at(anchor)[2]).length();
        if sine >= FACING && image.length() > 0.5 * FACING * scale {
            let first = image.length();
            Some(Pull { toward: image / first, facing: false, first, weight: [weight, along.z] })
        } else {
            Some(Pull { toward: DVec2::NEG_Y, facing: true, first: scale, weight: [weight, 0.0] })
        }
    }

    /// How far the plane moves along its normal, scene units, when the pointer goes this way, pixels.
    pub fn distance(&self, way: DVec2) -> f64 {
        let (way, [weight, more]) = (way.dot(self.toward), self.weight);
        // (anchor + t · normal) projects to anchor + way; weights are linear in t.
        let slope = weight * self.first;
        way * weight / (slope - way * more).max(slope / MOST_STRETCHED)
    }
}

/// A plane moved along its normal, within where it meets a box in the file's coordinates.
#[must_use]
pub fn moved(section: &Section, bounds: &Bounds, by: f64) -> Section {
    let [least, most] = range_of(bounds, section.normal);
    let offset = section.offset + by;
    Section { offset: if offset.is_finite() { offset.clamp(least, most) } else { section.offset }, ..*section }
}

/// A normal as it is turned when the pointer goes this way: right and down, in units of which π/2 lead from facing the viewer
/// to facing sideways. `axes` are those of [`View::axes_at`].
pub fn tilted(normal: DVec3, axes: [DVec3; 3], way: DVec2) -> DVec3 {
    let [right, up, back] = axes;
    let (flat, toward) = (DVec2::new(right.dot(normal), up.dot(normal)), back.dot(normal));
    // What points away is seen from behind.
    let side = if toward < -1e-9 { -1.0 } else { 1.0 };
    let out = flat.normalize_or_zero() * flat.length().atan2(side * toward);
    let out = (out + DVec2::new(way.x, -way.y)).clamp_length_max(PI);
    let flat = out.normalize_or_zero() * out.length().sin();
    let turned = right * flat.x + up * flat.y + back * (side * out.length().cos());
    turned.try_normalize().unwrap_or(normal)
}

/// The nearest direction whose angles, up from the ground and around the file's vertical axis, are multiples of [`SNAP`].
pub fn snapped(normal: DVec3) -> DVec3 {
    let nearest = |angle: f64| ((angle.to_degrees() / SNAP).round() * SNAP).to_radians();
    let rise = nearest(normal.y.clamp(-1.0, 1.0).asin());
    let turn = nearest(normal.x.atan2(normal.z));
    let clean = |v: f64| if v.abs() < 1e-12 { 0.0 } else { v };
    DVec3::new(clean(rise.cos() * turn.sin()), clean(rise.sin()), clean(rise.cos() * turn.cos())).normalize()
}

/// The plane through a point, in the file's coordinates, with another normal.
#[must_use]
pub fn about(section: &Section, point: DVec3, normal: DVec3) -> Section {
    Section { normal, offset: normal.dot(point), ..*section }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks along −z from z = 10 at the origin, 100 × 100 pixels, 10 of them a unit there.
    fn view(perspective: bool) -> View {
        let projection = if perspective {
            Projection::Perspective { fov_y: 2.0 * 0.5_f64.atan() }
        } else {
            Projection::Orthographic { height: 10.0 }
        };
        let camera = Camera { position: DVec3::Z * 10.0, focal_point: DVec3::ZERO, view_up: DVec3::Y, projection };
        View::new(&camera, &Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE }, [100, 100])
    }

    fn close(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-9
    }

    #[test]
    fn a_plane_meets_a_box_in_a_polygon() {
        let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        let square = outline(&unit, DVec3::X, 0.25);
        assert_eq!(square.len(), 4);
        assert!(square.iter().all(|p| p.x == 0.25) && close(middle_of(&square).unwrap(), DVec3::new(0.25, 0.5, 0.5)));
        let n = DVec3::ONE.normalize();
        let at = |sum: f64| outline(&unit, n, sum / 3.0_f64.sqrt());
        // Halfway: a regular hexagon through the middles of six edges.
        let hexagon = at(1.5);
        assert_eq!(hexagon.len(), 6);
        for (i, p) in hexagon.iter().enumerate() {
            assert!(((*p - hexagon[(i + 1) % 6]).length() - 0.5_f64.sqrt()).abs() < 1e-9, "{hexagon:?}");
        }
        assert!(close(middle_of(&hexagon).unwrap(), DVec3::splat(0.5)));
        // A corner cut off: (½, 0, 0), (0, ½, 0), (0, 0, ½), with the middle at a third of their sum.
        assert_eq!(at(0.5).len(), 3);
        assert!(close(middle_of(&at(0.5)).unwrap(), DVec3::splat(1.0 / 6.0)));
        assert!(at(3.5).is_empty() && at(-0.5).is_empty() && middle_of(&[]).is_none());
        // In the plane of a face it is that face; a flat box has a middle too.
        assert_eq!(outline(&unit, DVec3::Y, 1.0).len(), 4);
        let flat = Bounds { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 0.0) };
        let line = outline(&flat, DVec3::X, 1.0);
        assert!(close(middle_of(&line).unwrap(), DVec3::new(1.0, 2.0, 0.0)), "{line:?}");
    }

    #[test]
    fn points_and_lines_are_where_they_are_seen() {
        for perspective in [false, true] {
            let v = view(perspective);
            assert!((v.pixel(DVec3::new(2.0, 1.0, 0.0)).unwrap() - DVec2::new(70.0, 40.0)).length() < 1e-9);
        }
        let v = view(true);
        assert_eq!(v.pixel(DVec3::Z * 11.0), None);
        // Of a line that goes past the eye what is in front of it is left.
        let [from, to] = v.line(DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 20.0)).unwrap();
        assert!((from - DVec2::new(60.0, 50.0)).length() < 1e-9 && to.x > 1e4 && (to.y - 50.0).abs() < 1e-6);
        assert_eq!(v.line(DVec3::Z * 11.0, DVec3::new(1.0, 0.0, 11.0)), None);
    }

    #[test]
    fn a_pull_moves_the_plane_with_the_pointer() {
        for perspective in [false, true] {
            let v = view(perspective);
            let right = Pull::new(&v, DVec3::ZERO, DVec3::X).unwrap();
            assert!((right.toward - DVec2::X).length() < 1e-9 && !right.facing);
            assert!((right.distance(DVec2::new(30.0, 99.0)) - 3.0).abs() < 1e-9, "30 pixels to the right are 3 units");
            assert!((right.distance(DVec2::new(-10.0, 0.0)) + 1.0).abs() < 1e-9);
            // Straight at the viewer, or away: up is along it, 10 pixels a unit.
            for normal in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.1, 0.1, -1.0).normalize()] {
                let facing = Pull::new(&v, DVec3::ZERO, normal).unwrap();
                assert!(facing.facing && (facing.distance(DVec2::new(40.0, -20.0)) - 2.0).abs() < 1e-9, "{normal}");
                assert!((facing.distance(DVec2::new(0.0, 5.0)) + 0.5).abs() < 1e-9);
            }
        }
        // Towards the viewer and to the right: after 2√2 units it is at (2, 0, 2), 8 before the eye, and 2 there is where a
        // quarter is at 1: 25 pixels from the middle. The way back to 25 on the other side is to x = −10/3.
        let slanted = Pull::new(&view(true), DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0).normalize()).unwrap();
        assert!((slanted.distance(DVec2::X * 25.0) - 2.0 * 2.0_f64.sqrt()).abs() < 1e-9);
        assert!((slanted.distance(DVec2::X * -25.0) + 2.0_f64.sqrt() * 10.0 / 3.0).abs() < 1e-9);
        // Beyond the vanishing point (100 pixels to the left) it goes on moving the same way.
        let far = slanted.distance(DVec2::X * -500.0);
        assert!(far.is_finite() && far < slanted.distance(DVec2::X * -95.0), "{far}");
        assert_eq!(Pull::new(&view(true), DVec3::Z * 12.0, DVec3::X), None);
    }

    #[test]
    fn a_plane_stays_on_the_model() {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 6.0) };
        let section = Section { normal: DVec3::NEG_Y, offset: -1.0, enabled: true, caps: false };
        assert_eq!(moved(&section, &bounds, -0.5).offset, -1.5);
        assert_eq!(moved(&section, &bounds, -50.0).offset, -4.0);
        assert_eq!(moved(&section, &bounds, 50.0).offset, 0.0);
        assert_eq!(moved(&section, &bounds, f64::NAN), section);
        let turned = about(&section, DVec3::new(1.0, 2.0, 3.0), DVec3::Z);
        assert_eq!(turned, Section { normal: DVec3::Z, offset: 3.0, ..section });
    }

    #[test]
    fn a_tilt_goes_with_the_pointer() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let quarter = 0.5 * PI;
        for (normal, way, expected) in [
            // Facing the viewer: to the right, up, and halfway.
            (DVec3::Z, DVec2::new(quarter, 0.0), DVec3::X),
            (DVec3::Z, DVec2::new(0.0, -quarter), DVec3::Y),
            (DVec3::Z, DVec2::new(0.5 * quarter, 0.0), DVec3::new(1.0, 0.0, 1.0).normalize()),
            // From the right inwards it comes to face the viewer; outwards it turns away.
            (DVec3::X, DVec2::new(-quarter, 0.0), DVec3::Z),
            (DVec3::X, DVec2::new(0.5 * quarter, 0.0), DVec3::new(1.0, 0.0, -1.0).normalize()),
            // Facing away, it still goes where the pointer does.
            (DVec3::NEG_Z, DVec2::new(quarter, 0.0), DVec3::X),
            (DVec3::NEG_Z, DVec2::new(0.0, quarter), DVec3::NEG_Y),
            (DVec3::X, DVec2::ZERO, DVec3::X),
        ] {
            let turned = tilted(normal, axes, way);
            assert!(close(turned, expected), "{normal} by {way}: {turned}");
        }
        // Across from the side it swings in the picture's plane towards the pointer, and stays a unit vector.
        let swung = tilted(DVec3::X, axes, DVec2::new(0.0, -0.3));
        assert!(swung.y > 0.1 && (swung.length() - 1.0).abs() < 1e-12);
        assert!((tilted(DVec3::Z, axes, DVec2::splat(1e9)).length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn tilts_snap_to_whole_steps_and_axes_exactly() {
        assert_eq!(snapped(DVec3::new(0.99, 0.05, 0.1).normalize()), DVec3::X);
        assert_eq!(snapped(DVec3::new(0.02, -0.99, 0.1).normalize()), DVec3::NEG_Y);
        assert_eq!(snapped(DVec3::new(-0.1, 0.1, -1.0).normalize()), DVec3::NEG_Z);
        let half = snapped(DVec3::new(1.0, 0.1, 1.1).normalize());
        assert!(close(half, DVec3::new(0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt())), "{half}");
        // 30 degrees up, 60 degrees around from z towards x.
        let up = snapped(DVec3::new(0.76, 0.51, 0.42).normalize());
        assert!(close(up, DVec3::new(0.75, 0.5, 0.25 * 3.0_f64.sqrt())), "{up}");
    }

    #[test]
    fn axes_are_those_of_the_place() {
        let [right, up, back] = view(true).axes_at(DVec3::new(10.0, 0.0, 0.0));
        assert!(close(back, DVec3::new(-1.0, 0.0, 1.0).normalize()) && close(up, DVec3::Y));
        assert!(close(right, DVec3::new(1.0, 0.0, 1.0).normalize()));
        assert_eq!(view(false).axes_at(DVec3::X * 10.0), [DVec3::X, DVec3::Y, DVec3::Z]);
    }
}
