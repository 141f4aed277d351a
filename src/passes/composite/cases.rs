//! The hard cases of composition.

use crate::scene::hard_case::Contrast::Printed;
use crate::scene::hard_case::Source::Builtin;
use crate::scene::hard_case::{CaseCamera, HardCase, Measure, Method};

const FAINT: &str = "opacity.model=constant opacity.constant=0.01";
const PACKED: &str = "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=2 \
                      capture.bucketed_k_buffer.key=packed32 opacity.model=constant";

/// Cases of composition.
pub const CASES: &[HardCase] = &[
    HardCase {
        name: "t26-faint-layers",
        trap: "T26",
        why: "Thirty-two layers of one per cent each. Sums that are rounded to 8 bits after every layer lose a third of the \
              light; premultiplied, linear sums in 32-bit floats agree with f64 in either direction.",
        scene: Builtin("builtin:hard/faint"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [16, 16],
        ours: Method::of("32-bit floats", FAINT),
        contrast: Some(Printed(Method::of("8-bit sums", FAINT).changed(
            "passes/composite/blend",
            "        transmitted *= transmission(base + layer, alpha);\n",
            "        transmitted *= transmission(base + layer, alpha);\n        color = round(color * 255.0) / 255.0;\n",
        ))),
        measure: Measure::BlendError,
        bound: 0.001,
    },
    HardCase {
        name: "t26-dark-colours",
        trap: "T26",
        why: "Dark colours in eight bits: linear values have steps of 6/255 as the eye sees them, sRGB-encoded ones of \
              1/255. Where the paper stores RGBA8, it has to be sRGB, unpremultiplied.",
        scene: Builtin("builtin:hard/dark"),
        camera: CaseCamera::FRONT_PARALLEL,
        size: [32, 32],
        ours: Method::of("sRGB in 8 bits", PACKED),
        contrast: Some(Printed(Method::of("linear in 8 bits", PACKED).changed(
            "store/color_rgba8",
            "srgb_from_linear(color.rgb)",
            "srgb_from_linear(round(255.0 * color.rgb) / 255.0)",
        ))),
        measure: Measure::ColorError,
        bound: 0.51,
    },
];
