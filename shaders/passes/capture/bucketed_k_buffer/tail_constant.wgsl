// Style of the tail under constant opacity.

struct TransferParameters {
    color_mode: u32,
    gain: f32,
    constant: f32,
    ghost: f32,
}
@group(1) @binding(26) var<uniform> transfer: TransferParameters;

fn tail_style(color: vec4<f32>, depth: f32) -> vec4<f32> {
    return vec4<f32>(color.rgb, color.a * transfer.constant);
}
