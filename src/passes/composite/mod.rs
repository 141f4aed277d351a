//! Stage 4, composition: the layers of each pixel over each other, premultiplied, in linear light (T26); and the average of
//! jittered frames.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::{Capture, Pass};

/// Blends the layers into the image.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn blend(context: &mut Context<'_>) -> Result<(), GpuError> {
    let modules = StoreModules::of(context.plan);
    let tail = match context.plan.capture {
        Capture::BucketedKBuffer { tail: true, .. } => "passes/composite/tail_average",
        _ => "passes/composite/tail_none",
    };
    let spec = modules.layout(ShaderSpec::new("passes/composite/blend").with(tail));
    context.per_pixel(Pass::Blend, &spec, "main")
}

/// Brings the opaque pass's colours into the image.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn show_opaque(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::ShowOpaque, &ShaderSpec::new("passes/composite/show_opaque"), "main")
}

/// Adds the image to the sum of the frames before it.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn accumulate(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Accumulate, &ShaderSpec::new("passes/composite/accumulate"), "main")
}
