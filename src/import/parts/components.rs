//! Connected components: triangles that share a vertex, where vertices at one place are one.
//!
//! Vertices are the same where their positions are, whatever their normals and texture coordinates; a seam is no gap. Files
//! also have gaps of rounding, so positions that are nearer to each other than [`ALWAYS`] of the diagonal of the mesh's box
//! count as one, and such as are farther apart than [`NEVER`] do not. Between the two it depends on where they fall in a grid:
//! all positions in a cell are one, and one near a cell's wall belongs to the next cell too. That takes the same time
//! wherever vertices lie; a search for neighbours would not.
//!
//! Pieces are numbered by size, the diagonal of their boxes, largest first; of equal ones the one that begins first in the
//! file. So "component 1" of a gearbox is its housing, and stays it when the file is read again.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxBuildHasher;

use crate::import::triangles::compact;
use crate::import::{Fallible, ImportOptions, Phase};
use crate::math::Bounds;
use crate::scene::{Mesh, Node, Primitive, Scene, weld_positions};

/// Nearer than this share of the diagonal two positions are one.
pub(super) const ALWAYS: f64 = 1e-7;
/// Farther than this share they are two: the diagonal of a cell, and the margin on either side.
#[cfg(test)]
pub(super) const NEVER: f64 = 2e-6;
/// The side of a cell, as a share of the diagonal: two positions that are one lie in a cell grown by `ALWAYS` on each side.
const CELL: f64 = 1e-6;

/// Divides all meshes, and the nodes that show them. Gives what the parts are, or how many there would be if those are too
/// many; then the scene is as it was.
pub(super) fn divide(scene: &mut Scene, most: u64, options: &ImportOptions) -> Fallible<Result<&'static str, String>> {
    let mut shown = vec![0_u64; scene.meshes.len()];
    scene.nodes.iter().filter_map(|n| n.mesh).for_each(|m| shown[m] += 1);
    let labels: Vec<Fallible<Components>> = scene
        .meshes
        .par_iter()
        .zip(&shown)
        .map(|(mesh, &shown)| {
            options.cancel.go_on()?;
            Ok(if shown > 0 { Components::of(mesh) } else { Components::default() })
        })
        .collect();
    let labels = labels.into_iter().collect::<Fallible<Vec<Components>>>()?;
    let parts: u64 = labels.iter().zip(&shown).map(|(c, shown)| c.count as u64 * shown).sum();
    if parts > most {
        return Ok(Err(format!("{parts} connected components")));
    }
    options.progress.tell(Phase::Parts, 0.5);
    let pieces: Vec<Vec<Mesh>> = std::mem::take(&mut scene.meshes)
        .into_par_iter()
        .zip(labels)
        .map(|(mesh, components)| components.cut(mesh))
        .collect();
    let mut places = Vec::new();
    for pieces in pieces {
        let first = scene.meshes.len();
        scene.meshes.extend(pieces);
        places.push(first..scene.meshes.len());
    }
    for n in 0..scene.nodes.len() {
        let Some(mesh) = scene.nodes[n].mesh else { continue };
        let pieces = places[mesh].clone();
        if pieces.len() <= 1 {
            scene.nodes[n].mesh = (!pieces.is_empty()).then_some(pieces.start);
            continue;
        }
        scene.nodes[n].mesh = None;
        // The node's name says whose component it is; that of the file says nothing more.
        let owner = Some(scene.nodes[n].name.as_str()).filter(|name| !name.is_empty() && *name != scene.name);
        let owner = owner.map(|name| format!("{name} ")).unwrap_or_default();
        for (number, piece) in pieces.enumerate() {
            let child = scene.nodes.len();
            let name = format!("{owner}component {}", number + 1);
            scene.nodes.push(Node { parent: Some(n), ..Node::root(name, Some(piece), DMat4::IDENTITY) });
            scene.nodes[n].children.push(child);
        }
    }
    Ok(Ok("connected components"))
}

/// Which component each triangle of a mesh belongs to.
#[derive(Debug, Default)]
pub(super) struct Components {
    /// Per triangle, primitive by primitive, by order of size.
    of_triangle: Vec<u32>,
    pub(super) count: usize,
}

