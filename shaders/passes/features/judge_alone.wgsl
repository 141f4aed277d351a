// Continuity alone says how well two layers go together.

fn judged(own: u32, other: u32, direction: u32, continuity: f32) -> f32 {
    return continuity;
}
