//! The four neighbours of every layer: in each adjacent pixel the layer of the same part that continues the surface
//! (Murray 2016, section 5.1, after Carnecky 2013).
//!
//! A candidate has the least ε = ε_n + ε_z, with ε_n = 1 − n·n' and ε_z a squared depth difference without a unit (T7: the
//! printed formula adds a length squared to a number). Two ways, a setting:
//!
//! - `Printed`: the difference to the layer's own depth, in radii of the part. Where a thin wall is seen at a slant, depth
//!   changes by more than its thickness from pixel to pixel, and its two faces are taken for each other: the wall falls apart
//!   into rims.
//! - `Slope`, ours and the default: the difference to the depth at which the layer's tangent plane crosses the neighbouring
//!   pixel (T18), in heights of a pixel there. Along a surface that is right to a small part of a pixel, however thin the wall.
//!   Neither the unit of the file nor other parts enter (T7).
//! - `Continuity`, the illustration buffer's (Carnecky 2013, equations 1 to 3): the tangent plane as well, in radii of the part,
//!   the difference itself instead of its square, and of the two layers' differences the larger, so that ε is the same both
//!   ways and the best pair of two pixels is always linked (T13). As printed, with a sign and one layer's slope, most links
//!   go one way: `ContinuityPrinted` is kept for comparison.
//! - `Parameters`: distance in the surface's own parametrization (Carnecky 2013, section 4.4, leaves it at the remark that this
//!   is the measure for integral surfaces). Where sheets nearly touch, or turn within a pixel, depth and normal do not tell them
//!   apart, but their parameters do: [`super::parameters`] says how they are measured and what becomes of seams and of parts
//!   that have none.
//!
//! A candidate that does not see the layer as its own candidate is no neighbour (reverse check). *Missing* means the surface
//! ends; *unknown* means nothing can be said: beyond the image, in a pixel that lost layers, or where the surface would go on
//! beyond a section plane (T10). The last is a pass of its own after any search, so that frames without planes do not pay.
//!
//! `BruteForce` reads every layer of the adjacent pixels, as the paper's baseline, for the best candidate in each direction
//! and then checks it. `Buckets` reads only the layers of the same part, through the pixel's hash table, and searches both
//! pixels of a pair at once, so that the check needs no second pass. Same links, bit for bit. Memory a layer: 12 bytes for
//! links, by brute force 12 more for candidates.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::{Features, FramePlan, Pass};
use crate::settings::{Axis, DepthTerm, Effect, Knob, NeighbourSearch};

const WANTED: (&str, &str) = ("opacity.model", "curvature");

/// How neighbours are searched, and by which measure (T7, T18).
pub const AXES: &[Axis] = &[
    Axis {
        name: "neighbours",
        knob: Knob::Setting("features.neighbours"),
        values: &["buckets", "brute_force"],
        matters_if: &[WANTED],
        effect: Effect::Cost,
    },
    Axis {
        name: "depth-term",
        knob: Knob::Setting("features.depth_term"),
        values: &["slope", "continuity", "printed"],
        matters_if: &[WANTED],
        effect: Effect::Accuracy { exact: "slope" },
    },
    Axis {
        name: "reverse-check",
        knob: Knob::Setting("features.reverse_check"),
        values: &["true", "false"],
        matters_if: &[WANTED],
        effect: Effect::Accuracy { exact: "true" },
    },
];

fn search_spec(plan: &FramePlan, features: &Features, root: &'static str) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let [term, unit, measure] = match features.depth_term {
        DepthTerm::Printed => {
            ["passes/features/expected_depth_own", "passes/features/depth_unit_part", "passes/features/measure_one_way"]
        }
        DepthTerm::Slope => [
            "passes/features/expected_depth_slope",
            "passes/features/depth_unit_pixel",
            "passes/features/measure_one_way",
        ],
        DepthTerm::Continuity | DepthTerm::Parameters => [
            "passes/features/expected_depth_slope",
            "passes/features/depth_unit_part",
            "passes/features/measure_continuity",
        ],
        DepthTerm::ContinuityPrinted => [
            "passes/features/expected_depth_slope",
            "passes/features/depth_unit_part",
            "passes/features/measure_continuity_printed",
        ],
    };
    modules.normals(modules.keys(modules.layout(ShaderSpec::new(root).with(term).with(unit).with(measure))))
}

