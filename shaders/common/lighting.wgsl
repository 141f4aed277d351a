// Light on one surface point: functions only, no bindings. The f64 twin, with the reasoning, is `oracle::lighting`;
// the numbers in `Lights` come from `math::LightRig::to_vec4s`, in this order. Change both sides together: a test
// holds the constants equal, and the shading stage is compared with the twin.

struct Lights {
    // Directional lights: xyz unit direction towards the light in view space, w intensity.
    key: vec4<f32>,
    fill: vec4<f32>,
    rim: vec4<f32>,
    // The surroundings: linear rgb, w intensity.
    sky: vec4<f32>,
    ground: vec4<f32>,
    // xyz unit direction to the middle of the sky in view space, w exposure.
    up: vec4<f32>,
}

struct Surface {
    base_color: vec3<f32>,
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    emissive: vec3<f32>,
    unlit: bool,
    back_side: bool,
}

const SHOULDER_START: f32 = 0.75;
const SHOULDER_END: f32 = 1.15;
const INVERSE_PI: f32 = 0.31830987;
const KEY_TINT = vec3<f32>(1.02, 1.0, 0.96);
const FILL_TINT = vec3<f32>(0.94, 0.99, 1.06);
const RIM_TINT = vec3<f32>(0.97, 1.0, 1.04);
const DIELECTRIC: f32 = 0.04;
// Directional lights are lamps, not points: no highlight is sharper than this perceptual roughness.
const SHARPEST: f32 = 0.26;
const INSIDE_OCCLUSION: f32 = 0.82;
const MIRRORED: f32 = 1.3;
const BAND: f32 = 1.0;
const FLOOR: f32 = 0.5;

// What all lights have in common at one point.
struct LitPoint {
    n: vec3<f32>,
    v: vec3<f32>,
    n_v: f32,
    diffuse: vec3<f32>,
    f0: vec3<f32>,
    regained: vec3<f32>,
    alpha: f32,
}

fn lighting_normalize_or_zero(v: vec3<f32>) -> vec3<f32> {
    return v * inverseSqrt(max(dot(v, v), 1e-30));
}

// Radiance of the studio from `direction`, seen through a lobe of the given perceptual roughness: ground to sky, a
// bright band over the horizon, a dark floor line.
fn lighting_studio(direction: vec3<f32>, roughness: f32, lights: Lights) -> vec3<f32> {
    let sky = lights.sky.rgb * lights.sky.w;
    let ground = lights.ground.rgb * lights.ground.w;
    let height = dot(direction, lights.up.xyz);
    let spread = 0.10 + 0.90 * roughness;
    let s = saturate(height / (2.0 * spread) + 0.5);
    let above = s * s * (3.0 - 2.0 * s);
    let inverse_area = 1.0 / (1.0 + 2.2 * roughness);
    let b = (height - 0.38) / (0.22 + 0.6 * roughness);
    let band = inverse_area / (1.0 + b * b);
    let f = (height + 0.12) / (0.16 + 0.6 * roughness);
    let floor_line = inverse_area / (1.0 + f * f);
    return (ground + (sky - ground) * above + sky * (BAND * band)) * (MIRRORED - MIRRORED * FLOOR * floor_line);
}

// Diffuse and specular light of one directional light.
fn lighting_direct(point: LitPoint, light: vec4<f32>, tint: vec3<f32>) -> vec3<f32> {
    let n_l = saturate(dot(point.n, light.xyz));
    let l_h2 = max(0.5 + 0.5 * dot(light.xyz, point.v), 1e-4);
    let n_h = n_l + point.n_v;
    let n_h2 = min(n_h * n_h / (4.0 * l_h2), 1.0);
    let a2 = point.alpha * point.alpha;
    let d = n_h2 * (a2 - 1.0) + 1.0;
    let product = 2.0 * n_l * point.n_v;
    let visibility = product + (n_h - product) * point.alpha;
    let lobe = 0.5 * a2 / max(d * d * visibility, 1e-6);
    let x = saturate(1.0 - sqrt(l_h2));
    let x2 = x * x;
    let fresnel = point.f0 + (vec3<f32>(1.0) - point.f0) * (x2 * x2 * x);
    return (point.diffuse + fresnel * point.regained * lobe) * tint * (light.w * INVERSE_PI * n_l);
}

// Passes light up to SHOULDER_START as it is and bends the rest towards SHOULDER_END.
fn lighting_shoulder(color: vec3<f32>) -> vec3<f32> {
    let range = SHOULDER_END - SHOULDER_START;
    // The upper bound keeps the quotient finite for any exposure.
    let over = clamp(color - vec3<f32>(SHOULDER_START), vec3<f32>(0.0), vec3<f32>(1e6));
    return clamp(color, vec3<f32>(0.0), vec3<f32>(SHOULDER_START)) + range * over / (over + vec3<f32>(range));
}

// Linear rgb that leaves `surface` towards the viewer. The normal faces the viewer; `to_eye` points from the surface to
// the eye in view space, (0, 0, 1) for a parallel projection. Neither need have unit length. Finite for any input.
fn light_surface(surface: Surface, normal_in_view: vec3<f32>, to_eye: vec3<f32>, lights: Lights) -> vec3<f32> {
    if surface.unlit {
        return surface.base_color;
    }
    let n = lighting_normalize_or_zero(normal_in_view);
    let v = lighting_normalize_or_zero(to_eye);
    let n_v_signed = dot(n, v);
    let n_v = clamp(n_v_signed, 0.02, 1.0);
    let roughness = saturate(surface.roughness);
    let lamp_roughness = max(roughness, SHARPEST);
    let metallic = saturate(surface.metallic);
    let diffuse = surface.base_color * (1.0 - metallic);
    let f0 = vec3<f32>(DIELECTRIC * (1.0 - metallic)) + surface.base_color * metallic;

    // Karis's fit of the specular lobe's share, as a scale and a bias on f0, with (1 - n.v)^6 for its exponential.
    let x = 1.0 - n_v;
    let x2 = x * x;
    let smoothness = 1.0 - roughness;
    let a = min(smoothness * smoothness, x2 * x2 * x2) * smoothness + 0.0425 - 0.0275 * roughness;
    let scale = -1.04 * a + 1.04 - 0.572 * roughness;
    let bias = saturate(1.04 * a - 0.04 + 0.022 * roughness);
    let reflected = f0 * scale + vec3<f32>(bias);
    // Light that bounces between microfacets more than once: without it rough metals, glTF's default, are too dark.
    let regained = vec3<f32>(1.0) + f0 * (1.0 / max(scale + bias, 0.1) - 1.0);

    let point = LitPoint(n, v, n_v, diffuse, f0, regained, lamp_roughness * lamp_roughness);
    var color = lighting_direct(point, lights.key, KEY_TINT);
    color += lighting_direct(point, lights.fill, FILL_TINT);
    color += lighting_direct(point, lights.rim, RIM_TINT);

    let seen = saturate(surface.occlusion) * select(1.0, INSIDE_OCCLUSION, surface.back_side);
    let sky = lights.sky.rgb * lights.sky.w;
    let ground = lights.ground.rgb * lights.ground.w;
    let irradiance = ground + (sky - ground) * saturate(0.5 + 0.5 * dot(n, lights.up.xyz));
    let mirrored = n * (2.0 * n_v_signed) - v;
    color += (diffuse * irradiance + reflected * regained * lighting_studio(mirrored, roughness, lights)) * seen;

    return lighting_shoulder((color + surface.emissive) * lights.up.w);
}
