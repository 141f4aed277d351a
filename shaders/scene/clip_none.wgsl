// No section plane cuts. (What may take derivatives is called before anything is discarded.)

fn is_clipped(position: vec4<f32>, part: u32) -> bool {
    return false;
}
