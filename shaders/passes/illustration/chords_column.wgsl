// For each layer the chord of its four links, 8 bits each: right, left, down, up. How long the surface is along the link's axis,
// in pixels, at most the feature size.

@group(1) @binding(29) var<storage, read_write> chords: array<u32>;
