//@ use store/buckets
// Neighbour search by buckets (Murray 2016, section 5.1): only the layers of the same part are read.

// Best layer of `part` in the pixel `other` for a fragment, or MISSING.
fn best_candidate(other: u32, part: u32, normal: vec3<f32>, depth: f32, inverse_radius: f32) -> u32 {
    let range = find_bucket(other, part);
    let base = layer_base(other);
    var best = MISSING;
    var best_epsilon = 3.4e38;
    for (var position = range.x; position < range.y; position++) {
        let layer = by_part[base + position];
        let epsilon = neighbour_epsilon(normal, depth, base + layer, inverse_radius);
        if epsilon < best_epsilon {
            best_epsilon = epsilon;
            best = layer;
        }
    }
    return best;
}
