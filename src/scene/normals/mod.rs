//! Vertex normals: computing them where a file has none, and re-weighting those that a modeller averaged badly.
//!
//! Curvature is the derivative of the normal, so the weights of an average show in the picture (T31): the usual ones
//! (equal, by area, by angle) tilt the normals of a cylinder whose facets are of unequal width, and every facet gets a
//! curvature of its own. N. Max, "Weights for Computing Vertex Normals from Facet Normals" (1999), weights a facet by
//! sin(angle) / (|e₁| |e₂|); with it the sum of n·weight over a fan is the vector area of the fan's neighbours inverted
//! in the vertex, which is exact where they lie on a sphere, and on a cylinder however its facets are cut.
//!
//! All sums are in `f64`; angles are in degrees.

mod inserted;

use inserted::interpolated;
pub use inserted::interpolated_normals;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Primitive;
use super::weld::{Welded, bits, weld, weld_positions};

/// How far, in degrees, a file's normal may be from an average to count as that average.
const AVERAGE_TOLERANCE: f64 = 0.5;
/// The share of the vertices that must agree with an average before the file is taken to have used it.
const AGREEING_SHARE: f64 = 0.9;
/// Below this, in degrees, a re-weighted normal is the file's own: nothing is gained by touching it.
const SAME_NORMAL: f64 = 0.01;
/// Two facets of one polygon, triangulated: the cosine between their normals is above this.
const SAME_PLANE: f64 = 1.0 - 1e-9;
/// Above this many facets at a vertex coplanar ones are not looked for (the search is quadratic).
const PLANE_SEARCH: usize = 64;
/// So many points of a large mesh are asked whether its normals are averages at all.
const SAMPLE: usize = 8192;
/// So many vertices are told apart at one point.
const MOST_GROUPS: usize = 256;
/// Points that one thread takes at a time.
const POINTS_AT_ONCE: usize = 4096;

/// Computes the normals of a primitive from its triangles and replaces what it had.
///
/// Vertices with bit-identical positions are one point. The triangles around a point that are joined by shared edges
/// across which the normal turns by at most `crease_angle` **degrees** form a group and share a normal, Max-weighted;
/// a vertex that belongs to several groups is split, with copies of its other attributes appended to the arrays. Order
/// and number of the triangles stay. Vertices without a triangle of non-zero area get +z. Tangents are dropped if a
/// vertex was split or had other normals, since they belong to the old ones. Triangles that name a missing vertex are
/// ignored.
pub fn compute_normals(primitive: &mut Primitive, crease_angle: f64) {
    let fans = Fans::new(primitive, weld_positions(&primitive.positions));
    let cos_crease = crease_angle.clamp(0.0, 180.0).to_radians().cos() - 1e-12;
    primitive.tangents.clear();
    primitive.normals.clear();
    primitive.normals.resize(primitive.positions.len(), [0.0, 0.0, 1.0]);

    // The group of every corner, by number inside its point, and its normal: each point by itself, so in parallel.
    let mut groups = vec![(0_u32, [0.0_f32; 3]); fans.corners.len()];
    fans.each_point(&mut groups, |corners, groups, scratch| scratch.group(&fans, corners, cos_crease, groups));
    let mut used = vec![false; primitive.positions.len()];
    // Which vertex of the result stands for (vertex of the file, group at its point).
    let mut made: Vec<(u32, u32, u32)> = Vec::new();
    let mut groups = groups.iter();
    for corners in fans.iter() {
        made.clear();
        for (&corner, &(group, normal)) in corners.iter().zip(&mut groups) {
            let (triangle, place) = (corner as usize / 3, corner as usize % 3);
            let vertex = primitive.triangles[triangle][place];
            let index = match made.iter().find(|m| (m.0, m.1) == (vertex, group)) {
                Some(known) => known.2,
                None => {
                    let index = if std::mem::replace(&mut used[vertex as usize], true) {
                        primitive.normals.push(normal);
                        duplicate(primitive, vertex as usize)
                    } else {
                        primitive.normals[vertex as usize] = normal;
                        vertex
                    };
                    // A point where thousands of groups meet would be searched for ever; there, vertices are not shared.
                    if made.len() < MOST_GROUPS {
                        made.push((vertex, group, index));
                    }
                    index
                }
            };
            primitive.triangles[triangle][place] = index;
        }
    }
}