impl Components {
    pub(super) fn of(mesh: &Mesh) -> Components {
        let positions: Vec<[f32; 3]> = mesh.primitives.iter().flat_map(|p| p.positions.iter().copied()).collect();
        let welded = weld_positions(&positions);
        let points: Vec<DVec3> = welded.firsts.iter().map(|&v| Vec3::from(positions[v as usize]).as_dvec3()).collect();
        let mut sets = Sets((0..points.len() as u32).collect());
        let mut triangles: Vec<u32> = Vec::new();
        let mut offset = 0;
        for p in &mesh.primitives {
            for t in &p.triangles {
                let [a, b, c] = t.map(|v| welded.ids[offset + v as usize]);
                sets.unite(a, b);
                sets.unite(b, c);
                triangles.push(a);
            }
            offset += p.positions.len();
        }
        // What is one piece already needs no tolerance.
        let first = triangles.first().map(|&t| sets.root(t));
        if triangles.iter().any(|&t| Some(sets.root(t)) != first) {
            unite_near(&points, &mut sets);
        }
        // Numbered in order of their first triangle, then by size.
        let mut numbers = vec![u32::MAX; points.len()];
        let mut boxes: Vec<Bounds> = Vec::new();
        for triangle in &mut triangles {
            let root = sets.root(*triangle) as usize;
            if numbers[root] == u32::MAX {
                numbers[root] = boxes.len() as u32;
                boxes.push(Bounds::EMPTY);
            }
            *triangle = numbers[root];
        }
        for (point, &position) in points.iter().enumerate() {
            let number = numbers[sets.root(point as u32) as usize];
            if let Some(bounds) = boxes.get_mut(number as usize) {
                *bounds = bounds.including(position);
            }
        }
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let sizes: Vec<f64> = boxes.iter().map(|b| b.size().length()).collect();
        order.sort_by(|&a, &b| sizes[b as usize].total_cmp(&sizes[a as usize]).then(a.cmp(&b)));
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &number)| rank[number as usize] = place as u32);
        triangles.iter_mut().for_each(|t| *t = rank[*t as usize]);
        Components { of_triangle: triangles, count: order.len() }
    }

    /// The mesh in pieces. Triangles keep their order.
    fn cut(self, mesh: Mesh) -> Vec<Mesh> {
        if self.count <= 1 {
            return vec![mesh];
        }
        let mut pieces: Vec<Mesh> =
            (0..self.count).map(|_| Mesh { name: mesh.name.clone(), primitives: Vec::new() }).collect();
        let mut labels = self.of_triangle.iter();
        for primitive in &mesh.primitives {
            // The triangles of each piece, dealt in one go.
            let mut dealt: HashMap<u32, Vec<[u32; 3]>, FxBuildHasher> = HashMap::default();
            for (&triangle, &label) in primitive.triangles.iter().zip(&mut labels) {
                dealt.entry(label).or_default().push(triangle);
            }
            for (label, triangles) in dealt {
                pieces[label as usize].primitives.push(part_of(primitive, triangles));
            }
        }
        pieces
    }
}

/// The primitive with only these triangles and their vertices.
fn part_of(primitive: &Primitive, mut triangles: Vec<[u32; 3]>) -> Primitive {
    let used = compact(&mut triangles, primitive.positions.len() as u64);
    fn pick<T: Copy>(used: &[u32], of: &[T]) -> Vec<T> {
        if of.is_empty() { Vec::new() } else { used.iter().map(|&v| of[v as usize]).collect() }
    }
    Primitive {
        positions: pick(&used, &primitive.positions),
        normals: pick(&used, &primitive.normals),
        tangents: pick(&used, &primitive.tangents),
        uvs: [pick(&used, &primitive.uvs[0]), pick(&used, &primitive.uvs[1])],
        colors: pick(&used, &primitive.colors),
        triangles,
        material: primitive.material,
    }
}

/// Unites the points that are nearer to each other than the tolerance.
fn unite_near(points: &[DVec3], sets: &mut Sets) {
    let bounds = Bounds::of_points(points.iter().copied());
    let diagonal = bounds.size().length();
    if bounds.is_empty() || diagonal == 0.0 {
        return;
    }
    let (cell, margin) = (CELL * diagonal, 0.5 * ALWAYS / CELL);
    let mut first_in: HashMap<[i64; 3], u32, FxBuildHasher> =
        HashMap::with_capacity_and_hasher(points.len() + points.len() / 4, FxBuildHasher);
    for (i, &point) in points.iter().enumerate() {
        let at = (point - bounds.min) / cell;
        // From the cell below to the one above, which seldom differ.
        let low = (at - margin).floor().to_array().map(|c| c as i64);
        let high = (at + margin).floor().to_array().map(|c| c as i64);
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let first = *first_in.entry([x, y, z]).or_insert(i as u32);
                    sets.unite(first, i as u32);
                }
            }
        }
    }
}

/// Disjoint sets; a set's root is its smallest member.
struct Sets(Vec<u32>);

impl Sets {
    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
