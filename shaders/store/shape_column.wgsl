// Shape column: depth as the key has it, and the packed normal. Together, because whoever reads one mostly wants the other,
// and on a CPU rasterizer it is the number of loads that counts, not their width.

@group(1) @binding(3) var<storage, read_write> shapes: array<ShapeWords>;

// Distance along the view, scene units.
fn layer_view_depth(slot: u32) -> f32 {
    return view_depth_of_word(shapes[slot].x);
}
