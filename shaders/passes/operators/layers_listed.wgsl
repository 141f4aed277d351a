//@ use passes/operators/steps
// Layers for operators that are repeated: rows have gaps, which cost as much as layers, so layers are listed, pixels in any order.

@group(1) @binding(27) var<storage, read_write> listed_slots: array<u32>;

// Makes room for the layers of a pixel; gives the place of the first.
fn list_pixel(count: u32) -> u32 {
    if count == 0u {
        return 0u;
    }
    return atomicAdd(&steps[3], count);
}

fn list_layer(place: u32, slot: u32) {
    listed_slots[place] = slot;
}

fn layers_listed() -> u32 {
    return atomicLoad(&steps[3]);
}

fn listed_slot(place: u32) -> u32 {
    return listed_slots[place];
}
