//@ use passes/lit_color
//@ use store/pack_color_half
// Opaque: when every surface is opaque there is nothing to capture; the nearest fragment is lit and kept by the depth test.
// The surface goes through the store's formats, so that the picture equals that of a capture bit for bit.

struct ShadeParameters {
    lights: Lights,
}

@group(1) @binding(13) var<uniform> lights: ShadeParameters;

@fragment
fn fragment_main(v: Varyings, @builtin(front_facing) front_facing: bool) -> @location(0) vec2<u32> {
    let clipped = is_clipped(v.position, v.part);
    var s = captured_surface(v, front_facing);
    s.color = recolored(v.part, s.color);
    if clipped || is_cut_out(v) {
        discard;
    }
    let word = pack_material(MaterialWord(s.metallic, s.roughness, s.occlusion, s.unlit, s.back_side));
    let position = vec2<u32>(v.position.xy);
    let depth = view_depth_of_key(depth_key_of(v.position));
    let eye = to_eye(position_in_view(position.x, position.y, depth));
    let normal = unpack_normal(pack_normal(s.normal));
    let color = lit_color(as_stored(s.color), normal, vec2<u32>(word, pack_rgb9e5(s.emissive)), eye);
    return pack_half4(color);
}
