// Sorts a pixel's fragments by (depth, triangle), which lie together already, each with where it came from.

alias Element = vec3<u32>;
@group(1) @binding(2) var<storage, read_write> keys: array<vec2<u32>>;
// The depth word goes to the shape column too; the normal follows when surfaces are gathered.
@group(1) @binding(3) var<storage, read_write> shapes: array<ShapeWords>;
@group(1) @binding(24) var<storage, read_write> sources: array<u32>;

fn padding_element() -> Element {
    return vec3<u32>(0xFFFFFFFFu);
}

// Depth, triangle, source.
fn is_less(a: Element, b: Element) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

fn load_element(base: u32, i: u32) -> Element {
    let key = keys[base + i];
    return vec3<u32>(key.y, key.x, sources[base + i]);
}

fn store_element(base: u32, i: u32, e: Element) {
    keys[base + i] = vec2<u32>(e.y, e.x);
    shapes[base + i].x = e.x;
    sources[base + i] = e.z;
}

fn begin_long(base: u32, count: u32) {
}

fn load_long(base: u32, i: u32) -> Element {
    return load_element(base, i);
}

fn store_long(base: u32, i: u32, e: Element) {
    store_element(base, i, e);
}
