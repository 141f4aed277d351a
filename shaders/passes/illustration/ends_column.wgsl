//@ use store/links
// For each pixel the nearest layer that ends openly, in each direction: right under left, down under up, 16 bits each; all bits if
// none does.

@group(1) @binding(20) var<storage, read_write> ends: array<vec2<u32>>;

fn nearest_end(pixel: u32, direction: u32) -> u32 {
    return (ends[pixel][direction >> 1u] >> (16u * (direction & 1u))) & 0xFFFFu;
}

// Whether a layer lies under what ends between it and the adjacent pixel in a direction. With `bare`, as printed, every step
// of the layer index counts instead (T19).
fn lies_under(pixel: u32, index: u32, link: u32, direction: u32, bare: bool) -> bool {
    return select(nearest_end(pixel, direction) < index, link < UNKNOWN && index > link, bare) && link != UNKNOWN;
}

// Whether a layer lies beside what ends in the adjacent pixel, on this one's side, and covers its neighbour. Of layers that lack it,
// `behind` knows.
fn lies_beside(other: u32, index: u32, link: u32, direction: u32, bare: bool) -> bool {
    return link < UNKNOWN && select(nearest_end(other, direction ^ 1u) < link, index < link, bare);
}
