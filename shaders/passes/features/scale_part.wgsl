//@ use store/part_column
//@ use store/part_table
// Curvature is measured in the radius of the layer's part.

fn curvature_scale(slot: u32) -> f32 {
    return curvature_parameters.part_scale * part_table[parts[slot]].radius;
}
