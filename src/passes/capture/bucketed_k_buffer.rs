//! Capture `BucketedKBuffer`: the k nearest layers of every pixel, bucketed by part (Murray, Baril, Granier 2016).
//!
//! The paper's four steps, each a pass: Z insertion (a geometry pass with a chain of atomic minima), Z reordering by shape id,
//! bucket creation, data storage (a second geometry pass that finds its slot by bucket and binary search). Steps 2 and 3 are
//! in [`super::buckets`], since they serve every capture; they are planned only where something searches by part.
//!
//! Where we differ:
//! - `Wide64`, the default key: 32-bit depth over the instanced-triangle number. No two keys of a pixel are equal, so no
//!   fragment is lost to another and the result does not depend on draw order (T1, T2, T27). `Packed32` is the paper's
//!   (16-bit depth, 16-bit shape id); its equal keys merge, and are counted.
//! - The books balance: rasterized = stored + merged + dropped, counted on the GPU (T3, T5).
//! - Data storage may find its slot by binary search in the depth-ordered row instead of by bucket (`slot_search`), which is
//!   the default, because it is faster: no hashing for every fragment. The answer is the same.
//! - Captures are unlit; light falls once on every stored layer, later.
//! - The row stays in depth order; the reordering is kept beside it.
//!
//! Memory a slot: 8 (4) bytes key, 4 normal, 8 (4) colour, 8 material and emission, in parentheses for `Packed32`; the
//! paper's 128 bits are key, bucket, colour and normal. What overflows k is counted and left out, or averaged (tail).

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::geometry::{GpuScene, Vertices, clip, draw, recolor};
use crate::passes::store::{StoreModules, packed_depth};
use crate::passes::{Context, opacity};
use crate::plan::{Capture, FramePlan, Opacity, Pass};
use crate::settings::{Axis, Effect, Knob, SlotSearch};

const CHOSEN: (&str, &str) = ("capture.kind", "bucketed_k_buffer");

/// What k, the key and the tail cost and lose (T1, T2, T5).
pub const AXES: &[Axis] = &[
    Axis {
        name: "k",
        knob: Knob::Setting("capture.bucketed_k_buffer.k"),
        values: &["4", "8", "16", "32"],
        matters_if: &[CHOSEN],
        effect: Effect::Limit,
    },
    Axis {
        name: "key",
        knob: Knob::Setting("capture.bucketed_k_buffer.key"),
        values: &["wide64", "packed32"],
        matters_if: &[CHOSEN],
        effect: Effect::Accuracy { exact: "wide64" },
    },
    Axis {
        name: "depth",
        knob: Knob::Setting("capture.bucketed_k_buffer.depth"),
        values: &["linear", "z_over_w", "reversed"],
        matters_if: &[CHOSEN, ("capture.bucketed_k_buffer.key", "packed32")],
        effect: Effect::Limit,
    },
    Axis {
        name: "tail",
        knob: Knob::Setting("capture.bucketed_k_buffer.tail"),
        values: &["none", "average"],
        matters_if: &[CHOSEN],
        effect: Effect::Limit,
    },
    Axis {
        name: "slot-search",
        knob: Knob::Setting("capture.bucketed_k_buffer.slot_search"),
        values: &["depth", "bucket"],
        matters_if: &[CHOSEN],
        effect: Effect::Cost,
    },
];

/// Every key with every k.
pub const CROSSES: &[&[&str]] = &[&["key", "k"]];

const TAIL_NONE: &str = "passes/capture/bucketed_k_buffer/tail_none";
const TAIL_AVERAGE: &str = "passes/capture/bucketed_k_buffer/tail_average";

fn with_packed_depth(spec: ShaderSpec, capture: Capture) -> ShaderSpec {
    match capture {
        Capture::BucketedKBuffer { depth, .. } if !capture.is_wide() => {
            spec.constant("PACKED_DEPTH", packed_depth(depth))
        }
        _ => spec,
    }
}

/// The shader of [`clear`].
pub fn clear_spec(plan: &FramePlan) -> ShaderSpec {
    let words = if plan.capture.is_wide() { "2u" } else { "1u" };
    ShaderSpec::new("passes/capture/bucketed_k_buffer/clear").constant("KEY_WORDS", words)
}

/// The shader of [`z_insertion`], over a vertex stage.
pub fn z_insertion_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    let key = if plan.capture.is_wide() {
        "passes/capture/bucketed_k_buffer/atomic_key_wide64"
    } else {
        "passes/capture/bucketed_k_buffer/atomic_key_packed32"
    };
    with_packed_depth(
        vertex.with("passes/capture/bucketed_k_buffer/z_insertion").with(key).with(clip(plan)),
        plan.capture,
    )
}

/// The shader of [`count_layers`].
pub fn count_layers_spec() -> ShaderSpec {
    ShaderSpec::new("passes/capture/bucketed_k_buffer/count_layers")
}

/// The shader of [`data_storage`], over a vertex stage.
pub fn data_storage_spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let key = if plan.capture.is_wide() {
        "passes/capture/bucketed_k_buffer/search_key_wide64"
    } else {
        "passes/capture/bucketed_k_buffer/search_key_packed32"
    };
    let slot = match plan.capture {
        Capture::BucketedKBuffer { slot_search: SlotSearch::Bucket, .. } => {
            "passes/capture/bucketed_k_buffer/slot_by_bucket"
        }
        _ => "passes/capture/bucketed_k_buffer/slot_by_depth",
    };
    // Where buckets come first, the part column is there already.
    let part = if plan.features.is_some() && !plan.runs(Pass::PartLookup) {
        "passes/capture/bucketed_k_buffer/part_stored"
    } else {
        "passes/capture/bucketed_k_buffer/part_not_stored"
    };
    let tail: &[&'static str] = match (plan.capture, plan.opacity) {
        (Capture::BucketedKBuffer { tail: false, .. } | Capture::None, _) => &[TAIL_NONE],
        (capture, _) if capture.is_whole() => &[TAIL_NONE],
        (_, Opacity::Depth | Opacity::Curvature) => &[TAIL_AVERAGE, "passes/capture/bucketed_k_buffer/tail_transfer"],
        _ => &[TAIL_AVERAGE, "passes/capture/bucketed_k_buffer/tail_constant"],
    };
    let spec = vertex.with("passes/capture/bucketed_k_buffer/data_storage").with(key).with(slot).with(part);
    let spec = tail.iter().fold(spec.with(recolor(plan)).with(clip(plan)), |spec, module| spec.with(module));
    let spec = if tail.len() > 1 { spec.with(opacity::looks(plan)) } else { spec };
    with_packed_depth(modules.colors(modules.normals(spec)), plan.capture)
}

/// Empties the rows and the counters.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn clear(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_row_run(Pass::Clear, &clear_spec(context.plan), "main")
}

/// Step 1, a geometry pass: the k nearest keys of every pixel.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn z_insertion(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    let plan = context.plan;
    draw(context, scene, Pass::ZInsertion, Vertices::Depth, &|vertex| z_insertion_spec(plan, vertex))
}

/// Closes the books: layers of each pixel and the totals.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn count_layers(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_row_run(Pass::CountLayers, &count_layers_spec(), "main")
}

/// Step 4, a geometry pass: the surfaces of the stored keys.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn data_storage(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    let plan = context.plan;
    draw(context, scene, Pass::DataStorage, Vertices::Surface, &|vertex| data_storage_spec(plan, vertex))
}
