//@ use passes/operators/around
//@ use passes/illustration/lacking
//@ use passes/illustration/layer_ends
//@ use passes/illustration/ends_column
// Where surfaces end: `begin` notes the directions in which each layer lacks its neighbour, and lists those layers for `seams`
// and `behind`; `nearest`, between the two, finds for each pixel and direction the nearest layer that ends openly.

@compute @workgroup_size(16, 16)
fn begin(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    let beside = beside(id.x, pixel);
    for (var index = 0u; index < count; index++) {
        let missing = around(base + index, beside).links == vec4<u32>(MISSING);
        let directions = dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), missing), vec4<u32>(1u));
        layer_ends[base + index] = directions * (LACKS | ENDS | ENDS_OPENLY);
        if directions != 0u {
            list_lacking(pixel, index);
        }
    }
}

@compute @workgroup_size(16, 16)
fn nearest(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    var nearest = vec4<u32>(0xFFFFu);
    for (var index = 0u; index < count; index++) {
        let directions = vec4<u32>(layer_ends[base + index]) & (ENDS_OPENLY * vec4<u32>(1u, 2u, 4u, 8u));
        nearest = min(nearest, select(vec4<u32>(0xFFFFu), vec4<u32>(index), directions != vec4<u32>(0u)));
    }
    ends[pixel] = vec2<u32>(nearest.x | (nearest.y << 16u), nearest.z | (nearest.w << 16u));
}
