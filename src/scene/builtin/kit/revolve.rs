//! Profiles revolved around the z axis. A profile's x is the radius, its y the height z.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Path, Shell, Tolerance, Vertex, path::Knot};

/// Revolves `profile`. Each smooth face gets the number of chords that its largest radius needs; rings of different
/// numbers meet only in planar faces, where a change costs no accuracy.
pub fn revolve(profile: &Path, tolerance: Tolerance) -> Shell {
    let counts = ring_counts(profile, tolerance);
    let rings: Vec<Vec<f64>> = counts.iter().map(|&n| (0..n).map(|i| TAU * i as f64 / n as f64).collect()).collect();
    build(profile, &rings)
}

/// Revolves `profile` with the same `angles` (radians, ascending, within one turn) for all its rings, so that other
/// faces can join them.
pub fn revolve_with(profile: &Path, angles: &[f64]) -> Shell {
    build(profile, &vec![angles.to_vec(); profile.knots.len()])
}

fn is_planar(a: Knot, b: Knot) -> bool {
    (a.point.y - b.point.y).abs() < 1e-9
}

fn ring_counts(profile: &Path, tolerance: Tolerance) -> Vec<usize> {
    let knots = &profile.knots;
    let count = knots.len();
    let mut group: Vec<usize> = (0..count).collect();
    // Joined pieces share a number. Profiles are short, so plain relabelling will do.
    for (i, (a, b)) in profile.pieces().enumerate() {
        let (from, to) = (group[i], group[(i + 1) % count]);
        if !is_planar(a, b) && from != to {
            group.iter_mut().for_each(|g| {
                if *g == from {
                    *g = to;
                }
            });
        }
    }
    (0..count)
        .map(|i| {
            let radius = (0..count).filter(|&j| group[j] == group[i]).map(|j| knots[j].point.x).fold(0.0, f64::max);
            tolerance.circle(radius)
        })
        .collect()
}

fn build(profile: &Path, rings: &[Vec<f64>]) -> Shell {
    let mut shell = Shell::new();
    let count = rings.len();
    for (i, (a, b)) in profile.pieces().enumerate() {
        if b.open {
            continue;
        }
        let low = ring(a.point, a.normal_out, &rings[i]);
        let high = ring(b.point, b.normal_in, &rings[(i + 1) % count]);
        match (a.point.x < 1e-9, b.point.x < 1e-9) {
            (true, true) => {}
            (true, false) => fan(&mut shell, a, &high),
            (false, true) => fan(&mut shell, b, &low),
            (false, false) if low.len() == high.len() => shell.strip(&low, &high),
            (false, false) => zip(&mut shell, &low, &high),
        }
    }
    shell
}

/// The ring's vertices, with the first repeated at the end.
fn ring(point: DVec2, normal: DVec2, angles: &[f64]) -> Vec<Vertex> {
    angles
        .iter()
        .chain(angles.first())
        .map(|angle| {
            let (sin, cos) = angle.sin_cos();
            Vertex {
                position: DVec3::new(point.x * cos, point.x * sin, point.y),
                normal: DVec3::new(normal.x * cos, normal.x * sin, normal.y),
            }
        })
        .collect()
}

fn fan(shell: &mut Shell, apex: Knot, ring: &[Vertex]) {
    let position = DVec3::Z * apex.point.y;
    for pair in ring.windows(2) {
        // The apex takes the mean of its sector's normals: exact on a flat, and smooth on a dome.
        let flat = (pair[0].position.z - apex.point.y).abs() < 1e-9;
        let along = apex.normal_in.y + apex.normal_out.y;
        let dome = apex.normal_in.x.abs() < 1e-6 || apex.normal_out.x.abs() < 1e-6;
        let normal = if flat || !dome { pair[0].normal + pair[1].normal } else { DVec3::Z * along };
        shell.triangle(Vertex::new(position, normal), pair[0], pair[1]);
    }
}

/// Joins two coplanar rings of different numbers.
fn zip(shell: &mut Shell, low: &[Vertex], high: &[Vertex]) {
    let (n, m) = (low.len() - 1, high.len() - 1);
    let (mut i, mut j) = (0, 0);
    while i < n || j < m {
        // Advance where the next step's middle comes first.
        let (next_low, next_high) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / m as f64);
        if j >= m || (i < n && next_low <= next_high) {
            shell.triangle(low[i], low[i + 1], high[j]);
            i += 1;
        } else {
            shell.triangle(low[i], high[j], high[j + 1]);
            j += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{
        Step,
        shell::{faults, volume},
    };
    use super::*;

    #[test]
    fn a_ring_and_a_stepped_shaft_are_closed_and_have_their_volume() {
        let tolerance = Tolerance(0.005);
        let ring = Path::closed(
            &[Step::To(10.0, 0.0), Step::Cut(30.0, 0.0, 1.0), Step::Round(30.0, 8.0, 2.0), Step::To(10.0, 8.0)],
            tolerance,
        );
        let primitive = revolve(&ring, tolerance).primitive(0);
        assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
        let exact = std::f64::consts::PI * (900.0 - 100.0) * 8.0;
        let found = volume(&primitive);
        assert!(found < exact && found > exact * 0.98, "{found} of {exact}");

        let shaft = Path::open(
            &[
                Step::To(0.0, 0.0),
                Step::To(5.0, 0.0),
                Step::To(5.0, 10.0),
                Step::To(2.0, 10.0),
                Step::To(2.0, 20.0),
                Step::To(0.0, 20.0),
            ],
            tolerance,
        );
        let primitive = revolve(&shaft, tolerance).primitive(0);
        assert!(faults(&primitive).is_empty(), "{:?}", faults(&primitive));
        let exact = std::f64::consts::PI * (250.0 + 40.0);
        assert!((volume(&primitive) / exact - 1.0).abs() < 0.01);
    }
}
