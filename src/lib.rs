//! Pellucid shows the inside of 3D models without losing their shape.
//!
//! Rooms, in the order of their dependencies; ARCHITECTURE.md is the map.

pub mod math;
pub mod scene;
pub mod transfer;
pub mod settings;
pub mod plan;
pub mod oracle;
pub mod gpu;
pub mod passes;
pub mod render;
