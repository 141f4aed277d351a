//@ use passes/features/neighbour_epsilon
// First half of the neighbour search as the baseline of Murray 2016, section 6: depth, normal and part of every layer of the
// neighbouring pixel are read, and a layer of another part is infinitely far. Same answer as by buckets.

fn best_candidate(other: u32, direction: u32, part: u32, seeker: Seeker) -> u32 {
    let base = layer_base(other);
    let count = min(layer_count(other), LARGEST_LINK);
    var best = MISSING;
    var best_epsilon = 3.4e38;
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let epsilon = neighbour_epsilon(seeker, direction, slot).x;
        if parts[slot] == part && epsilon < best_epsilon {
            best_epsilon = epsilon;
            best = layer;
        }
    }
    return best;
}

fn candidate_in(adjacent: Adjacent, direction: u32, part: u32, seeker: Seeker) -> u32 {
    if !adjacent.inside[direction] {
        return UNKNOWN;
    }
    let other = adjacent.pixels[direction];
    let best = best_candidate(other, direction, part, seeker);
    return select(best, absent(other), best == MISSING);
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    let adjacent = adjacent_of(id.x, id.y);
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        var found = vec4<u32>(UNKNOWN);
        if layer < LARGEST_LINK {
            let part = parts[slot];
            let seeker = seeker_of(id.x, id.y, slot, part);
            found = vec4<u32>(
                candidate_in(adjacent, 0u, part, seeker),
                candidate_in(adjacent, 1u, part, seeker),
                candidate_in(adjacent, 2u, part, seeker),
                candidate_in(adjacent, 3u, part, seeker),
            );
        }
        store_candidates(slot, found);
    }
}
