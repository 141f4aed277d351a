//@ use passes/features/neighbour_epsilon
//@ use store/buckets
// First half of the neighbour search, by buckets (Murray 2016, section 5.1): for each layer and direction, the layer of the
// same part in the adjacent pixel with the least epsilon; equal epsilons: the nearer layer. Only the layers of the same part
// are read, and a bucket is looked up once for all layers of a part.

// A bucket is in depth order, and epsilon is at least the squared depth difference (less what rounding can take from
// 1 - cosine): the search starts at the expected depth and goes both ways until depth alone says that nothing better
// follows.
const ROUNDING: f32 = 2e-6;

// A bucket of an adjacent pixel, and where in it the last search began: layers of one part seek in depth order, so the next
// search begins nearby.
struct Bucket {
    base: u32,
    first: u32,
    end: u32,
    at: u32,
    absent: u32,
}

fn bucket_of(adjacent: Adjacent, direction: u32, part: u32) -> Bucket {
    if !adjacent.inside[direction] {
        return Bucket(0u, 0u, 0u, 0u, UNKNOWN);
    }
    let other = adjacent.pixels[direction];
    let range = find_bucket(other, part);
    return Bucket(layer_base(other), range.x, range.y, range.x, absent(other));
}

fn best_candidate(bucket: ptr<function, Bucket>, direction: u32, seeker: Seeker) -> u32 {
    let base = (*bucket).base;
    let expected = seeker.expected[direction];
    while (*bucket).at < (*bucket).end {
        if layer_view_depth(base + by_part[base + (*bucket).at]) > expected {
            break;
        }
        (*bucket).at += 1u;
    }
    while (*bucket).at > (*bucket).first {
        if layer_view_depth(base + by_part[base + (*bucket).at - 1u]) <= expected {
            break;
        }
        (*bucket).at -= 1u;
    }
    var best = (*bucket).absent;
    var best_epsilon = 3.4e38;
    // Nearer to the viewer. Among equals the nearer layer wins, here the later one.
    for (var position = (*bucket).at; position > (*bucket).first; position--) {
        let layer = by_part[base + position - 1u];
        let epsilon = neighbour_epsilon(seeker, direction, base + layer);
        if epsilon.y > best_epsilon + ROUNDING {
            break;
        }
        if epsilon.x <= best_epsilon {
            best_epsilon = epsilon.x;
            best = layer;
        }
    }
    // Farther from the viewer.
    for (var position = (*bucket).at; position < (*bucket).end; position++) {
        let layer = by_part[base + position];
        let epsilon = neighbour_epsilon(seeker, direction, base + layer);
        if epsilon.y > best_epsilon + ROUNDING {
            break;
        }
        if epsilon.x < best_epsilon {
            best_epsilon = epsilon.x;
            best = layer;
        }
    }
    return best;
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    // What lies deeper than a link can say has unknown neighbours.
    for (var layer = LARGEST_LINK; layer < count; layer++) {
        store_candidates(base + layer, vec4<u32>(UNKNOWN));
    }
    let bucketed = min(count, LARGEST_LINK);
    let adjacent = adjacent_of(id.x, id.y);
    var position = 0u;
    while position < bucketed {
        let part = parts[base + by_part[base + position]];
        var right = bucket_of(adjacent, 0u, part);
        var left = bucket_of(adjacent, 1u, part);
        var down = bucket_of(adjacent, 2u, part);
        var up = bucket_of(adjacent, 3u, part);
        while position < bucketed {
            let slot = base + by_part[base + position];
            if parts[slot] != part {
                break;
            }
            let seeker = seeker_of(id.x, id.y, slot, part);
            store_candidates(slot, vec4<u32>(
                best_candidate(&right, 0u, seeker),
                best_candidate(&left, 1u, seeker),
                best_candidate(&down, 2u, seeker),
                best_candidate(&up, 3u, seeker),
            ));
            position += 1u;
        }
    }
}
