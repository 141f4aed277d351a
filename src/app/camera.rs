//! Moving the camera by hand: pure functions from a camera and a gesture to a camera.
//!
//! Turning is a turntable about the vertical axis of the file, which keeps the horizon level, or a trackball that turns as the
//! hand pulls. Either turns about a *pivot* that need not lie in the middle of the picture: what is under it stays there.
//! Zooming keeps what is under the cursor, at the depth of the focal point, where it is.

use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::math::views::{VIEW_ANGLE, VIEWS, ZOOM_FACTOR};
use crate::math::{Bounds, Camera, Projection};

/// The file's vertical axis (glTF).
const VERTICAL: DVec3 = DVec3::Y;
/// Degrees that a drag across the whole height turns.
const DEGREES_ACROSS: f64 = 270.0;
/// A turntable stops so many degrees before the pole.
const POLE_MARGIN: f64 = 0.05;

/// Whose habits the mouse follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Habits {
    /// Left turns, middle or Shift+left moves, right zooms.
    #[default]
    F3d,
    /// Middle turns, Shift+middle moves, Ctrl+middle zooms; Alt+left turns where there is no middle button.
    Blender,
    /// Middle or right turns as a trackball, Ctrl with it moves, Shift with it zooms.
    Cad,
}

impl Habits {
    /// All of them, with what they are called.
    pub const ALL: [(Habits, &'static str); 3] =
        [(Habits::F3d, "f3d"), (Habits::Blender, "Blender"), (Habits::Cad, "CAD")];
}

/// A mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Left.
    Left,
    /// Middle, or the wheel pressed.
    Middle,
    /// Right.
    Right,
}

/// Keys held during a drag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// Shift.
    pub shift: bool,
    /// Ctrl or Command.
    pub ctrl: bool,
    /// Alt.
    pub alt: bool,
}

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Turns with a level horizon.
    Turntable,
    /// Turns as pulled.
    Trackball,
    /// Moves with the cursor.
    Pan,
    /// Zooms about the place where the drag began.
    Zoom,
}

/// What a drag with this button means, if anything.
pub fn motion(habits: Habits, button: Button, held: Held) -> Option<Motion> {
    match (habits, button) {
        (Habits::F3d, Button::Left) if held.shift => Some(Motion::Pan),
        (Habits::F3d, Button::Left) => Some(Motion::Turntable),
        (Habits::F3d, Button::Middle) => Some(Motion::Pan),
        (Habits::F3d, Button::Right) => Some(Motion::Zoom),
        (Habits::Blender, Button::Left) if !held.alt => None,
        (Habits::Blender, Button::Right) => None,
        (Habits::Blender, _) if held.shift => Some(Motion::Pan),
        (Habits::Blender, _) if held.ctrl => Some(Motion::Zoom),
        (Habits::Blender, _) => Some(Motion::Turntable),
        (Habits::Cad, Button::Left) => None,
        (Habits::Cad, _) if held.ctrl => Some(Motion::Pan),
        (Habits::Cad, _) if held.shift => Some(Motion::Zoom),
        (Habits::Cad, _) => Some(Motion::Trackball),
    }
}

/// The viewport that gestures are measured in, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Width and height.
    pub size: DVec2,
}

impl Frame {
    /// Width over height.
    pub fn aspect(self) -> f64 {
        self.size.x.max(1.0) / self.size.y.max(1.0)
    }

    /// The point under a pixel, at the depth of the focal point.
    pub fn point_at(self, camera: &Camera, pixel: DVec2) -> DVec3 {
        let (right, up, _) = camera.axes();
        let per_pixel = camera.visible_height() / self.size.y.max(1.0);
        let offset = (pixel - self.size * 0.5) * per_pixel;
        camera.focal_point + right * offset.x - up * offset.y
    }
}

fn turned(camera: &Camera, pivot: DVec3, rotation: DMat3) -> Camera {
    Camera {
        position: pivot + rotation * (camera.position - pivot),
        focal_point: pivot + rotation * (camera.focal_point - pivot),
        view_up: (rotation * camera.view_up).normalize_or(camera.view_up),
        projection: camera.projection,
    }
}

