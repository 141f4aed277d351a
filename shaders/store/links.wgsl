// Neighbours of a layer: the index of a layer in the adjacent pixel to the right, left, below, above, or one of two values
// for none (T10): missing is an edge of the part, unknown is where nothing can be said. Indices have 16 bits; no pixel has so
// many layers (plan::most_layers).
//
// Links are stored by who finds them. A pixel finds what lies ahead of it, to the right and below, and with it what lies
// behind the layers there: two halves of one word ahead, a word each behind.

@group(1) @binding(8) var<storage, read_write> links_ahead: array<u32>;
@group(1) @binding(9) var<storage, read_write> links_behind: array<vec2<u32>>;

const MISSING: u32 = 0xFFFFu;
const UNKNOWN: u32 = 0xFFFEu;

// Direction: 0 right, 1 left, 2 down, 3 up.
fn link_of(slot: u32, direction: u32) -> u32 {
    switch direction {
        case 0u: { return links_ahead[slot] & 0xFFFFu; }
        case 1u: { return links_behind[slot].x; }
        case 2u: { return links_ahead[slot] >> 16u; }
        default: { return links_behind[slot].y; }
    }
}

// What an adjacent pixel without a neighbour means.
fn absent(other: u32) -> u32 {
    return select(MISSING, UNKNOWN, overflowed(other));
}
