//! Nacelle, cowls, casings, struts, exhaust and bolts.

use glam::DMat4;

use super::super::{
    assembly::{Assembly, shift, upside_down},
    kit::{BladeSection, blade, hex_bolt, hex_nut, three},
};
use super::{BOLT, Materials, flanged, sheet};

/// Adds what does not turn and carries no compressor or turbine vanes.
pub fn add(a: &mut Assembly, root: usize, m: &Materials) {
    let nacelle = a.group(Some(root), "Nacelle", DMat4::IDENTITY);
    let lip = [
        (-300.0, 838.0),
        (-400.0, 818.0),
        (-470.0, 822.0),
        (-505.0, 850.0),
        (-500.0, 885.0),
        (-440.0, 940.0),
        (-250.0, 1000.0),
        (50.0, 1030.0),
        (400.0, 1026.0),
        (800.0, 990.0),
        (1150.0, 930.0),
        (1380.0, 880.0),
    ];
    a.single(nacelle, "outer cowl", &sheet(&lip, 9.0), m.nacelle);
    let duct = [
        (-298.0, 852.0),
        (-150.0, 868.0),
        (50.0, 878.0),
        (400.0, 880.0),
        (800.0, 880.0),
        (1150.0, 872.0),
        (1372.0, 858.0),
    ];
    a.single(nacelle, "inner barrel", &sheet(&duct, 12.0), m.nacelle);
    let case = a.group(Some(root), "Fan case", DMat4::IDENTITY);
    a.single(case, "containment ring", &flanged((-120.0, 330.0), (832.0, 832.0), 12.0, 18.0), m.casing);
    let rub = [(-70.0, 831.0), (0.0, 831.5), (240.0, 831.0)];
    a.single(case, "abradable liner", &sheet(&rub, 4.0), m.cage);
    guide_vanes(a, root, m);

    let core = a.group(Some(root), "Core cowl", DMat4::IDENTITY);
    let cowl = [
        (232.0, 478.0),
        (300.0, 505.0),
        (480.0, 545.0),
        (760.0, 580.0),
        (1100.0, 590.0),
        (1450.0, 570.0),
        (1800.0, 530.0),
        (2080.0, 505.0),
        (2190.0, 492.0),
    ];
    a.single(core, "core cowl", &sheet(&cowl, 6.0), m.cowl);
    let fire = [(500.0, 500.0), (760.0, 530.0), (1100.0, 545.0), (1450.0, 530.0), (1800.0, 498.0)];
    a.single(core, "fire shield", &sheet(&fire, 3.0), m.exhaust);

    let casings = a.group(Some(root), "Casings", DMat4::IDENTITY);
    let splitter = [(230.0, 470.0), (290.0, 474.0), (420.0, 462.0), (560.0, 432.0), (640.0, 390.0)];
    a.single(casings, "booster casing", &sheet(&splitter, 8.0), m.casing);
    a.single(casings, "intermediate case", &flanged((645.0, 700.0), (372.0, 345.0), 9.0, 20.0), m.casing);
    a.single(casings, "compressor casing", &flanged((702.0, 1200.0), (338.0, 268.0), 9.0, 22.0), m.casing);
    a.single(casings, "bleed manifold", &flanged((820.0, 1100.0), (392.0, 372.0), 4.0, 8.0), m.casing);
    a.single(casings, "combustor outer case", &flanged((1202.0, 1590.0), (398.0, 398.0), 10.0, 22.0), m.casing);
    a.single(casings, "combustor inner case", &flanged((1225.0, 1580.0), (166.0, 176.0), 7.0, 12.0), m.casing);
    a.single(casings, "high-pressure turbine case", &flanged((1592.0, 1780.0), (345.0, 372.0), 10.0, 24.0), m.casing);
    a.single(casings, "low-pressure turbine case", &flanged((1782.0, 2130.0), (374.0, 470.0), 9.0, 18.0), m.casing);
    a.single(casings, "cooling shroud", &flanged((1800.0, 2060.0), (425.0, 485.0), 3.0, 6.0), m.exhaust);
    exhaust(a, root, m);
    bolts(a, casings, m);
}

