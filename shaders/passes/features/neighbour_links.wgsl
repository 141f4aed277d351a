//@ use store/links
// Second half of the neighbour search, the reverse check (Murray 2016, Figure 5): a candidate is a neighbour only if it
// sees the layer as its own candidate.

@group(1) @binding(8) var<storage, read_write> candidates: array<vec2<u32>>;
@group(1) @binding(9) var<storage, read_write> links: array<vec2<u32>>;

fn checked(candidate: u32, other: u32, opposite: u32, layer: u32) -> u32 {
    if candidate >= UNKNOWN {
        return candidate;
    }
    if link_in(candidates[layer_base(other) + candidate], opposite) == layer {
        return candidate;
    }
    return select(MISSING, UNKNOWN, overflowed(other));
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let width = frame.size.x;
    let pixel = id.y * width + id.x;
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    for (var layer = 0u; layer < count; layer++) {
        let words = candidates[base + layer];
        let right = checked(words.x & 0xFFFFu, pixel + 1u, 1u, layer);
        let left = checked(words.x >> 16u, pixel - 1u, 0u, layer);
        let down = checked(words.y & 0xFFFFu, pixel + width, 3u, layer);
        let up = checked(words.y >> 16u, pixel - width, 2u, layer);
        links[base + layer] = vec2<u32>(right | (left << 16u), down | (up << 16u));
    }
}
