//@ use passes/opacity/transfer
// Style of the tail under transfer functions: its curvature is unknown, so it counts as flat (T10).

fn tail_style(color: vec4<f32>, depth: f32) -> vec4<f32> {
    return vec4<f32>(tinted(color.rgb, color_of_kappa(0.0)), color.a * opacity_of(depth01_of(depth), 0.0));
}
