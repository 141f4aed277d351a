//! A [`Scene`] as OBJ with MTL, as STL and as PLY: for other programs, and to hold our own readers against.
//!
//! All three lie in the file's own coordinates: transforms are applied, instances written out. What a format cannot say is
//! left out: OBJ has no cameras and materials of Phong's day (metalness and roughness as the widely read `Pm` and `Pr`), STL
//! has nothing but triangles, PLY is one mesh with colours at its vertices. Textures are not written.

mod obj;
mod ply;
mod stl;

#[cfg(test)]
mod tests;

use glam::{DMat3, DMat4, DVec3, Vec3};

pub use obj::{write_mtl, write_obj};
pub use ply::{PlyEncoding, write_ply};
pub use stl::{write_stl_ascii, write_stl_binary};

use crate::scene::{Part, Primitive, Scene};

/// The file's space from a part's.
fn file_from_part(scene: &Scene, part: &Part) -> DMat4 {
    DMat4::from_translation(scene.origin) * part.world_from_part
}

/// A primitive's vertices and triangles in the file's space, wound as they are seen.
struct Placed<'a> {
    source: &'a Primitive,
    transform: DMat4,
    cofactors: DMat3,
    mirrors: bool,
}

impl<'a> Placed<'a> {
    fn new(source: &'a Primitive, transform: DMat4) -> Placed<'a> {
        let m = DMat3::from_mat4(transform);
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        Placed { source, transform, cofactors, mirrors: m.determinant() < 0.0 }
    }

    fn position(&self, v: usize) -> DVec3 {
        self.transform.transform_point3(Vec3::from(self.source.positions[v]).as_dvec3())
    }

    fn normal(&self, v: usize) -> DVec3 {
        let sign = if self.mirrors { -1.0 } else { 1.0 };
        (self.cofactors * Vec3::from(self.source.normals[v]).as_dvec3() * sign).normalize_or(DVec3::Z)
    }

    fn triangles(&self) -> impl Iterator<Item = [usize; 3]> {
        let mirrors = self.mirrors;
        self.source.triangles.iter().map(move |t| {
            let [a, b, c] = t.map(|v| v as usize);
            if mirrors { [a, c, b] } else { [a, b, c] }
        })
    }
}

/// All primitives of a part, in its order.
fn placed<'a>(scene: &'a Scene, part: &Part) -> impl Iterator<Item = Placed<'a>> + use<'a> {
    let transform = file_from_part(scene, part);
    scene.meshes[part.mesh].primitives.iter().map(move |p| Placed::new(p, transform))
}
