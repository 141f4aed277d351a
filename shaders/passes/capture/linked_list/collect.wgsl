//@ use passes/capture/linked_list/list
// Collect: brings the fragments of a list together, in the order of the list, for a sort in place.

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    var link = list_heads[pixel];
    for (var i = 0u; i < count; i++) {
        if is_place(link) {
            place_layer(base + i, arrival_keys[link - 1u], link - 1u);
            link = list_next[link - 1u];
        } else {
            place_nothing(base + i);
        }
    }
    if link != END {
        atomicAdd(&statistics[STAT_LOST], 1u);
    }
}
