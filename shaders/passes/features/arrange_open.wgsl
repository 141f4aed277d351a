//@ use store/open_dispatch
// How many workgroups a dispatch over the listed layers takes.

// Workgroups in x, y, z.
@group(1) @binding(16) var<storage, read_write> open_arguments: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let groups = (atomicLoad(&open_count[0]) + 63u) / 64u;
    open_arguments[0] = min(groups, ROW);
    open_arguments[1] = (groups + ROW - 1u) / ROW;
    open_arguments[2] = 1u;
}
