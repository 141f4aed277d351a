//! What leaves the program: pictures and models.

pub mod assets;
pub mod exr;
pub mod glb;
pub mod image;
pub mod mesh_files;
pub mod png;
