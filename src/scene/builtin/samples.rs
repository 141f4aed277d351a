//! Samples for tests and hard cases: meshes with exact normals, loose triangles, and a scene that has a bit of everything.
//!
//! Scenes are not finished, so that more can be added to them.

use std::f64::consts::{PI, TAU};

use super::parameters::Random;
use crate::scene::{AlphaMode, Image, Material, Mesh, Mip, Node, Primitive, Scene, Texture, TextureRef, Wrap};
use glam::{DMat4, DQuat, DVec3, Vec3};

/// A mesh of one primitive.
pub fn mesh(name: &str, primitive: Primitive) -> Mesh {
    Mesh { name: name.to_owned(), primitives: vec![primitive] }
}

/// A grid of (columns + 1) × (rows + 1) vertices, counter-clockwise seen from where u goes right and v up.
pub fn grid(columns: u32, rows: u32, point: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Primitive {
    let mut p = Primitive::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (at, normal) = point(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            p.positions.push(at.as_vec3().to_array());
            p.normals.push(normal.normalize_or_zero().as_vec3().to_array());
        }
    }
    let at = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            p.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            p.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    p
}

/// A sphere about the origin with its poles on the y axis.
pub fn sphere(radius: f64, columns: u32, rows: u32) -> Primitive {
    let mut p = grid(columns, rows, |u, v| {
        let (a, b) = (TAU * u, PI * (v - 0.5));
        let n = DVec3::new(a.sin() * b.cos(), b.sin(), a.cos() * b.cos());
        (n * radius, n)
    });
    // The poles are rows of one point: half of their triangles have no area.
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| Vec3::from(p.positions[i as usize]));
        (b - a).cross(c - a).length()
    };
    let limit = (radius * radius * 1e-9) as f32;
    let kept = p.triangles.iter().filter(|t| area(t) > limit).copied().collect();
    p.triangles = kept;
    p
}

/// A torus around z.
pub fn torus(major: f64, minor: f64, columns: u32, rows: u32) -> Primitive {
    grid(columns, rows, |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let out = DVec3::new(a.cos(), a.sin(), 0.0);
        let n = out * b.cos() + DVec3::Z * b.sin();
        (out * major + n * minor, n)
    })
}

/// Open cylinder around y, from −half to half.
pub fn cylinder(radius: f64, half: f64, columns: u32) -> Primitive {
    cylinder_at(radius, half, &(0..=columns).map(|i| TAU * f64::from(i) / f64::from(columns)).collect::<Vec<_>>())
}

/// The same with facets between given angles.
pub fn cylinder_at(radius: f64, half: f64, angles: &[f64]) -> Primitive {
    let last = (angles.len() - 1) as u32;
    grid(last, 1, |u, v| {
        let a = angles[(u * f64::from(last)).round() as usize];
        let n = DVec3::new(a.sin(), 0.0, a.cos());
        (n * radius + DVec3::Y * (half * (2.0 * v - 1.0)), n)
    })
}

/// z = bend (x² − y²) / 2 over [−half, half]².
pub fn saddle(bend: f64, half: f64, cells: u32) -> Primitive {
    grid(cells, cells, |u, v| {
        let (x, y) = (half * (2.0 * u - 1.0), half * (2.0 * v - 1.0));
        (DVec3::new(x, y, 0.5 * bend * (x * x - y * y)), DVec3::new(-bend * x, bend * y, 1.0))
    })
}

/// The square [−half, half]² at z, facing +z.
pub fn square(half: f64, z: f64) -> Primitive {
    grid(1, 1, |u, v| (DVec3::new(half * (2.0 * u - 1.0), half * (2.0 * v - 1.0), z), DVec3::Z))
}

