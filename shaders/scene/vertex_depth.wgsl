//@ use common/frame
//@ use scene/instance
// Geometry for passes that need only depth and identity.

struct Varyings {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, first) triangle: u32,
    @location(1) @interpolate(flat, first) part: u32,
}

@vertex
fn vertex_main(
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) triangle: u32,
) -> Varyings {
    let instance = instances[instance_index];
    let point = place(instance, position);
    var out: Varyings;
    out.position = frame.clip_from_view * vec4<f32>(point, 1.0);
    out.triangle = instance.ids.x + (triangle & ~OPPOSED);
    out.part = instance.ids.y;
    return out;
}

fn is_cut_out(v: Varyings) -> bool {
    return false;
}
