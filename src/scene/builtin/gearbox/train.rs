//! What turns: sun on the input shaft, planets on their pins, carrier with the output shaft, ring gear, bearings.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2};

use super::super::{
    assembly::{Assembly, shift},
    bearings::{BallBearing, BearingMaterials},
    kit::{
        Chamfer, Path, Shell, Step, bevel, external_gear, extrude, face, internal_gear, prism, revolve, revolve_with,
        socket_screw, spline, turned, wall,
    },
};
use super::housing::{angles, bolt_circle, loops};
use super::{FINE, Materials, SMALL};

const MODULE: f64 = 2.0;
const SUN: u32 = 24;
const PLANET: u32 = 18;
const RING: u32 = 60;
const PLANETS: usize = 4;

/// Distance of the planets' axes from the sun's.
const ORBIT: f64 = MODULE * (SUN + PLANET) as f64 / 2.0;

/// Adds everything that turns, and the ring gear.
pub fn add(a: &mut Assembly, root: usize, m: &Materials) {
    let gears = a.group(Some(root), "Gear train", DMat4::IDENTITY);
    gear_set(a, gears, m);
    let carrier = a.group(Some(root), "Carrier and output", DMat4::IDENTITY);
    carrier_set(a, carrier, m);
    let input = a.group(Some(root), "Input", DMat4::IDENTITY);
    a.single(input, "input shaft", &input_shaft(), m.shaft);
    let outline = Path::closed(
        &[Step::To(-13.8, -2.95), Step::To(13.8, -2.95), Step::To(13.8, 2.95), Step::To(-13.8, 2.95)],
        FINE,
    );
    let key = prism(&outline, &[], 5.6, 11.4, Chamfer::Cut(0.3));
    // The key's long side along z, its height along x.
    let lay = shift(0.0, 0.0, -112.0) * DMat4::from_rotation_y(PI / 2.0);
    a.single(input, "parallel key", &key.moved(lay), m.key);
    bearing_set(a, root, m);
}

fn circle(radius: f64) -> Path {
    Path::circle(DVec2::ZERO, radius, FINE.circle(radius))
}

/// The angle by which a planet at `place` (angle on its orbit) must be turned to mesh with the sun, which has a tooth at
/// +x: where the sun shows a tooth, the planet shows a gap.
fn planet_turn(place: f64) -> f64 {
    let (sun, planet) = (f64::from(SUN), f64::from(PLANET));
    // Tooth phases (fractions of a pitch) seen along the line of centers must add up to one half.
    let sun_phase = place * sun / TAU;
    place + PI - (0.5 - sun_phase) * TAU / planet
}

/// The angle of the ring gear whose gap at +x meets the teeth of the planet at angle 0.
fn ring_turn() -> f64 {
    let phase = -planet_turn(0.0) * f64::from(PLANET) / TAU;
    -phase * TAU / f64::from(RING)
}

fn gear_set(a: &mut Assembly, group: usize, m: &Materials) {
    let sides = |size: f64| [Chamfer::Cut(size); 2];
    let sun = extrude(&external_gear(MODULE, SUN), &[circle(10.03)], -15.0, 15.0, sides(0.3), sides(0.6));
    a.single(group, "sun gear", &sun, m.gear);
    let opening = internal_gear(MODULE, RING).placed(ring_turn(), DVec2::ZERO);
    let ring = extrude(&circle(75.0), &[opening], -18.0, 18.0, sides(1.0), sides(0.3));
    a.single(group, "ring gear", &ring, m.gear);

    let planet = extrude(&external_gear(MODULE, PLANET), &[circle(9.0)], -14.0, 14.0, sides(0.3), sides(0.6));
    let planet = a.mesh("planet gear", &planet, m.planet);
    let pin = a.mesh("planet pin", &pin(), m.shaft);
    let rollers = a.mesh("needle rollers", &rollers(), m.ring);
    let thrust = extrude(&circle(13.5), &[circle(6.1)], -1.2, 1.2, sides(0.2), sides(0.2));
    let thrust = a.mesh("thrust washer", &thrust, m.cage);
    for i in 0..PLANETS {
        let place = TAU * i as f64 / PLANETS as f64;
        let center = DVec2::from_angle(place) * ORBIT;
        let set = a.group(Some(group), &format!("Planet {}", i + 1), shift(center.x, center.y, 0.0));
        a.part(set, "planet gear", planet, DMat4::from_rotation_z(planet_turn(place)));
        a.part(set, "pin", pin, DMat4::IDENTITY);
        a.part(set, "needle rollers", rollers, DMat4::IDENTITY);
        a.part(set, "front thrust washer", thrust, shift(0.0, 0.0, 15.5));
        a.part(set, "rear thrust washer", thrust, shift(0.0, 0.0, -15.5));
    }
}

