//@ use common/frame
//@ use store/open_dispatch
// The layers that lack a neighbour, listed, for dispatches of one invocation each. They are few, and a CPU rasterizer executes
// branches that no lane takes.

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
    let place = open_place(group, local);
    if !is_listed(place) {
        return Lacking(false, vec2<u32>(0u), 0u);
    }
    let item = open_layers[place];
    let width = frame.size.x;
    let at = vec2<u32>(item.x % width, item.x / width + frame.first_row);
    return Lacking(true, at, layer_base(item.x) + (item.y >> 2u));
}

// The adjacent pixel in a direction in which a neighbour is missing: there is one.
struct Across {
    at: vec2<u32>,
    pixel: u32,
    base: u32,
    count: u32,
}

fn across(own: Lacking, direction: u32) -> Across {
    let ahead = vec2<u32>(u32(direction < 2u), u32(direction >= 2u));
    let at = select(own.at + ahead, own.at - ahead, (direction & 1u) != 0u);
    let pixel = pixel_index(at.x, at.y);
    return Across(at, pixel, layer_base(pixel), layer_count(pixel));
}
