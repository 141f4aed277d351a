//! Scenes about normals and curvature.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::super::parameters::{Parameters, Random};
use super::super::{BuiltinError, samples};
use super::parts;
use crate::scene::{Primitive, Scene};

pub(super) fn ball(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [radius, columns] = p.take([("radius", 1.0, 1e-6, 1e6), ("columns", 160.0, 8.0, 2048.0)])?;
    Ok(parts(vec![samples::sphere(radius, columns as u32, columns as u32 / 2)]))
}

/// Squares that face the viewer, each with one normal anywhere on the viewer's side: interpolation adds no error.
pub(super) fn normals(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let mut random = Random::new(90);
    let mut all = Primitive::default();
    for i in 0..1600 {
        let (x, y) = (f64::from(i % 40), f64::from(i / 40));
        let mut normal = random.direction();
        // Half of them at grazing angles.
        normal.z = normal.z.abs() * if i % 2 == 0 { 1.0 } else { 0.02 } + 0.002;
        let normal = normal.normalize();
        let square = samples::grid(1, 1, |u, v| (DVec3::new(x + 0.9 * u, y + 0.9 * v, 0.0), normal));
        samples::append(&mut all, &square);
    }
    Ok(parts(vec![all]))
}

/// Every triangle with vertices of its own, so that each can be turned.
pub fn loose_saddle(turned: impl Fn(usize) -> (bool, bool)) -> Primitive {
    let source = samples::saddle(0.8, 1.0, 20);
    let mut p = Primitive::default();
    for (i, t) in source.triangles.iter().enumerate() {
        let (wound, flipped) = turned(i);
        let first = p.positions.len() as u32;
        for &v in t {
            p.positions.push(source.positions[v as usize]);
            let n = Vec3::from(source.normals[v as usize]);
            p.normals.push((if flipped { -n } else { n }).to_array());
        }
        p.triangles.push(if wound { [first, first + 2, first + 1] } else { [first, first + 1, first + 2] });
    }
    p
}

pub(super) fn saddle(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [turned] = p.take([("turned", 0.0, 0.0, 1.0)])?;
    let at_random = |i: usize| {
        let mut random = Random::new(i as u64);
        (random.unit() < 0.5, random.unit() < 0.5)
    };
    Ok(parts(vec![loose_saddle(|i| if turned > 0.0 { at_random(i) } else { (false, false) })]))
}

/// Angles of facets that are up to three times as wide as others.
pub fn unequal(facets: u32) -> Vec<f64> {
    let mut random = Random::new(u64::from(facets));
    let widths: Vec<f64> = (0..facets).map(|_| random.between(0.5, 1.5)).collect();
    let sum: f64 = widths.iter().sum();
    let mut at = 0.0;
    let mut angles = vec![0.0];
    angles.extend(widths.iter().map(|w| {
        at += w / sum * TAU;
        at
    }));
    angles
}

/// Normals of the neighbouring faces averaged without regard to their width, as exporters do: T31's bands.
pub fn banded_cylinder(angles: &[f64]) -> Primitive {
    let facets = angles.len() - 1;
    let middle = |i: usize| 0.5 * (angles[i] + angles[i + 1]);
    let mut p = samples::cylinder_at(1.0, 1.5, angles);
    for (i, normal) in p.normals.iter_mut().enumerate() {
        let column = i % (facets + 1) % facets;
        let (a, b) = (middle((column + facets - 1) % facets), middle(column));
        let n = DVec3::new(a.sin() + b.sin(), 0.0, a.cos() + b.cos()).normalize();
        *normal = n.as_vec3().to_array();
    }
    p
}

pub(super) fn facets(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [count] = p.take([("facets", 24.0, 3.0, 4096.0)])?;
    Ok(parts(vec![banded_cylinder(&unequal(count as u32))]))
}

/// A cylinder as an STL brings it: every facet flat, no vertex shared.
pub(super) fn flat_facets(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    let [count] = p.take([("facets", 48.0, 3.0, 4096.0)])?;
    let angles = unequal(count as u32);
    let mut all = Primitive::default();
    for edges in angles.windows(2) {
        let middle = 0.5 * (edges[0] + edges[1]);
        let mut facet = samples::cylinder_at(1.0, 1.5, edges);
        let normal = DVec3::new(middle.sin(), 0.0, middle.cos()).as_vec3().to_array();
        facet.normals.fill(normal);
        samples::append(&mut all, &facet);
    }
    Ok(parts(vec![all]))
}

/// A sphere, a normal in seven of which is zero or not a number, and triangles that have no surface: without area, with
/// corners that are not numbers, with corners at infinity.
pub(super) fn broken(p: &mut Parameters) -> Result<Scene, BuiltinError> {
    p.none()?;
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let mut all = samples::sphere(1.0, 48, 24);
    for (i, normal) in all.normals.iter_mut().enumerate().filter(|(i, _)| i % 7 == 3) {
        *normal = if i % 2 == 0 { [0.0; 3] } else { [nan, 0.0, 1.0] };
    }
    let first = all.positions.len() as u32;
    all.positions.extend([
        [nan; 3],
        [inf, 0.0, 0.0],
        [0.0, -inf, nan],
        [0.1, 0.2, 0.3],
        [0.2, 0.2, 0.3],
        [0.3, 0.2, 0.3],
    ]);
    all.normals.extend([[nan; 3], [0.0; 3], [inf, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]);
    let corners = 0..6_u32;
    for (i, j) in corners.clone().flat_map(|i| corners.clone().map(move |j| (i, j))) {
        // The last three corners lie on a line: no three of the six have a surface.
        all.triangles.extend(corners.clone().map(|k| [first + i, first + j, first + k]));
    }
    Ok(parts(vec![all]))
}
