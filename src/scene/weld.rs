//! Welding: which elements of a list are bit for bit the same.
//!
//! Triangles without shared indices, normals of vertices that a seam splits and connected components all ask it of millions
//! of vertices. A hash table over all of them misses the cache at every step, so keys are dealt into buckets by their hash,
//! each bucket has a table that fits the cache, and buckets are worked off in parallel. The answer depends on neither the
//! number of buckets nor of threads: an element is the same as the **first** one that has its key, and the different ones are
//! numbered in order of appearance.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;
use rustc_hash::FxBuildHasher;

/// Elements that one thread hashes at a time.
const CHUNK: usize = 1 << 16;
/// A power of two.
const BUCKETS: usize = 256;
/// Below this many elements one table does.
const SMALL: usize = 1 << 14;

/// Elements with their keys.
type Bucket<const N: usize> = Vec<(u32, [u32; N])>;

/// What [`weld`] found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Welded {
    /// For every element the number of its key; keys are numbered in order of appearance.
    pub ids: Vec<u32>,
    /// For every key the first element that has it, ascending.
    pub firsts: Vec<u32>,
}

/// Finds the elements among `0..count` that have the same key. `count` is less than `u32::MAX`; what is beyond is left out.
pub fn weld<const N: usize>(count: usize, key: impl Fn(usize) -> [u32; N] + Sync) -> Welded {
    let count = count.min(u32::MAX as usize - 1);
    if count < SMALL {
        let mut numbers: HashMap<[u32; N], u32, FxBuildHasher> =
            HashMap::with_capacity_and_hasher(count, FxBuildHasher);
        let mut welded = Welded::default();
        for i in 0..count {
            let next = welded.firsts.len() as u32;
            let id = *numbers.entry(key(i)).or_insert(next);
            if id == next {
                welded.firsts.push(i as u32);
            }
            welded.ids.push(id);
        }
        return welded;
    }
    // The elements of every bucket with their keys, chunk by chunk, so that those of a bucket are in order. Keys are copied
    // because looking them up where they are would miss the cache each time.
    let dealt: Vec<Vec<Bucket<N>>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut buckets: Vec<Bucket<N>> =
                (0..BUCKETS).map(|_| Vec::with_capacity(CHUNK / BUCKETS * 5 / 4)).collect();
            for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let key = key(i);
                buckets[hash(key) as usize % BUCKETS].push((i as u32, key));
            }
            buckets
        })
        .collect();
    // The first element with the same key.
    let same: Vec<AtomicU32> = (0..count).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    (0..BUCKETS).into_par_iter().for_each(|bucket| {
        let size = dealt.iter().map(|chunk| chunk[bucket].len()).sum::<usize>();
        let mut firsts: Vec<(u32, [u32; N])> = Vec::new();
        // Open addressing; an entry is a place in `firsts`, `u32::MAX` is none.
        let mask = (2 * size).next_power_of_two().max(2) - 1;
        let mut table = vec![u32::MAX; mask + 1];
        for &(i, key) in dealt.iter().flat_map(|chunk| &chunk[bucket]) {
            let mut at = (hash(key) >> 32) as usize & mask;
            let first = loop {
                let Some(&(first, other)) = firsts.get(table[at] as usize) else {
                    table[at] = firsts.len() as u32;
                    firsts.push((i, key));
                    break i;
                };
                if other == key {
                    break first;
                }
                at = (at + 1) & mask;
            };
            same[i as usize].store(first, Relaxed);
        }
    });
    drop(dealt);
    let mut welded = Welded { ids: Vec::with_capacity(count), firsts: Vec::new() };
    for (i, first) in same.iter().enumerate() {
        let first = first.load(Relaxed) as usize;
        if first == i {
            welded.ids.push(welded.firsts.len() as u32);
            welded.firsts.push(i as u32);
        } else {
            welded.ids.push(welded.ids[first]);
        }
    }
    welded
}

/// Welds positions; −0 is +0.
pub fn weld_positions(positions: &[[f32; 3]]) -> Welded {
    weld(positions.len(), |i| bits(positions[i]))
}

/// The bits of a position or normal, with −0 and +0 the same.
pub fn bits<const N: usize>(values: [f32; N]) -> [u32; N] {
    values.map(|c| if c == 0.0 { 0 } else { c.to_bits() })
}

/// Both halves of the result depend on all bits of the key.
fn hash<const N: usize>(key: [u32; N]) -> u64 {
    let mut h = 0x9E37_79B9_7F4A_7C15_u64;
    for word in key {
        h = (h ^ u64::from(word)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        h ^= h >> 32;
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_and_few_are_welded_alike_and_numbered_as_they_appear() {
        for count in [0, 1, SMALL - 1, SMALL, 3 * CHUNK + 7] {
            let key = |i: usize| [(i * 7919 % 1000) as u32, (i % 3) as u32];
            let welded = weld(count, key);
            let mut numbers = HashMap::new();
            for i in 0..count {
                let next = numbers.len() as u32;
                assert_eq!(welded.ids[i], *numbers.entry(key(i)).or_insert(next), "{count}: {i}");
            }
            assert_eq!(welded.firsts.len(), numbers.len());
            assert!(welded.firsts.iter().enumerate().all(|(id, &f)| welded.ids[f as usize] == id as u32));
            assert!(welded.firsts.is_sorted());
        }
    }

    #[test]
    fn zeros_are_one_and_all_the_same_is_one() {
        let welded = weld_positions(&[[0.0, -0.0, 1.0], [-0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]);
        assert_eq!(welded.ids, [0, 0, 1]);
        assert_eq!(weld(5 * CHUNK, |_| [1, 2, 3]).firsts, [0]);
    }
}
