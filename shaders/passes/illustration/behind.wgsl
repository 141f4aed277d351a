//@ use store/part_column
//@ use passes/illustration/lacking
//@ use passes/illustration/tangent
//@ use passes/illustration/layer_ends_bits
//@ use passes/illustration/ends_column
// Which of the layers that lack a neighbour lie behind what ends openly in the adjacent pixel, so that a halo begins at them. Where a
// layer does not end openly, it does as if its neighbour were there. Otherwise only what belongs to another part counts: of
// one part, it may be the neighbour that was not found, on a surface seen nearly edge-on.

// Others read the bits of where a layer ends while its own invocation sets another.
@group(1) @binding(32) var<storage, read_write> atomic_ends: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let own = lacking_of(group, local);
    if !own.is_one {
        return;
    }
    let tangent = tangent_of(own.at, layer_shape(own.slot));
    let part = parts[own.slot];
    let flags = atomicLoad(&atomic_ends[own.slot]);
    for (var direction = 0u; direction < 4u; direction++) {
        if (flags & (LACKS << direction)) == 0u {
            continue;
        }
        let there = across(own, direction);
        let expected = depth_aside(tangent, direction);
        let ends_openly = (flags & (ENDS_OPENLY << direction)) != 0u;
        for (var i = nearest_end(there.pixel, direction ^ 1u); i < there.count && layer_view_depth(there.base + i) < expected; i++) {
            let hides = (atomicLoad(&atomic_ends[there.base + i]) & (ENDS_OPENLY << (direction ^ 1u))) != 0u;
            if hides && !(ends_openly && parts[there.base + i] == part) {
                atomicOr(&atomic_ends[own.slot], BEHIND << direction);
                break;
            }
        }
    }
}
