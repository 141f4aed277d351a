//! Triangles of several nodes in one mesh: transforms are applied to them.
//!
//! The new meshes lie relative to the middle of the scene, so that `f32` keeps them; the node has the offset. Normals go with
//! the inverse transpose, triangles of a node that mirrors are turned around.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::import::{Fallible, Fault, ImportOptions};
use crate::scene::{Mesh, Node, Primitive, Scene};

/// One part for each material that is used, in order of the materials.
pub(super) fn by_material(
    scene: &mut Scene,
    most: u64,
    options: &ImportOptions,
) -> Fallible<Result<&'static str, String>> {
    let shown = scene.nodes.iter().filter_map(|n| scene.meshes.get(n.mesh?)).flat_map(|m| &m.primitives);
    let mut used: Vec<usize> = shown.filter(|p| !p.triangles.is_empty()).map(|p| p.material).collect();
    used.sort_unstable();
    used.dedup();
    if used.len() as u64 > most {
        return Ok(Err(format!("{} materials", used.len())));
    }
    let (origin, primitives) = bake(scene, options)?;
    scene.meshes.clear();
    scene.nodes.clear();
    for primitive in primitives {
        let material = scene.materials.get(primitive.material).map(|m| m.name.clone()).unwrap_or_default();
        let name = if material.is_empty() { format!("material {}", primitive.material) } else { material };
        scene.nodes.push(Node::root(name, Some(scene.meshes.len()), DMat4::from_translation(origin)));
        scene.meshes.push(Mesh { name: String::new(), primitives: vec![primitive] });
    }
    Ok(Ok("materials"))
}

/// One part.
pub(super) fn whole(scene: &mut Scene, options: &ImportOptions) -> Fallible<Result<&'static str, String>> {
    // What is one part already stays as it is.
    if scene.nodes.iter().filter(|n| n.mesh.is_some()).count() > 1 {
        let (origin, primitives) = bake(scene, options)?;
        scene.meshes = vec![Mesh { name: String::new(), primitives }];
        scene.nodes = vec![Node::root(scene.name.clone(), Some(0), DMat4::from_translation(origin))];
    }
    Ok(Ok("the whole file"))
}

/// All triangles that are shown, by material, relative to the point that is given with them.
fn bake(scene: &Scene, options: &ImportOptions) -> Fallible<(DVec3, Vec<Primitive>)> {
    let shown: Vec<(DMat4, &Mesh)> = (0..scene.nodes.len())
        .filter_map(|n| {
            let mesh = scene.meshes.get(scene.nodes[n].mesh?)?;
            // In the file's space: the scene may have been re-based.
            Some((DMat4::from_translation(scene.origin) * scene.world_from_node(n), mesh))
        })
        .collect();
    let limits = &options.limits;
    let triangles: u64 = shown.iter().map(|(_, mesh)| mesh.triangle_count()).sum();
    let vertices: u64 = shown.iter().flat_map(|(_, m)| &m.primitives).map(|p| p.positions.len() as u64).sum();
    for (what, needed, allowed) in [
        ("triangles", triangles, limits.most_triangles()),
        ("vertices", vertices, limits.vertices.min(u32::MAX.into())),
    ] {
        if needed > allowed {
            return Err(Fault::limit("parts: all instances in one mesh", what, needed, allowed));
        }
    }
    let bounds = shown.iter().fold(crate::math::Bounds::EMPTY, |b, (world, mesh)| b.union(mesh.bounds_in(*world)));
    let origin = bounds.center();
    let mut places: HashMap<usize, usize> = HashMap::new();
    let mut primitives: Vec<Primitive> = Vec::new();
    for (world, mesh) in shown {
        options.cancel.go_on()?;
        for source in mesh.primitives.iter().filter(|p| !p.triangles.is_empty()) {
            let place = *places.entry(source.material).or_insert(primitives.len());
            if place == primitives.len() {
                primitives.push(Primitive { material: source.material, ..Primitive::default() });
            }
            append(&mut primitives[place], source, DMat4::from_translation(-origin) * world);
        }
    }
    primitives.sort_by_key(|p| p.material);
    Ok((origin, primitives))
}

fn append(to: &mut Primitive, from: &Primitive, transform: DMat4) {
    let before = to.positions.len();
    let offset = before as u32;
    let linear = DMat3::from_mat4(transform);
    let mirrors = linear.determinant() < 0.0;
    let turned = |[a, b, c]: [u32; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
    to.triangles.extend(from.triangles.iter().map(|&t| turned(t.map(|v| v + offset))));
    let point = |p: &[f32; 3]| transform.transform_point3(Vec3::from(*p).as_dvec3()).as_vec3().to_array();
    to.positions.extend(from.positions.iter().map(point));
    // The matrix of cofactors: the inverse transpose but for its scale, and there where the matrix has no inverse.
    let cofactors = DMat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    );
    let sign = if mirrors { -1.0 } else { 1.0 };
    let unit = |v: DVec3, otherwise: [f32; 3]| v.try_normalize().map_or(otherwise, |v| v.as_vec3().to_array());
    let normal = |n: &[f32; 3]| unit(cofactors * Vec3::from(*n).as_dvec3() * sign, [0.0, 0.0, 1.0]);
    to.normals.extend(from.normals.iter().map(normal));
    let tangent = |&[x, y, z, w]: &[f32; 4]| {
        let [x, y, z] = unit(linear * Vec3::new(x, y, z).as_dvec3(), [1.0, 0.0, 0.0]);
        [x, y, z, w * sign as f32]
    };
    // Columns that one has and the other lacks are filled with what stands for nothing.
    fn column<T: Copy>(to: &mut Vec<T>, from: impl ExactSizeIterator<Item = T>, before: usize, count: usize, fill: T) {
        if !to.is_empty() || from.len() > 0 {
            to.resize(before, fill);
            to.extend(from);
            to.resize(before + count, fill);
        }
    }
    let count = from.positions.len();
    column(&mut to.tangents, from.tangents.iter().map(tangent), before, count, [1.0, 0.0, 0.0, 1.0]);
    column(&mut to.uvs[0], from.uvs[0].iter().copied(), before, count, [0.0; 2]);
    column(&mut to.uvs[1], from.uvs[1].iter().copied(), before, count, [0.0; 2]);
    column(&mut to.colors, from.colors.iter().copied(), before, count, [1.0; 4]);
}
