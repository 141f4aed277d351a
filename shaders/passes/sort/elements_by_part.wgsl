//@ use store/part_column
// Z reordering by shape id (Murray 2016, section 4.1 step 2): sorts a pixel's layers by (part, depth). Depth is the layer
// index, since the row is in depth order; the row itself stays as it is and the order is kept beside it.

alias Element = vec2<u32>;
@group(1) @binding(10) var<storage, read_write> by_part: array<u32>;

fn padding_element() -> Element {
    return vec2<u32>(0xFFFFFFFFu, 0xFFFFFFFFu);
}

fn is_less(a: Element, b: Element) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

fn load_element(base: u32, i: u32) -> Element {
    return vec2<u32>(parts[base + i], i);
}

fn store_element(base: u32, i: u32, e: Element) {
    by_part[base + i] = e.y;
}

// In-place form for long lists: the order itself is the memory.
fn begin_long(base: u32, count: u32) {
    for (var i = 0u; i < count; i++) {
        by_part[base + i] = i;
    }
}

fn load_long(base: u32, i: u32) -> Element {
    let layer = by_part[base + i];
    return vec2<u32>(parts[base + layer], layer);
}

fn store_long(base: u32, i: u32, e: Element) {
    by_part[base + i] = e.y;
}
