//! The renderer's stages in `f64` on the CPU, slow and obviously right.

pub mod lighting;
