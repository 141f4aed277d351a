//! Stage 3, opacity: transfer functions over curvature and depth (Murray 2016, section 5.2).
//!
//! The colour function over κ changes the lit colour, the opacity function over (depth, |κ|) gives opacity; depth is
//! normalized over the scene's bounding sphere. Both are tables that the GPU reads, so changing a function compiles nothing.
//! Functions that do not vary with κ need no curvature, and constant ones do not even need this pass.

use crate::gpu::{Gpu, GpuError, ShaderSpec};
use crate::passes::store::StoreModules;
use crate::passes::{Context, TransferParameters};
use crate::plan::{FramePlan, Opacity, Pass};
use crate::transfer::{ColorMode, TransferFunction};

/// The uniform of a transfer function.
pub fn parameters(transfer: &TransferFunction, gain: f64, constant: f64) -> TransferParameters {
    TransferParameters {
        color_mode: match transfer.color.mode {
            ColorMode::Tint => 0,
            ColorMode::Multiply => 1,
        },
        gain: gain as f32,
        constant: constant as f32,
        _pad: 0,
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
