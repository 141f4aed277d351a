//@ use passes/features/neighbour_epsilon
//@ use store/links
//@ use store/candidates
// Second half of the neighbour search as printed (Carnecky 2013, Algorithm 2, lines 11 to 17): a candidate is a neighbour
// unless it suits another layer of the seeking pixel better. By a measure that is not the same both ways this makes links
// that have no way back (T13).

fn checked(x: u32, y: u32, direction: u32, candidate: u32, adjacent: Adjacent, layer: u32) -> u32 {
    if candidate >= UNKNOWN {
        return candidate;
    }
    let pixel = (y - frame.first_row) * frame.size.x + x;
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    let other = layer_shape(layer_base(adjacent.pixels[direction]) + candidate);
    let part = parts[base + layer];
    var own = 0.0;
    var least = 3.4e38;
    for (var rival = 0u; rival < count; rival++) {
        let shape = layer_shape(base + rival);
        let expected = expected_depths(x, y, shape.depth, shape.normal)[direction];
        let epsilon = neighbour_epsilon(shape.normal, expected, inverse_depth_unit(shape.depth, part), other, 0.0).x;
        if rival == layer {
            own = epsilon;
        }
        if parts[base + rival] == part {
            least = min(least, epsilon);
        }
    }
    return select(candidate, absent(adjacent.pixels[direction]), least < own);
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let y = id.y + frame.first_row;
    let base = layer_base(pixel);
    let begin = id.z * store_layout.chunk;
    let end = min(layer_count(pixel), begin + store_layout.chunk);
    let adjacent = adjacent_of(id.x, id.y);
    for (var layer = begin; layer < end; layer++) {
        let ahead = candidates_ahead[base + layer];
        let behind = candidates_behind[base + layer];
        let right = checked(id.x, y, 0u, ahead & 0xFFFFu, adjacent, layer);
        let below = checked(id.x, y, 2u, ahead >> 16u, adjacent, layer);
        links_ahead[base + layer] = right | (below << 16u);
        links_behind[base + layer] = vec2<u32>(
            checked(id.x, y, 1u, behind.x, adjacent, layer),
            checked(id.x, y, 3u, behind.y, adjacent, layer),
        );
    }
}
