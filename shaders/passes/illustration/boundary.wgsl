//@ use passes/operators/around
//@ use passes/illustration/parameters
//@ use passes/illustration/ends_column
//@ use store/lit
// Initial and boundary conditions (Carnecky 2013, sections 5.2 and 5.3). A layer that lacks a neighbour is a silhouette. One
// whose index is less than its neighbour's lies beside what ends there and covers the neighbour: the halo begins. One whose
// index is greater lies under what ends: no highlight may pass.

fn operate(at: Layer, own: vec4<f32>, around: Around, beside: Beside) -> vec4<f32> {
    let bare = illustration.printed == PRINTED_INDEX_STEPS;
    let is_end = any(around.links == vec4<u32>(MISSING));
    let link = around.links;
    let other = beside.pixels;
    let is_under = any(around.there & vec4<bool>(
        lies_under(at.pixel, at.index, link.x, 0u, bare), lies_under(at.pixel, at.index, link.y, 1u, bare),
        lies_under(at.pixel, at.index, link.z, 2u, bare), lies_under(at.pixel, at.index, link.w, 3u, bare),
    ));
    let is_beside = any(around.there & vec4<bool>(
        lies_beside(other.x, at.index, link.x, 0u, bare), lies_beside(other.y, at.index, link.y, 1u, bare),
        lies_beside(other.z, at.index, link.z, 2u, bare), lies_beside(other.w, at.index, link.w, 3u, bare),
    ));
    let alpha = clamp(layer_lit(at.base + at.index).a * illustration.constant, 0.0, 1.0);
    let fixed = select(0u, FIXED_BETA, is_end || is_under) | select(0u, FIXED_GAMMA, is_beside);
    return vec4<f32>(alpha, select(0.0, 1.0, is_end), select(0.0, 1.0, is_beside), f32(fixed));
}
