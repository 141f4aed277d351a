//! Stage 2, features: what is computed from the layers and their neighbours.

pub mod curvature;
pub mod neighbours;
