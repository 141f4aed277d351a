//! Shafts, drums, bearings and the annular combustor.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2};

use super::super::{
    assembly::{Assembly, shift},
    bearings::{BallBearing, BearingMaterials},
    kit::{Chamfer, Path, Perforation, Shell, Step, extrude, perforated_tube, revolve, torus_tube},
};
use super::{COARSE, Materials, SMALL, sheet, smooth, tube};

/// Fuel nozzles, and holes in the dome.
const NOZZLES: usize = 18;

/// Adds the inner parts that are not blade rows.
pub fn add(a: &mut Assembly, root: usize, m: &Materials) {
    shafts(a, root, m);
    bearings(a, root, m);
    combustor(a, root, m);
}

fn shafts(a: &mut Assembly, root: usize, m: &Materials) {
    let set = a.group(Some(root), "Shafts", DMat4::IDENTITY);
    a.single(set, "center vent tube", &tube((-10.0, 2290.0), 22.0, 28.0), m.cage);
    // The low-pressure shaft swells to its couplings at both ends.
    let low =
        [(60.0, 86.0), (330.0, 86.0), (420.0, 74.0), (700.0, 70.0), (1700.0, 70.0), (1850.0, 76.0), (2210.0, 76.0)];
    a.single(set, "low-pressure shaft", &sheet(&low, 16.0), m.lp_shaft);
    let high = [(640.0, 112.0), (760.0, 112.0), (1000.0, 108.0), (1500.0, 108.0), (1620.0, 114.0), (1745.0, 116.0)];
    a.single(set, "high-pressure shaft", &sheet(&high, 14.0), m.hp_shaft);
    let baffle = [(690.0, 93.5), (1200.0, 90.0), (1700.0, 93.0)];
    a.single(set, "shaft baffle tube", &sheet(&baffle, 3.0), m.cage);
    let spinner = [0.0, 12.0].map(|inset: f64| {
        let at = |k: usize| {
            let (sin, cos) = (PI / 2.0 * k as f64 / 16.0).sin_cos();
            let (r, z) = (272.0 - inset, 330.0 - inset);
            (DVec2::new(if k == 0 { 0.0 } else { r * sin }, -z * cos), DVec2::new(r * cos, z * sin))
        };
        (0..=16).map(at).collect::<Vec<_>>()
    });
    let [outer, mut inner] = spinner;
    inner.reverse();
    let path = Path::open(&[Step::Curve(outer), Step::Curve(inner)], COARSE);
    a.single(set, "spinner", &revolve(&path, COARSE), m.nacelle);
    let drum = [(230.0, 330.0), (300.0, 335.0), (450.0, 328.0), (600.0, 300.0)];
    a.single(set, "booster drum", &sheet(&drum, 8.0), m.disc);
    let drum = [(715.0, 225.0), (900.0, 231.0), (1100.0, 234.0), (1185.0, 232.0)];
    a.single(set, "compressor drum", &sheet(&drum, 7.0), m.disc);
    let cone = [(205.0, 262.0), (250.0, 240.0), (300.0, 150.0), (330.0, 112.0), (380.0, 104.0)];
    a.single(set, "fan drive cone", &sheet(&cone, 8.0), m.lp_shaft);
    let cone = [(1186.0, 222.0), (1210.0, 190.0), (1240.0, 140.0), (1260.0, 128.0)];
    a.single(set, "compressor rear cone", &sheet(&cone, 7.0), m.hp_shaft);
    let cone = [(2000.0, 235.0), (2050.0, 190.0), (2090.0, 120.0), (2120.0, 96.0)];
    a.single(set, "turbine drive cone", &sheet(&cone, 8.0), m.lp_shaft);
}

fn bearings(a: &mut Assembly, root: usize, m: &Materials) {
    let materials = BearingMaterials { ring: m.bearing, ball: m.bearing, cage: m.cage };
    let set = a.group(Some(root), "Bearings", DMat4::IDENTITY);
    let fan = BallBearing { bore: 86.5, outer: 150.0, width: 42.0, balls: 12 };
    let meshes = fan.meshes(a, "fan bearing", materials, SMALL);
    fan.add(a, set, "Fan bearing", meshes, shift(0.0, 0.0, 180.0));
    let high = BallBearing { bore: 112.6, outer: 165.0, width: 34.0, balls: 16 };
    let meshes = high.meshes(a, "high-pressure bearing", materials, SMALL);
    high.add(a, set, "High-pressure bearing", meshes, shift(0.0, 0.0, 665.0));
    let rear = BallBearing { bore: 76.5, outer: 118.0, width: 30.0, balls: 14 };
    let meshes = rear.meshes(a, "rear bearing", materials, SMALL);
    rear.add(a, set, "Rear bearing", meshes, shift(0.0, 0.0, 2180.0));
    let sump = [(155.0, 162.0), (205.0, 162.0), (260.0, 190.0), (450.0, 270.0), (640.0, 288.0)];
    a.single(set, "front bearing housing", &sheet(&sump, 7.0), m.casing);
    let sump = [(645.0, 180.0), (685.0, 180.0), (700.0, 205.0)];
    a.single(set, "high-pressure bearing housing", &sheet(&sump, 8.0), m.casing);
    let sump = [(2140.0, 222.0), (2155.0, 160.0), (2168.0, 132.0), (2200.0, 130.0)];
    a.single(set, "rear bearing housing", &sheet(&sump, 7.0), m.casing);
}

