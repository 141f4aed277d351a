//@ use passes/features/neighbour_epsilon
//@ use store/buckets
//@ use store/links
// Neighbours by buckets (Murray 2016, section 5.1). A pixel pairs its layers with those of the pixel to the right and of the
// pixel below, part by part: only the bucket of the same part is read. Both pixels are searched at once, so the reverse check
// (Figure 5) needs no pass of its own and every bucket is read half as often.
//
// Four layers of a bucket are held against the four of the same rank in the other pixel, and the layers next to those four
// bound what all others could reach: buckets are in depth order, and epsilon is at least epsilon_z. Nearly always that
// decides. What it leaves open is searched in storage.

const NONE: u32 = 0xFFFFFFFFu;

struct Bucket {
    // The pixel's first slot.
    base: u32,
    // Positions in by_part.
    first: u32,
    end: u32,
}

// Up to four layers of a bucket, from a position on.
struct Four {
    bucket: Bucket,
    begin: u32,
    count: u32,
    layers: vec4<u32>,
    depths: vec4<f32>,
    normals_x: vec4<f32>,
    normals_y: vec4<f32>,
    normals_z: vec4<f32>,
    // Depths of the layers next to the four, where the bucket goes on.
    before: f32,
    after: f32,
}

fn load_layer(four: ptr<function, Four>, i: u32) {
    if i < (*four).count {
        let base = (*four).bucket.base;
        let layer = by_part[base + (*four).begin + i];
        let shape = layer_shape(base + layer);
        (*four).layers[i] = layer;
        (*four).depths[i] = shape.depth;
        (*four).normals_x[i] = shape.normal.x;
        (*four).normals_y[i] = shape.normal.y;
        (*four).normals_z[i] = shape.normal.z;
    }
}

fn four_at(bucket: Bucket, begin: u32, end: u32) -> Four {
    var four: Four;
    four.bucket = bucket;
    four.begin = begin;
    four.count = min(max(end, begin) - begin, 4u);
    four.depths = vec4<f32>(1.0);
    load_layer(&four, 0u);
    load_layer(&four, 1u);
    load_layer(&four, 2u);
    load_layer(&four, 3u);
    if begin > bucket.first {
        four.before = layer_view_depth(bucket.base + by_part[bucket.base + begin - 1u]);
    }
    if begin + four.count < bucket.end {
        four.after = layer_view_depth(bucket.base + by_part[bucket.base + begin + four.count]);
    }
    return four;
}

fn normal_of(four: Four, i: u32) -> vec3<f32> {
    return vec3<f32>(four.normals_x[i], four.normals_y[i], four.normals_z[i]);
}

// Where four layers expect their surface in an adjacent pixel, and one over the length that differences are measured in.
struct Expected {
    depths: vec4<f32>,
    inverse_units: vec4<f32>,
}

fn expected_in(four: Four, x: u32, y: u32, direction: u32, part: u32) -> Expected {
    return Expected(
        vec4<f32>(
            expected_depths(x, y, four.depths.x, normal_of(four, 0u))[direction],
            expected_depths(x, y, four.depths.y, normal_of(four, 1u))[direction],
            expected_depths(x, y, four.depths.z, normal_of(four, 2u))[direction],
            expected_depths(x, y, four.depths.w, normal_of(four, 3u))[direction],
        ),
        vec4<f32>(
            inverse_depth_unit(four.depths.x, part),
            inverse_depth_unit(four.depths.y, part),
            inverse_depth_unit(four.depths.z, part),
            inverse_depth_unit(four.depths.w, part),
        ),
    );
}

// As neighbour_epsilon, to four layers.
fn four_epsilons(normal: vec3<f32>, expected: f32, inverse_unit: f32, others: Four) -> vec4<f32> {
    let dz = (expected - others.depths) * inverse_unit;
    let x = normal.x - others.normals_x;
    let y = normal.y - others.normals_y;
    let z = normal.z - others.normals_z;
    return 0.5 * (x * x + y * y + z * z) + dz * dz;
}

