//! Test scenes: the samples of the built-in scenes, finished.

use glam::DMat4;
pub use pellucid::scene::builtin::Random;
use pellucid::scene::builtin::samples;
pub use pellucid::scene::builtin::samples::{
    append, cuboid, cylinder, cylinder_at, grey, grid, material, mesh, moved, saddle, soup, sphere, square, torus,
};
use pellucid::scene::{Material, Mesh, Primitive, Scene};

fn finished(scene: Scene) -> Scene {
    scene.finish().expect("a small scene")
}

/// A scene with one root node a part.
pub fn scene(materials: Vec<Material>, meshes: Vec<Mesh>, nodes: Vec<(usize, DMat4)>) -> Scene {
    finished(samples::scene(materials, meshes, nodes))
}

/// One part for every primitive.
pub fn parts(primitives: Vec<Primitive>) -> Scene {
    finished(samples::parts(primitives))
}

/// A bit of everything.
pub fn assembly(seed: u64) -> Scene {
    finished(samples::assembly(seed))
}

/// Loose triangles of several parts, that cut through each other.
pub fn soups(seed: u64, parts_of: usize, triangles: u32) -> Scene {
    finished(samples::soups(seed, parts_of, triangles))
}

/// Squares behind each other, seen from +z: the nearest first, `gap` apart; part of each by `part_of`.
pub fn stack(layers: u32, gap: f64, part_of: impl Fn(u32) -> usize) -> Scene {
    finished(samples::stack(layers, gap, part_of))
}
