//! The camera: where it stands, what it looks at, how it projects.
//!
//! Depth convention: clip space has `z` in [0, 1], **reversed**, 1 at the near plane. Perspective has its far plane at
//! infinity, so `z = near / depth` and a 32-bit float keeps its relative precision everywhere (T2). Orthographic depth
//! is linear between `near` (1) and `far` (0). View space is right-handed, looking down −z; *depth* is the positive
//! distance along the viewing direction, in scene units.

use glam::{DMat3, DMat4, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::Bounds;

/// How the camera projects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Projection {
    /// Pinhole; `fov_y` is the full vertical angle of view in radians.
    Perspective {
        /// Full vertical angle of view, radians, in (0, π).
        fov_y: f64,
    },
    /// Parallel; `height` is the visible height in scene units.
    Orthographic {
        /// Visible height, scene units, > 0.
        height: f64,
    },
}

/// A camera in scene space. `view_up` need not be perpendicular to the viewing direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Position of the eye, scene units.
    pub position: DVec3,
    /// The point looked at; also the pivot of azimuth, elevation and zoom.
    pub focal_point: DVec3,
    /// The direction that is up in the image.
    pub view_up: DVec3,
    /// How it projects.
    pub projection: Projection,
}

/// The part of view space that a picture of a scene needs: computed per scene and view by [`Camera::frustum`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewFrustum {
    /// Depth of the near plane, scene units, > 0 for perspective.
    pub near: f64,
    /// Depth of the far plane, scene units, > near. A perspective picture does not clip there; it only normalizes by it.
    pub far: f64,
}

impl Camera {
    /// A camera that looks along `direction` at the middle of `bounds`, with the whole box inside an image of
    /// `aspect` = width / height.
    ///
    /// `zoom_factor` 1 makes the box touch the image's edge; 0.9 leaves a margin (as in f3d). For empty or single-point
    /// bounds a box of edge 2 is framed.
    pub fn framing(
        bounds: &Bounds,
        direction: DVec3,
        view_up: DVec3,
        aspect: f64,
        zoom_factor: f64,
        orthographic: bool,
        fov_y: f64,
    ) -> Camera {
        let center = bounds.center();
        let bounds = if bounds.bounding_sphere().radius > 0.0 {
            *bounds
        } else {
            Bounds::of_points([center - DVec3::ONE, center + DVec3::ONE])
        };
        let direction = direction.try_normalize().unwrap_or(DVec3::NEG_Z);
        let projection = Projection::Perspective { fov_y };
        let mut camera = Camera { position: center - direction, focal_point: center, view_up, projection };
        let (right, up, back) = camera.axes();
        let tan = (fov_y * 0.5).tan();
        let tangents = DVec2::new(tan * aspect, tan);
        let corners = bounds.corners().map(|c| c - center);
        // The eye stands so far back that every corner is inside; how far is decided by one of them.
        let needed = |c: &DVec3| {
            let across = DVec2::new(right.dot(*c).abs(), up.dot(*c).abs()) / tangents / zoom_factor;
            across.max_element() + back.dot(*c)
        };
        let distance = corners.iter().map(needed).fold(0.0, f64::max);
        camera.position = center - direction * distance;
        if orthographic {
            let half = corners.iter().map(|c| up.dot(*c).abs().max(right.dot(*c).abs() / aspect)).fold(0.0, f64::max);
            camera.projection = Projection::Orthographic { height: 2.0 * half / zoom_factor };
        }
        camera
    }

    /// Unit vector from the eye to the focal point; −z if they coincide.
    pub fn direction(&self) -> DVec3 {
        (self.focal_point - self.position).try_normalize().unwrap_or(DVec3::NEG_Z)
    }

    /// Rotates the eye about the focal point around the view-up axis by `degrees` (VTK's Azimuth: positive moves the
    /// eye to its right).
    #[must_use]
    pub fn azimuth(mut self, degrees: f64) -> Camera {
        let axis = self.view_up.try_normalize().unwrap_or(DVec3::Y);
        let rotation = DMat3::from_axis_angle(axis, degrees.to_radians());
        self.position = self.focal_point + rotation * (self.position - self.focal_point);
        self
    }

    /// Rotates the eye about the focal point over the top by `degrees` (VTK's Elevation: positive moves the eye up).
    #[must_use]
    pub fn elevation(mut self, degrees: f64) -> Camera {
        let (right, _, _) = self.axes();
        let rotation = DMat3::from_axis_angle(right, -degrees.to_radians());
        self.position = self.focal_point + rotation * (self.position - self.focal_point);
        self.view_up = rotation * self.view_up;
        self
    }

    /// Right, up and backward unit vectors of view space, in scene space.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let forward = self.direction();
        let right = forward.cross(self.view_up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        (right, up, -forward)
    }

    /// View space from scene space: a rigid motion.
    pub fn view_from_world(&self) -> DMat4 {
        let (right, up, back) = self.axes();
        let rotation = DMat3::from_cols(right, up, back).transpose();
        DMat4::from_cols(
            rotation.x_axis.extend(0.0),
            rotation.y_axis.extend(0.0),
            rotation.z_axis.extend(0.0),
            (-(rotation * self.position)).extend(1.0),
        )
    }

    /// Distance from the eye to the focal point, scene units.
    pub fn distance(&self) -> f64 {
        (self.focal_point - self.position).length()
    }