/// Lists for the corners around one point, kept from point to point.
#[derive(Default)]
struct Scratch {
    group: Vec<usize>,
    edges: Vec<(u32, usize)>,
    sums: Vec<DVec3>,
}

impl Scratch {
    /// Groups the corners around a point that are joined by edges smoother than the crease; writes for each corner its group
    /// and the group's normal.
    fn group(&mut self, fans: &Fans, corners: &[u32], cos_crease: f64, groups: &mut [(u32, [f32; 3])]) {
        let Scratch { group, edges, sums } = self;
        group.clear();
        group.extend(0..corners.len());
        edges.clear();
        for (i, &corner) in corners.iter().enumerate() {
            let [a, b] = fans.opposite(corner);
            edges.extend([(a, i), (b, i)]);
        }
        edges.sort_unstable();
        for run in edges.chunk_by(|a, b| a.0 == b.0) {
            for (k, &(_, i)) in run.iter().enumerate() {
                for &(_, j) in run.iter().skip(k + 1).take(PLANE_SEARCH) {
                    if fans.normal(corners[i]).dot(fans.normal(corners[j])) >= cos_crease {
                        let (a, b) = (root_of(group, i), root_of(group, j));
                        group[a.max(b)] = a.min(b);
                    }
                }
            }
        }
        sums.clear();
        sums.resize(corners.len(), DVec3::ZERO);
        for (i, &corner) in corners.iter().enumerate() {
            sums[root_of(group, i)] += fans.max_weighted(corner);
        }
        for (i, &corner) in corners.iter().enumerate() {
            let root = root_of(group, i);
            // A root is the first corner of its group, so its normal is known before the others'.
            let normal = if root == i {
                sums[root].try_normalize().unwrap_or(fans.normal(corner)).as_vec3().to_array()
            } else {
                groups[root].1
            };
            groups[i] = (root as u32, normal);
        }
    }
}

/// Replaces a primitive's normals by Max-weighted ones where the file's are a standard average, and says whether any
/// changed.
///
/// A standard average is that of the facets which share the vertex (welded where position *and* normal are
/// bit-identical): unweighted over triangles or over planes, by area, or by angle. One of them must agree with nine in
/// ten of the vertices within 0.5° and clearly better than Max's weights do. Normals that are not within 0.5° of it are
/// left alone, bit for bit, as are all normals of a primitive where no average fits: analytic ones, custom ones, flat
/// shading.
pub fn reweighted_normals(primitive: &mut Primitive) -> bool {
    primitive.normals.len() == primitive.positions.len() && {
        let fans = Fans::with_normals(primitive);
        reweighted(primitive, &fans)
    }
}

/// [`reweighted_normals`], then [`interpolated_normals`]; says which of them changed anything. The triangles around vertices are
/// looked for once if the first does not.
pub fn mended_normals(primitive: &mut Primitive) -> [bool; 2] {
    if primitive.normals.len() != primitive.positions.len() {
        return [false; 2];
    }
    let fans = Fans::with_normals(primitive);
    let first = reweighted(primitive, &fans);
    [first, if first { interpolated_normals(primitive) } else { interpolated(primitive, &fans) }]
}

