//@ use passes/capture/linked_list/list
// Selection sort (Carnecky 2013, section 4.3): for every layer the list is walked once, for the nearest fragment behind the
// last one. Each layer is written once, and no array is needed, however long the list is. The keys of a pixel differ, so the
// order is one. Long lists take several dispatches: a cursor says how far a pixel's layers are sorted.

@group(1) @binding(21) var<storage, read_write> cursors: array<u32>;

fn is_nearer(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    let begin = cursors[pixel];
    let end = min(base + count, begin + store_layout.chunk);
    for (var slot = begin; slot < end; slot++) {
        let is_first = slot == base;
        let last = keys[select(slot - 1u, slot, is_first)];
        var nearest = vec2<u32>(EMPTY);
        var source = EMPTY;
        var link = list_heads[pixel];
        for (var i = 0u; i < count && is_place(link); i++) {
            let key = arrival_keys[link - 1u];
            if (is_first || is_nearer(last, key)) && is_nearer(key, nearest) {
                nearest = key;
                source = link - 1u;
            }
            link = list_next[link - 1u];
        }
        if source == EMPTY {
            place_nothing(slot);
        } else {
            place_layer(slot, nearest, source);
        }
    }
    cursors[pixel] = max(begin, end);
}
