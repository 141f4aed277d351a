//! Where the edge of a near sheet crosses the edge of a farther one: the T-junctions of an opaque picture.
//!
//! They are found in the store, whatever the picture looks like. A *crack* lies between two adjacent pixels where a layer lacks
//! its neighbour. Around a crack the sheet that ends there, and each sheet that goes on behind it, are followed along their links
//! within a disc; where the pixels that a sheet covers fill a half-plane, it has a straight edge. The crack is a junction if the
//! near sheet has such an edge, one behind it has another that runs elsewhere through the same place, and nothing else ends in
//! front of that within the disc. A sheet that folds back at its silhouette ends twice in one place: that is one edge.
//!
//! The occluding edge is then crossed at right angles in two places, to either side of the farther edge: once the farther sheet is
//! behind both ends of the crossing, once behind neither.

use std::collections::HashMap;

use glam::DVec2;

use crate::oracle::{Direction, Link, StoreData};
use crate::scene::builtin::Random;

/// Radius of the disc, pixels.
const RADIUS: i64 = 6;
/// How far from the crossing of the edges the occluding edge is crossed, pixels.
const ASIDE: f64 = 4.0;
/// Distances from the occluding edge at which luminance is taken, pixels.
pub const DISTANCES: [f64; 3] = [1.5, 2.5, 3.5];
/// Least cosine between the directions in which two different edges may look, turned by a right angle: 45°.
const MOST_ALIKE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Share of a disc's pixels that may lie on the wrong side of a straight edge.
const RAGGED: f64 = 0.08;
/// Share of a disc's pixels at which something else may end. An edge that passes the disc's rim has more.
const STRAY: f64 = 0.03;
/// How far from an edge a pixel belongs to it, pixels.
const OF_EDGE: f64 = 1.8;
/// How far apart two junctions are at least, pixels.
const SPACING: f64 = 4.0;

/// A place where the edge of a near sheet crosses a farther one's.
#[derive(Clone, Debug, PartialEq)]
pub struct Junction {
    /// Where the edges cross, pixels; pixel (x, y) has its centre at (x + ½, y + ½).
    pub place: DVec2,
    /// From the near sheet over its edge, of unit length.
    pub outward: DVec2,
    /// From the farther sheet over its edge, of unit length.
    pub outward_behind: DVec2,
}

/// A crossing of the occluding edge: places on the near sheet's side, and as many beyond it.
pub type Crossing = [[DVec2; DISTANCES.len()]; 2];

impl Junction {
    /// The two crossings, to either side of the farther edge.
    pub fn crossings(&self) -> [Crossing; 2] {
        [-1.0, 1.0].map(|side| {
            let middle = self.place + self.outward.perp() * (side * ASIDE);
            [-1.0, 1.0].map(|over| DISTANCES.map(|d| middle + self.outward * (over * d)))
        })
    }
}

/// A half-plane of pixels: those with `outward · place < at`.
#[derive(Clone, Copy, Debug)]
struct Edge {
    outward: DVec2,
    at: f64,
}

impl Edge {
    /// How far outside a place lies.
    fn beyond(self, place: DVec2) -> f64 {
        self.outward.dot(place) - self.at
    }

    /// Where two edges cross.
    fn crosses(self, other: Edge) -> DVec2 {
        let determinant = self.outward.perp_dot(other.outward);
        DVec2::new(
            self.at * other.outward.y - other.at * self.outward.y,
            other.at * self.outward.x - self.at * other.outward.x,
        ) / determinant
    }
}

/// The store as the search reads it.
struct Search<'a> {
    store: &'a StoreData,
    links: &'a [[Link; 4]],
    width: usize,
    height: usize,
}

/// Puts elements into an order that depends on the seed alone.
pub(super) fn shuffle<T>(elements: &mut [T], seed: u64) {
    let mut random = Random::new(seed);
    for i in (1..elements.len()).rev() {
        elements.swap(i, random.below(i as u64 + 1) as usize);
    }
}

/// Finds all junctions of a picture, in an order that depends on the seed alone, and says how many cracks were looked at.
pub fn find(store: &StoreData, links: &[[Link; 4]], seed: u64) -> (Vec<Junction>, usize) {
    let search = Search { store, links, width: store.width as usize, height: store.height as usize };
    let mut cracks = search.cracks();
    shuffle(&mut cracks, seed);
    let mut found: Vec<Junction> = Vec::new();
    let tried = cracks.len();
    for (pixel, direction, layer) in cracks {
        // Otherwise one crossing of edges would count many times.
        let (x, y) = store.xy(pixel);
        let here = DVec2::new(f64::from(x), f64::from(y));
        if found.iter().any(|j| j.place.distance(here) < SPACING) {
            continue;
        }
        if let Some(junction) = search.junction(pixel, direction, layer) {
            found.push(junction);
        }
    }
    (found, tried)
}

