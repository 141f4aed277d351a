//! Helical screw threads: a closed surface that follows the helix, with flanks, crests and roots as faces of their own.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Shell, Vertex};

/// Where root, rising flank, crest and falling flank begin, as fractions of the pitch: about the ISO profile's.
const STARTS: [f64; 5] = [0.0, 0.25, 0.5625, 0.6875, 1.0];

/// Height of the profile (0 root to 1 crest) at the band boundaries.
const HEIGHTS: [f64; 5] = [0.0, 0.0, 1.0, 1.0, 0.0];

/// The side of a threaded shank from `z0` to `z1` between the radii `minor` and `major`: open at both ends, where it
/// meets circles of radius `minor` with `chords` points. The thread fades in and out over three quarters of a turn.
pub fn thread(shell: &mut Shell, minor: f64, major: f64, pitch: f64, z0: f64, z1: f64, chords: usize) {
    // Plain collars below and above leave room for the ends of the helix.
    let collar = 0.15 * pitch;
    let turns = (((z1 - z0 - 2.0 * collar) / pitch).floor() - 1.0).max(1.0) as usize;
    let base = z0 + collar;
    let total = turns as f64;
    let fade = |turn: f64| {
        let ramp = |x: f64| {
            let x = (x / 0.75).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        };
        ramp(turn) * ramp(total - turn)
    };
    // The surface at chord `a` of its turn, `band` + `w` of the profile, `turn` whole turns up.
    let point = |angle: f64, turn: usize, band: usize, w: f64| {
        let around = angle / TAU;
        let profile = STARTS[band] + (STARTS[band + 1] - STARTS[band]) * w;
        let height = HEIGHTS[band] + (HEIGHTS[band + 1] - HEIGHTS[band]) * w;
        // The fade follows the helix, so that it is constant along a profile and the last row lies at `minor`.
        let radius = minor + (major - minor) * height * fade(turn as f64 + around);
        let (sin, cos) = angle.sin_cos();
        DVec3::new(radius * cos, radius * sin, base + pitch * (turn as f64 + profile + around))
    };
    let vertex = |a: usize, turn: usize, band: usize, w: f64| {
        let angle = TAU * a as f64 / chords as f64;
        let step = 1e-5;
        let along = point(angle + step, turn, band, w) - point(angle - step, turn, band, w);
        let across = point(angle, turn, band, w + step) - point(angle, turn, band, w - step);
        // The seam's points are computed as chord 0 of the next turn, so that they are the same numbers.
        let (a, turn) = if a == chords { (0, turn + 1) } else { (a, turn) };
        Vertex::new(point(TAU * a as f64 / chords as f64, turn, band, w), along.cross(across))
    };
    for turn in 0..turns {
        for band in 0..4 {
            for a in 0..chords {
                shell.quad(
                    vertex(a, turn, band, 0.0),
                    vertex(a + 1, turn, band, 0.0),
                    vertex(a + 1, turn, band, 1.0),
                    vertex(a, turn, band, 1.0),
                );
            }
        }
    }
    let on = |a: usize, z: f64| {
        let angle = TAU * (a % chords) as f64 / chords as f64;
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        Vertex { position: normal * minor + DVec3::Z * z, normal }
    };
    for (turn, flat, rising) in [(0, z0, true), (turns, z1, false)] {
        let helix = |a: usize| base + pitch * (turn as f64 + a as f64 / chords as f64);
        // At the seam the helix has risen by one pitch. The step there is joined to the sector that is next to it:
        // the last one below the thread, the first one above it.
        for a in 0..chords {
            let last = a + 1 == chords;
            if rising && last {
                shell.triangle(on(a, flat), on(a + 1, flat), on(0, helix(0)));
                shell.triangle(on(a, flat), on(0, helix(0)), on(a, helix(a)));
                for k in 0..4 {
                    let level = |k: usize| helix(0) + pitch * STARTS[k];
                    shell.triangle(on(a, helix(a)), on(0, level(k)), on(0, level(k + 1)));
                }
            } else if !rising && a == 0 {
                shell.triangle(on(0, flat), on(1, flat), on(1, helix(1)));
                // Above the thread the seam runs from the end of the last turn down to its begin.
                shell.triangle(on(0, flat), on(1, helix(1)), on(0, helix(chords)));
                for k in 0..4 {
                    let level = |k: usize| helix(0) + pitch * STARTS[k];
                    shell.triangle(on(1, helix(1)), on(0, level(k)), on(0, level(k + 1)));
                }
            } else {
                shell.quad(on(a, helix(a)), on(a + 1, helix(a + 1)), on(a + 1, flat), on(a, flat));
            }
        }
    }
}
