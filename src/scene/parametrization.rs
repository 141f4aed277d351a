//! The parametrization that a mesh may have: its first set of texture coordinates, scaled to lengths.
//!
//! Two coordinates of a parametrization have nothing to do with each other or with the mesh's size: u may be an angle, v a time.
//! Each is multiplied by how far the surface goes while it changes by one, in the mean over the surface, and divided by the
//! mesh's radius. A difference is then about the distance along the surface in radii of the part, as the measure by continuity
//! has depth (T7), whatever the unit of the file and however the coordinates run.

use glam::{DVec2, DVec3, Vec3};

use super::{Mesh, Primitive};

/// How the first texture coordinates of a mesh become lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parametrization {
    /// What u and v are multiplied with: radii of the mesh for one unit of each.
    pub scale: DVec2,
}

impl Parametrization {
    /// That of a mesh; `None` if it has no texture coordinates, or none that tell its points apart.
    pub fn of(mesh: &Mesh) -> Option<Parametrization> {
        let radius = mesh.bounds_in(glam::DMat4::IDENTITY).bounding_sphere().radius;
        let (mut sums, mut area) = (DVec2::ZERO, 0.0);
        for primitive in mesh.primitives.iter().filter(|p| Parametrization::covers(p)) {
            for t in &primitive.triangles {
                let [a, b, c] = t.map(|i| Vec3::from(primitive.positions[i as usize]).as_dvec3());
                let [p, q, r] = t.map(|i| glam::Vec2::from(primitive.uvs[0][i as usize]).as_dvec2());
                let (edge, other, du, dv) = (b - a, c - a, q - p, r - p);
                let determinant = du.perp_dot(dv);
                let weight = edge.cross(other).length();
                let along_u: DVec3 = (edge * dv.y - other * du.y) / determinant;
                let along_v: DVec3 = (other * du.x - edge * dv.x) / determinant;
                let speeds = DVec2::new(along_u.length(), along_v.length());
                if speeds.is_finite() && weight > 0.0 {
                    sums += speeds * weight;
                    area += weight;
                }
            }
        }
        let scale = sums / (area * radius);
        (scale.is_finite() && scale.min_element() > 0.0).then_some(Parametrization { scale })
    }

    /// Whether the primitive has coordinates for all its vertices.
    pub fn covers(primitive: &Primitive) -> bool {
        !primitive.positions.is_empty() && primitive.uvs[0].len() == primitive.positions.len()
    }

    /// A vertex's coordinates as lengths.
    pub fn scaled(&self, uv: [f32; 2]) -> DVec2 {
        glam::Vec2::from(uv).as_dvec2() * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::samples::{grid, mesh};

    fn sheet(size: f64, units: [f32; 2]) -> Mesh {
        let mut p = grid(4, 6, |u, v| (DVec3::new(3.0 * u, 4.0 * v, 0.0) * size, DVec3::Z));
        p.uvs[0] = p.positions.iter().map(|q| [q[0] * units[0], q[1] * units[1]]).collect();
        mesh("sheet", p)
    }

    #[test]
    fn coordinates_become_lengths_in_radii_whatever_their_units() {
        for (size, units) in [(1.0, [1.0, 1.0]), (1000.0, [0.25, 7.0]), (0.01, [1.0, -3.0])] {
            let mesh = sheet(size, units);
            let parametrization = Parametrization::of(&mesh).unwrap();
            let uvs = &mesh.primitives[0].uvs[0];
            let [first, last] = [uvs[0], uvs[uvs.len() - 1]].map(|uv| parametrization.scaled(uv));
            // A sheet of 3 by 4 has a radius of 2.5.
            let across = (last - first).abs();
            assert!((across - DVec2::new(1.2, 1.6)).length() < 1e-5, "{across}");
        }
    }

    #[test]
    fn what_tells_no_points_apart_is_none() {
        assert_eq!(Parametrization::of(&sheet(1.0, [0.0, 1.0])), None);
        let mut none = sheet(1.0, [1.0, 1.0]);
        none.primitives[0].uvs[0].clear();
        assert_eq!(Parametrization::of(&none), None);
        assert_eq!(Parametrization::of(&Mesh::default()), None);
    }
}
