//@ use store/layout_rows
//@ use store/buckets
// Where a fragment's data belongs (Murray 2016, Figure 4): the bucket of its shape, then binary search on depth.

fn find_slot(v: Varyings, pixel: u32) -> u32 {
    let base = layer_base(pixel);
    let range = find_entry(bucket_table(pixel), v.part, 0u);
    let key = search_key_of(v);
    var low = range.first;
    var high = range.end;
    while low < high {
        let middle = (low + high) / 2u;
        if key_is_less(keys[base + by_part[base + middle]], key) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if low < range.end {
        let slot = base + by_part[base + low];
        if all(keys[slot] == key) {
            return slot;
        }
    }
    return EMPTY;
}
