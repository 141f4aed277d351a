//! Blades: airfoil sections lofted along a radius.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Shell, Vertex, planar::triangulate};

/// An airfoil section of a blade at one radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeSection {
    /// Distance from the engine's axis.
    pub radius: f64,
    /// Chord length.
    pub chord: f64,
    /// Largest thickness as a fraction of the chord.
    pub thickness: f64,
    /// Camber (height of the mean line) as a fraction of the chord; its sign chooses the side.
    pub camber: f64,
    /// Angle between the chord and the z axis, radians.
    pub stagger: f64,
    /// How far the section is moved along z (sweep).
    pub sweep: f64,
}

impl BladeSection {
    fn mix(a: BladeSection, b: BladeSection, t: f64) -> BladeSection {
        let m = |x: f64, y: f64| x + (y - x) * t;
        BladeSection {
            radius: m(a.radius, b.radius),
            chord: m(a.chord, b.chord),
            thickness: m(a.thickness, b.thickness),
            camber: m(a.camber, b.camber),
            stagger: m(a.stagger, b.stagger),
            sweep: m(a.sweep, b.sweep),
        }
    }
}

/// A closed blade that stands along +x at `section(0)` to `section(1)`, with its chord turned from +z towards +y.
///
/// `around` chords on each side of the airfoil, `along` rows from root to tip. Both edges are round-nosed by the
/// thickness law's root at each end; normals are the surface's, by central differences of its formula.
pub fn blade(section: impl Fn(f64) -> BladeSection, around: usize, along: usize) -> Shell {
    let loop_count = 2 * around;
    let point = |u: f64, t: f64| -> DVec3 {
        // u runs once around the airfoil, from the trailing edge over one side to the leading edge and back.
        let s = section(t);
        let x = 0.5 * (1.0 + (2.0 * PI * u).cos());
        let side = (2.0 * PI * u).sin();
        // Thickest at 0.35 to 0.4 of the chord; an ellipse nose, a thin tail with a small round end.
        let half = 0.5 * s.thickness * side * (0.62 + 0.75 * (1.0 - x) * (1.0 - 0.15 * (1.0 - x)));
        let mean = 4.0 * s.camber * x * (1.0 - x);
        let in_section = DVec2::new((x - 0.45) * s.chord, (mean + half) * s.chord);
        let turned = DVec2::from_angle(s.stagger).rotate(in_section);
        DVec3::new(s.radius, turned.y, turned.x + s.sweep)
    };
    let vertex = |i: usize, j: usize| {
        // Rows crowd where the airfoil bends most: at its nose and its tail.
        let even = (i % loop_count) as f64 / loop_count as f64;
        let u = even - 0.8 * (4.0 * PI * even).sin() / (4.0 * PI);
        let t = j as f64 / along as f64;
        let step = 1e-5;
        let du = point(u + step, t) - point(u - step, t);
        let dt = point(u, t + step) - point(u, t - step);
        Vertex::new(point(u, t), dt.cross(du))
    };
    let mut shell = Shell::new();
    // Which way the cross product looks is the same everywhere: test it once, at the thickest place of one side.
    let probe = vertex(around / 2, 0);
    let outward = (probe.position - vertex(loop_count - around / 2, 0).position).dot(probe.normal) > 0.0;
    let at = |i: usize, j: usize| {
        let v = vertex(i, j);
        if outward { v } else { Vertex { normal: -v.normal, ..v } }
    };
    for j in 0..along {
        let row = |j| (0..=loop_count).map(|i| at(i, j)).collect::<Vec<_>>();
        shell.strip(&row(j), &row(j + 1));
    }
    for (j, normal) in [(0, DVec3::NEG_X), (along, DVec3::X)] {
        let ring: Vec<DVec3> = (0..loop_count).map(|i| at(i, j).position).collect();
        let flat: Vec<DVec2> = ring.iter().map(|p| DVec2::new(p.z, p.y)).collect();
        for triangle in triangulate(&[flat]) {
            let [a, b, c] = triangle.map(|i| Vertex { position: ring[i], normal });
            shell.triangle(a, b, c);
        }
    }
    shell
}

/// Mixes three sections linearly: root, middle, tip.
pub fn three(root: BladeSection, middle: BladeSection, tip: BladeSection) -> impl Fn(f64) -> BladeSection {
    // A quadratic through all three keeps the surface smooth along its span.
    move |t| {
        let (a, b) = (BladeSection::mix(root, middle, 2.0 * t), BladeSection::mix(middle, tip, 2.0 * t - 1.0));
        BladeSection::mix(a, b, t)
    }
}

#[cfg(test)]
mod tests {
    use super::super::shell::{faults, volume};
    use super::*;

    #[test]
    fn a_twisted_blade_is_closed() {
        let section =
            |radius, chord, stagger| BladeSection { radius, chord, thickness: 0.08, camber: 0.06, stagger, sweep: 0.0 };
        for sign in [1.0, -1.0] {
            let shape = three(
                section(300.0, 180.0, 0.2 * sign),
                section(500.0, 220.0, 0.6 * sign),
                section(800.0, 260.0, 1.1 * sign),
            );
            let primitive = blade(shape, 12, 10).primitive(0);
            assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
            assert!(volume(&primitive) > 0.0);
        }
    }
}
