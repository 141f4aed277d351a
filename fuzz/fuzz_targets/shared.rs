//! What the targets share: small limits, so that no input is slow by right, and what a scene promises.

use pellucid::import::{ImportOptions, Limits};
use pellucid::scene::Scene;

/// Options under which every input has to end soon.
pub fn options() -> ImportOptions {
    let limits = Limits {
        bytes: 1 << 20,
        vertices: 1 << 14,
        triangles: 1 << 14,
        image_side: 256,
        image_pixels: 1 << 16,
        node_depth: 64,
        parts: 64,
        ..Limits::default()
    };
    ImportOptions { limits, ..ImportOptions::default() }
}

/// All that a finished scene promises.
pub fn check(scene: &Scene) {
    for p in scene.meshes.iter().flat_map(|m| &m.primitives) {
        let count = p.positions.len();
        assert!(p.triangles.as_flattened().iter().all(|&v| (v as usize) < count), "an index beyond the vertices");
        assert!(p.positions.iter().chain(&p.normals).flatten().all(|c| c.is_finite()), "a number that is not finite");
        assert!(p.material < scene.materials.len(), "a material that does not exist");
        assert_eq!(p.normals.len(), count, "normals");
        for length in [p.tangents.len(), p.uvs[0].len(), p.uvs[1].len(), p.colors.len()] {
            assert!(length == 0 || length == count, "a column of another length");
        }
    }
    for reference in scene.materials.iter().flat_map(|m| m.texture_refs()) {
        assert!(scene.textures[reference.texture].image < scene.images.len(), "an image that does not exist");
    }
    assert!(scene.parts.iter().all(|p| p.world_from_part.is_finite()), "a transform that is not finite");
}

/// Reads `bytes` as a file of this name.
#[allow(dead_code)]
pub fn read(bytes: &[u8], name: &str) {
    if let Ok(scene) = pellucid::import::load_bytes_with(bytes, name, None, &options()) {
        check(&scene);
    }
}
