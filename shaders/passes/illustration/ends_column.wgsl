// For each pixel the nearest layer that lacks its neighbour, in each direction: right under left, down under up, 16 bits each;
// all bits if none does.

@group(1) @binding(20) var<storage, read_write> ends: array<vec2<u32>>;

fn nearest_end(pixel: u32, direction: u32) -> u32 {
    return (ends[pixel][direction >> 1u] >> (16u * (direction & 1u))) & 0xFFFFu;
}
