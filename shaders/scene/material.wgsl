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

// Turns the interpolated normal to the viewer's side; a degenerate one becomes the direction to the eye.
fn facing_normal(normal: vec3<f32>, side: bool) -> vec3<f32> {
    let squared = dot(normal, normal);
    if !(squared > 1e-20 && squared < 1e20) {
        return vec3<f32>(0.0, 0.0, 1.0);
    }
    return normal * (inverseSqrt(squared) * select(-1.0, 1.0, side));
}
