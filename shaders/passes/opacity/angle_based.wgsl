//@ use passes/operators/layer
//@ use passes/opacity/model_parameters
//@ use store/shapes
// Angle-based opacity (Hummel 2010): from the angle between normal and sight line, 0 to 90 degrees.

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let shape = layer_shape(at.base + at.index);
    let eye = to_eye(position_in_view(at.x, at.y, shape.depth));
    let angle = acos(clamp(abs(dot(shape.normal, eye)), 0.0, 1.0)) * 0.6366197723675814;
    return with_opacity(color, mix(model_parameters.low, model_parameters.high, angle));
}
