//@ use passes/operators/around
//@ use passes/opacity/model_parameters
//@ use store/shapes
// Opacity by normal variation (after Born 2010): how fast the normal turns across the image, between real neighbours instead of
// by screen derivatives, so that nothing is seen where one surface passes before another.

// The turn of the normal in a pixel, along one axis.
fn turn(slot: u32, ahead: u32, behind: u32, steps: f32) -> vec3<f32> {
    if ahead == slot && behind == slot {
        return vec3<f32>(0.0);
    }
    return (layer_shape(ahead).normal - layer_shape(behind).normal) / steps;
}

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let slot = at.base + at.index;
    let around = around(slot, beside(at.x, at.pixel));
    let there = vec4<f32>(around.there);
    let u = turn(slot, around.slots.x, around.slots.y, there.x + there.y);
    let v = turn(slot, around.slots.z, around.slots.w, there.z + there.w);
    let variation = 1.0 - exp(-model_parameters.scale * sqrt(dot(u, u) + dot(v, v)));
    return with_opacity(color, mix(model_parameters.low, model_parameters.high, variation));
}
