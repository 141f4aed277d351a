//@ use store/parameters
// A geometry pass that finds the layer of each fragment by its key and notes the parameters there. Fragments that are no layer
// were cut away or dropped by the capture.

@fragment
fn fragment_main(v: Varyings) -> @location(0) vec4<f32> {
    // Derivatives come before any early return.
    let step = vec2<f32>(length(dpdx(v.parameters)), length(dpdy(v.parameters)));
    let pixel = pixel_of_position(v.position);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    let key = search_key_of(v);
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if key_is_less(keys[base + middle], key) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low < count && all(keys[base + low] == key) {
        // A triangle seen edge-on has no finite step.
        parameters[base + low] = vec4<f32>(v.parameters, select(vec2<f32>(0.0), step, step < vec2<f32>(1e30)));
    }
    return vec4<f32>(0.0);
}
