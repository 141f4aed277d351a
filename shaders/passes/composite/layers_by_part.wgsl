// Layers have an opacity by their parts besides.

fn layer_alpha(slot: u32, alpha: f32, ghost: f32) -> f32 {
    return part_alpha(part_of_layer(slot), alpha, ghost);
}
