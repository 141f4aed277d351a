//! `builtin:contact`: a press fit, in which nearly every face of a part lies exactly on a face of another.
//!
//! A block between two plates, held by four pins that end flush with the plates; in its bore a sleeve, in the sleeve a shaft,
//! and between these two a key in its keyways. Which of two touching faces a sight line meets first is up to the last bit of
//! its depth, so layers change places from pixel to pixel: a halo that follows their order sprinkles every contact (T19).
//!
//! Fits are exact in `f32`: touching outlines are made of the same points, and those are multiples of 1/1024, which no part's
//! grid rounds any further. Faces in one plane are cut into other triangles each, as separately made parts are.

use glam::{DMat4, DVec2};

use super::assembly::{Assembly, shift};
use super::kit::{Chamfer, Path, Step, Tolerance, prism};
use super::{BuiltinError, parameters::Parameters};
use crate::scene::Scene;

/// Radii of shaft and sleeve, half width of the key, and how far from the axis its two faces lie.
const SHAFT: f64 = 12.0;
const SLEEVE: f64 = 24.0;
const KEY: f64 = 3.0;
const KEY_FROM: f64 = 8.0;
const KEY_TO: f64 = 16.0;
/// Height of the block, thickness of the plates, how far the shaft stands out of them.
const BLOCK: f64 = 30.0;
const PLATE: f64 = 8.0;
const STUB: f64 = 14.0;
/// Radius of the pins and where they stand.
const PIN: f64 = 4.0;
const PIN_AT: f64 = 30.0;

fn snapped(mut path: Path) -> Path {
    for knot in &mut path.knots {
        knot.point = (knot.point * 1024.0).round() / 1024.0;
    }
    path
}

/// The shaft's round from one side of the keyway to the other, as (point, normal); `chords` for a whole turn.
fn round(chords: usize) -> Vec<(DVec2, DVec2)> {
    let from = (KEY / SHAFT).asin();
    let last = chords - chords / 8;
    let sweep = std::f64::consts::TAU - 2.0 * from;
    let normal = |i: usize| DVec2::from_angle(from + sweep * i as f64 / last as f64);
    (0..=last).map(|i| (normal(i) * SHAFT, normal(i))).collect()
}

/// The round, closed by a keyway down or up to the distance `to` from the axis.
fn keyed(chords: usize, to: f64) -> Path {
    let arc = round(chords);
    let end = arc.len() - 1;
    let outward = (to - SHAFT).signum();
    // The keyway's sides look at each other in the shaft, and away from the hole's inside in the sleeve.
    let side = DVec2::new(0.0, outward);
    let knots = arc.iter().enumerate().map(|(i, &(point, normal))| {
        let before = if i == 0 { side } else { normal };
        let after = if i == end { -side } else { normal };
        (point, before, after)
    });
    let corners = [(DVec2::new(to, -KEY), -side, DVec2::X), (DVec2::new(to, KEY), DVec2::X, side)];
    snapped(Path::from_knots(knots.chain(corners)))
}

/// The whole round: the same points, and those across the keyway.
fn whole(chords: usize) -> Path {
    let across = chords / 8;
    let from = (KEY / SHAFT).asin();
    let closing = (1..across).map(|i| DVec2::from_angle(2.0 * from * i as f64 / across as f64 - from));
    let knots = round(chords).into_iter().chain(closing.map(|n| (n * SHAFT, n)));
    snapped(Path::from_knots(knots.map(|(point, normal)| (point, normal, normal))))
}