/// Whether a camera can be looked through: finite, away from its focal point, upright, with an angle or height above 0.
pub fn is_sound(camera: &Camera) -> bool {
    let toward = camera.focal_point - camera.position;
    let opening = match camera.projection {
        Projection::Perspective { fov_y } => fov_y > 0.0 && fov_y < std::f64::consts::PI,
        Projection::Orthographic { height } => height > 0.0 && height.is_finite(),
    };
    let finite = [camera.position, camera.focal_point, camera.view_up].iter().all(|v| v.is_finite());
    let upright = camera.view_up.normalize_or_zero().cross(toward.normalize_or_zero()).length() > 1e-9;
    finite && toward.length() > 0.0 && upright && opening
}

/// Turns about the vertical line through a pivot.
pub fn spun(camera: &Camera, pivot: DVec3, degrees: f64) -> Camera {
    // No product where nothing turns: the first picture is the one that is seen.
    if degrees == 0.0 { *camera } else { turned(camera, pivot, DMat3::from_axis_angle(VERTICAL, degrees.to_radians())) }
}

/// The same view with a point in the middle of the picture.
pub fn centred(camera: &Camera, point: DVec3) -> Camera {
    let shift = point - camera.focal_point;
    Camera { position: camera.position + shift, focal_point: point, ..*camera }
}

/// Turns about a pivot by a drag of `delta` pixels, horizon level.
pub fn turntable(camera: &Camera, pivot: DVec3, frame: Frame, delta: DVec2) -> Camera {
    let degrees = delta * (DEGREES_ACROSS / frame.size.y.max(1.0));
    let (right, up, back) = camera.axes();
    // Upside down, the hand still pulls what it sees.
    let side = if up.dot(VERTICAL) < -1e-9 { -1.0 } else { 1.0 };
    let about = DMat3::from_axis_angle(VERTICAL, (-degrees.x * side).to_radians());
    let height = back.dot(VERTICAL).clamp(-1.0, 1.0).asin().to_degrees();
    // At a pole up is horizontal, and the way down leads along it.
    let most = 90.0 - POLE_MARGIN;
    let wanted = (height + degrees.y * side).clamp(-most, most);
    let over = DMat3::from_axis_angle(right, ((height - wanted) * side).to_radians());
    let mut next = turned(camera, pivot, about * over);
    let (next_right, _, next_back) = next.axes();
    // The horizon is made level again: a file's camera may have been tilted.
    let level = next_back.cross(VERTICAL.cross(next_back)).try_normalize();
    if let Some(level) = level
        && next_right.dot(VERTICAL).abs() > 1e-12
    {
        next.view_up = level * if next.view_up.dot(level) < 0.0 { -1.0 } else { 1.0 };
    }
    next
}

/// Turns about a pivot by a drag of `delta` pixels, as a ball would.
pub fn trackball(camera: &Camera, pivot: DVec3, frame: Frame, delta: DVec2) -> Camera {
    let (right, up, _) = camera.axes();
    let axis = right * delta.y + up * delta.x;
    match axis.try_normalize() {
        None => *camera,
        Some(axis) => {
            let angle = -(delta.length() * DEGREES_ACROSS / frame.size.y.max(1.0)).to_radians();
            turned(camera, pivot, DMat3::from_axis_angle(axis, angle))
        }
    }
}

/// Moves the picture with the cursor by `delta` pixels; exact at the depth of the focal point.
pub fn pan(camera: &Camera, frame: Frame, delta: DVec2) -> Camera {
    let (right, up, _) = camera.axes();
    let per_pixel = camera.visible_height() / frame.size.y.max(1.0);
    let shift = (up * delta.y - right * delta.x) * per_pixel;
    Camera { position: camera.position + shift, focal_point: camera.focal_point + shift, ..*camera }
}

/// Makes what is seen smaller by `factor` (below 1: larger) about a pixel. Stays between a ten-thousandth of the scene and a
/// thousand times its size.
pub fn zoom(camera: &Camera, frame: Frame, pixel: DVec2, factor: f64, bounds: &Bounds) -> Camera {
    let radius = match bounds.bounding_sphere().radius {
        r if r > 0.0 => r,
        _ => 1.0,
    };
    let height = camera.visible_height();
    if !(factor > 0.0 && factor.is_finite() && height > 0.0) {
        return *camera;
    }
    let factor = (height * factor).clamp(radius * 1e-4, radius * 1e3) / height;
    let center = frame.point_at(camera, pixel);
    let toward = |p: DVec3| center + (p - center) * factor;
    match camera.projection {
        Projection::Perspective { .. } => {
            Camera { position: toward(camera.position), focal_point: toward(camera.focal_point), ..*camera }
        }
        Projection::Orthographic { height } => {
            let shift = toward(camera.focal_point) - camera.focal_point;
            Camera {
                position: camera.position + shift,
                focal_point: camera.focal_point + shift,
                projection: Projection::Orthographic { height: height * factor },
                ..*camera
            }
        }
    }
}

