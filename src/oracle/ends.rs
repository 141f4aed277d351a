//! Where surfaces end, and what that hides: seams, open ends, and which fragments lie under or beside them (Carnecky 2013, section
//! 5.3; [`crate::passes::illustration::ends`] says where we differ and why).
//!
//! # Choices
//! - A seam needs both: each fragment no farther than a pixel's size from the other's tangent plane, as seen along the sight
//!   line through the other's pixel; or their planes cross between the two pixels, not more than [`CROSSING`] pixels' sizes apart
//!   at their centres together. A plane seen nearly edge-on gets at most the slope of 1 : 20.
//! - Only a fragment without a neighbour on this side closes a gap, whichever part it belongs to: missing, or unknown, as beside
//!   a cut. The surface itself goes on only with a fragment of its part that lacks its neighbour.
//! - What is unknown neither ends nor lies under or beside anything in that direction (T10).
//! - A fragment that ends openly lies behind open ends of other parts only. Of its own part, what seems to end in front of it
//!   may be the neighbour that the search did not find, on a surface seen nearly edge-on.
//!
//! An answer is ambiguous if a depth lies within a rounding error of what decides it.

use glam::{DVec3, Vec3};

use super::neighbours::{Direction, Link};
use super::store::StoreData;
use super::view::View;

/// How many pixels' sizes planes that cross may be apart at the pixels' centres, taken together.
const CROSSING: f64 = 4.0;

/// Where fragments end, by fragment and [`Direction`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ends {
    /// Whether the surface does: the neighbour is missing, and the surface does not go on beyond a seam.
    pub surface: Vec<[bool; 4]>,
    /// Whether it does openly: the neighbour is missing, and there is no seam at all.
    pub open: Vec<[bool; 4]>,
    /// Whether the neighbour is missing and the fragment lies behind what ends openly in the adjacent pixel.
    pub behind: Vec<[bool; 4]>,
}

/// A fragment's tangent plane.
struct Tangent<'a> {
    view: &'a View,
    normal: DVec3,
    pixel: (u32, u32),
    depth: f64,
    /// How far along the sight line something is off, if it is a pixel's size off the plane.
    reach: f64,
    /// What 32-bit numbers may be off by.
    error: f64,
}

impl<'a> Tangent<'a> {
    fn of(store: &StoreData, view: &'a View, i: usize, pixel: usize) -> Tangent<'a> {
        let (depth, at) = (store.depth[i], store.xy(pixel));
        let normal = Vec3::from(store.normal[i]).as_dvec3();
        let facing = normal.dot(view.to_eye(view.position(at.0, at.1, depth)).normalize()).max(0.05);
        let reach = view.pixel_size(depth).y / facing;
        let error = 8.0 * f64::from(f32::EPSILON) * depth.abs() / facing + 1e-4 * reach;
        Tangent { view, normal, pixel: at, depth, reach, error }
    }

    /// The plane's depth in another pixel.
    fn depth_in(&self, (x, y): (u32, u32)) -> f64 {
        let of = |(x, y): (u32, u32)| self.view.position(x, y, if self.view.perspective { 1.0 } else { self.depth });
        let (there, step) = (of((x, y)), of((x, y)) - of(self.pixel));
        let rise = self.normal.x * step.x + self.normal.y * step.y;
        if self.view.perspective {
            self.depth + self.depth * rise / (-self.normal.dot(there)).max(0.05)
        } else {
            self.depth + rise / self.normal.z.max(0.05)
        }
    }
}

/// Something that one number decides: whether it is so, and whether that hangs on a rounding error.
fn at_most(value: f64, limit: f64, error: f64) -> (bool, bool) {
    (value <= limit, (value - limit).abs() <= error)
}

/// Whether two fragments meet, and whether that hangs on a rounding error.
fn meet(own: &Tangent<'_>, other: &Tangent<'_>) -> (bool, bool) {
    let size = own.view.pixel_size(own.depth).y;
    let off = own.depth_in(other.pixel) - other.depth;
    let back = other.depth_in(own.pixel) - own.depth;
    let error = own.error + other.error;
    let near = at_most(off.abs(), own.reach, error);
    let near_back = at_most(back.abs(), other.reach, error);
    let close = at_most(off.abs() + back.abs(), CROSSING * size, error);
    let crosses = off * back >= 0.0;
    let is_so = |near: bool, back: bool, close: bool, crosses: bool| (near && back) || (close && crosses);
    let found = is_so(near.0, near_back.0, close.0, crosses);
    // Whatever else may be found where each that is in doubt is the other way, too.
    let unsure = [near.1, near_back.1, close.1, off.abs().min(back.abs()) <= error];
    let is_unsure = (0..16).any(|turned: u32| {
        let turn = |i: usize, is: bool| is != (turned >> i & 1 != 0);
        (0..4).all(|i| unsure[i] || turned >> i & 1 == 0)
            && is_so(turn(0, near.0), turn(1, near_back.0), turn(2, close.0), turn(3, crosses)) != found
    });
    (found, is_unsure)
}

impl Ends {
    /// Those of all fragments, and which of them are ambiguous.
    pub fn find(store: &StoreData, links: &[[Link; 4]], view: &View) -> (Ends, Vec<[bool; 4]>) {
        let (mut ends, mut ambiguous) = Ends::seams(store, links, view);
        let (behind, unsure) = Ends::behind(store, links, view, &ends.open);
        ends.behind = behind;
        for (a, b) in ambiguous.iter_mut().flatten().zip(unsure.iter().flatten()) {
            *a |= b;
        }
        (ends, ambiguous)
    }

