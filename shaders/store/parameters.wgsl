// Parameter column: where in its surface's parametrization a layer lies, scaled to radii of the part, and how far the parameters
// go over a pixel in x and in y. All zero for a layer whose surface has none.

@group(1) @binding(25) var<storage, read_write> parameters: array<vec4<f32>>;
