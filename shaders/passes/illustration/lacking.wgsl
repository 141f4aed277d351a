//@ use common/frame
//@ use store/open_layers
// The layers that lack a neighbour, listed, for dispatches of one invocation each. They are few, and a CPU rasterizer executes
// branches that no lane takes.

// Workgroups in x, y, z.
@group(1) @binding(16) var<storage, read_write> open_arguments: array<u32>;

// Workgroups in a row of the dispatch.
const ROW: u32 = 32768u;

fn arrange_lacking() {
    let groups = (atomicLoad(&open_count[0]) + 63u) / 64u;
    open_arguments[0] = min(groups, ROW);
    open_arguments[1] = (groups + ROW - 1u) / ROW;
    open_arguments[2] = 1u;
}

fn list_lacking(pixel: u32, index: u32) {
    list_open(pixel, index, 0u);
}

struct Lacking {
    // Whether the invocation has a layer.
    is_one: bool,
    // Column and row in the image.
    at: vec2<u32>,
    slot: u32,
}

fn lacking_of(group: vec3<u32>, local: u32) -> Lacking {
    let place = (group.y * ROW + group.x) * 64u + local;
    if place >= atomicLoad(&open_count[0]) {
        return Lacking(false, vec2<u32>(0u), 0u);
    }
    let item = open_layers[place];
    let width = frame.size.x;
    let at = vec2<u32>(item.x % width, item.x / width + frame.first_row);
    return Lacking(true, at, layer_base(item.x) + (item.y >> 2u));
}

// The adjacent pixel in a direction in which a neighbour is missing: there is one.
fn adjacent_to(at: vec2<u32>, direction: u32) -> vec2<u32> {
    let step = vec2<u32>(u32(direction < 2u), u32(direction >= 2u));
    return select(at + step, at - step, (direction & 1u) != 0u);
}
