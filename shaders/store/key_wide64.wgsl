//@ use common/frame
// Key column, wide: x = instanced-triangle number, y = depth key. Read as one 64-bit number, depth is on top.

@group(1) @binding(2) var<storage, read_write> keys: array<vec2<u32>>;

fn layer_view_depth(slot: u32) -> f32 {
    return view_depth_of_key(keys[slot].y);
}
