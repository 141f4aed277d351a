//@ use common/frame
// As printed (Murray 2016, section 5.1): a neighbour is expected at the layer's own depth.

fn expected_depths(x: u32, y: u32, depth: f32, normal: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(depth);
}
