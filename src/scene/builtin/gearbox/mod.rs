//! A planetary gearbox: 24-tooth sun, four 18-tooth planets, 60-tooth ring, module 2, in a three-piece housing on feet.
//!
//! Lengths are millimetres; the root node scales to metres. The axis is z, the input shaft comes from −z, the output
//! shaft leaves to +z. Parts that repeat share a mesh. The reduction is 1 + 60/24 = 3.5.

mod housing;
mod train;

use glam::{DMat4, DVec3};

use super::assembly::Assembly;
use super::kit::Tolerance;
use crate::scene::Scene;

/// Chord tolerance of everything that is turned or cut, mm.
const FINE: Tolerance = Tolerance(0.02);

/// Chord tolerance of bolts and other small things, of which there are many, mm.
const SMALL: Tolerance = Tolerance(0.03);

/// Materials by what they are for.
struct Materials {
    housing: usize,
    cover: usize,
    base: usize,
    gear: usize,
    planet: usize,
    carrier: usize,
    shaft: usize,
    ring: usize,
    ball: usize,
    cage: usize,
    rubber: usize,
    gasket: usize,
    bolt: usize,
    key: usize,
}

pub(super) fn scene() -> Scene {
    let mut a = Assembly::new("gearbox");
    let m = Materials {
        housing: a.material("housing, painted cast iron", 0xA9BACB, 0.0, 0.55),
        cover: a.material("covers, painted", 0x8FA3B8, 0.0, 0.5),
        base: a.material("base plate", 0x8C8F86, 0.3, 0.6),
        gear: a.material("gear steel", 0xB8B6B0, 0.8, 0.35),
        planet: a.material("planet bronze", 0xC59A5C, 0.8, 0.38),
        carrier: a.material("carrier steel", 0x86A08C, 0.5, 0.45),
        shaft: a.material("shaft steel", 0x7F8894, 0.85, 0.35),
        ring: a.material("bearing steel", 0xD4D8DC, 0.9, 0.22),
        ball: a.material("ball steel", 0xE4E6E8, 0.95, 0.12),
        cage: a.material("cage brass", 0xD0AE62, 0.7, 0.4),
        rubber: a.material("seal rubber", 0x9A4A44, 0.0, 0.7),
        gasket: a.material("gasket", 0x7C8C6C, 0.0, 0.85),
        bolt: a.material("zinc-plated steel", 0xA6A8B0, 0.85, 0.35),
        key: a.material("key steel", 0xB07A5A, 0.7, 0.4),
    };
    let root = a.group(None, "Planetary gearbox", DMat4::from_scale(DVec3::splat(0.001)));
    housing::add(&mut a, root, &m);
    train::add(&mut a, root, &m);
    a.into_scene()
}

#[cfg(test)]
mod tests {
    use super::super::{
        build,
        kit::shell::{faults, volume},
        probe::Rays,
    };
    use glam::DVec3;

    #[test]
    fn every_mesh_is_a_closed_solid() {
        let scene = build("gearbox").unwrap();
        let mut found = Vec::new();
        for mesh in &scene.meshes {
            let primitive = &mesh.primitives[0];
            found.extend(faults(primitive).into_iter().map(|f| format!("{}: {f}", mesh.name)));
            if volume(primitive) <= 0.0 {
                found.push(format!("{} is inside out", mesh.name));
            }
        }
        assert_eq!(found, Vec::<String>::new());
    }

    #[test]
    fn it_is_large_shared_and_deep() {
        let scene = build("gearbox").unwrap();
        assert!(scene.parts.len() >= 60, "{} parts", scene.parts.len());
        assert!(scene.triangle_count() >= 200_000, "{} triangles", scene.triangle_count());
        assert!(scene.meshes.len() * 2 < scene.parts.len(), "repeated parts share their mesh");
        let sphere = scene.bounds().bounding_sphere();
        let depths = Rays::new(&scene).depth_map(sphere.center, sphere.radius, DVec3::new(-1.0, -0.7, -1.2), 72);
        let covered: Vec<usize> = depths.into_iter().filter(|&d| d > 0).collect();
        assert!(covered.iter().all(|d| d % 2 == 0), "closed solids are entered as often as they are left");
        let mean = covered.iter().sum::<usize>() as f64 / covered.len() as f64;
        println!("gearbox: mean depth complexity {mean:.1}, largest {:?}", covered.iter().max());
        assert!(mean >= 8.0, "mean depth complexity {mean}");
    }
}
