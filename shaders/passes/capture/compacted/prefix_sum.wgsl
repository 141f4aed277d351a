//@ use common/frame
//@ use passes/capture/statistics
// Prefix sum: where each pixel's layers begin. Three passes: rows are summed, the sums are scanned, rows are scanned from
// their start. Also writes which list lengths occur, as arguments of the sorts: an empty class dispatches nothing.

@group(1) @binding(0) var<storage, read_write> pixel_table: array<u32>;
@group(1) @binding(19) var<storage, read_write> cursors: array<u32>;
@group(1) @binding(27) var<storage, read_write> row_sums: array<u32>;

// One workgroup a row, so that the sums are those of whole rows: bands are cut from them.
const LANES: u32 = 64u;
var<workgroup> partial: array<u32, 64>;
var<workgroup> partial_max: array<atomic<u32>, 2>;

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
    var classes = 0u;
    var covered = 0u;
    for (var x = begin; x < end; x++) {
        let count = pixel_table[row * frame.size.x + x];
        sum += count;
        deepest = max(deepest, count);
        if count > 0u {
            covered += 1u;
            classes |= 1u << min(32u - countLeadingZeros(count - 1u), LARGEST_CLASS);
        }
    }
    partial[lane] = sum;
    atomicMax(&partial_max[0], deepest);
    atomicOr(&partial_max[1], classes);
    workgroupBarrier();
    if lane == 0u {
        var total = 0u;
        for (var i = 0u; i < LANES; i++) {
            total += partial[i];
        }
        row_sums[row] = total;
        atomicMax(&statistics[STAT_CLASS_DEEPEST], atomicLoad(&partial_max[0]));
        atomicOr(&statistics[STAT_CLASSES], atomicLoad(&partial_max[1]));
    }
    let y = row + frame.first_row;
    if y >= frame.first_output_row && y < frame.end_output_row && sum > 0u {
        atomicAdd(&statistics[STAT_RASTERIZED], sum);
        atomicAdd(&statistics[STAT_COVERED], covered);
        atomicMax(&statistics[STAT_DEEPEST], deepest);
    }
}

@group(1) @binding(29) var<storage, read_write> sort_arguments: array<u32>;

@compute @workgroup_size(1)
fn scan_rows() {
    var total = 0u;
    for (var row = 0u; row < rows(); row++) {
        let sum = row_sums[row];
        row_sums[row] = total;
        total += sum;
    }
    pixel_table[rows() * frame.size.x] = total;
    let classes = atomicLoad(&statistics[STAT_CLASSES]);
    for (var class_ = 0u; class_ <= LARGEST_CLASS; class_++) {
        let present = (classes & (1u << class_)) != 0u;
        sort_arguments[3u * class_] = select(0u, (frame.size.x + 15u) / 16u, present);
        sort_arguments[3u * class_ + 1u] = (rows() + 15u) / 16u;
        sort_arguments[3u * class_ + 2u] = 1u;
    }
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