    /// Where surfaces end and where they do openly, and which of that is ambiguous.
    pub fn seams(store: &StoreData, links: &[[Link; 4]], view: &View) -> (Ends, Vec<[bool; 4]>) {
        let (width, height) = (store.width.max(1) as usize, store.height as usize);
        let mut ends = Ends::default();
        let mut ambiguous = Vec::new();
        for (i, &p) in store.pixel_of_fragment().iter().enumerate() {
            let missing = links[i].map(|l| l == Link::Missing);
            let (mut surface, mut open, mut unsure) = (missing, missing, [false; 4]);
            for d in Direction::ALL.into_iter().filter(|&d| missing[d as usize]) {
                let Some(q) = d.step(p, width, height) else { continue };
                let back = d.opposite() as usize;
                for j in store.range(q).filter(|&j| !matches!(links[j][back], Link::To(_))) {
                    let (meets, is_unsure) = meet(&Tangent::of(store, view, i, p), &Tangent::of(store, view, j, q));
                    let lacking = links[j][back] == Link::Missing;
                    unsure[d as usize] |= is_unsure;
                    open[d as usize] &= !meets;
                    surface[d as usize] &= !(meets && lacking && store.part[j] == store.part[i]);
                }
            }
            ends.surface.push(surface);
            ends.open.push(open);
            ambiguous.push(unsure);
        }
        (ends, ambiguous)
    }

    /// Which fragments lack a neighbour and lie behind what ends openly, and which of that is ambiguous.
    pub fn behind(
        store: &StoreData,
        links: &[[Link; 4]],
        view: &View,
        open: &[[bool; 4]],
    ) -> (Vec<[bool; 4]>, Vec<[bool; 4]>) {
        let (width, height) = (store.width.max(1) as usize, store.height as usize);
        let of = |(i, &p): (usize, &usize)| {
            let tangent = Tangent::of(store, view, i, p);
            let in_direction = |d: Direction| {
                let q = d.step(p, width, height).filter(|_| links[i][d as usize] == Link::Missing)?;
                let expected = tangent.depth_in(store.xy(q));
                let counts = |j: &usize| {
                    let other = !open[i][d as usize] || store.part[*j] != store.part[i];
                    open[*j][d.opposite() as usize] && other
                };
                let nearest = store.range(q).filter(counts).map(|j| store.depth[j]).fold(f64::INFINITY, f64::min);
                Some((nearest < expected, (nearest - expected).abs() <= tangent.error))
            };
            let found = Direction::ALL.map(|d| in_direction(d).unwrap_or_default());
            (found.map(|f| f.0), found.map(|f| f.1))
        };
        store.pixel_of_fragment().iter().enumerate().map(of).unzip()
    }
}

/// What is known of the surfaces in a store, by which silhouettes and halos begin.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// The fragments.
    pub store: &'a StoreData,
    /// Their neighbours.
    pub links: &'a [[Link; 4]],
    /// Where they end.
    pub ends: &'a Ends,
    /// As printed: every missing neighbour is an end, and every step of the layer index counts.
    pub bare: bool,
}

