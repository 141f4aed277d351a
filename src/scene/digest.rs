//! A number that changes when anything that is drawn does.

use std::hash::{DefaultHasher, Hasher};

use super::Scene;

impl Scene {
    /// A 64-bit digest of geometry, transforms, materials and images: what was measured of a scene holds for the same digest.
    /// The same program gives the same digest of the same scene on every run; another version may give another.
    pub fn digest(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        let mut bytes = |data: &[u8]| {
            // Lengths keep what follows apart.
            hasher.write_usize(data.len());
            hasher.write(data);
        };
        for mesh in &self.meshes {
            bytes(&mesh.primitives.len().to_le_bytes());
            for p in &mesh.primitives {
                bytes(bytemuck::cast_slice(&p.positions));
                bytes(bytemuck::cast_slice(&p.normals));
                bytes(bytemuck::cast_slice(&p.tangents));
                p.uvs.iter().for_each(|uvs| bytes(bytemuck::cast_slice(uvs)));
                bytes(bytemuck::cast_slice(&p.colors));
                bytes(bytemuck::cast_slice(&p.triangles));
                bytes(&p.material.to_le_bytes());
            }
        }
        for part in &self.parts {
            bytes(&part.mesh.to_le_bytes());
            bytes(bytemuck::cast_slice(&part.world_from_part.to_cols_array()));
        }
        // A material is its fields; `Debug` names them all.
        self.materials.iter().for_each(|m| bytes(format!("{m:?}").as_bytes()));
        self.textures.iter().for_each(|t| bytes(format!("{t:?}").as_bytes()));
        for image in &self.images {
            bytes(&image.width.to_le_bytes());
            bytes(&image.rgba);
        }
        hasher.finish()
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::builtin;

    #[test]
    fn a_digest_changes_with_what_is_drawn_and_with_nothing_else() {
        let scene = || builtin::build("quads?layers=3&parts=2").unwrap();
        let digest = scene().digest();
        assert_eq!(scene().digest(), digest);
        let mut renamed = scene();
        renamed.name = "other".to_owned();
        assert_eq!(renamed.digest(), digest);
        let mut moved = scene();
        moved.parts[1].world_from_part.w_axis.x += 1e-9;
        let mut bent = scene();
        bent.meshes[0].primitives[0].normals[0][0] += 1e-6;
        let mut painted = scene();
        painted.materials[0].roughness *= 0.5;
        for changed in [moved, bent, painted] {
            assert!(changed.digest() != digest);
        }
    }
}
