//@ use passes/operators/layer
// First half of a global operator: `gather(at)` is called for every layer of the image, once, in no order. Rows around a band
// are another band's.

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
        gather(Layer(id.x, y, pixel, base, count, index));
    }
}
