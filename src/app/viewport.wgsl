// A picture into a rectangle of the window.

struct Place {
    // Of the rectangle in the window, pixels.
    origin: vec2f,
    size: vec2f,
    // From the viewport to the picture, both from -1 to 1 with y up, homogeneous.
    moved: mat3x3f,
    background: vec4f,
    // 1 to show a checkerboard where the picture is transparent.
    checker: f32,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<uniform> place: Place;
@group(0) @binding(2) var linear: sampler;

@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn over_checkerboard(color: vec4f, at: vec2f) -> vec4f {
    let cell = vec2u(at) / 12u;
    let shade = select(0.36, 0.42, ((cell.x + cell.y) & 1u) == 1u);
    let opacity = mix(1.0, color.a, place.checker);
    return vec4f(for_surface(mix(vec3f(shade), color.rgb, opacity)), 1.0);
}

// Pixel for pixel.
@fragment
fn unchanged(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = position.xy - place.origin;
    return over_checkerboard(textureLoad(picture, vec2i(at), 0), at);
}

// Moved along with the view, and filtered.
@fragment
fn moved(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = position.xy - place.origin;
    let here = (at / place.size * 2.0 - 1.0) * vec2f(1.0, -1.0);
    let p = place.moved * vec3f(here, 1.0);
    let there = p.xy / p.z;
    let found = textureSampleLevel(picture, linear, there * vec2f(0.5, -0.5) + 0.5, 0.0);
    // A little beyond the edge is rounding, further there is nothing to know.
    let outside = p.z <= 0.0 || any(abs(there) > vec2f(1.005));
    let beyond = vec4f(place.background.rgb, 1.0 - place.checker);
    return over_checkerboard(select(found, beyond, outside), at);
}
