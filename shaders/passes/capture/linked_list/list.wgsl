//@ use store/layout_compacted
//@ use passes/capture/statistics
// The list of a pixel, and where its layers go. Whoever walks a list takes as many steps as the pixel has layers, whatever the
// list says: a corrupt one cannot hold up the device (T17). What is then wrong is counted.

@group(1) @binding(2) var<storage, read_write> keys: array<vec2<u32>>;
// The depth word; the normal follows when surfaces are gathered.
@group(1) @binding(3) var<storage, read_write> shapes: array<ShapeWords>;
// Where the fragment of a layer lies.
@group(1) @binding(24) var<storage, read_write> sources: array<u32>;
@group(1) @binding(18) var<storage, read_write> list_heads: array<u32>;
@group(1) @binding(19) var<storage, read_write> list_next: array<u32>;
@group(1) @binding(20) var<storage, read_write> arrival_keys: array<vec2<u32>>;

const END: u32 = 0u;

fn is_place(link: u32) -> bool {
    return link != END && link <= arrayLength(&list_next);
}

fn place_layer(slot: u32, key: vec2<u32>, source: u32) {
    keys[slot] = key;
    shapes[slot].x = key.y;
    sources[slot] = source;
}

// A layer that the list does not have: behind all others, of no triangle.
fn place_nothing(slot: u32) {
    place_layer(slot, vec2<u32>(EMPTY), 0u);
    atomicAdd(&statistics[STAT_LOST], 1u);
}
