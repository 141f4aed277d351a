//! What leaves the program: pictures and files.

pub mod image;
pub mod png;