fn guide_vanes(a: &mut Assembly, root: usize, m: &Materials) {
    let set = a.group(Some(root), "Outlet guide vanes", DMat4::IDENTITY);
    let section =
        |radius, chord, stagger, sweep| BladeSection { radius, chord, thickness: 0.09, camber: -0.07, stagger, sweep };
    let shape = three(
        section(540.0, 150.0, -0.22, 0.0),
        section(690.0, 160.0, -0.18, 15.0),
        section(866.0, 175.0, -0.16, 40.0),
    );
    let vane = a.mesh("outlet guide vane", &blade(shape, 10, 8), m.stator);
    a.circle(set, "guide vane", vane, 32, 0.05, shift(0.0, 0.0, 470.0));
}

fn exhaust(a: &mut Assembly, root: usize, m: &Materials) {
    let set = a.group(Some(root), "Exhaust", DMat4::IDENTITY);
    let frame = a.group(Some(set), "Turbine rear frame", DMat4::IDENTITY);
    a.single(frame, "rear frame outer ring", &flanged((2132.0, 2260.0), (471.0, 474.0), 8.0, 14.0), m.casing);
    a.single(frame, "rear frame hub", &flanged((2140.0, 2255.0), (232.0, 232.0), 12.0, 8.0), m.casing);
    let section =
        |radius, chord| BladeSection { radius, chord, thickness: 0.16, camber: 0.02, stagger: 0.12, sweep: 0.0 };
    let shape = three(section(246.0, 100.0), section(360.0, 95.0), section(472.0, 100.0));
    let strut = a.mesh("rear frame strut", &blade(shape, 10, 4), m.vane);
    a.circle(frame, "strut", strut, 12, 0.0, shift(0.0, 0.0, 2195.0));
    let nozzle = [(2262.0, 481.0), (2350.0, 476.0), (2470.0, 448.0), (2600.0, 405.0), (2690.0, 378.0)];
    a.single(set, "core nozzle", &sheet(&nozzle, 6.0), m.exhaust);
    let plug = [
        (2262.0, 244.0),
        (2340.0, 246.0),
        (2450.0, 222.0),
        (2600.0, 160.0),
        (2750.0, 86.0),
        (2830.0, 40.0),
        (2850.0, 20.0),
    ];
    a.single(set, "exhaust cone", &sheet(&plug, 5.0), m.exhaust);
    let vent = [(2300.0, 60.0), (2500.0, 60.0), (2700.0, 40.0), (2845.0, 15.0)];
    a.single(set, "vent tube", &sheet(&vent, 4.0), m.lp_shaft);
}

/// Bolts and nuts of the casings' flange pairs. The bolt holes are not drawn: bolts of real casings fill theirs.
fn bolts(a: &mut Assembly, group: usize, m: &Materials) {
    let bolt = a.mesh("flange bolt", &hex_bolt(10.0, 1.5, 34.0, 11.0, BOLT), m.bolt);
    let nut = a.mesh("flange nut", &hex_nut(10.0, BOLT), m.bolt);
    for (name, z, radius, count) in [
        ("Fan frame bolts", 701.0, 365.0, 28),
        ("Diffuser bolts", 1201.0, 419.0, 36),
        ("Turbine bolts", 1591.0, 419.0, 36),
        ("Rear frame bolts", 2131.0, 487.0, 36),
    ] {
        let set = a.group(Some(group), name, shift(0.0, 0.0, z));
        // Heads look forward, nuts sit behind the second flange.
        a.circle(set, "bolt", bolt, count, 0.0, shift(radius, 0.0, -11.2) * upside_down());
        a.circle(set, "nut", nut, count, 0.0, shift(radius, 0.0, 11.2));
    }
}
