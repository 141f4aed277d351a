// Two counters a pixel: fragments rasterized, and fragments that merged with an equal key (packed keys only).

@group(1) @binding(18) var<storage, read_write> tally: array<atomic<u32>>;
