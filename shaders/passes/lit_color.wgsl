//@ use common/lighting
//@ use common/packing
// Light on what the store keeps of a surface. Shared by the shade pass, the opaque pass and the tail, so that all give the
// same colour.

fn lit_color(color: vec4<f32>, normal: vec3<f32>, words: vec2<u32>, eye: vec3<f32>) -> vec4<f32> {
    let m = unpack_material(words.x);
    var surface: Surface;
    surface.base_color = color.rgb;
    surface.metallic = m.metallic;
    surface.roughness = m.roughness;
    surface.occlusion = m.occlusion;
    surface.emissive = unpack_rgb9e5(words.y);
    surface.unlit = m.unlit;
    surface.back_side = m.back_side;
    let light = light_surface(surface, normal, eye, lights.lights);
    return vec4<f32>(light, color.a);
}
