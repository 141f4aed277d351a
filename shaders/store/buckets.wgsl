//@ use common/frame
// Buckets of a pixel (Murray 2016, section 4.1): its layers grouped by part. `by_part` lists the pixel's layer indices in
// (part, depth) order; the bucket table is a hash table of (part, range in by_part), H(part) = part mod slots with linear
// probing that wraps around and ends after one round (T6).

@group(1) @binding(10) var<storage, read_write> by_part: array<u32>;
// x: part or EMPTY; y: first | end << 16, positions in by_part.
@group(1) @binding(11) var<storage, read_write> buckets: array<vec2<u32>>;

// H(part) = part mod slots. Written out, because an integer division is scalar code on CPUs: the quotient is never taken too
// large, and what the first takes too little of, the second does.
fn hash_of(part: u32, slots: u32) -> u32 {
    let inverse = 0.9999995 / f32(slots);
    var rest = part - u32(f32(part) * inverse) * slots;
    rest -= u32(f32(rest) * inverse) * slots;
    return select(rest, rest - slots, rest >= slots);
}

// A part's entry in a bucket table.
struct Entry {
    // Positions in by_part; both 0 if the pixel has no layer of the part.
    first: u32,
    end: u32,
    // Where in the table it is.
    slot: u32,
}

// A pixel's bucket table.
struct Table {
    // The pixel's first slot.
    base: u32,
    slots: u32,
}

fn bucket_table(pixel: u32) -> Table {
    return Table(layer_base(pixel), bucket_slots(pixel));
}

// A bucket: the pixel's first slot, and positions in by_part.
struct Bucket {
    base: u32,
    first: u32,
    end: u32,
}

// The part's entry; `likely` is looked at first.
fn find_entry(table: Table, part: u32, likely: u32) -> Entry {
    if table.slots == 0u {
        return Entry(0u, 0u, 0u);
    }
    let guess = min(likely, table.slots - 1u);
    let guessed = buckets[table.base + guess];
    if guessed.x == part {
        return Entry(guessed.y & 0xFFFFu, guessed.y >> 16u, guess);
    }
    var slot = hash_of(part, table.slots);
    for (var probes = 0u; probes < table.slots; probes++) {
        let bucket = buckets[table.base + slot];
        if bucket.x == part {
            return Entry(bucket.y & 0xFFFFu, bucket.y >> 16u, slot);
        }
        if bucket.x == EMPTY {
            break;
        }
        slot += 1u;
        if slot == table.slots {
            slot = 0u;
        }
    }
    return Entry(0u, 0u, 0u);
}