    /// Visible height at the focal point, scene units. The unit in which curvature is measured by default.
    pub fn visible_height(&self) -> f64 {
        match self.projection {
            Projection::Perspective { fov_y } => 2.0 * (fov_y * 0.5).tan() * self.distance(),
            Projection::Orthographic { height } => height,
        }
    }

    /// Near and far depth for a scene inside `bounds`, with a margin so that nothing touches either plane.
    ///
    /// A perspective near plane never comes closer than 1/10 000 of the far depth, so an eye inside the model (T29)
    /// keeps a usable range; what lies nearer is clipped. It is rounded down to a power of two: depths under another
    /// near plane (a far part came or went) then have the same mantissas, and the same picture bit for bit (T7).
    pub fn frustum(&self, bounds: &Bounds) -> ViewFrustum {
        let view_from_world = self.view_from_world();
        let depths = if bounds.is_empty() {
            [self.distance(); 8]
        } else {
            bounds.corners().map(|corner| -view_from_world.transform_point3(corner).z)
        };
        let nearest = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let farthest = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = (farthest - nearest).max(self.visible_height() / 1024.0).max(f64::MIN_POSITIVE);
        let margin = span / 64.0;
        match self.projection {
            Projection::Orthographic { .. } => ViewFrustum { near: nearest - margin, far: farthest + margin },
            Projection::Perspective { .. } => {
                let far = (farthest + margin).max(self.distance() / 1024.0);
                let near = (nearest - margin).max(far / 10_000.0);
                ViewFrustum { near: near.log2().floor().exp2(), far }
            }
        }
    }

    /// Clip space from view space, with the image shifted by `jitter` pixels (x right, y down) for supersampling.
    pub fn clip_from_view(&self, frustum: ViewFrustum, size: [u32; 2], jitter: DVec2) -> DMat4 {
        let [width, height] = size.map(|s| f64::from(s.max(1)));
        let aspect = width / height;
        let shift = DVec2::new(2.0 * jitter.x / width, -2.0 * jitter.y / height);
        match self.projection {
            Projection::Perspective { fov_y } => {
                let f = 1.0 / (fov_y * 0.5).tan();
                DMat4::from_cols_array_2d(&[
                    [f / aspect, 0.0, 0.0, 0.0],
                    [0.0, f, 0.0, 0.0],
                    [-shift.x, -shift.y, 0.0, -1.0],
                    [0.0, 0.0, frustum.near, 0.0],
                ])
            }
            Projection::Orthographic { height } => {
                let depth = frustum.far - frustum.near;
                DMat4::from_cols_array_2d(&[
                    [2.0 / (height * aspect), 0.0, 0.0, 0.0],
                    [0.0, 2.0 / height, 0.0, 0.0],
                    [0.0, 0.0, 1.0 / depth, 0.0],
                    [shift.x, shift.y, frustum.far / depth, 1.0],
                ])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> Bounds {
        Bounds::of_points([DVec3::splat(-1.0), DVec3::splat(1.0)])
    }

    #[test]
    fn depth_is_one_at_the_near_plane_and_falls() {
        for orthographic in [false, true] {
            let camera = Camera::framing(&unit_box(), DVec3::NEG_Z, DVec3::Y, 1.0, 0.9, orthographic, 0.5);
            let frustum = camera.frustum(&unit_box());
            let clip = camera.clip_from_view(frustum, [64, 64], DVec2::ZERO);
            let z = |depth: f64| clip.project_point3(DVec3::new(0.0, 0.0, -depth)).z;
            assert!((z(frustum.near) - 1.0).abs() < 1e-12);
            assert!(z(frustum.far) >= -1e-12 && z(frustum.far) < 0.9);
            assert!(z(frustum.near + 0.1) > z(frustum.near + 0.2));
        }
    }

    #[test]
    fn framing_keeps_the_box_inside_and_fills_the_image() {
        for aspect in [0.5, 1.0, 2.0] {
            let camera = Camera::framing(&unit_box(), DVec3::new(1.0, -2.0, -3.0), DVec3::Y, aspect, 1.0, false, 0.5);
            let clip = camera.clip_from_view(camera.frustum(&unit_box()), [(100.0 * aspect) as u32, 100], DVec2::ZERO)
                * camera.view_from_world();
            let mut outermost: f64 = 0.0;
            for corner in unit_box().corners() {
                let p = clip.project_point3(corner);
                outermost = outermost.max(p.x.abs()).max(p.y.abs());
            }
            assert!((outermost - 1.0).abs() < 0.02, "aspect {aspect}: {outermost}");
        }
    }

    #[test]
    fn jitter_shifts_the_image_by_pixels() {
        for orthographic in [false, true] {
            let camera = Camera::framing(&unit_box(), DVec3::NEG_Z, DVec3::Y, 1.0, 0.9, orthographic, 0.5);
            let frustum = camera.frustum(&unit_box());
            let at =
                |jitter| camera.clip_from_view(frustum, [100, 50], jitter).project_point3(DVec3::new(0.1, 0.2, -3.0));
            let moved = at(DVec2::new(0.5, 0.25)) - at(DVec2::ZERO);
            assert!((moved.x - 0.01).abs() < 1e-12 && (moved.y + 0.01).abs() < 1e-12, "{moved}");
        }
    }
}
