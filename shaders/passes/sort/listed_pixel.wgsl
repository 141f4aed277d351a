// The pixel that an invocation of a sort is for, or EMPTY.

@group(1) @binding(27) var<storage, read_write> classes: array<u32>;
@group(1) @binding(28) var<storage, read_write> class_pixels: array<u32>;

fn listed_pixel(group: vec3<u32>, local: u32) -> u32 {
    let index = (group.y * SORT_ROW + group.x) * 256u + local;
    if index >= classes[4u * SORT_CLASS] {
        return EMPTY;
    }
    return class_pixels[classes[4u * SORT_CLASS + 1u] + index];
}
