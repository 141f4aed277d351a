//@ use store/shape_column
// Depth and normal of layers.

struct Shape {
    // Distance along the view, scene units.
    depth: f32,
    // Unit, view space, on the viewer's side.
    normal: vec3<f32>,
}

fn layer_shape(slot: u32) -> Shape {
    let words = shapes[slot];
    return Shape(view_depth_of_word(words.x), unpack_normal(normal_words(words)));
}
