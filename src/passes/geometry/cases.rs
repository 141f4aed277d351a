//! The hard cases of geometry: extreme sizes and cameras.

use glam::DVec3;

use crate::math::{Camera, Projection};
use crate::scene::hard_case::Contrast::Planted;
use crate::scene::hard_case::Source::Builtin;
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const EXACT: Method = Method::of("compacted", "");
/// Vertices behind the eye are pulled to the near plane instead of being clipped.
const NOT_CLIPPED: Method = Method::of("vertices pulled to the near plane", "").changed(
    "scene/instance",
    "return vec3<f32>(dot(instance.view_x, p), dot(instance.view_y, p), dot(instance.view_z, p));",
    "return vec3<f32>(dot(instance.view_x, p), dot(instance.view_y, p), min(dot(instance.view_z, p), -frame.near));",
);
/// Positions keep only half of an f32's digits.
const ROUNDED: Method = Method::of("half precision", "").changed(
    "scene/instance",
    "return vec3<f32>(dot(instance.view_x, p), dot(instance.view_y, p), dot(instance.view_z, p));",
    "return vec3<f32>(dot(instance.view_x, p), dot(instance.view_y, p), quantizeToF16(dot(instance.view_z, p)));",
);

const fn eye(position: DVec3, toward: DVec3) -> CaseCamera {
    CaseCamera::Placed(Camera {
        position,
        focal_point: toward,
        view_up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 1.2 },
    })
}

/// Cases of geometry.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t29-size-1e-6",
        trap: "T29",
        why: "A model a millionth of a unit across. Thresholds that are lengths of their own swallow it whole: areas, \
              margins of the near plane, tolerances of normals.",
        scene: Builtin("builtin:hard/assembly?seed=29&size=1e-6"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: EXACT,
        contrast: Some(Planted(ROUNDED)),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t29-size-1e6",
        trap: "T29",
        why: "The same model a million units across: squared lengths, areas and products of depths leave the range in \
              which an f32 is exact, and would leave its range altogether if they were taken to higher powers.",
        scene: Builtin("builtin:hard/assembly?seed=29&size=1e6"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: EXACT,
        contrast: Some(Planted(ROUNDED)),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t29-camera-inside",
        trap: "T29",
        why: "The eye stands inside ten nested parts, most of which reach behind it: bounds give no near plane, every \
              second triangle crosses it, and what lies behind must not come back mirrored.",
        scene: Builtin("builtin:hard/assembly?seed=30"),
        camera: eye(DVec3::new(0.21, -0.13, 0.34), DVec3::new(-0.3, 0.1, -0.4)),
        size: [64, 48],
        ours: EXACT,
        contrast: Some(Planted(NOT_CLIPPED)),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t29-near-plane-through-a-part",
        trap: "T29",
        why: "One triangle reaches from sixty units behind the eye to ninety ahead. It must be clipped where the near plane \
              cuts it, with depths that stay those of its plane.",
        scene: Builtin("builtin:hard/floor"),
        camera: eye(DVec3::ZERO, DVec3::new(0.1, -0.2, -1.0)),
        size: [64, 48],
        ours: EXACT,
        contrast: Some(Planted(NOT_CLIPPED)),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
    HardCase {
        name: "t29-no-pixel",
        trap: "T29",
        why: "An image without pixels, as a window has while it is minimized. There is nothing to dispatch and no texture of \
              that size; it must be refused in words before the device is asked.",
        scene: Builtin("builtin:hard/stack?layers=20&parts=4"),
        camera: CaseCamera::FRONT,
        size: [0, 0],
        ours: EXACT,
        contrast: None,
        measure: Measure::NotRefused,
        bound: 0.0,
    },
    HardCase {
        name: "t29-one-pixel",
        trap: "T29",
        why: "An image of one pixel: no neighbour anywhere, a single work group nearly idle, a projection whose sample is \
              the whole image. Nothing may be read beyond the edge.",
        scene: Builtin("builtin:hard/stack?layers=20&parts=4"),
        camera: CaseCamera::Framed { direction: DVec3::new(0.5, 0.1, -1.0), zoom: 3.0, orthographic: false },
        size: [1, 1],
        ours: EXACT,
        contrast: Some(Planted(Method::of("triangles numbered from 1", "").changed(
            "scene/vertex_plain",
            "out.triangle = instance.ids.x + (triangle & ~OPPOSED);",
            "out.triangle = instance.ids.x + (triangle & ~OPPOSED) + 1u;",
        ))),
        measure: Measure::LayersWrong,
        bound: 0.0,
    },
];
