// The paper's normals: x and y in 15 bits each, 2 bits for the sign of z. Worst error 0.53 degrees at grazing angles (T9).

fn pack_normal(n: vec3<f32>) -> u32 {
    let q = vec2<u32>(clamp(n.xy * 0.5 + 0.5, vec2<f32>(0.0), vec2<f32>(1.0)) * 32767.0 + 0.5);
    return q.x | (q.y << 15u) | (select(0u, 1u, n.z < 0.0) << 30u);
}

fn unpack_normal(word: u32) -> vec3<f32> {
    let xy = vec2<f32>(f32(word & 0x7FFFu), f32((word >> 15u) & 0x7FFFu)) / 32767.0 * 2.0 - 1.0;
    let z = sqrt(max(1.0 - dot(xy, xy), 0.0));
    return normalize(vec3<f32>(xy, select(z, -z, (word >> 30u) != 0u)));
}
