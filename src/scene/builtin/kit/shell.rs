//! Triangles with analytic vertices, welded into a [`Primitive`] at the end.

use std::collections::HashMap;

use glam::{DMat4, DVec3};

use crate::scene::Primitive;

/// Positions are rounded to multiples of a power of two: the smallest whose multiples up to `reach` are exact in `f32`,
/// with two bits to spare.
fn grid(reach: f64) -> f64 {
    2.0_f64.powi(reach.max(f64::MIN_POSITIVE).log2().ceil() as i32 - 22)
}

/// Normals are rounded to multiples of this, which leaves them unit to 1e-6.
const NORMAL_GRID: f64 = 1.0 / 1_048_576.0;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position, part units.
    pub position: DVec3,
    /// Unit outward normal.
    pub normal: DVec3,
}

impl Vertex {
    /// A vertex; `normal` need not be unit.
    pub fn new(position: DVec3, normal: DVec3) -> Vertex {
        Vertex { position, normal: normal.normalize_or_zero() }
    }
}

/// A growing surface: corners of triangles, not yet welded.
#[derive(Clone, Debug, Default)]
pub struct Shell {
    triangles: Vec<[Vertex; 3]>,
}

impl Shell {
    /// An empty shell.
    pub fn new() -> Shell {
        Shell::default()
    }

    /// Adds a triangle, wound so that its face looks the way its normals do.
    pub fn triangle(&mut self, a: Vertex, b: Vertex, c: Vertex) {
        let face = (b.position - a.position).cross(c.position - a.position);
        let outward = face.dot(a.normal + b.normal + c.normal) >= 0.0;
        self.triangles.push(if outward { [a, b, c] } else { [a, c, b] });
    }

    /// Adds the quadrilateral a, b, c, d (in order around it), split along its shorter diagonal.
    pub fn quad(&mut self, a: Vertex, b: Vertex, c: Vertex, d: Vertex) {
        if a.position.distance_squared(c.position) <= b.position.distance_squared(d.position) * (1.0 + 1e-9) {
            self.triangle(a, b, c);
            self.triangle(a, c, d);
        } else {
            self.triangle(b, c, d);
            self.triangle(b, d, a);
        }
    }

    /// A strip of quadrilaterals between two rows of equal length.
    pub fn strip(&mut self, low: &[Vertex], high: &[Vertex]) {
        for (l, h) in low.windows(2).zip(high.windows(2)) {
            self.quad(l[0], l[1], h[1], h[0]);
        }
    }

    /// Adds another shell after a rigid motion (or a uniform scale).
    pub fn add(&mut self, other: &Shell, self_from_other: DMat4) {
        let mirrored = self_from_other.determinant() < 0.0;
        let moved = |v: Vertex| {
            Vertex::new(self_from_other.transform_point3(v.position), self_from_other.transform_vector3(v.normal))
        };
        self.triangles.extend(other.triangles.iter().map(|t| {
            let [a, b, c] = t.map(moved);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }

    /// This shell after a rigid motion.
    #[must_use]
    pub fn moved(&self, motion: DMat4) -> Shell {
        let mut moved = Shell::new();
        moved.add(self, motion);
        moved
    }

    /// This shell shifted along z.
    #[must_use]
    pub fn at_z(&self, z: f64) -> Shell {
        self.moved(DMat4::from_translation(DVec3::Z * z))
    }

    /// Welds equal vertices and gives the primitive. Triangles that the grid collapses to an edge are dropped.
    pub fn primitive(&self, material: usize) -> Primitive {
        let mut primitive = Primitive { material, ..Primitive::default() };
        let mut known: HashMap<[i64; 6], u32> = HashMap::new();
        let reach = self.triangles.iter().flatten().map(|v| v.position.abs().max_element()).fold(0.0, f64::max);
        let grid = grid(reach);
        for triangle in &self.triangles {
            let cells = triangle.map(|v| (v.position / grid).round().as_i64vec3());
            if cells[0] == cells[1] || cells[1] == cells[2] || cells[2] == cells[0] {
                continue;
            }
            let indices = std::array::from_fn(|i| {
                let normal = (triangle[i].normal / NORMAL_GRID).round();
                let cell = cells[i];
                let n = normal.as_i64vec3();
                *known.entry([cell.x, cell.y, cell.z, n.x, n.y, n.z]).or_insert_with(|| {
                    primitive.positions.push((cell.as_dvec3() * grid).as_vec3().to_array());
                    // Adding zero turns -0 into 0, so that files do not depend on its sign.
                    primitive.normals.push((normal * NORMAL_GRID + DVec3::ZERO).as_vec3().to_array());
                    (primitive.positions.len() - 1) as u32
                })
            });
            primitive.triangles.push(indices);
        }
        primitive
    }
}

/// What is wrong with a primitive as a closed surface; empty if nothing is. Vertices are identified by position.
#[cfg(test)]
pub fn faults(primitive: &Primitive) -> Vec<String> {
    use glam::Vec3;
    let mut faults = Vec::new();
    let point = |i: u32| Vec3::from(primitive.positions[i as usize]).as_dvec3();
    let normal = |i: u32| Vec3::from(primitive.normals[i as usize]).as_dvec3();
    let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    let mut uses: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
    let size = crate::math::Bounds::of_points((0..primitive.positions.len() as u32).map(point)).size().length();
    let (mut thin, mut against, mut unit) = (0, 0, 0);
    for t in &primitive.triangles {
        let [a, b, c] = t.map(point);
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - a).length()).max((c - b).length());
        let height = cross.length() / longest;
        if height.is_nan() || height <= size * 1e-7 {
            thin += 1;
        }
        if t.iter().any(|&i| normal(i).dot(cross.normalize_or_zero()) < 0.2) {
            against += 1;
        }
        unit +=
            t.iter().filter(|&&i| (normal(i).length_squared() - 1.0).abs() > 2e-5 || !normal(i).is_finite()).count();
        for e in 0..3 {
            let ends = [t[e], t[(e + 1) % 3]].map(|i| primitive.positions[i as usize].map(|c| (c + 0.0).to_bits()));
            let forward = ends[0] < ends[1];
            let key = if forward { ends } else { [ends[1], ends[0]] };
            *edges.entry(key).or_default() += if forward { 1 } else { -1 };
            *uses.entry(key).or_default() += 1;
        }
    }
    let open: Vec<_> = edges.iter().filter(|(_, balance)| **balance != 0).map(|(k, _)| *k).collect();
    if let Some(edge) = open.first() {
        let ends = edge.map(|p| p.map(f32::from_bits));
        faults.push(format!("{} open or wrongly wound edges, one from {:?} to {:?}", open.len(), ends[0], ends[1]));
    }
    let crowded = uses.values().filter(|&&n| n != 2).count();
    if crowded > 0 && open.is_empty() {
        faults.push(format!("{crowded} edges with more than two triangles"));
    }
    for (count, what) in
        [(thin, "degenerate triangles"), (against, "corners against their triangle"), (unit, "normals not unit")]
    {
        if count > 0 {
            faults.push(format!("{count} {what}"));
        }
    }
    if primitive.triangles.is_empty() {
        faults.push("no triangles".to_owned());
    }
    faults
}

/// Volume that a closed primitive encloses, part units cubed; negative if it is inside out.
#[cfg(test)]
pub fn volume(primitive: &Primitive) -> f64 {
    let point = |i: u32| glam::Vec3::from(primitive.positions[i as usize]).as_dvec3();
    primitive.triangles.iter().map(|t| t.map(point)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}
