// The fields that an operator reads.

@group(1) @binding(18) var<storage, read_write> field_in: array<vec4<f32>>;

fn field_of(slot: u32) -> vec4<f32> {
    return field_in[slot];
}
