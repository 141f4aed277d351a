//@ use common/frame
//@ use store/links
//@ use passes/illustration/parameters
//@ use passes/illustration/layer_ends
//@ use passes/illustration/ends_column
// Local feature size, first half: how many neighbours follow each other from a layer on in each direction, until one is missing
// or something in front begins or ends. One invocation goes along a whole row or column against the direction it measures,
// from each pixel to the next, so that a run is its neighbour's and one more. What is unknown ends nothing (T10).

struct Sweep {
    // The pixels along the line, from the end that runs are counted to.
    first: u32,
    end: u32,
    _pad0: u32,
    _pad1: u32,
}
@group(1) @binding(28) var<uniform> sweep: Sweep;
// Four to a layer: right, left, down, up.
@group(1) @binding(27) var<storage, read_write> runs: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = frame.size.x;
    let rows = frame.end_row - frame.first_row;
    let direction = id.y;
    let is_row = direction < 2u;
    let length = select(rows, width, is_row);
    if id.x >= select(width, rows, is_row) {
        return;
    }
    // Runs to the right and below are counted from the last pixel on, those to the left and above from the first.
    let from_last = (direction & 1u) == 0u;
    let stride = select(width, 1u, is_row);
    let line = select(id.x, id.x * width, is_row);
    let bare = illustration.printed == PRINTED_INDEX_STEPS;
    let most = illustration.feature_size - 1u;
    for (var t = sweep.first; t < min(sweep.end, length); t++) {
        let pixel = line + stride * select(t, length - 1u - t, from_last);
        let other = select(pixel - stride, pixel + stride, from_last);
        let base = layer_base(pixel);
        let count = layer_count(pixel);
        for (var index = 0u; index < count; index++) {
            let link = link_of(base + index, direction);
            var run = 0u;
            // At the edge of what is captured nothing is known either; nor is it how far a surface goes on beyond a seam.
            let goes_on = link == MISSING && !bare && (layer_ends[base + index] & (ENDS << direction)) == 0u;
            if link == UNKNOWN || goes_on || (link != MISSING && t == 0u) {
                run = most;
            } else if link != MISSING
                && !lies_under(pixel, index, link, direction, bare)
                && !lies_beside(other, index, link, direction, bare) {
                run = min(most, 1u + runs[4u * (layer_base(other) + link) + direction]);
            }
            runs[4u * (base + index) + direction] = run;
        }
    }
}
