//@ use scene/sections
// Section planes cut fragments: those beyond any plane do not exist. The point is that of the stored depth, so what is
// decided here and where features expect a surface agree.

fn is_clipped(position: vec4<f32>, part: u32) -> bool {
    let depth = view_depth_of_z(clamp(position.z, 0.0, 1.0));
    let xy = frame.unproject.xy * (position.xy - 0.5) + frame.unproject.zw;
    let point = vec3<f32>(select(xy * depth, xy, frame.orthographic != 0u), -depth);
    let margin = section_margin(depth);
    var clipped = false;
    for (var i = 0u; i < sections.count; i++) {
        clipped = clipped || (section_cuts(i, part) && height_over(i, point) > -margin);
    }
    return clipped;
}
