//! Tubes with rows of round holes: combustor liners with dilution holes, bearing cages with pockets.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3};

use super::{Shell, Vertex};

/// What a perforated tube looks like. It stands around the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perforation {
    /// Inner radius.
    pub inner: f64,
    /// Outer radius.
    pub outer: f64,
    /// Lower end.
    pub z0: f64,
    /// Upper end.
    pub z1: f64,
    /// Rows of holes along z.
    pub rows: usize,
    /// Holes in a row.
    pub holes: usize,
    /// Radius of a hole, measured on the middle of the wall.
    pub hole_radius: f64,
    /// Chords of an eighth of a hole and of half a cell's side.
    pub divisions: usize,
    /// Turns a row against the one before by this fraction of a cell.
    pub shift: f64,
}

/// A tube with holes, closed and watertight. Each hole lies in a rectangular cell of the unrolled wall; the hole's
/// points and the cell's border are joined by quadrilaterals.
///
/// Rows that are shifted against each other meet at bands of their own, with the number of chords that both have.
pub fn perforated_tube(p: &Perforation) -> Shell {
    let mut shell = Shell::new();
    let middle = 0.5 * (p.inner + p.outer);
    let cell = DVec2::new(TAU / p.holes as f64, (p.z1 - p.z0) / p.rows as f64);
    let per_side = 2 * p.divisions;
    // (angle, z) to a vertex on one of the two walls.
    let on = |q: DVec2, outer: bool| {
        let radial = DVec3::new(q.x.cos(), q.x.sin(), 0.0);
        let (radius, normal) = if outer { (p.outer, radial) } else { (p.inner, -radial) };
        Vertex { position: radial * radius + DVec3::Z * q.y, normal }
    };
    // A cell's border and hole, `8 · divisions` points each, from the corner at +45°.
    let count = 8 * p.divisions;
    let around = |k: usize| {
        let side = k / per_side % 4;
        let along = (k % per_side) as f64 / per_side as f64;
        let edge = 1.0 - 2.0 * along;
        let border = match side {
            0 => DVec2::new(edge, 1.0),
            1 => DVec2::new(-1.0, edge),
            2 => DVec2::new(-edge, -1.0),
            _ => DVec2::new(1.0, -edge),
        };
        let angle = FRAC_PI_4 + TAU * k as f64 / count as f64;
        (border * 0.5, DVec2::from_angle(angle))
    };
    for row in 0..p.rows {
        for hole in 0..p.holes {
            // Whole divisions, so that the borders of shifted rows share their points.
            let shift = (p.shift * per_side as f64 * row as f64).round() / per_side as f64;
            let center = DVec2::new(cell.x * (hole as f64 + shift), p.z0 + cell.y * (row as f64 + 0.5));
            let points: Vec<(DVec2, DVec2, DVec2)> = (0..=count)
                .map(|k| {
                    let (border, direction) = around(k % count);
                    let rim = direction * p.hole_radius / DVec2::new(middle, 1.0);
                    let mut at = center + border * cell;
                    // Exact on the shared lines, so that the grid cannot part them.
                    at.y = if border.y == 0.5 {
                        p.z0 + cell.y * (row as f64 + 1.0)
                    } else if border.y == -0.5 {
                        p.z0 + cell.y * row as f64
                    } else {
                        at.y
                    };
                    (at, center + rim, direction)
                })
                .collect();
            for pair in points.windows(2) {
                let [(a, ra, na), (b, rb, nb)] = [pair[0], pair[1]];
                // Two rings of quadrilaterals keep those beside the hole narrow.
                let (ma, mb) = (ra.lerp(a, 0.4), rb.lerp(b, 0.4));
                for outer in [false, true] {
                    shell.quad(on(a, outer), on(b, outer), on(mb, outer), on(ma, outer));
                    shell.quad(on(ma, outer), on(mb, outer), on(rb, outer), on(ra, outer));
                }
                let inward = |r: DVec2, n: DVec2, outer: bool| {
                    let v = on(r, outer);
                    let (sin, cos) = r.x.sin_cos();
                    Vertex::new(v.position, -(DVec3::new(-sin, cos, 0.0) * n.x + DVec3::Z * n.y))
                };
                shell.quad(inward(ra, na, false), inward(rb, nb, false), inward(rb, nb, true), inward(ra, na, true));
                for (z, normal, first) in [(p.z0, DVec3::NEG_Z, row == 0), (p.z1, DVec3::Z, row + 1 == p.rows)] {
                    if first && a.y == z && b.y == z {
                        let end = |q: DVec2, outer: bool| Vertex { normal, ..on(q, outer) };
                        shell.quad(end(a, false), end(b, false), end(b, true), end(a, true));
                    }
                }
            }
        }
    }
    shell
}

#[cfg(test)]
mod tests {
    use super::super::shell::{faults, volume};
    use super::*;

    #[test]
    fn a_liner_is_closed_and_has_its_volume() {
        let liner = Perforation {
            inner: 100.0,
            outer: 102.0,
            z0: 0.0,
            z1: 90.0,
            rows: 3,
            holes: 20,
            hole_radius: 6.0,
            divisions: 2,
            shift: 0.5,
        };
        let primitive = perforated_tube(&liner).primitive(0);
        assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
        let pi = std::f64::consts::PI;
        let expected = pi * (102.0_f64.powi(2) - 1e4) * 90.0 - 60.0 * pi * 36.0 * 2.0;
        assert!((volume(&primitive) / expected - 1.0).abs() < 0.03, "{} of {expected}", volume(&primitive));
    }
}
