//@ use common/frame
// Outline: a pixel outside the mask takes the line's colour if a pixel inside is at most the line's width away.

struct OutlineParameters {
    color: vec4<f32>,
    width: f32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

@group(1) @binding(13) var<uniform> outline_parameters: OutlineParameters;
@group(1) @binding(15) var outline_mask: texture_2d<f32>;
@group(1) @binding(28) var image: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.size.y {
        return;
    }
    let center = vec2<i32>(id.xy);
    if textureLoad(outline_mask, center, 0).x > 0.5 {
        return;
    }
    let width = outline_parameters.width;
    let reach = i32(width);
    let low = max(center - reach, vec2<i32>(0));
    let high = min(center + reach, vec2<i32>(frame.size) - 1);
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            let off = vec2<f32>(vec2<i32>(x, y) - center);
            if dot(off, off) <= width * width && textureLoad(outline_mask, vec2<i32>(x, y), 0).x > 0.5 {
                textureStore(image, center, outline_parameters.color);
                return;
            }
        }
    }
}
