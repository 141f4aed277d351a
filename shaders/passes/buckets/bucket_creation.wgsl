//@ use store/buckets
//@ use store/part_column
// Bucket creation (Murray 2016, section 4.1 step 3): one entry a part in the pixel's hash table.

fn insert_bucket(pixel: u32, part: u32, first: u32, end: u32) {
    let slots = bucket_slots(pixel);
    let base = layer_base(pixel);
    var index = hash_of(part, slots);
    for (var probes = 0u; probes < slots; probes++) {
        if buckets[base + index].x == EMPTY {
            buckets[base + index] = vec2<u32>(part, first | (end << 16u));
            return;
        }
        index += 1u;
        if index == slots {
            index = 0u;
        }
    }
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if !has_pixel(id.xy) {
        return;
    }
    let pixel = pixel_at(id.xy);
    let count = layer_count(pixel);
    if count == 0u {
        return;
    }
    let base = layer_base(pixel);
    for (var i = 0u; i < bucket_slots(pixel); i++) {
        buckets[base + i] = vec2<u32>(EMPTY, 0u);
    }
    var first = 0u;
    var part = parts[base + by_part[base]];
    for (var i = 1u; i < count; i++) {
        let next = parts[base + by_part[base + i]];
        if next != part {
            insert_bucket(pixel, part, first, i);
            first = i;
            part = next;
        }
    }
    insert_bucket(pixel, part, first, count);
}
