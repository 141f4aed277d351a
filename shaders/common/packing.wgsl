// Packed forms of what a fragment carries besides its normal: material word, shared-exponent light, 8-bit sRGB.

struct MaterialWord {
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    unlit: bool,
    back_side: bool,
}

fn pack_material(m: MaterialWord) -> u32 {
    let q = vec3<u32>(clamp(vec3<f32>(m.metallic, m.roughness, m.occlusion), vec3<f32>(0.0), vec3<f32>(1.0)) * 255.0 + 0.5);
    return q.x | (q.y << 8u) | (q.z << 16u) | (u32(m.unlit) << 24u) | (u32(m.back_side) << 25u);
}

fn unpack_material(word: u32) -> MaterialWord {
    let q = vec3<f32>(f32(word & 255u), f32((word >> 8u) & 255u), f32((word >> 16u) & 255u)) / 255.0;
    return MaterialWord(q.x, q.y, q.z, (word & 0x1000000u) != 0u, (word & 0x2000000u) != 0u);
}

// RGB9E5: three 9-bit mantissas under one 5-bit exponent (bias 15), as in the GPU texture format.
fn pack_rgb9e5(color: vec3<f32>) -> u32 {
    let c = clamp(color, vec3<f32>(0.0), vec3<f32>(65408.0));
    let largest = max(c.x, max(c.y, c.z));
    if largest < 1e-7 {
        return 0u;
    }
    // Exponent of the largest component from its bits: floor(log2) without rounding trouble.
    var exponent = max(-16, i32(bitcast<u32>(largest) >> 23u) - 127) + 16;
    if u32(largest / exp2(f32(exponent - 24)) + 0.5) == 512u {
        exponent += 1;
    }
    let q = vec3<u32>(c / exp2(f32(exponent - 24)) + 0.5);
    return q.x | (q.y << 9u) | (q.z << 18u) | (u32(exponent) << 27u);
}

fn unpack_rgb9e5(word: u32) -> vec3<f32> {
    let scale = exp2(f32(i32(word >> 27u) - 24));
    return vec3<f32>(f32(word & 511u), f32((word >> 9u) & 511u), f32((word >> 18u) & 511u)) * scale;
}

fn pack_half4(color: vec4<f32>) -> vec2<u32> {
    let c = clamp(color, vec4<f32>(0.0), vec4<f32>(65504.0));
    return vec2<u32>(pack2x16float(c.xy), pack2x16float(c.zw));
}

fn unpack_half4(word: vec2<u32>) -> vec4<f32> {
    return vec4<f32>(unpack2x16float(word.x), unpack2x16float(word.y));
}

fn srgb_from_linear(c: vec3<f32>) -> vec3<f32> {
    let x = clamp(c, vec3<f32>(0.0), vec3<f32>(1.0));
    return select(1.055 * pow(x, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3<f32>(0.0031308));
}

fn linear_from_srgb(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3<f32>(2.4)), c / 12.92, c <= vec3<f32>(0.04045));
}
