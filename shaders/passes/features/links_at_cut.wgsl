//@ use store/shapes
//@ use store/part_column
//@ use store/links
//@ use scene/sections
//@ use passes/features/point_aside
// A cut is unknown, not a silhouette (T10): a layer whose surface would go on in the adjacent pixel on the side that is cut
// away has an unknown neighbour there, whatever was found. Runs after any search.
//
// The surface goes on along its tangent plane; half a pixel more is granted, because it bends. Seen nearly edge-on, it is
// given at most the slope of 1 : 20.

// Right, left, down, up.
fn goes_on_in_cut(x: u32, y: u32, shape: Shape, part: u32) -> vec4<bool> {
    let p = position_in_view(x, y, shape.depth);
    let s = frame.unproject.xy;
    let right = point_aside(p, shape.normal, vec2<f32>(s.x, 0.0));
    let left = point_aside(p, shape.normal, vec2<f32>(-s.x, 0.0));
    let down = point_aside(p, shape.normal, vec2<f32>(0.0, s.y));
    let up = point_aside(p, shape.normal, vec2<f32>(0.0, -s.y));
    let margin = section_margin(shape.depth);
    var cut = vec4<bool>(false);
    for (var i = 0u; i < sections.count; i++) {
        if section_cuts(i, part) {
            let here = height_over(i, p);
            let there = vec4<f32>(height_over(i, right), height_over(i, left), height_over(i, down), height_over(i, up));
            cut = cut | (here + 1.5 * (there - here) > vec4<f32>(-margin));
        }
    }
    return cut;
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let unknown = goes_on_in_cut(id.x, id.y + frame.first_row, layer_shape(slot), parts[slot]);
        let ahead = links_ahead[slot];
        links_ahead[slot] = select(ahead & 0xFFFFu, UNKNOWN, unknown.x) | (select(ahead >> 16u, UNKNOWN, unknown.z) << 16u);
        links_behind[slot] = select(links_behind[slot], vec2<u32>(UNKNOWN), unknown.yw);
    }
}
