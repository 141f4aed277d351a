//! Scenes that several traps share: loose triangles, an assembly with a bit of everything, tiles of random scenes.

use glam::{DMat4, DVec3, Vec3};

use super::super::parameters::{Parameters, Random};
use super::super::{BuiltinError, samples};
use super::parts;
use crate::scene::{Mesh, Node, Primitive, Scene};

const SEED: (&str, f64, f64, f64) = ("seed", 1.0, 0.0, 4_294_967_295.0);
const SIZE: (&str, f64, f64, f64) = ("size", 1.0, 1e-6, 1e6);

fn resize(scene: &mut Scene, size: f64) {
    if size != 1.0 {
        for node in scene.nodes.iter_mut().filter(|n| n.parent.is_none()) {
            node.parent_from_node = DMat4::from_scale(DVec3::splat(size)) * node.parent_from_node;
        }
    }
}

pub(super) fn soup(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [seed, count, triangles, size, far] = p.take([
        ("seed", 71.0, 0.0, SEED.3),
        ("parts", 3.0, 1.0, 256.0),
        ("triangles", 30.0, 1.0, 10_000.0),
        SIZE,
        ("far", 0.0, 0.0, 1e6),
    ])?;
    let mut scene = samples::soups(seed as u64, count as usize, triangles as u32);
    if far > 0.0 {
        // Off the picture's axis: it must not come into the picture, only into the scene's size.
        let at = DVec3::new(500.0, 300.0, -900.0).normalize() * far;
        scene.meshes.push(Mesh { name: "far".to_owned(), primitives: vec![samples::cuboid(DVec3::splat(0.5))] });
        scene.nodes.push(Node::root("far", Some(scene.meshes.len() - 1), DMat4::from_translation(at)));
    }
    resize(&mut scene, size);
    Ok(scene)
}

/// `offset` moves the whole by (1, −2, 3) times it, in the transform of a node above all others; `baked` in the `f32`
/// vertices instead, as a program does that exports one mesh in world coordinates.
pub(super) fn assembly(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [seed, size, offset, baked] = p.take([SEED, SIZE, ("offset", 0.0, 0.0, 1e9), ("baked", 0.0, 0.0, 1.0)])?;
    let mut scene = samples::assembly(seed as u64);
    resize(&mut scene, size);
    let by = DMat4::from_translation(offset * DVec3::new(1.0, -2.0, 3.0));
    if baked > 0.0 {
        bake(&mut scene, by);
    } else if offset > 0.0 {
        let top = scene.nodes.len();
        scene.nodes.iter_mut().for_each(|n| n.parent = Some(top));
        scene.nodes.push(Node { children: (0..top).collect(), ..Node::root("far away", None, by) });
    }
    Ok(scene)
}

/// Puts every node's transform, and `by` after it, into vertices of its own.
fn bake(scene: &mut Scene, by: DMat4) {
    let mut meshes = Vec::new();
    for node in &mut scene.nodes {
        let Some(mesh) = node.mesh else { continue };
        let world = by * node.parent_from_node;
        let normals = glam::DMat3::from_mat4(world).inverse().transpose();
        let mut own = scene.meshes[mesh].clone();
        for primitive in &mut own.primitives {
            for p in &mut primitive.positions {
                *p = world.transform_point3(Vec3::from(*p).as_dvec3()).as_vec3().to_array();
            }
            for n in &mut primitive.normals {
                *n = (normals * Vec3::from(*n).as_dvec3()).normalize_or_zero().as_vec3().to_array();
            }
        }
        node.mesh = Some(meshes.len());
        node.parent_from_node = DMat4::IDENTITY;
        meshes.push(own);
    }
    scene.meshes = meshes;
}

pub(super) fn floor(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let floor = Primitive {
        positions: vec![[-50.0, -0.5, 60.0], [50.0, -0.5, 60.0], [0.0, -0.5, -90.0]],
        normals: vec![[0.0, 1.0, 0.0]; 3],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    Ok(parts(vec![floor, samples::moved(samples::sphere(0.4, 32, 16), DVec3::new(0.2, -0.3, -2.0))]))
}

/// Triangles of a random scene at most.
const MOST_TRIANGLES: u64 = 12;

/// Scene number `i`, row by row from the top, fills the square of edge 1 about (column, −row, 0): one to twelve triangles
/// of one to three parts, a third of them slivers or neighbours of the one before.
pub(super) fn tiles(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [seed, columns] = p.take([SEED, ("columns", 16.0, 1.0, 64.0)])?;
    let mut random = Random::new(seed as u64);
    let columns = columns as u32;
    let middle = 0.5 * f64::from(columns - 1);
    let mut primitives = Vec::new();
    for tile in 0..columns * columns {
        let place = DVec3::new(f64::from(tile % columns) - middle, middle - f64::from(tile / columns), 0.0);
        let count = 1 + random.below(MOST_TRIANGLES);
        let mut of_parts = vec![Primitive::default(); 1 + random.below(3) as usize];
        let mut last = [DVec3::ZERO; 3];
        for i in 0..count {
            let mut corners = [0; 3].map(|_| random.point(0.49));
            match random.below(6) {
                0 => corners[2] = corners[0].lerp(corners[1], random.unit()) + 0.02 * random.direction(),
                1 if i > 0 => (corners[0], corners[1]) = (last[1], last[0]),
                _ => {}
            }
            last = corners;
            let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
            let longest = ab.length().max(ac.length()).max((ac - ab).length()).max(1e-9);
            // Bent only where the triangle is wide: on a sliver a normal would turn by radians over a pixel.
            let bend = if ab.cross(ac).length() / longest > 0.25 { 0.3 } else { 0.0 };
            let normal = ab.cross(ac).normalize_or(DVec3::Z);
            let part = random.below(of_parts.len() as u64) as usize;
            let target = &mut of_parts[part];
            let first = target.positions.len() as u32;
            // Not always agreeing with the winding.
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            for corner in corners {
                target.positions.push((corner + place).as_vec3().to_array());
                let bent = (sign * normal + bend * random.direction()).normalize();
                target.normals.push(bent.as_vec3().to_array());
            }
            target.triangles.push([first, first + 1, first + 2]);
        }
        primitives.extend(of_parts.into_iter().filter(|p| !p.triangles.is_empty()));
    }
    Ok(parts(primitives))
}
