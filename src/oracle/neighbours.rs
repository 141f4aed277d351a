//! The four neighbours of every fragment, by brute force (Murray 2016, section 5.1).
//!
//! The candidate of fragment i in an adjacent pixel is the fragment j of the same part with the smallest
//! `ε = (1 − n_i · n_j) + ((depth_i − depth_j) / r)²`, r the radius of the part (T7). It counts as a neighbour only if i is
//! its candidate in return. *Missing* says that the surface ends here, *unknown* that nobody can say: beyond the image,
//! or where the adjacent list lost fragments (T10).
//!
//! With a view, depth_i is replaced by the depth at which the fragment's tangent plane crosses the adjacent pixel (T18), and
//! r by the height of a pixel there.
//!
//! An answer is ambiguous if the two best ε lie within 1e-6 and what 4 ulp of the depths make, here or in the reverse check.

use glam::{DVec3, Vec3};

use super::store::StoreData;
use super::view::{Extents, View};

/// Where a neighbour is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// +x.
    Right = 0,
    /// −x.
    Left = 1,
    /// +y.
    Down = 2,
    /// −y.
    Up = 3,
}

impl Direction {
    /// All four, in the order of their numbers.
    pub const ALL: [Direction; 4] = [Direction::Right, Direction::Left, Direction::Down, Direction::Up];

    /// The way back.
    pub fn opposite(self) -> Direction {
        match self {
            Direction::Right => Direction::Left,
            Direction::Left => Direction::Right,
            Direction::Down => Direction::Up,
            Direction::Up => Direction::Down,
        }
    }

    /// The adjacent pixel in an image of `width` × `height`, if there is one.
    pub fn step(self, pixel: usize, width: usize, height: usize) -> Option<usize> {
        let (x, y) = (pixel % width, pixel / width);
        match self {
            Direction::Right => (x + 1 < width).then_some(pixel + 1),
            Direction::Left => (x > 0).then(|| pixel - 1),
            Direction::Down => (y + 1 < height).then_some(pixel + width),
            Direction::Up => (y > 0).then(|| pixel - width),
        }
    }
}

/// What lies next to a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// The layer with this number in the adjacent pixel.
    To(u32),
    /// The surface ends.
    Missing,
    /// It cannot be said.
    Unknown,
}

/// The neighbours of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbours {
    /// By fragment and [`Direction`].
    pub links: Vec<[Link; 4]>,
    /// Whether the other answer passes too.
    pub ambiguous: Vec<[bool; 4]>,
}

/// How close two ε may be for either to win.
const TOLERANCE: f64 = 1e-6;

/// A layer of an adjacent pixel that resembles a fragment most.
#[derive(Clone, Copy)]
struct Candidate {
    layer: usize,
    ambiguous: bool,
}

/// Finds all neighbours as printed. Without `reverse_check` a candidate counts as it is.
pub fn neighbours(store: &StoreData, extents: &Extents, reverse_check: bool) -> Neighbours {
    neighbours_expected(store, extents, None, reverse_check)
}

/// Finds all neighbours; with a view, depths are compared with where the fragment's tangent plane crosses the adjacent pixel
/// (T18) instead of the fragment's own depth.
pub fn neighbours_expected(
    store: &StoreData,
    extents: &Extents,
    slope: Option<&View>,
    reverse_check: bool,
) -> Neighbours {
    let pixel_of = store.pixel_of_fragment();
    let (width, height) = (store.width.max(1) as usize, store.height as usize);
    let mut result = Neighbours::default();
    for (i, &p) in pixel_of.iter().enumerate() {
        let mut links = [Link::Unknown; 4];
        let mut ambiguous = [false; 4];
        for direction in Direction::ALL {
            let d = direction as usize;
            let Some(q) = direction.step(p, width, height) else { continue };
            let none = if store.overflowed[q] { Link::Unknown } else { Link::Missing };
            links[d] = none;
            let Some(found) = candidate(store, &Measure::new(store, extents, slope, i, p, q), i, q) else { continue };
            ambiguous[d] = found.ambiguous;
            let agreed = if reverse_check {
                let j = store.offsets[q] + found.layer;
                let back = candidate(store, &Measure::new(store, extents, slope, j, q, p), j, p);
                ambiguous[d] |= back.is_some_and(|b| b.ambiguous);
                back.is_some_and(|b| store.offsets[p] + b.layer == i)
            } else {
                true
            };
            if agreed {
                links[d] = Link::To(found.layer as u32);
            }
        }
        result.links.push(links);
        result.ambiguous.push(ambiguous);
    }
    result
}

