//@ use passes/operators/around
//@ use passes/operators/steps
// A local operator: `operate(at, own, around, beside)` gives a layer's fields anew, from its own and those of its neighbours.
// Fields are read from one column and written to the other (ping-pong); the first operator reads none. `has_changed(own, next)` says whether a step was
// worth it, for operators that are repeated until nothing changes.

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
    var changed = false;
    for (var index = 0u; index < count; index++) {
        let slot = base + index;
        let at = Layer(id.x, id.y + frame.first_row, pixel, base, count, index);
        let own = field_of(slot);
        let next = operate(at, own, around(slot, beside), beside);
        field_out[slot] = next;
        changed = changed || has_changed(own, next);
    }
    if changed {
        note_change();
    }
}
