//! Scenes about depth: equal, close, far, many.

use glam::{DMat4, DVec3};

use super::super::parameters::{Parameters, Random};
use super::super::{BuiltinError, samples};
use super::parts;
use crate::math::color::linear_from_srgb;
use crate::scene::{Material, Node, Primitive, Scene};

pub(super) fn equal_keys(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [layers, colors] = p.take([("layers", 2.0, 2.0, 64.0), ("colors", 0.0, 0.0, 1.0)])?;
    let mut scene = samples::stack(layers as u32, 0.0, |_| 0);
    if colors > 0.0 {
        for primitive in scene.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
            // Four vertices a face.
            let share = |vertex: usize| (vertex / 4) as f32 / (layers as f32 - 1.0);
            let color = |vertex: usize| [share(vertex), 0.3, 1.0 - share(vertex), 1.0];
            primitive.colors = (0..primitive.positions.len()).map(color).collect();
        }
    }
    Ok(scene)
}

/// Two squares of one part, tilted so that depth sweeps over many keys, `gap` apart in depth.
pub fn tilted_pair(gap: f64, half: f64, place: DVec3) -> Primitive {
    let square = |z: f64| {
        samples::grid(1, 1, |u, v| {
            let (x, y) = (half * (2.0 * u - 1.0), half * (2.0 * v - 1.0));
            (DVec3::new(x, y, 0.7 * x + 0.31 * y + z) + place, DVec3::Z)
        })
    };
    let mut pair = square(0.0);
    samples::append(&mut pair, &square(-gap));
    pair
}

/// The depth range that counts is that of the sphere around the scene.
pub(super) fn close_sheets(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [share] = p.take([("gap", 1e-5, 1e-9, 1.0)])?;
    let scene_of = |gap: f64| parts(vec![tilted_pair(gap, 1.0, DVec3::ZERO), samples::sphere(0.1, 8, 4)]);
    let range = 2.0 * scene_of(0.0).finish()?.bounds().bounding_sphere().radius;
    Ok(scene_of(share * range))
}

pub(super) fn far_sheets(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    Ok(parts(vec![
        tilted_pair(1.0, 12.0, DVec3::new(0.0, 0.0, -900.0)),
        samples::moved(samples::square(0.01, 0.0), DVec3::new(0.0, 0.2, -0.5)),
        samples::moved(samples::square(1.0, 0.0), DVec3::new(0.0, 200.0, -1000.0)),
    ]))
}

pub(super) fn many_parts(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [count] = p.take([("parts", 70_000.0, 1.0, 1_000_000.0)])?;
    let mut random = Random::new(9);
    let triangle = Primitive {
        positions: vec![[0.0; 3], [0.03, 0.0, 0.01], [0.01, 0.03, 0.0]],
        normals: vec![[-0.33, 0.11, 1.0].map(|c: f32| c / 1.058_77); 3],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    let nodes = (0..count as u32).map(|_| (0, DMat4::from_translation(random.point(1.0)))).collect();
    Ok(samples::scene(samples::grey(), vec![samples::mesh("one", triangle)], nodes))
}

pub(super) fn stack(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [layers, gap, count, alike] = p.take([
        ("layers", 20.0, 1.0, 2048.0),
        ("gap", 0.1, 0.0, 10.0),
        ("parts", 4.0, 1.0, 256.0),
        ("alike", 0.0, 0.0, 1.0),
    ])?;
    let count = (count as u32).min(layers as u32);
    let mut scene = samples::stack(layers as u32, gap, |i| (i % count) as usize);
    if alike == 0.0 {
        for (i, part) in scene.meshes.iter_mut().enumerate() {
            part.primitives[0].material = i;
        }
        let share = |i: u32| i as f32 / count as f32;
        let color = |i: u32| [0.2 + 0.8 * share(i), 0.9 - 0.8 * share(i), 0.5, 1.0];
        scene.materials = (0..count).map(|i| samples::material(color(i), 0.0, 0.6)).collect();
    }
    Ok(scene)
}

/// The same plane twice, as parts of different triangles: which lies in front changes from pixel to pixel.
pub(super) fn contact(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let sheet = |columns: u32, rows: u32| {
        samples::grid(columns, rows, |u, v| {
            let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            (DVec3::new(x, y, 0.7 * x + 0.31 * y), DVec3::new(-0.7, -0.31, 1.0).normalize())
        })
    };
    Ok(parts(vec![sheet(7, 5), sheet(3, 11)]))
}

/// Eight parts whose home is the last of eight slots, so that every probe wraps around; and a ninth, which looks for itself
/// in full tables that do not have it.
pub(super) fn full_buckets(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let mut scene = samples::stack(8, 0.1, |i| (7 + 8 * i) as usize);
    scene.meshes[0].primitives[0] = samples::moved(samples::square(0.4, 0.0), DVec3::new(1.4, 0.0, 0.0));
    Ok(scene)
}

pub(super) fn faint(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let mut scene = samples::stack(32, 0.03, |_| 0);
    scene.materials[0] = Material { unlit: true, ..samples::material([0.02, 0.3, 0.9, 1.0], 0.0, 1.0) };
    Ok(scene)
}

pub(super) fn dark(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let mut random = Random::new(26);
    let place = |i: u32| DVec3::new(f64::from(i % 6), f64::from(i / 6), 0.0);
    let mut scene = parts((0..24).map(|i| samples::moved(samples::square(0.5, 0.0), place(i))).collect());
    let mut material = || {
        let [r, g, b] = [0; 3].map(|_| linear_from_srgb(random.unit() * 0.3) as f32);
        Material { unlit: true, ..samples::material([r, g, b, 1.0], 0.0, 1.0) }
    };
    scene.materials = (0..24).map(|_| material()).collect();
    for (i, mesh) in scene.meshes.iter_mut().enumerate() {
        mesh.primitives[0].material = i;
    }
    Ok(scene)
}

/// Each shell is a part of its own, numbered against depth, so that a tie comes out in the wrong order; two squares far
/// away make the scene a kilometre large.
pub(super) fn gaps(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let shell = samples::grid(1, 1, |u, v| {
        let (x, y) = (8.0 * u - 4.0, 8.0 * v - 4.0);
        (DVec3::new(x, y, 0.3 * x + 0.2 * y), DVec3::Z)
    });
    let far = samples::square(1.0, 0.0);
    let meshes = vec![samples::mesh("shell", shell), samples::mesh("far", far)];
    let shells =
        (0..10).map(|i| Node::root("", Some(0), DMat4::from_translation(DVec3::Z * -0.002 * f64::from(9 - i))));
    let corners =
        [1.0, -1.0].map(|s| Node::root("", Some(1), DMat4::from_translation(s * DVec3::new(300.0, 400.0, -500.0))));
    Ok(Scene { materials: samples::grey(), meshes, nodes: shells.chain(corners).collect(), ..Scene::default() })
}
