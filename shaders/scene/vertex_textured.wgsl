//@ use common/frame
//@ use scene/instance
//@ use scene/material
// Geometry and surface of primitives with textures, vertex colours or tangents. Textures are sampled here, in the
// capture, because only a fragment shader has derivatives.

@group(2) @binding(1) var base_color_texture: texture_2d<f32>;
@group(2) @binding(2) var base_color_sampler: sampler;
@group(2) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(2) @binding(4) var metallic_roughness_sampler: sampler;
@group(2) @binding(5) var normal_texture: texture_2d<f32>;
@group(2) @binding(6) var normal_sampler: sampler;
@group(2) @binding(7) var occlusion_texture: texture_2d<f32>;
@group(2) @binding(8) var occlusion_sampler: sampler;
@group(2) @binding(9) var emissive_texture: texture_2d<f32>;
@group(2) @binding(10) var emissive_sampler: sampler;

struct Varyings {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, first) triangle: u32,
    @location(1) @interpolate(flat, first) part: u32,
    @location(2) @interpolate(flat, first) facing: u32,
    @location(3) normal: vec3<f32>,
    @location(4) color: vec4<f32>,
    @location(5) uv: vec4<f32>,
    @location(6) tangent: vec4<f32>,
}

@vertex
fn vertex_main(
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) triangle: u32,
    @location(2) normal: vec3<f32>,
    @location(3) color: vec4<f32>,
    @location(4) uv: vec4<f32>,
    @location(5) tangent: vec4<f32>,
) -> Varyings {
    let instance = instances[instance_index];
    let point = place(instance, position);
    var out: Varyings;
    out.position = frame.clip_from_view * vec4<f32>(point, 1.0);
    out.triangle = instance.ids.x + (triangle & ~OPPOSED);
    out.part = instance.ids.y;
    out.facing = u32((triangle & OPPOSED) != 0u) ^ instance.ids.z;
    out.normal = turn_normal(instance, normal);
    out.color = color;
    out.uv = uv;
    out.tangent = vec4<f32>(turn_vector(instance, tangent.xyz), select(tangent.w, -tangent.w, instance.ids.z != 0u));
    return out;
}

fn has_texture(index: u32) -> bool {
    return (material.modes.z & (1u << index)) != 0u;
}

fn texture_uv(v: Varyings, index: u32) -> vec2<f32> {
    let set1 = (material.modes.w & (1u << index)) != 0u;
    let uv = vec3<f32>(select(v.uv.xy, v.uv.zw, set1), 1.0);
    return vec2<f32>(dot(material.uv_rows[2u * index].xyz, uv), dot(material.uv_rows[2u * index + 1u].xyz, uv));
}

fn base_color_of(v: Varyings) -> vec4<f32> {
    var color = material.base_color * v.color;
    if has_texture(0u) {
        color *= textureSample(base_color_texture, base_color_sampler, texture_uv(v, 0u));
    }
    return color;
}

fn is_cut_out(v: Varyings) -> bool {
    if material.modes.x != 1u {
        return false;
    }
    return base_color_of(v).a < material.factors.w;
}

fn captured_surface(v: Varyings, front_facing: bool) -> Captured {
    let side = normal_side(front_facing, v.facing);
    let color = base_color_of(v);
    var s: Captured;
    var normal = v.normal;
    if has_texture(2u) {
        let sampled = textureSample(normal_texture, normal_sampler, texture_uv(v, 2u)).xyz * 2.0 - 1.0;
        let unit = normalize(v.normal);
        let tangent = v.tangent.xyz - unit * dot(unit, v.tangent.xyz);
        let squared = dot(tangent, tangent);
        if squared > 1e-20 {
            let t = tangent * inverseSqrt(squared);
            let b = cross(unit, t) * v.tangent.w;
            let scale = material.emissive.w;
            normal = t * (sampled.x * scale) + b * (sampled.y * scale) + unit * max(sampled.z, 1e-3);
        }
    }
    s.normal = facing_normal(normal, side, v.position);
    s.color = vec4<f32>(color.rgb, opacity_of_alpha(color.a));
    s.metallic = material.factors.x;
    s.roughness = material.factors.y;
    if has_texture(1u) {
        let sampled = textureSample(metallic_roughness_texture, metallic_roughness_sampler, texture_uv(v, 1u));
        s.metallic *= sampled.b;
        s.roughness *= sampled.g;
    }
    s.occlusion = 1.0;
    if has_texture(3u) {
        let sampled = textureSample(occlusion_texture, occlusion_sampler, texture_uv(v, 3u)).r;
        s.occlusion = 1.0 + material.factors.z * (sampled - 1.0);
    }
    s.emissive = material.emissive.rgb;
    if has_texture(4u) {
        s.emissive *= textureSample(emissive_texture, emissive_sampler, texture_uv(v, 4u)).rgb;
    }
    s.unlit = material.modes.y != 0u;
    s.back_side = !side;
    return s;
}
