//@ use passes/lit_color
//@ use store/pack_color_half
// Unsorted: every fragment is lit and blended as it comes. Wrong by design; the lower bound of the time that any transparent
// picture takes, with the same light on the same surfaces. Benchmarks compare with it.

struct ShadeParameters {
    lights: Lights,
}

@group(1) @binding(13) var<uniform> lights: ShadeParameters;

struct BlendParameters {
    opacity: f32,
    ghost: f32,
    _pad0: u32,
    _pad1: u32,
}
@group(1) @binding(26) var<uniform> blend_parameters: BlendParameters;

@fragment
fn fragment_main(v: Varyings, @builtin(front_facing) front_facing: bool) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    let s = captured_surface(v, front_facing);
    if clipped || is_cut_out(v) {
        discard;
    }
    let word = pack_material(MaterialWord(s.metallic, s.roughness, s.occlusion, s.unlit, s.back_side));
    let position = vec2<u32>(v.position.xy);
    let depth = view_depth_of_key(depth_key_of(v.position));
    let eye = to_eye(position_in_view(position.x, position.y, depth));
    let color = lit_color(s.color, s.normal, vec2<u32>(word, pack_rgb9e5(s.emissive)), eye);
    return vec4<f32>(color.rgb, color.a * blend_parameters.opacity);
}
