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
use crate::settings::ListSort;

/// The module that reads a layer's part off its key.
pub fn part_of_key(plan: &FramePlan) -> &'static str {
    if plan.capture.is_wide() { "passes/buckets/part_of_wide64" } else { "passes/buckets/part_of_packed32" }
}

/// The shader of [`part_lookup`].
pub fn part_lookup_spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    modules.keys(modules.layout(ShaderSpec::new("passes/buckets/part_lookup").with(part_of_key(plan))))
}

/// What [`z_reordering`] sorts.
pub const SORTED: &str = "passes/sort/elements_by_part";

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
    let longest = match context.plan.capture {
        Capture::BucketedKBuffer { k, .. } => {
            sort::classify(context, Pass::ZReordering)?;
            k
        }
        Capture::LinkedList { sort: ListSort::Selection, .. } => {
            sort::classify(context, Pass::ZReordering)?;
            context.deepest
        }
        // The sort by depth has listed the pixels already.
        Capture::Compacted | Capture::LinkedList { .. } | Capture::None => context.deepest,
    };
    sort::sort(context, Pass::ZReordering, SORTED, longest)
}

/// Builds the bucket table of every pixel.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn bucket_creation(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::BucketCreation, &bucket_creation_spec(context.plan), "main")
}