/// The shader of [`Pass::NeighbourCandidates`], by brute force.
pub fn candidates_spec(plan: &FramePlan, features: &Features) -> ShaderSpec {
    let judge = match features.depth_term {
        DepthTerm::Parameters => "passes/features/judge_parameters",
        _ => "passes/features/judge_alone",
    };
    search_spec(plan, features, "passes/features/candidates_brute_force").with(judge)
}

/// The shader of [`Pass::NeighbourLinks`]: the whole search by buckets, or the check of candidates.
pub fn links_spec(plan: &FramePlan, features: &Features) -> ShaderSpec {
    match features.search {
        NeighbourSearch::Buckets => search_spec(plan, features, "passes/features/links_by_buckets"),
        NeighbourSearch::BruteForce if features.depth_term == DepthTerm::ContinuityPrinted => {
            search_spec(plan, features, "passes/features/check_printed")
        }
        NeighbourSearch::BruteForce => StoreModules::of(plan).layout(ShaderSpec::new("passes/features/reverse_check")),
    }
}

/// The entry points of [`links_spec`].
pub fn links_entries(features: &Features) -> &'static [&'static str] {
    match features.search {
        NeighbourSearch::Buckets => &["begin", "main"],
        NeighbourSearch::BruteForce => &["main"],
    }
}

/// The shader that says how large a dispatch over listed layers is.
pub fn arrange_spec() -> ShaderSpec {
    ShaderSpec::new("passes/features/arrange_open")
}

/// The shader that searches for the links which the search by buckets leaves open.
pub fn open_spec(plan: &FramePlan, features: &Features) -> Option<ShaderSpec> {
    (features.search == NeighbourSearch::Buckets)
        .then(|| search_spec(plan, features, "passes/features/links_left_open"))
}

/// The shader of [`Pass::CutLinks`].
pub fn cut_spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    modules.normals(modules.keys(modules.layout(ShaderSpec::new("passes/features/links_at_cut"))))
}

/// The neighbours of every layer.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn search(context: &mut Context<'_>, features: &Features) -> Result<(), GpuError> {
    search_uncut(context, features)?;
    if context.plan.runs(Pass::CutLinks) {
        context.per_pixel(Pass::CutLinks, &cut_spec(context.plan), "main")?;
    }
    Ok(())
}

fn search_uncut(context: &mut Context<'_>, features: &Features) -> Result<(), GpuError> {
    if context.plan.runs(Pass::NeighbourCandidates) {
        context.per_chunk(Pass::NeighbourCandidates, &candidates_spec(context.plan, features), "main")?;
    }
    if !context.plan.runs(Pass::NeighbourLinks) {
        return Ok(());
    }
    let spec = links_spec(context.plan, features);
    let Some(open) = open_spec(context.plan, features) else {
        // The printed check goes through the pixel's own list for every layer.
        return match features.depth_term {
            DepthTerm::ContinuityPrinted => context.per_chunk(Pass::NeighbourLinks, &spec, "main"),
            _ => context.per_pixel(Pass::NeighbourLinks, &spec, "main"),
        };
    };
    let count = context.resources.require(Pass::NeighbourLinks.name(), "open_count")?;
    context.recorder.encoder.clear_buffer(count, 0, None);
    context.per_pixel(Pass::NeighbourLinks, &spec, "begin")?;
    context.per_chunk(Pass::NeighbourLinks, &spec, "main")?;
    context.compute(Pass::NeighbourLinks, &arrange_spec(), "main", [1, 1, 1])?;
    let kernel = context.shaders.kernel(&open, "main")?;
    let arguments = context.resources.require(Pass::NeighbourLinks.name(), "open_arguments")?.clone();
    context.recorder.compute_indirect(Pass::NeighbourLinks, &kernel, &context.frame, context.resources, (&arguments, 0))
}
