// What opacity models without transfer functions are set by.

struct ModelParameters {
    // Opacity of all layers of a pixel together.
    share: f32,
    // Opacity at the lower and at the upper end of what the model follows.
    low: f32,
    high: f32,
    // Sensitivity, times the image's shorter side in pixels.
    scale: f32,
}
@group(1) @binding(13) var<uniform> model_parameters: ModelParameters;

fn with_opacity(color: vec4<f32>, alpha: f32) -> vec4<f32> {
    return vec4<f32>(color.rgb, clamp(color.a * alpha, 0.0, 1.0));
}
