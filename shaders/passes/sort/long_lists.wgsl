//@ use passes/sort/listed_pixel
// Lists longer than the largest network: heap sort in storage, one invocation a pixel. Bounded loops, no recursion.

fn sift_down(base: u32, start: u32, end: u32) {
    let moved = load_long(base, start);
    var root = start;
    // A heap of 2^32 elements is 32 levels high.
    for (var level = 0u; level < 32u; level++) {
        var child = 2u * root + 1u;
        if child >= end {
            break;
        }
        var largest = load_long(base, child);
        if child + 1u < end {
            let right = load_long(base, child + 1u);
            if is_less(largest, right) {
                largest = right;
                child += 1u;
            }
        }
        if !is_less(moved, largest) {
            break;
        }
        store_long(base, root, largest);
        root = child;
    }
    store_long(base, root, moved);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pixel = listed_pixel(group, local);
    if pixel == EMPTY {
        return;
    }
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    begin_long(base, count);
    for (var start = count / 2u; start > 0u; start--) {
        sift_down(base, start - 1u, count);
    }
    for (var end = count - 1u; end > 0u; end--) {
        let last = load_long(base, end);
        store_long(base, end, load_long(base, 0u));
        store_long(base, 0u, last);
        sift_down(base, 0u, end);
    }
}
