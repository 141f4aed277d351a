//! Capture `Compacted`: count, prefix sum, append, sort. Ours; exact up to the most layers that a list may have (more are
//! refused, `Capabilities::most_layers`), and the default.
//!
//! One geometry pass counts the fragments of each pixel, a prefix sum turns counts into offsets, a second geometry pass
//! appends key and surface to its pixel's run in whatever order fragments come, and a sort by (depth, triangle number) puts
//! them in an order that depends on nothing but the scene and the view (T27). Against a chain of atomic minima it costs about
//! a quarter on a CPU rasterizer, and memory follows what is really there: 68 bytes a fragment, half of which is the arrival
//! buffer, instead of k slots in every pixel.
//!
//! The number of fragments is known only after counting. A picture whose fragments do not fit one binding is made in bands.

use super::sort;
use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::geometry::{GpuScene, Vertices, clip, draw, recolor};
use crate::passes::store::StoreModules;
use crate::plan::{Capture, FramePlan, Pass};

/// The shader of [`count`], over a vertex stage.
pub fn count_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    vertex.with("passes/capture/compacted/count").with(clip(plan))
}

/// The entry points of [`prefix_sum_spec`].
pub const PREFIX_SUM_ENTRIES: [&str; 3] = ["sum_rows", "scan_rows", "offset_rows"];

/// The shader of [`sum_rows`] and [`prefix_sum`].
pub fn prefix_sum_spec() -> ShaderSpec {
    ShaderSpec::new("passes/capture/compacted/prefix_sum")
        .constant("LARGEST_CLASS", format!("{}u", sort::LARGEST_CLASS))
}

/// The shader of [`append`], over a vertex stage.
pub fn append_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    StoreModules::of(plan).normals(vertex.with("passes/capture/compacted/append").with(recolor(plan)).with(clip(plan)))
}

/// What [`sort_by_depth`] sorts.
pub const SORTED: &str = "passes/sort/elements_by_depth";

/// The shader of [`gather`].
pub fn gather_spec(plan: &FramePlan) -> ShaderSpec {
    let source = match plan.capture {
        Capture::LinkedList { .. } => "passes/capture/linked_list/source_in_list",
        _ => "passes/capture/compacted/source_in_run",
    };
    StoreModules::of(plan).normals_alone(ShaderSpec::new("passes/capture/compacted/gather").with(source))
}

/// Geometry pass: counts the fragments of every pixel into `pixel_counts`, which must be zero.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn count(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    let plan = context.plan;
    draw(context, scene, Pass::Count, Vertices::Depth, &|vertex| count_spec(plan, vertex))
}

/// Sums the counts of every row into `row_sums`.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn sum_rows(context: &mut Context<'_>) -> Result<(), GpuError> {
    let [sum_rows, ..] = PREFIX_SUM_ENTRIES;
    let groups = [context.rows(), 1, 1];
    context.compute(Pass::PrefixSum, &prefix_sum_spec(), sum_rows, groups)
}

/// Turns counts into offsets, from the sums of the rows.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn prefix_sum(context: &mut Context<'_>) -> Result<(), GpuError> {
    let [_, scan_rows, offset_rows] = PREFIX_SUM_ENTRIES;
    let groups = [context.rows(), 1, 1];
    context.compute(Pass::PrefixSum, &prefix_sum_spec(), scan_rows, [1, 1, 1])?;
    context.compute(Pass::PrefixSum, &prefix_sum_spec(), offset_rows, groups)
}

/// Geometry pass: appends key and surface of every fragment to its pixel's run.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn append(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    let plan = context.plan;
    draw(context, scene, Pass::Append, Vertices::Surface, &|vertex| append_spec(plan, vertex))
}

/// Sorts every pixel's run by (depth, triangle number).
///
/// # Errors
/// [`GpuError`] of the device.
pub fn sort_by_depth(context: &mut Context<'_>) -> Result<(), GpuError> {
    sort::classify(context, Pass::Sort)?;
    sort::sort(context, Pass::Sort, SORTED, context.deepest)
}

/// Brings the surfaces into the sorted order.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn gather(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::Gather, &gather_spec(context.plan), "main")
}
