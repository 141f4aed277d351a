//@ use common/packing
// Lit colour column: linear, straight alpha, four halves. Written by the shade pass; stylization changes it in place.

@group(1) @binding(6) var<storage, read_write> lit: array<vec2<u32>>;

fn layer_lit(slot: u32) -> vec4<f32> {
    return unpack_half4(lit[slot]);
}

fn store_lit(slot: u32, color: vec4<f32>) {
    lit[slot] = pack_half4(color);
}
