// The slots of a layer's neighbours, right, left, down, up, its own where there is none: found once, for operators that are
// repeated.

@group(1) @binding(25) var<storage, read_write> around_slots: array<vec4<u32>>;
