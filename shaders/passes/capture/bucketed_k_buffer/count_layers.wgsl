//@ use store/layout_rows
//@ use passes/capture/statistics
//@ use passes/capture/bucketed_k_buffer/tally
// Closes the books of the insertion: layers stored in each pixel, whether some were dropped, and the totals.

var<workgroup> sums: array<atomic<u32>, 6>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let x = group.x * 64u + local;
    if x < frame.size.x {
        let pixel = group.y * frame.size.x + x;
        let rasterized = atomicLoad(&tally[2u * pixel]);
        let merged = atomicLoad(&tally[2u * pixel + 1u]);
        let distinct = rasterized - merged;
        let stored = min(distinct, store_layout.k);
        pixel_table[pixel] = stored | select(0u, 0x80000000u, distinct > stored);
        let y = group.y + frame.first_row;
        if y >= frame.first_output_row && y < frame.end_output_row && rasterized > 0u {
            atomicAdd(&sums[STAT_RASTERIZED], rasterized);
            atomicAdd(&sums[STAT_STORED], stored);
            atomicAdd(&sums[STAT_MERGED], merged);
            atomicAdd(&sums[STAT_DROPPED], distinct - stored);
            atomicAdd(&sums[4], 1u);
            atomicMax(&sums[5], rasterized);
        }
    }
    workgroupBarrier();
    if local == 0u {
        atomicAdd(&statistics[STAT_RASTERIZED], atomicLoad(&sums[STAT_RASTERIZED]));
        atomicAdd(&statistics[STAT_STORED], atomicLoad(&sums[STAT_STORED]));
        atomicAdd(&statistics[STAT_MERGED], atomicLoad(&sums[STAT_MERGED]));
        atomicAdd(&statistics[STAT_DROPPED], atomicLoad(&sums[STAT_DROPPED]));
        atomicAdd(&statistics[STAT_COVERED], atomicLoad(&sums[4]));
        atomicMax(&statistics[STAT_DEEPEST], atomicLoad(&sums[5]));
    }
}
