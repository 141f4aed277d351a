//! Tangents by MikkTSpace, the algorithm that glTF names and that normal maps are baked with.
//!
//! The algorithm works on triangle corners; corners of one vertex may get different tangents (at mirrored texture
//! coordinates, for one), so vertices are split. glTF's texture coordinates run down and its bitangent up, so the sign
//! is the opposite of the library's.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DVec3, Vec3};

use crate::scene::Primitive;

/// The library walks around a vertex by recursion: with more triangles than this at one point it might exhaust the
/// stack.
const MOST_TRIANGLES_AT_A_POINT: u32 = 2000;

/// A tangent for a normal where texture coordinates give none.
pub(super) fn any(normal: [f32; 3]) -> [f32; 4] {
    let normal = Vec3::from(normal).try_normalize().unwrap_or(Vec3::Z);
    let [x, y, z] = normal.any_orthonormal_vector().to_array();
    [x, y, z, 1.0]
}

/// Computes the primitive's tangents from texture coordinate set `uv_set`, splitting vertices. Where the coordinates
/// have no area, or there are none, a tangent is some direction in the surface: always finite, of unit length.
pub(super) fn generate(primitive: &mut Primitive, uv_set: usize) {
    let mut corners = vec![None; primitive.triangles.len() * 3];
    if let Some(uvs) = primitive.uvs.get(uv_set).filter(|uvs| !uvs.is_empty())
        && valence(primitive) <= MOST_TRIANGLES_AT_A_POINT
    {
        let mut input = Input {
            primitive,
            positions: tamed(&primitive.positions),
            uvs: tamed(uvs),
            corners: std::mem::take(&mut corners),
        };
        // The error type has no values.
        let _ = generate_tangents(&mut input);
        corners = input.corners;
    }
    let mut tangents: Vec<Option<[f32; 4]>> = vec![None; primitive.positions.len()];
    let mut splits: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (corner, computed) in corners.into_iter().enumerate() {
        let (triangle, place) = (corner / 3, corner % 3);
        let vertex = primitive.triangles[triangle][place];
        let tangent = computed.and_then(unit).unwrap_or_else(|| any(primitive.normals[vertex as usize]));
        match tangents[vertex as usize] {
            None => tangents[vertex as usize] = Some(tangent),
            Some(present) if present == tangent => {}
            Some(_) => {
                let split = *splits.entry((vertex, tangent.map(f32::to_bits))).or_insert_with(|| {
                    tangents.push(Some(tangent));
                    duplicate(primitive, vertex as usize)
                });
                primitive.triangles[triangle][place] = split;
            }
        }
    }
    primitive.tangents =
        tangents.into_iter().zip(&primitive.normals).map(|(t, &n)| t.unwrap_or_else(|| any(n))).collect();
}

fn unit([x, y, z, w]: [f32; 4]) -> Option<[f32; 4]> {
    let [x, y, z] = DVec3::new(x.into(), y.into(), z.into()).try_normalize()?.as_vec3().to_array();
    Some([x, y, z, w])
}

/// The largest number of triangles around one position.
fn valence(primitive: &Primitive) -> u32 {
    let mut counts: HashMap<[u32; 3], u32> = HashMap::new();
    for &v in primitive.triangles.as_flattened() {
        *counts.entry(primitive.positions[v as usize].map(|c| (c + 0.0).to_bits())).or_default() += 1;
    }
    counts.into_values().max().unwrap_or(0)
}

/// Values moved and scaled to about 1 if they are so large or so small that `f32` products would overflow or vanish;
/// directions do not change by that.
fn tamed<const N: usize>(values: &[[f32; N]]) -> Vec<[f32; N]> {
    let largest = values.as_flattened().iter().fold(0.0_f32, |m, c| m.max(c.abs()));
    if (1e-4..=1e6).contains(&largest) || largest == 0.0 {
        return values.to_vec();
    }
    let largest = f64::from(largest);
    values.iter().map(|v| v.map(|c| (f64::from(c) / largest) as f32)).collect()
}

/// Appends a copy of all attributes but tangents; gives its index.
fn duplicate(primitive: &mut Primitive, vertex: usize) -> u32 {
    let new = primitive.positions.len();
    primitive.positions.push(primitive.positions[vertex]);
    primitive.normals.push(primitive.normals[vertex]);
    for uvs in &mut primitive.uvs {
        if let Some(&uv) = uvs.get(vertex) {
            uvs.push(uv);
        }
    }
    if let Some(&color) = primitive.colors.get(vertex) {
        primitive.colors.push(color);
    }
    new as u32
}

struct Input<'a> {
    primitive: &'a Primitive,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    corners: Vec<Option<[f32; 4]>>,
}

impl Input<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Input<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)]
    }

    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, corner: usize) {
        self.corners[3 * face + corner] = tangent_space.map(|space| {
            let [x, y, z, w] = space.tangent_encoded();
            [x, y, z, -w]
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of `n` triangles around its center, with texture coordinates from the positions (v down).
    fn disc(n: u32) -> Primitive {
        let ring = (0..n).map(|i| (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos());
        let mut p = Primitive::default();
        p.positions.push([0.0; 3]);
        p.positions.extend(ring.map(|(sin, cos)| [cos as f32, sin as f32, 0.0]));
        p.uvs[0] = p.positions.iter().map(|&[x, y, _]| [0.5 + x, 0.5 - y]).collect();
        p.normals = vec![[0.0, 0.0, 1.0]; p.positions.len()];
        p.triangles = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        p
    }

    #[test]
    fn a_disc_has_one_direction() {
        let mut p = disc(64);
        generate(&mut p, 0);
        assert_eq!(p.positions.len(), 65, "nothing is split");
        for &[x, y, z, w] in &p.tangents {
            assert!(x > 0.999 && y.abs() < 1e-3 && z.abs() < 1e-3 && w == 1.0);
        }
    }

    #[test]
    fn very_many_triangles_at_a_point_do_not_exhaust_the_stack() {
        for n in [MOST_TRIANGLES_AT_A_POINT, 200_000] {
            let mut p = disc(n);
            generate(&mut p, 0);
            assert_eq!(p.tangents.len(), p.positions.len());
            assert!(p.tangents.iter().flatten().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn without_coordinates_tangents_lie_in_the_surface() {
        let mut p = disc(5);
        generate(&mut p, 1);
        assert!(p.tangents.iter().all(|t| t[2].abs() < 1e-6 && t[3] == 1.0));
    }
}
