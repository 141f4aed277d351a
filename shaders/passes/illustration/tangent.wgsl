//@ use store/shapes
//@ use passes/features/point_aside
// Tangent planes of layers, and how closely something lies to them.

struct Tangent {
    // Of the layer, view space.
    position: vec3<f32>,
    normal: vec3<f32>,
    // How far along the sight line something is off, if it is a pixel's size off the plane; at most 20 of those.
    reach: f32,
}

fn tangent_of(at: vec2<u32>, shape: Shape) -> Tangent {
    let position = position_in_view(at.x, at.y, shape.depth);
    let facing = dot(shape.normal, to_eye(position));
    return Tangent(position, shape.normal, pixel_size(shape.depth).y / max(facing, 0.05));
}

// The plane's depth in the adjacent pixel to the right, left, below or above.
fn depth_aside(tangent: Tangent, direction: u32) -> f32 {
    let ahead = select(vec2<f32>(frame.unproject.x, 0.0), vec2<f32>(0.0, frame.unproject.y), direction >= 2u);
    let step = select(ahead, -ahead, (direction & 1u) != 0u);
    return -point_aside(tangent.position, tangent.normal, step).z;
}
