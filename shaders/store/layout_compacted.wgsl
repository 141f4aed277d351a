//@ use common/frame
// FragmentStore without gaps: a pixel's layers begin at its offset and end at the next pixel's.

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
    return pixel_table[pixel];
}

// Offsets beyond the capacity mean that the buffers were too small: the frame is then drawn again with larger ones, and
// until then nothing may be read past the end.
fn layer_count(pixel: u32) -> u32 {
    return min(pixel_table[pixel + 1u], store_layout.capacity) - min(pixel_table[pixel], store_layout.capacity);
}

// Layers of all pixels.
fn layers_in_store() -> u32 {
    return min(pixel_table[pixels_in_store()], store_layout.capacity);
}

fn overflowed(pixel: u32) -> bool {
    return false;
}

fn bucket_slots(pixel: u32) -> u32 {
    return layer_count(pixel);
}
