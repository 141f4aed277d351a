//! Pellucid shows the inside of 3D models without losing their shape.

pub mod math;
pub mod oracle;
pub mod scene;
pub mod settings;
pub mod transfer;
