//@ use passes/operators/layer
//@ use passes/opacity/transfer
//@ use store/shape_column
// The same where neither function varies with curvature: no neighbours and no curvature are needed.

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let alpha = opacity_of(depth01_of(layer_view_depth(at.base + at.index)), 0.0);
    return vec4<f32>(tinted(color.rgb, color_of_kappa(0.0)), clamp(color.a * alpha, 0.0, 1.0));
}
