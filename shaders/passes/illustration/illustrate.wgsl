//@ use passes/operators/layer
//@ use passes/illustration/parameters
//@ use passes/operators/field_before
// Opacity out of base, silhouettes and halos (Carnecky 2013, Algorithm 3, line 4), after their profiles.

// 1 - exp(-x) for x from 0 on, without its cancellation.
fn risen(x: f32) -> f32 {
    let series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0)))));
    return select(1.0 - exp(-x), series, x < 0.25);
}

// Equation 10 is 0/0 at p = 0; its limit is 1 - (1 - u)^2 (T15).
fn bell(u: f32, p: f32) -> f32 {
    let v = (1.0 - u) * (1.0 - u);
    if p < 1e-6 {
        return 1.0 - v;
    }
    return exp(-p * v) * (risen(p * (1.0 - v)) / risen(p));
}

fn profiled(u: f32, profile: u32, p: f32) -> f32 {
    let x = clamp(u, 0.0, 1.0);
    if profile == 1u {
        return bell(x, p);
    }
    if profile == 2u {
        return select(pow(x, p), 0.0, x <= 0.0);
    }
    return x;
}

fn operate(at: Layer, color: vec4<f32>) -> vec4<f32> {
    let field = field_of(at.base + at.index);
    let beta = illustration.strength.y * profiled(field.y, illustration.profile.y, illustration.p.y);
    let gamma = illustration.strength.z * profiled(field.z, illustration.profile.z, illustration.p.z);
    let alpha = (1.0 - gamma) * (field.x + (1.0 - field.x) * beta);
    return vec4<f32>(color.rgb, clamp(alpha, 0.0, 1.0));
}
