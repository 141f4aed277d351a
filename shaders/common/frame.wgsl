// The frame: camera and viewport. Group 0 holds nothing else.

struct Frame {
    clip_from_view: mat4x4<f32>,
    // View-space xy of a pixel = unproject.xy * pixel + unproject.zw, per unit of depth under perspective.
    unproject: vec4<f32>,
    // Width and height of the whole image, pixels.
    size: vec2<u32>,
    // Rows whose layers are in the store: a band of the image with its apron.
    first_row: u32,
    end_row: u32,
    // Rows that this band writes to the image.
    first_output_row: u32,
    end_output_row: u32,
    orthographic: u32,
    _pad: u32,
    // Near and far depth; far only normalizes under perspective.
    near: f32,
    far: f32,
    // depth01 = (depth - depth_min) * depth_scale, over the scene's bounding sphere.
    depth_min: f32,
    depth_scale: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Whether there is a pixel for an invocation: workgroups reach over the edges of a band.
fn has_pixel(at: vec2<u32>) -> bool {
    return at.x < frame.size.x && at.y < frame.end_row - frame.first_row;
}

// Number of a pixel in its band.
fn pixel_at(at: vec2<u32>) -> u32 {
    return at.y * frame.size.x + at.x;
}

const DEPTH_KEY_OF_ONE: u32 = 0x3F800000u;
const EMPTY: u32 = 0xFFFFFFFFu;

fn pixel_index(x: u32, y: u32) -> u32 {
    return (y - frame.first_row) * frame.size.x + x;
}

fn pixel_of_position(position: vec4<f32>) -> u32 {
    return pixel_index(u32(position.x), u32(position.y));
}

fn pixels_in_store() -> u32 {
    return (frame.end_row - frame.first_row) * frame.size.x;
}

// The 32-bit depth of a fragment: smaller is nearer, never EMPTY. The one place where a key is made from a depth (T3).
fn depth_key_of(position: vec4<f32>) -> u32 {
    return DEPTH_KEY_OF_ONE - bitcast<u32>(clamp(position.z, 0.0, 1.0));
}

// Distance along the view, scene units, from clip-space z in [0, 1].
fn view_depth_of_z(z: f32) -> f32 {
    if frame.orthographic != 0u {
        return frame.far - z * (frame.far - frame.near);
    }
    return frame.near / max(z, 1e-30);
}

fn view_depth_of_key(depth_key: u32) -> f32 {
    return view_depth_of_z(bitcast<f32>(DEPTH_KEY_OF_ONE - depth_key));
}

fn depth01_of(view_depth: f32) -> f32 {
    return clamp((view_depth - frame.depth_min) * frame.depth_scale, 0.0, 1.0);
}

fn position_in_view(x: u32, y: u32, view_depth: f32) -> vec3<f32> {
    let xy = frame.unproject.xy * vec2<f32>(f32(x), f32(y)) + frame.unproject.zw;
    if frame.orthographic != 0u {
        return vec3<f32>(xy, -view_depth);
    }
    return vec3<f32>(xy * view_depth, -view_depth);
}

// Width and height of a pixel at a depth, scene units.
fn pixel_size(view_depth: f32) -> vec2<f32> {
    if frame.orthographic != 0u {
        return abs(frame.unproject.xy);
    }
    return abs(frame.unproject.xy) * view_depth;
}

// Unit vector from a point in view space to the eye.
fn to_eye(point_in_view: vec3<f32>) -> vec3<f32> {
    if frame.orthographic != 0u {
        return vec3<f32>(0.0, 0.0, 1.0);
    }
    return normalize(-point_in_view);
}
