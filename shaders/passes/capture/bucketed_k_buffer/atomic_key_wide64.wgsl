//@ use common/frame
// The k-buffer's rows during insertion, wide: depth key over instanced-triangle number. All keys of a pixel differ (T1).

alias Key = u64;
@group(1) @binding(2) var<storage, read_write> atomic_keys: array<atomic<u64>>;

const EMPTY_KEY: u64 = 0xFFFFFFFFFFFFFFFFlu;

fn key_of(v: Varyings) -> Key {
    return (u64(depth_key_of(v.position)) << 32u) | u64(v.triangle);
}
