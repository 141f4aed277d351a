//@ use passes/features/neighbour_epsilon
//@ use store/buckets
//@ use store/links
//@ use store/open_layers
// Neighbours by buckets (Murray 2016, section 5.1). A pixel pairs its layers with those of the pixel to the right and of the
// pixel below, part by part: only the bucket of the same part is read. Both pixels are searched at once, so the reverse check
// (Figure 5) needs no pass of its own and every bucket is read half as often.
//
// Two layers of a bucket are held against the two of the same rank in the other pixel (closed bodies put layers in pairs), and
// the layers next to those two bound what all others could reach: buckets are in depth order, and epsilon is at least
// epsilon_z. Nearly always that decides. What it leaves open is listed and searched by `links_left_open`: a CPU rasterizer
// executes branches that no lane takes, so what is rare is better elsewhere.

// Up to two layers of a bucket, from a position on.
struct Couple {
    bucket: Bucket,
    begin: u32,
    count: u32,
    layers: vec2<u32>,
    depths: vec2<f32>,
    normals_x: vec2<f32>,
    normals_y: vec2<f32>,
    normals_z: vec2<f32>,
    // Depths of the layers next to the two, where the bucket goes on.
    before: f32,
    after: f32,
}

fn load_layer(couple: ptr<function, Couple>, i: u32) {
    if i < (*couple).count {
        let base = (*couple).bucket.base;
        let layer = by_part[base + (*couple).begin + i];
        let shape = layer_shape(base + layer);
        (*couple).layers[i] = layer;
        (*couple).depths[i] = shape.depth;
        (*couple).normals_x[i] = shape.normal.x;
        (*couple).normals_y[i] = shape.normal.y;
        (*couple).normals_z[i] = shape.normal.z;
    }
}

fn couple_at(bucket: Bucket, begin: u32, end: u32) -> Couple {
    var couple: Couple;
    couple.bucket = bucket;
    couple.begin = begin;
    couple.count = min(max(end, begin) - begin, 2u);
    couple.depths = vec2<f32>(1.0);
    load_layer(&couple, 0u);
    load_layer(&couple, 1u);
    if begin > bucket.first {
        couple.before = layer_view_depth(bucket.base + by_part[bucket.base + begin - 1u]);
    }
    if begin + couple.count < bucket.end {
        couple.after = layer_view_depth(bucket.base + by_part[bucket.base + begin + couple.count]);
    }
    return couple;
}

fn normal_of(couple: Couple, i: u32) -> vec3<f32> {
    return vec3<f32>(couple.normals_x[i], couple.normals_y[i], couple.normals_z[i]);
}

// Where two layers expect their surface in an adjacent pixel, and one over the length that differences are measured in.
struct Expected {
    depths: vec2<f32>,
    inverse_units: vec2<f32>,
}

fn expected_in(couple: Couple, x: u32, y: u32, direction: u32, part: u32) -> Expected {
    return Expected(
        vec2<f32>(
            expected_depths(x, y, couple.depths.x, normal_of(couple, 0u))[direction],
            expected_depths(x, y, couple.depths.y, normal_of(couple, 1u))[direction],
        ),
        vec2<f32>(
            inverse_depth_unit(couple.depths.x, part),
            inverse_depth_unit(couple.depths.y, part),
        ),
    );
}

// As neighbour_epsilon, to two layers, of which `back` says where they expect the layer.
fn couple_epsilons(
    normal: vec3<f32>,
    depth: f32,
    expected: f32,
    inverse_unit: f32,
    others: Couple,
    back: Expected,
) -> vec2<f32> {
    let dz = (expected - others.depths) * inverse_unit;
    let dz_back = (back.depths - depth) * back.inverse_units;
    let x = normal.x - others.normals_x;
    let y = normal.y - others.normals_y;
    let z = normal.z - others.normals_z;
    return 0.5 * (x * x + y * y + z * z) + depth_measures(dz, dz_back);
}

// The best of the other two for each of two.
struct Choice {
    // 0 or 1, or 2 for none.
    index: vec2<u32>,
    epsilon: vec2<f32>,
}

// Of equals the nearer: the first.
fn choose(choice: ptr<function, Choice>, i: u32, epsilons: vec2<f32>, count: u32) {
    var best = 2u;
    var least = 3.4e38;
    if count > 0u && epsilons.x < least {
        best = 0u;
        least = epsilons.x;
    }
    if count > 1u && epsilons.y < least {
        best = 1u;
        least = epsilons.y;
    }
    (*choice).index[i] = best;
    (*choice).epsilon[i] = least;
}

fn choice_of(couple: Couple, expected: Expected, others: Couple, back: Expected) -> Choice {
    var choice: Choice;
    let d = couple.depths;
    let e = expected.depths;
    let u = expected.inverse_units;
    choose(&choice, 0u, couple_epsilons(normal_of(couple, 0u), d.x, e.x, u.x, others, back), others.count);
    choose(&choice, 1u, couple_epsilons(normal_of(couple, 1u), d.y, e.y, u.y, others, back), others.count);
    return choice;
}

