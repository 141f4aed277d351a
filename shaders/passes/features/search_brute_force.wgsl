// Neighbour search as the baseline of Murray 2016, section 6: depth, normal and part of every layer of the neighbouring
// pixel are read, and a layer of another part is infinitely far.

fn best_candidate(other: u32, part: u32, normal: vec3<f32>, depth: f32, inverse_radius: f32) -> u32 {
    let base = layer_base(other);
    let count = min(layer_count(other), LARGEST_LINK);
    var best = MISSING;
    var best_epsilon = 3.4e38;
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let epsilon = neighbour_epsilon(normal, depth, slot, inverse_radius);
        if parts[slot] == part && epsilon < best_epsilon {
            best_epsilon = epsilon;
            best = layer;
        }
    }
    return best;
}
