//! A small ray caster in `f64` for the tests of generated scenes: how many surfaces a ray crosses.

use glam::DVec3;

use crate::scene::Scene;

/// All instanced triangles of a scene, in scene space, in a grid over nothing: tests cast few rays.
pub struct Rays {
    triangles: Vec<[DVec3; 3]>,
}

impl Rays {
    /// Gathers the triangles of a finished scene.
    pub fn new(scene: &Scene) -> Rays {
        let mut triangles = Vec::new();
        for part in &scene.parts {
            for primitive in &scene.meshes[part.mesh].primitives {
                let place = |i: u32| {
                    let p = glam::Vec3::from(primitive.positions[i as usize]).as_dvec3();
                    part.world_from_part.transform_point3(p)
                };
                triangles.extend(primitive.triangles.iter().map(|t| t.map(place)));
            }
        }
        Rays { triangles }
    }

    /// How many triangles the line from `origin` in `direction` passes through.
    pub fn crossings(&self, origin: DVec3, direction: DVec3) -> usize {
        self.triangles.iter().filter(|t| hits(t, origin, direction)).count()
    }

    /// Crossings of `n` × `n` parallel rays that cover the square of half size `radius` around `center`.
    pub fn depth_map(&self, center: DVec3, radius: f64, direction: DVec3, n: usize) -> Vec<usize> {
        let forward = direction.normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        // Triangles are sorted into the rays that their rectangle covers, which makes this a small rasterizer.
        let mut counts = vec![0; n * n];
        let cell = 2.0 * radius / n as f64;
        for triangle in &self.triangles {
            let flat = triangle.map(|p| ((p - center).dot(right), (p - center).dot(up)));
            let range = |v: [f64; 3]| {
                let low = v.into_iter().fold(f64::INFINITY, f64::min);
                let high = v.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let first = ((low + radius) / cell - 0.5).ceil().max(0.0) as usize;
                let last = ((high + radius) / cell - 0.5).floor().min(n as f64 - 1.0);
                first..(last + 1.0).max(0.0) as usize
            };
            for j in range(flat.map(|f| f.1)) {
                for i in range(flat.map(|f| f.0)) {
                    let at = |k: usize| (k as f64 + 0.5) * cell - radius;
                    let origin = center + right * at(i) + up * at(j) - forward * (4.0 * radius);
                    counts[j * n + i] += usize::from(hits(triangle, origin, forward));
                }
            }
        }
        counts
    }
}

/// A line through a triangle, with edges decided by a rule that gives every shared edge to one side.
fn hits(&[a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> bool {
    let side = |p: DVec3, q: DVec3| {
        // Evaluated the same way for both triangles at an edge.
        let swap = (p.x, p.y, p.z) > (q.x, q.y, q.z);
        let (p, q) = if swap { (q, p) } else { (p, q) };
        ((p - origin).cross(q - origin).dot(direction) >= 0.0) != swap
    };
    let (ab, bc, ca) = (side(a, b), side(b, c), side(c, a));
    ab == bc && bc == ca
}
