//@ use passes/operators/layer
//@ use passes/opacity/transfer
//@ use store/shape_column
// Mean-curvature transparency (Murray 2016, section 5.2): the colour function over kappa changes the lit colour, the opacity
// function over depth and |kappa| gives opacity.

@group(1) @binding(14) var<storage, read_write> kappas: array<f32>;

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let slot = at.base + at.index;
    let kappa = kappas[slot];
    let alpha = opacity_of(depth01_of(layer_view_depth(slot)), kappa);
    return vec4<f32>(tinted(color.rgb, color_of_kappa(kappa)), clamp(color.a * alpha, 0.0, 1.0));
}
