//@ use passes/lit_color
//@ use common/packing
//@ use store/shapes
//@ use store/lit
// Shade: light falls on every stored layer, once, whatever captured it.

struct ShadeParameters {
    lights: Lights,
}

@group(1) @binding(13) var<uniform> lights: ShadeParameters;
@group(1) @binding(5) var<storage, read_write> materials: array<vec2<u32>>;

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
        let words = materials[slot];
        let shape = layer_shape(slot);
        let eye = to_eye(position_in_view(id.x, y, shape.depth));
        store_lit(slot, lit_color(layer_color(slot), shape.normal, words, eye));
    }
}
