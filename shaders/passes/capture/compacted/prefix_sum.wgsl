//@ use common/frame
//@ use passes/capture/statistics
// Prefix sum: where each pixel's layers begin. Three passes: rows are summed, the sums are scanned, rows are scanned from
// their start.

@group(1) @binding(0) var<storage, read_write> pixel_table: array<u32>;
@group(1) @binding(19) var<storage, read_write> cursors: array<u32>;
@group(1) @binding(27) var<storage, read_write> row_sums: array<u32>;

// One workgroup a row, so that the sums are those of whole rows: bands are cut from them.
const LANES: u32 = 64u;
var<workgroup> partial: array<u32, 64>;
var<workgroup> partial_max: atomic<u32>;

fn rows() -> u32 {
    return frame.end_row - frame.first_row;
}

// Pixels of a row are split into LANES runs; a lane sums its run.
fn run_begin(lane: u32) -> u32 {
    return lane * ((frame.size.x + LANES - 1u) / LANES);
}

@compute @workgroup_size(64)
fn sum_rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let row = group.x;
    let begin = min(run_begin(lane), frame.size.x);
    let end = min(run_begin(lane + 1u), frame.size.x);
    var sum = 0u;
    var deepest = 0u;
    var covered = 0u;
    for (var x = begin; x < end; x++) {
        let count = pixel_table[row * frame.size.x + x];
        sum += count;
        deepest = max(deepest, count);
        if count > 0u {
            covered += 1u;
        }
    }
    partial[lane] = sum;
    atomicMax(&partial_max, deepest);
    workgroupBarrier();
    if lane == 0u {
        var total = 0u;
        for (var i = 0u; i < LANES; i++) {
            total += partial[i];
        }
        row_sums[row] = total;
        atomicMax(&statistics[STAT_BAND_DEEPEST], atomicLoad(&partial_max));
    }
    let y = row + frame.first_row;
    if y >= frame.first_output_row && y < frame.end_output_row && sum > 0u {
        atomicAdd(&statistics[STAT_RASTERIZED], sum);
        atomicAdd(&statistics[STAT_COVERED], covered);
        atomicMax(&statistics[STAT_DEEPEST], deepest);
    }
}

@compute @workgroup_size(1)
fn scan_rows() {
    var total = 0u;
    for (var row = 0u; row < rows(); row++) {
        let sum = row_sums[row];
        row_sums[row] = total;
        total += sum;
    }
    pixel_table[rows() * frame.size.x] = total;
}

@compute @workgroup_size(64)
fn offset_rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let row = group.x;
    let begin = min(run_begin(lane), frame.size.x);
    let end = min(run_begin(lane + 1u), frame.size.x);
    var sum = 0u;
    for (var x = begin; x < end; x++) {
        sum += pixel_table[row * frame.size.x + x];
    }
    partial[lane] = sum;
    workgroupBarrier();
    var offset = row_sums[row];
    for (var i = 0u; i < lane; i++) {
        offset += partial[i];
    }
    for (var x = begin; x < end; x++) {
        let pixel = row * frame.size.x + x;
        let count = pixel_table[pixel];
        pixel_table[pixel] = offset;
        cursors[pixel] = offset;
        offset += count;
    }
}