// Whether no layer of the other bucket outside the couple can be as good as the best of them.
fn is_decided(expected: Expected, choice: Choice, others: Couple) -> vec2<bool> {
    let nothing_before = others.begin == others.bucket.first;
    let nothing_after = others.begin + others.count == others.bucket.end;
    let before = (expected.depths - others.before) * expected.inverse_units;
    let after = (expected.depths - others.after) * expected.inverse_units;
    let behind_all = vec2<f32>(others.before) <= expected.depths;
    let before_all = vec2<f32>(others.after) >= expected.depths;
    return (vec2<bool>(nothing_before) | (behind_all & (least_measures(before) > choice.epsilon)))
        & (vec2<bool>(nothing_after) | (before_all & (least_measures(after) > choice.epsilon)));
}

// The other pixel of a pair, read once for all parts.
struct Other {
    table: Table,
    // What the lack of a neighbour there means.
    none: u32,
}

fn other_of(inside: bool, pixel: u32) -> Other {
    if !inside {
        return Other(Table(0u, 0u), UNKNOWN);
    }
    return Other(bucket_table(pixel), absent(pixel));
}

// Which two pixels are paired: the right or lower one is at `step`, `direction` leads there, `direction + 1` back.
struct Way {
    x: u32,
    y: u32,
    step: vec2<u32>,
    direction: u32,
    part: u32,
}

// Links of two layers to the other pixel, OPEN where undecided; records those behind. Pixels side by side mostly have the same
// parts, so the part is mostly in the same slot of both tables.
fn pair(own: Couple, slot: u32, other: Other, way: Way) -> vec2<u32> {
    let entry = find_entry(other.table, way.part, slot);
    let base = other.table.base;
    let start = min(entry.first + own.begin - own.bucket.first, entry.end);
    let others = couple_at(Bucket(base, entry.first, entry.end), start, entry.end);
    let expected = expected_in(own, way.x, way.y, way.direction, way.part);
    let back = expected_in(others, way.x + way.step.x, way.y + way.step.y, way.direction + 1u, way.part);
    let forward = choice_of(own, expected, others, back);
    let backward = choice_of(others, back, own, expected);
    // Decided are layers whose choice is, and whose choice's choice is.
    let backward_decided = is_decided(back, backward, own);
    let second = forward.index == vec2<u32>(1u);
    let decided = is_decided(expected, forward, others) & (forward.index != vec2<u32>(2u))
        & select(vec2<bool>(backward_decided.x), vec2<bool>(backward_decided.y), second);
    let mutual = decided & (select(vec2<u32>(backward.index.x), vec2<u32>(backward.index.y), second) == vec2<u32>(0u, 1u));
    let there = select(vec2<u32>(others.layers.x), vec2<u32>(others.layers.y), second);
    let some = entry.first < entry.end;
    if some && mutual.x && own.count > 0u {
        links_behind[base + there.x][way.direction >> 1u] = own.layers.x;
    }
    if some && mutual.y && own.count > 1u {
        links_behind[base + there.y][way.direction >> 1u] = own.layers.y;
    }
    let links = select(select(vec2<u32>(OPEN), vec2<u32>(other.none), decided), there, mutual);
    return select(vec2<u32>(other.none), links, some);
}

fn store_links(slot: u32, pixel: u32, position: u32, right: u32, below: u32) {
    links_ahead[slot] = right | (below << 16u);
    if right == OPEN || below == OPEN {
        list_open(pixel, position, u32(right == OPEN) | (u32(below == OPEN) << 1u));
    }
}

// Nothing is behind a layer until it is found.
@compute @workgroup_size(16, 16)
fn begin(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
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
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let table = bucket_table(pixel);
    let base = table.base;
    let begin = id.z * store_layout.chunk;
    let end = min(layer_count(pixel), begin + store_layout.chunk);
    if begin >= end {
        return;
    }
    let y = id.y + frame.first_row;
    let adjacent = adjacent_of(id.x, id.y);
    let other_right = other_of(adjacent.inside.x, adjacent.pixels.x);
    let other_below = other_of(adjacent.inside.z, adjacent.pixels.z);
    var position = begin;
    while position < end {
        let part = parts[base + by_part[base + position]];
        let entry = find_entry(table, part, position);
        let own = couple_at(Bucket(base, entry.first, entry.end), position, min(entry.end, end));
        let right = pair(own, entry.slot, other_right, Way(id.x, y, vec2<u32>(1u, 0u), 0u, part));
        let below = pair(own, entry.slot, other_below, Way(id.x, y, vec2<u32>(0u, 1u), 2u, part));
        if own.count > 0u {
            store_links(base + own.layers.x, pixel, position, right.x, below.x);
        }
        if own.count > 1u {
            store_links(base + own.layers.y, pixel, position + 1u, right.y, below.y);
        }
        position += max(own.count, 1u);
    }
}
