// Part column.

@group(1) @binding(7) var<storage, read_write> parts: array<u32>;
