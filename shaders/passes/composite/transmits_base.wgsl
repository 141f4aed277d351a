//@ use passes/operators/field_before
// What passes a layer as printed (Carnecky 2013, Algorithm 3, line 6): 1 less the field alpha, whatever the layer covers. Kept
// to show that the weights then do not sum to 1 (T14).

fn transmission(slot: u32, alpha: f32) -> f32 {
    return 1.0 - field_of(slot).x;
}
