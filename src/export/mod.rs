//! Writes what Pellucid has: models.

pub mod glb;
