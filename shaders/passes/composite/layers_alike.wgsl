// Layers have the opacity that the model gives.

fn layer_alpha(slot: u32, alpha: f32, ghost: f32) -> f32 {
    return alpha;
}
