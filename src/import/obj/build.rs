//! From triangles of indices to meshes and nodes.

use std::collections::HashMap;

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use super::statements::{Bucket, Model, NONE, PartName, Shading};
use crate::import::triangles::{clean, compact, given_normals, linear_color, origin_of, relative};
use crate::import::{Fallible, ImportOptions, Notices, Phase, tangents};
use crate::scene::{Material, Mesh, Node, NoticeKind, Primitive, compute_normals, weld};

/// Makes a mesh of every part, with one primitive a material, and the nodes that show them.
pub(super) fn build(
    model: Model,
    materials: &[Material],
    name: &str,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<(Vec<Node>, Vec<Mesh>)> {
    let origin = origin_of(&model.positions);
    let context = Context { model: &model, origin, options };
    let built: Vec<Fallible<(Option<Primitive>, Notices)>> = model
        .buckets
        .par_iter()
        .map(|bucket| {
            options.cancel.go_on()?;
            let mut notices = Notices::default();
            Ok((context.primitive(bucket, &mut notices), notices))
        })
        .collect();
    options.progress.tell(Phase::Geometry, 0.8);
    let mut meshes: Vec<Vec<Primitive>> = model.parts.iter().map(|_| Vec::new()).collect();
    let mut places: HashMap<(usize, usize), usize> = HashMap::new();
    for (bucket, result) in model.buckets.iter().zip(built) {
        let (primitive, told) = result?;
        notices.append(told);
        let Some(primitive) = primitive else { continue };
        let mesh = &mut meshes[bucket.part];
        let place = *places.entry((bucket.part, bucket.material)).or_insert(mesh.len());
        match mesh.get_mut(place) {
            Some(first) => append(first, primitive),
            None => mesh.push(primitive),
        }
    }
    for primitive in meshes.iter_mut().flatten() {
        let material = &materials[primitive.material];
        if let Some(map) = material.normal_texture {
            tangents::generate(primitive, map.uv_set as usize);
            notices.count(NoticeKind::Computed, "primitives with a normal map were given tangents", 1, "file");
        }
        let lacking = material.texture_refs().next().is_some() && primitive.uvs[0].is_empty();
        let what = "primitives lack the texture coordinates of their material's textures, which are sampled at (0, 0)";
        notices.count(NoticeKind::Approximated, what, lacking.into(), "file");
    }
    Ok(nodes(&model.parts, meshes, name, origin))
}

/// The nodes of the parts that have triangles, and their meshes.
fn nodes(parts: &[PartName], meshes: Vec<Vec<Primitive>>, name: &str, origin: DVec3) -> (Vec<Node>, Vec<Mesh>) {
    let (mut nodes, mut all): (Vec<Node>, Vec<Mesh>) = (Vec::new(), Vec::new());
    let shown: Vec<(&PartName, Vec<Primitive>)> = parts.iter().zip(meshes).filter(|(_, m)| !m.is_empty()).collect();
    let mut groups = HashMap::new();
    for (part, _) in &shown {
        *groups.entry(part.object.clone()).or_insert(0_usize) += 1;
    }
    let mut parents = HashMap::new();
    for (part, primitives) in shown {
        let grouped = !part.object.is_empty() && groups.get(&part.object).is_some_and(|&n| n > 1);
        let parent = grouped.then(|| {
            *parents.entry(part.object.clone()).or_insert_with(|| {
                nodes.push(Node::root(part.object.clone(), None, DMat4::IDENTITY));
                nodes.len() - 1
            })
        });
        let label = match (grouped, part.object.as_str(), part.group.as_str()) {
            (true, _, "") => "default",
            (true, _, group) => group,
            (false, "", "") => name,
            (false, "", group) => group,
            (false, object, _) => object,
        };
        let mut node = Node::root(label, Some(all.len()), DMat4::from_translation(origin));
        node.parent = parent;
        if let Some(parent) = parent {
            let child = nodes.len();
            nodes[parent].children.push(child);
        }
        nodes.push(node);
        all.push(Mesh { name: String::new(), primitives });
    }
    (nodes, all)
}

struct Context<'a> {
    model: &'a Model,
    origin: DVec3,
    options: &'a ImportOptions,
}

impl Context<'_> {
    /// The triangles of a bucket as a primitive; none if nothing of them can be drawn.
    fn primitive(&self, bucket: &Bucket, notices: &mut Notices) -> Option<Primitive> {
        let corners = bucket.triangles.as_flattened();
        let welded = weld(corners.len(), |i| corners[i]);
        let mut triangles: Vec<[u32; 3]> = welded.ids.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        let place = match self.model.materials[bucket.material].as_str() {
            "" => "file".to_owned(),
            material => format!("faces of material '{material}'"),
        };
        let positions: Vec<[f32; 3]> = welded
            .firsts
            .iter()
            .map(|&c| relative(self.model.positions[corners[c as usize][0] as usize], self.origin))
            .collect();
        clean(&mut triangles, &positions, &place, notices);
        let kept = compact(&mut triangles, positions.len() as u64);
        if triangles.is_empty() {
            return None;
        }
        let vertices: Vec<[u32; 3]> = kept.iter().map(|&k| corners[welded.firsts[k as usize] as usize]).collect();
        let mut p = Primitive {
            positions: kept.iter().map(|&k| positions[k as usize]).collect(),
            triangles,
            material: bucket.material,
            ..Primitive::default()
        };
        if vertices.iter().any(|v| v[1] != NONE) {
            // Images have their first row at the top here, and v goes down.
            let uv = |v: &[u32; 3]| self.model.uvs.get(v[1] as usize).map_or([0.0; 2], |&[u, v]| [u, 1.0 - v]);
            p.uvs[0] = vertices.iter().map(uv).collect();
        }
        if !self.model.colors.is_empty() {
            let color = |v: &[u32; 3]| self.model.colors.get(v[0] as usize).copied().unwrap_or([1.0; 3]);
            p.colors = vertices.iter().map(color).map(|[r, g, b]| linear_color([r, g, b, 1.0])).collect();
        }
        match bucket.shading {
            Shading::Given => {
                let stored = vertices.iter().map(|v| self.model.normals[v[2] as usize]).collect();
                given_normals(&mut p, Some(stored), self.options, &place, notices);
            }
            Shading::Smooth(_) => {
                compute_normals(&mut p, 180.0);
                let what = "primitives without normals were smoothed by their smoothing groups";
                notices.count(NoticeKind::Computed, what, 1, &place);
            }
            Shading::Crease => {
                given_normals(&mut p, None, self.options, &place, notices);
            }
        }
        Some(p)
    }
}

/// Joins two primitives of one material. Texture coordinates that one of them lacks are 0.
fn append(first: &mut Primitive, second: Primitive) {
    let (count, more) = (first.positions.len(), second.positions.len());
    let offset = count as u32;
    first.triangles.extend(second.triangles.iter().map(|t| t.map(|v| v + offset)));
    first.positions.extend(second.positions);
    first.normals.extend(second.normals);
    if !first.uvs[0].is_empty() || !second.uvs[0].is_empty() {
        first.uvs[0].resize(count, [0.0; 2]);
        first.uvs[0].extend(&second.uvs[0]);
        first.uvs[0].resize(count + more, [0.0; 2]);
    }
    // All primitives of a file have colours, or none.
    first.colors.extend(second.colors);
}