/// The depth at which fragment `i` of pixel `p` expects its surface in the adjacent pixel `q`: its own, or with a view where
/// its tangent plane crosses the middle of `q`. A plane seen nearly edge-on gives at most the slope of 1 : 20.
pub(super) fn expected_depth(store: &StoreData, slope: Option<&View>, i: usize, p: usize, q: usize) -> f64 {
    let Some(view) = slope else { return store.depth[i] };
    let normal = Vec3::from(store.normal[i]).as_dvec3();
    let depth = store.depth[i];
    let at = |pixel: usize, depth: f64| {
        let (x, y) = store.xy(pixel);
        view.position(x, y, depth)
    };
    let here = at(p, depth);
    if !view.perspective {
        let step = at(q, depth) - here;
        return depth + (normal.x * step.x + normal.y * step.y) / normal.z.max(0.05);
    }
    let ray = at(q, 1.0);
    let (toward, away) = (-normal.dot(ray), -normal.dot(here));
    if toward > 0.05 && away > 0.0 { away / toward } else { depth }
}

/// How depth enters ε.
struct Measure {
    /// The depth that is expected.
    expected: f64,
    /// The length in which differences are measured: the part's radius as printed, the height of a pixel with a view.
    unit: f64,
    /// What 32-bit depths may be off by, in that length: 4 ulp of the depth itself, and of the expected one, which a plane
    /// near the edge-on limit amplifies.
    error: f64,
}

impl Measure {
    fn new(store: &StoreData, extents: &Extents, slope: Option<&View>, i: usize, p: usize, q: usize) -> Measure {
        let depth = store.depth[i];
        let ulps = 4.0 * f64::from(f32::EPSILON) * depth.abs();
        let expected = expected_depth(store, slope, i, p, q);
        match slope {
            None => {
                let unit = extents.part_radius(store.part[i]);
                Measure { expected, unit, error: ulps / unit }
            }
            Some(view) => {
                let unit = view.pixel_size(depth).y;
                let facing = f64::from(store.normal[i][2]).clamp(0.05, 1.0);
                Measure { expected, unit, error: ulps / unit / facing }
            }
        }
    }

    /// What ε may be off by.
    fn tolerance(&self, epsilon: f64) -> f64 {
        TOLERANCE + 2.0 * epsilon.sqrt() * self.error + self.error * self.error
    }
}

