//@ use store/part_table
// The opacity that a part has of its own: a factor of what the model gives (or of 1, for a solid part), after it is
// clamped, so that lines fade too. Pure products: a ghosted layer has exactly `ghost` times the opacity of a shown one.

const LOOK_SOLID: u32 = 0x80000000u;
const LOOK_GHOSTED: u32 = 0x40000000u;
const LOOK_FACTOR: u32 = 0x3FFFFFFFu;

fn part_alpha(part: u32, alpha: f32, ghost: f32) -> f32 {
    let look = part_table[part].look;
    let whole = select(alpha, 1.0, (look & LOOK_SOLID) != 0u);
    return whole * bitcast<f32>(look & LOOK_FACTOR) * select(1.0, ghost, (look & LOOK_GHOSTED) != 0u);
}
