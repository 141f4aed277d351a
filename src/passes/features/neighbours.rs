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
//!
//! A candidate that does not see the layer as its own candidate
//! is no neighbour (reverse check). *Missing* means the surface ends; *unknown* means nothing can be said: beyond the image,
//! or in a pixel that lost layers (T10).
//!
//! `Buckets` reads only the layers of the same part, through the pixel's hash table; `BruteForce` reads all, as the paper's
//! baseline. Both give the same answer, bit for bit. The search runs one direction at a time in two passes, so that each pair
//! is evaluated once a direction. Memory a layer: 8 bytes for candidates, 8 for links.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::store::StoreModules;
use crate::plan::{FramePlan, Pass};
use crate::settings::{DepthTerm, NeighbourSearch};

/// The shader of [`candidates`].
pub fn candidates_spec(plan: &FramePlan, search: NeighbourSearch) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    let spec = ShaderSpec::new(match search {
        NeighbourSearch::Buckets => "passes/features/candidates_buckets",
        NeighbourSearch::BruteForce => "passes/features/candidates_brute_force",
    });
    let term = match plan.features.map(|f| f.depth_term) {
        Some(DepthTerm::Printed) => "passes/features/expected_depth_own",
        Some(DepthTerm::Slope) | None => "passes/features/expected_depth_slope",
    };
    modules.normals(modules.keys(modules.layout(spec.with(term))))
}

/// The shader of [`links`].
pub fn links_spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new("passes/features/neighbour_links"))
}

/// Best candidate of every layer in each direction.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn candidates(context: &mut Context<'_>, search: NeighbourSearch) -> Result<(), GpuError> {
    context.per_pixel(Pass::NeighbourCandidates, &candidates_spec(context.plan, search), "main")
}

/// Keeps only mutual candidates.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn links(context: &mut Context<'_>) -> Result<(), GpuError> {
    context.per_pixel(Pass::NeighbourLinks, &links_spec(context.plan), "main")
}
