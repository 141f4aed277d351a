// Accumulate: adds one jittered frame to the sum of the others. The sum moves between two textures.

@group(1) @binding(15) var sample_image: texture_2d<f32>;
@group(1) @binding(16) var sum_before: texture_2d<f32>;
@group(1) @binding(28) var sum_after: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(sample_image);
    if id.x >= size.x || id.y >= size.y {
        return;
    }
    let sum = textureLoad(sum_before, id.xy, 0) + textureLoad(sample_image, id.xy, 0);
    textureStore(sum_after, id.xy, sum);
}
