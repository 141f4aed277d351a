//! Pellucid shows the inside of 3D models without losing their shape.

pub mod cli;
pub mod export;
pub mod math;
pub mod scene;
pub mod settings;
mod stub;
pub mod transfer;

// The renderer, the importer and the generated scenes are written elsewhere; delete with `stub.rs`.
pub use stub::{gpu, import, plan, render};
