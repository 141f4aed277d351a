//! Blade and vane rows: fan, booster, compressor, turbines.

use glam::DMat4;

use super::super::{
    assembly::{Assembly, shift},
    kit::{BladeSection, blade, three},
};
use super::{Materials, disc, tube};

/// A stage: rotor row and the vane row after (compressor) or before it (turbine).
struct Stage {
    name: &'static str,
    /// Middle of the rotor along z.
    z: f64,
    /// Radii of hub and tip.
    hub: f64,
    tip: f64,
    /// Chord of the rotor blades.
    chord: f64,
    /// Numbers of blades and of vanes.
    counts: (usize, usize),
    /// Radius of the disc's bore; none where a drum carries the blades.
    bore: Option<f64>,
}

/// Adds all rows.
pub fn add(a: &mut Assembly, root: usize, m: &Materials) {
    fan(a, root, m);
    let booster = a.group(Some(root), "Booster", DMat4::IDENTITY);
    for (i, (hub, tip)) in [(332.0, 464.0), (334.0, 455.0), (326.0, 438.0)].into_iter().enumerate() {
        let z = 290.0 + 105.0 * i as f64;
        let name = ["Booster stage 1", "Booster stage 2", "Booster stage 3"][i];
        stage(a, booster, m, &Stage { name, z, hub, tip, chord: 58.0, counts: (34, 36), bore: None }, true);
    }
    let compressor = a.group(Some(root), "High-pressure compressor", DMat4::IDENTITY);
    const NAMES: [&str; 6] = ["Stage 1", "Stage 2", "Stage 3", "Stage 4", "Stage 5", "Stage 6"];
    for (i, name) in NAMES.into_iter().enumerate() {
        let t = i as f64 / 5.0;
        let s = Stage {
            name,
            z: 740.0 + 430.0 * t - 20.0 * t * t,
            hub: 225.0 + 8.0 * t,
            tip: 328.0 - 52.0 * t,
            chord: 46.0 - 16.0 * t,
            counts: (32 + 2 * i, 34 + 2 * i),
            bore: Some(122.0),
        };
        stage(a, compressor, m, &s, true);
    }
    let high = a.group(Some(root), "High-pressure turbine", DMat4::IDENTITY);
    for (i, name) in ["High-pressure turbine 1", "High-pressure turbine 2"].into_iter().enumerate() {
        let t = i as f64;
        let s = Stage {
            name,
            z: 1650.0 + 90.0 * t,
            hub: 240.0,
            tip: 342.0 + 16.0 * t,
            chord: 40.0,
            counts: (40, 30),
            bore: Some(128.0),
        };
        stage(a, high, m, &s, false);
    }
    let low = a.group(Some(root), "Low-pressure turbine", DMat4::IDENTITY);
    const LOW: [&str; 4] =
        ["Low-pressure turbine 1", "Low-pressure turbine 2", "Low-pressure turbine 3", "Low-pressure turbine 4"];
    for (i, name) in LOW.into_iter().enumerate() {
        let t = i as f64;
        let s = Stage {
            name,
            z: 1830.0 + 84.0 * t,
            hub: 244.0,
            tip: 376.0 + 24.0 * t,
            chord: 38.0,
            counts: (36 + 2 * i, 34 + 2 * i),
            bore: Some(100.0 + 8.0 * t),
        };
        stage(a, low, m, &s, false);
    }
}

fn fan(a: &mut Assembly, root: usize, m: &Materials) {
    let set = a.group(Some(root), "Fan", DMat4::IDENTITY);
    let section = |radius, chord, thickness, camber, stagger, sweep| BladeSection {
        radius,
        chord,
        thickness,
        camber,
        stagger,
        sweep,
    };
    let shape = three(
        section(270.0, 190.0, 0.11, 0.11, 0.25, 0.0),
        section(560.0, 250.0, 0.05, 0.06, 0.75, -22.0),
        section(823.0, 285.0, 0.03, 0.02, 1.08, 18.0),
    );
    let blades = a.mesh("fan blade", &blade(shape, 16, 18), m.fan);
    a.circle(set, "fan blade", blades, 22, 0.0, shift(0.0, 0.0, 100.0));
    a.single(set, "fan disc", &disc(100.0, 152.0, 272.0, (120.0, 60.0, 196.0)), m.disc);
}

fn stage(a: &mut Assembly, parent: usize, m: &Materials, s: &Stage, compressor: bool) {
    let set = a.group(Some(parent), s.name, shift(0.0, 0.0, s.z));
    let (rotor, vane) = if compressor { (m.compressor, m.stator) } else { (m.turbine, m.vane) };
    let (thick, camber) = if compressor { (0.09, 0.06) } else { (0.17, 0.13) };
    let middle = 0.5 * (s.hub + s.tip);
    let section = |radius, chord: f64, camber, stagger| BladeSection {
        radius,
        chord,
        thickness: thick,
        camber,
        stagger,
        sweep: 0.0,
    };
    let shape = three(
        section(s.hub - 1.0, s.chord, camber, 0.4),
        section(middle, s.chord * 0.97, camber * 0.8, 0.62),
        section(s.tip - 2.0, s.chord * 0.94, camber * 0.6, 0.82),
    );
    let mesh = a.mesh(&format!("{} blade", s.name), &blade(shape, 8, 5), rotor);
    a.circle(set, "blade", mesh, s.counts.0, 0.0, DMat4::IDENTITY);
    let edge = 0.92 * s.chord;
    if let Some(bore) = s.bore {
        let shell = disc(0.0, bore, s.hub, (edge * 0.9, edge * 0.28, edge));
        a.single(set, "disc", &shell, m.disc);
    }
    // Vanes hang from the casing and carry a shroud ring at their inner end.
    let side = if compressor { 1.0 } else { -1.0 };
    let at = side * (if compressor { 1.06 } else { 1.05 }) * s.chord;
    let shroud = s.hub + 7.0;
    let shape = three(
        section(shroud, s.chord * 0.85, -camber, -0.3),
        section(middle, s.chord * 0.85, -camber, -0.35),
        section(s.tip + 1.0, s.chord * 0.9, -camber, -0.4),
    );
    let mesh = a.mesh(&format!("{} vane", s.name), &blade(shape, 8, 4), vane);
    a.circle(set, "vane", mesh, s.counts.1, 0.04, shift(0.0, 0.0, at));
    let half = 0.3 * s.chord;
    a.single(set, "vane shroud", &tube((at - half, at + half), shroud - 3.0, shroud + 1.0), vane);
}
