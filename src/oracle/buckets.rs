//! The Bucketed k-Buffer of one pixel, literally the four steps of Murray, Baril and Granier 2016 (section 4.1).
//!
//! 1. **Z insertion**: every fragment's key is inserted into a sorted list of k; what falls off the end is gone.
//! 2. **Z reordering**: the same keys sorted by shape, then by depth.
//! 3. **Bucket creation**: a hash table of k entries (shape, first, last) with `H(b) = b mod k`; if the entry is taken, b
//!    is incremented until a free one is found.
//! 4. **Data storage**: every fragment looks its shape up by the same probing, then its key by binary search inside the
//!    bucket, and stores its data there; if either search fails it is rejected.
//!
//! Generic over the key. [`PackedKey`] is the paper's: 16 bits of depth over 16 of shape. Two fragments with equal keys
//! get two places in Z, but step 4 finds the first of them for both (T1): one fragment is lost and one place is never
//! written. [`WideKey`] has the instanced-triangle number below 32 bits of depth, so no two keys are equal.
//!
//! The **books** balance: rasterized = stored + merged + dropped. They are kept in step 4: *stored* is the first to reach
//! its place, *merged* finds the place taken, *dropped* is rejected. None of the three depends on the draw order (which of
//! two merged fragments survives does: [`BucketedPixel::slots`] lists them all).
//!
//! # Choices
//! - The search of step 4 ends after k probes, also when the table is full and the shape absent (T6); it ends early at a
//!   free entry.
//! - A pixel has *overflowed* if more than k fragments were rasterized, that is, if step 1 pushed a key off the end.
//! - A packed depth is `round(t · 65534)` for t in [0, 1] from near to far, so that no legal key is all ones (T4).

use crate::settings::DepthQuantization;

/// A key of step 1: ordered by depth.
pub trait Key: Copy + Ord {
    /// The same information with the shape in the most significant place (step 2).
    type ByShape: Ord;

    /// The shape that the fragment belongs to.
    fn shape(self) -> u32;

    /// The key of step 2.
    fn by_shape(self) -> Self::ByShape;
}

/// 32-bit depth over the instanced-triangle number. The part follows from the triangle and is carried along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct WideKey {
    /// Depth half, smaller is nearer.
    pub depth: u32,
    /// Instanced-triangle number.
    pub triangle: u32,
    /// The part that has this triangle.
    pub part: u32,
}

impl Key for WideKey {
    type ByShape = (u32, u32, u32);

    fn shape(self) -> u32 {
        self.part
    }

    fn by_shape(self) -> (u32, u32, u32) {
        (self.part, self.depth, self.triangle)
    }
}

/// The paper's key: 16-bit depth over 16-bit shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PackedKey(pub u32);

impl PackedKey {
    /// Packs a quantized depth and a shape.
    pub fn new(depth: u16, shape: u16) -> PackedKey {
        PackedKey(u32::from(depth) << 16 | u32::from(shape))
    }
}

impl Key for PackedKey {
    type ByShape = u32;

    fn shape(self) -> u32 {
        self.0 & 0xFFFF
    }

    fn by_shape(self) -> u32 {
        self.0.rotate_left(16)
    }
}

/// The 16 bits that stand for a depth between `near` and `far` (scene units, clamped).
pub fn quantize_depth(quantization: DepthQuantization, depth: f64, near: f64, far: f64) -> u16 {
    let t = match quantization {
        DepthQuantization::Linear => (depth - near) / (far - near),
        DepthQuantization::ZOverW => far * (depth - near) / (depth * (far - near)),
        DepthQuantization::Reversed => 1.0 - near / depth,
    };
    // NaN, from an empty range, becomes 0.
    (t.clamp(0.0, 1.0) * 65534.0).round() as u16
}

/// An entry of the hash table: fragments `first ..= last` of the reordered list belong to `shape`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bucket {
    /// Shape id.
    pub shape: u32,
    /// Index of the nearest fragment.
    pub first: usize,
    /// Index of the farthest fragment.
    pub last: usize,
}

/// What became of the fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Books {
    /// Fragments that came.
    pub rasterized: u64,
    /// Fragments that have a place of their own.
    pub stored: u64,
    /// Fragments whose place was taken by one with an equal key.
    pub merged: u64,
    /// Fragments that were rejected: k nearer ones came.
    pub dropped: u64,
}

impl Books {
    /// Whether nothing is unaccounted for.
    pub fn balance(&self) -> bool {
        self.rasterized == self.stored + self.merged + self.dropped
    }
}

