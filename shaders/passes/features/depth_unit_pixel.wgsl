//@ use common/frame
// In pixels: along a surface, the depth expected is right to a small part of a pixel, and another wall of the same part is
// off by its thickness, however small that is beside the part.

fn inverse_depth_unit(depth: f32, part: u32) -> f32 {
    return 1.0 / pixel_size(depth).y;
}
