//@ use common/frame
//@ use scene/instance
//@ use scene/material
// Geometry and surface of primitives without textures, vertex colours or tangents.

struct Varyings {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, first) triangle: u32,
    @location(1) @interpolate(flat, first) part: u32,
    // Bit 0: the normals oppose the winding as seen in the window.
    @location(2) @interpolate(flat, first) facing: u32,
    @location(3) normal: vec3<f32>,
}

@vertex
fn vertex_main(
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) triangle: u32,
    @location(2) normal: vec3<f32>,
) -> Varyings {
    let instance = instances[instance_index];
    let point = place(instance, position);
    var out: Varyings;
    out.position = frame.clip_from_view * vec4<f32>(point, 1.0);
    out.triangle = instance.ids.x + (triangle & ~OPPOSED);
    out.part = instance.ids.y;
    out.facing = u32((triangle & OPPOSED) != 0u) ^ instance.ids.z;
    out.normal = turn_normal(instance, normal);
    return out;
}

fn is_cut_out(v: Varyings) -> bool {
    return false;
}

fn captured_surface(v: Varyings, front_facing: bool) -> Captured {
    let side = normal_side(front_facing, v.facing);
    var s: Captured;
    s.normal = facing_normal(v.normal, side, v.position);
    s.color = vec4<f32>(material.base_color.rgb, opacity_of_alpha(material.base_color.a));
    s.metallic = material.factors.x;
    s.roughness = material.factors.y;
    s.occlusion = 1.0;
    s.emissive = material.emissive.rgb;
    s.unlit = material.modes.y != 0u;
    s.back_side = !side;
    return s;
}
