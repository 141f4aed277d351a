//! The hard cases of neighbours and curvature.

use glam::DVec3;

use crate::math::{Camera, Projection};
use crate::scene::hard_case::Contrast::{Planted, Printed};
use crate::scene::hard_case::Source::{Builtin, Cut};
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const PLAIN: Method = Method::of("ours", "");
/// κ by which a curvature can be read back: a small scale, no lines, one unit of the file as the length.
const SURFACE: Method = Method::of(
    "surface",
    "features.curvature.unit=world features.curvature.scale=0.004 features.curvature.radius=0 \
     features.curvature.line_width=0 features.curvature.crease_angle=180",
);
const NEAR_BALL: CaseCamera = CaseCamera::Placed(Camera {
    position: DVec3::new(0.0, 0.0, 4.0),
    focal_point: DVec3::ZERO,
    view_up: DVec3::Y,
    projection: Projection::Orthographic { height: 0.5 },
});
const AT_THE_SOUP: CaseCamera = CaseCamera::Placed(Camera {
    position: DVec3::new(1.1, 1.3, 2.6),
    focal_point: DVec3::ZERO,
    view_up: DVec3::Y,
    projection: Projection::Perspective { fov_y: 0.6 },
});

/// Cases of the features.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t07-unit-of-length",
        trap: "T7",
        why: "As printed, the resemblance of two fragments adds a difference of normals, which has no unit, to a squared \
              depth in the file's unit: a model exported in millimetres gets other neighbours than the same in metres. \
              Depth has to be measured in a length of the model or the view.",
        scene: Builtin("builtin:hard/soup?seed=71&parts=3&triangles=30"),
        camera: CaseCamera::CORNER,
        size: [64, 64],
        ours: PLAIN,
        contrast: Some(Printed(
            Method::of("depth in the file's unit", "features.depth_term=printed features.neighbours=brute_force")
                .changed("passes/features/neighbour_epsilon", " * inverse_unit;", ";"),
        )),
        measure: Measure::LinksUnlike(Builtin("builtin:hard/soup?seed=71&parts=3&triangles=30&size=1000")),
        bound: 0.1,
    },
    HardCase {
        name: "t07-far-part",
        trap: "T7",
        why: "A part that is added far away must not change the neighbours of the others, as it would if depth were \
              measured in the radius of the scene; nor may it change a bit of their depths, through the near plane.",
        scene: Builtin("builtin:hard/soup?seed=71&parts=3&triangles=30"),
        camera: AT_THE_SOUP,
        size: [64, 64],
        ours: PLAIN,
        contrast: Some(Planted(Method::of("depth in the scene's range", "").changed(
            "passes/features/links_by_buckets",
            "depth_measures(dz, dz_back)",
            "depth_measures(dz, dz_back) * frame.depth_scale",
        ))),
        measure: Measure::LinksUnlike(Builtin("builtin:hard/soup?seed=71&parts=3&triangles=30&far=1000")),
        bound: 0.0,
    },
    HardCase {
        name: "t08-grazing-curvature",
        trap: "T8",
        why: "The printed curvature is the gradient of the normal's x/z and y/z, that is, the Hessian of depth. It grows \
              without bound towards silhouettes: on a sphere where normal and sight line have a cosine of 0.3 it is \
              twenty times the surface's own curvature.",
        scene: Builtin("builtin:hard/ball"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: SURFACE,
        contrast: Some(Printed(Method::of(
            "view-centred",
            "features.curvature.kind=view_centred features.curvature.unit=world features.curvature.scale=0.004 \
             features.curvature.radius=0 features.curvature.line_width=0 features.curvature.crease_angle=180",
        ))),
        measure: Measure::SphereCurvature(0.3),
        bound: 2.0,
    },
    HardCase {
        name: "t08-saturated-curvature",
        trap: "T8",
        why: "The largest sensitivity on loose triangles seen at any angle: the argument of tanh goes far beyond 88, where \
              WGSL allows anything to come back. κ must stay within ±1 and be the oracle's.",
        scene: Builtin("builtin:hard/soup?seed=81&parts=4&triangles=40"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: Method::of(
            "scale 1000",
            "features.curvature.unit=scene features.curvature.scale=1000 features.curvature.radius=0.05",
        ),
        contrast: Some(Planted(
            Method::of(
                "mean of the axes kept in part",
                "features.curvature.unit=scene features.curvature.scale=1000 features.curvature.radius=0.05",
            )
            .changed("passes/features/curvature", "- mean * axis.normal)", "- 0.9 * mean * axis.normal)"),
        )),
        measure: Measure::KappaError,
        bound: 1e-3,
    },
    HardCase {
        name: "t09-normals",
        trap: "T9",
        why: "Curvature is a derivative of stored normals. The printed 15 + 15 + 2 bits hold x and y, so that z, taken from \
              a root, is off by half a degree at grazing angles; an octahedral map in the same 32 bits is a hundred times \
              as exact.",
        scene: Builtin("builtin:hard/normals"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: Method::of("octahedral", "opacity.model=constant"),
        contrast: Some(Printed(Method::of("15 + 15 + 2", "opacity.model=constant capture.normals=xy15"))),
        measure: Measure::NormalError,
        bound: 0.006,
    },
    HardCase {
        name: "t10-edge-of-the-image",
        trap: "T10",
        why: "A sphere that is larger than the image: beyond the edge nothing is known, and *unknown* is not *missing*. If \
              it counts as missing, the picture gets a frame that looks like a silhouette.",
        scene: Builtin("builtin:hard/ball?columns=64"),
        camera: NEAR_BALL,
        size: [48, 48],
        ours: Method::of("unknown", "features.neighbours=brute_force"),
        contrast: Some(Printed(Method::of("missing", "features.neighbours=brute_force").changed(
            "passes/features/candidates_brute_force",
            "return UNKNOWN;",
            "return MISSING;",
        ))),
        measure: Measure::FalseRims,
        bound: 0.0,
    },
    HardCase {
        name: "t10-overflow-in-every-neighbour",
        trap: "T10",
        why: "Steep sheets cross and only the two nearest layers are kept: in nearly every adjacent pixel the list lost \
              fragments, perhaps the very neighbour. Nobody can say that the surface ends there, so no rim may show where \
              k ran out.",
        scene: Builtin("builtin:hard/soup?seed=101&parts=2&triangles=60"),
        camera: CaseCamera::CORNER,
        size: [48, 48],
        ours: Method::of("k = 2", "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=2"),
        contrast: Some(Printed(
            Method::of(
                "k = 2, overflow ignored",
                "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=2 features.neighbours=brute_force",
            )
            .changed("store/links", "select(MISSING, UNKNOWN, overflowed(other))", "MISSING"),
        )),
        measure: Measure::FalseRims,
        bound: 0.5,
    },
    HardCase {
        name: "t10-section-plane",
        trap: "T10",
        why: "A sphere cut open by a slanted plane: along the cut every surface ends, though not by itself. Counted as \
              missing, the neighbours that were cut away paint the border of the cut as a silhouette, on the inside as on \
              the outside.",
        scene: Cut("builtin:hard/ball?columns=96", DVec3::new(0.48, 0.6, 0.64), 0.2),
        camera: CaseCamera::FRONT,
        size: [96, 96],
        ours: PLAIN,
        contrast: Some(Printed(Method::of("missing", "").changed(
            "passes/features/links_at_cut",
            "> vec4<f32>(-margin));",
            "> vec4<f32>(1e30));",
        ))),
        measure: Measure::FalseRims,
        bound: 0.0,
    },
    HardCase {
        name: "t11-winding",
        trap: "T11",
        why: "Triangles of one surface that disagree on their winding and on the side of their normals, as CAD exporters \
              write them. Normals have to face the viewer before they are compared, or the surface falls apart at every \
              other edge.",
        scene: Builtin("builtin:hard/saddle?turned=1"),
        camera: CaseCamera::CORNER,
        size: [64, 64],
        ours: PLAIN,
        contrast: Some(Printed(Method::of("normals as they come", "").changed(
            "scene/material",
            "select(-1.0, 1.0, side)",
            "1.0",
        ))),
        measure: Measure::KappaUnlike(Builtin("builtin:hard/saddle")),
        bound: 0.0,
    },
    HardCase {
        name: "t31-facets",
        trap: "T31",
        why: "A cylinder of 24 unequal facets with averaged normals: interpolated over a facet they give a curvature that \
              is constant on it and jumps to the next, a band on every CAD cylinder. Estimated over a radius the bands \
              fade; the figure is their spread where the smooth cylinder has 1 everywhere.",
        scene: Builtin("builtin:hard/facets?facets=24"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: Method::of(
            "radius 0.05",
            "features.curvature.unit=world features.curvature.scale=0.05 features.curvature.radius=0.05 \
             features.curvature.line_width=0",
        ),
        contrast: Some(Printed(Method::of(
            "next pixels only",
            "features.curvature.unit=world features.curvature.scale=0.05 features.curvature.radius=0 \
             features.curvature.line_width=0",
        ))),
        measure: Measure::CurvatureSpread,
        bound: 0.33,
    },
    HardCase {
        name: "t31-flat-facets",
        trap: "T31",
        why: "The same cylinder as an STL brings it: every facet flat, no vertex shared, so that all the curvature sits in \
              the edges. Between next pixels the normal jumps there, a spike of many times the curvature, and nothing \
              happens anywhere else; over a radius edges under the crease angle even out. The figure is the peak where the \
              smooth cylinder has 1 everywhere.",
        scene: Builtin("builtin:hard/flat-facets?facets=48"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [128, 128],
        ours: Method::of(
            "radius 0.05",
            "features.curvature.unit=world features.curvature.scale=0.05 features.curvature.radius=0.05 \
             features.curvature.line_width=0",
        ),
        contrast: Some(Printed(Method::of(
            "next pixels only",
            "features.curvature.unit=world features.curvature.scale=0.05 features.curvature.radius=0 \
             features.curvature.line_width=0",
        ))),
        measure: Measure::CurvaturePeak,
        bound: 1.5,
    },
    HardCase {
        name: "t13-one-way-links",
        trap: "T13",
        why: "The illustration buffer's measure as printed keeps the sign of a difference of depth and takes one fragment's slope: \
              the candidate that lies deepest wins, and a neighbour is linked elsewhere or nowhere. Diffusion over such links \
              drifts. The greater of both absolute differences makes every link mutual.",
        scene: Builtin("builtin:hard/soup?seed=71&parts=3&triangles=30"),
        camera: CaseCamera::CORNER,
        size: [64, 64],
        ours: Method::of("mutual", "features.depth_term=continuity"),
        contrast: Some(Printed(Method::of("signed", "features.depth_term=continuity_printed"))),
        measure: Measure::LinksOneWay,
        bound: 0.0,
    },
    HardCase {
        name: "t18-thin-slanted-walls",
        trap: "T18",
        why: "Layers of one part close behind each other, seen at a slant: depth changes by more than their distance from pixel to \
              pixel, and only the slope tells them apart. Without it surfaces are linked to the layer in front of them.",
        scene: Builtin("builtin:hard/close-sheets?gap=2e-3"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [64, 64],
        ours: Method::of("continuity", "features.depth_term=continuity"),
        contrast: Some(Planted(
            Method::of("own depth", "features.depth_term=continuity features.neighbours=brute_force").changed(
                "passes/features/measure_continuity",
                "return max(abs(difference), abs(back));",
                "return abs(abs(difference) - 0.02);",
            ),
        )),
        measure: Measure::LinksWrong,
        bound: 0.0,
    },
];
