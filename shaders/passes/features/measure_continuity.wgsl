//@ use store/shapes
// Continuity (Carnecky 2013, equations 1 to 3), the same both ways (T13): epsilon_z is the larger of the two differences between
// a layer and where the other one's tangent plane expects it, without its sign. Equal weights, as the paper has them.

fn depth_measure(difference: f32, back: f32) -> f32 {
    return max(abs(difference), abs(back));
}

fn depth_measures(differences: vec2<f32>, back: vec2<f32>) -> vec2<f32> {
    return max(abs(differences), abs(back));
}

// The least that epsilon can be with this difference.
fn least_measures(differences: vec2<f32>) -> vec2<f32> {
    return abs(differences);
}

// How far a layer is from where `other`, in the adjacent pixel that `direction` leads to, expects it.
fn difference_back(x: u32, y: u32, direction: u32, depth: f32, part: u32, other: Shape) -> f32 {
    let step = select(vec2<u32>(1u, 0u), vec2<u32>(0u, 1u), direction >= 2u);
    let there = select(vec2<u32>(x, y) + step, vec2<u32>(x, y) - step, (direction & 1u) != 0u);
    let expected = expected_depths(there.x, there.y, other.depth, other.normal)[direction ^ 1u];
    return (expected - depth) * inverse_depth_unit(other.depth, part);
}
