//@ use store/shapes
//@ use store/part_column
//@ use store/part_table
// How well a layer of an adjacent pixel continues a fragment: epsilon = epsilon_n + epsilon_z (Murray 2016, section 5.1, after
// Carnecky 2013); a module says how differences of depth become epsilon_z.
// Depth differences are measured in a length of the part or the view, so that the choice depends neither on the unit of the
// file nor on other parts (T7).
//
// Half the squared chord is 1 - cosine without its cancellation, which in 32 bits hides walls thinner than 1/3000 of their
// part's radius. All searches must find the same, so the sum is written out in one order here, for one layer and for four.

// x: epsilon, y: the least that it can be from the difference of depth alone. `back` is `difference_back`.
fn neighbour_epsilon(normal: vec3<f32>, expected: f32, inverse_unit: f32, other: Shape, back: f32) -> vec2<f32> {
    let dz = (expected - other.depth) * inverse_unit;
    let c = normal - other.normal;
    let epsilon_z = depth_measure(dz, back);
    return vec2<f32>(0.5 * (c.x * c.x + c.y * c.y + c.z * c.z) + epsilon_z, depth_measure(dz, 0.0));
}

// Right, left, down, up: whether there is such a pixel, and which.
struct Adjacent {
    inside: vec4<bool>,
    pixels: vec4<u32>,
}

fn adjacent_of(x: u32, row: u32) -> Adjacent {
    let width = frame.size.x;
    let pixel = row * width + x;
    return Adjacent(
        vec4<bool>(x + 1u < width, x > 0u, row + 1u < frame.end_row - frame.first_row, row > 0u),
        vec4<u32>(pixel + 1u, pixel - 1u, pixel + width, pixel - width),
    );
}
