//@ use passes/operators/around
//@ use passes/illustration/parameters
//@ use passes/illustration/layer_ends
//@ use passes/illustration/ends_column
//@ use store/lit
// Initial and boundary conditions (Carnecky 2013, sections 5.2 and 5.3). A layer whose surface ends is a silhouette. One that
// lies beside what ends, and is covered by it a pixel further, is where the halo begins. One under what ends takes no
// highlight.
//
// The paper compares layer indices for that. Ours asks for what really ends openly in front of either of two neighbours: where
// one surface ends and another begins, the index may be the same, and the halo had a gap there.

fn operate(at: Layer, own: vec4<f32>, around: Around, beside: Beside) -> vec4<f32> {
    let bare = illustration.printed == PRINTED_INDEX_STEPS;
    let slot = at.base + at.index;
    let link = around.links;
    let other = beside.pixels;
    let flags = layer_ends[slot];
    let is_end = (flags & (15u * select(ENDS, LACKS, bare))) != 0u;
    let is_under = any(vec4<bool>(
        lies_under(at.pixel, at.index, link.x, 0u, bare), lies_under(at.pixel, at.index, link.y, 1u, bare),
        lies_under(at.pixel, at.index, link.z, 2u, bare), lies_under(at.pixel, at.index, link.w, 3u, bare),
    ));
    let is_beside = any(vec4<bool>(
        lies_beside(other.x, at.index, link.x, 0u, bare), lies_beside(other.y, at.index, link.y, 1u, bare),
        lies_beside(other.z, at.index, link.z, 2u, bare), lies_beside(other.w, at.index, link.w, 3u, bare),
    )) || (!bare && (flags & (15u * BEHIND)) != 0u);
    let alpha = clamp(layer_lit(slot).a * illustration.constant, 0.0, 1.0);
    let fixed = select(0u, FIXED_BETA, is_end || is_under) | select(0u, FIXED_GAMMA, is_beside);
    return vec4<f32>(alpha, select(0.0, 1.0, is_end), select(0.0, 1.0, is_beside), f32(fixed));
}