fn reweighted(primitive: &mut Primitive, fans: &Fans) -> bool {
    let tolerance = chord(AVERAGE_TOLERANCE);
    // Over the points: the file's normal, the Max-weighted one, the distances (as chords) of the four averages.
    struct Point {
        max: DVec3,
        to_max: f64,
        to_average: [f64; 4],
    }
    let point = |point: usize| {
        let corners = fans.corners_of(point);
        let &corner = corners.first()?;
        let vertex = primitive.triangles[corner as usize / 3][corner as usize % 3] as usize;
        let stored = Vec3::from(primitive.normals[vertex]).as_dvec3().try_normalize()?;
        let max = corners.iter().map(|&c| fans.max_weighted(c)).sum::<DVec3>().try_normalize()?;
        // A file whose winding is the other way round averages the opposite normals.
        let sign = if max.dot(stored) < 0.0 { -1.0 } else { 1.0 };
        let to_average = fans.averages(corners).map(|a| a.try_normalize().map_or(2.0, |a| (a * sign).distance(stored)));
        Some(Point { max: max * sign, to_max: (max * sign).distance(stored), to_average })
    };
    // The average that at least this share of the points agrees with, and that fits better than Max's by this factor.
    let average_of = |points: &[Option<Point>], share: f64, factor: f64| {
        let known = points.iter().flatten().count();
        let rms = |of: &dyn Fn(&Point) -> f64| {
            // Clamped: a few custom normals must not decide.
            (points.iter().flatten().map(|p| of(p).min(4.0 * tolerance).powi(2)).sum::<f64>() / known as f64).sqrt()
        };
        let fits = |a: usize| points.iter().flatten().filter(|p| p.to_average[a] <= tolerance).count() as f64;
        let (average, error) = (0..4)
            .filter(|&a| known > 0 && fits(a) >= share * known as f64)
            .map(|a| (a, rms(&|p| p.to_average[a])))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        // Analytic normals of a fine tessellation are near every average, but nearest to Max's.
        (error <= factor * rms(&|p| p.to_max)).then_some(average)
    };
    // Of a large mesh a sample is asked first, less strictly: most have normals that are no average.
    if fans.len() > 4 * SAMPLE {
        let sample: Vec<Option<Point>> = (0..fans.len()).step_by(fans.len() / SAMPLE).map(point).collect();
        if average_of(&sample, AGREEING_SHARE - 0.1, 1.0).is_none() {
            return false;
        }
    }
    let points: Vec<Option<Point>> = (0..fans.len()).into_par_iter().map(point).collect();
    let Some(average) = average_of(&points, AGREEING_SHARE, 0.5) else { return false };
    let mut changed = false;
    for (corners, point) in fans.iter().zip(&points) {
        let Some(point) = point else { continue };
        if point.to_average[average] > tolerance || point.to_max <= chord(SAME_NORMAL) {
            continue;
        }
        for &corner in corners {
            let vertex = primitive.triangles[corner as usize / 3][corner as usize % 3] as usize;
            primitive.normals[vertex] = point.max.as_vec3().to_array();
        }
        changed = true;
    }
    changed
}

/// The length of the chord between two unit vectors that are `degrees` apart.
fn chord(degrees: f64) -> f64 {
    2.0 * (degrees.to_radians() * 0.5).sin()
}

/// Copies all attributes of `vertex` but its normal to the end; gives the new index.
fn duplicate(primitive: &mut Primitive, vertex: usize) -> u32 {
    let new = primitive.positions.len();
    primitive.positions.push(primitive.positions[vertex]);
    for uvs in &mut primitive.uvs {
        if let Some(&uv) = uvs.get(vertex) {
            uvs.push(uv);
        }
    }
    if let Some(&color) = primitive.colors.get(vertex) {
        primitive.colors.push(color);
    }
    new as u32
}

