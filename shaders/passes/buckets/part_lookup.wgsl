//@ use store/part_column
// Fills the part column from the keys: the part follows from the triangle's number.

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let base = layer_base(pixel);
    let count = layer_count(pixel);
    for (var i = 0u; i < count; i++) {
        parts[base + i] = part_of_layer(base + i);
    }
}
