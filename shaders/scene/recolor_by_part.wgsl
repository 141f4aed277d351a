//@ use store/part_table
// Parts may have a base colour of the user's. The material's opacity stays.

fn recolored(part: u32, color: vec4<f32>) -> vec4<f32> {
    let own = part_table[part].color;
    return select(color, vec4<f32>(own.rgb, color.a), own.w != 0.0);
}
