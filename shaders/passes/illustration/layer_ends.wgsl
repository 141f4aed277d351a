//@ use passes/illustration/layer_ends_bits
// Where each layer ends.

@group(1) @binding(32) var<storage, read_write> layer_ends: array<u32>;