// The best of the other four for each of four.
struct Choice {
    // 0 to 3, or 4 for none.
    index: vec4<u32>,
    epsilon: vec4<f32>,
}

// Of equals the nearer: the first.
fn choose(choice: ptr<function, Choice>, i: u32, epsilons: vec4<f32>, count: u32) {
    var best = 4u;
    var least = 3.4e38;
    if count > 0u && epsilons.x < least {
        best = 0u;
        least = epsilons.x;
    }
    if count > 1u && epsilons.y < least {
        best = 1u;
        least = epsilons.y;
    }
    if count > 2u && epsilons.z < least {
        best = 2u;
        least = epsilons.z;
    }
    if count > 3u && epsilons.w < least {
        best = 3u;
        least = epsilons.w;
    }
    (*choice).index[i] = best;
    (*choice).epsilon[i] = least;
}

fn choice_of(four: Four, expected: Expected, others: Four) -> Choice {
    var choice: Choice;
    let e = expected.depths;
    let u = expected.inverse_units;
    choose(&choice, 0u, four_epsilons(normal_of(four, 0u), e.x, u.x, others), others.count);
    choose(&choice, 1u, four_epsilons(normal_of(four, 1u), e.y, u.y, others), others.count);
    choose(&choice, 2u, four_epsilons(normal_of(four, 2u), e.z, u.z, others), others.count);
    choose(&choice, 3u, four_epsilons(normal_of(four, 3u), e.w, u.w, others), others.count);
    return choice;
}

// Whether no layer of the other bucket outside the four can be as good as the best of them.
fn is_decided(expected: Expected, choice: Choice, others: Four) -> vec4<bool> {
    let nothing_before = others.begin == others.bucket.first;
    let nothing_after = others.begin + others.count == others.bucket.end;
    let before = (expected.depths - others.before) * expected.inverse_units;
    let after = (expected.depths - others.after) * expected.inverse_units;
    let behind_all = vec4<f32>(others.before) <= expected.depths;
    let before_all = vec4<f32>(others.after) >= expected.depths;
    return (vec4<bool>(nothing_before) | (behind_all & (before * before > choice.epsilon)))
        & (vec4<bool>(nothing_after) | (before_all & (after * after > choice.epsilon)));
}

fn pick(v: vec4<u32>, i: u32) -> u32 {
    return select(select(v.x, v.y, i == 1u), select(v.z, v.w, i == 3u), i >= 2u);
}

// The position of the best layer of a bucket, outward from a position; NONE if the bucket is empty.
fn search_bucket(bucket: Bucket, start: u32, normal: vec3<f32>, expected: f32, inverse_unit: f32) -> u32 {
    let near = clamp(start, bucket.first, bucket.end);
    var best = NONE;
    var least = 3.4e38;
    // Among equals the nearer layer wins, here the later one.
    for (var position = near; position > bucket.first; position--) {
        let shape = layer_shape(bucket.base + by_part[bucket.base + position - 1u]);
        let epsilon = neighbour_epsilon(normal, expected, inverse_unit, shape);
        if shape.depth <= expected && epsilon.y > least {
            break;
        }
        if epsilon.x <= least {
            least = epsilon.x;
            best = position - 1u;
        }
    }
    for (var position = near; position < bucket.end; position++) {
        let shape = layer_shape(bucket.base + by_part[bucket.base + position]);
        let epsilon = neighbour_epsilon(normal, expected, inverse_unit, shape);
        if shape.depth >= expected && epsilon.y > least {
            break;
        }
        if epsilon.x < least {
            least = epsilon.x;
            best = position;
        }
    }
    return best;
}

// Which two pixels are paired: the right or lower one is at `step`, `direction` leads there, `direction + 1` back.
struct Way {
    x: u32,
    y: u32,
    step: vec2<u32>,
    direction: u32,
    part: u32,
}

