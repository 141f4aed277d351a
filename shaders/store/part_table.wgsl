// Parts: number of the first triangle, and the radius by which depth differences are normalized (T7).

struct PartFacts {
    first_triangle: u32,
    inverse_radius: f32,
    radius: f32,
    _pad: u32,
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
