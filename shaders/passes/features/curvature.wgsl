//@ use store/shapes
//@ use store/links
// Curvature of every layer from its neighbours (Murray 2016, section 5.1, after Vergne 2009): kappa in [-1, 1], -1 convex.
//
// Two kinds. Surface (ours): the shape operator, from how normal and position change along the links. View-centred (the
// paper's): the Hessian of depth. Both are estimated by regression over the layers met on the way along the links, up to a
// radius, which stops at creases (T31); creases and missing neighbours are drawn as lines of a settable width.

struct CurvatureParameters {
    // Sensitivity times unit of length; 0 where the unit is the part's radius, then `part_scale` holds the sensitivity.
    scale: f32,
    part_scale: f32,
    // Steps of the estimate, and of the walk (at least as far as lines are wide).
    radius: u32,
    reach: u32,
    // Width of lines, pixels.
    line: f32,
    // Cosine of the crease angle.
    crease_cosine: f32,
    // 0 surface, 1 view-centred.
    kind: u32,
    _pad: u32,
}

@group(1) @binding(13) var<uniform> curvature_parameters: CurvatureParameters;
@group(1) @binding(14) var<storage, read_write> kappas: array<f32>;

struct Fragment {
    normal: vec3<f32>,
    point: vec3<f32>,
}

fn fragment_at(x: u32, y: u32, slot: u32) -> Fragment {
    let shape = layer_shape(slot);
    return Fragment(shape.normal, position_in_view(x, y, shape.depth));
}

// What a walk along one axis collects.
struct Axis {
    samples: f32,
    sum_s: f32,
    sum_ss: f32,
    // Sums of the normal's (view-centred: the depth gradient's) and the position's difference to the start, plain and
    // times s.
    normal: vec3<f32>,
    normal_s: vec3<f32>,
    point: vec3<f32>,
    point_s: vec3<f32>,
}

// The nearest lines met: distance in steps (0 for none) and, for a crease, the difference of the normals and which way it
// bends. Angles are computed once at the end, because a CPU rasterizer executes branches that no lane takes.
struct Lines {
    rim: u32,
    crease: u32,
    turn: vec3<f32>,
    convex: bool,
}

// Steps in x and y of a direction.
fn step_of(direction: u32) -> vec2<i32> {
    switch direction {
        case 0u: { return vec2<i32>(1, 0); }
        case 1u: { return vec2<i32>(-1, 0); }
        case 2u: { return vec2<i32>(0, 1); }
        default: { return vec2<i32>(0, -1); }
    }
}

// Walks from a layer, whose link in that direction is `first`.
fn walk(
    start: Fragment,
    x: u32,
    y: u32,
    first: u32,
    direction: u32,
    axis: ptr<function, Axis>,
    lines: ptr<function, Lines>,
) {
    let move_by = step_of(direction);
    let side = select(1.0, -1.0, (direction & 1u) != 0u);
    var at = vec2<i32>(i32(x), i32(y));
    var link = first;
    var last = start;
    for (var distance = 1u; ; distance++) {
        if link == UNKNOWN {
            return;
        }
        if link == MISSING {
            if (*lines).rim == 0u || distance < (*lines).rim {
                (*lines).rim = distance;
            }
            return;
        }
        at += move_by;
        let current = layer_base(pixel_index(u32(at.x), u32(at.y))) + link;
        let next = fragment_at(u32(at.x), u32(at.y), current);
        let cosine = dot(last.normal, next.normal);
        if cosine < curvature_parameters.crease_cosine {
            if (*lines).crease == 0u || distance < (*lines).crease {
                let turn = next.normal - last.normal;
                (*lines).crease = distance;
                (*lines).turn = turn;
                (*lines).convex = dot(turn, next.point - last.point) > 0.0;
            }
            return;
        }
        if distance <= curvature_parameters.radius {
            let s = side * f32(distance);
            var dn = next.normal - start.normal;
            if curvature_parameters.kind == 1u {
                dn = vec3<f32>(depth_gradient(next.normal) - depth_gradient(start.normal), 0.0);
            }
            let dp = next.point - start.point;
            (*axis).samples += 1.0;
            (*axis).sum_s += s;
            (*axis).sum_ss += s * s;
            (*axis).normal += dn;
            (*axis).normal_s += s * dn;
            (*axis).point += dp;
            (*axis).point_s += s * dp;
        }
        if distance >= curvature_parameters.reach {
            return;
        }
        last = next;
        link = link_of(current, direction);
    }
}

