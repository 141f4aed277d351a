//! The renderer's stages in `f64` on the CPU: slow and obviously right.
//!
//! Every stage here takes plain data and gives plain data, so that a picture from the GPU can be judged stage by stage:
//! the oracle's stage is fed with the *read-back of the stage before*, and what comes out must be what the GPU made of
//! the same input. Only rasterization starts from the scene itself.
//!
//! | stage | module | takes | gives |
//! |---|---|---|---|
//! | capture | [`raster`] | scene, camera | [`Layers`]: every fragment of every pixel |
//! | | [`buckets`] | the fragments of one pixel, k | the paper's Z, B and data slots |
//! | | [`store`] | layers | [`StoreData`], the neutral form that read-backs have too |
//! | features | [`neighbours`] | store | four [`Link`]s a fragment |
//! | | [`curvature`] | store, links | κ and the 2×2 operator |
//! | shading | [`shade`], [`lighting`] | store, lights | lit colour |
//! | opacity | [`stylize`] | store, lit colour, κ, tables | colour and alpha |
//! | composite | [`composite`] | store, colour and alpha | the image |
//!
//! [`view`] reads camera and image size as the shaders do; [`analytic`] makes stores of surfaces whose curvature is
//! known in closed form.
//!
//! # Where either answer passes
//! Rasterizers snap vertices to 1/256 pixel, and `f32` has near-ties. A result that lies within such a threshold carries
//! an `ambiguous` flag; a comparison lets either answer pass there and counts how often it did (at most 2 %).
//!
//! # Where the contract left a choice
//! Noted in the module that had to choose, under *Choices*.

pub mod buckets;
pub mod lighting;
pub mod neighbours;
pub mod raster;
pub mod store;
mod texture;
pub mod view;

pub use buckets::{Books, BucketedPixel, PackedKey, WideKey, bucket_k_buffer};
pub use neighbours::{Direction, Link, Neighbours, neighbours};
pub use raster::{Fragment, Layers, Pixel, rasterize};
pub use store::StoreData;
pub use view::{Extents, View};
