//! Vertices that a modeller inserted into the edge of a facet, where another face meets it.
//!
//! Such a vertex lies on a straight line between two others, and exporters give it the facet's own normal, while the ends
//! have those of the curved surface. Across the short piece of the edge the normal then turns as far as over half a facet,
//! which shows as a stripe of high curvature (T31). The normal that belongs there is the one between the ends'.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Fans, chord};
use crate::scene::Primitive;

/// How far, in degrees, directions may differ that count as the same.
const SAME_DIRECTION: f64 = 0.5;
/// Inserted vertices in a row that are looked at on either side.
const LONGEST_ROW: usize = 64;

/// Gives inserted vertices the normal between the ends of their edge, and says whether any changed.
///
/// A vertex (welded where position *and* normal are bit-identical) counts as inserted if all its triangles lie in one plane,
/// its normal is that plane's, and it lies between its two neighbours on a straight edge of the smooth surface. On flat faces
/// nothing changes, because the ends have the same normal.
pub fn interpolated_normals(primitive: &mut Primitive) -> bool {
    primitive.normals.len() == primitive.positions.len() && {
        let fans = Fans::with_normals(primitive);
        interpolated(primitive, &fans)
    }
}

pub(super) fn interpolated(primitive: &mut Primitive, fans: &Fans) -> bool {
    let same = chord(SAME_DIRECTION);
    let vertex_of = |corner: u32| primitive.triangles[corner as usize / 3][corner as usize % 3] as usize;
    let stored: Vec<Option<DVec3>> = (0..fans.len())
        .into_par_iter()
        .map(|point| {
            let &corner = fans.corners_of(point).first()?;
            Vec3::from(primitive.normals[vertex_of(corner)]).as_dvec3().try_normalize()
        })
        .collect();
    let inserted: Vec<Option<[usize; 2]>> = (0..fans.len())
        .into_par_iter()
        .map(|point| {
            let corners = fans.corners_of(point);
            let plane = fans.normal(*corners.first()?);
            let normal = stored[point]?;
            let flat = corners.iter().all(|&c| fans.normal(c).distance(plane) <= same);
            if !flat || normal.distance(plane).min(normal.distance(-plane)) > same {
                return None;
            }
            let [a, b] = fans.ends_of_edge(corners)?;
            let [p, q, r] = [point, a, b].map(|i| fans.positions[i]);
            ((q - p).try_normalize()?.distance(-(r - p).try_normalize()?) <= same).then_some([a, b])
        })
        .collect();
    // Along the row of inserted vertices to the first that is not.
    let end = |from: usize, to: usize| {
        let (mut last, mut at) = (from, to);
        for _ in 0..LONGEST_ROW {
            match inserted[at] {
                Some([a, b]) => (last, at) = (at, if a == last { b } else { a }),
                None => return Some(at),
            }
        }
        None
    };
    let mut found = Vec::new();
    for (point, edge) in inserted.iter().enumerate() {
        let Some([a, b]) = *edge else { continue };
        let (Some(a), Some(b), Some(own)) = (end(point, a), end(point, b), stored[point]) else { continue };
        let (Some(normal_a), Some(normal_b)) = (stored[a], stored[b]) else { continue };
        let [to_a, to_b] = [a, b].map(|end| fans.positions[end].distance(fans.positions[point]));
        let between = normal_a.lerp(normal_b, to_a / (to_a + to_b)).try_normalize();
        if let Some(between) = between.filter(|n| n.distance(own) > chord(super::SAME_NORMAL)) {
            found.push((point, between.as_vec3().to_array()));
        }
    }
    let corners: Vec<&[u32]> = fans.iter().collect();
    for &(point, normal) in &found {
        for &corner in corners[point] {
            let vertex = primitive.triangles[corner as usize / 3][corner as usize % 3] as usize;
            primitive.normals[vertex] = normal;
        }
    }
    !found.is_empty()
}

