//@ use common/frame
//@ use store/packed_depth
// The k-buffer's rows during insertion, the paper's key: 16-bit depth over 16-bit shape id (section 4.2).

alias Key = u32;
@group(1) @binding(2) var<storage, read_write> atomic_keys: array<atomic<u32>>;

const EMPTY_KEY: u32 = 0xFFFFFFFFu;

fn key_of(v: Varyings) -> Key {
    return (packed_depth_of(v.position) << 16u) | v.part;
}
