//! PLY, ASCII and binary of both byte orders: a header that declares elements and their properties, then the values.
//!
//! Greg Turk's format of 1994. Any program may declare what it likes, so elements and properties are found by name and all
//! others are read over: positions, normals, colours (of vertices, or of faces where all
//! vertices have the same) and texture coordinates of `vertex`, polygons of `face`, strips of `tristrips`. Numbers may have any
//! of the eight types, also where a file has them for lists.
//! Nothing is made room for because a header says that it comes; there must be bytes for it first.
//!
//! - **Colours** are taken as sRGB, as the programs that scan and paint meshes show them; whole numbers as shares of the
//!   largest of their type.
//! - **Coordinates** that lie far from the origin are stored relative to the middle of their box, read as `f64`.
//! - A PLY file is one mesh, so its **parts** are its connected components.

mod build;
mod elements;
mod header;
mod values;

#[cfg(test)]
mod tests;

use glam::DMat4;

use super::parts::Draft;
use super::triangles::plain_material;
use super::{Fallible, Fault, ImportOptions, Notices, PartsBy, Phase};
use crate::scene::{Mesh, Node, Scene};

/// Reads a PLY file.
pub(super) fn read(bytes: &[u8], name: &str, options: &ImportOptions) -> Fallible<Draft> {
    let mut notices = Notices::default();
    options.progress.tell(Phase::Parsing, 0.0);
    let (header, body) = header::read(bytes)?;
    for texture in &header.textures {
        notices.ignored(format!("comment TextureFile: {texture:?} is not shown"));
    }
    let raw = elements::read(&header, body, options, &mut notices)?;
    if raw.polygons() == 0 {
        let cause = match raw.positions.len() {
            0 => "a PLY file without vertices or faces".to_owned(),
            count => format!("a PLY file of {count} points and no faces: points are not shown"),
        };
        return Err(Fault::invalid("file", cause));
    }
    options.cancel.go_on()?;
    options.progress.tell(Phase::Geometry, 0.0);
    let (primitive, origin) = build::build(raw, options, &mut notices)?;
    let mut scene = Scene { name: name.to_owned(), materials: vec![plain_material()], ..Scene::default() };
    if !primitive.colors.is_empty() {
        // The colours of vertices multiply the material's.
        scene.materials[0].base_color = [1.0; 4];
    }
    if primitive.triangles.is_empty() {
        notices.ignored("the file shows no triangles: the scene is empty".to_owned());
    } else {
        scene.nodes.push(Node::root(name, Some(0), DMat4::from_translation(origin)));
        scene.meshes.push(Mesh { name: String::new(), primitives: vec![primitive] });
    }
    scene.notices = notices.into_vec();
    Ok(Draft::new(scene, PartsBy::Component, "a PLY file is one mesh, whatever it holds"))
}
