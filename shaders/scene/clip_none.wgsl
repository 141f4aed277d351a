// No section plane cuts.

fn is_clipped(position: vec4<f32>, part: u32) -> bool {
    return false;
}
