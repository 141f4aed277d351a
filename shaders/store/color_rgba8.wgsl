//@ use common/packing
// Base colour column, the paper's RGBA8: straight, sRGB-encoded (T26).

@group(1) @binding(4) var<storage, read_write> colors: array<u32>;

fn store_color(slot: u32, color: vec4<f32>) {
    colors[slot] = pack4x8unorm(vec4<f32>(srgb_from_linear(color.rgb), color.a));
}

fn layer_color(slot: u32) -> vec4<f32> {
    let c = unpack4x8unorm(colors[slot]);
    return vec4<f32>(linear_from_srgb(c.rgb), c.a);
}
