// Layers for operators that are repeated: they lie without gaps, the n-th of all in slot n.

fn list_pixel(count: u32) -> u32 {
    return 0u;
}

fn list_layer(place: u32, slot: u32) {
}

fn layers_listed() -> u32 {
    return layers_in_store();
}

fn listed_slot(place: u32) -> u32 {
    return place;
}
