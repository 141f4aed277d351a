//! Local feature size, which makes diffusion anisotropic: the paper's silhouettes and halos flood what is small and full of
//! silhouettes, and it leaves a remedy as future work (Carnecky 2013, section 9).
//!
//! A chord is how long a surface is through a layer, along its row or its column of pixels, until it ends or something in front
//! begins or ends. Where it is shorter than `opacity.illustrative.feature_size`, links along that axis conduct less, in proportion:
//! heat and `max` get as far as a share of what is there. Lines on thin blades get thin, the room between two teeth is not
//! filled by their halos, and along a narrow strip all flows as ever.
//!
//! Chords are made of runs, and a run is its neighbour's and one more: one invocation a line goes along it once, in four
//! directions at the same time, so that the cost does not grow with the feature size. Memory: 4 bytes a layer for the chords;
//! runs lie in the second column of the fields, which is free until they spread.

use crate::gpu::{GpuError, Resource, ShaderSpec};
use crate::passes::store::StoreModules;
use crate::passes::{Context, SweepParameters};
use crate::plan::{FramePlan, Pass};

/// Rounds of loops that one dispatch may take in an invocation ([`crate::passes::features`] says why there is a limit).
const ROUNDS: u32 = 1 << 15;

/// The shader of the runs.
pub fn runs_spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new("passes/illustration/runs"))
}

/// The shader of the chords.
pub fn chords_spec(plan: &FramePlan) -> ShaderSpec {
    StoreModules::of(plan).layout(ShaderSpec::new("passes/illustration/chords"))
}

/// Measures the chords of all layers.
///
/// # Errors
/// [`GpuError`] of the device.
pub fn measure(context: &mut Context<'_>) -> Result<(), GpuError> {
    let (width, rows) = (context.width(), context.rows());
    let kernel = context.shaders.kernel(&runs_spec(context.plan), "main")?;
    let lines = width.max(rows).div_ceil(64);
    let piece = (ROUNDS / context.longest().saturating_add(1)).max(1);
    for first in (0..width.max(rows)).step_by(piece as usize) {
        let sweep = SweepParameters { first, end: first + piece, _pad: [0; 2] };
        let mut resources = context.resources.clone();
        resources.set("sweep", Resource::Buffer(context.gpu.uniform("sweep", &sweep)?));
        context.recorder.compute(Pass::FeatureSize, &kernel, &context.frame, &resources, [lines, 4, 1])?;
    }
    context.per_pixel(Pass::FeatureSize, &chords_spec(context.plan), "main")
}
