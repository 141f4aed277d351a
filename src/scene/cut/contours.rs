//! Where a plane cuts the surface of a mesh: closed contours, found through the mesh's edges.
//!
//! Every vertex is on one side or the other. One in the plane, or closer to it than rounding can tell, counts as cut away:
//! so the side is a property of the vertex, every triangle is crossed in two edges or none, and contours close wherever the
//! mesh does, whatever lies exactly in the plane. A face of the solid in the plane is thereby replaced by the cap, and one
//! from which the solid lies on the cut-away side vanishes with it.
//!
//! A crossing is known by its edge, not by its position, so nothing is compared with a tolerance. Only where a mesh does not
//! quite close (seams whose vertices differ by a rounding, an edge that meets the middle of another) ends of contours that
//! lie in one place are joined. Triangles of closed and
//! consistently wound meshes give as many contours into each crossing as out of it; then contours have a sense, and what
//! overlaps is filled once (nonzero winding). Where triangles disagree on their winding, contours are followed either way,
//! and filled by parity. A crossing that an odd number of contours meets is the end of an open one.

use std::collections::HashMap;

use glam::{DMat4, DVec3};

use crate::scene::Mesh;

/// A mesh with its vertices welded where their positions are equal, whatever their normals and materials.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Largest coordinates, without their signs.
    reach: DVec3,
}

/// Vertices that are closer to the plane than this share of the mesh's reach are in it: what 32-bit coordinates round.
const IN_PLANE: f64 = 1.0 / (1 << 22) as f64;

/// Ends of contours that are closer together than this share of the mesh's reach are in one place.
const SEAM: f64 = 1.0 / (1 << 18) as f64;

/// The contours of a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contours {
    /// Closed, without the repeated first point, in the space that was asked for.
    pub closed: Vec<Vec<DVec3>>,
    /// Whether they have a sense: counterclockwise around material as seen from the side that is cut away.
    pub directed: bool,
    /// Ends of contours that do not close; then there are no others either.
    pub open_ends: usize,
}

/// A piece of a contour inside one triangle, between two crossed edges.
struct Piece {
    ends: [u64; 2],
}

