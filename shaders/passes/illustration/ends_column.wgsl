// For each pixel the nearest layer that lacks its neighbour, in each direction: right under left, down under up, 16 bits each;
// all bits if none does.

@group(1) @binding(20) var<storage, read_write> ends: array<vec2<u32>>;

fn nearest_end(pixel: u32, direction: u32) -> u32 {
    return (ends[pixel][direction >> 1u] >> (16u * (direction & 1u))) & 0xFFFFu;
}

// Whether a layer lies under what ends between it and its neighbour in a direction: its index is greater, and something in
// front of it really ends there, since touching faces swap places from pixel to pixel (T19). With `bare` every step counts.
fn lies_under(pixel: u32, index: u32, link: u32, direction: u32, bare: bool) -> bool {
    return index > link && (bare || nearest_end(pixel, direction) < index);
}

// Whether a layer lies beside what ends in the adjacent pixel, on this one's side, and covers its neighbour.
fn lies_beside(other: u32, index: u32, link: u32, direction: u32, bare: bool) -> bool {
    return index < link && (bare || nearest_end(other, direction ^ 1u) < link);
}
