//@ use store/layout_rows
// Where a fragment's data belongs when nothing needs buckets: binary search in the depth-ordered row.

fn find_slot(v: Varyings, pixel: u32) -> u32 {
    let base = layer_base(pixel);
    let key = search_key_of(v);
    var low = 0u;
    var high = layer_count(pixel);
    while low < high {
        let middle = (low + high) / 2u;
        if key_is_less(keys[base + middle], key) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low < layer_count(pixel) && all(keys[base + low] == key) {
        return base + low;
    }
    return EMPTY;
}
