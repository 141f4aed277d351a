//! Stage 3, opacity: transfer functions over curvature and depth (Murray 2016, section 5.2).
//!
//! The colour function over κ changes the lit colour, the opacity function over (depth, |κ|) gives opacity; depth is
//! normalized over the scene's bounding sphere. Both are tables that the GPU reads, so changing a function compiles nothing.
//! Functions that do not vary with κ need no curvature, and constant ones do not even need this pass.

use crate::gpu::{Gpu, GpuError, ShaderSpec};
use crate::passes::store::StoreModules;
use crate::passes::{Context, TransferParameters};
use crate::plan::{FramePlan, Opacity, Pass};
use crate::scene::hard_case::{CaseCamera, Contrast, HardCase, Measure, Method, Source};
use crate::transfer::{ColorMode, TransferFunction};

/// The hard cases of opacity.
pub const CASES: &[HardCase] = &[HardCase {
    name: "ends-of-the-tables",
    trap: "",
    why: "Curvatures at both ends of their range, and opacities eight times over 1: positions in the tables at and beyond \
          the last entry, a gain that only the clamp after the material's own opacity may cut. An opacity that is clamped \
          before that makes glass of a blended material out of what should be solid.",
    scene: Source::Builtin("builtin:hard/assembly?seed=3"),
    camera: CaseCamera::CORNER,
    size: [56, 56],
    ours: Method::of("gain 8", "opacity.gain=8 features.curvature.scale=1000"),
    contrast: Some(Contrast::Planted(
        Method::of("clamped too early", "opacity.gain=8 features.curvature.scale=1000").changed(
            "passes/opacity/transfer",
            "return transfer.gain * mix(mix(a, b, t.x), mix(c, d, t.x), t.y);",
            "return min(1.0, transfer.gain * mix(mix(a, b, t.x), mix(c, d, t.x), t.y));",
        ),
    )),
    measure: Measure::StyleError,
    bound: 1.0,
}];

/// The uniform of a transfer function.
pub fn parameters(transfer: &TransferFunction, gain: f64, constant: f64, ghost: f64) -> TransferParameters {
    TransferParameters {
        color_mode: match transfer.color.mode {
            ColorMode::Tint => 0,
            ColorMode::Multiply => 1,
        },
        gain: gain as f32,
        constant: constant as f32,
        ghost: ghost as f32,
    }
}

/// The tables as buffers: colour (256 vectors) and opacity (256×256, rows of equal |κ|).
///
/// # Errors
/// [`GpuError::OutOfMemory`].
pub fn tables(gpu: &Gpu, transfer: &TransferFunction) -> Result<[wgpu::Buffer; 2], GpuError> {
    let baked = transfer.bake();
    let colors: Vec<[f32; 4]> = baked.color.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect();
    let usage = wgpu::BufferUsages::STORAGE;
    Ok([
        gpu.buffer_of("color_table", bytemuck::cast_slice(&colors), usage)?,
        gpu.buffer_of("opacity_table", bytemuck::cast_slice(&baked.opacity), usage)?,
    ])
}

/// The module that multiplies a layer's opacity by its part's, where parts have opacities of their own. It acts after the
/// transfer functions and after the clamp, so that lines fade like everything else.
pub fn looks(plan: &FramePlan) -> &'static str {
    if plan.faded { "passes/opacity/looks_by_part" } else { "passes/opacity/looks_none" }
}

/// The shader of [`stylize`].
pub fn spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let root = if plan.opacity == Opacity::Depth { "passes/opacity/depth_only" } else { "passes/opacity/curvature" };
    modules.keys(modules.layout(ShaderSpec::new(root).with("store/shape_column")))
}

/// Colour and opacity of every layer.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn stylize(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Stylize, &spec(context.plan), "main")
}
