//@ use store/links
//@ use store/part_column
//@ use passes/illustration/lacking
//@ use passes/illustration/layer_ends
//@ use passes/illustration/tangent
// Seams: where a layer that lacks a neighbour meets another one in the adjacent pixel that has none on its side either, so closely
// that nobody could see a gap. Each is no farther than a pixel's size from the other's tangent plane, or the planes cross between
// the two pixels at a moderate angle. Where both surfaces of parts that touch end side by side, nothing opens (T19).
//
// Of sheets of one part that nearly coincide, the neighbour search may pair the wrong ones and leave two over: there the surface
// goes on.

// How many pixels' sizes planes that cross may be apart at the pixels' centres, taken together.
const CROSSING: f32 = 4.0;

// The first layer of a pixel that is not nearer than a depth.
fn first_from(there: Across, depth: f32) -> u32 {
    var low = 0u;
    var high = there.count;
    while low < high {
        let middle = (low + high) / 2u;
        if layer_view_depth(there.base + middle) < depth {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let own = lacking_of(group, local);
    if !own.is_one {
        return;
    }
    let shape = layer_shape(own.slot);
    let tangent = tangent_of(own.at, shape);
    let part = parts[own.slot];
    let size = pixel_size(shape.depth).y;
    // Nothing that is farther along the sight line meets it.
    let most = max(tangent.reach, CROSSING * size);
    var flags = layer_ends[own.slot];
    for (var direction = 0u; direction < 4u; direction++) {
        if (flags & (LACKS << direction)) == 0u {
            continue;
        }
        let there = across(own, direction);
        let expected = depth_aside(tangent, direction);
        for (var i = first_from(there, expected - most); i < there.count; i++) {
            let facing = layer_shape(there.base + i);
            if facing.depth > expected + most {
                break;
            }
            let other_tangent = tangent_of(there.at, facing);
            let off = expected - facing.depth;
            let back = depth_aside(other_tangent, direction ^ 1u) - shape.depth;
            // Unknown is what is cut away, or lost by a k-buffer.
            let link = link_of(there.base + i, direction ^ 1u);
            let touches = abs(off) <= tangent.reach && abs(back) <= other_tangent.reach;
            let crosses = off * back >= 0.0 && abs(off) + abs(back) <= CROSSING * size;
            if link >= UNKNOWN && (touches || crosses) {
                flags &= ~(ENDS_OPENLY << direction);
                flags &= ~select(0u, ENDS << direction, link == MISSING && parts[there.base + i] == part);
            }
        }
    }
    layer_ends[own.slot] = flags;
}
