// Normal column: unit, view space, on the viewer's side.

@group(1) @binding(3) var<storage, read_write> normals: array<u32>;

fn layer_normal(slot: u32) -> vec3<f32> {
    return unpack_normal(normals[slot]);
}
