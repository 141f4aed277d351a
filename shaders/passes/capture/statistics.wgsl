// What a capture counts; read back after the frame. Indices are shared with Rust (passes/capture/mod.rs).

const STAT_RASTERIZED: u32 = 0u;
const STAT_STORED: u32 = 1u;
const STAT_MERGED: u32 = 2u;
const STAT_DROPPED: u32 = 3u;
const STAT_LOST: u32 = 4u;
const STAT_DEEPEST: u32 = 5u;
const STAT_COVERED: u32 = 6u;
// Of the whole band with its apron.
const STAT_BAND_DEEPEST: u32 = 7u;

@group(1) @binding(17) var<storage, read_write> statistics: array<atomic<u32>>;
