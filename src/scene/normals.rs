//! Vertex normals.
use super::Primitive;

/// Replaces the normals of a primitive.
pub fn compute_normals(_primitive: &mut Primitive, _crease_angle: f64) {}

/// Re-weighted normals.
pub fn reweighted_normals(_primitive: &mut Primitive) -> bool {
    false
}
