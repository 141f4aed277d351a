//@ use common/frame
// Key column, wide: x = instanced-triangle number, y = depth key. Read as one 64-bit number, depth is on top.

@group(1) @binding(2) var<storage, read_write> keys: array<vec2<u32>>;

fn depth_word(key: vec2<u32>) -> u32 {
    return key.y;
}

fn view_depth_of_word(word: u32) -> f32 {
    return view_depth_of_key(word);
}
