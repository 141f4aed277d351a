//@ use store/part_table
// Differences of depth in radii of the part (T7).

fn inverse_depth_unit(depth: f32, part: u32) -> f32 {
    return part_table[part].inverse_radius;
}
