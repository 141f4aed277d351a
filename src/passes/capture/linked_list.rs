//! Capture `LinkedList`: the illustration buffer's lists (Carnecky, Fuchs, Mehl, Jang, Peikert 2013, sections 4.1 to 4.3).
//!
//! One geometry pass fills: a fragment takes the next free place and exchanges the head of its pixel's list. The lists are
//! then sorted by depth and copied into the consecutive store, the same, bit for bit, as that of [`super::compacted`] (T28).
//! Against that capture it saves a geometry pass and pays with scattered memory.
//!
//! Where we differ:
//! - Blocks of the store are given out by a prefix sum over the counts instead of an atomic counter, so the store does not
//!   depend on the order of the fragments; nor does the order of equal depths, which the triangle's number decides (T19, T27).
//! - Sorting is by a network for the length of the list. The paper's selection sort is a setting: its time grows with the
//!   square of the length.
//! - Every loop over a list takes as many steps as the pixel has fragments, and places are checked: a corrupt list ends, and
//!   what it lacks is counted as lost (T17).
//!
//! Memory a layer: 72 bytes, 36 of them the lists. Where fragments find no room, they are counted; buffers then grow to
//! exactly that number and the frame is filled again, once, so that no picture ever lacks a fragment. Above
//! `capture.linked_list.memory` the picture is made in bands.

use super::sort;
use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::geometry::{GpuScene, Vertices, clip, draw, recolor};
use crate::passes::store::StoreModules;
use crate::plan::{FramePlan, Pass};
use crate::settings::{Axis, Effect, Knob, ListSort};

/// The columns that the lists are made of.
pub const COLUMNS: [&str; 5] = ["arrival_keys", "arrival_colors", "arrival_surfaces", "arrival_emissive", "list_next"];

/// How lists are sorted.
pub const AXES: &[Axis] = &[Axis {
    name: "list-sort",
    knob: Knob::Setting("capture.linked_list.sort"),
    values: &["by_length", "selection"],
    matters_if: &[("capture.kind", "linked_list")],
    effect: Effect::Cost,
}];

/// The shader of [`fill`], over a vertex stage.
pub fn fill_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    let spec = vertex.with("passes/capture/linked_list/fill").with(recolor(plan)).with(clip(plan));
    StoreModules::of(plan).normals(spec)
}

/// The shader that walks the lists: it brings their fragments together, or sorts them by selection.
pub fn walk_spec(plan: &FramePlan, sort: ListSort) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new(match sort {
        ListSort::ByLength => "passes/capture/linked_list/collect",
        ListSort::Selection => "passes/capture/linked_list/selection",
    }))
}

/// What a sort by length sorts.
pub const SORTED: &str = "passes/sort/elements_collected";

/// Geometry pass: links every fragment into its pixel's list and counts it. Heads and counts must be zero.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn fill(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    for name in ["list_heads", "list_count"] {
        context.recorder.encoder.clear_buffer(context.resources.require(Pass::Fill.name(), name)?, 0, None);
    }
    let plan = context.plan;
    draw(context, scene, Pass::Fill, Vertices::Surface, &|vertex| fill_spec(plan, vertex))
}

/// Brings the fragments of every pixel into the order of the store.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn sort_by_depth(context: &mut Context<'_>, how: ListSort) -> Result<(), GpuError> {
    let walk = walk_spec(context.plan, how);
    match how {
        ListSort::ByLength => {
            context.per_pixel(Pass::Sort, &walk, "main")?;
            sort::classify(context, Pass::Sort)?;
            sort::sort(context, Pass::Sort, SORTED, context.deepest)
        }
        ListSort::Selection => {
            let chunk = super::super::features::chunk(context.plan, context.deepest);
            for _ in (0..context.deepest).step_by(chunk as usize) {
                context.per_pixel(Pass::Sort, &walk, "main")?;
            }
            Ok(())
        }
    }
}
