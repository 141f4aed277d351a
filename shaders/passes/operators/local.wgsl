//@ use passes/operators/around
// A local operator: `operate(at, own, around, beside)` gives a layer's fields from its own and from what its neighbours are.
// Fields are read from one column and written to the other (ping-pong); the first operator reads none.

@group(1) @binding(19) var<storage, read_write> field_out: array<vec4<f32>>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    let beside = beside(id.x, pixel);
    let place = keep_pixel(count);
    for (var index = 0u; index < count; index++) {
        let slot = base + index;
        let at = Layer(id.x, id.y + frame.first_row, pixel, base, count, index);
        let around = around(slot, beside);
        keep_around(place + index, slot, around.slots);
        field_out[slot] = operate(at, field_of(slot), around, beside);
    }
}
