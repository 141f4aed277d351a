//@ use store/lit
// Blend: a pixel's layers over each other, front to back, premultiplied, in linear light and 32-bit floats (T26). What is
// behind an accumulated opacity of 1 - 2^-20 cannot change a 16-bit image and is not read.

struct BlendParameters {
    // Multiplies the opacity of every layer.
    opacity: f32,
    // Multiplies the opacity of ghosted parts.
    ghost: f32,
    _pad0: u32,
    _pad1: u32,
}

@group(1) @binding(13) var<uniform> blend_parameters: BlendParameters;
@group(1) @binding(28) var image: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_output_row;
    if id.x >= frame.size.x || y >= frame.end_output_row {
        return;
    }
    let pixel = pixel_index(id.x, y);
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    var color = vec3<f32>(0.0);
    var transmitted = 1.0;
    for (var layer = 0u; layer < count; layer++) {
        let next = layer_lit(base + layer);
        let whole = clamp(next.a * blend_parameters.opacity, 0.0, 1.0);
        let alpha = layer_alpha(base + layer, whole, blend_parameters.ghost);
        color += (transmitted * alpha) * next.rgb;
        transmitted *= transmission(base + layer, alpha);
        if transmitted < 9.5367431640625e-7 {
            break;
        }
    }
    let with_tail = blend_tail(pixel, color, transmitted);
    textureStore(image, vec2<u32>(id.x, y), with_tail);
}
