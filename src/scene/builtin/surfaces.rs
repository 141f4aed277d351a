//! Analytic surfaces with known curvature, and cylinders of unequal facets (trap T31).
//!
//! Normals are exact at the vertices. Curvatures are positive where the surface is convex seen from outside, the mean
//! curvature is H = (κ₁ + κ₂) / 2:
//!
//! | surface | normal | κ₁ | κ₂ |
//! |---|---|---|---|
//! | sphere of radius r | p / r | 1/r | 1/r |
//! | cylinder of radius r about z | (x, y, 0) / r | 1/r | 0 |
//! | torus, tube t around radius R about z | from the tube's center circle | 1/t | cos v / (R + t cos v) |
//! | saddle z = (x² − y²) / (2r) | (−x/r, y/r, 1) / w | at the origin −1/r | at the origin 1/r |
//!
//! where v is the angle around the tube, 0 on the outer equator, and w² = 1 + (x² + y²) / r². The saddle's mean curvature
//! is H = (x² − y²) / (2 r³ w³) with the normal towards +z (negated for "convex positive"), its Gaussian curvature
//! −1 / (r² w⁴).

use std::f64::consts::TAU;

use glam::{DMat4, DVec2, DVec3};

use super::{
    BuiltinError,
    assembly::Assembly,
    kit::{Path, Shell, Tolerance, Vertex, ball_divided, face, revolve_with},
    parameters::{Parameters, Random},
};
use crate::scene::{Primitive, Scene};

const RADIUS: (&str, f64, f64, f64) = ("radius", 1.0, 0.01, 1000.0);

fn angles(count: usize) -> Vec<f64> {
    (0..count).map(|i| TAU * i as f64 / count as f64).collect()
}

fn one(name: &str, shell: &Shell) -> Scene {
    one_of(name, shell.primitive(0))
}

fn one_of(name: &str, primitive: Primitive) -> Scene {
    let mut assembly = Assembly::new(name);
    let root = assembly.group(None, name, DMat4::IDENTITY);
    assembly.material("grey", 0xB4BCC4, 0.0, 0.5);
    let mesh = assembly.mesh_of(name, primitive);
    assembly.part(root, name, mesh, DMat4::IDENTITY);
    assembly.into_scene()
}

pub(super) fn sphere(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [radius, segments] = p.take([RADIUS, ("segments", 48.0, 8.0, 1024.0)])?;
    // An icosahedron's edge spans a little more than a sixth of a great circle.
    Ok(one("sphere", &ball_divided(radius, (segments / 5.0).ceil() as usize)))
}

pub(super) fn cylinder(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [radius, height, segments] =
        p.take([RADIUS, ("height", 3.0, 0.01, 1000.0), ("segments", 64.0, 3.0, 4096.0)])?;
    Ok(one("cylinder", &tube(radius, height, &angles(segments as usize))))
}

/// A capped cylinder with the given ring angles.
fn tube(radius: f64, height: f64, angles: &[f64]) -> Shell {
    use super::kit::Step;
    let h = height / 2.0;
    let profile = Path::open(&[Step::To(radius, -h), Step::To(radius, h)], Tolerance(0.01));
    let mut shell = revolve_with(&profile, angles);
    let ring: Vec<DVec2> = angles.iter().map(|&a| DVec2::from_angle(a) * radius).collect();
    face(&mut shell, -h, std::slice::from_ref(&ring), false);
    face(&mut shell, h, &[ring], true);
    shell
}

pub(super) fn torus(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [radius, tube, segments] = p.take([RADIUS, ("tube", 0.4, 0.001, 1000.0), ("segments", 96.0, 8.0, 2048.0)])?;
    let around = ((segments * tube / radius).ceil() as usize).clamp(12, 2048);
    let profile = Path::circle(DVec2::new(radius.max(tube), 0.0), tube, around);
    Ok(one("torus", &revolve_with(&profile, &angles(segments as usize))))
}

pub(super) fn saddle(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [radius, segments] = p.take([RADIUS, ("segments", 48.0, 2.0, 1024.0)])?;
    let n = segments as usize;
    let vertex = |i: usize, j: usize| {
        let at = |k: usize| (2.0 * k as f64 / n as f64 - 1.0) * radius;
        let (x, y) = (at(i), at(j));
        let position = DVec3::new(x, y, (x * x - y * y) / (2.0 * radius));
        Vertex::new(position, DVec3::new(-x / radius, y / radius, 1.0))
    };
    let mut shell = Shell::new();
    for j in 0..n {
        let row = |j| (0..=n).map(|i| vertex(i, j)).collect::<Vec<_>>();
        shell.strip(&row(j), &row(j + 1));
    }
    Ok(one("saddle", &shell))
}

/// Ring angles whose steps differ by up to a factor of three.
fn unequal(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    let steps: Vec<f64> = (0..count).map(|_| 0.5 + random.unit()).collect();
    let total: f64 = steps.iter().sum();
    let reached = |i: usize| steps[..i].iter().sum::<f64>();
    (0..count).map(|i| TAU * reached(i) / total).collect()
}

