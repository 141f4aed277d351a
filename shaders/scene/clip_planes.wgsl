//@ use scene/sections
// Section planes cut fragments: those beyond any plane do not exist. The point is that of the stored depth, so what is
// decided here and where features expect a surface agree.
//
// A rasterizer moves surfaces by up to 1/256 pixel. One that lies in the plane has to go as a whole, because the cap takes
// its place, so what is parallel to the plane is cut a little before it; anything else exactly there, so that neither a gap
// nor the wall itself shows at the border of its cap.

// Needs every invocation of the quad.
fn is_clipped(position: vec4<f32>, part: u32) -> bool {
    let depth = view_depth_of_z(clamp(position.z, 0.0, 1.0));
    let xy = frame.unproject.xy * (position.xy - 0.5) + frame.unproject.zw;
    let point = vec3<f32>(select(xy * depth, xy, frame.orthographic != 0u), -depth);
    let margin = section_margin(depth);
    var clipped = false;
    for (var i = 0u; i < sections.count; i++) {
        let height = height_over(i, point);
        let is_parallel = fwidth(height) < 2.0 * margin;
        clipped = clipped || (height > select(0.0, -margin, is_parallel) && section_cuts(i, part));
    }
    return clipped;
}
