//@ use store/key_packed32

fn search_key_of(v: Varyings) -> u32 {
    return (packed_depth_of(v.position) << 16u) | v.part;
}

fn key_is_less(a: u32, b: u32) -> bool {
    return a < b;
}

fn is_behind(key: u32, last: u32) -> bool {
    return last < key;
}
