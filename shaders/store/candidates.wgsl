// Candidates for neighbours, right, left, down, up: as links, but each found by the layer itself.

@group(1) @binding(14) var<storage, read_write> candidates_ahead: array<u32>;
@group(1) @binding(15) var<storage, read_write> candidates_behind: array<vec2<u32>>;
