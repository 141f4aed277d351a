// Parts have no opacity of their own.

fn part_alpha(part: u32, alpha: f32, ghost: f32) -> f32 {
    return alpha;
}
