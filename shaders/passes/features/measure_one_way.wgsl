// Epsilon_z is the square of the difference to where a layer expects the other one; where that expects the layer does not
// count.

fn depth_measure(difference: f32, back: f32) -> f32 {
    return difference * difference;
}

fn depth_measures(differences: vec2<f32>, back: vec2<f32>) -> vec2<f32> {
    return differences * differences;
}

// The least that epsilon can be with this difference.
fn least_measures(differences: vec2<f32>) -> vec2<f32> {
    return differences * differences;
}

// How far a layer is from where `other`, in the adjacent pixel that `direction` leads to, expects it.
fn difference_back(x: u32, y: u32, direction: u32, depth: f32, part: u32, other: Shape) -> f32 {
    return 0.0;
}
