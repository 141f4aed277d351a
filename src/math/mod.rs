//! Geometry and colour primitives that every other room uses: the [`Camera`], [`Bounds`] and linear, premultiplied
//! colours, and which name a misspelt word was meant to be. Nothing here knows of scenes, files or the GPU.
//!
//! Cameras and bounds are kept in `f64`. Matrices are named by the spaces they connect, destination first
//! (`view_from_world`), and points and vectors by the space they live in (`point_in_view`).

mod bounds;
mod camera;
pub mod color;
mod image;
mod layer;
mod lights;
pub mod spelling;
pub mod views;

pub use bounds::{Bounds, Sphere};
pub use camera::{Camera, Projection, ViewFrustum};
pub use image::LinearImage;
pub use layer::LayerImage;
pub use lights::{DirectionalLight, Hemisphere, LightLevels, LightRig};
