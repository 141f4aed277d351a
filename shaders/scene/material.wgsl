//@ use common/frame
// Material constants, and the surface that a capture stores.

struct Material {
    base_color: vec4<f32>,
    // rgb, normal scale.
    emissive: vec4<f32>,
    // Metalness, roughness, occlusion strength, alpha cutoff.
    factors: vec4<f32>,
    // Alpha mode (0 opaque, 1 mask, 2 blend), unlit, bits of the textures present, bits of those that use uv set 1.
    modes: vec4<u32>,
    // Rows of the uv transforms: two a texture, in the order base colour, metallic-roughness, normal, occlusion, emissive.
    uv_rows: array<vec4<f32>, 10>,
}

@group(2) @binding(0) var<uniform> material: Material;

// What a fragment is before light falls on it.
struct Captured {
    normal: vec3<f32>,
    // Linear, straight; a is opacity (1 unless the material blends).
    color: vec4<f32>,
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    emissive: vec3<f32>,
    unlit: bool,
    back_side: bool,
}

// Alpha as glTF means it: what is stored as opacity.
fn opacity_of_alpha(alpha: f32) -> f32 {
    return select(1.0, clamp(alpha, 0.0, 1.0), material.modes.x == 2u);
}

// Whether the viewer is on the side that the vertex normals point to (T11).
fn normal_side(front_facing: bool, facing: u32) -> bool {
    return front_facing != ((facing & 1u) != 0u);
}

// The normal of the triangle that a fragment lies on, towards the viewer, from how its point moves across the image.
fn geometric_normal(position: vec4<f32>) -> vec3<f32> {
    let xy = frame.unproject.xy * (position.xy - 0.5) + frame.unproject.zw;
    let depth = view_depth_of_z(clamp(position.z, 0.0, 1.0));
    let point = vec3<f32>(select(xy * depth, xy, frame.orthographic != 0u), -depth);
    let normal = cross(dpdy(point), dpdx(point));
    let eye = to_eye(point);
    let scale = max(abs(normal.x), max(abs(normal.y), abs(normal.z)));
    if !(scale > 0.0 && scale < 3e38) {
        return eye;
    }
    let unit = normalize(normal / scale);
    return select(-unit, unit, dot(unit, eye) >= 0.0);
}

// Turns the interpolated normal to the viewer's side; for a degenerate one the triangle's own stands in. Needs every
// invocation of the quad.
fn facing_normal(normal: vec3<f32>, side: bool, position: vec4<f32>) -> vec3<f32> {
    let squared = dot(normal, normal);
    let geometric = geometric_normal(position);
    if !(squared > 1e-8 && squared < 1e20) {
        return geometric;
    }
    return normal * (inverseSqrt(squared) * select(-1.0, 1.0, side));
}
