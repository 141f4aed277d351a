// Curvature is measured in one length for the whole picture.

fn curvature_scale(slot: u32) -> f32 {
    return curvature_parameters.scale;
}
