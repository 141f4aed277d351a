//! Tests of the program as a whole: its shaders, its structure, the real binary, real models.

mod commands;
mod compare;
mod configuration;
mod desk;
mod drop_source;
mod exr;
mod hard_cases;
mod importing;
mod models;
mod pace;
mod place;
mod sessions;
mod shaders;
mod shells;
mod structure;
mod support;
mod tradeoff;
mod watch;
mod window;
