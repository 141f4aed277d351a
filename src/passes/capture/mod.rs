//! Stage 1, capture: the surface layers of every pixel, in depth order, with unlit surface inputs.

pub mod bucketed_k_buffer;
pub mod buckets;
pub mod cases;
pub mod compacted;
pub mod linked_list;
pub mod sort;

use serde::Serialize;

use crate::settings::{Axis, Effect, Knob};

/// Which technique captures.
pub const AXES: &[Axis] = &[Axis {
    name: "capture",
    knob: Knob::Setting("capture.kind"),
    values: &["compacted", "linked_list", "bucketed_k_buffer"],
    matters_if: &[],
    effect: Effect::Accuracy { exact: "compacted" },
}];

/// What a capture counted over the whole image. The books balance: `rasterized = stored + merged + dropped`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LayerCounts {
    /// Fragments that the geometry made.
    pub rasterized: u64,
    /// Layers in the store.
    pub stored: u64,
    /// Fragments that became one with another because their keys were equal (packed keys only).
    pub merged: u64,
    /// Fragments left out because the pixel was full.
    pub dropped: u64,
    /// Faults: fragments of the second geometry pass that no slot explains (T3). Always 0.
    pub lost: u64,
    /// Most fragments in one pixel.
    pub deepest: u64,
    /// Pixels with at least one fragment.
    pub covered: u64,
}

/// Words of the statistics buffer; the indices are those of `passes/capture/statistics.wgsl`.
pub const STATISTICS_WORDS: usize = 16;
/// The word that holds the most fragments of a pixel in the whole band, its apron included.
pub const BAND_DEEPEST: usize = 7;

impl LayerCounts {
    /// Adds what a band counted. `words` are the statistics buffer's.
    pub fn add_band(&mut self, words: &[u32]) {
        let at = |i: usize| u64::from(words.get(i).copied().unwrap_or(0));
        self.rasterized += at(0);
        self.stored += at(1);
        self.merged += at(2);
        self.dropped += at(3);
        self.lost += at(4);
        self.deepest = self.deepest.max(at(5));
        self.covered += at(6);
    }

    /// Whether every fragment is accounted for.
    pub fn balanced(&self) -> bool {
        self.rasterized == self.stored + self.merged + self.dropped && self.lost == 0
    }
}
