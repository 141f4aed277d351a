//@ use passes/operators/layer
//@ use passes/opacity/model_parameters
// Adaptive opacity (Carnecky 2013, equation 5): all layers of a pixel together are as opaque everywhere.

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let clear = 1.0 - model_parameters.share;
    return with_opacity(color, select(1.0 - pow(max(clear, 1e-30), 1.0 / f32(at.count)), 1.0, clear <= 0.0));
}
