// Layers listed for a dispatch over just those: in the neighbour search those whose links are still open, later those that lack a
// neighbour (passes/illustration/lacking). At most one entry a layer.

// x: pixel; y: position in by_part * 4, and the axes that are open: 1 right, 2 below; later the layer index * 4.
@group(1) @binding(14) var<storage, read_write> open_layers: array<vec2<u32>>;
// How many there are.
@group(1) @binding(15) var<storage, read_write> open_count: array<atomic<u32>>;

// Stands for a link that is not known yet.
const OPEN: u32 = 0xFFFDu;

fn list_open(pixel: u32, position: u32, axes: u32) {
    open_layers[atomicAdd(&open_count[0], 1u)] = vec2<u32>(pixel, (position << 2u) | axes);
}
