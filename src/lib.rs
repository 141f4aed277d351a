//! Pellucid shows the inside of 3D models without losing their shape.

pub mod export;
pub mod math;
pub mod scene;
pub mod settings;
pub mod transfer;
