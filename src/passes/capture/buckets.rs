//! Buckets over any capture: Z reordering by shape id and bucket creation (Murray 2016, section 4.1, steps 2 and 3).
//!
//! Where the paper reorders the row itself, ours keeps the row in depth order and the (part, depth) order beside it
//! (`by_part`), so that composition needs no second sort. A pixel's bucket table has as many slots as the pixel has room for
//! layers (k, or its own count), H(part) = part mod slots, with linear probing that wraps and ends after one round (T6).
//! Memory a layer: 4 bytes for the part, 4 for the order, 8 for the table.

use super::sort;
use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::{Capture, FramePlan, Pass};

/// The shader of [`part_lookup`].
pub fn part_lookup_spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let part_of =
        if plan.capture.is_wide() { "passes/buckets/part_of_wide64" } else { "passes/buckets/part_of_packed32" };
    modules.keys(modules.layout(ShaderSpec::new("passes/buckets/part_lookup").with(part_of)))
}

/// The shaders of [`z_reordering`], one for each class of lengths that the capture can have.
pub fn z_reordering_specs(plan: &FramePlan) -> Vec<ShaderSpec> {
    let elements = StoreModules::of(plan).layout(ShaderSpec::new("passes/sort/elements_by_part"));
    match plan.capture {
        Capture::BucketedKBuffer { k, .. } => {
            let largest = k.next_power_of_two().trailing_zeros();
            (0..=largest).map(|class| sort::with_network(elements.clone(), class)).collect()
        }
        Capture::Compacted | Capture::None => sort::all_classes(&elements),
    }
}

/// The shader of [`bucket_creation`].
pub fn bucket_creation_spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new("passes/buckets/bucket_creation"))
}

/// Fills the part column.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn part_lookup(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::PartLookup, &part_lookup_spec(context.plan), "main")
}

/// Sorts the layers of every pixel by (part, depth).
///
/// # Errors
/// [`GpuError`] of the device.
pub fn z_reordering(context: &mut Context<'_>) -> Result<(), GpuError> {
    let specs = z_reordering_specs(context.plan);
    match context.plan.capture {
        Capture::BucketedKBuffer { .. } => {
            for spec in &specs {
                context.per_pixel(Pass::ZReordering, spec, "main")?;
            }
        }
        Capture::Compacted | Capture::None => {
            let arguments = context.resources.require("z reordering", "sort_arguments")?.clone();
            for (class, spec) in (0_u64..).zip(&specs) {
                let kernel = context.shaders.kernel(spec, "main")?;
                let at = (&arguments, class * 12);
                context.recorder.compute_indirect(Pass::ZReordering, &kernel, &context.frame, context.resources, at)?;
            }
        }
    }
    Ok(())
}

/// Builds the bucket table of every pixel.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn bucket_creation(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::BucketCreation, &bucket_creation_spec(context.plan), "main")
}