/// The factor of a drag of so many pixels downwards.
pub fn zoom_of_drag(frame: Frame, down: f64) -> f64 {
    (3.0 * down / frame.size.y.max(1.0)).exp()
}

/// The factor of turning the wheel by so many notches away from the hand.
pub fn zoom_of_wheel(notches: f64) -> f64 {
    0.85_f64.powf(notches)
}

/// Parallel instead of perspective or the reverse; what lies at the focal point keeps its size.
pub fn other_projection(camera: &Camera) -> Camera {
    let height = camera.visible_height();
    match camera.projection {
        Projection::Perspective { .. } => Camera { projection: Projection::Orthographic { height }, ..*camera },
        Projection::Orthographic { .. } => {
            let fov_y = VIEW_ANGLE.to_radians();
            let distance = height * 0.5 / (fov_y * 0.5).tan();
            let position = camera.focal_point - camera.direction() * distance;
            Camera { position, projection: Projection::Perspective { fov_y }, ..*camera }
        }
    }
}

/// The same direction and projection with all of `bounds` in the picture.
pub fn framed(camera: &Camera, bounds: &Bounds, aspect: f64) -> Camera {
    along(camera, bounds, aspect, camera.direction(), camera.view_up)
}

/// A named view ([`VIEWS`]) of `bounds`, with the projection of `camera`; `opposite` looks from the other side.
pub fn named(camera: &Camera, bounds: &Bounds, aspect: f64, name: &str, opposite: bool) -> Option<Camera> {
    let other = |name| match name {
        "front" => Some("back"),
        "right" => Some("left"),
        "top" => Some("bottom"),
        _ => None,
    };
    let found = |name: &str| VIEWS.iter().find(|(view, ..)| *view == name);
    let (_, direction, up) = match (opposite, other(name)) {
        (true, Some(name)) => *found(name)?,
        (true, None) => {
            let (view, direction, up) = *found(name)?;
            (view, -direction, up)
        }
        (false, _) => *found(name)?,
    };
    Some(along(camera, bounds, aspect, direction, up))
}

/// What a file is first seen as: the default of the command line.
pub fn first(bounds: &Bounds, aspect: f64) -> Camera {
    let (_, direction, up) = VIEWS[VIEWS.len() - 1];
    Camera::framing(bounds, direction.normalize(), up, aspect, ZOOM_FACTOR, false, VIEW_ANGLE.to_radians())
}

