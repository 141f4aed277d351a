//! Linked lists of fragments (Carnecky 2013, sections 4.1 to 4.3): filling, walking, and the paper's selection sort.
//!
//! # Choices
//! Places are counted from 1 in heads and links; 0 ends a list, so that cleared memory is an empty list. A walk takes at most
//! as many steps as its caller allows and stops at a place that does not exist: a corrupt list ends (T17).

/// The lists of all pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists<K> {
    /// The place of each pixel's last fragment, or 0.
    pub heads: Vec<u32>,
    /// Fragments of each pixel, those without room included.
    pub counts: Vec<u32>,
    /// For each place the place of the fragment that the pixel had before, or 0.
    pub next: Vec<u32>,
    /// What lies in each place.
    pub keys: Vec<K>,
    /// Fragments that came.
    pub counted: u64,
}

impl<K: Ord + Copy> Lists<K> {
    /// Algorithm 1: links fragments (pixel, key), in the order in which they come, into room for `capacity`. What finds no
    /// room is counted.
    pub fn fill(pixels: usize, capacity: usize, fragments: &[(usize, K)]) -> Lists<K> {
        let (mut heads, mut counts) = (vec![0; pixels], vec![0; pixels]);
        let (mut next, mut keys) = (Vec::new(), Vec::new());
        for &(pixel, key) in fragments {
            counts[pixel] += 1;
            if next.len() < capacity {
                keys.push(key);
                next.push(std::mem::replace(&mut heads[pixel], keys.len() as u32));
            }
        }
        Lists { heads, counts, next, keys, counted: fragments.len() as u64 }
    }

    /// The places of a pixel's list, from its head on, at most `most`; and whether it ends there.
    pub fn walk(&self, pixel: usize, most: usize) -> (Vec<usize>, bool) {
        let mut places = Vec::new();
        let mut link = self.heads[pixel] as usize;
        while (1..=self.next.len()).contains(&link) && places.len() < most {
            places.push(link - 1);
            link = self.next[link - 1] as usize;
        }
        (places, link == 0)
    }

    /// Section 4.3: for every layer the nearest fragment behind the last one. What the list lacks of its count is left out.
    pub fn selection_sort(&self, pixel: usize) -> Vec<K> {
        let count = self.counts[pixel] as usize;
        let mut sorted: Vec<K> = Vec::new();
        for _ in 0..count {
            let (places, _) = self.walk(pixel, count);
            let behind = places.iter().map(|&p| self.keys[p]).filter(|key| sorted.last().is_none_or(|last| key > last));
            sorted.extend(behind.min());
        }
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels, five fragments, by hand.
    const FRAGMENTS: [(usize, u32); 5] = [(0, 30), (1, 7), (0, 10), (0, 20), (1, 5)];

    #[test]
    fn filling_by_hand() {
        let lists = Lists::fill(3, 5, &FRAGMENTS);
        assert_eq!(lists.heads, [4, 5, 0]);
        assert_eq!(lists.next, [0, 0, 1, 3, 2]);
        assert_eq!(lists.counts, [3, 2, 0]);
        assert_eq!(lists.walk(0, 9), (vec![3, 2, 0], true));
        assert_eq!(lists.walk(2, 9), (vec![], true));
        assert_eq!(lists.selection_sort(0), [10, 20, 30]);
        assert_eq!(lists.selection_sort(1), [5, 7]);
    }

    #[test]
    fn what_finds_no_room_is_counted_and_the_rest_stays_linked() {
        let lists = Lists::fill(2, 4, &FRAGMENTS);
        assert_eq!((lists.counted, lists.counts.clone()), (5, vec![3, 2]));
        assert_eq!(lists.heads, [4, 2], "the fifth fragment is not linked");
        assert_eq!(lists.selection_sort(1), [7]);
        assert_eq!(Lists::fill(2, 0, &FRAGMENTS).heads, [0, 0]);
    }

    #[test]
    fn a_cycle_and_a_wild_link_end() {
        let mut lists = Lists::fill(2, 5, &FRAGMENTS);
        lists.next[2] = 3;
        assert_eq!(lists.walk(0, 3), (vec![3, 2, 2], false));
        assert_eq!(lists.selection_sort(0), [10, 20], "one is lost, none is there twice");
        lists.next[2] = 99;
        assert_eq!(lists.walk(0, 3), (vec![3, 2], false));
    }

    #[test]
    fn the_order_of_arrival_does_not_matter() {
        let mut state = 7_u32;
        let mut random = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        for _ in 0..50 {
            let mut fragments: Vec<(usize, (u32, u32))> =
                (0..60).map(|triangle| (random(4) as usize, (random(5), triangle))).collect();
            let a = Lists::fill(4, 60, &fragments);
            fragments.reverse();
            let b = Lists::fill(4, 60, &fragments);
            for pixel in 0..4 {
                let sorted = a.selection_sort(pixel);
                assert_eq!(sorted, b.selection_sort(pixel));
                assert!(
                    sorted.is_sorted() && sorted.len() == a.counts[pixel] as usize,
                    "equal depths keep their order"
                );
            }
        }
    }
}
