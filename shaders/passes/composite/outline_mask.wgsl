// Outline mask: every pixel that is covered, whatever is in front.

@fragment
fn fragment_main(v: Varyings) -> @location(0) vec4<f32> {
    let clipped = is_clipped(v.position, v.part);
    if clipped || is_cut_out(v) {
        discard;
    }
    return vec4<f32>(1.0);
}
