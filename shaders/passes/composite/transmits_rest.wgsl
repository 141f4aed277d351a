// What passes a layer is what it does not cover.

fn transmission(slot: u32, alpha: f32) -> f32 {
    return 1.0 - alpha;
}