fn crossing(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

impl Solid {
    /// Welds a mesh. Triangles that have no area for it are left out.
    pub fn new(mesh: &Mesh) -> Solid {
        let bits = |p: [f32; 3]| p.map(|v| (v + 0.0).to_bits());
        let all = mesh.primitives.iter().flat_map(|p| &p.positions).copied();
        let mut order: Vec<([u32; 3], u32)> = all.enumerate().map(|(i, p)| (bits(p), i as u32)).collect();
        order.sort_unstable();
        let mut welded = vec![0; order.len()];
        let mut solid = Solid::default();
        let mut last = None;
        for (key, index) in order {
            if last != Some(key) {
                last = Some(key);
                solid.positions.push(glam::Vec3::from(key.map(f32::from_bits)).as_dvec3());
            }
            welded[index as usize] = solid.positions.len() as u32 - 1;
        }
        let finite = solid.positions.iter().filter(|p| p.is_finite());
        solid.reach = finite.fold(DVec3::ZERO, |reach, p| reach.max(p.abs()));
        let mut first = 0;
        for primitive in &mesh.primitives {
            let triangles = primitive.triangles.iter().map(|t| t.map(|v| welded[first + v as usize]));
            let finite = |v: u32| solid.positions[v as usize].is_finite();
            let sound = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && t.iter().all(|&v| finite(v));
            solid.triangles.extend(triangles.filter(sound));
            first += primitive.positions.len();
        }
        solid
    }

    /// The contours in which the plane `normal · x = offset` cuts the mesh, placed by `world_from_mesh`, in world space.
    pub fn contours(&self, world_from_mesh: &DMat4, normal: DVec3, offset: f64) -> Contours {
        let gradient = world_from_mesh.transpose() * normal.extend(0.0);
        let (gradient, at_origin) = (gradient.truncate(), gradient.w - offset);
        let in_plane = IN_PLANE * gradient.abs().dot(self.reach) + 1e-14 * at_origin.abs();
        let heights: Vec<f64> = self.positions.iter().map(|p| gradient.dot(*p) + at_origin).collect();
        let is_cut = |v: u32| heights[v as usize] > -in_plane;
        let mut pieces: Vec<Piece> = Vec::new();
        for &triangle in &self.triangles {
            let cut = triangle.map(is_cut);
            if cut[0] == cut[1] && cut[1] == cut[2] {
                continue;
            }
            // From the edge that goes down to the one that goes up: material is on the left, seen from above.
            let mut ends = [0; 2];
            for i in 0..3 {
                let next = (i + 1) % 3;
                if cut[i] != cut[next] {
                    ends[usize::from(cut[next])] = crossing(triangle[i], triangle[next]);
                }
            }
            pieces.push(Piece { ends });
        }
        let point = |crossing: u64| {
            let [a, b] = [(crossing >> 32) as u32, crossing as u32];
            let (kept, cut) = if is_cut(a) { (b, a) } else { (a, b) };
            let (below, above) = (heights[kept as usize], heights[cut as usize].max(0.0));
            let [from, to] = [kept, cut].map(|v| self.positions[v as usize]);
            world_from_mesh.transform_point3(from + (to - from) * (below / (below - above)))
        };
        let longest = (0..3).map(|axis| world_from_mesh.col(axis).truncate().length()).fold(0.0, f64::max);
        follow(&pieces, point, SEAM * longest * self.reach.max_element())
    }
}

/// For every point the first that lies within `distance` of it, itself perhaps.
fn merged(points: &[DVec3], distance: f64) -> Vec<u32> {
    if distance.is_nan() || distance <= 0.0 {
        return (0..points.len() as u32).collect();
    }
    // A ball of that radius touches at most two cells along each axis.
    let cell = |p: DVec3| (p / (2.0 * distance)).floor().to_array().map(|v| v as i64);
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let near = |cells: &HashMap<[i64; 3], Vec<u32>>, p: DVec3| {
        let (low, high) = (cell(p - distance), cell(p + distance));
        for corner in 0..8 {
            let at: [i64; 3] = std::array::from_fn(|axis| if corner >> axis & 1 == 0 { low } else { high }[axis]);
            let found = cells.get(&at).into_iter().flatten();
            if let Some(&other) = found.into_iter().find(|&&i| points[i as usize].distance(p) <= distance) {
                return Some(other);
            }
        }
        None
    };
    let mut all = Vec::with_capacity(points.len());
    for (i, &p) in points.iter().enumerate() {
        let first = near(&cells, p).unwrap_or_else(|| {
            cells.entry(cell(p)).or_default().push(i as u32);
            i as u32
        });
        all.push(first);
    }
    all
}

/// Numbers of the crossings that an odd number of pieces meets.
fn odd_ones(crossings: usize, ends: &[[usize; 2]]) -> Vec<usize> {
    let mut odd = vec![false; crossings];
    ends.iter().flatten().for_each(|end| odd[*end] = !odd[*end]);
    (0..crossings).filter(|i| odd[*i]).collect()
}

/// Joins pieces at their ends; ends that no other piece meets, where they are at most `seam` apart.
fn follow(pieces: &[Piece], point: impl Fn(u64) -> DVec3, seam: f64) -> Contours {
    let mut crossings: Vec<u64> = pieces.iter().flat_map(|p| p.ends).collect();
    crossings.sort_unstable();
    crossings.dedup();
    let number = |crossing: u64| crossings.binary_search(&crossing).unwrap_or_default();
    let mut ends: Vec<[usize; 2]> = pieces.iter().map(|p| p.ends.map(number)).collect();
    let mut loose = odd_ones(crossings.len(), &ends);
    if !loose.is_empty() {
        let places: Vec<DVec3> = loose.iter().map(|i| point(crossings[*i])).collect();
        let mut joined: Vec<usize> = (0..crossings.len()).collect();
        for (i, first) in merged(&places, seam).into_iter().enumerate() {
            joined[loose[i]] = loose[first as usize];
        }
        ends.iter_mut().flatten().for_each(|end| *end = joined[*end]);
        loose = odd_ones(crossings.len(), &ends);
    }
    if !loose.is_empty() {
        return Contours { open_ends: loose.len(), ..Contours::default() };
    }
    let mut balance = vec![0_i32; crossings.len()];
    for [from, to] in &ends {
        balance[*from] += 1;
        balance[*to] -= 1;
    }
    let directed = balance.iter().all(|b| *b == 0);
    // Ways out of each crossing: the piece, and the end by which it is entered.
    let mut ways: Vec<(usize, usize, usize)> = Vec::with_capacity(2 * ends.len());
    for (piece, [from, to]) in ends.iter().enumerate() {
        ways.push((*from, piece, 0));
        if !directed {
            ways.push((*to, piece, 1));
        }
    }
    ways.sort_unstable();
    let mut next: Vec<usize> = (0..crossings.len()).map(|c| ways.partition_point(|w| w.0 < c)).collect();
    let mut taken = vec![false; ends.len()];
    let mut closed = Vec::new();
    for (first, &[start, _]) in ends.iter().enumerate() {
        if taken[first] {
            continue;
        }
        let mut contour = Vec::new();
        let mut at = start;
        // Degrees are even, so the walk can only end where it began.
        while let Some(&(_, piece, end)) = ways.get(next[at]).filter(|way| way.0 == at) {
            next[at] += 1;
            if !std::mem::replace(&mut taken[piece], true) {
                contour.push(point(crossings[at]));
                at = ends[piece][1 - end];
            }
        }
        closed.push(contour);
    }
    Contours { closed, directed, open_ends: 0 }
}
