//@ use passes/operators/around
//@ use passes/illustration/parameters
//@ use passes/illustration/ends_column
//@ use store/lit
// Initial and boundary conditions (Carnecky 2013, sections 5.2 and 5.3). A layer that lacks a neighbour is a silhouette. One
// whose index is less than its neighbour's lies beside what ends there and covers the neighbour: the halo begins. One whose
// index is greater lies under what ends: no highlight may pass. A step of the index counts only if something in front really
// ends there, since touching faces swap places from pixel to pixel (T19).

fn operate(at: Layer, own: vec4<f32>, around: Around, beside: Beside) -> vec4<f32> {
    let bare = vec4<bool>(illustration.printed == PRINTED_INDEX_STEPS);
    let own_ends = vec4<u32>(
        nearest_end(at.pixel, 0u), nearest_end(at.pixel, 1u), nearest_end(at.pixel, 2u), nearest_end(at.pixel, 3u),
    );
    // Of the adjacent pixels, on the side of this one.
    let other_ends = vec4<u32>(
        nearest_end(beside.pixels.x, 1u),
        nearest_end(beside.pixels.y, 0u),
        nearest_end(beside.pixels.z, 3u),
        nearest_end(beside.pixels.w, 2u),
    );
    let index = vec4<u32>(at.index);
    let is_end = any(around.links == vec4<u32>(MISSING));
    let is_under = any(around.there & (index > around.links) & (bare | (own_ends < index)));
    let is_beside = any(around.there & (index < around.links) & (bare | (other_ends < around.links)));
    let alpha = clamp(layer_lit(at.base + at.index).a * illustration.constant, 0.0, 1.0);
    let fixed = select(0u, FIXED_BETA, is_end || is_under) | select(0u, FIXED_GAMMA, is_beside);
    return vec4<f32>(alpha, select(0.0, 1.0, is_end), select(0.0, 1.0, is_beside), f32(fixed));
}
