//@ use store/lit
//@ use passes/opacity/transfer
// Mean-curvature transparency (Murray 2016, section 5.2): the colour function over kappa changes the lit colour, the opacity
// function over depth and |kappa| gives opacity. In place in the lit column.

@group(1) @binding(14) var<storage, read_write> kappas: array<f32>;

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
        let kappa = kappas[slot];
        let color = layer_lit(slot);
        let alpha = opacity_of(depth01_of(layer_view_depth(slot)), kappa);
        store_lit(slot, vec4<f32>(tinted(color.rgb, color_of_kappa(kappa)), clamp(color.a * alpha, 0.0, 1.0)));
    }
}
