//@ use common/frame
// Buckets of a pixel (Murray 2016, section 4.1): its layers grouped by part. `by_part` lists the pixel's layer indices in
// (part, depth) order; the bucket table is a hash table of (part, range in by_part), H(part) = part mod slots with linear
// probing that wraps around and ends after one round (T6).

@group(1) @binding(10) var<storage, read_write> by_part: array<u32>;
// x: part or EMPTY; y: first | end << 16, positions in by_part.
@group(1) @binding(11) var<storage, read_write> buckets: array<vec2<u32>>;

// First and end position in by_part of the part's layers; (0, 0) if the pixel has none.
fn find_bucket(pixel: u32, part: u32) -> vec2<u32> {
    let slots = bucket_slots(pixel);
    if slots == 0u {
        return vec2<u32>(0u);
    }
    let base = layer_base(pixel);
    var index = part % slots;
    for (var probes = 0u; probes < slots; probes++) {
        let bucket = buckets[base + index];
        if bucket.x == part {
            return vec2<u32>(bucket.y & 0xFFFFu, bucket.y >> 16u);
        }
        if bucket.x == EMPTY {
            break;
        }
        index += 1u;
        if index == slots {
            index = 0u;
        }
    }
    return vec2<u32>(0u);
}
