//@ use common/frame
//@ use store/links
//@ use passes/illustration/ends_column
// Where surfaces end: for each pixel and direction the nearest layer that lacks its neighbour.

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.end_row - frame.first_row {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    var nearest = vec4<u32>(0xFFFFu);
    for (var index = 0u; index < count; index++) {
        let ahead = links_ahead[base + index];
        let behind = links_behind[base + index];
        let links = vec4<u32>(ahead & 0xFFFFu, behind.x, ahead >> 16u, behind.y);
        nearest = min(nearest, select(vec4<u32>(0xFFFFu), vec4<u32>(index), links == vec4<u32>(MISSING)));
    }
    ends[pixel] = vec2<u32>(nearest.x | (nearest.y << 16u), nearest.z | (nearest.w << 16u));
}
