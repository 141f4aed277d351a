//@ use common/frame
// Section planes, in view space.

struct Sections {
    // What a plane cuts away has xyz . point + w > 0.
    planes: array<vec4<f32>, 6>,
    // The parts from x to before y close the cut, and are not cut by this plane.
    caps: array<vec4<u32>, 6>,
    count: u32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

@group(1) @binding(29) var<uniform> sections: Sections;

fn section_cuts(section: u32, part: u32) -> bool {
    let caps = sections.caps[section];
    return part < caps.x || part >= caps.y;
}

// Signed distance from a plane, scene units.
fn height_over(section: u32, point: vec3<f32>) -> f32 {
    let plane = sections.planes[section];
    return dot(plane.xyz, point) + plane.w;
}

// How far from a plane, scene units, rasterization cannot tell on which side a surface is: 1/64 pixel, and what 32-bit
// positions round.
fn section_margin(depth: f32) -> f32 {
    return pixel_size(depth).y * 0.015625 + abs(depth) * 4.76837158203125e-7;
}
