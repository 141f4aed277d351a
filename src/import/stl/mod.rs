//! STL, ASCII and binary: triangles and nothing else.
//!
//! The format is 3D Systems' of 1989. Which of the two forms a file has is told by its length (84 bytes and 50 for each
//! triangle), because binary files may begin with "solid" too. Facet normals are not believed: many writers leave them
//! zero, and the winding says the same. Every triangle has corners of its own, so they are welded where they are bit for bit
//! at one place, and vertex normals are computed up to the crease angle; else curvature, the normals' derivative, would be
//! noise (T31). The two bytes behind each binary triangle hold colours in some writers' files, in two dialects that contradict
//! each other; they are left out and told.

mod ascii;
mod binary;

#[cfg(test)]
mod tests;

use glam::DMat4;

use super::format::{is_ascii_stl, is_binary_stl};
use super::parts::Draft;
use super::triangles::plain_material;
use super::{Fallible, Fault, ImportOptions, Notices, PartsBy, Phase};
use crate::scene::{Mesh, Node, Primitive, Scene, compute_normals};

/// Reads an STL file.
pub(super) fn read(bytes: &[u8], name: &str, options: &ImportOptions) -> Fallible<Draft> {
    let mut notices = Notices::default();
    options.progress.tell(Phase::Parsing, 0.0);
    let solids = if !is_binary_stl(bytes) && (is_ascii_stl(bytes) || bytes.len() < 84) {
        ascii::read(bytes, options, &mut notices)?
    } else {
        binary::read(bytes, options, &mut notices)?
    };
    let solids: Vec<Solid> = solids.into_iter().filter(|s| !s.primitive.triangles.is_empty()).collect();
    if solids.is_empty() {
        return Err(Fault::invalid("file", "an STL file without triangles"));
    }
    // They are welded; the rest are their normals.
    options.progress.tell(Phase::Geometry, 0.5);
    let mut scene = Scene { name: name.to_owned(), materials: vec![plain_material()], ..Scene::default() };
    let many = solids.len() > 1;
    let total = solids.len() as f32;
    for (i, mut solid) in solids.into_iter().enumerate() {
        options.cancel.go_on()?;
        compute_normals(&mut solid.primitive, options.crease_angle);
        // A single solid is the file; what writers call it ("Exported from …", "ascii") is seldom its name.
        let label = match solid.name {
            label if many && !label.is_empty() => label,
            _ if many => format!("solid {}", i + 1),
            _ => name.to_owned(),
        };
        scene.nodes.push(Node::root(label, Some(i), DMat4::from_translation(solid.origin)));
        scene.meshes.push(Mesh { name: String::new(), primitives: vec![solid.primitive] });
        options.progress.tell(Phase::Geometry, 0.5 + 0.5 * (i + 1) as f32 / total);
    }
    notices.computed(format!(
        "STL has no vertex normals: they were smoothed over edges of up to {}°",
        options.crease_angle
    ));
    scene.notices = notices.into_vec();
    Ok(if many {
        Draft::new(scene, PartsBy::Node, "the file has several solids")
    } else {
        Draft::new(scene, PartsBy::Component, "an STL file is one mesh, whatever it holds")
    })
}

/// A solid: welded triangles, and where their coordinates begin.
struct Solid {
    name: String,
    origin: glam::DVec3,
    primitive: Primitive,
}
