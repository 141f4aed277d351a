//@ use passes/capture/statistics
//@ use store/surfaces
// Data storage (Murray 2016, section 4.1 step 4): the second geometry pass finds the slot of each fragment and writes its
// surface there. What is not found lies behind the k nearest; anything else not found is a fault and is counted (T3).

@fragment
fn fragment_main(v: Varyings, @builtin(front_facing) front_facing: bool) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    // Derivatives need every invocation of the quad, so the surface comes before any early return.
    var surface = captured_surface(v, front_facing);
    surface.color = recolored(v.part, surface.color);
    if clipped || is_cut_out(v) {
        discard;
    }
    let pixel = pixel_of_position(v.position);
    let slot = find_slot(v, pixel);
    if slot != EMPTY {
        store_surface(slot, depth_word(search_key_of(v)), surface);
        store_part(slot, v.part);
    } else {
        let count = layer_count(pixel);
        let explained = overflowed(pixel) && count > 0u && is_behind(search_key_of(v), keys[layer_base(pixel) + count - 1u]);
        if !explained {
            atomicAdd(&statistics[STAT_LOST], 1u);
        }
        store_tail(pixel, v, surface, explained);
    }
    return vec4<f32>(0.0);
}