/// The root of `i` in a forest of parents, with the path halved.
fn root_of(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

/// The triangle corners around every welded point. A corner is `3 · triangle + place`.
struct Fans {
    /// Where each point's corners start in `corners`; one more than there are points.
    starts: Vec<u32>,
    corners: Vec<u32>,
    /// Welded point of every corner.
    points: Vec<u32>,
    /// Positions at every corner's point.
    positions: Vec<DVec3>,
    /// Unit normal of every triangle; zero if it has no area.
    normals: Vec<DVec3>,
}

impl Fans {
    /// The vertices that have the same position and normal are one point.
    fn with_normals(primitive: &Primitive) -> Fans {
        let welded = weld(primitive.positions.len(), |v| {
            let ([a, b, c], [d, e, f]) = (bits(primitive.positions[v]), bits(primitive.normals[v]));
            [a, b, c, d, e, f]
        });
        Fans::new(primitive, welded)
    }

    /// The fans of welded vertices. Triangles without area, or with a missing vertex, have no corners.
    fn new(primitive: &Primitive, welded: Welded) -> Fans {
        let positions: Vec<DVec3> =
            welded.firsts.par_iter().map(|&v| Vec3::from(primitive.positions[v as usize]).as_dvec3()).collect();
        let mut points = vec![u32::MAX; primitive.triangles.len() * 3];
        let mut normals = vec![DVec3::ZERO; primitive.triangles.len()];
        let each = points.par_chunks_exact_mut(3).zip(&mut normals).zip(&primitive.triangles);
        each.for_each(|((points, normal), triangle)| {
            let [Some(&a), Some(&b), Some(&c)] = triangle.map(|v| welded.ids.get(v as usize)) else { return };
            let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
            if let Some(n) = (q - p).cross(r - p).try_normalize() {
                *normal = n;
                points.copy_from_slice(&[a, b, c]);
            }
        });
        let mut starts = vec![0_u32; positions.len() + 1];
        for &point in points.iter().filter(|&&p| p != u32::MAX) {
            starts[point as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; starts.last().map_or(0, |&n| n as usize)];
        for (corner, &point) in points.iter().enumerate() {
            if point != u32::MAX {
                corners[next[point as usize] as usize] = corner as u32;
                next[point as usize] += 1;
            }
        }
        Fans { starts, corners, points, positions, normals }
    }

    /// Calls `each` with the corners of every point and the slots of `out` that belong to them, in parallel. `out` has one slot
    /// a corner.
    fn each_point<T: Send>(&self, out: &mut [T], each: impl Fn(&[u32], &mut [T], &mut Scratch) + Sync) {
        let mut pieces = Vec::new();
        let mut rest = out;
        for starts in self.starts[..self.len()].chunks(POINTS_AT_ONCE) {
            let first = pieces.len() * POINTS_AT_ONCE;
            let last = first + starts.len();
            let (piece, after) = rest.split_at_mut((self.starts[last] - self.starts[first]) as usize);
            pieces.push((first..last, piece));
            rest = after;
        }
        pieces.into_par_iter().for_each(|(points, mut piece)| {
            let mut scratch = Scratch::default();
            for point in points {
                let corners = self.corners_of(point);
                let (own, after) = piece.split_at_mut(corners.len());
                each(corners, own, &mut scratch);
                piece = after;
            }
        });
    }

    fn len(&self) -> usize {
        self.positions.len()
    }

    /// The corners around a point, in triangle order.
    fn corners_of(&self, point: usize) -> &[u32] {
        &self.corners[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// The corners around each point, in triangle order.
    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.corners[w[0] as usize..w[1] as usize])
    }

    /// The triangle's normal.
    fn normal(&self, corner: u32) -> DVec3 {
        self.normals[corner as usize / 3]
    }

    /// The two other points of the corner's triangle, in winding order.
    fn opposite(&self, corner: u32) -> [u32; 2] {
        let (first, place) = (corner as usize / 3 * 3, corner as usize % 3);
        [self.points[first + (place + 1) % 3], self.points[first + (place + 2) % 3]]
    }

    /// The two edges that leave the corner, in winding order.
    fn edges(&self, corner: u32) -> [DVec3; 2] {
        let here = self.positions[self.points[corner as usize] as usize];
        self.opposite(corner).map(|p| self.positions[p as usize] - here)
    }

    /// Normal times Max's weight: sin(angle)/(|e₁||e₂|), which is the cross product over both squared lengths.
    fn max_weighted(&self, corner: u32) -> DVec3 {
        let [e1, e2] = self.edges(corner);
        // Lengths first, so that very small and very large models neither underflow nor overflow.
        let (l1, l2) = (e1.length(), e2.length());
        (e1 / l1).cross(e2 / l2) / (l1 * l2)
    }

    /// Sums of the standard averages: by triangle, by plane, by area, by angle.
    fn averages(&self, corners: &[u32]) -> [DVec3; 4] {
        let mut sums = [DVec3::ZERO; 4];
        for (i, &corner) in corners.iter().enumerate() {
            let normal = self.normal(corner);
            let [e1, e2] = self.edges(corner);
            sums[0] += normal;
            let seen =
                corners.len() <= PLANE_SEARCH && corners[..i].iter().any(|&c| self.normal(c).dot(normal) >= SAME_PLANE);
            if !seen {
                sums[1] += normal;
            }
            sums[2] += e1.cross(e2);
            sums[3] += normal * e1.angle_between(e2);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A tube of unequal facets around z, two rings of quads, no caps. Vertices are shared.
    fn tube(facets: usize) -> Primitive {
        let mut p = Primitive::default();
        let mut angle = 0.0;
        let widths: Vec<f64> = (0..facets).map(|i| 1.0 + 0.8 * (i as f64 * 2.3).sin()).collect();
        let total: f64 = widths.iter().sum();
        for width in &widths {
            for z in [0.0, 0.7, 2.0] {
                p.positions.push([(3.0 * f64::cos(angle)) as f32, (3.0 * f64::sin(angle)) as f32, z]);
            }
            angle += width / total * TAU;
        }
        let n = facets as u32;
        for i in 0..n {
            for k in 0..2 {
                let [a, b] = [i * 3 + k, (i + 1) % n * 3 + k];
                p.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        p
    }

    fn radial_error(p: &Primitive) -> f64 {
        let each = p.positions.iter().zip(&p.normals).map(|(&v, &n)| {
            let exact = DVec3::new(v[0].into(), v[1].into(), 0.0).normalize();
            exact.angle_between(Vec3::from(n).as_dvec3()).to_degrees()
        });
        each.fold(0.0, f64::max)
    }

    fn averaged(p: &mut Primitive, which: usize) {
        p.normals = vec![[0.0; 3]; p.positions.len()];
        let fans = Fans::new(p, weld_positions(&p.positions));
        for (v, corners) in fans.iter().enumerate() {
            p.normals[v] = fans.averages(corners)[which].normalize().as_vec3().to_array();
        }
    }

    #[test]
    fn computed_normals_of_a_tube_of_unequal_facets_are_radial() {
        let mut p = tube(24);
        compute_normals(&mut p, 60.0);
        assert_eq!(p.positions.len(), 72, "no vertex of a smooth tube is split");
        assert!(radial_error(&p) < 0.01, "{}", radial_error(&p));
    }

    #[test]
    fn averaged_normals_of_a_tube_become_radial() {
        for which in 0..4 {
            let mut p = tube(48);
            averaged(&mut p, which);
            let before = radial_error(&p);
            assert!(before > 0.3, "average {which} shows the fault: {before}");
            assert!(reweighted_normals(&mut p), "average {which} is recognized");
            assert!(radial_error(&p) < 0.1, "average {which}: {}", radial_error(&p));
        }
    }

    #[test]
    fn analytic_and_custom_normals_stay_bit_identical() {
        let mut analytic = tube(24);
        analytic.normals = analytic.positions.iter().map(|v| [v[0] / 3.0, v[1] / 3.0, 0.0]).collect();
        let mut custom = tube(24);
        custom.normals = (0..custom.positions.len())
            .map(|i| Vec3::new((i as f32).sin(), (i as f32 * 0.7).cos(), 0.3).normalize().to_array())
            .collect();
        for (name, mut p) in [("analytic tube", analytic), ("custom", custom), ("analytic sphere", sphere(24, 48))] {
            let before = p.clone();
            assert!(!reweighted_normals(&mut p), "{name}");
            assert_eq!(p, before, "{name}");
        }
    }

    /// A unit sphere by latitude and longitude, closed by index, with its analytic normals.
    fn sphere(rows: u32, columns: u32) -> Primitive {
        let mut p = Primitive::default();
        p.positions.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
        for r in 1..rows {
            for c in 0..columns {
                let (t, f) = (TAU / 2.0 * f64::from(r) / f64::from(rows), TAU * f64::from(c) / f64::from(columns));
                p.positions.push([(t.sin() * f.cos()) as f32, (t.sin() * f.sin()) as f32, t.cos() as f32]);
            }
        }
        let at = |r: u32, c: u32| 2 + (r - 1) * columns + c % columns;
        for c in 0..columns {
            p.triangles.push([0, at(1, c), at(1, c + 1)]);
            p.triangles.push([1, at(rows - 1, c + 1), at(rows - 1, c)]);
            for r in 1..rows - 1 {
                p.triangles.push([at(r, c), at(r + 1, c), at(r + 1, c + 1)]);
                p.triangles.push([at(r, c), at(r + 1, c + 1), at(r, c + 1)]);
            }
        }
        p.normals = p.positions.clone();
        p
    }

    #[test]
    fn computed_normals_of_a_sphere_are_exact() {
        let mut p = sphere(12, 20);
        let exact = p.normals.clone();
        compute_normals(&mut p, 60.0);
        let worst =
            p.normals.iter().zip(&exact).map(|(&a, &b)| Vec3::from(a).distance(Vec3::from(b))).fold(0.0, f32::max);
        assert!(worst < 1e-5, "{worst}");
    }

    #[test]
    fn a_cube_is_split_at_its_edges_and_only_there() {
        let mut p = Primitive {
            positions: (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect(),
            ..Primitive::default()
        };
        p.uvs[0] = (0..8).map(|i| [i as f32, 0.0]).collect();
        for [a, b, c, d] in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] as [[u32; 4]; 6]
        {
            p.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let mut smooth = p.clone();
        compute_normals(&mut p, 30.0);
        assert_eq!(p.positions.len(), 24);
        assert_eq!((p.normals.len(), p.uvs[0].len()), (24, 24));
        for t in &p.triangles {
            let [a, b, c] = t.map(|v| Vec3::from(p.positions[v as usize]));
            let face = (b - a).cross(c - a).normalize();
            for &v in t {
                assert!(face.distance(Vec3::from(p.normals[v as usize])) < 1e-6);
                // The copy carries its own vertex's coordinates.
                let uv = p.uvs[0][v as usize][0] as usize;
                assert_eq!(p.positions[v as usize], smooth.positions[uv]);
            }
        }
        compute_normals(&mut smooth, 180.0);
        assert_eq!(smooth.positions.len(), 8, "nothing is split when every edge is smooth");
    }

    #[test]
    fn odd_input_gives_finite_normals() {
        let mut p = Primitive {
            positions: vec![[0.0; 3], [1e-30, 0.0, 0.0], [0.0, 1e-30, 0.0], [3e38, 0.0, 0.0], [0.0, -3e38, 1.0]],
            triangles: vec![[0, 1, 2], [0, 3, 4], [0, 0, 1], [9, 1, 2]],
            ..Primitive::default()
        };
        compute_normals(&mut p, 30.0);
        assert!(p.normals.iter().flatten().all(|c| c.is_finite()));
        reweighted_normals(&mut p);
        assert!(p.normals.iter().flatten().all(|c| c.is_finite()));
    }
}
