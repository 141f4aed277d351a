//@ use store/open_layers
// Dispatches over the listed layers, one invocation each in workgroups of 64.

// Workgroups in a row of the dispatch.
const ROW: u32 = 32768u;

// The place in the list that an invocation has; there may be none.
fn open_place(group: vec3<u32>, local: u32) -> u32 {
    return (group.y * ROW + group.x) * 64u + local;
}

fn is_listed(place: u32) -> bool {
    return place < atomicLoad(&open_count[0]);
}
