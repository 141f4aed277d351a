//@ use passes/operators/gathered
//@ use passes/opacity/model_parameters
// Equal shares: opacity for each layer index, so that each is seen as much as any other. All pixels that have layer i have the
// layers before it too, so what gets through to it is the same for all of them, T(i), and it is seen n(i) T(i) a(i) times.
// That is to be the same for all i; then T(i + 1) = T(i) - s / n(i). Indices that few pixels have would want nearly all of the
// picture for themselves: they take the opacity of the last one that enough have.

fn settle() {
    var pixels = 0u;
    for (var count = 1u; count < GATHERED; count++) {
        pixels += atomicLoad(&gathered[count]);
    }
    let enough = model_parameters.low * f32(pixels);
    // What all indices together want, in units of what the first one does.
    var wanted = 0.0;
    var deeper = pixels;
    for (var index = 0u; index + 1u < GATHERED && deeper > 0u && f32(deeper) >= enough; index++) {
        wanted += f32(pixels) / f32(deeper);
        deeper -= atomicLoad(&gathered[index + 1u]);
    }
    let first = model_parameters.share / max(wanted, 1.0);
    var passed = 1.0;
    var last = 0.0;
    deeper = pixels;
    for (var index = 0u; index + 1u < GATHERED; index++) {
        if deeper > 0u && f32(deeper) >= enough {
            let share = first * (f32(pixels) / f32(deeper));
            last = clamp(share / max(passed, 1e-6), 0.0, 1.0);
            passed -= share;
            deeper -= atomicLoad(&gathered[index + 1u]);
        } else {
            deeper = 0u;
        }
        settled[index] = last;
    }
}
