//! Stage 3, opacity: each model a pointwise operator over the lit layers ([`super::operators`]).
//!
//! Transfer functions over curvature and depth (Murray 2016, section 5.2).
//!
//! The colour function over κ changes the lit colour, the opacity function over (depth, |κ|) gives opacity; depth is
//! normalized over the scene's bounding sphere. Both are tables that the GPU reads, so changing a function compiles nothing.
//! Functions that do not vary with κ need no curvature, and constant ones do not even need this pass.
//!
//! The models that illustrative transparency is compared with (Carnecky 2013): `Adaptive` (equation 5), which gives all layers of
//! a pixel together the same opacity everywhere; `AngleBased` (Hummel 2010), from the angle between normal and sight line;
//! `NormalVariation` (Born 2010), from how fast the normal turns across the image's shorter side, between real neighbours
//! instead of by screen derivatives. `EqualShare`, a global operator: every layer index is seen as much as any other, by a
//! histogram of how many layers the pixels have. All multiply the material's own opacity.

use crate::gpu::{Gpu, GpuError};
use crate::passes::operators::{self, Global, Operator};
use crate::passes::{Context, ModelParameters, TransferParameters};
use crate::plan::{FramePlan, Opacity, Pass};
use crate::scene::hard_case::{CaseCamera, Contrast, HardCase, Measure, Method, Source};
use crate::settings::{OpacityModel, OpacitySettings};
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
    ours: Method::of("gain 8", "opacity.model=curvature opacity.gain=8 features.curvature.scale=1000"),
    contrast: Some(Contrast::Planted(
        Method::of("clamped too early", "opacity.model=curvature opacity.gain=8 features.curvature.scale=1000")
            .changed(
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

/// The uniform of the models without transfer functions, for an image of this size.
pub fn model_parameters(settings: &OpacitySettings, size: [u32; 2]) -> ModelParameters {
    let (low, high, scale) = match settings.base_model() {
        OpacityModel::NormalVariation => {
            let s = &settings.variation;
            (s.low, s.high, s.scale * f64::from(size[0].min(size[1])))
        }
        OpacityModel::EqualShare => (settings.equal_share.least, 0.0, 0.0),
        _ => (settings.angle.low, settings.angle.high, 0.0),
    };
    let share = match settings.base_model() {
        OpacityModel::EqualShare => settings.equal_share.share,
        _ => settings.adaptive,
    };
    ModelParameters { share: share as f32, low: low as f32, high: high as f32, scale: scale as f32 }
}

/// What the tail behind a k-buffer's layers counts with: it has no neighbours and is taken as flat and facing (T10).
pub fn tail_opacity(opacity: Opacity, settings: &OpacitySettings, k: u32) -> f64 {
    let gain = if settings.model == OpacityModel::Illustrative { settings.illustrative.base_gain } else { 1.0 };
    gain * match opacity {
        Opacity::Constant { alpha } => alpha,
        Opacity::Depth | Opacity::Curvature => 1.0,
        Opacity::Adaptive { share } => 1.0 - (1.0 - share).powf(1.0 / f64::from(k.max(1))),
        Opacity::AngleBased => settings.angle.low,
        Opacity::NormalVariation => settings.variation.low,
        Opacity::EqualShare => settings.equal_share.share,
    }
}

/// The operator of [`stylize`]; constant opacity needs none.
pub fn operator(opacity: Opacity) -> Option<Operator> {
    match opacity {
        Opacity::Constant { .. } => None,
        Opacity::Depth => Some(Operator::pointwise("passes/opacity/depth_only")),
        Opacity::Curvature => Some(Operator::pointwise("passes/opacity/curvature")),
        Opacity::Adaptive { .. } => Some(Operator::pointwise("passes/opacity/adaptive")),
        Opacity::AngleBased => Some(Operator::pointwise("passes/opacity/angle_based")),
        Opacity::NormalVariation => Some(Operator::pointwise("passes/opacity/normal_variation")),
        Opacity::EqualShare => Some(Operator::pointwise("passes/opacity/equal_share")),
    }
}

/// What is gathered for equal shares.
pub const SHARES: Global =
    Global { gather: "passes/opacity/equal_share_gather", settle: "passes/opacity/equal_share_settle" };

/// Gathers what the opacity of the whole image depends on, if it does, from the rows that this band writes. What the bands
/// before it gathered is forgotten at the `first`.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn gather(context: &mut Context<'_>, first: bool) -> Result<(), GpuError> {
    if !context.plan.runs(Pass::LayerHistogram) {
        return Ok(());
    }
    if first {
        operators::forget(context, Pass::LayerHistogram)?;
    }
    operators::gather(context, Pass::LayerHistogram, &SHARES)
}

/// Colour and opacity of every layer.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn stylize(context: &mut Context<'_>) -> Result<(), GpuError> {
    if context.plan.runs(Pass::LayerHistogram) {
        operators::settle(context, Pass::LayerHistogram, &SHARES)?;
    }
    match operator(context.plan.opacity) {
        Some(operator) => operators::run(context, Pass::Stylize, &operator, 0),
        None => Ok(()),
    }
}
