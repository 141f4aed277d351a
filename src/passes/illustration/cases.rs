//! The hard cases of illustrative transparency.

use crate::scene::hard_case::Contrast::{Planted, Printed};
use crate::scene::hard_case::Source::Builtin;
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const OURS: Method = Method::of("ours", "opacity.model=illustrative opacity.illustrative.unit=pixel");
const TINY_P: &str = "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.beta.profile=bell opacity.illustrative.beta.p=1e-9";

/// Cases of illustrative transparency.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t12-diffusion",
        trap: "T12",
        why: "The printed diffusion takes the 5-point Laplacian with a coefficient of 1, four times its limit of stability: every \
              difference between neighbouring pixels grows sevenfold a step. Ours flows along existing links, a quarter of λ \
              through each.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: Method::of(
            "λ = 0.9 along links",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.base=angle_based opacity.illustrative.iterations=50",
        ),
        contrast: Some(Printed(Method::of(
            "λ = 1, 5 points",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.base=angle_based opacity.illustrative.printed=laplacian",
        ))),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "t14-transmittance",
        trap: "T14",
        why: "Line 6 of the printed blending lets 1 − α pass each layer, though the layer covers α̂: behind a silhouette or a halo \
              the weights sum to anything but 1, and the picture lightens or darkens for no reason.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: OURS,
        contrast: Some(Printed(Method::of(
            "1 − α",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.printed=transmittance",
        ))),
        measure: Measure::BlendError,
        bound: 0.5,
    },
    HardCase {
        name: "t15-flat-bell",
        trap: "T15",
        why: "The bell profile is 0/0 at p = 0, and in 32 bits already at 1e-8: not a number, or a jump to 0 or 1. Its limit is a \
              parabola, and differences of exponentials close to 1 need a series.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: Method::of("limit", TINY_P),
        contrast: Some(Printed(Method::of("0/0", TINY_P).changed(
            "passes/illustration/illustrate",
            "    if p < 1e-6 {\n        return 1.0 - v;\n    }\n    return exp(-p * v) * (risen(p * (1.0 - v)) / risen(p));",
            "    return (exp(-p * v) - exp(-p)) / (1.0 - exp(-p));",
        ))),
        measure: Measure::FieldOpacityError,
        bound: 0.1,
    },
    HardCase {
        name: "t16-fixed-fragments",
        trap: "T16",
        why: "Max-propagation as printed drops the boundary's flag: what lies right under a silhouette and should stay at 0 is \
              overwritten in the first step, and the highlight runs on under what covers it.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: OURS,
        contrast: Some(Printed(Method::of(
            "without its flag",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.printed=propagation",
        ))),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "t16-early-stop",
        trap: "T16",
        why: "A highlight a hundred pixels wide over few steps of heat: the loop has to go on as long as something changes, \
              whatever heat does, and not a step less, or the profile is cut off.",
        scene: Builtin("builtin:hard/ball?columns=64"),
        camera: CaseCamera::FRONT,
        size: [96, 96],
        ours: Method::of(
            "until nothing changes",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.iterations=3 opacity.illustrative.beta.lambda=0.02",
        ),
        contrast: Some(Planted(
            Method::of(
                "as long as heat",
                "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.iterations=3 opacity.illustrative.beta.lambda=0.02",
            )
            .changed("passes/operators/next_step", "|| changed ||", "||"),
        )),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "narrow-surfaces",
        trap: "",
        why: "Diffusion by local feature size: how much flows through a link must be the same from both of its ends, or values \
              drift towards whatever is wider. A chord ends at other places along one axis than along the other, and the two \
              layers of a link need not have the same one: the smaller of both counts.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: Method::of(
            "the smaller chord",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.base=angle_based opacity.illustrative.feature_size=30 \
             opacity.illustrative.iterations=50",
        ),
        contrast: Some(Planted(
            Method::of(
                "each its own",
                "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.base=angle_based opacity.illustrative.feature_size=30 \
                 opacity.illustrative.iterations=50",
            )
            .changed(
                "passes/illustration/chords",
                "let chord = select(vec4<u32>(illustration.feature_size), smaller, around.there);",
                "let chord = select(vec4<u32>(illustration.feature_size), own.xxyy, around.there);",
            ),
        )),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "t19-touching-faces",
        trap: "T19",
        why: "Two sheets in one place, as where parts of an assembly touch: which of them lies in front changes from pixel to \
              pixel, and as printed every change of the layer index begins a halo. Nothing ends there, so nothing may shine.",
        scene: Builtin("builtin:hard/contact"),
        camera: CaseCamera::INTO,
        size: [64, 63],
        ours: OURS,
        contrast: Some(Printed(Method::of(
            "bare index steps",
            "opacity.model=illustrative opacity.illustrative.unit=pixel opacity.illustrative.printed=index_steps",
        ))),
        measure: Measure::Halos,
        bound: 0.0,
    },
    HardCase {
        name: "t19-press-fit",
        trap: "T19",
        why: "A press fit: sleeve in bore, key in keyway, pins and plates, every face in the place of another's. Which of two \
              lies in front is up to the last bit of depth, so bare index steps sprinkle every contact with halos. Away from the \
              contours that the geometry has, nothing may begin.",
        scene: Builtin("builtin:contact"),
        camera: CaseCamera::CORNER,
        size: [160, 160],
        ours: OURS,
        contrast: Some(Printed(Method::of(
            "bare index steps",
            "opacity.model=illustrative opacity.illustrative.printed=index_steps",
        ))),
        measure: Measure::HalosOffContours,
        bound: 0.0,
    },
    HardCase {
        name: "t19-cancelled-steps",
        trap: "T19",
        why: "Where one surface ends and another begins in front of the same neighbours, their layer index stays what it is, and as \
              printed the halo has a gap there. What ends and what begins do not cancel unless they touch.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: OURS,
        contrast: Some(Planted(
            OURS.changed(
                "passes/illustration/ends_column",
                "select(nearest_end(other, direction ^ 1u) < link, index < link, bare)",
                "index < link && nearest_end(other, direction ^ 1u) < link",
            ),
        )),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "ends-behind-ends",
        trap: "",
        why: "A surface that ends right where one in front of it does has no neighbour whose layer index could be compared, and stood \
              opaque in the middle of the halo. Its depth says that it lies behind.",
        scene: Builtin("builtin:hard/assembly?seed=3"),
        camera: CaseCamera::CORNER,
        size: [56, 56],
        ours: OURS,
        contrast: Some(Planted(OURS.changed(
            "passes/illustration/boundary",
            "|| (!bare && (flags & (15u * BEHIND)) != 0u)",
            "",
        ))),
        measure: Measure::FieldError,
        bound: 1e-5,
    },
    HardCase {
        name: "near-coincident-sheets",
        trap: "",
        why: "A sheet rolled up until its turns lie less than a pixel apart. The neighbour search cannot tell them from each other, \
              and where it pairs the wrong ones two are left over. Nobody could see a gap: it is a seam, and no silhouette.",
        scene: Builtin("builtin:flow"),
        camera: CaseCamera::CORNER,
        size: [160, 160],
        ours: OURS,
        contrast: Some(Planted(OURS.changed(
            "passes/illustration/seams",
            "if link >= UNKNOWN && (touches || crosses) {",
            "if false {",
        ))),
        measure: Measure::HalosOffContours,
        bound: 0.1,
    },
];
