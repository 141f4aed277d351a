//@ use store/layout_rows
//@ use passes/capture/bucketed_k_buffer/tally
// Z insertion (Murray 2016, section 4.1 step 1): keeps the k nearest fragments of each pixel, sorted, by a chain of
// atomic minima. The value that leaves a slot is carried on to the next.
//
// Slots only ever decrease and are sorted at every moment, so a slot seen below the key stays below it, and so do all
// slots before it: the chain may start at the first slot that a binary search does not see below. With fragments that
// arrive front to back that saves nearly all atomics.

@fragment
fn fragment_main(v: Varyings) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    if clipped || is_cut_out(v) {
        discard;
    }
    let pixel = pixel_of_position(v.position);
    let k = store_layout.k;
    let base = pixel * k;
    atomicAdd(&tally[2u * pixel], 1u);
    var key = key_of(v);
    var low = 0u;
    var high = k;
    while low < high {
        let middle = (low + high) / 2u;
        if atomicLoad(&atomic_keys[base + middle]) < key {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    for (var i = low; i < k; i++) {
        let old = atomicMin(&atomic_keys[base + i], key);
        if old == EMPTY_KEY {
            break;
        }
        if old == key {
            // Only packed keys can be equal: the fragments are one from here on, and counted.
            atomicAdd(&tally[2u * pixel + 1u], 1u);
            break;
        }
        key = max(old, key);
    }
    return vec4<f32>(0.0);
}
