// Transfer functions as tables (Murray 2016, section 5.2): colour over kappa (256 entries), opacity over (depth, |kappa|)
// (256 x 256), linear between entries. Buffers, not textures: samplers keep only 8 bits of the position between two texels.

@group(1) @binding(15) var<storage, read> color_table: array<vec4<f32>>;
@group(1) @binding(16) var<storage, read> opacity_table: array<f32>;

struct TransferParameters {
    // 0 tint, 1 multiply.
    color_mode: u32,
    // Multiplies the opacity.
    gain: f32,
    // Opacity of every layer under the constant model, 1 under the others.
    constant: f32,
    // Multiplies the opacity of ghosted parts.
    ghost: f32,
}
@group(1) @binding(26) var<uniform> transfer: TransferParameters;

fn color_of_kappa(kappa: f32) -> vec3<f32> {
    let at = clamp(kappa * 0.5 + 0.5, 0.0, 1.0) * 255.0;
    let low = min(u32(at), 254u);
    let a = color_table[low].rgb;
    let b = color_table[low + 1u].rgb;
    return mix(a, b, at - f32(low));
}

// Not clamped: the material's opacity is multiplied first.
fn opacity_of(depth01: f32, kappa: f32) -> f32 {
    let at = clamp(vec2<f32>(depth01, abs(kappa)), vec2<f32>(0.0), vec2<f32>(1.0)) * 255.0;
    let low = min(vec2<u32>(at), vec2<u32>(254u));
    let t = at - vec2<f32>(low);
    let entry = low.y * 256u + low.x;
    let a = opacity_table[entry];
    let b = opacity_table[entry + 1u];
    let c = opacity_table[entry + 256u];
    let d = opacity_table[entry + 257u];
    return transfer.gain * mix(mix(a, b, t.x), mix(c, d, t.x), t.y);
}

// A colour under the colour function's value, 0.5 of which changes nothing.
fn tinted(color: vec3<f32>, value: vec3<f32>) -> vec3<f32> {
    let darkened = color * min(2.0 * value, vec3<f32>(select(1.0, 2.0, transfer.color_mode == 1u)));
    if transfer.color_mode == 1u {
        return darkened;
    }
    return mix(darkened, vec3<f32>(1.0), max(2.0 * value - 1.0, vec3<f32>(0.0)));
}
