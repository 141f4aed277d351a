// Normals as three 32-bit floats: what the reference of the accuracy-time report takes. No error but that of the arithmetic.

fn pack_normal(n: vec3<f32>) -> vec3<u32> {
    return bitcast<vec3<u32>>(n);
}

fn unpack_normal(words: vec3<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(words);
}
