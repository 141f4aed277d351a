//@ use passes/operators/steps
// Before each step of an operator that is repeated: whether it is taken. The steps that are always taken have one more after
// them, in which what they changed is carried over into the other column; then it goes on as long as something changes. Where
// it stops, both columns hold the same. No read-back waits for it (T16).

struct StepParameters {
    // Steps that are always taken.
    always: u32,
    // 0 for never stopping early.
    early_stop: u32,
    _pad0: u32,
    _pad1: u32,
}
@group(1) @binding(22) var<uniform> step_parameters: StepParameters;
// Workgroups in x, y, z.
@group(1) @binding(23) var<storage, read_write> step_arguments: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let step = atomicLoad(&steps[0]);
    let changed = atomicLoad(&steps[1]) != 0u;
    let goes_on = step <= step_parameters.always || changed || step_parameters.early_stop == 0u;
    atomicStore(&steps[0], step + 1u);
    atomicStore(&steps[1], 0u);
    atomicAdd(&steps[2], u32(goes_on));
    present[0] = step;
    // Of the steps that are always taken only the last decides anything.
    present[1] = u32(step >= step_parameters.always && step_parameters.early_stop != 0u);
    let layers = layers_listed();
    present[2] = layers;
    let groups = (layers + 255u) / 256u;
    step_arguments[0] = select(0u, min(groups, STEP_ROW), goes_on);
    step_arguments[1] = select(0u, (groups + STEP_ROW - 1u) / STEP_ROW, goes_on);
    step_arguments[2] = 1u;
}
