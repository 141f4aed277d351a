//@ use store/key_wide64

fn search_key_of(v: Varyings) -> vec2<u32> {
    return vec2<u32>(v.triangle, depth_key_of(v.position));
}

fn key_is_less(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

// Behind every stored layer: dropped by overflow, not lost.
fn is_behind(key: vec2<u32>, last: vec2<u32>) -> bool {
    return key_is_less(last, key);
}
