//@ use common/frame
//@ use common/packing
// Writes the opaque pass's colours to the image; alpha 0 where nothing was drawn.

@group(1) @binding(15) var opaque_colors: texture_2d<u32>;
@group(1) @binding(28) var image: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.size.y {
        return;
    }
    let color = unpack_half4(textureLoad(opaque_colors, id.xy, 0).xy);
    textureStore(image, id.xy, vec4<f32>(color.rgb * color.a, color.a));
}
