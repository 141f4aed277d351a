//@ use passes/illustration/parameters
// One step of diffusion (Carnecky 2013, section 5.4). Heat flows along the links that there are, a quarter of lambda through
// each, so that it is stable for every lambda up to 1 and nothing is lost where a neighbour is missing (T12). Max: the greatest
// of the neighbours less lambda, if that is more; what is fixed stays (T16). `conductance_of(slot)` says how far either gets
// along the four links, as a share: heat goes with its square, and `max` loses as much more.

fn operate(slot: u32, own: vec4<f32>, slots: vec4<u32>) -> vec4<f32> {
    let u = own.xyz;
    // A neighbour that is missing is the layer itself: nothing flows, nothing is greater.
    let right = field_of(slots.x).xyz;
    let left = field_of(slots.y).xyz;
    let down = field_of(slots.z).xyz;
    let up = field_of(slots.w).xyz;
    let fixed = u32(own.w);
    let is_fixed = vec3<bool>(false, (fixed & FIXED_BETA) != 0u, (fixed & FIXED_GAMMA) != 0u);
    let lambda = illustration.lambda.xyz;
    let rate = select(0.25 * lambda, vec3<f32>(1.0), illustration.printed == PRINTED_LAPLACIAN);
    let g = conductance_of(slot);
    let flow = g * g;
    let heat = u + rate * ((flow.x * (right - u) + flow.y * (left - u)) + (flow.z * (down - u) + flow.w * (up - u)));
    let loss = 1.0 / g;
    let rows = max(right - lambda * loss.x, left - lambda * loss.y);
    let columns = max(down - lambda * loss.z, up - lambda * loss.w);
    let spread = max(u, max(rows, columns));
    let by_heat = (illustration.diffusion.xyz == vec3<u32>(1u)) & vec3<bool>(present_step < illustration.heat_steps);
    let by_max = illustration.diffusion.xyz == vec3<u32>(2u);
    let overwrites = vec3<bool>(illustration.printed == PRINTED_PROPAGATION);
    var next = select(u, heat, by_heat & !is_fixed);
    next = select(next, spread, by_max & (!is_fixed | overwrites));
    return vec4<f32>(next, own.w);
}

// Heat takes its steps in any case.
fn has_changed(own: vec4<f32>, next: vec4<f32>) -> bool {
    return any((illustration.diffusion.xyz == vec3<u32>(2u)) & (own.xyz != next.xyz));
}
