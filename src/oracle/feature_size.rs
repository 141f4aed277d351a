//! Local feature size: how far a surface goes on from a fragment, from one end or occlusion to the next, along rows and along
//! columns. It makes the diffusion of illustrative transparency anisotropic (Carnecky 2013 leaves that as future work,
//! section 9): across what is narrow, little flows.
//!
//! # Choices
//! - A run ends where a neighbour is missing and where something in front begins or ends (a step of the layer index, T19), so
//!   that the room between two silhouettes counts, whichever surface they belong to. What is unknown ends nothing (T10).
//! - A chord is the fragment and the runs to both of its sides, along one axis; fragments of one run have one chord.
//! - Conductance of a link is the smaller chord of its two fragments along its axis, over the feature size, at most 1: the same
//!   from both sides, so that nothing is lost.

use super::ends::Surfaces;
use super::neighbours::{Direction, Link};

/// How many neighbours follow each other from a fragment on in each direction, at most `most`.
pub fn runs(surfaces: &Surfaces<'_>, most: u32) -> Vec<[u32; 4]> {
    let (store, links) = (surfaces.store, surfaces.links);
    let (width, height) = (store.width.max(1) as usize, store.height as usize);
    let run = |pixel: usize, index: usize, d: Direction| {
        let (mut pixel, mut index) = (pixel, index);
        for length in 0..most {
            let (under, beside) = surfaces.occlusion(pixel, index, d);
            match (links[store.offsets[pixel] + index][d as usize], d.step(pixel, width, height)) {
                (Link::Unknown, _) => return most,
                // Nor is it known how far a surface goes on beyond a seam.
                (Link::Missing, _) if surfaces.goes_on(store.offsets[pixel] + index, d) => return most,
                (Link::To(next), Some(q)) if !under && !beside => (pixel, index) = (q, next as usize),
                _ => return length,
            }
        }
        most
    };
    let pixels = store.pixel_of_fragment();
    let all = pixels.iter().enumerate();
    all.map(|(i, &pixel)| Direction::ALL.map(|d| run(pixel, i - store.offsets[pixel], d))).collect()
}

/// The smaller chord of the two fragments of each link along its axis, in pixels and at most `size`; `size` where there is no
/// link.
pub fn chords(around: &[[Option<usize>; 4]], surfaces: &Surfaces<'_>, size: u32) -> Vec<[u32; 4]> {
    let runs = runs(surfaces, size.saturating_sub(1));
    let chord = |i: usize, d: Direction| (runs[i][d as usize] + runs[i][d.opposite() as usize] + 1).min(size);
    let of = |(i, around): (usize, &[Option<usize>; 4])| {
        Direction::ALL.map(|d| around[d as usize].map_or(size, |j| chord(i, d).min(chord(j, d))))
    };
    around.iter().enumerate().map(of).collect()
}

/// How much flows through each link: chords over `size`; 1 everywhere for a size of 0, the paper's isotropic diffusion.
pub fn conductances(around: &[[Option<usize>; 4]], surfaces: &Surfaces<'_>, size: u32) -> Vec<[f64; 4]> {
    if size == 0 {
        return vec![[1.0; 4]; around.len()];
    }
    let chords = chords(around, surfaces, size);
    chords.into_iter().map(|c| c.map(|c| f64::from(c) / f64::from(size))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::ends::Ends;
    use crate::oracle::illustration::adjacency;
    use crate::oracle::store::StoreData;

    /// Every missing neighbour ends the surface openly.
    fn all_open(links: &[[Link; 4]]) -> Ends {
        let open: Vec<_> = links.iter().map(|l| l.map(|l| l == Link::Missing)).collect();
        Ends { surface: open.clone(), behind: vec![[false; 4]; open.len()], open }
    }

    /// A strip of five pixels that ends at both sides, and one that goes on beyond the image on its right.
    #[test]
    fn runs_and_chords_by_hand() {
        let mut store = StoreData { width: 5, height: 2, ..StoreData::default() };
        let end = Link::Missing;
        let mut links = Vec::new();
        for y in 0..2 {
            for x in 0..5 {
                store.offsets.push(store.depth.len());
                store.counts.push(1);
                store.overflowed.push(false);
                store.depth.push(1.0);
                let beyond = if y == 0 { end } else { Link::Unknown };
                let right = if x < 4 { Link::To(0) } else { beyond };
                links.push([right, if x > 0 { Link::To(0) } else { end }, end, end]);
            }
        }
        // All of one part.
        store.part = vec![0; 10];
        let ends = all_open(&links);
        let surfaces = Surfaces { store: &store, links: &links, ends: &ends, bare: false };
        let found = runs(&surfaces, 19);
        assert_eq!(found[0], [4, 0, 0, 0]);
        assert_eq!(found[3], [1, 3, 0, 0]);
        assert_eq!(found[5..].iter().map(|r| r[0]).collect::<Vec<_>>(), [19; 5], "unknown ends nothing");
        assert_eq!(runs(&surfaces, 2)[0][0], 2);
        let around = adjacency(&store, &links);
        let c = chords(&around, &surfaces, 20);
        assert!(c[..5].iter().all(|c| c[0] == if c[0] == 20 { 20 } else { 5 }) && c[2] == [5, 5, 20, 20]);
        assert_eq!(c[7], [20; 4], "a chord as long as the size or longer limits nothing");
        let g = conductances(&around, &surfaces, 20);
        assert_eq!(g[1], [0.25, 0.25, 1.0, 1.0]);
        assert_eq!(conductances(&around, &surfaces, 0)[1], [1.0; 4]);
    }

    /// Before the right half of a sheet another begins: the far sheet's runs end there on both sides, the near one's does not
    /// go on to the left.
    #[test]
    fn what_begins_in_front_ends_a_run() {
        let store = StoreData {
            width: 4,
            height: 1,
            counts: vec![1, 1, 2, 2],
            overflowed: vec![false; 4],
            offsets: vec![0, 1, 2, 4],
            depth: vec![2.0, 2.0, 1.0, 2.0, 1.0, 2.0],
            part: vec![0; 6],
            ..StoreData::default()
        };
        let to = |l| Link::To(l);
        let (end, far) = (Link::Missing, Link::Unknown);
        let links = [
            [to(0), end, far, far],
            [to(1), to(0), far, far],
            [to(0), end, far, far],
            [to(1), to(0), far, far],
            [end, to(0), far, far],
            [end, to(1), far, far],
        ];
        let ends = all_open(&links);
        let surfaces = Surfaces { store: &store, links: &links, ends: &ends, bare: false };
        let runs = runs(&surfaces, 9);
        assert_eq!(
            runs.iter().map(|r| [r[0], r[1]]).collect::<Vec<_>>(),
            [[1, 0], [0, 1], [1, 0], [1, 0], [0, 1], [0, 1]]
        );
        let c = chords(&adjacency(&store, &links), &surfaces, 8);
        assert_eq!((c[1][0], c[3][1]), (2, 2), "the link under the edge");
    }
}
