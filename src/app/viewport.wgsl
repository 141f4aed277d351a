// A picture into a rectangle of the window.

struct Place {
    // Of the rectangle in the window, pixels.
    origin: vec2f,
    size: vec2f,
    // Size of the picture.
    picture_size: vec2f,
    // 1 to show a checkerboard where the picture is transparent.
    checker: f32,
    _pad: f32,
    background: vec4f,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<uniform> place: Place;

@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn filtered(at: vec2f) -> vec4f {
    let p = at - 0.5;
    let whole = floor(p);
    let t = p - whole;
    let last = vec2i(place.picture_size) - 1;
    let a = clamp(vec2i(whole), vec2i(0), last);
    let b = clamp(vec2i(whole) + 1, vec2i(0), last);
    let top = mix(textureLoad(picture, a, 0), textureLoad(picture, vec2i(b.x, a.y), 0), t.x);
    let bottom = mix(textureLoad(picture, vec2i(a.x, b.y), 0), textureLoad(picture, b, 0), t.x);
    return mix(top, bottom, t.y);
}

@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = position.xy - place.origin;
    var color: vec4f;
    if all(place.size == place.picture_size) {
        color = textureLoad(picture, vec2i(at), 0);
    } else {
        let scale = place.picture_size.y / place.size.y;
        let from = (at - place.size * 0.5) * scale + place.picture_size * 0.5;
        // Rounding may leave a preview half a pixel short of the edge.
        if any(from < vec2f(-1.0)) || any(from > place.picture_size + 1.0) {
            color = place.background * (1.0 - place.checker);
        } else {
            color = filtered(from);
        }
    }
    if place.checker > 0.5 {
        let cell = vec2u(at) / 12u;
        let shade = select(0.36, 0.42, ((cell.x + cell.y) & 1u) == 1u);
        color = vec4f(mix(vec3f(shade), color.rgb, color.a), 1.0);
    }
    return vec4f(color.rgb, 1.0);
}