impl Surfaces<'_> {
    /// Whether fragment `i` is a silhouette.
    pub fn is_end(&self, i: usize) -> bool {
        if self.bare { self.links[i].contains(&Link::Missing) } else { self.ends.surface[i].contains(&true) }
    }

    /// Whether fragment `i` lacks its neighbour in a direction though its surface does not end there.
    pub fn goes_on(&self, i: usize, d: Direction) -> bool {
        !self.bare && self.links[i][d as usize] == Link::Missing && !self.ends.surface[i][d as usize]
    }

    /// Whether layer `index` of a pixel lies under what ends between it and the adjacent pixel in a direction, and whether it
    /// lies beside what ends there, on its own side.
    pub fn occlusion(&self, pixel: usize, index: usize, d: Direction) -> (bool, bool) {
        let store = self.store;
        let i = store.offsets[pixel] + index;
        let link = self.links[i][d as usize];
        if self.bare {
            return match link {
                Link::To(other) => (index > other as usize, index < other as usize),
                Link::Missing | Link::Unknown => (false, false),
            };
        }
        let Some(q) = d.step(pixel, store.width.max(1) as usize, store.height as usize) else { return (false, false) };
        let under = (store.offsets[pixel]..i).any(|f| self.ends.open[f][d as usize]);
        let hides = |f: usize| self.ends.open[f][d.opposite() as usize];
        let first = store.offsets[q];
        match link {
            Link::To(other) => (under, (first..first + other as usize).any(hides)),
            Link::Missing => (under, self.ends.behind[i][d as usize]),
            Link::Unknown => (false, false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::store::row;

    /// Nothing is linked.
    fn unlinked(store: &StoreData) -> Vec<[Link; 4]> {
        let (left, right) = (store.counts[0] as usize, store.len() - *store.counts.last().unwrap() as usize);
        let known = |is: bool| if is { Link::Missing } else { Link::Unknown };
        (0..store.len()).map(|i| [known(i < right), known(i >= left), Link::Unknown, Link::Unknown]).collect()
    }

    /// Whether the surface of the first fragment ends to the right, and whether openly.
    fn first(pixels: [&[(u32, f64, f64)]; 2]) -> (bool, bool) {
        let (store, view) = row(&pixels);
        let (ends, ambiguous) = Ends::find(&store, &unlinked(&store), &view);
        assert!(!ambiguous.concat().contains(&true));
        let last = store.len() - 1;
        assert_eq!(ends.open[0][0], ends.open[last][1], "a seam is one from both sides");
        assert!(!ends.surface[0][1] && !ends.surface[0][2], "beyond the image nothing is known");
        (ends.surface[0][0], ends.open[0][0])
    }

    #[test]
    fn seams_by_hand() {
        assert_eq!(first([&[(0, 5.0, 0.0)], &[(1, 5.9, 0.0)]]), (true, false), "parts that touch");
        assert_eq!(first([&[(0, 5.0, 0.0)], &[(0, 5.9, 0.0)]]), (false, false), "the surface goes on");
        assert_eq!(first([&[(0, 5.0, 0.0)], &[(0, 6.1, 0.0)]]), (true, true), "more than a pixel apart");
        // At a slope of 3 the surface is expected 3 farther away, and a pixel off its plane is √10 along the sight line.
        assert_eq!(first([&[(0, 5.0, 3.0)], &[(0, 11.0, 3.0)]]), (false, false));
        assert_eq!(first([&[(0, 5.0, 3.0)], &[(0, 11.2, 3.0)]]), (true, true));
        assert_eq!(first([&[(0, 5.0, 3.0)], &[(0, 5.0, 3.0)]]), (false, false));
        // Two silhouettes that turn away from each other, one far behind the other: neither expects the other there.
        assert_eq!(first([&[(0, 5.0, 9.0)], &[(0, 16.0, -9.0)]]), (true, true));
        // The second expects the first in its own plane, but the first turns away.
        assert_eq!(first([&[(0, 5.0, 5.0)], &[(0, 9.0, 0.0)]]), (true, true));
        // Seen edge-on a plane is given a slope of 20.
        assert_eq!(first([&[(0, 5.0, 1e6)], &[(0, 25.0, 1e6)]]), (false, false));
    }

    /// Faces whose common edge lies between the two pixels.
    #[test]
    fn planes_that_cross_meet() {
        // At a right angle, with the edge a tenth of a pixel from the first one's centre.
        assert_eq!(first([&[(0, 5.0, 3.0)], &[(1, 5.0, -1.0 / 3.0)]]), (true, false));
        assert_eq!(first([&[(0, 5.0, 3.0)], &[(1, 4.5, -1.0 / 3.0)]]), (true, true), "the second is nearer at both");
        assert_eq!(first([&[(0, 5.0, 0.0)], &[(1, 8.0, 3.5)]]), (true, false), "a wall on a floor");
        assert_eq!(first([&[(0, 5.0, 0.0)], &[(1, 8.0, 5.5)]]), (true, true), "too steep to tell");
    }

    #[test]
    fn a_linked_fragment_makes_no_seam_and_an_unknown_one_does() {
        let (store, view) = row(&[&[(0, 5.0, 0.0), (0, 5.2, 0.0)], &[(0, 5.2, 0.0)]]);
        let mut links = unlinked(&store);
        (links[1][0], links[2][1]) = (Link::To(0), Link::To(1));
        let (ends, _) = Ends::find(&store, &links, &view);
        assert!(ends.open[0][0] && ends.surface[0][0] && !ends.open[1][0] && !ends.open[2][1]);
        // Beside a cut nothing opens, but the surface ends.
        let (store, view) = row(&[&[(0, 5.0, 0.0)], &[(0, 5.0, 0.0)]]);
        let mut links = unlinked(&store);
        links[1][1] = Link::Unknown;
        let (ends, _) = Ends::find(&store, &links, &view);
        assert!(!ends.open[0][0] && ends.surface[0][0] && !ends.open[1][1]);
    }

    /// What is found for layer `index` of the left pixel, looking to the right.
    fn left(store: &StoreData, view: &View, links: &[[Link; 4]], index: usize) -> (bool, bool) {
        let (ends, _) = Ends::find(store, links, view);
        Surfaces { store, links, ends: &ends, bare: false }.occlusion(0, index, Direction::Right)
    }

    /// One sheet ends where another begins, far from it; what lies behind both has the same index on either side.
    #[test]
    fn an_end_and_a_beginning_do_not_cancel() {
        let (store, view) = row(&[&[(0, 5.0, 0.0), (2, 30.0, 0.0)], &[(1, 20.0, 0.0), (2, 30.0, 0.0)]]);
        let mut links = unlinked(&store);
        (links[1][0], links[3][1]) = (Link::To(1), Link::To(1));
        assert_eq!(left(&store, &view, &links, 1), (true, true));
        assert_eq!(left(&store, &view, &links, 0), (false, false), "the nearest is behind nothing");
        let (ends, _) = Ends::find(&store, &links, &view);
        let bare = Surfaces { store: &store, links: &links, ends: &ends, bare: true };
        assert_eq!(bare.occlusion(0, 1, Direction::Right), (false, false), "as printed the steps cancel");
        // In a seam nothing opens.
        let (store, view) = row(&[&[(0, 5.0, 0.0), (2, 30.0, 0.0)], &[(1, 5.0, 0.0), (2, 30.0, 0.0)]]);
        assert_eq!(left(&store, &view, &links, 1), (false, false));
    }

    /// A sheet that ends right where another does in front of it, on the other side.
    #[test]
    fn what_ends_itself_can_lie_beside_an_end() {
        let (store, view) = row(&[&[(0, 20.0, 0.0)], &[(1, 5.0, 0.0)]]);
        assert_eq!(left(&store, &view, &unlinked(&store), 0), (false, true));
        let (store, view) = row(&[&[(0, 5.0, 0.0)], &[(1, 20.0, 0.0)]]);
        assert_eq!(left(&store, &view, &unlinked(&store), 0), (false, false), "the farther one hides nothing");
        let (store, view) = row(&[&[(0, 20.0, 0.0)], &[(0, 5.0, 0.0)]]);
        assert_eq!(left(&store, &view, &unlinked(&store), 0), (false, false), "it may be its own neighbour");
        // With a seam there, it does as if its neighbour had been found.
        let (store, view) = row(&[&[(0, 20.0, 0.0)], &[(0, 5.0, 0.0), (0, 20.0, 0.0)]]);
        assert_eq!(left(&store, &view, &unlinked(&store), 0), (false, true));
    }
}
