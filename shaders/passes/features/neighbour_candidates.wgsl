//@ use store/normals
//@ use store/links
//@ use store/part_column
//@ use store/part_table
// First half of the neighbour search: for each layer and direction, the layer of the same part in the adjacent pixel with
// the least epsilon = epsilon_n + epsilon_z (Murray 2016, section 5.1). Depth is in units of the part's radius, so that the
// choice depends neither on the unit of the file nor on other parts (T7). Equal epsilons: the nearer layer.

@group(1) @binding(8) var<storage, read_write> candidates: array<vec2<u32>>;

fn neighbour_epsilon(normal: vec3<f32>, depth: f32, slot: u32, inverse_radius: f32) -> f32 {
    let dz = (depth - layer_view_depth(slot)) * inverse_radius;
    return (1.0 - dot(normal, layer_normal(slot))) + dz * dz;
}

// What an adjacent pixel without a candidate means (T10).
fn absent(other: u32) -> u32 {
    return select(MISSING, UNKNOWN, overflowed(other));
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let rows = frame.end_row - frame.first_row;
    if id.x >= frame.size.x || id.y >= rows {
        return;
    }
    let width = frame.size.x;
    let pixel = id.y * width + id.x;
    let count = layer_count(pixel);
    if count == 0u {
        return;
    }
    let base = layer_base(pixel);
    let inside = vec4<bool>(id.x + 1u < width, id.x > 0u, id.y + 1u < rows, id.y > 0u);
    let others = vec4<u32>(pixel + 1u, pixel - 1u, pixel + width, pixel - width);
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        var found = vec4<u32>(UNKNOWN);
        if layer <= LARGEST_LINK {
            let part = parts[slot];
            let normal = layer_normal(slot);
            let depth = layer_view_depth(slot);
            let inverse_radius = part_table[part].inverse_radius;
            for (var direction = 0u; direction < 4u; direction++) {
                if inside[direction] {
                    let other = others[direction];
                    let best = best_candidate(other, part, normal, depth, inverse_radius);
                    found[direction] = select(best, absent(other), best == MISSING);
                }
            }
        }
        candidates[slot] = vec2<u32>(found.x | (found.y << 16u), found.z | (found.w << 16u));
    }
}
