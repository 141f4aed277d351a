//! Pellucid shows the inside of 3D models without losing their shape.
//!
//! Rooms, in the order of their dependencies; ARCHITECTURE.md is the map.

pub mod app;
pub mod cli;
pub mod export;
pub mod gpu;
pub mod import;
pub mod math;
pub mod oracle;
pub mod passes;
pub mod plan;
pub mod render;
pub mod scene;
pub mod session;
pub mod settings;
pub mod tradeoff;
pub mod transfer;