fn combustor(a: &mut Assembly, root: usize, m: &Materials) {
    let set = a.group(Some(root), "Combustor", DMat4::IDENTITY);
    let liner = |inner: f64, holes: usize, z1: f64, radius: f64| Perforation {
        inner,
        outer: inner + 3.5,
        z0: 1272.0,
        z1,
        rows: 4,
        holes,
        hole_radius: radius,
        divisions: 2,
        shift: 0.5,
    };
    a.single(set, "outer liner", &perforated_tube(&liner(362.0, 36, 1540.0, 11.0)), m.liner);
    a.single(set, "inner liner", &perforated_tube(&liner(206.0, 24, 1540.0, 10.0)), m.liner);
    let outer = [(1541.0, 365.5), (1560.0, 362.0), (1590.0, 344.0)];
    a.single(set, "outer transition", &sheet(&outer, 3.5), m.liner);
    let inner = [(1541.0, 209.5), (1560.0, 214.0), (1590.0, 236.0)];
    a.single(set, "inner transition", &sheet(&inner, 3.5), m.liner);

    let ring = |radius: f64| Path::circle(DVec2::ZERO, radius, COARSE.circle(400.0));
    let mut holes = vec![ring(206.0)];
    let spot = |i: usize| DVec2::from_angle(TAU * i as f64 / NOZZLES as f64) * 286.0;
    holes.extend((0..NOZZLES).map(|i| Path::circle(spot(i), 30.0, 32)));
    let dome = extrude(&ring(365.0), &holes, 1264.0, 1271.0, [Chamfer::Cut(1.0); 2], [Chamfer::None; 2]);
    a.single(set, "dome", &dome, m.liner);
    let cowl = [(1271.0, 364.0), (1248.0, 358.0), (1232.0, 340.0), (1226.0, 318.0)];
    let mut points = cowl.to_vec();
    points.reverse();
    a.single(set, "outer dome cowl", &sheet(&points, 3.0), m.liner);
    let points = [(1226.0, 252.0), (1232.0, 230.0), (1248.0, 213.0), (1263.0, 209.0)];
    a.single(set, "inner dome cowl", &sheet(&points, 3.0), m.liner);

    let swirler = a.mesh("swirler", &swirler(), m.fuel);
    a.circle(set, "swirler", swirler, NOZZLES, 0.0, shift(286.0, 0.0, 1268.0));
    let nozzle = a.mesh("fuel nozzle", &nozzle(), m.fuel);
    a.circle(set, "fuel nozzle", nozzle, NOZZLES, 0.0, shift(286.0, 0.0, 1246.0));
    let stem = a.mesh("fuel stem", &stem(), m.fuel);
    // A stem stands on its nozzle and goes out through the case to the manifold.
    a.circle(set, "fuel stem", stem, NOZZLES, 0.0, shift(298.0, 0.0, 1226.0) * DMat4::from_rotation_y(PI / 2.0));
    a.single(set, "fuel manifold", &torus_tube(452.0, 9.0, 1226.0, COARSE), m.fuel);
}

/// A flared ring that guides air around a nozzle.
fn swirler() -> Shell {
    let outer = smooth(&[(-14.0, 29.0), (0.0, 27.5), (12.0, 31.0), (22.0, 40.0)]);
    let inner = outer.iter().rev().map(|&(p, t)| (p - DVec2::new(t.y, -t.x) * 3.0, -t)).collect();
    revolve(&Path::closed(&[Step::Curve(outer), Step::Curve(inner)], COARSE), COARSE)
}

fn nozzle() -> Shell {
    let steps = [
        Step::To(0.0, -34.0),
        Step::Round(15.0, -34.0, 5.0),
        Step::Round(15.0, 6.0, 4.0),
        Step::Round(9.0, 22.0, 2.0),
        Step::To(6.0, 24.0),
        Step::To(4.0, 14.0),
        Step::To(0.0, 12.0),
    ];
    revolve(&Path::open(&steps, SMALL), SMALL)
}

fn stem() -> Shell {
    let steps = [
        Step::To(0.0, 0.0),
        Step::Cut(7.0, 0.0, 1.0),
        Step::Round(7.0, 90.0, 2.0),
        Step::Cut(16.0, 92.0, 1.0),
        Step::Round(16.0, 108.0, 2.0),
        Step::Round(8.0, 114.0, 2.0),
        Step::Cut(8.0, 152.0, 1.0),
        Step::To(0.0, 152.0),
    ];
    revolve(&Path::open(&steps, SMALL), SMALL)
}
