//! Arranged scenes: a scene with its parts where and as an [`Arrangement`] wants them, as a scene again, so that every
//! stage of the oracle takes it as it takes any other; and what the arrangement does to opacity, which no scene can say.
//!
//! Numbers of parts and triangles stay. A hidden part has no triangles and no extent; a part with a colour of the user's
//! has materials of its own whose textures keep only their opacity.

use std::sync::Arc;

use super::store::StoreData;
use crate::math::color::linear_from_srgb;
use crate::scene::cut::{cap_material, tinted};
use crate::scene::{Arrangement, Cut, Image, Mesh, Part, PartStyle, Presence, Primitive, Scene, Solids};

/// The scene that `arrangement` makes of `scene`, with the caps of its section planes as parts. The planes themselves and
/// the selection are no part of it: see [`Cut::planes`].
pub fn arranged(scene: &Scene, arrangement: &Arrangement) -> Scene {
    let cut = Cut::new(scene, arrangement, &Solids::of(scene));
    let mut result = uncut(scene, arrangement);
    for (index, cap) in cut.caps.iter().enumerate() {
        let mut material = cap_material(scene, scene.parts[cap.part as usize].mesh);
        if let Some(color) = arrangement.look(cap.part).color {
            let [r, g, b] = tinted(color.map(|v| linear_from_srgb(v) as f32));
            material.base_color = [r, g, b, material.base_color[3]];
        }
        let primitive = Primitive {
            positions: cap.positions.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 1.0]; cap.positions.len()],
            triangles: cap.triangles.clone(),
            material: result.materials.len(),
            ..Primitive::default()
        };
        let owner = &result.parts[cap.part as usize];
        // As large as its owner, by which lengths are measured.
        let part = Part {
            name: format!("cap {index} of {}", owner.name),
            node: owner.node,
            mesh: result.meshes.len(),
            world_from_part: cap.world_from_cap,
            first_triangle: cap.first_triangle,
            triangle_count: cap.triangles.len() as u32,
            bounds: owner.bounds,
        };
        result.materials.push(material);
        result.meshes.push(Mesh { name: part.name.clone(), primitives: vec![primitive] });
        result.parts.push(part);
    }
    result
}

fn uncut(scene: &Scene, arrangement: &Arrangement) -> Scene {
    let mut result = scene.clone();
    let placed = arrangement.placed(scene);
    let nothing = result.meshes.len();
    result.meshes.push(Mesh::default());
    for (index, place) in placed.parts.iter().enumerate() {
        let look = arrangement.look(index as u32);
        let part = &mut result.parts[index];
        part.world_from_part = place.world_from_part;
        part.bounds = place.bounds;
        if look.presence == Presence::Hidden {
            part.mesh = nothing;
        } else if let Some(color) = look.color {
            part.mesh = result.meshes.len();
            let mesh = recolored(&mut result, scene.parts[index].mesh, color);
            result.meshes.push(mesh);
        }
    }
    result
}

/// A copy of a mesh whose materials have another base colour.
fn recolored(scene: &mut Scene, mesh: usize, color: [f64; 3]) -> Mesh {
    let mut mesh = scene.meshes[mesh].clone();
    let [r, g, b] = color.map(|v| linear_from_srgb(v) as f32);
    for primitive in &mut mesh.primitives {
        let mut material = scene.materials[primitive.material].clone();
        material.base_color = [r, g, b, material.base_color[3]];
        if let Some(reference) = &mut material.base_color_texture {
            let mut texture = scene.textures[reference.texture];
            let mut image = Image::clone(&scene.images[texture.image]);
            image.rgba.chunks_exact_mut(4).for_each(|texel| texel[..3].fill(255));
            texture.image = scene.images.len();
            scene.images.push(Arc::new(image));
            reference.texture = scene.textures.len();
            scene.textures.push(texture);
        }
        for c in &mut primitive.colors {
            c[..3].fill(1.0);
        }
        primitive.material = scene.materials.len();
        scene.materials.push(material);
    }
    mesh
}

/// Multiplies the opacity of every layer by what the arrangement and `ghost` make of its part's.
pub fn fade(store: &StoreData, colors: &mut [[f64; 4]], arrangement: &Arrangement, ghost: f64) {
    for (color, &part) in colors.iter_mut().zip(&store.part) {
        let look = arrangement.look(part);
        let whole = if look.style == PartStyle::Solid { 1.0 } else { color[3] };
        color[3] = whole * look.opacity * if look.presence == Presence::Ghosted { ghost } else { 1.0 };
    }
}