// Searches for one layer of `own` in all of the other bucket and back. Returns its link and records the one behind.
fn search_both_ways(own: Four, i: u32, other: Bucket, start: u32, way: Way, none: u32) -> u32 {
    let base = own.bucket.base;
    let layer = by_part[base + own.begin + i];
    let shape = layer_shape(base + layer);
    let expected = expected_depths(way.x, way.y, shape.depth, shape.normal)[way.direction];
    let unit = inverse_depth_unit(shape.depth, way.part);
    let found = search_bucket(other, start, shape.normal, expected, unit);
    if found == NONE {
        return none;
    }
    let there = by_part[other.base + found];
    let back = layer_shape(other.base + there);
    let x = way.x + way.step.x;
    let y = way.y + way.step.y;
    let expected_back = expected_depths(x, y, back.depth, back.normal)[way.direction + 1u];
    let unit_back = inverse_depth_unit(back.depth, way.part);
    if search_bucket(own.bucket, own.begin + i, back.normal, expected_back, unit_back) != own.begin + i {
        return none;
    }
    links_behind[other.base + there][way.direction >> 1u] = layer;
    return there;
}

// Links of up to four layers to the other pixel; records those behind.
fn pair(own: Four, other: u32, way: Way) -> vec4<u32> {
    let range = find_bucket(other, way.part);
    let bucket = Bucket(layer_base(other), range.x, range.y);
    let none = absent(other);
    let start = min(range.x + own.begin - own.bucket.first, range.y);
    let others = four_at(bucket, start, range.y);
    let expected = expected_in(own, way.x, way.y, way.direction, way.part);
    let back = expected_in(others, way.x + way.step.x, way.y + way.step.y, way.direction + 1u, way.part);
    let forward = choice_of(own, expected, others);
    let backward = choice_of(others, back, own);
    let forward_decided = is_decided(expected, forward, others);
    let backward_decided = is_decided(back, backward, own);
    var links = vec4<u32>(none);
    var open = 0u;
    for (var i = 0u; i < 4u; i++) {
        let j = forward.index[i];
        if i >= own.count || range.x == range.y {
            continue;
        }
        if j == 4u || !(forward_decided[i] && pick(vec4<u32>(backward_decided), j) == 1u) {
            open |= 1u << i;
        } else if pick(backward.index, j) == i {
            let there = pick(others.layers, j);
            links[i] = there;
            links_behind[bucket.base + there][way.direction >> 1u] = own.layers[i];
        }
    }
    while open != 0u {
        let i = firstTrailingBit(open);
        open &= open - 1u;
        links[i] = search_both_ways(own, i, bucket, start + i, way, none);
    }
    return links;
}

// Nothing is behind a layer until it is found.
@compute @workgroup_size(16, 16)
fn begin(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    let adjacent = adjacent_of(id.x, id.y);
    var behind = vec2<u32>(UNKNOWN);
    if adjacent.inside.y {
        behind.x = absent(adjacent.pixels.y);
    }
    if adjacent.inside.w {
        behind.y = absent(adjacent.pixels.w);
    }
    for (var layer = 0u; layer < count; layer++) {
        links_behind[base + layer] = behind;
    }
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let base = layer_base(pixel);
    let begin = id.z * store_layout.chunk;
    let end = min(layer_count(pixel), begin + store_layout.chunk);
    let adjacent = adjacent_of(id.x, id.y);
    let y = id.y + frame.first_row;
    var position = begin;
    while position < end {
        let part = parts[base + by_part[base + position]];
        let range = find_bucket(pixel, part);
        let own = four_at(Bucket(base, range.x, range.y), position, min(range.y, end));
        var right = vec4<u32>(UNKNOWN);
        var below = vec4<u32>(UNKNOWN);
        if adjacent.inside.x {
            right = pair(own, adjacent.pixels.x, Way(id.x, y, vec2<u32>(1u, 0u), 0u, part));
        }
        if adjacent.inside.z {
            below = pair(own, adjacent.pixels.z, Way(id.x, y, vec2<u32>(0u, 1u), 2u, part));
        }
        for (var i = 0u; i < own.count; i++) {
            links_ahead[base + own.layers[i]] = right[i] | (below[i] << 16u);
        }
        position += max(own.count, 1u);
    }
}
