// There are no fields yet.

fn field_of(slot: u32) -> vec4<f32> {
    return vec4<f32>(0.0);
}
