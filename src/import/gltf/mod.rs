//! glTF 2.0, as text (`.gltf`) and binary (`.glb`), by our own checked reader.
//!
//! From the `gltf` crates only the JSON types are used (`gltf-json`): its reader panics on several malformed files, and
//! its validation refuses extensions that this program reads or can do without.
//!
//! One file passes through the modules in this order: `container` (GLB chunks) → `document` (JSON, place by place)
//! → `extensions` (what is required, what is left out) → `buffers` and `uri` → `accessor` → `images` →
//! `materials` → `geometry` (with `attributes`, `import::triangles`, `import::tangents`) → `nodes`.

mod accessor;
mod attributes;
mod buffers;
mod container;
mod document;
mod extensions;
mod geometry;
mod images;
mod materials;
mod nodes;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::{Fallible, Fault, ImportOptions, Limits, Notices, Phase, uri};
use crate::scene::Scene;

/// Reads a glTF file; files that it refers to are looked up in `folder` and refused without one.
pub(super) fn read(bytes: &[u8], name: &str, folder: Option<&Path>, options: &ImportOptions) -> Fallible<Scene> {
    let mut notices = Notices::default();
    options.progress.tell(Phase::Parsing, 0.0);
    let parts = container::split(bytes, &mut notices)?;
    let document = document::parse(parts.json, &mut notices)?;
    extensions::report(&document, &mut notices)?;
    let root = &document.root;
    let buffers = buffers::read(root, parts.binary, folder, &options.limits, &mut notices)?;
    let data = accessor::Data::new(root, &buffers, &options.limits)?;
    options.cancel.go_on()?;
    options.progress.tell(Phase::Images, 0.0);
    let images = images::read(root, &data, folder, options, &mut notices)?;
    let mut textures = materials::textures(root, images.len(), &mut notices)?;
    let mut materials = materials::read(root, textures.len(), &mut notices)?;
    materials::drop_unusable(&mut textures, &mut materials);
    options.progress.tell(Phase::Geometry, 0.0);
    let geometry = geometry::read(root, &data, materials, options, &mut notices)?;
    let hierarchy = nodes::read(root, geometry.meshes.len(), &options.limits, &mut notices)?;
    let mut scene = Scene {
        name: name.to_owned(),
        nodes: hierarchy.nodes,
        meshes: geometry.meshes,
        materials: geometry.materials,
        textures,
        images,
        ..Scene::default()
    };
    let meshes_shown = scene.nodes.iter().filter_map(|n| n.mesh).any(|m| scene.meshes[m].triangle_count() > 0);
    if !meshes_shown {
        notices.ignored("the file shows no triangles: the scene is empty".to_owned());
    }
    scene.notices = notices.into_vec();
    options.cancel.go_on()?;
    let mut scene = scene.finish().map_err(Fault::Scene)?;
    // After finishing, so that cameras are in the re-based space.
    scene.cameras = nodes::cameras(root, &hierarchy.cameras, &scene);
    Ok(scene)
}
