//! glTF 2.0, as text (`.gltf`) and binary (`.glb`), by our own checked reader.
//!
//! From the `gltf` crates only the JSON types are used (`gltf-json`): its reader panics on several malformed files, and
//! its validation refuses extensions that this program reads or can do without.
//!
//! One file passes through the modules in this order: `container` (GLB chunks) → `document` (JSON, place by place)
//! → `extensions` (what is required, what is left out) → `buffers` and `uri`, `meshopt` (compressed views) → `accessor` →
//! `sources`, `images` and `ktx2` → `materials` → `variants` → `draco` (compressed primitives) → `geometry` (with `attributes`,
//! `import::triangles`, `import::tangents`) → `nodes` (with `instancing`). `validator` lists what becomes of every fault that the
//! Khronos validator knows. What is done piece by piece, in parallel, goes through `import::steps`, and what it holds through `budget`.

mod accessor;
mod attributes;
mod budget;
mod buffers;
mod container;
mod document;
mod draco;
mod extensions;
mod geometry;
mod images;
mod instancing;
mod ktx2;
mod materials;
mod meshopt;
mod nodes;
mod schema;
mod sources;
mod uses;
pub(super) mod validator;
mod variants;

#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DMat4;

use super::{Fallible, Fault, ImportOptions, Limits, Notices, Phase, steps, uri};
use crate::scene::Scene;
use budget::Budget;
pub(super) use extensions::features;
pub(super) use variants::unknown as unknown_variant;

/// Reads a glTF file; files that it refers to are looked up in `folder` and refused without one.
pub(super) fn read(bytes: &[u8], name: &str, folder: Option<&Path>, options: &ImportOptions) -> Fallible<Scene> {
    let mut notices = Notices::default();
    let tell = |phase| options.progress.tell(phase, 0.0);
    tell(Phase::Parsing);
    let parts = container::split(bytes, &mut notices)?;
    let mut document = document::parse(parts.json, &mut notices)?;
    extensions::report(&document, &mut notices)?;
    uses::report(&document.root, &mut notices);
    let budget = Budget::new(&options.limits);
    let buffers = buffers::read(&document.root, parts.binary, folder, &budget, options, &mut notices)?;
    options.cancel.go_on()?;
    let views = meshopt::decode(&document.root, &buffers, &budget, options, &mut notices)?;
    let mut data = accessor::Data::new(&document.root, &buffers, &views, &options.limits, &mut notices)?;
    options.cancel.go_on()?;
    tell(Phase::Images);
    let mut sources = sources::find(&document.root)?;
    let images = images::read(&document.root, &data, &mut sources, folder, &budget, options, &mut notices)?;
    let mut textures = materials::textures(&document.root, &sources, &images, &mut notices)?;
    let mut materials = materials::read(&document.root, textures.len(), &mut notices)?;
    materials::drop_unusable(&mut textures, &mut materials);
    tell(Phase::Geometry);
    variants::choose(&mut document.root, &document.variants, options, &mut notices)?;
    let decoded = draco::decode(&document.root, &data, &budget, options, &mut notices)?;
    draco::install(&mut document.root, &mut data, &decoded);
    let root = &document.root;
    let begin = if decoded.is_empty() { 0.0 } else { 0.5 };
    let geometry = geometry::read(root, &data, materials, begin, options, &mut notices)?;
    let hierarchy = nodes::read(root, &data, &geometry.meshes, &options.limits, &mut notices)?;
    let mut scene = Scene {
        name: name.to_owned(),
        nodes: hierarchy.nodes,
        meshes: geometry.meshes,
        materials: geometry.materials,
        textures,
        images: images.images,
        variants: document.variants,
        ..Scene::default()
    };
    let meshes_shown = scene.nodes.iter().filter_map(|n| n.mesh).any(|m| scene.meshes[m].triangle_count() > 0);
    if !meshes_shown {
        notices.ignored("the file shows no triangles: the scene is empty".to_owned());
    }
    scene.notices = notices.into_vec();
    options.cancel.go_on()?;
    // Before finishing, which may move a node with its mesh; then into the re-based space.
    let mut cameras = nodes::cameras(root, &hierarchy.cameras, &scene);
    let mut scene = scene.finish().map_err(Fault::Scene)?;
    for camera in &mut cameras {
        camera.world_from_camera = DMat4::from_translation(-scene.origin) * camera.world_from_camera;
    }
    scene.cameras = cameras;
    Ok(scene)
}