fn along(camera: &Camera, bounds: &Bounds, aspect: f64, direction: DVec3, up: DVec3) -> Camera {
    let (parallel, fov_y) = match camera.projection {
        Projection::Perspective { fov_y } => (false, fov_y),
        Projection::Orthographic { .. } => (true, VIEW_ANGLE.to_radians()),
    };
    Camera::framing(bounds, direction, up, aspect, ZOOM_FACTOR, parallel, fov_y)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { size: DVec2::new(800.0, 600.0) };

    fn bounds() -> Bounds {
        Bounds::of_points([DVec3::new(-1.0, -2.0, -3.0), DVec3::new(3.0, 2.0, 1.0)])
    }

    fn pixel_of(camera: &Camera, point: DVec3) -> DVec2 {
        let clip = camera.clip_from_view(camera.frustum(&bounds()), [800, 600], DVec2::ZERO);
        let p = (clip * camera.view_from_world()).project_point3(point);
        DVec2::new((p.x + 1.0) * 400.0, (1.0 - p.y) * 300.0)
    }

    fn both() -> [Camera; 2] {
        let camera = first(&bounds(), FRAME.aspect());
        [camera, other_projection(&camera)]
    }

    #[test]
    fn what_is_under_the_cursor_stays_there() {
        for camera in both() {
            let at = DVec2::new(650.0, 120.0);
            let point = FRAME.point_at(&camera, at);
            assert!((pixel_of(&camera, point) - at).length() < 1e-6);
            let zoomed = zoom(&camera, FRAME, at, 0.4, &bounds());
            assert!((pixel_of(&zoomed, point) - at).length() < 1e-6);
            assert!((zoomed.visible_height() / camera.visible_height() - 0.4).abs() < 1e-9);
            let delta = DVec2::new(-37.0, 81.0);
            assert!((pixel_of(&pan(&camera, FRAME, delta), point) - at - delta).length() < 1e-6);
        }
    }

    #[test]
    fn turning_keeps_the_pivot_in_place_and_the_horizon_level() {
        for camera in both() {
            let pivot = FRAME.point_at(&camera, DVec2::new(200.0, 400.0));
            for turn in [turntable, trackball] {
                let next = turn(&camera, pivot, FRAME, DVec2::new(90.0, -40.0));
                assert!((pixel_of(&next, pivot) - pixel_of(&camera, pivot)).length() < 1e-6);
                assert!((next.distance() - camera.distance()).abs() < 1e-9);
                assert!((next.direction() - camera.direction()).length() > 0.1);
            }
            let next = turntable(&camera, pivot, FRAME, DVec2::new(90.0, -40.0));
            assert!(next.axes().0.dot(VERTICAL).abs() < 1e-9);
        }
    }

    #[test]
    fn a_drag_to_the_right_brings_the_left_side_forward() {
        let camera = named(&both()[0], &bounds(), 1.0, "front", false).unwrap();
        let next = turntable(&camera, camera.focal_point, FRAME, DVec2::new(60.0, 0.0));
        assert!(next.position.x < camera.position.x);
        let next = turntable(&camera, camera.focal_point, FRAME, DVec2::new(0.0, 60.0));
        assert!(next.position.y > camera.position.y, "down tips the top towards the viewer");
        let ball = trackball(&camera, camera.focal_point, FRAME, DVec2::new(60.0, 0.0));
        assert!(ball.position.x < camera.position.x);
        let ball = trackball(&camera, camera.focal_point, FRAME, DVec2::new(0.0, 60.0));
        assert!(ball.position.y > camera.position.y);
    }

    #[test]
    fn a_turntable_stops_at_the_poles_and_leaves_them() {
        let mut camera = both()[0];
        for _ in 0..50 {
            camera = turntable(&camera, camera.focal_point, FRAME, DVec2::new(3.0, 50.0));
        }
        let up = camera.axes().1;
        assert!(-camera.direction().dot(VERTICAL) > 0.999 && up.dot(VERTICAL) >= 0.0, "{camera:?}");
        let top = named(&camera, &bounds(), 1.0, "top", false).unwrap();
        let tipped = turntable(&top, top.focal_point, FRAME, DVec2::new(0.0, -100.0));
        assert!(tipped.axes().1.dot(VERTICAL) > 0.5 && tipped.position.z > 0.5, "{tipped:?}");
    }

    #[test]
    fn zoom_is_bounded_and_ignores_nonsense() {
        let camera = both()[0];
        let r = bounds().bounding_sphere().radius;
        for (factor, least, most) in [(1e-30, r * 0.99e-4, r * 1.01e-4), (1e30, r * 999.0, r * 1001.0)] {
            let height = zoom(&camera, FRAME, DVec2::ZERO, factor, &bounds()).visible_height();
            assert!((least..most).contains(&height), "{factor}: {height}");
        }
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(zoom(&camera, FRAME, DVec2::ZERO, factor, &bounds()), camera);
        }
        assert!(zoom_of_wheel(1.0) < 1.0 && zoom_of_drag(FRAME, 10.0) > 1.0);
    }

    #[test]
    fn projections_change_back_and_views_have_opposites() {
        let camera = both()[0];
        let back = other_projection(&other_projection(&camera));
        assert!((back.position - camera.position).length() < 1e-9);
        for name in ["front", "right", "top", "isometric"] {
            let view = |opposite| named(&camera, &bounds(), 1.0, name, opposite).unwrap();
            assert!((view(false).direction() + view(true).direction()).length() < 1e-9, "{name}");
        }
        assert_eq!(named(&camera, &bounds(), 1.0, "nowhere", false), None);
    }

    #[test]
    fn habits_differ() {
        let plain = Held::default();
        let shift = Held { shift: true, ..plain };
        assert_eq!(motion(Habits::F3d, Button::Left, plain), Some(Motion::Turntable));
        assert_eq!(motion(Habits::F3d, Button::Left, shift), Some(Motion::Pan));
        assert_eq!(motion(Habits::Blender, Button::Left, plain), None);
        assert_eq!(motion(Habits::Blender, Button::Middle, shift), Some(Motion::Pan));
        assert_eq!(motion(Habits::Cad, Button::Right, plain), Some(Motion::Trackball));
        assert_eq!(motion(Habits::Cad, Button::Middle, shift), Some(Motion::Zoom));
    }
}