/// The fragment of pixel `q` that resembles fragment `i` most; the nearer layer among equals.
fn candidate(store: &StoreData, measure: &Measure, i: usize, q: usize) -> Option<Candidate> {
    let normal = |f: usize| -> DVec3 { Vec3::from(store.normal[f]).as_dvec3() };
    let mut best: Option<(usize, f64)> = None;
    let mut second = f64::INFINITY;
    for (layer, j) in store.range(q).enumerate().filter(|&(_, j)| store.part[j] == store.part[i]) {
        let epsilon_z = (measure.expected - store.depth[j]) / measure.unit;
        let epsilon = (1.0 - normal(i).dot(normal(j))) + epsilon_z * epsilon_z;
        match best {
            Some((_, smallest)) if epsilon >= smallest => second = second.min(epsilon),
            _ => {
                second = best.map_or(f64::INFINITY, |(_, smallest)| smallest);
                best = Some((layer, epsilon));
            }
        }
    }
    best.map(|(layer, smallest)| Candidate { layer, ambiguous: second - smallest <= measure.tolerance(smallest) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of pixels; each fragment is (part, depth, normal).
    fn row(pixels: &[&[(u32, f64, [f32; 3])]]) -> StoreData {
        let mut store = StoreData { width: pixels.len() as u32, height: 1, ..StoreData::default() };
        for fragments in pixels {
            store.offsets.push(store.depth.len());
            store.counts.push(fragments.len() as u32);
            store.overflowed.push(false);
            for &(part, depth, normal) in *fragments {
                store.part.push(part);
                store.depth.push(depth);
                store.normal.push(normal);
            }
        }
        store
    }

    fn extents() -> Extents {
        Extents { part_radii: vec![1.0, 100.0], scene_radius: 1.0, visible_height: 1.0, depth_range: [0.0, 1.0] }
    }

    const Z: [f32; 3] = [0.0, 0.0, 1.0];
    const X: [f32; 3] = [1.0, 0.0, 0.0];

    /// A wall 0.1 thick whose depth grows by 0.4 a pixel: the near face is closer to the next pixel's far face than to its
    /// own continuation, unless the slope is taken into account.
    #[test]
    fn the_slope_keeps_the_faces_of_a_thin_slanted_wall_apart() {
        let view = View {
            width: 3,
            height: 1,
            perspective: false,
            half_extent: glam::DVec2::new(1.5, 0.5),
            shift: glam::DVec2::ZERO,
        };
        let slanted = DVec3::new(0.4, 0.0, 1.0).normalize().as_vec3().to_array();
        let wall = |x: f64| [(0, 2.0 + 0.4 * x, slanted), (0, 2.1 + 0.4 * x, slanted)];
        let store = row(&[&wall(0.0), &wall(1.0), &wall(2.0)]);
        let by_slope = neighbours_expected(&store, &extents(), Some(&view), true);
        assert_eq!(by_slope.links[2][..2], [Link::To(0), Link::To(0)]);
        assert_eq!(by_slope.links[3][..2], [Link::To(1), Link::To(1)]);
        let printed = neighbours(&store, &extents(), true);
        assert_ne!(printed.links[2][..2], [Link::To(0), Link::To(0)]);
    }

    #[test]
    fn epsilon_chooses_by_normal_and_depth_inside_the_part() {
        let store = row(&[&[(0, 1.0, Z)], &[(0, 1.5, X), (1, 1.9, Z), (0, 1.75, Z)]]);
        let found = neighbours(&store, &extents(), true);
        // Fragment 1: 1 + 0.25; fragment 3: 0 + 0.5625. Part 1 is closer still, but another part.
        assert_eq!(found.links[0], [Link::To(2), Link::Unknown, Link::Unknown, Link::Unknown]);
        assert_eq!(found.links[3][1], Link::To(0));
        assert_eq!(found.links[2][1], Link::Missing, "no fragment of part 1 in the first pixel");
        // Fragment 1 wants fragment 0, which prefers fragment 3.
        assert_eq!(found.links[1][1], Link::Missing);
        assert_eq!(neighbours(&store, &extents(), false).links[1][1], Link::To(0));
    }

    #[test]
    fn a_full_list_makes_missing_unknown() {
        let mut store = row(&[&[(0, 1.0, Z)], &[(1, 1.0, Z)]]);
        assert_eq!(neighbours(&store, &extents(), true).links[0][0], Link::Missing);
        store.overflowed[1] = true;
        let found = neighbours(&store, &extents(), true);
        assert_eq!(found.links[0][0], Link::Unknown);
        assert_eq!(found.links[1][1], Link::Missing, "the other pixel has all its fragments");
    }

    #[test]
    fn equals_go_to_the_nearer_layer_and_are_ambiguous() {
        let store = row(&[&[(0, 1.0, Z)], &[(0, 1.25, Z), (0, 1.25, Z)]]);
        let found = neighbours(&store, &extents(), true);
        assert_eq!((found.links[0][0], found.ambiguous[0][0]), (Link::To(0), true));
        assert_eq!((found.links[2][1], found.ambiguous[2][1]), (Link::Missing, true));
        let clear = neighbours(&row(&[&[(0, 1.0, Z)], &[(0, 1.25, Z), (0, 1.5, Z)]]), &extents(), true);
        assert_eq!(clear.ambiguous, [[false; 4]; 3]);
    }

    #[test]
    fn a_larger_part_weighs_depth_less() {
        let pixels = |part| row(&[&[(part, 1.0, Z)], &[(part, 1.1, X), (part, 3.0, Z)]]);
        assert_eq!(neighbours(&pixels(0), &extents(), false).links[0][0], Link::To(0));
        assert_eq!(neighbours(&pixels(1), &extents(), false).links[0][0], Link::To(1));
    }

    #[test]
    fn one_pixel_knows_nothing_of_its_surroundings() {
        let found = neighbours(&row(&[&[(0, 1.0, Z)]]), &extents(), true);
        assert_eq!(found.links, [[Link::Unknown; 4]]);
        assert!(neighbours(&row(&[&[]]), &extents(), true).links.is_empty());
        assert!(neighbours(&StoreData::default(), &extents(), true).links.is_empty());
    }
}
