//! Wavefront OBJ and its material files.
//!
//! The format is a list of statements of Wavefront's Advanced Visualizer (its manual's appendix B1 of 1995 is what everybody
//! refers to), and every program writes its own dialect. So statements are taken as they come: bytes need not be UTF-8, a
//! backslash continues a line, unknown statements are counted and skipped, a missing material or texture costs colour and
//! not the model. What is not forgiven is an index that points nowhere: which face was meant cannot be guessed.
//!
//! - **Coordinates** are read as `f64`. Where they lie far from the origin, positions are stored relative to the middle of the
//!   file's box and the node has the offset, so that a survey's 1e7 metres cost nothing.
//! - **Parts** are objects and groups: a group of an object is below it, an object with only one group is that. A file
//!   without either is divided into connected components.
//! - **Normals** are the file's. Faces without go by their smoothing group, over any angle inside it; those without a group,
//!   or with `s off`, which writers put into files whatever they mean, by the crease angle.
//! - **Colours** are taken as sRGB, in materials and behind vertices (`v x y z r g b`). How materials are converted, `mtl`
//!   says.
//!
//! One file passes through `statements` (lines to triangles of indices), `mtl` and `textures` (materials), `build`
//! (primitives and nodes).

mod build;
mod mtl;
mod statements;
mod textures;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::parts::Draft;
use super::triangles::plain_material;
use super::{Fallible, Fault, ImportOptions, Notices, PartsBy, Phase};
use crate::scene::Scene;

/// Reads an OBJ file; material files and textures are looked up in `folder`.
pub(super) fn read(bytes: &[u8], name: &str, folder: Option<&Path>, options: &ImportOptions) -> Fallible<Draft> {
    let mut notices = Notices::default();
    options.progress.tell(Phase::Parsing, 0.0);
    let model = statements::read(bytes, options, &mut notices)?;
    if model.buckets.is_empty() {
        let cause = match model.positions.len() {
            0 => "an OBJ file without vertices or faces".to_owned(),
            count => format!("an OBJ file with {count} vertices and no faces"),
        };
        return Err(Fault::invalid("file", cause));
    }
    options.cancel.go_on()?;
    options.progress.tell(Phase::Images, 0.0);
    let looks = mtl::read(&model, folder, options, &mut notices)?;
    options.cancel.go_on()?;
    options.progress.tell(Phase::Geometry, 0.0);
    let named = model.names_parts();
    let (nodes, meshes) = build::build(model, &looks.materials, name, options, &mut notices)?;
    if meshes.is_empty() {
        notices.ignored("the file shows no triangles: the scene is empty".to_owned());
    }
    let scene = Scene {
        name: name.to_owned(),
        nodes,
        meshes,
        materials: if looks.materials.is_empty() { vec![plain_material()] } else { looks.materials },
        textures: looks.textures,
        images: looks.images,
        notices: notices.into_vec(),
        ..Scene::default()
    };
    Ok(if named {
        Draft::new(scene, PartsBy::Node, "the file names objects or groups")
    } else {
        Draft::new(scene, PartsBy::Component, "the file names no more than one object or group")
    })
}
