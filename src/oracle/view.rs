//! Camera and image as the shaders see them: where in view space a pixel's sample lies, how large a pixel is there, and
//! how large the things are by which lengths are divided.
//!
//! # Choices
//! A part without extent has radius 1 where something is divided by it.

use glam::{DVec2, DVec3};

use crate::math::{Camera, Projection};
use crate::scene::Scene;

/// How pixels and view space go together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Whether sight lines meet in the eye; otherwise they are parallel.
    pub perspective: bool,
    /// Half the visible width and height: at depth 1 for a perspective, anywhere for a parallel projection. View units.
    pub half_extent: DVec2,
    /// How far the image is shifted, in normalized device coordinates (y up).
    pub shift: DVec2,
}

impl View {
    /// The view of `camera` in an image of `size` (width, height), shifted by `jitter` pixels (x right, y down).
    pub fn new(camera: &Camera, size: [u32; 2], jitter: DVec2) -> View {
        let [width, height] = size.map(|s| f64::from(s.max(1)));
        let (perspective, half_height) = match camera.projection {
            Projection::Perspective { fov_y } => (true, (fov_y * 0.5).tan()),
            Projection::Orthographic { height } => (false, height * 0.5),
        };
        View {
            width: size[0],
            height: size[1],
            perspective,
            half_extent: DVec2::new(half_height * width / height, half_height),
            shift: DVec2::new(2.0 * jitter.x / width, -2.0 * jitter.y / height),
        }
    }

    /// The point in view space that the centre of pixel (`x`, `y`) shows at `depth`.
    pub fn position(&self, x: u32, y: u32, depth: f64) -> DVec3 {
        let ndc = DVec2::new(
            2.0 * (f64::from(x) + 0.5) / f64::from(self.width) - 1.0,
            1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(self.height),
        ) - self.shift;
        let scale = if self.perspective { depth } else { 1.0 };
        (self.half_extent * ndc * scale).extend(-depth)
    }

    /// Width and height of a pixel at `depth`, view units.
    pub fn pixel_size(&self, depth: f64) -> DVec2 {
        let scale = if self.perspective { depth } else { 1.0 };
        2.0 * self.half_extent * scale / DVec2::new(f64::from(self.width.max(1)), f64::from(self.height.max(1)))
    }

    /// From a point in view space towards the eye; not of unit length.
    pub fn to_eye(&self, position_in_view: DVec3) -> DVec3 {
        if self.perspective { -position_in_view } else { DVec3::Z }
    }
}

/// Sizes of the scene and its parts, in scene units, by which stages normalize.
#[derive(Clone, Debug, PartialEq)]
pub struct Extents {
    /// Radius of the sphere around each part.
    pub part_radii: Vec<f64>,
    /// Radius of the sphere around the scene.
    pub scene_radius: f64,
    /// Visible height at the focal point.
    pub visible_height: f64,
    /// Nearest and farthest depth of the sphere around the scene.
    pub depth_range: [f64; 2],
}

impl Extents {
    /// The sizes of `scene` seen by `camera`.
    pub fn new(scene: &Scene, camera: &Camera) -> Extents {
        let sphere = scene.bounds().bounding_sphere();
        let center_depth = -camera.view_from_world().transform_point3(sphere.center).z;
        Extents {
            part_radii: scene.parts.iter().map(|p| p.bounds.bounding_sphere().radius).collect(),
            scene_radius: sphere.radius,
            visible_height: camera.visible_height(),
            depth_range: [center_depth - sphere.radius, center_depth + sphere.radius],
        }
    }

    /// Radius of a part; 1 for a part that is a single point or does not exist, so that nothing is divided by zero.
    pub fn part_radius(&self, part: u32) -> f64 {
        self.part_radii.get(part as usize).copied().filter(|&r| r > 0.0).unwrap_or(1.0)
    }

    /// Where `depth` lies in the scene's depth range: 0 nearest, 1 farthest, clamped; 0 in a range without extent.
    pub fn depth01(&self, depth: f64) -> f64 {
        let [near, far] = self.depth_range;
        if far > near { ((depth - near) / (far - near)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Bounds;

    #[test]
    fn a_position_projects_back_onto_its_pixel_centre() {
        let bounds = Bounds::of_points([DVec3::splat(-1.0), DVec3::splat(1.0)]);
        let size = [50, 30];
        let jitter = DVec2::new(0.25, -0.375);
        for orthographic in [false, true] {
            let camera = Camera::framing(&bounds, DVec3::NEG_Z, DVec3::Y, 5.0 / 3.0, 0.9, orthographic, 0.6);
            let view = View::new(&camera, size, jitter);
            let clip = camera.clip_from_view(camera.frustum(&bounds), size, jitter);
            for (x, y, depth) in [(0, 0, 3.0), (49, 29, 4.0), (7, 20, 3.5)] {
                let p = clip.project_point3(view.position(x, y, depth));
                let at = DVec2::new((p.x + 1.0) * 25.0, (1.0 - p.y) * 15.0);
                assert!((at - DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).length() < 1e-9, "{at}");
                let step = view.position(x, y, depth) - view.position(x + 1, y, depth);
                assert!((step.length() - view.pixel_size(depth).x).abs() < 1e-12);
            }
        }
    }
}
