//! Where surfaces end, which is where silhouettes and halos begin (Carnecky 2013, section 5.3).
//!
//! The paper takes every missing neighbour for an end of the surface, and every difference of the layer index between two
//! neighbours for something that ends in front of them. Neither holds where surfaces touch, or nearly coincide, or where one
//! begins as another ends: false ends speckle what is behind them, touching faces swap places and sprinkle halos (T19), and a
//! halo has a gap wherever as many layers begin in front of it as end, or its own surface ends too. Ours:
//!
//! - Two layers side by side that both have no neighbour on the other's side have a *seam* if each is within a pixel's size of the
//!   other's tangent plane, or their planes cross between the two pixels at a moderate angle: nobody could see a gap. If both are
//!   of one part and lack a neighbour, the search has paired the wrong ones, and the surface goes on.
//! - A layer *ends openly* if it has no seam there. Halos begin behind what ends openly, whatever the layer index says, and whether
//!   or not what lies behind ends there itself.
//!
//! Where a part rests on another whose surface goes on, as a bolt's head does on a flange or a box beside one flush with it, the
//! part's edge ends openly, and its halo runs along the contact too, as in a drawing by hand: a line without gaps.
//!
//! Layers that lack a neighbour are few: they are listed and looked at by themselves, one invocation a layer. The list lies in
//! the first column of the fields, which is free until then. Memory: 4 bytes a layer, 8 a pixel.

use crate::gpu::{GpuError, ShaderSpec};
use crate::passes::Context;
use crate::passes::features::neighbours;
use crate::passes::operators;
use crate::passes::store::StoreModules;
use crate::plan::{FramePlan, Pass};

/// The entry points of [`spec`].
pub const ENTRIES: [&str; 2] = ["begin", "nearest"];

/// The shader that notes what each layer lacks, and then what ends nearest in each pixel.
pub fn spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new("passes/illustration/ends"))
}

/// The shader that finds seams.
pub fn seams_spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    modules.normals(modules.keys(modules.layout(ShaderSpec::new("passes/illustration/seams"))))
}

/// The shader that finds which of the layers that lack a neighbour lie behind what ends.
pub fn behind_spec(plan: &FramePlan) -> ShaderSpec {
    let modules = StoreModules::of(plan);
    modules.normals(modules.keys(modules.layout(ShaderSpec::new("passes/illustration/behind"))))
}

/// Finds where all layers end.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn find(context: &mut Context<'_>) -> Result<(), GpuError> {
    let pass = Pass::Boundary;
    let mut resources = context.resources.clone();
    resources.alias("open_layers", operators::column_after(0));
    resources.alias("atomic_ends", "layer_ends");
    context.recorder.encoder.clear_buffer(resources.require(pass.name(), "open_count")?, 0, None);
    let arguments = resources.require(pass.name(), "open_arguments")?.clone();
    let pixels = [context.width().div_ceil(16), context.rows().div_ceil(16), 1];
    let [begin, nearest] = ENTRIES;
    let plan = context.plan;
    let all = spec(plan);
    for (spec, entry, groups) in [
        (&all, begin, Some(pixels)),
        (&neighbours::arrange_spec(), "main", Some([1, 1, 1])),
        (&seams_spec(plan), "main", None),
        (&all, nearest, Some(pixels)),
        (&behind_spec(plan), "main", None),
    ] {
        let kernel = context.shaders.kernel(spec, entry)?;
        match groups {
            Some(groups) => context.recorder.compute(pass, &kernel, &context.frame, &resources, groups)?,
            None => {
                let lacking = (&arguments, 0);
                context.recorder.compute_indirect(pass, &kernel, &context.frame, &resources, lacking)?;
            }
        }
    }
    Ok(())
}
