//@ use passes/operators/layer
//@ use store/lit
// A pointwise operator: `operate(at, color)` gives a layer's colour and opacity anew, from the layers of its own pixel and
// whatever it reads besides, but never from another layer's lit colour. In place.

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.size.x || y < frame.first_output_row || y >= frame.end_output_row {
        return;
    }
    let pixel = pixel_index(id.x, y);
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    for (var index = 0u; index < count; index++) {
        let at = Layer(id.x, y, pixel, base, count, index);
        store_lit(base + index, operate(at, layer_lit(base + index)));
    }
}
