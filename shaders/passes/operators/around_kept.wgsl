//@ use passes/operators/around_slots
// The neighbours of every layer are kept for operators that are repeated.

fn keep_pixel(count: u32) -> u32 {
    return list_pixel(count);
}

fn keep_around(place: u32, slot: u32, slots: vec4<u32>) {
    list_layer(place, slot);
    around_slots[slot] = slots;
}
