//! Shared models that exist twice, plain and compressed: the same scene within the format's precision.

use glam::DVec3;

use super::*;
use crate::import::tests::models;
use crate::import::{ImportOptions, load_with};

/// A grid of cells in which points are looked up.
struct Points {
    cell: f64,
    cells: std::collections::HashMap<[i64; 3], Vec<(DVec3, DVec3)>>,
}

impl Points {
    /// The vertices of a part with their normals, in scene space.
    fn of(scene: &Scene, part: usize, cell: f64) -> Points {
        let part = &scene.parts[part];
        let mut points = Points { cell, cells: Default::default() };
        let turn = part.world_from_part.inverse().transpose();
        for p in &scene.meshes[part.mesh].primitives {
            for (position, normal) in p.positions.iter().zip(&p.normals) {
                let at = part.world_from_part.transform_point3(glam::Vec3::from(*position).as_dvec3()) + scene.origin;
                let normal = turn.transform_vector3(glam::Vec3::from(*normal).as_dvec3()).normalize();
                points.cells.entry(points.key(at)).or_default().push((at, normal));
            }
        }
        points
    }

    fn key(&self, at: DVec3) -> [i64; 3] {
        (at / self.cell).floor().to_array().map(|c| c as i64)
    }

    fn all(&self) -> impl Iterator<Item = &(DVec3, DVec3)> {
        self.cells.values().flatten()
    }

    /// How far the nearest vertex is, and the largest cosine of normals among those within `near`.
    fn nearest(&self, (at, normal): (DVec3, DVec3), near: f64) -> (f64, f64) {
        let [x, y, z] = self.key(at);
        let (mut distance, mut cosine) = (f64::INFINITY, -1.0_f64);
        for key in (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k]))) {
            for (other, turned) in self.cells.get(&key).into_iter().flatten() {
                distance = distance.min(other.distance(at));
                if other.distance(at) <= near {
                    cosine = cosine.max(normal.dot(*turned));
                }
            }
        }
        (distance, cosine)
    }
}

fn area(scene: &Scene, part: usize) -> f64 {
    let part = &scene.parts[part];
    let at = |p: [f32; 3]| part.world_from_part.transform_point3(glam::Vec3::from(p).as_dvec3());
    scene.meshes[part.mesh]
        .primitives
        .iter()
        .flat_map(|p| p.triangles.iter().map(|t| t.map(|v| at(p.positions[v as usize]))))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum()
}

/// Compares part by part: no vertex may be farther from the other model's than a part's extent over `steps`, nor its normal turned
/// by more than `degrees`, but for one in a thousand.
fn compare(plain: &str, packed: &str, steps: f64, degrees: f64) {
    let Some(folder) = models() else { return };
    // Whether normals are averages of their facets is told by their last bits, which quantization takes.
    let options = ImportOptions { reweight_normals: false, ..ImportOptions::default() };
    let load = |path: &str| load_with(&folder.join(path), &options).unwrap_or_else(|e| panic!("{e}"));
    let (plain, packed) = (load(plain), load(packed));
    assert_eq!(plain.parts.len(), packed.parts.len());
    let (mut farthest, mut turned, mut vertices) = (0.0_f64, 0, 0);
    for (i, (a, b)) in plain.parts.iter().zip(&packed.parts).enumerate() {
        let materials = |s: &Scene, mesh: usize| -> Vec<([f32; 4], f32, f32)> {
            let of = |m: usize| (s.materials[m].base_color, s.materials[m].metallic, s.materials[m].roughness);
            s.meshes[mesh].primitives.iter().map(|p| of(p.material)).collect()
        };
        for (x, y) in materials(&plain, a.mesh).iter().zip(&materials(&packed, b.mesh)) {
            let near = |x: f32, y: f32| (x - y).abs() < 1e-4;
            assert!(x.0.iter().zip(&y.0).all(|(x, y)| near(*x, *y)) && near(x.1, y.1) && near(x.2, y.2), "part {i}");
        }
        // One step of the quantized grid, over the part's largest extent.
        let near = a.bounds.size().max_element() / steps;
        let (ours, theirs) = (Points::of(&plain, i, near), Points::of(&packed, i, near));
        for (from, to) in [(&ours, &theirs), (&theirs, &ours)] {
            for point in from.all() {
                let (distance, cosine) = to.nearest(*point, near);
                farthest = farthest.max(distance / near);
                turned += usize::from(cosine < degrees.to_radians().cos());
                vertices += 1;
            }
        }
        let (ours, theirs) = (area(&plain, i), area(&packed, i));
        assert!((ours - theirs).abs() < 4e-3 * ours, "part {i}: area {ours} and {theirs}");
    }
    println!("{vertices} vertices: at most {farthest:.3} steps apart, {turned} turned by more than {degrees}°");
    println!("{} and {} triangles", plain.triangle_count(), packed.triangle_count());
    // A sliver that rounding takes away takes its normals along.
    assert!(farthest <= 1.0 && turned * 1000 < vertices, "{farthest} steps, {turned} of {vertices} normals");
}

#[test]
fn a_quantized_model_is_the_plain_one() {
    compare("assemblies/CycloidalDrive.glb", "conformance/CycloidalDrive_quantized.glb", 8192.0, 1.5);
}

#[test]
fn a_draco_model_is_the_plain_one() {
    compare("assemblies/2CylinderEngine.glb", "conformance/2CylinderEngine_draco/2CylinderEngine.gltf", 1024.0, 4.0);
}
