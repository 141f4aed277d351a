//@ use store/lit
//@ use passes/opacity/transfer
// The same where neither function varies with curvature: no neighbours and no curvature are needed.

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.size.x || y < frame.first_output_row || y >= frame.end_output_row {
        return;
    }
    let pixel = pixel_index(id.x, y);
    let count = layer_count(pixel);
    let base = layer_base(pixel);
    for (var layer = 0u; layer < count; layer++) {
        let slot = base + layer;
        let color = layer_lit(slot);
        let alpha = opacity_of(depth01_of(layer_view_depth(slot)), 0.0);
        store_lit(slot, vec4<f32>(tinted(color.rgb, color_of_kappa(0.0)), clamp(color.a * alpha, 0.0, 1.0)));
    }
}
