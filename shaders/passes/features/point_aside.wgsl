//@ use common/frame
// The tangent plane of a layer beside it. Seen nearly edge-on, it is given at most the slope of 1 : 20.

// Where the tangent plane through p is met by the sight line one step aside.
fn point_aside(p: vec3<f32>, n: vec3<f32>, step: vec2<f32>) -> vec3<f32> {
    if frame.orthographic != 0u {
        return p + vec3<f32>(step, -dot(n.xy, step) / max(n.z, 0.05));
    }
    let depth = -p.z;
    let ray = p.xy / depth + step;
    let toward = max(n.z - dot(n.xy, ray), 0.05);
    return vec3<f32>(ray, -1.0) * (depth + depth * dot(n.xy, step) / toward);
}