// Regression slopes per step; the start is the sample s = 0 with difference 0.
struct Slopes {
    normal: vec3<f32>,
    point: vec3<f32>,
}

fn slopes_of(axis: Axis) -> Slopes {
    let mean = axis.sum_s / axis.samples;
    let denominator = axis.sum_ss - axis.sum_s * mean;
    return Slopes(
        (axis.normal_s - mean * axis.normal) / denominator,
        (axis.point_s - mean * axis.point) / denominator,
    );
}

// View-centred: the gradient of depth, finite everywhere.
fn depth_gradient(normal: vec3<f32>) -> vec2<f32> {
    return normal.xy / max(normal.z, 0.05);
}

// Sum of the principal curvatures, positive where convex, per unit of length.
fn curvature_sum(start: Fragment, u: Axis, v: Axis, pixel: vec2<f32>) -> f32 {
    let has_u = u.samples > 1.5;
    let has_v = v.samples > 1.5;
    if !has_u && !has_v {
        return 0.0;
    }
    var along_u = Slopes(vec3<f32>(0.0), vec3<f32>(0.0));
    var along_v = along_u;
    if has_u {
        along_u = slopes_of(u);
    }
    if has_v {
        along_v = slopes_of(v);
    }
    if curvature_parameters.kind == 1u {
        return along_u.normal.x / pixel.x - along_v.normal.y / pixel.y;
    }
    // Tangent parts, then S = B inverse(A) in any frame of the tangent plane: its trace needs only cross products.
    let n = start.normal;
    let au = along_u.point - n * dot(n, along_u.point);
    let av = along_v.point - n * dot(n, along_v.point);
    let bu = along_u.normal - n * dot(n, along_u.normal);
    let bv = along_v.normal - n * dot(n, along_v.normal);
    let uu = dot(au, au);
    let vv = dot(av, av);
    let area = dot(n, cross(au, av));
    if has_u && has_v && area * area > 1e-8 * uu * vv {
        return dot(n, cross(bu, av) + cross(au, bv)) / area;
    }
    // One direction only: the curvature along it; two that coincide: their mean.
    var sum = 0.0;
    var directions = 0.0;
    if has_u && uu > 0.0 {
        sum += dot(bu, au) / uu;
        directions += 1.0;
    }
    if has_v && vv > 0.0 {
        sum += dot(bv, av) / vv;
        directions += 1.0;
    }
    return sum / max(directions, 1.0);
}

// WGSL leaves tanh of large arguments to the implementation (T8).
fn saturate(x: f32) -> f32 {
    return tanh(clamp(x, -20.0, 20.0));
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.size.x || y < frame.first_output_row || y >= frame.end_output_row {
        return;
    }
    let pixel = pixel_index(id.x, y);
    let base = layer_base(pixel);
    let begin = id.z * store_layout.chunk;
    let end = min(layer_count(pixel), begin + store_layout.chunk);
    for (var layer = begin; layer < end; layer++) {
        let slot = base + layer;
        let start = fragment_at(id.x, y, slot);
        var lines = Lines(0u, 0u, vec3<f32>(0.0), false);
        var u = Axis(1.0, 0.0, 0.0, vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
        var v = u;
        let ahead = links_ahead[slot];
        let behind = links_behind[slot];
        walk(start, id.x, y, ahead & 0xFFFFu, 0u, &u, &lines);
        walk(start, id.x, y, behind.x, 1u, &u, &lines);
        walk(start, id.x, y, ahead >> 16u, 2u, &v, &lines);
        walk(start, id.x, y, behind.y, 3u, &v, &lines);
        let size = pixel_size(-start.point.z);
        let scale = curvature_scale(slot);
        var kappa = saturate(-scale * curvature_sum(start, u, v, size));
        if lines.crease != 0u {
            // From the chord: accurate where the arc cosine is not.
            let angle = 2.0 * asin(min(0.5 * length(lines.turn), 1.0));
            let strength = saturate(
                scale * select(angle, -angle, lines.convex) / (curvature_parameters.line * size.y),
            );
            let coverage = clamp(0.5 * curvature_parameters.line + 0.5 - f32(lines.crease - 1u), 0.0, 1.0);
            kappa = mix(kappa, strength, coverage);
        }
        if lines.rim != 0u {
            let coverage = clamp(curvature_parameters.line - f32(lines.rim - 1u), 0.0, 1.0);
            kappa = mix(kappa, -1.0, coverage);
        }
        kappas[slot] = kappa;
    }
}
