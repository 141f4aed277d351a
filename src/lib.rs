//! Pellucid shows the inside of 3D models without losing their shape.
//!
//! Rooms, in the order of their dependencies; ARCHITECTURE.md is the map.

// Output goes through `cli::output`; a line printed elsewhere is a forgotten one.
#![warn(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

#[cfg(feature = "window")]
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
