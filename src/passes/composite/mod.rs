//! Stage 4, composition: the layers of each pixel over each other, premultiplied, in linear light (T26); and the average of
//! jittered frames.

pub mod cases;
pub mod outline;

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::capture::buckets;
use crate::passes::store::StoreModules;
use crate::passes::{Context, opacity};
use crate::plan::{Capture, FramePlan, Pass};
use crate::settings::{Axis, Effect, Knob};

/// How densely the scene is sampled.
pub const AXES: &[Axis] = &[
    Axis {
        name: "samples",
        knob: Knob::Setting("image.samples"),
        values: &["1", "2", "4"],
        matters_if: &[],
        effect: Effect::Sampling,
    },
    Axis {
        name: "resolution",
        knob: Knob::Resolution,
        values: &["0.5", "0.75"],
        matters_if: &[],
        effect: Effect::Sampling,
    },
];

/// The shader of [`blend`].
pub fn blend_spec(plan: &FramePlan) -> ShaderSpec {
    let tail = match plan.capture {
        Capture::BucketedKBuffer { tail: true, .. } => "passes/composite/tail_average",
        _ => "passes/composite/tail_none",
    };
    let modules = StoreModules::of(plan);
    let transmission = match plan.illustration {
        Some(i) if i.printed_transmittance => "passes/composite/transmits_base",
        _ => "passes/composite/transmits_rest",
    };
    let spec = modules.layout(ShaderSpec::new("passes/composite/blend").with(tail).with(transmission));
    if !plan.faded {
        return spec.with("passes/composite/layers_alike");
    }
    let spec = spec.with("passes/composite/layers_by_part").with(opacity::looks(plan));
    if plan.columns().iter().any(|(name, _)| *name == "parts") {
        return spec.with("passes/buckets/part_of_column");
    }
    modules.keys(spec.with(buckets::part_of_key(plan)))
}

/// The shader of [`show_opaque`].
pub fn show_opaque_spec() -> ShaderSpec {
    ShaderSpec::new("passes/composite/show_opaque")
}

/// The shader of [`accumulate`].
pub fn accumulate_spec() -> ShaderSpec {
    ShaderSpec::new("passes/composite/accumulate")
}

/// Blends the layers into the image.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn blend(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Blend, &blend_spec(context.plan), "main")
}

/// Brings the opaque pass's colours into the image.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn show_opaque(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::ShowOpaque, &show_opaque_spec(), "main")
}

/// Adds the image to the sum of the frames before it.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn accumulate(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Accumulate, &accumulate_spec(), "main")
}
