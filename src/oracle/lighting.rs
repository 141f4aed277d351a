//! Light on one surface point, in `f64`: the twin of `shaders/common/lighting.wgsl`, line for line.
//!
//! glTF's metallic-roughness surface under the studio of [`LightRig`]: Lambert and GGX for three directional lights, and
//! a surrounding that is a sum of three soft shapes (ground to sky, a bright band over the horizon, a dark floor line),
//! each blurred by roughness in closed form, so that metals have something to mirror. No shadows.
//!
//! Made for a rasterizer that runs on a CPU: no `pow`, no exponential, no trigonometry. Where the usual formulas have
//! one, a polynomial stands in:
//! - half vectors are never built: `(n·h)² = (n·l + n·v)² / (2 (1 + l·v))` and `(l·h)² = (1 + l·v) / 2`;
//! - Smith's visibility is Hammon's mix, `0.5 / mix(2 n·l n·v, n·l + n·v, α)`;
//! - the surroundings' share of the specular lobe is Karis's fit with `2^(−9.28 n·v)` replaced by `(1 − n·v)⁶`.
//!
//! A **shoulder** ends it: up to [`SHOULDER_START`] light is passed on as it is, beyond it bends towards
//! [`SHOULDER_END`] and never exceeds that. Highlights on a layer that is then blended with others would otherwise burn
//! through every layer in front. Emitted light passes through it too.
//!
//! Any input gives a finite result: vectors of length zero, `n·v ≤ 0`, roughness 0.

use glam::DVec3;

use crate::math::{DirectionalLight, LightRig};

/// What is lit: the shader's `Surface`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear rgb.
    pub base_color: DVec3,
    /// Metalness, 0 to 1.
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f64,
    /// Share of the surroundings that is seen, 0 to 1.
    pub occlusion: f64,
    /// Emitted light, linear rgb.
    pub emissive: DVec3,
    /// Base colour is shown as it is.
    pub unlit: bool,
    /// The side turned away from the winding faces the viewer: the inside of a solid, which sees less of the surroundings.
    pub back_side: bool,
}

/// Where the shoulder begins.
pub const SHOULDER_START: f64 = 0.75;
/// What no result exceeds.
pub const SHOULDER_END: f64 = 1.15;

const INVERSE_PI: f64 = std::f64::consts::FRAC_1_PI;
const KEY_TINT: DVec3 = DVec3::new(1.02, 1.0, 0.96);
const FILL_TINT: DVec3 = DVec3::new(0.94, 0.99, 1.06);
const RIM_TINT: DVec3 = DVec3::new(0.97, 1.0, 1.04);
const DIELECTRIC: f64 = 0.04;
/// Directional lights are lamps, not points: no highlight is sharper than this perceptual roughness.
const SHARPEST: f64 = 0.26;
const INSIDE_OCCLUSION: f64 = 0.82;
/// The studio as metals mirror it is brighter than the light that it gives: softboxes outshine walls.
const MIRRORED: f64 = 1.3;
/// Height of the bright band over the horizon, in units of the sky.
const BAND: f64 = 1.0;
/// Depth of the dark line under it.
const FLOOR: f64 = 0.5;

fn normalize_or_zero(v: DVec3) -> DVec3 {
    v * (1.0 / v.dot(v).max(1e-30).sqrt())
}

