// Blends the averaged tail behind the stored layers: mean colour, and the opacity that its fragments have together.

@group(1) @binding(25) var<storage, read_write> tail: array<u32>;

fn blend_tail(pixel: u32, color: vec3<f32>, transmitted: f32) -> vec4<f32> {
    let weight = f32(tail[6u * pixel + 3u]);
    if weight <= 0.0 {
        return vec4<f32>(color, 1.0 - transmitted);
    }
    let sum = vec3<f32>(f32(tail[6u * pixel]), f32(tail[6u * pixel + 1u]), f32(tail[6u * pixel + 2u]));
    let through = exp2(-f32(tail[6u * pixel + 4u]) / 4096.0);
    let behind = color + (transmitted * (1.0 - through)) * (sum / weight);
    return vec4<f32>(behind, 1.0 - transmitted * through);
}
