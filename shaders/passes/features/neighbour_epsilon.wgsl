//@ use store/normals
//@ use store/links
//@ use store/part_column
//@ use store/part_table
// How well a layer of an adjacent pixel continues a fragment: epsilon = epsilon_n + epsilon_z (Murray 2016, section 5.1).
// Depth differences are measured in a length of the part or the view, so that the choice depends neither on the unit of the
// file nor on other parts (T7).

@group(1) @binding(8) var<storage, read_write> candidates: array<vec2<u32>>;

struct Seeker {
    normal: vec3<f32>,
    // One over the length in which depth differences are measured.
    inverse_unit: f32,
    // The depth that the surface is expected to have in each adjacent pixel.
    expected: vec4<f32>,
}

fn seeker_of(x: u32, row: u32, slot: u32, part: u32) -> Seeker {
    let normal = layer_normal(slot);
    let expected = expected_depths(x, row + frame.first_row, layer_view_depth(slot), normal);
    return Seeker(normal, inverse_depth_unit(layer_view_depth(slot), part), expected);
}

// x: epsilon, y: epsilon_z alone.
fn neighbour_epsilon(seeker: Seeker, direction: u32, slot: u32) -> vec2<f32> {
    let dz = (seeker.expected[direction] - layer_view_depth(slot)) * seeker.inverse_unit;
    let epsilon_z = dz * dz;
    // Half the squared chord is 1 - cosine without its cancellation, which in 32 bits hides walls thinner than 1/3000 of
    // their part's radius.
    let chord = seeker.normal - layer_normal(slot);
    return vec2<f32>(0.5 * dot(chord, chord) + epsilon_z, epsilon_z);
}

// What an adjacent pixel without a candidate means (T10).
fn absent(other: u32) -> u32 {
    return select(MISSING, UNKNOWN, overflowed(other));
}

fn store_candidates(slot: u32, found: vec4<u32>) {
    candidates[slot] = vec2<u32>(found.x | (found.y << 16u), found.z | (found.w << 16u));
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
