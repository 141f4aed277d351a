// What a global operator gathers from all layers, as counters that are 0 before it begins, and the table it makes of them.

const GATHERED: u32 = 256u;

@group(1) @binding(30) var<storage, read_write> gathered: array<atomic<u32>>;
@group(1) @binding(31) var<storage, read_write> settled: array<f32>;
