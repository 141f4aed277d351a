//! Stage 2, features: what is computed from the layers and their neighbours.

pub mod cases;
pub mod curvature;
pub mod neighbours;
pub mod parameters;

use crate::plan::FramePlan;

/// Rounds of loops that an invocation of these passes may take. Mesa's software rasterizer ends all loops of an invocation,
/// in silence, after 65 535 rounds together.
const ROUNDS: u32 = 1 << 14;

/// Layers of a pixel that one invocation takes where each of them reads the lists of four other pixels, or walks along the
/// links in four directions. `longest` bounds the length of a list.
pub fn chunk(plan: &FramePlan, longest: u32) -> u32 {
    let reach = plan.features.map_or(1, |f| f.reach);
    (ROUNDS / 4 / longest.max(reach).max(1)).clamp(1, 64)
}
