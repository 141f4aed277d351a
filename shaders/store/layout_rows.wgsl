//@ use common/frame
// FragmentStore with a fixed row of k slots a pixel.

// Layers stored in the low bits; the highest bit says that layers were dropped.
@group(1) @binding(0) var<storage, read_write> pixel_table: array<u32>;

struct StoreLayout {
    // Slots a pixel, where rows have a fixed length.
    k: u32,
    // Slots in the whole store.
    capacity: u32,
    // Layers of a pixel that one invocation takes in passes that read lists of other pixels for each of them.
    chunk: u32,
    _pad: u32,
}
@group(1) @binding(1) var<uniform> store_layout: StoreLayout;

fn layer_base(pixel: u32) -> u32 {
    return pixel * store_layout.k;
}

fn layer_count(pixel: u32) -> u32 {
    return pixel_table[pixel] & 0x7FFFFFFFu;
}

fn overflowed(pixel: u32) -> bool {
    return (pixel_table[pixel] & 0x80000000u) != 0u;
}

// Slots of the pixel's bucket table. A pixel without layers has none: its table still holds another frame's.
fn bucket_slots(pixel: u32) -> u32 {
    return select(store_layout.k, 0u, layer_count(pixel) == 0u);
}
