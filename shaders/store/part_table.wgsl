// Parts: number of the first triangle, the radius by which depth differences are normalized (T7), and how the user wants
// them to look.

struct PartFacts {
    first_triangle: u32,
    inverse_radius: f32,
    radius: f32,
    // Opacity factor under flags: `passes/opacity/looks_by_part`.
    look: u32,
    // Base colour of the user's, if w is not 0.
    color: vec4<f32>,
}

@group(1) @binding(12) var<storage, read> part_table: array<PartFacts>;

// The part that a triangle belongs to: the last whose first triangle is not greater.
fn part_of_triangle(triangle: u32) -> u32 {
    var low = 0u;
    var high = arrayLength(&part_table);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if part_table[middle].first_triangle <= triangle {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}
