//@ use passes/features/neighbour_epsilon
//@ use store/links
//@ use store/candidates
// First half of the neighbour search as the baseline of Murray 2016, section 6: depth, normal and part of every layer of the
// neighbouring pixel are read, and a layer of another part is infinitely far. Same answer as by buckets.

struct Seeker {
    x: u32,
    y: u32,
    part: u32,
    depth: f32,
    normal: vec3<f32>,
    inverse_unit: f32,
    // The depth that the surface is expected to have in each adjacent pixel.
    expected: vec4<f32>,
}

// The layer with the least epsilon; of equals the nearer.
fn best_candidate(adjacent: Adjacent, direction: u32, own: u32, seeker: Seeker) -> u32 {
    if !adjacent.inside[direction] {
        return UNKNOWN;
    }
    let other = adjacent.pixels[direction];
    let base = layer_base(other);
    let count = layer_count(other);
    var best = absent(other);
    var least = 3.4e38;
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let shape = layer_shape(slot);
        let back = difference_back(seeker.x, seeker.y, direction, seeker.depth, seeker.part, shape);
        let continuity = neighbour_epsilon(seeker.normal, seeker.expected[direction], seeker.inverse_unit, shape, back).x;
        let epsilon = judged(own, slot, direction, continuity);
        if parts[slot] == seeker.part && epsilon < least {
            least = epsilon;
            best = layer;
        }
    }
    return best;
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let begin = id.z * store_layout.chunk;
    let end = min(layer_count(pixel), begin + store_layout.chunk);
    let adjacent = adjacent_of(id.x, id.y);
    for (var layer = begin; layer < end; layer++) {
        let slot = base + layer;
        let part = parts[slot];
        let shape = layer_shape(slot);
        let y = id.y + frame.first_row;
        let expected = expected_depths(id.x, y, shape.depth, shape.normal);
        let seeker = Seeker(id.x, y, part, shape.depth, shape.normal, inverse_depth_unit(shape.depth, part), expected);
        let right = best_candidate(adjacent, 0u, slot, seeker);
        let below = best_candidate(adjacent, 2u, slot, seeker);
        candidates_ahead[slot] = right | (below << 16u);
        candidates_behind[slot] = vec2<u32>(
            best_candidate(adjacent, 1u, slot, seeker),
            best_candidate(adjacent, 3u, slot, seeker),
        );
    }
}
