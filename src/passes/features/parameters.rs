//! Where in its surface's own parametrization every layer lies: the measure that Carnecky 2013 (section 4.4) recommends for
//! integral surfaces and leaves open.
//!
//! The first texture coordinates of a mesh are taken for its parametrization. They are interpolated by a geometry pass of its own,
//! which finds each fragment's layer by its key, so that it serves every capture and costs nothing where nobody asks. Scaled to
//! radii of the part ([`crate::scene::Parametrization`]), their Euclidean distance is that of two layers, and as it is the same
//! both ways, links are mutual (T13).
//!
//! - **Seams.** A parametrization may jump where the surface goes on. A pair farther apart than four times what either's triangle
//!   covers over a pixel is judged by continuity instead, and takes second place to every pair that is near: ε = d / (1 + d) for
//!   those, 1 + ε by continuity for the others. So a seam is linked as if there were no parametrization, and near pairs never lose
//!   to it.
//! - **Parts without** texture coordinates, caps of sections, and triangles on which they do not change are judged by continuity;
//!   the plan says how many parts.
//! - **What it needs.** Different places must have different parameters. Coordinates that repeat a pattern, or give both halves of
//!   a symmetrical body the same picture, fail where two such places come to lie next to each other. Hence a setting, and not the
//!   default.
//!
//! Candidates are searched by brute force: depth bounds no distance in parameters, so buckets cannot be searched outwards.
//! Memory a layer: 16 bytes, and 12 a vertex of meshes with texture coordinates.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::geometry::{GpuScene, Vertices, draw};
use crate::passes::store::StoreModules;
use crate::plan::{FramePlan, Pass};

/// The shader of [`Pass::Parametrize`], over a vertex stage.
pub fn spec(plan: &FramePlan, vertex: ShaderSpec) -> ShaderSpec {
    let key = if plan.capture.is_wide() {
        "passes/capture/bucketed_k_buffer/search_key_wide64"
    } else {
        "passes/capture/bucketed_k_buffer/search_key_packed32"
    };
    let modules = StoreModules::of(plan);
    modules.keys(modules.layout(vertex.with("passes/features/parametrize").with(key)))
}

/// Notes the parameters of all layers, if the plan wants them; the store is complete.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn parametrize(context: &mut Context<'_>, scene: &GpuScene) -> Result<(), GpuError> {
    if !context.plan.runs(Pass::Parametrize) {
        return Ok(());
    }
    let column = context.resources.require(Pass::Parametrize.name(), "parameters")?;
    context.recorder.encoder.clear_buffer(column, 0, None);
    let plan = context.plan;
    draw(context, scene, Pass::Parametrize, Vertices::Parameters, &|vertex| spec(plan, vertex))
}
