//@ use common/frame
// Sorts pixels into classes by the length of their lists, so that each sort runs over exactly the pixels it is for. A CPU
// rasterizer executes a kernel's whole body for every group of lanes, active or not, and a GPU still schedules the waves:
// without lists, one deep pixel would cost as much as a million.
//
// Three entry points: lengths are counted, places and dispatch arguments computed, pixels listed.

// For each class: pixels, place of its first pixel in the list, cursor, unused.
@group(1) @binding(27) var<storage, read_write> classes: array<atomic<u32>>;
@group(1) @binding(28) var<storage, read_write> class_pixels: array<u32>;
// Arguments of an indirect dispatch a class.
@group(1) @binding(29) var<storage, read_write> sort_arguments: array<u32>;

var<workgroup> lengths: array<atomic<u32>, 8>;

fn class_of(count: u32) -> u32 {
    return min(32u - countLeadingZeros(count - 1u), LARGEST_CLASS);
}

@compute @workgroup_size(16, 16)
fn count_classes(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    if has_pixel(id.xy) {
        let count = layer_count(pixel_at(id.xy));
        if count > 0u {
            atomicAdd(&lengths[class_of(count)], 1u);
        }
    }
    workgroupBarrier();
    if local <= LARGEST_CLASS {
        let length = atomicLoad(&lengths[local]);
        if length > 0u {
            atomicAdd(&classes[4u * local], length);
        }
    }
}

@compute @workgroup_size(1)
fn place_classes() {
    var place = 0u;
    for (var class_ = 0u; class_ <= LARGEST_CLASS; class_++) {
        let pixels = atomicLoad(&classes[4u * class_]);
        atomicStore(&classes[4u * class_ + 1u], place);
        atomicStore(&classes[4u * class_ + 2u], place);
        place += pixels;
        let groups = (pixels + 255u) / 256u;
        sort_arguments[3u * class_] = min(groups, SORT_ROW);
        sort_arguments[3u * class_ + 1u] = (groups + SORT_ROW - 1u) / SORT_ROW;
        sort_arguments[3u * class_ + 2u] = 1u;
    }
}

@compute @workgroup_size(16, 16)
fn list_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let count = layer_count(pixel);
    if count > 0u {
        class_pixels[atomicAdd(&classes[4u * class_of(count) + 2u], 1u)] = pixel;
    }
}