fn saturate(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

/// Radiance of the studio from `direction`, seen through a lobe of the given perceptual roughness.
fn studio(direction: DVec3, roughness: f64, rig: &LightRig) -> DVec3 {
    let sky = rig.sky.color * rig.sky.intensity;
    let ground = rig.ground.color * rig.ground.intensity;
    let height = direction.dot(rig.up);
    let spread = 0.10 + 0.90 * roughness;
    let s = saturate(height / (2.0 * spread) + 0.5);
    let above = s * s * (3.0 - 2.0 * s);
    // Bumps of width `spread`; their heights fall as they widen, which keeps their light.
    let inverse_area = 1.0 / (1.0 + 2.2 * roughness);
    let b = (height - 0.38) / (0.22 + 0.6 * roughness);
    let band = inverse_area / (1.0 + b * b);
    let f = (height + 0.12) / (0.16 + 0.6 * roughness);
    let floor_line = inverse_area / (1.0 + f * f);
    (ground + (sky - ground) * above + sky * (BAND * band)) * (MIRRORED - MIRRORED * FLOOR * floor_line)
}

/// What all lights have in common at one point.
struct Point {
    n: DVec3,
    v: DVec3,
    n_v: f64,
    diffuse: DVec3,
    f0: DVec3,
    regained: DVec3,
    alpha: f64,
}

impl Point {
    /// Diffuse and specular light of one directional light.
    fn direct(&self, light: &DirectionalLight, tint: DVec3) -> DVec3 {
        let l = light.direction;
        let n_l = saturate(self.n.dot(l));
        let l_h2 = (0.5 + 0.5 * l.dot(self.v)).max(1e-4);
        let n_h = n_l + self.n_v;
        let n_h2 = (n_h * n_h / (4.0 * l_h2)).min(1.0);
        let a2 = self.alpha * self.alpha;
        let d = n_h2 * (a2 - 1.0) + 1.0;
        let product = 2.0 * n_l * self.n_v;
        let visibility = product + (n_h - product) * self.alpha;
        let lobe = 0.5 * a2 / (d * d * visibility).max(1e-6);
        let x = saturate(1.0 - l_h2.sqrt());
        let x2 = x * x;
        let fresnel = self.f0 + (DVec3::ONE - self.f0) * (x2 * x2 * x);
        (self.diffuse + fresnel * self.regained * lobe) * tint * (light.intensity * INVERSE_PI * n_l)
    }
}

fn shoulder(x: f64) -> f64 {
    let range = SHOULDER_END - SHOULDER_START;
    let over = (x - SHOULDER_START).clamp(0.0, 1e6);
    x.clamp(0.0, SHOULDER_START) + range * over / (over + range)
}

/// Linear rgb that leaves `surface` towards the viewer.
///
/// `normal_in_view` faces the viewer; `to_eye` points from the surface to the eye, in view space (for a parallel
/// projection (0, 0, 1)). Neither need have unit length.
pub fn light_surface(surface: &Surface, normal_in_view: DVec3, to_eye: DVec3, rig: &LightRig) -> DVec3 {
    if surface.unlit {
        return surface.base_color;
    }
    let n = normalize_or_zero(normal_in_view);
    let v = normalize_or_zero(to_eye);
    let n_v_signed = n.dot(v);
    let n_v = n_v_signed.clamp(0.02, 1.0);
    let roughness = saturate(surface.roughness);
    let lamp_roughness = roughness.max(SHARPEST);
    let alpha = lamp_roughness * lamp_roughness;
    let metallic = saturate(surface.metallic);
    let diffuse = surface.base_color * (1.0 - metallic);
    let f0 = DVec3::splat(DIELECTRIC) * (1.0 - metallic) + surface.base_color * metallic;

    // Karis's fit of the specular lobe's share, as a scale and a bias on f0.
    let x = 1.0 - n_v;
    let x2 = x * x;
    let smoothness = 1.0 - roughness;
    let a = (smoothness * smoothness).min(x2 * x2 * x2) * smoothness + 0.0425 - 0.0275 * roughness;
    let scale = -1.04 * a + 1.04 - 0.572 * roughness;
    let bias = saturate(1.04 * a - 0.04 + 0.022 * roughness);
    let reflected = f0 * scale + DVec3::splat(bias);
    // Light that bounces between microfacets more than once: without it rough metals, glTF's default, are too dark.
    let regained = DVec3::ONE + f0 * (1.0 / (scale + bias).max(0.1) - 1.0);

    let point = Point { n, v, n_v, diffuse, f0, regained, alpha };
    let mut color = point.direct(&rig.key, KEY_TINT);
    color += point.direct(&rig.fill, FILL_TINT);
    color += point.direct(&rig.rim, RIM_TINT);

    let mut seen = saturate(surface.occlusion);
    if surface.back_side {
        seen *= INSIDE_OCCLUSION;
    }
    let sky = rig.sky.color * rig.sky.intensity;
    let ground = rig.ground.color * rig.ground.intensity;
    let irradiance = ground + (sky - ground) * saturate(0.5 + 0.5 * n.dot(rig.up));
    let mirrored = n * (2.0 * n_v_signed) - v;
    color += (diffuse * irradiance + reflected * regained * studio(mirrored, roughness, rig)) * seen;

    color = (color + surface.emissive) * rig.exposure;
    DVec3::new(shoulder(color.x), shoulder(color.y), shoulder(color.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LightLevels;

    const SHADER: &str = include_str!("../../shaders/common/lighting.wgsl");

    fn plain(base: f64, metallic: f64, roughness: f64) -> Surface {
        Surface {
            base_color: DVec3::splat(base),
            metallic,
            roughness,
            occlusion: 1.0,
            emissive: DVec3::ZERO,
            unlit: false,
            back_side: false,
        }
    }

    fn studio_rig() -> LightRig {
        LightRig::studio(LightLevels::default())
    }

    #[test]
    fn the_shader_is_valid() {
        let module = naga::front::wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SHADER)));
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all())
            .validate(&module)
            .unwrap();
    }

    #[test]
    fn the_shader_has_the_same_constants() {
        let module = naga::front::wgsl::parse_str(SHADER).unwrap();
        let value = |name: &str| -> Vec<f64> {
            let (_, constant) = module
                .constants
                .iter()
                .find(|(_, c)| c.name.as_deref() == Some(name))
                .unwrap_or_else(|| panic!("{name} is not a constant of the shader"));
            let literal = |e| match module.global_expressions[e] {
                naga::Expression::Literal(naga::Literal::F32(x)) => f64::from(x),
                ref other => panic!("{name}: {other:?}"),
            };
            match &module.global_expressions[constant.init] {
                naga::Expression::Compose { components, .. } => components.iter().map(|&c| literal(c)).collect(),
                _ => vec![literal(constant.init)],
            }
        };
        for (name, ours) in [
            ("SHOULDER_START", SHOULDER_START),
            ("SHOULDER_END", SHOULDER_END),
            ("INVERSE_PI", INVERSE_PI),
            ("DIELECTRIC", DIELECTRIC),
            ("SHARPEST", SHARPEST),
            ("INSIDE_OCCLUSION", INSIDE_OCCLUSION),
            ("MIRRORED", MIRRORED),
            ("BAND", BAND),
            ("FLOOR", FLOOR),
        ] {
            assert!((value(name)[0] - ours).abs() < 1e-7, "{name}");
        }
        for (name, ours) in [("KEY_TINT", KEY_TINT), ("FILL_TINT", FILL_TINT), ("RIM_TINT", RIM_TINT)] {
            let shader = value(name);
            assert!((0..3).all(|i| (shader[i] - ours[i]).abs() < 1e-7), "{name}");
        }
    }

    #[test]
    fn grey_that_faces_the_viewer_keeps_its_value() {
        for roughness in [0.2, 0.5, 1.0] {
            for base in [0.1, 0.214, 0.5] {
                let lit = light_surface(&plain(base, 0.0, roughness), DVec3::Z, DVec3::Z, &studio_rig());
                for c in lit.to_array() {
                    assert!(c > 0.9 * base && c < 1.15 * base + 0.025, "{base} {roughness}: {lit}");
                }
            }
            let metal = light_surface(&plain(0.6, 1.0, roughness), DVec3::Z, DVec3::Z, &studio_rig());
            assert!(metal.min_element() > 0.4 && metal.max_element() < 0.75, "{metal}");
        }
    }

    #[test]
    fn any_input_is_finite_and_in_range() {
        let vectors = [DVec3::ZERO, DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(1e-3, -0.7, 0.2), DVec3::splat(1e-12)];
        for n in vectors {
            for v in vectors {
                for (roughness, metallic, base) in [(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 0.0), (-3.0, 7.0, 1.0)]
                {
                    let mut surface = plain(base, metallic, roughness);
                    surface.emissive = DVec3::splat(if base == 0.0 { 1e30 } else { 0.0 });
                    let c = light_surface(&surface, n, v, &studio_rig());
                    assert!(c.is_finite() && c.min_element() >= 0.0 && c.max_element() <= SHOULDER_END, "{c}");
                }
            }
        }
    }

    #[test]
    fn the_levels_are_the_settings_defaults() {
        let s = crate::settings::LightSettings::default();
        let levels = LightLevels { exposure: s.exposure, key: s.key, fill: s.fill, rim: s.rim, ambient: s.ambient };
        assert_eq!(levels, LightLevels::default());
    }

    #[test]
    fn lambert_by_hand() {
        // Only the key light, straight on, hardly any specular reflection: 1 / π of the base colour.
        let rig = LightRig {
            key: DirectionalLight { direction: DVec3::Z, intensity: 1.0 },
            ..LightRig::studio(LightLevels { fill: 0.0, rim: 0.0, ambient: 0.0, ..LightLevels::default() })
        };
        let lit = light_surface(&plain(1.0, 0.0, 1.0), DVec3::Z, DVec3::Z, &rig);
        // GGX at roughness 1 seen and lit straight on: D = 1/π, V = 1/4, F = 0.04 (and what is regained of it).
        let specular = 0.04 / 4.0;
        assert!((lit.y - INVERSE_PI * (1.0 + specular)).abs() < 2e-3, "{lit}");
        assert!(lit.x > lit.y && lit.y > lit.z, "the key light is warm: {lit}");
    }

    #[test]
    fn unlit_shows_its_colour_and_the_inside_is_darker() {
        let mut surface = plain(0.3, 0.0, 0.5);
        let outside = light_surface(&surface, DVec3::Z, DVec3::Z, &studio_rig());
        surface.back_side = true;
        assert!(light_surface(&surface, DVec3::Z, DVec3::Z, &studio_rig()).y < outside.y);
        surface.unlit = true;
        assert_eq!(light_surface(&surface, DVec3::Z, DVec3::Z, &studio_rig()), DVec3::splat(0.3));
    }
}
