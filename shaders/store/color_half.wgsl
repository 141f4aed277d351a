//@ use common/packing
// Base colour column: linear, straight, four halves.

@group(1) @binding(4) var<storage, read_write> colors: array<vec2<u32>>;

fn store_color(slot: u32, color: vec4<f32>) {
    colors[slot] = pack_half4(color);
}

fn layer_color(slot: u32) -> vec4<f32> {
    return unpack_half4(colors[slot]);
}