fn pin() -> Shell {
    let profile = [
        Step::To(0.0, -26.5),
        Step::Cut(5.95, -26.5, 0.7),
        Step::Cut(5.95, 26.5, 0.7),
        Step::To(3.0, 26.5),
        Step::To(2.0, 25.5),
        Step::To(2.0, 0.0),
        Step::To(0.0, -1.0),
    ];
    revolve(&Path::open(&profile, FINE), FINE)
}

/// Fourteen needles around a pin: one part, as a caged set is.
fn rollers() -> Shell {
    let (radius, half) = (1.47, 12.0);
    let profile =
        [Step::To(0.0, -half), Step::Round(radius, -half, 0.5), Step::Round(radius, half, 0.5), Step::To(0.0, half)];
    let one = revolve(&Path::open(&profile, SMALL), SMALL);
    let mut all = Shell::new();
    for i in 0..14 {
        let at = DVec2::from_angle(TAU * i as f64 / 14.0) * 7.475;
        all.add(&one, shift(at.x, at.y, 0.0));
    }
    all
}

/// Holes of the carrier plates: for the pins, and between them for the bolts.
fn carrier_holes() -> Vec<Path> {
    let pins = (0..PLANETS).map(|i| {
        let at = DVec2::from_angle(TAU * i as f64 / PLANETS as f64) * ORBIT;
        Path::circle(at, 6.0, FINE.circle(6.0))
    });
    pins.chain(bolt_circle(PLANETS, 45.0, 3.3)).collect()
}

fn ring_of(radius: f64) -> Path {
    Path::circle(DVec2::ZERO, radius, angles().len())
}

fn output_carrier() -> Shell {
    let profile = [
        Step::To(0.0, 17.0),
        Step::Open(55.0, 17.0),
        Step::To(56.0, 18.0),
        Step::To(56.0, 26.0),
        Step::To(55.0, 27.0),
        Step::Open(27.0, 27.0),
        Step::Round(24.0, 27.0, 2.5),
        Step::Cut(24.0, 39.9, 0.6),
        Step::To(20.0, 39.9),
        Step::To(20.0, 113.0),
        Step::To(19.0, 114.0),
        Step::Open(0.0, 114.0),
    ];
    let mut s = revolve_with(&Path::open(&profile, FINE), &angles());
    let holes = carrier_holes();
    for hole in &holes {
        wall(&mut s, hole, 17.0, 27.0, false);
    }
    face(&mut s, 17.0, &loops(&ring_of(55.0), &holes), false);
    face(&mut s, 27.0, &loops(&ring_of(55.0), holes.iter().chain([&ring_of(27.0)])), true);
    // The splined end, with a center hole.
    let teeth = spline(20, 15.2, 17.5);
    let center = circle(4.0);
    face(&mut s, 114.0, &loops(&ring_of(19.0), [&teeth]), true);
    wall(&mut s, &teeth, 114.0, 151.0, true);
    bevel(&mut s, &teeth, 151.0, 152.0, 0.3, true);
    face(&mut s, 152.0, &loops(&teeth.offset(-0.3), [&center.offset(1.0)]), true);
    bevel(&mut s, &center, 151.0, 152.0, 1.0, false);
    wall(&mut s, &center, 136.0, 151.0, false);
    face(&mut s, 136.0, &[center.points()], true);
    s
}

