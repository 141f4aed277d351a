// Continuity as printed (Carnecky 2013, equation 1): the difference keeps its sign, and only one layer's slope counts. Kept to
// show that most links then go one way (T13).

fn depth_measure(difference: f32, back: f32) -> f32 {
    return difference;
}

// How far a layer is from where `other`, in the adjacent pixel that `direction` leads to, expects it.
fn difference_back(x: u32, y: u32, direction: u32, depth: f32, part: u32, other: Shape) -> f32 {
    return 0.0;
}