/// A capped cylinder of unequal facets. Vertex normals are the **unweighted** mean of the two facets' normals, as many
/// exporters write them: they lie midway between facets however wide, so they are off the radius, and their slope jumps.
/// `flat` gives every facet its own normal instead.
pub(super) fn facets(p: &mut Parameters, flat: bool) -> Result<Scene, BuiltinError> {
    let [count, radius, height, seed] = p.take([
        ("facets", 48.0, 3.0, 4096.0),
        RADIUS,
        ("height", 3.0, 0.01, 1000.0),
        ("seed", 1.0, 0.0, 4_294_967_295.0),
    ])?;
    let angles = unequal(count as usize, seed as u64);
    let n = angles.len();
    let h = height / 2.0;
    let middle = |i: usize| {
        let next = if i + 1 < n { angles[i + 1] } else { TAU };
        DVec2::from_angle(0.5 * (angles[i] + next))
    };
    let mut shell = Shell::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let normals = if flat { [middle(i); 2] } else { [middle((i + n - 1) % n) + middle(i), middle(i) + middle(j)] };
        let [a, b] = [i, j].map(|k| DVec2::from_angle(angles[k]) * radius);
        let [na, nb] = normals.map(|m| m.extend(0.0));
        shell.quad(
            Vertex::new(a.extend(-h), na),
            Vertex::new(b.extend(-h), nb),
            Vertex::new(b.extend(h), nb),
            Vertex::new(a.extend(h), na),
        );
    }
    let ring: Vec<DVec2> = angles.iter().map(|&a| DVec2::from_angle(a) * radius).collect();
    face(&mut shell, -h, std::slice::from_ref(&ring), false);
    face(&mut shell, h, &[ring], true);
    Ok(one(if flat { "flat-cylinder" } else { "unequal-cylinder" }, &shell))
}

#[cfg(test)]
mod tests {
    use super::super::{build, kit::shell::faults};
    use super::*;

    /// Largest error of κ along edges against `expected(position, direction)`, by normals over positions.
    fn curvature_error(name: &str, on: impl Fn(DVec3) -> bool, expected: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let scene = build(name).unwrap();
        let p = &scene.meshes[0].primitives[0];
        let mut worst = 0.0_f64;
        let mut seen = 0;
        for t in &p.triangles {
            for (i, j) in [(t[0], t[1]), (t[1], t[2])] {
                let at = |v: &[[f32; 3]], k: u32| glam::Vec3::from(v[k as usize]).as_dvec3();
                let (dp, dn) = (at(&p.positions, j) - at(&p.positions, i), at(&p.normals, j) - at(&p.normals, i));
                let middle = 0.5 * (at(&p.positions, i) + at(&p.positions, j));
                if on(at(&p.normals, i)) && on(at(&p.normals, j)) {
                    seen += 1;
                    worst = worst.max((dn.dot(dp) / dp.length_squared() - expected(middle, dp.normalize())).abs());
                }
            }
        }
        assert!(seen > 50);
        worst
    }

    #[test]
    fn curvatures_are_the_documented_ones() {
        assert!(curvature_error("sphere?radius=2", |_| true, |_, _| 0.5) < 2e-3);
        let side = |n: DVec3| n.z.abs() < 0.5;
        let across = |_: DVec3, d: DVec3| (1.0 - d.z * d.z) / 2.0;
        assert!(curvature_error("cylinder?radius=2", side, across) < 2e-3);
        let saddle = |p: DVec3, d: DVec3| {
            let w = (1.0 + p.x * p.x + p.y * p.y).sqrt();
            -(d.x * d.x - d.y * d.y) / w
        };
        assert!(curvature_error("saddle?segments=96", |_| true, saddle) < 0.02);
        let torus = |p: DVec3, d: DVec3| {
            let out = DVec3::new(p.x, p.y, 0.0).normalize();
            let cos = ((p - out).dot(out) / (p - out).length()).clamp(-1.0, 1.0);
            let along = d.dot(DVec3::Z.cross(out)).powi(2);
            along * cos / (1.0 + 0.4 * cos) + (1.0 - along) / 0.4
        };
        assert!(curvature_error("torus?segments=400", |_| true, torus) < 0.05);
    }

    #[test]
    fn closed_ones_are_closed() {
        for name in ["sphere", "cylinder", "torus", "unequal-cylinder?facets=24", "flat-cylinder?facets=96"] {
            let scene = build(name).unwrap();
            assert_eq!(faults(&scene.meshes[0].primitives[0]), Vec::<String>::new(), "{name}");
        }
    }

    #[test]
    fn unequal_facets_are_unequal_and_their_normals_off_the_radius() {
        let steps = unequal(48, 1).windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>();
        let (low, high) = steps.iter().fold((f64::MAX, 0.0_f64), |(l, h), &s| (l.min(s), h.max(s)));
        assert!(high / low > 2.0);
        let scene = build("unequal-cylinder").unwrap();
        let p = &scene.meshes[0].primitives[0];
        let off = p.positions.iter().zip(&p.normals).filter(|(_, n)| n[2] == 0.0).map(|(p, n)| {
            let radial = DVec2::new(f64::from(p[0]), f64::from(p[1])).normalize();
            radial.dot(DVec2::new(f64::from(n[0]), f64::from(n[1]))).clamp(-1.0, 1.0).acos()
        });
        assert!(off.fold(0.0, f64::max) > 0.01);
    }
}
