//! Fewer triangles for previews on a software rasterizer, which takes as long for a vertex as for many pixels.
//!
//! Vertices are merged by cells of a grid (Rossignac and Borrel 1993): those of one cell move to their mean, and a triangle
//! that loses a corner goes. Unlike there, vertices of one cell share a position but keep apart by the direction of their
//! normals, so that creases and the two sides of a wall stay lit as they were. The cells grow until the whole scene is inside
//! a budget. Parts keep their number, name and place whatever becomes of their meshes: small ones stay whole.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::scene::{Mesh, Part, Primitive, Scene};

/// A mesh is never made coarser than this.
const FEWEST_TRIANGLES: u64 = 48;
/// Cells across the scene's radius to begin with.
const FINEST: f64 = 400.0;

/// The scene with at most about `budget` instanced triangles, for pictures only; `None` if it has no more than that already.
pub fn simplified(scene: &Scene, budget: u64) -> Option<Scene> {
    let radius = scene.bounds().bounding_sphere().radius;
    if scene.triangle_count() <= budget || radius <= 0.0 || !radius.is_finite() {
        return None;
    }
    let scales = mesh_scales(scene);
    let uses: Vec<u64> =
        (0..scene.meshes.len()).map(|m| scene.parts.iter().filter(|p| p.mesh == m).count() as u64).collect();
    let mut cells = FINEST;
    let mut meshes: Vec<Mesh>;
    loop {
        let cell = radius / cells;
        meshes = scene.meshes.par_iter().zip(&scales).map(|(mesh, scale)| coarse(mesh, cell / scale)).collect();
        let total: u64 = meshes.iter().zip(&uses).map(|(m, n)| m.triangle_count() * n).sum();
        if total <= budget || cells < 8.0 {
            break;
        }
        cells /= 1.4;
    }
    let mut first = 0;
    let parts = scene
        .parts
        .iter()
        .map(|part| {
            let triangle_count = meshes[part.mesh].triangle_count() as u32;
            let part = Part { first_triangle: first, triangle_count, ..part.clone() };
            first += triangle_count;
            part
        })
        .collect();
    Some(Scene {
        name: scene.name.clone(),
        nodes: scene.nodes.clone(),
        meshes,
        materials: scene.materials.clone(),
        textures: scene.textures.clone(),
        images: scene.images.clone(),
        parts,
        cameras: scene.cameras.clone(),
        variants: scene.variants.clone(),
        origin: scene.origin,
        notices: Vec::new(),
        partition: scene.partition.clone(),
    })
}

/// How much larger than itself each mesh is shown, at most.
fn mesh_scales(scene: &Scene) -> Vec<f64> {
    let mut scales = vec![0.0_f64; scene.meshes.len()];
    for part in &scene.parts {
        let m = part.world_from_part;
        let largest = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate().length()).into_iter().fold(0.0, f64::max);
        scales[part.mesh] = scales[part.mesh].max(largest);
    }
    scales.into_iter().map(|s| if s > 0.0 && s.is_finite() { s } else { 1.0 }).collect()
}

/// The mesh in cells of this edge, or of a smaller one where too little would be left.
fn coarse(mesh: &Mesh, cell: f64) -> Mesh {
    let enough = mesh.triangle_count().min(FEWEST_TRIANGLES);
    let mut cell = cell;
    for _ in 0..12 {
        let coarse =
            Mesh { name: mesh.name.clone(), primitives: mesh.primitives.iter().map(|p| clustered(p, cell)).collect() };
        if coarse.triangle_count() >= enough {
            return coarse;
        }
        cell *= 0.5;
    }
    mesh.clone()
}

type Cell = [i64; 3];

fn cell_of(position: &[f32; 3], cell: f64) -> Cell {
    position.map(|x| (f64::from(x) / cell).floor() as i64)
}

/// Which way a normal faces: one of the six axes and, of the others, their signs.
fn facing(normal: &[f32; 3]) -> u8 {
    let n = Vec3::from_array(*normal);
    let a = n.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    axis * 8 + u8::from(n.x < 0.0) + 2 * u8::from(n.y < 0.0) + 4 * u8::from(n.z < 0.0)
}

