//! The line around what is selected, through everything in front of it.
//!
//! The selected parts are drawn into a mask without a depth test; a pixel outside the mask whose centre is at most the
//! line's width from the centre of a pixel inside takes the line's colour, fully. Nothing of the picture inside the outline
//! changes, and pixels are as hard-edged as the picture's own; several samples average both.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::geometry::{GpuScene, clip, draw_mask};
use crate::passes::{Context, OutlineParameters};
use crate::plan::{FramePlan, Pass};

/// The uniform of a colour (linear) and a width in pixels.
pub fn parameters(color: [f64; 3], width: f64) -> OutlineParameters {
    let [r, g, b] = color.map(|v| v as f32);
    OutlineParameters { color: [r, g, b, 1.0], width: width as f32, _pad: [0; 3] }
}

/// The shader of [`mask`], over a vertex stage.
pub fn mask_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    vertex.with("passes/composite/outline_mask").with(clip(plan))
}

/// The shader of [`outline`].
pub fn outline_spec() -> ShaderSpec {
    ShaderSpec::new("passes/composite/outline")
}

/// Draws what the context's instances cover into `target` (R8Unorm).
///
/// # Errors
/// [`GpuError`] of the device.
pub fn mask(context: &mut Context<'_>, scene: &GpuScene, target: &wgpu::TextureView) -> Result<(), GpuError> {
    let plan = context.plan;
    draw_mask(context, scene, target, &|vertex| mask_spec(plan, vertex))
}

/// Draws the line around the mask into the image.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn outline(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Outline, &outline_spec(), "main")
}
