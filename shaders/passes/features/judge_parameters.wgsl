//@ use store/parameters
// Distance in the surface's parametrization, the same both ways. What is farther than a few steps of either layer over a pixel
// lies on the other side of a seam, or on another sheet: of such, and of layers without parameters, continuity decides, and
// each of them is worse than any that is near.

const STEPS: f32 = 4.0;

fn judged(own: u32, other: u32, direction: u32, continuity: f32) -> f32 {
    let a = parameters[own];
    let b = parameters[other];
    let steps = select(vec2<f32>(a.z, b.z), vec2<f32>(a.w, b.w), direction >= 2u);
    let apart = distance(a.xy, b.xy);
    let is_near = min(steps.x, steps.y) > 0.0 && apart <= STEPS * max(steps.x, steps.y);
    // Less than 1, however far a triangle seen nearly edge-on goes over a pixel.
    return select(1.0 + continuity, apart / (1.0 + apart), is_near);
}