fn rear_carrier() -> Shell {
    let profile = [
        Step::Cut(12.5, -44.0, 0.6),
        Step::Cut(22.0, -44.0, 0.8),
        Step::To(22.0, -29.0),
        Step::To(25.0, -29.0),
        Step::To(25.0, -27.0),
        Step::Open(55.0, -27.0),
        Step::To(56.0, -26.0),
        Step::To(56.0, -18.0),
        Step::To(55.0, -17.0),
        Step::Open(12.5, -17.0),
    ];
    let mut s = revolve_with(&Path::closed(&profile, FINE), &angles());
    let holes = carrier_holes();
    for hole in &holes {
        wall(&mut s, hole, -27.0, -17.0, false);
    }
    face(&mut s, -27.0, &loops(&ring_of(55.0), holes.iter().chain([&ring_of(25.0)])), false);
    face(&mut s, -17.0, &loops(&ring_of(55.0), holes.iter().chain([&ring_of(12.5)])), true);
    s
}

fn carrier_set(a: &mut Assembly, group: usize, m: &Materials) {
    a.single(group, "output carrier and shaft", &output_carrier(), m.carrier);
    a.single(group, "rear carrier plate", &rear_carrier(), m.carrier);
    // Spacer between two planets; it keeps 2 mm off their teeth.
    let outline = Path::closed(
        &[
            Step::Round(36.0, -5.0, 2.5),
            Step::Round(53.0, -13.0, 3.0),
            Step::Round(55.0, 0.0, 20.0),
            Step::Round(53.0, 13.0, 3.0),
            Step::Round(36.0, 5.0, 2.5),
        ],
        FINE,
    );
    let hole = Path::circle(DVec2::new(45.0, 0.0), 3.3, FINE.circle(3.3));
    let spacer = a.mesh("carrier spacer", &prism(&outline, &[hole], -16.97, 16.97, Chamfer::Cut(0.5)), m.carrier);
    a.circle(group, "spacer", spacer, PLANETS, PI / PLANETS as f64, DMat4::IDENTITY);
    let screw = a.mesh("cap screw M6x52", &socket_screw(6.0, 1.0, 52.0, SMALL), m.bolt);
    a.circle(group, "carrier screw", screw, PLANETS, PI / PLANETS as f64, shift(45.0, 0.0, 27.03));
}

/// The input shaft with a closed keyway in its free end.
fn input_shaft() -> Shell {
    let (radius, half, depth) = (9.0_f64, 3.0_f64, 3.5);
    let edge = (half / radius).asin();
    let count = FINE.circle(13.0);
    // The keyway's edges are rings' points as well; ring points next to them would make slivers.
    let step = TAU / count as f64;
    let mut turns: Vec<f64> =
        (0..count).map(|i| i as f64 * step).filter(|t| (t.min(TAU - t) - edge).abs() > 0.3 * step).collect();
    turns.extend([edge, TAU - edge]);
    turns.sort_by(f64::total_cmp);
    let (z0, z1) = (-126.0, -98.0);
    let profile = [
        Step::To(0.0, -132.0),
        Step::Cut(radius, -132.0, 1.0),
        Step::To(radius, z0),
        Step::Open(radius, z1),
        Step::Cut(radius, -90.0, 0.0),
        Step::Cut(10.0, -90.0, 0.5),
        Step::To(10.0, -57.95),
        Step::Cut(13.0, -57.95, 0.6),
        Step::Cut(13.0, -49.0, 0.6),
        Step::To(10.0, -49.0),
        Step::Cut(10.0, 16.0, 0.8),
        Step::To(0.0, 16.0),
    ];
    let mut s = revolve_with(&Path::open(&profile, FINE), &turns);
    let bottom = radius - depth;
    let round = |t: f64| (DVec2::from_angle(t) * radius, DVec2::from_angle(t), DVec2::from_angle(t));
    let mut knots: Vec<_> = turns.iter().filter(|&&t| t >= edge && t <= TAU - edge).map(|&t| round(t)).collect();
    if let Some(first) = knots.first_mut() {
        first.1 = DVec2::NEG_Y;
    }
    if let Some(last) = knots.last_mut() {
        last.2 = DVec2::Y;
    }
    knots.push((DVec2::new(bottom, -half), DVec2::Y, DVec2::X));
    knots.push((DVec2::new(bottom, half), DVec2::X, DVec2::NEG_Y));
    wall(&mut s, &Path::from_knots(knots), z0, z1, true);
    let arc = turns.iter().filter(|&&t| t > TAU - edge - 1e-9).chain(turns.iter().filter(|&&t| t < edge + 1e-9));
    let mut end: Vec<DVec2> = arc.map(|&t| DVec2::from_angle(t) * radius).collect();
    end.extend([DVec2::new(bottom, half), DVec2::new(bottom, -half)]);
    face(&mut s, z0, std::slice::from_ref(&end), true);
    face(&mut s, z1, &[end], false);
    s
}