/// A box about the origin with a normal for each face.
pub fn cuboid(half: DVec3) -> Primitive {
    let mut all = Primitive::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let (e, f) = ((axis + 1) % 3, (axis + 2) % 3);
            append(
                &mut all,
                &grid(1, 1, |u, v| {
                    let mut p = DVec3::ZERO;
                    p[axis] = sign * half[axis];
                    // Swapping sides with the sign keeps the winding outwards.
                    p[e] = half[e] * (2.0 * u - 1.0) * sign;
                    p[f] = half[f] * (2.0 * v - 1.0);
                    let mut n = DVec3::ZERO;
                    n[axis] = sign;
                    (p, n)
                }),
            );
        }
    }
    all
}

/// Adds the triangles of `more`.
pub fn append(all: &mut Primitive, more: &Primitive) {
    let first = all.positions.len() as u32;
    all.positions.extend(&more.positions);
    all.normals.extend(&more.normals);
    all.triangles.extend(more.triangles.iter().map(|t| t.map(|i| i + first)));
}

/// The same, shifted.
pub fn moved(mut p: Primitive, by: DVec3) -> Primitive {
    p.positions.iter_mut().for_each(|q| *q = (Vec3::from(*q) + by.as_vec3()).to_array());
    p
}

/// Triangles anywhere in a cube, with random winding; normals are the triangle's own or its opposite.
pub fn soup(random: &mut Random, triangles: u32, half: f64, size: f64) -> Primitive {
    let mut p = Primitive::default();
    for i in 0..triangles {
        let center = random.point(half);
        let corners = [0; 3].map(|_| center + random.direction() * size);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
        for corner in corners {
            p.positions.push(corner.as_vec3().to_array());
            p.normals.push((normal * sign).as_vec3().to_array());
        }
        p.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    p
}

/// A material without textures.
pub fn material(base_color: [f32; 4], metallic: f32, roughness: f32) -> Material {
    Material { base_color, metallic, roughness, ..Material::default() }
}

/// One grey material.
pub fn grey() -> Vec<Material> {
    vec![material([0.6, 0.6, 0.6, 1.0], 0.0, 0.5)]
}

/// A scene with one root node a part.
pub fn scene(materials: Vec<Material>, meshes: Vec<Mesh>, nodes: Vec<(usize, DMat4)>) -> Scene {
    let nodes = nodes.into_iter().map(|(m, at)| Node::root("", Some(m), at)).collect();
    Scene { materials, meshes, nodes, ..Scene::default() }
}

/// One part for every primitive.
pub fn parts(primitives: Vec<Primitive>) -> Scene {
    let nodes = (0..primitives.len()).map(|i| (i, DMat4::IDENTITY)).collect();
    scene(grey(), primitives.into_iter().map(|p| mesh("", p)).collect(), nodes)
}

/// A bit of everything: smooth and flat shapes inside each other, instances, a mirrored and a stretched part, touching
/// faces, loose triangles, vertex colours, a texture with holes, blended, shining and unlit materials.
pub fn assembly(seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let blended = Material { alpha_mode: AlphaMode::Blend, ..material([0.2, 0.5, 0.9, 0.4], 0.0, 0.3) };
    let shining = Material { emissive: [0.3, 0.1, 0.0], ..material([0.1, 0.1, 0.1, 1.0], 0.5, 0.7) };
    let unlit = Material { unlit: true, ..material([0.9, 0.3, 0.2, 1.0], 0.0, 1.0) };
    let textured = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(TextureRef { texture: 0, uv_set: 0, uv_transform: TextureRef::IDENTITY }),
        ..material([1.0; 4], 0.1, 0.6)
    };
    let materials = vec![
        material([0.7, 0.6, 0.5, 1.0], 0.0, 0.5),
        material([0.8; 4], 1.0, 0.35),
        blended,
        shining,
        unlit,
        textured,
    ];
    let with = |mut p: Primitive, material: usize| {
        p.material = material;
        p
    };
    let mut colored = soup(&mut random, 12, 1.2, 0.9);
    colored.colors = colored
        .positions
        .iter()
        .map(|_| [0.0; 3].map(|_| random.unit() as f32))
        .map(|[r, g, b]| [r, g, b, 1.0])
        .collect();
    let mut holes = square(0.9, 0.0);
    holes.uvs[0] = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let rgba =
        (0..16).flat_map(|i| [40 + 12 * i as u8, 200 - 9 * i as u8, 128, if i % 5 == 2 { 0 } else { 255 }]).collect();
    let image = Image { name: "texels".to_owned(), width: 4, height: 4, rgba };
    let mut two_materials = mesh("two materials", with(cuboid(DVec3::new(0.5, 0.3, 0.4)), 0));
    two_materials.primitives.push(with(moved(sphere(0.35, 12, 6), DVec3::new(0.0, 0.6, 0.0)), 1));
    let meshes = vec![
        mesh("ball", with(sphere(1.0, 24, 12), 0)),
        mesh("ring", with(torus(1.1, 0.35, 24, 10), 1)),
        two_materials,
        mesh("loose", with(colored, 3)),
        mesh("glass", with(cuboid(DVec3::splat(0.7)), 2)),
        mesh("holes", with(holes, 5)),
        mesh("tube", with(cylinder(0.5, 1.4, 24), 4)),
    ];
    let turn = |random: &mut Random| DQuat::from_axis_angle(random.direction(), random.between(0.3, 2.8));
    let at = |random: &mut Random, scale: DVec3, place: DVec3| {
        DMat4::from_scale_rotation_translation(scale, turn(random), place)
    };
    let r = &mut random;
    let box_at = at(r, DVec3::ONE, DVec3::new(-0.9, -0.5, 0.4));
    let nodes = vec![
        (0, at(r, DVec3::splat(1.5), DVec3::ZERO)),
        (0, at(r, DVec3::splat(0.8), DVec3::new(0.2, 0.1, 0.0))),
        (1, at(r, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(0.1, 0.0, 0.2))),
        (0, at(r, DVec3::new(0.4, 1.3, 0.7), DVec3::new(0.9, -0.6, -0.5))),
        (2, box_at),
        // A part of its face x = −0.5 touches the other's face x = 0.5.
        (2, box_at * DMat4::from_translation(DVec3::new(1.0, 0.45, 0.3))),
        (3, DMat4::IDENTITY),
        (4, at(r, DVec3::new(1.0, 1.0, -1.2), DVec3::new(-0.4, 0.7, 0.8))),
        (5, at(r, DVec3::ONE, DVec3::new(0.5, 0.6, 1.3))),
        (6, at(r, DVec3::ONE, DVec3::new(0.2, -0.3, -0.4))),
    ];
    let nodes = nodes.into_iter().map(|(m, at)| Node::root("", Some(m), at)).collect();
    let texture = Texture { image: 0, wrap: [Wrap::Repeat; 2], mag_linear: true, min_linear: true, mip: Mip::None };
    let images = vec![std::sync::Arc::new(image)];
    Scene { materials, meshes, nodes, images, textures: vec![texture], ..Scene::default() }
}

/// Loose triangles of several parts, that cut through each other.
pub fn soups(seed: u64, parts_of: usize, triangles: u32) -> Scene {
    let mut random = Random::new(seed);
    parts((0..parts_of).map(|_| soup(&mut random, triangles, 1.0, 0.8)).collect())
}

/// Squares behind each other, seen from +z: the nearest first, `gap` apart; part of each by `part_of`.
pub fn stack(layers: u32, gap: f64, part_of: impl Fn(u32) -> usize) -> Scene {
    let mut primitives: Vec<Primitive> = Vec::new();
    for i in 0..layers {
        let part = part_of(i);
        while primitives.len() <= part {
            primitives.push(Primitive::default());
        }
        append(&mut primitives[part], &square(1.0, -gap * f64::from(i)));
    }
    // Parts that have no square get a small one far to the side, so that part numbers stay.
    for p in primitives.iter_mut().filter(|p| p.triangles.is_empty()) {
        *p = moved(square(0.01, 0.0), DVec3::new(30.0, 0.0, 0.0));
    }
    parts(primitives)
}