fn clustered(primitive: &Primitive, cell: f64) -> Primitive {
    let mut means: HashMap<Cell, (DVec3, f64)> = HashMap::new();
    for position in &primitive.positions {
        let (sum, count) = means.entry(cell_of(position, cell)).or_insert((DVec3::ZERO, 0.0));
        *sum += Vec3::from_array(*position).as_dvec3();
        *count += 1.0;
    }
    let mut numbers: HashMap<(Cell, u8), u32> = HashMap::new();
    let mut first_of: Vec<usize> = Vec::new();
    let mut normals: Vec<Vec3> = Vec::new();
    let mut cells: Vec<Cell> = Vec::new();
    let new_index: Vec<u32> = (0..primitive.positions.len())
        .map(|i| {
            let at = cell_of(&primitive.positions[i], cell);
            let normal = primitive.normals.get(i).copied().unwrap_or([0.0, 0.0, 1.0]);
            let number = *numbers.entry((at, facing(&normal))).or_insert_with(|| {
                first_of.push(i);
                normals.push(Vec3::ZERO);
                cells.push(at);
                first_of.len() as u32 - 1
            });
            normals[number as usize] += Vec3::from_array(normal);
            number
        })
        .collect();
    let mut seen = std::collections::HashSet::new();
    let triangles = primitive
        .triangles
        .iter()
        .map(|t| t.map(|i| new_index[i as usize]))
        .filter(|t| {
            let corners = t.map(|i| cells[i as usize]);
            let flat = corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
            // The same three corners in whatever rotation are one triangle.
            let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
            !flat && seen.insert([t[least], t[(least + 1) % 3], t[(least + 2) % 3]])
        })
        .collect();
    fn pick<T: Copy>(all: &[T], first_of: &[usize]) -> Vec<T> {
        first_of.iter().filter_map(|&i| all.get(i).copied()).collect()
    }
    Primitive {
        positions: cells.iter().map(|c| (means[c].0 / means[c].1).as_vec3().to_array()).collect(),
        normals: normals
            .iter()
            .zip(&first_of)
            .map(|(n, &i)| n.try_normalize().map_or(primitive.normals[i], |n| n.to_array()))
            .collect(),
        tangents: pick(&primitive.tangents, &first_of),
        uvs: [pick(&primitive.uvs[0], &first_of), pick(&primitive.uvs[1], &first_of)],
        colors: pick(&primitive.colors, &first_of),
        triangles,
        material: primitive.material,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn the_budget_is_held_and_parts_stay_what_they_are() {
        let scene = builtin::build("gearbox").unwrap();
        let before = scene.triangle_count();
        let budget = before / 4;
        let coarse = simplified(&scene, budget).unwrap();
        let after = coarse.triangle_count();
        assert!(after <= budget && after > budget / 4, "{before} became {after}, budget {budget}");
        assert_eq!(coarse.parts.len(), scene.parts.len());
        let mut first = 0;
        for (a, b) in scene.parts.iter().zip(&coarse.parts) {
            assert_eq!((&a.name, a.node, a.mesh, a.bounds), (&b.name, b.node, b.mesh, b.bounds));
            assert!(b.triangle_count > 0 && b.first_triangle == first, "{}", b.name);
            first += b.triangle_count;
        }
        for primitive in coarse.meshes.iter().flat_map(|m| &m.primitives) {
            let n = primitive.positions.len();
            assert_eq!(primitive.normals.len(), n);
            assert!(primitive.triangles.iter().flatten().all(|&i| (i as usize) < n));
            assert!(primitive.normals.iter().all(|&v| (Vec3::from_array(v).length() - 1.0).abs() < 1e-3));
        }
        // Nothing moves further than the cells are large.
        let r = scene.bounds().bounding_sphere().radius;
        let boxes =
            |s: &Scene| s.parts.iter().map(|p| s.meshes[p.mesh].bounds_in(p.world_from_part)).collect::<Vec<_>>();
        for (a, b) in boxes(&scene).iter().zip(boxes(&coarse)) {
            assert!((a.min - b.min).length().max((a.max - b.max).length()) < 0.05 * r, "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_small_scene_is_left_alone() {
        let scene = builtin::build("gearbox").unwrap();
        assert!(simplified(&scene, u64::MAX).is_none());
        assert!(simplified(&Scene::default(), 0).is_none());
    }
}
