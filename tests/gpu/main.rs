//! Tests that need an adapter (a GPU, or lavapipe): the stages against the `f64` oracle, the captures against each other,
//! the traps of the papers, curvature on surfaces whose curvature is known.
//!
//! One binary, because each links the whole of wgpu, and one renderer, because every pipeline compiles once in it.
//! Matrices of settings are sampled; all of them run where `PELLUCID_TEST_FULL` is set. Where no adapter answers the tests
//! say `SKIPPED`, unless `CI` is set: then they fail.

mod accuracy;
mod arrangement;
mod captures;
mod common;
mod curvature;
mod hard_cases;
mod histogram;
mod illustration;
mod illustrative;
mod matrix;
mod meshes;
mod parameters;
mod pictures;
mod raster;
mod reuse;
mod sections;
mod stages;
mod study;
mod tradeoff;
mod traps;
mod traps_of_geometry;
