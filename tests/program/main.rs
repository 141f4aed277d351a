//! Tests of the program as a whole: its shaders, its structure, the real binary, real models.

mod commands;
mod desk;
mod drop_source;
mod hard_cases;
mod models;
mod pace;
mod sessions;
mod shaders;
mod structure;
mod support;
mod tradeoff;
mod window;
