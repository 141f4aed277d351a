//@ use common/frame
//@ use scene/instance
// Geometry for the pass that needs depth, identity and the scaled parameters of the surface.

struct Varyings {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, first) triangle: u32,
    @location(1) @interpolate(flat, first) part: u32,
    @location(2) parameters: vec2<f32>,
}

@vertex
fn vertex_main(
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) triangle: u32,
    @location(2) parameters: vec3<f32>,
) -> Varyings {
    let instance = instances[instance_index];
    let point = place(instance, position);
    var out: Varyings;
    out.position = frame.clip_from_view * vec4<f32>(point, 1.0);
    out.triangle = instance.ids.x + (triangle & ~OPPOSED);
    out.part = instance.ids.y;
    out.parameters = parameters.xy;
    return out;
}
