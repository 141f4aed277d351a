//! What becomes a part: the file's nodes, its materials, its connected components, or all of it.
//!
//! Every technique that looks for neighbours or tells things apart works on parts, so a gearbox that a file holds as one mesh
//! has to come apart, and a car that a program wrote as a thousand nodes may be better by material. Each format's reader says
//! what suits it (a [`Draft`]), the user may say otherwise, and [`Scene::partition`] tells what was done and why.
//!
//! - **Nodes**: as the file has them. Nothing changes.
//! - **Components** (`components`): each mesh comes apart into its connected pieces, in its own space, and every node that
//!   shows it gets a node below it for each. So meshes that nodes share are divided once, and their pieces stay shared.
//! - **Materials**, **file** (`bake`): triangles of different nodes become one mesh, for which they are brought into one
//!   space; sharing ends there.
//!
//! More parts than [`Limits::parts`](super::Limits) are not made: a cloud of loose triangles is one part, and that is told.

mod bake;
mod components;

#[cfg(test)]
mod tests;

use glam::DMat4;

use super::{Fallible, Fault, ImportOptions, PartsBy, Phase};
use crate::scene::{Notice, NoticeKind, Scene};

/// A scene as a format's reader leaves it.
pub(super) struct Draft {
    /// With nodes as the file has them; finished or not.
    scene: Scene,
    /// What becomes a part unless the user says otherwise, and why.
    default: PartsBy,
    why: &'static str,
}

impl Draft {
    pub(super) fn new(scene: Scene, default: PartsBy, why: &'static str) -> Draft {
        Draft { scene, default, why }
    }

    /// A glTF scene, which is finished: its nodes are what its author called a thing.
    pub(super) fn gltf(scene: Scene) -> Draft {
        Draft::new(scene, PartsBy::Node, "glTF names its nodes")
    }
}

/// Makes the parts and finishes the scene.
pub(super) fn divide(draft: Draft, options: &ImportOptions) -> Fallible<Scene> {
    let Draft { mut scene, default, why } = draft;
    let by = options.parts.unwrap_or(default);
    let reason = if options.parts.is_some() { "as asked for" } else { why };
    let most = options.limits.parts;
    options.cancel.go_on()?;
    options.progress.tell(Phase::Parts, 0.0);
    let named = scene.nodes.iter().filter(|n| n.mesh.is_some()).count() as u64;
    let done = match by {
        // Nodes of glTF are instances, and as many as they are.
        PartsBy::Node if options.parts.is_none() && scene.parts.is_empty() && named > most => {
            bake::whole(&mut scene, options)?.ok();
            Err(format!("{named} objects and groups"))
        }
        PartsBy::Node => Ok(nodes_of(&scene)),
        PartsBy::Component => components::divide(&mut scene, most, options)?,
        PartsBy::Material => bake::by_material(&mut scene, most, options)?,
        PartsBy::File => bake::whole(&mut scene, options)?,
    };
    scene.partition = match done {
        Ok(what) => format!("{what}: {reason}"),
        Err(many) => {
            // A sentence of its own, because the user is likely to have expected something else.
            let message =
                format!("the model is not divided into {many}, which are more than the limit of {most} parts");
            scene.notices.push(Notice { kind: NoticeKind::Approximated, message });
            format!("{}: {many} would be more than the limit of {most} parts", nodes_of(&scene))
        }
    };
    options.progress.tell(Phase::Finishing, 0.0);
    // Parts that are nodes were made by the reader that finished them.
    if by == PartsBy::Node && !scene.parts.is_empty() { Ok(scene) } else { finish(scene) }
}

/// Finishes a scene, again if it was: cameras keep their place in the file.
fn finish(mut scene: Scene) -> Fallible<Scene> {
    let before = scene.origin;
    if before != glam::DVec3::ZERO {
        // Said anew.
        scene.notices.retain(|n| !(n.kind == NoticeKind::Computed && n.message.contains("was re-based by (")));
    }
    let mut scene = scene.finish().map_err(Fault::Scene)?;
    let moved = DMat4::from_translation(before - scene.origin);
    for camera in &mut scene.cameras {
        camera.world_from_camera = moved * camera.world_from_camera;
    }
    Ok(scene)
}

fn nodes_of(scene: &Scene) -> &'static str {
    if scene.nodes.iter().filter(|n| n.mesh.is_some()).count() == 1 { "the whole file" } else { "the file's nodes" }
}