impl Search<'_> {
    /// Cracks of the nearest layer that ends in each pixel and direction, far enough from the image's edge.
    fn cracks(&self) -> Vec<(usize, Direction, usize)> {
        let margin = RADIUS as usize + 2;
        let mut all = Vec::new();
        for pixel in 0..self.width * self.height {
            let (x, y) = (pixel % self.width, pixel / self.width);
            if x < margin || y < margin || x + margin >= self.width || y + margin >= self.height {
                continue;
            }
            for direction in Direction::ALL {
                let ends = |i: &usize| self.links[*i][direction as usize] == Link::Missing;
                if let Some(i) = self.store.range(pixel).find(ends) {
                    all.push((pixel, direction, i));
                }
            }
        }
        all
    }

    fn center(&self, pixel: usize) -> DVec2 {
        let (x, y) = self.store.xy(pixel);
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    /// Pixels of the disc around a pixel.
    fn disc(&self, around: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = ((around % self.width) as i64, (around / self.width) as i64);
        let all = (-RADIUS..=RADIUS).flat_map(|dy| (-RADIUS..=RADIUS).map(move |dx| (dx, dy)));
        all.filter(|(dx, dy)| dx * dx + dy * dy <= RADIUS * RADIUS)
            .map(move |(dx, dy)| (y + dy) as usize * self.width + (x + dx) as usize)
    }

    /// The sheet that a layer belongs to, followed over the disc: its layer in each pixel. `None` if it meets itself there.
    fn sheet(&self, around: usize, (pixel, layer): (usize, usize)) -> Option<HashMap<usize, usize>> {
        let disc: Vec<usize> = self.disc(around).collect();
        let mut sheet = HashMap::from([(pixel, layer)]);
        let mut open = vec![(pixel, layer)];
        while let Some((pixel, layer)) = open.pop() {
            for direction in Direction::ALL {
                let Some(next) = direction.step(pixel, self.width, self.height) else { continue };
                let Link::To(index) = self.links[layer][direction as usize] else { continue };
                if !disc.contains(&next) {
                    continue;
                }
                let there = self.store.offsets[next] + index as usize;
                match sheet.insert(next, there) {
                    None => open.push((next, there)),
                    Some(before) if before == there => {}
                    Some(_) => return None,
                }
            }
        }
        Some(sheet)
    }

    /// The straight edge of a sheet in the disc, if it has one.
    fn edge(&self, around: usize, sheet: &HashMap<usize, usize>) -> Option<Edge> {
        let disc: Vec<(DVec2, bool)> = self.disc(around).map(|p| (self.center(p), sheet.contains_key(&p))).collect();
        let inside = disc.iter().filter(|(_, covered)| *covered).count();
        // Of less than a fifth nothing can be said.
        if inside * 5 < disc.len() || (disc.len() - inside) * 5 < disc.len() {
            return None;
        }
        let mean = |wanted: bool| {
            let of = disc.iter().filter(|(_, covered)| *covered == wanted);
            of.clone().map(|(p, _)| *p).sum::<DVec2>() / of.count() as f64
        };
        let outward = (mean(false) - mean(true)).try_normalize()?;
        let mut along: Vec<f64> = disc.iter().map(|(p, _)| outward.dot(*p)).collect();
        along.sort_by(f64::total_cmp);
        let edge = Edge { outward, at: 0.5 * (along[inside - 1] + along[inside]) };
        let wrong = disc.iter().filter(|(p, covered)| (edge.beyond(*p) < 0.0) != *covered).count();
        (wrong as f64 <= RAGGED * disc.len() as f64).then_some(edge)
    }

    fn junction(&self, pixel: usize, direction: Direction, layer: usize) -> Option<Junction> {
        let near = self.sheet(pixel, (pixel, layer))?;
        let edge = self.edge(pixel, &near)?;
        let beyond = direction.step(pixel, self.width, self.height)?;
        // Sheets that go on behind the near one's edge.
        let behind = (layer + 1..self.store.range(pixel).end)
            .filter(|&i| matches!(self.links[i][direction as usize], Link::To(_)));
        for other in behind {
            let Some(far) = self.sheet(pixel, (pixel, other)) else { continue };
            // Away from it, the near sheet has to be in front too.
            let in_front = near.iter().all(|(p, i)| far.get(p).is_none_or(|j| i < j));
            let Some(edge_behind) = self.edge(pixel, &far).filter(|_| in_front) else { continue };
            if edge.outward.dot(edge_behind.outward).abs() > MOST_ALIKE {
                continue;
            }
            let place = edge.crosses(edge_behind);
            let junction = Junction { place, outward: edge.outward, outward_behind: edge_behind.outward };
            let middle = 0.5 * (self.center(pixel) + self.center(beyond));
            if place.distance(middle) < 2.0 && self.is_clear(pixel, &junction, (edge, edge_behind), &far) {
                return Some(junction);
            }
        }
        None
    }

    /// Whether nothing else ends in front of the farther sheet, and no place of the crossings lies at its edge or outside the disc.
    fn is_clear(
        &self,
        around: usize,
        junction: &Junction,
        (edge, edge_behind): (Edge, Edge),
        far: &HashMap<usize, usize>,
    ) -> bool {
        let places = junction.crossings();
        let mut places = places.iter().flatten().flatten();
        if !places
            .all(|p| edge_behind.beyond(*p).abs() >= 1.0 && p.distance(self.center(around)) <= RADIUS as f64 + 1.5)
        {
            return false;
        }
        // Where the farther sheet is not, what counts is nearer than any of it.
        let nearest = far.values().map(|&j| self.store.depth[j]).fold(f64::INFINITY, f64::min);
        let others = self.disc(around).filter(|&pixel| {
            let here = self.center(pixel);
            if edge.beyond(here).abs() <= OF_EDGE || edge_behind.beyond(here).abs() <= OF_EDGE {
                return false;
            }
            let limit = far.get(&pixel).map_or(nearest, |&j| self.store.depth[j]);
            let ends = |i: usize| self.store.depth[i] < limit && self.links[i].contains(&Link::Missing);
            self.store.range(pixel).any(ends)
        });
        // What of the two edges strays from a straight line is no other edge.
        others.count() as f64 <= STRAY * self.disc(around).count() as f64
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::Camera;
    use crate::oracle::{Extents, View, continuity, rasterize};
    use crate::scene::builtin::samples;
    use crate::settings::DepthTerm;

    const SIZE: [u32; 2] = [60, 60];

    /// Squares of side 2 with their centres given, seen from +z in parallel: 20 pixels a unit.
    fn seen(centers: &[DVec3]) -> (StoreData, Vec<[Link; 4]>) {
        let squares = centers.iter().map(|&c| samples::moved(samples::square(1.0, 0.0), c)).collect();
        let scene = samples::parts(squares).finish().unwrap();
        let camera = Camera {
            position: DVec3::new(0.0, 0.0, 10.0),
            focal_point: DVec3::ZERO,
            view_up: DVec3::Y,
            projection: crate::math::Projection::Orthographic { height: 3.0 },
        };
        let store = StoreData::from_layers(&rasterize(&scene, &camera, SIZE, DVec2::ZERO));
        let view = View::new(&camera, SIZE, DVec2::ZERO);
        let how = (DepthTerm::Continuity, true);
        let links = continuity::neighbours_by(&store, &Extents::new(&scene, &camera), &view, how).links;
        (store, links)
    }

    /// The near square ends at x = 0.02 and the far one at y = 0.03: they cross at one place. Where their other edges cross is
    /// too near to the image's.
    #[test]
    fn the_crossing_of_two_edges_is_found_where_it_is() {
        let (store, links) = seen(&[DVec3::new(-0.98, 0.0, 1.0), DVec3::new(-0.4, -0.97, 0.0)]);
        let (found, tried) = find(&store, &links, 1);
        assert_eq!(found.len(), 1, "{found:?}, {tried} cracks");
        let exact = DVec2::new(30.0 + 0.02 * 20.0, 30.0 - 0.03 * 20.0);
        assert!(found[0].place.distance(exact) < 0.75, "{:?}", found[0]);
        assert!(found[0].outward.distance(DVec2::X) < 0.1 && found[0].outward_behind.distance(DVec2::NEG_Y) < 0.1);
        // To either side of the far edge: three places on the near square and three beyond it.
        for crossing in found[0].crossings() {
            for (side, places) in crossing.iter().enumerate() {
                assert!(places.iter().all(|p| (p.x > exact.x) == (side == 1)), "{crossing:?}");
            }
            assert!((crossing[0][0].y - exact.y).abs() > 3.0);
        }
    }

    #[test]
    fn parallel_edges_and_crowded_places_are_none() {
        let none = |centers: &[DVec3]| {
            let (store, links) = seen(centers);
            assert_eq!(find(&store, &links, 1).0, Vec::new());
        };
        none(&[DVec3::new(-0.98, 0.0, 1.0), DVec3::new(-0.9, 0.0, 0.0)]);
        none(&[DVec3::new(-0.98, 0.0, 1.0)]);
        // A third square ends between the two, three pixels from where they cross.
        none(&[DVec3::new(-0.98, 0.0, 1.0), DVec3::new(-0.4, -0.97, 0.0), DVec3::new(1.17, -0.6, 0.5)]);
    }

    #[test]
    fn what_lies_in_front_occludes_and_what_lies_behind_does_not() {
        // The same with the depths exchanged: the edges change their roles.
        let (store, links) = seen(&[DVec3::new(-0.98, 0.0, 0.0), DVec3::new(-0.4, -0.97, 1.0)]);
        let (found, _) = find(&store, &links, 1);
        assert_eq!(found.len(), 1);
        assert!(found[0].outward.distance(DVec2::NEG_Y) < 0.1);
    }
}
