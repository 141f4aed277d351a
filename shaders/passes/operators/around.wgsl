//@ use passes/operators/layer
//@ use store/links
// The four neighbours of a layer, for operators that look at them: right, left, down, up.

struct Beside {
    // The adjacent pixels; the pixel itself beyond the edge of what is captured.
    pixels: vec4<u32>,
    // Where their layers begin.
    bases: vec4<u32>,
}

fn beside(x: u32, pixel: u32) -> Beside {
    let width = frame.size.x;
    let pixels = select(
        vec4<u32>(pixel),
        vec4<u32>(pixel + 1u, pixel - 1u, pixel + width, pixel - width),
        vec4<bool>((x + 1u < width), (x > 0u), (pixel + width < pixels_in_store()), (pixel >= width)),
    );
    return Beside(
        pixels,
        vec4<u32>(layer_base(pixels.x), layer_base(pixels.y), layer_base(pixels.z), layer_base(pixels.w)),
    );
}

struct Around {
    // Index of the neighbour in its pixel, MISSING or UNKNOWN.
    links: vec4<u32>,
    // Whether there is one.
    there: vec4<bool>,
    // Its slot; the layer's own where there is none.
    slots: vec4<u32>,
}

fn around(slot: u32, beside: Beside) -> Around {
    let ahead = links_ahead[slot];
    let behind = links_behind[slot];
    let links = vec4<u32>(ahead & 0xFFFFu, behind.x, ahead >> 16u, behind.y);
    let there = links < vec4<u32>(UNKNOWN);
    return Around(links, there, select(vec4<u32>(slot), beside.bases + links, there));
}
