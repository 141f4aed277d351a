//@ use passes/features/neighbour_epsilon
//@ use store/buckets
//@ use store/links
//@ use store/open_dispatch
// Neighbours that `links_by_buckets` left open: one invocation a layer searches the whole bucket of the other pixel, and from
// what it finds the whole of its own.

const NONE: u32 = 0xFFFFFFFFu;

// Who searches: a layer, and the direction in which it does.
struct Seeker {
    x: u32,
    y: u32,
    direction: u32,
    part: u32,
    depth: f32,
    normal: vec3<f32>,
}

fn epsilon_of(seeker: Seeker, expected: f32, inverse_unit: f32, shape: Shape) -> vec2<f32> {
    let back = difference_back(seeker.x, seeker.y, seeker.direction, seeker.depth, seeker.part, shape);
    return neighbour_epsilon(seeker.normal, expected, inverse_unit, shape, back);
}

// The position of the best layer of a bucket, outward from a position; NONE if the bucket is empty.
fn search_bucket(bucket: Bucket, start: u32, seeker: Seeker) -> u32 {
    let expected = expected_depths(seeker.x, seeker.y, seeker.depth, seeker.normal)[seeker.direction];
    let inverse_unit = inverse_depth_unit(seeker.depth, seeker.part);
    let near = clamp(start, bucket.first, bucket.end);
    var best = NONE;
    var least = 3.4e38;
    // Among equals the nearer layer wins, here the later one.
    for (var position = near; position > bucket.first; position--) {
        let shape = layer_shape(bucket.base + by_part[bucket.base + position - 1u]);
        let epsilon = epsilon_of(seeker, expected, inverse_unit, shape);
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
        let epsilon = epsilon_of(seeker, expected, inverse_unit, shape);
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

// The link from a position of `own` to the pixel at (x, y) + step; records the one behind.
fn search_both_ways(own: Bucket, position: u32, x: u32, row: u32, axis: u32, part: u32) -> u32 {
    let step = select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), axis == 1u);
    let y = row + frame.first_row;
    let other_pixel = (row + step.y) * frame.size.x + x + step.x;
    let table = bucket_table(other_pixel);
    let entry = find_entry(table, part, 0u);
    let other = Bucket(table.base, entry.first, entry.end);
    let none = absent(other_pixel);
    let layer = by_part[own.base + position];
    let shape = layer_shape(own.base + layer);
    let start = entry.first + position - own.first;
    let found = search_bucket(other, start, Seeker(x, y, 2u * axis, part, shape.depth, shape.normal));
    if found == NONE {
        return none;
    }
    let there = by_part[other.base + found];
    let back = layer_shape(other.base + there);
    let seeker = Seeker(x + step.x, y + step.y, 2u * axis + 1u, part, back.depth, back.normal);
    if search_bucket(own, position, seeker) != position {
        return none;
    }
    links_behind[other.base + there][axis] = layer;
    return there;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let place = open_place(group, local);
    if !is_listed(place) {
        return;
    }
    let item = open_layers[place];
    let pixel = item.x;
    let position = item.y >> 2u;
    let table = bucket_table(pixel);
    let slot = table.base + by_part[table.base + position];
    let part = parts[slot];
    let entry = find_entry(table, part, position);
    let own = Bucket(table.base, entry.first, entry.end);
    var link = links_ahead[slot];
    for (var axis = 0u; axis < 2u; axis++) {
        if (item.y & (1u << axis)) != 0u {
            let found = search_both_ways(own, position, pixel % frame.size.x, pixel / frame.size.x, axis, part);
            link = insertBits(link, found, 16u * axis, 16u);
        }
    }
    links_ahead[slot] = link;
}
