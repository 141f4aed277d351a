//@ use common/frame
// A neighbour is expected where the layer's tangent plane crosses the adjacent pixel (T18). Exact on planes, perspective or
// not. A surface that is seen nearly edge-on is given at most the slope of 1 : 20.

fn expected_depth(p: vec3<f32>, n: vec3<f32>, step: vec2<f32>) -> f32 {
    let depth = -p.z;
    if frame.orthographic != 0u {
        return depth + dot(n.xy, step) / max(n.z, 0.05);
    }
    // Along the ray of the adjacent pixel, per unit of depth: n . (ray * d - p) = 0.
    let ray = p.xy / depth + step;
    let toward = n.z - dot(n.xy, ray);
    let away = n.z * depth - dot(n.xy, p.xy);
    return select(depth, away / toward, toward > 0.05 && away > 0.0);
}

fn expected_depths(x: u32, y: u32, depth: f32, normal: vec3<f32>) -> vec4<f32> {
    let p = position_in_view(x, y, depth);
    let s = frame.unproject.xy;
    return vec4<f32>(
        expected_depth(p, normal, vec2<f32>(s.x, 0.0)),
        expected_depth(p, normal, vec2<f32>(-s.x, 0.0)),
        expected_depth(p, normal, vec2<f32>(0.0, s.y)),
        expected_depth(p, normal, vec2<f32>(0.0, -s.y)),
    );
}