fn bearing_set(a: &mut Assembly, root: usize, m: &Materials) {
    let materials = BearingMaterials { ring: m.ring, ball: m.ball, cage: m.cage };
    let group = a.group(Some(root), "Bearings", DMat4::IDENTITY);
    let main = BallBearing { bore: 20.02, outer: 39.98, width: 18.0, balls: 9 };
    let meshes = main.meshes(a, "6208", materials, FINE);
    main.add(a, group, "Output bearing, inner", meshes, shift(0.0, 0.0, 49.0));
    main.add(a, group, "Output bearing, outer", meshes, shift(0.0, 0.0, 85.1));
    let rear = BallBearing { bore: 22.02, outer: 35.98, width: 14.0, balls: 14 };
    let meshes = rear.meshes(a, "carrier bearing", materials, FINE);
    rear.add(a, group, "Carrier bearing", meshes, shift(0.0, 0.0, -36.3));
    let input = BallBearing { bore: 10.02, outer: 20.98, width: 12.0, balls: 8 };
    let meshes = input.meshes(a, "6004", materials, FINE);
    input.add(a, group, "Input bearing", meshes, shift(0.0, 0.0, -64.1));
    // Spacers on the output shaft: between the bearings' inner rings.
    let sleeve = turned(
        &[
            Step::Cut(20.05, 58.05, 0.3),
            Step::Cut(24.0, 58.05, 0.3),
            Step::Cut(24.0, 76.05, 0.3),
            Step::Cut(20.05, 76.05, 0.3),
        ],
        FINE,
    );
    a.single(group, "spacer sleeve", &sleeve, m.cage);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether `point` lies inside the closed outline.
    fn inside(outline: &[DVec2], p: DVec2) -> bool {
        let mut odd = false;
        for i in 0..outline.len() {
            let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                odd = !odd;
            }
        }
        odd
    }

    #[test]
    fn teeth_mesh_without_cutting_into_each_other() {
        let sun = external_gear(MODULE, SUN).points();
        let opening = internal_gear(MODULE, RING).placed(ring_turn(), DVec2::ZERO).points();
        for i in 0..PLANETS {
            let place = TAU * i as f64 / PLANETS as f64;
            let center = DVec2::from_angle(place) * ORBIT;
            let planet = external_gear(MODULE, PLANET).placed(planet_turn(place), center).points();
            assert!(planet.iter().all(|&p| !inside(&sun, p)), "planet {i} cuts into the sun");
            assert!(sun.iter().all(|&p| !inside(&planet, p)), "the sun cuts into planet {i}");
            assert!(planet.iter().all(|&p| inside(&opening, p)), "planet {i} cuts into the ring");
            assert!(opening.iter().all(|&p| !inside(&planet, p)), "the ring cuts into planet {i}");
            let gap = planet.iter().flat_map(|p| sun.iter().map(|s| p.distance(*s))).fold(f64::MAX, f64::min);
            assert!(gap < 0.5, "planet {i} and the sun are {gap} apart");
        }
    }
}
