// Octahedral normals, 16 + 16 bits signed: worst error 0.004 degrees (T9).

fn pack_normal(n: vec3<f32>) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    return pack2x16snorm(select(folded, p, n.z >= 0.0));
}

fn unpack_normal(word: u32) -> vec3<f32> {
    let p = unpack2x16snorm(word);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let t = max(-z, 0.0);
    let xy = p - select(vec2<f32>(-t), vec2<f32>(t), p >= vec2<f32>(0.0));
    return normalize(vec3<f32>(xy, z));
}
