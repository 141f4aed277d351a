fn blend_tail(pixel: u32, color: vec3<f32>, transmitted: f32) -> vec4<f32> {
    return vec4<f32>(color, 1.0 - transmitted);
}