/// All that the four steps leave of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct BucketedPixel<K> {
    /// Step 1: the nearest keys by depth, at most k.
    pub nearest: Vec<K>,
    /// Step 2: the same keys by shape, then depth.
    pub reordered: Vec<K>,
    /// Step 3: the hash table, k entries.
    pub table: Vec<Option<Bucket>>,
    /// Step 4: for each key of `reordered`, which input fragments (by index) found it.
    pub slots: Vec<Vec<usize>>,
    /// What became of the fragments.
    pub books: Books,
    /// Whether fragments fell off the end of the list.
    pub overflowed: bool,
}

/// Runs the four steps for the fragments of one pixel, given by their keys in draw order.
pub fn bucket_k_buffer<K: Key>(fragments: &[K], k: usize) -> BucketedPixel<K> {
    let nearest = insert(fragments, k);
    let reordered = reorder(&nearest);
    let table = create_buckets(&reordered, k);
    let mut slots = vec![Vec::new(); reordered.len()];
    let mut books = Books { rasterized: fragments.len() as u64, ..Books::default() };
    for (index, &key) in fragments.iter().enumerate() {
        match find_slot(&table, &reordered, key) {
            None => books.dropped += 1,
            Some(slot) => {
                if slots[slot].is_empty() {
                    books.stored += 1;
                } else {
                    books.merged += 1;
                }
                slots[slot].push(index);
            }
        }
    }
    BucketedPixel { nearest, reordered, table, slots, books, overflowed: fragments.len() > k }
}

/// Step 1. As the atomic minimum does it: the smaller key stays, the larger one moves on to the next place.
fn insert<K: Key>(fragments: &[K], k: usize) -> Vec<K> {
    let mut places: Vec<Option<K>> = vec![None; k];
    for &fragment in fragments {
        let mut carried = fragment;
        for place in &mut places {
            match place {
                None => {
                    *place = Some(carried);
                    break;
                }
                Some(there) => {
                    let farther = carried.max(*there);
                    *there = carried.min(*there);
                    carried = farther;
                }
            }
        }
    }
    places.into_iter().flatten().collect()
}

/// Step 2.
fn reorder<K: Key>(nearest: &[K]) -> Vec<K> {
    let mut keys = nearest.to_vec();
    keys.sort_by_key(|key| key.by_shape());
    keys
}

/// Step 3.
fn create_buckets<K: Key>(reordered: &[K], k: usize) -> Vec<Option<Bucket>> {
    let mut table = vec![None; k];
    let mut first = 0;
    for run in reordered.chunk_by(|a, b| a.shape() == b.shape()) {
        let bucket = Bucket { shape: run[0].shape(), first, last: first + run.len() - 1 };
        let home = bucket.shape as usize % k;
        // There are at most k buckets, so one of the k entries is free.
        if let Some(free) = (0..k).map(|step| (home + step) % k).find(|&entry| table[entry].is_none()) {
            table[free] = Some(bucket);
        }
        first += run.len();
    }
    table
}

/// The bucket of a shape: first half of step 4, and of the neighbour search.
pub fn find_bucket(table: &[Option<Bucket>], shape: u32) -> Option<Bucket> {
    let k = table.len();
    for step in 0..k {
        let bucket = table[(shape as usize % k + step) % k]?;
        if bucket.shape == shape {
            return Some(bucket);
        }
    }
    None
}

