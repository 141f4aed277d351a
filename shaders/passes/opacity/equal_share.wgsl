//@ use passes/operators/layer
//@ use passes/operators/gathered
//@ use passes/opacity/model_parameters
// Equal shares: a layer's opacity by its index, from the table that was settled for the whole image.

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    return with_opacity(color, settled[min(at.index, GATHERED - 2u)]);
}
