//@ use store/links
//@ use store/candidates
// Second half of the neighbour search, the reverse check (Murray 2016, Figure 5): a candidate is a neighbour only if it
// sees the layer as its own candidate.

fn candidate_of(slot: u32, direction: u32) -> u32 {
    switch direction {
        case 0u: { return candidates_ahead[slot] & 0xFFFFu; }
        case 1u: { return candidates_behind[slot].x; }
        case 2u: { return candidates_ahead[slot] >> 16u; }
        default: { return candidates_behind[slot].y; }
    }
}

fn checked(candidate: u32, other: u32, opposite: u32, layer: u32) -> u32 {
    if candidate >= UNKNOWN {
        return candidate;
    }
    return select(absent(other), candidate, candidate_of(layer_base(other) + candidate, opposite) == layer);
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let width = frame.size.x;
    let pixel = pixel_at(id.xy);
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let ahead = candidates_ahead[slot];
        let behind = candidates_behind[slot];
        let right = checked(ahead & 0xFFFFu, pixel + 1u, 1u, layer);
        let below = checked(ahead >> 16u, pixel + width, 3u, layer);
        links_ahead[slot] = right | (below << 16u);
        links_behind[slot] = vec2<u32>(
            checked(behind.x, pixel - 1u, 0u, layer),
            checked(behind.y, pixel - width, 2u, layer),
        );
    }
}