/// The place of a key: second half of step 4, the first of equal ones.
fn find_slot<K: Key>(table: &[Option<Bucket>], reordered: &[K], key: K) -> Option<usize> {
    let bucket = find_bucket(table, key.shape())?;
    let (mut low, mut high) = (bucket.first, bucket.last + 1);
    while low < high {
        let middle = (low + high) / 2;
        if reordered[middle] < key {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    (low <= bucket.last && reordered[low] == key).then_some(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packed(pairs: &[(u16, u16)]) -> Vec<PackedKey> {
        pairs.iter().map(|&(depth, shape)| PackedKey::new(depth, shape)).collect()
    }

    #[test]
    fn four_steps_by_hand_with_a_probe_that_wraps_around() {
        // k = 4. Shapes 3, 7 and 11 all have their home at entry 3.
        let fragments = packed(&[(50, 11), (10, 7), (30, 3), (20, 7), (60, 3)]);
        let pixel = bucket_k_buffer(&fragments, 4);
        assert_eq!(pixel.nearest, packed(&[(10, 7), (20, 7), (30, 3), (50, 11)]));
        assert_eq!(pixel.reordered, packed(&[(30, 3), (10, 7), (20, 7), (50, 11)]));
        assert_eq!(
            pixel.table,
            [
                Some(Bucket { shape: 7, first: 1, last: 2 }),
                Some(Bucket { shape: 11, first: 3, last: 3 }),
                None,
                Some(Bucket { shape: 3, first: 0, last: 0 }),
            ]
        );
        assert_eq!(pixel.slots, [vec![2], vec![1], vec![3], vec![0]]);
        assert_eq!(pixel.books, Books { rasterized: 5, stored: 4, merged: 0, dropped: 1 });
        assert!(pixel.overflowed && pixel.books.balance());
    }

    #[test]
    fn a_search_in_a_full_table_ends() {
        let pixel = bucket_k_buffer(&packed(&[(1, 0), (2, 1), (3, 2), (4, 3)]), 4);
        assert!(pixel.table.iter().all(Option::is_some));
        assert_eq!(find_bucket(&pixel.table, 6), None);
        assert_eq!(find_bucket(&pixel.table, 2), Some(Bucket { shape: 2, first: 2, last: 2 }));
        assert_eq!(find_bucket(&[], 2), None);
    }

    #[test]
    fn equal_packed_keys_lose_a_fragment_and_wide_ones_do_not() {
        let pixel = bucket_k_buffer(&packed(&[(5, 1), (5, 1), (9, 1)]), 4);
        assert_eq!(pixel.reordered.len(), 3);
        assert_eq!(pixel.slots, [vec![0, 1], vec![], vec![2]], "the second place is never written (T1)");
        assert_eq!(pixel.books, Books { rasterized: 3, stored: 2, merged: 1, dropped: 0 });
        let wide: Vec<WideKey> = [7, 8, 9].map(|triangle| WideKey { depth: 5, triangle, part: 1 }).to_vec();
        let pixel = bucket_k_buffer(&wide, 4);
        assert_eq!(pixel.books, Books { rasterized: 3, stored: 3, merged: 0, dropped: 0 });
    }

    #[test]
    fn the_result_does_not_depend_on_the_draw_order() {
        // A small linear congruential generator: many pixels, few depths, so that there are ties and overflow.
        let mut state = 1_u32;
        let mut random = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        for round in 0..200 {
            let k = 1 + random(8) as usize;
            let fragments: Vec<PackedKey> =
                (0..random(16)).map(|_| PackedKey::new(random(5) as u16, random(20) as u16)).collect();
            let mut reversed = fragments.clone();
            reversed.reverse();
            let (a, b) = (bucket_k_buffer(&fragments, k), bucket_k_buffer(&reversed, k));
            assert_eq!((&a.nearest, &a.reordered, &a.table, a.books), (&b.nearest, &b.reordered, &b.table, b.books));
            assert!(a.books.balance(), "round {round}: {:?}", a.books);
            let mut sorted = fragments.clone();
            sorted.sort();
            sorted.truncate(k);
            assert_eq!(a.nearest, sorted, "the k nearest");
            for bucket in a.table.iter().flatten() {
                assert_eq!(find_bucket(&a.table, bucket.shape), Some(*bucket));
            }
        }
    }

    #[test]
    fn no_layers_at_all() {
        let pixel = bucket_k_buffer(&packed(&[(1, 1)]), 0);
        assert_eq!(pixel.books, Books { rasterized: 1, stored: 0, merged: 0, dropped: 1 });
        assert!(bucket_k_buffer::<WideKey>(&[], 3).table.iter().all(Option::is_none));
    }

    #[test]
    fn quantized_depths_span_their_range_and_never_reach_the_empty_key() {
        for quantization in [DepthQuantization::Linear, DepthQuantization::ZOverW, DepthQuantization::Reversed] {
            assert_eq!(quantize_depth(quantization, 0.1, 0.1, 1000.0), 0);
            assert!(quantize_depth(quantization, 5000.0, 0.1, 1000.0) <= 65534);
            assert!(quantize_depth(quantization, 1.0, 0.1, 9.0) < quantize_depth(quantization, 2.0, 0.1, 9.0));
        }
        // At depth 900 of 0.1 to 1000, one step of z/w is about 100 units wide (T2).
        let z = |d| quantize_depth(DepthQuantization::ZOverW, d, 0.1, 1000.0);
        assert!(z(990.0) - z(900.0) <= 1);
        assert_eq!(quantize_depth(DepthQuantization::Linear, 1.0, 1.0, 1.0), 0);
    }
}
