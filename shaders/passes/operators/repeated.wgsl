//@ use passes/operators/around_slots
//@ use passes/operators/field_before
//@ use passes/operators/steps
// One step of a local operator that is repeated: `operate(slot, own, slots)` gives a layer's fields anew, from its own and from
// those of its neighbours, which lie in `slots` (right, left, down, up; the layer itself where there is none). `has_changed(own,
// next)` says whether a step was worth it.
//
// One invocation a layer, not a pixel: lanes that run side by side would all take as many rounds as the deepest of their pixels,
// and find the neighbours again in each step. On a CPU rasterizer that was two thirds of the time.

@group(1) @binding(19) var<storage, read_write> field_out: array<vec4<f32>>;

var<private> present_step: u32;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let place = (group.y * STEP_ROW + group.x) * 256u + local;
    // Here, where all lanes are at work, one load is enough for them.
    present_step = present[0];
    let notes = present[1] != 0u;
    if place >= present[2] {
        return;
    }
    let slot = listed_slot(place);
    let own = field_of(slot);
    let next = operate(slot, own, around_slots[slot]);
    field_out[slot] = next;
    if notes && has_changed(own, next) {
        note_change();
    }
}
