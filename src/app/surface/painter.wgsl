// Egui's meshes: coloured triangles, with a texture or without. Colours are encoded in sRGB with premultiplied alpha, as egui
// has them, and are blended so.

struct Window {
    // Points.
    size: vec2f,
}

@group(0) @binding(0) var<uniform> window: Window;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var filtered: sampler;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) color: vec4f,
    @location(1) uv: vec2f,
}

@vertex
fn corner(@location(0) at: vec2f, @location(1) uv: vec2f, @location(2) color: vec4f) -> Corner {
    let there = 2.0 * at / window.size - 1.0;
    return Corner(vec4f(there.x, -there.y, 0.0, 1.0), color, uv);
}

fn written(given: vec4f) -> vec4f {
    // No colour is that bright. But llvmpipe draws shaders that do nothing but multiply with 8-bit arithmetic, where the shape of
    // what is drawn allows it, and what is drawn again in part would differ from the whole in the last bit.
    let color = min(given, vec4f(2.0));
    return vec4f(for_surface(color.rgb), color.a);
}

@fragment
fn plain(corner: Corner) -> @location(0) vec4f {
    return written(corner.color);
}

@fragment
fn textured(corner: Corner) -> @location(0) vec4f {
    // There is one level, so there is nothing to find out from derivatives.
    return written(corner.color * textureSampleLevel(image, filtered, corner.uv, 0.0));
}