impl Fans {
    /// The two points to which edges with a triangle on one side only lead from a point with these corners.
    fn ends_of_edge(&self, corners: &[u32]) -> Option<[usize; 2]> {
        let neighbour = |corner: u32, step: u32| self.points[(corner / 3 * 3 + (corner % 3 + step) % 3) as usize];
        // Inside a surface every neighbour comes twice, and two sums in which those cancel are 0: most vertices end here.
        let around = || corners.iter().flat_map(|&c| [neighbour(c, 1), neighbour(c, 2)]);
        let cancelled = |(x, y): (u32, u32), p: u32| (x ^ p, y ^ p.wrapping_mul(0x9e37_79b1).rotate_left(15));
        if around().fold((0, 0), cancelled) == (0, 0) {
            return None;
        }
        let all: Vec<u32> = around().collect();
        let mut single = all.iter().filter(|&p| all.iter().filter(|&q| q == p).count() == 1);
        let ends = [*single.next()? as usize, *single.next()? as usize];
        single.next().is_none().then_some(ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of facets of a cylinder of radius 1 around z, with exact normals at its corners, and vertices with the facet's
    /// normal inserted into the upper edge of the middle facet at these shares of its width.
    fn strip(shares: &[f64], height: f32) -> Primitive {
        let mut p = Primitive::default();
        let at = |i: usize| (0.3 * i as f64).sin_cos();
        for i in 0..4 {
            let (s, c) = at(i);
            for z in [0.0, height] {
                p.positions.push([c as f32, s as f32, z]);
                p.normals.push([c as f32, s as f32, 0.0]);
            }
        }
        for i in [0_u32, 4] {
            p.triangles.extend([[i, i + 2, i + 3], [i, i + 3, i + 1]]);
        }
        // The middle facet as a fan from its lower left corner.
        let (s, c) = (0.45_f64).sin_cos();
        let mut last = 5_u32;
        p.triangles.push([2, 4, 5]);
        for share in shares.iter().rev() {
            let ((s0, c0), (s1, c1)) = (at(1), at(2));
            let (x, y) = (c0 + share * (c1 - c0), s0 + share * (s1 - s0));
            p.positions.push([x as f32, y as f32, height]);
            p.normals.push([c as f32, s as f32, 0.0]);
            let new = p.positions.len() as u32 - 1;
            p.triangles.push([2, last, new]);
            last = new;
        }
        p.triangles.push([2, last, 3]);
        p
    }

    #[test]
    fn inserted_vertices_get_the_normal_between_the_ends() {
        let mut p = strip(&[0.1, 0.8], 0.5);
        let before = p.normals.clone();
        assert!(interpolated_normals(&mut p));
        assert_eq!(p.normals[..8], before[..8], "the ends stay, bit for bit");
        for (vertex, share) in [(9, 0.1), (8, 0.8)] {
            let [a, b] = [0.3, 0.6].map(|a: f64| DVec3::new(a.cos(), a.sin(), 0.0));
            let error =
                Vec3::from(p.normals[vertex]).as_dvec3().angle_between(a.lerp(b, share).normalize()).to_degrees();
            assert!(error < 1e-4, "{vertex}: {error}°");
        }
    }

    #[test]
    fn nothing_else_is_touched() {
        // No inserted vertices; one whose normal somebody chose; one that bends the edge.
        let mut chosen = strip(&[0.3], 0.5);
        chosen.normals[8] = [0.0, 0.0, 1.0];
        let mut bent = strip(&[0.3], 0.5);
        bent.positions[8][2] = 0.7;
        for mut p in [strip(&[], 0.5), chosen, bent] {
            let before = p.clone();
            assert!(!interpolated_normals(&mut p));
            assert_eq!(p, before);
        }
        // A flat face with a vertex in its edge.
        let mut flat = Primitive {
            positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 5],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]],
            ..Primitive::default()
        };
        assert!(!interpolated_normals(&mut flat));
    }
}
