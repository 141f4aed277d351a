//! The synthetic stack of the Bucketed k-Buffer paper, Section 6: full-screen quads at random depths, each with a random
//! object, so that every pixel has exactly as many layers as there are quads and only the number of objects varies.
//!
//! The paper draws an object id per quad. Here every part gets at least one quad (else "n parts" would mean fewer), and
//! the rest are drawn. Depths are random but at least half a mean step apart, so that the order is the same at any
//! precision. The camera "front" is orthographic and looks along −z; the quads reach far beyond a square image, so they
//! fill any image up to an aspect of 4.

use glam::{DMat4, DVec3};

use super::{
    BuiltinError,
    assembly::{Assembly, shift},
    parameters::{Parameters, Random},
};
use crate::math::Projection;
use crate::scene::{Primitive, Scene, SceneCamera};

/// Half a quad's width over half the height of the front camera's image.
const REACH: f32 = 4.0;

pub(super) fn scene(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [parts, seed, layers] =
        p.take([("parts", 32.0, 1.0, 256.0), ("seed", 1.0, 0.0, 4_294_967_295.0), ("layers", 32.0, 1.0, 256.0)])?;
    let layers = layers as usize;
    let parts = (parts as usize).min(layers);
    let mut random = Random::new(seed as u64);
    let mut owners: Vec<usize> =
        (0..layers).map(|i| if i < parts { i } else { random.below(parts as u64) as usize }).collect();
    for i in (1..layers).rev() {
        owners.swap(i, random.below(i as u64 + 1) as usize);
    }
    let step = 1.0 / layers as f64;
    let depths: Vec<f64> = (0..layers).map(|i| step * (i as f64 + 0.25 + 0.5 * random.unit())).collect();
    // Triangles come in random order too: an order by depth would favour some captures.
    let mut order: Vec<usize> = (0..layers).collect();
    for i in (1..layers).rev() {
        order.swap(i, random.below(i as u64 + 1) as usize);
    }
    let mut assembly = Assembly::new("quads");
    let root = assembly.group(None, "quads", DMat4::IDENTITY);
    for part in 0..parts {
        let hue = part as f64 / parts as f64 * std::f64::consts::TAU;
        let channel = |phase: f64| (150.0 + 60.0 * (hue + phase).cos()) as u32;
        let color = channel(0.0) << 16 | channel(2.1) << 8 | channel(4.2);
        let material = assembly.material(&format!("part {}", part + 1), color, 0.0, 0.6);
        let mut primitive = Primitive { material, ..Primitive::default() };
        for &layer in order.iter().filter(|&&l| owners[l] == part) {
            let base = primitive.positions.len() as u32;
            let z = -depths[layer] as f32;
            let corners = [(-REACH, -REACH), (REACH, -REACH), (REACH, REACH), (-REACH, REACH)];
            primitive.positions.extend(corners.map(|(x, y)| [x, y, z]));
            primitive.normals.extend([[0.0, 0.0, 1.0]; 4]);
            primitive.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
        let name = format!("part {}", part + 1);
        let mesh = assembly.mesh_of(&name, primitive);
        assembly.part(root, &name, mesh, DMat4::IDENTITY);
    }
    let mut scene = assembly.into_scene();
    scene.cameras.push(SceneCamera {
        name: "front".to_owned(),
        world_from_camera: shift(0.0, 0.0, DVec3::ONE.z),
        projection: Projection::Orthographic { height: 2.0 },
    });
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::super::{build, probe};
    use super::*;

    #[test]
    fn every_pixel_sees_every_layer_and_every_part_has_a_quad() {
        for parts in [1, 6, 32] {
            let scene = build(&format!("quads?parts={parts}&seed=7")).unwrap();
            assert_eq!(scene.parts.len(), parts);
            assert_eq!(scene.triangle_count(), 64);
            let rays = probe::Rays::new(&scene);
            for (x, y) in [(-0.99, 0.3), (0.4, 0.97), (3.9, -0.5)] {
                assert_eq!(rays.crossings(DVec3::new(x, y, 1.0), DVec3::NEG_Z), 32);
            }
        }
        assert_eq!(build("quads?seed=3").unwrap().meshes, build("quads?seed=3").unwrap().meshes);
    }
}