pub(super) fn scene(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [chords] = p.take([("chords", 48.0, 16.0, 512.0)])?;
    let chords = chords as usize / 8 * 8;
    let corner = |x: f64, y: f64| Step::Round(x * 40.0, y * 40.0, 6.0);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let outline = snapped(Path::closed(&corners, Tolerance(0.1)));
    let pin = |x: f64, y: f64| snapped(Path::circle(DVec2::new(x * PIN_AT, y * PIN_AT), PIN, 24));
    let pins = [pin(-1.0, -1.0), pin(1.0, -1.0), pin(1.0, 1.0), pin(-1.0, 1.0)];
    let bore = snapped(Path::circle(DVec2::ZERO, SLEEVE, chords));
    let key = [Step::To(KEY_FROM, -KEY), Step::To(KEY_TO, -KEY), Step::To(KEY_TO, KEY), Step::To(KEY_FROM, KEY)];
    let holes = |first: Path| std::iter::once(first).chain(pins.iter().cloned()).collect::<Vec<Path>>();

    let mut assembly = Assembly::new("contact");
    let root = assembly.group(None, "press fit", DMat4::IDENTITY);
    let cast = assembly.material("cast iron", 0x8C96A0, 0.0, 0.6);
    let plate = assembly.material("steel plate", 0xA9B6BF, 0.0, 0.5);
    let bronze = assembly.material("bronze", 0xC49A5A, 0.0, 0.45);
    let steel = assembly.material("steel", 0xB8BEC6, 0.0, 0.4);
    let brass = assembly.material("brass", 0xCBB26A, 0.0, 0.45);
    let solid = |outline: &Path, holes: &[Path], z0: f64, z1: f64| prism(outline, holes, z0, z1, Chamfer::None);

    assembly.single(root, "block", &solid(&outline, &holes(bore.clone()), 0.0, BLOCK), cast);
    let plate_mesh = assembly.mesh("plate", &solid(&outline, &holes(whole(chords)), 0.0, PLATE), plate);
    assembly.part(root, "base plate", plate_mesh, shift(0.0, 0.0, -PLATE));
    assembly.part(root, "cover plate", plate_mesh, shift(0.0, 0.0, BLOCK));
    assembly.single(root, "sleeve", &solid(&bore, &[keyed(chords, KEY_TO)], 0.0, BLOCK), bronze);
    let ends = [-PLATE - STUB, BLOCK + PLATE + STUB];
    assembly.single(root, "shaft", &solid(&keyed(chords, KEY_FROM), &[], ends[0], ends[1]), steel);
    assembly.single(root, "key", &solid(&Path::closed(&key, Tolerance(0.1)), &[], 0.0, BLOCK), brass);
    for (i, pin) in pins.iter().enumerate() {
        assembly.single(root, &format!("pin {}", i + 1), &solid(pin, &[], -PLATE, BLOCK + PLATE), steel);
    }
    Ok(assembly.into_scene())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::{
        build,
        kit::shell::{faults, volume},
    };
    use super::*;
    use glam::{DVec3, Vec3};

    /// Positions of a part in scene space, as they are in `f32`.
    fn points(scene: &Scene, name: &str) -> BTreeSet<[u32; 3]> {
        let part = scene.parts.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("{name}"));
        let place = |p: &[f32; 3]| {
            let moved = part.world_from_part.transform_point3(Vec3::from(*p).as_dvec3());
            assert_eq!(moved.as_vec3().as_dvec3(), moved, "nothing is rounded");
            (moved.as_vec3() + Vec3::ZERO).to_array().map(f32::to_bits)
        };
        scene.meshes[part.mesh].primitives[0].positions.iter().map(place).collect()
    }

    #[test]
    fn every_part_is_closed_and_touching_outlines_share_their_points() {
        let scene = build("contact").unwrap();
        let mut solid = 0.0;
        for part in &scene.parts {
            let primitive = &scene.meshes[part.mesh].primitives[0];
            assert_eq!(faults(primitive), Vec::<String>::new(), "{}", part.name);
            assert!(volume(primitive) > 0.0, "{}", part.name);
            solid += volume(primitive);
        }
        // A press fit leaves no room: all parts together fill the outer box but for its rounded corners and the key's ways
        // through the plates, and the shaft stands out of it.
        let stub = 2.0 * STUB * volume(&scene.meshes[3].primitives[0]) / (BLOCK + 2.0 * (PLATE + STUB));
        let corners = (4.0 - std::f64::consts::PI) * 36.0 * (BLOCK + 2.0 * PLATE);
        let ways = 2.0 * PLATE * 2.0 * KEY * (SHAFT - KEY_FROM);
        let filled = 6400.0 * (BLOCK + 2.0 * PLATE) - corners - ways + stub;
        assert!((solid / filled - 1.0).abs() < 0.001, "{solid} of {filled}");
        let shared = |a: &str, b: &str| points(&scene, a).intersection(&points(&scene, b)).count();
        // 48 chords at both ends; the sleeve's inside has the shaft's round and the key's corners.
        assert_eq!(shared("block", "sleeve"), 2 * 48);
        assert_eq!(shared("sleeve", "key"), 2 * 2);
        assert_eq!(shared("block", "cover plate"), shared("block", "base plate"));
        assert_eq!(shared("pin 1", "cover plate"), 24);
        assert!(shared("block", "cover plate") >= 4 * 24 + 4);
        assert_eq!(scene.parts.len(), 10);
    }

    /// Straight through plate, block and plate, and through all that is concentric: each contact is met twice.
    #[test]
    fn every_contact_is_met_twice_in_one_place() {
        let scene = build("contact").unwrap();
        let along = |x: f64, y: f64| {
            let mut heights = Vec::new();
            for part in &scene.parts {
                for primitive in &scene.meshes[part.mesh].primitives {
                    for t in &primitive.triangles {
                        let corner = |i: u32| Vec3::from(primitive.positions[i as usize]).as_dvec3();
                        let [a, b, c] = t.map(corner).map(|p| part.world_from_part.transform_point3(p));
                        let side = |p: DVec3, q: DVec3| (q - p).truncate().perp_dot(DVec2::new(x, y) - p.truncate());
                        let sides = [side(a, b), side(b, c), side(c, a)];
                        if sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0) {
                            heights.push(a.z);
                        }
                    }
                }
            }
            heights.sort_by(f64::total_cmp);
            heights
        };
        let [top, bottom] = [BLOCK + PLATE, -PLATE];
        assert_eq!(along(33.1, 7.3), [bottom, 0.0, 0.0, BLOCK, BLOCK, top], "plate, block, plate");
        assert_eq!(along(-17.2, 3.1), [bottom, 0.0, 0.0, BLOCK, BLOCK, top], "plate, sleeve, plate");
        assert_eq!(along(14.03, 0.7), [bottom, 0.0, 0.0, BLOCK, BLOCK, top], "plate, key, plate");
        assert_eq!(along(30.3, 29.1), [bottom, top], "a pin");
    }
}
