//! What came from a GPU against what the oracle finds: the comparison of each stage, and of the whole picture.
//!
//! A comparison counts how many samples are ambiguous, where either answer passes, and lists the faults elsewhere. The
//! stages after the capture are fed with the read-back of the stage before, so that structures compare exactly.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};

use super::continuity::neighbours_by;
use super::cut::ViewCut;
use super::ends::{Ends, Surfaces};
use super::neighbours::{Link, Neighbours};
use super::raster::{Fragment, Layers};
use super::store::StoreData;
use super::stylize::Tables;
use super::view::{Extents, View};
use super::{composite, curvature, illustration, models, rasterize, shade, stylize};
use crate::math::color::srgb_from_linear;
use crate::math::{Camera, LightLevels, LightRig};
use crate::scene::{CutPlane, Scene};
use crate::settings::{
    CurvatureSettings, DepthTerm, IllustrativeSettings, LightSettings, NormalEncoding, OpacityModel, PrintedForm,
    Settings,
};
use crate::transfer::TransferFunction;

/// At most this share of samples may be ambiguous, else a comparison says nothing.
pub const AMBIGUOUS: f64 = 0.02;

/// Something that is not as the oracle finds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where.
    pub pixel: usize,
    /// What.
    pub what: String,
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Samples compared, ambiguous ones included.
    pub samples: usize,
    /// Samples where either answer passes.
    pub ambiguous: usize,
    /// Samples that are wrong.
    pub faults: Vec<Fault>,
    /// The largest difference, in the unit of what is compared.
    pub worst: f64,
}

impl Comparison {
    fn fault(&mut self, pixel: usize, what: impl FnOnce() -> String) {
        self.faults.push(Fault { pixel, what: what() });
    }

    /// Share of the samples that are ambiguous.
    pub fn ambiguous_share(&self) -> f64 {
        self.ambiguous as f64 / self.samples.max(1) as f64
    }

    /// Takes over what another stage's comparison found.
    pub fn add(&mut self, other: Comparison) {
        self.samples += other.samples;
        self.ambiguous += other.ambiguous;
        self.faults.extend(other.faults);
        self.worst = self.worst.max(other.worst);
    }
}

/// The lights that the settings mean.
pub fn rig(s: &LightSettings) -> LightRig {
    LightRig::studio(LightLevels { exposure: s.exposure, key: s.key, fill: s.fill, rim: s.rim, ambient: s.ambient })
}

/// Change of depth per pixel along x and y, of the plane of every triangle.
pub struct Slopes(HashMap<u32, (DVec3, f64)>);

impl Slopes {
    /// The planes of all instanced triangles, as the camera sees them.
    pub fn new(scene: &Scene, camera: &Camera) -> Slopes {
        let mut planes = HashMap::new();
        for part in &scene.parts {
            let view_from_part = camera.view_from_world() * part.world_from_part;
            let mut number = part.first_triangle;
            for primitive in &scene.meshes[part.mesh].primitives {
                for t in &primitive.triangles {
                    let [a, b, c] = t.map(|i| {
                        view_from_part.transform_point3(Vec3::from(primitive.positions[i as usize]).as_dvec3())
                    });
                    let n = (b - a).cross(c - a).normalize_or_zero();
                    planes.insert(number, (n, n.dot(a)));
                    number += 1;
                }
            }
        }
        Slopes(planes)
    }

    /// How far a fragment's depth may be off where vertices snap to 1/256 pixel, and a few steps of an f32 (of a depth of
    /// that size: a parallel depth is as precise as the whole range).
    fn tolerance(&self, f: &Fragment, view: &View) -> f64 {
        let Some((n, _)) = self.0.get(&f.triangle) else { return 0.0 };
        let (point, pixel) = (f.position_in_view, view.pixel_size(f.depth));
        let sight = if view.perspective { point / -point.z } else { DVec3::NEG_Z };
        let facing = n.dot(sight).abs().max(1e-9);
        let slope = (n.x.abs() * pixel.x + n.y.abs() * pixel.y) / facing;
        slope / 256.0 + 1e-6 * -point.z
    }
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * ((a - b).length() * 0.5).min(1.0).asin()
}

/// The largest angle by which an encoding may turn a normal, radians.
pub fn encoding_error(encoding: NormalEncoding) -> f64 {
    match encoding {
        NormalEncoding::Octahedral => 0.0001,
        NormalEncoding::Xy15 => 0.0095,
        NormalEncoding::Full => 0.0,
    }
}

/// How one stored surface differs from the oracle's, if it does; and the angle between the normals.
fn surface_fault(s: &StoreData, i: usize, f: &Fragment, depth_by: f64, normal_by: f64) -> (f64, Option<String>) {
    let off = angle(Vec3::from(s.normal[i]).as_dvec3().normalize(), f.normal_in_view);
    let near = |a: f32, b: f64, by: f64| (f64::from(a) - b).abs() <= by;
    let c = f.surface.base_color;
    let color = (0..3).all(|j| {
        let (found, expected) = (srgb_from_linear(f64::from(s.base_color[i][j])), srgb_from_linear(c[j]));
        (found - expected).abs() <= 1.0 / 255.0 && near(s.emissive[i][j], f.surface.emissive[j], 2e-3)
    });
    let eight = 0.51 / 255.0;
    let material = near(s.metallic[i], f.surface.metallic, eight)
        && near(s.roughness[i], f.surface.roughness, eight)
        && near(s.occlusion[i], f.surface.occlusion, eight)
        && s.unlit[i] == f.surface.unlit;
    let what = if (s.part[i], s.side[i]) != (f.part, f.side) {
        format!("part and side {:?}, expected {:?}", (s.part[i], s.side[i]), (f.part, f.side))
    } else if (s.depth[i] - f.depth).abs() > depth_by {
        format!("depths {} and {} may differ by {depth_by}", s.depth[i], f.depth)
    } else if off.is_nan() || off >= normal_by {
        format!("normal off by {off}")
    } else if !color || !near(s.base_color[i][3], c[3], 1.0 / 255.0) {
        format!("colour {:?}, expected {c:?}, or emission", s.base_color[i])
    } else if !material {
        "metalness, roughness, occlusion or unlit".to_owned()
    } else {
        return (off, None);
    };
    (off, Some(format!("triangle {}: {what}", f.triangle)))
}

/// A capture with wide keys: the fragments of every pixel, their order, and what they carry. `k` is how many layers are
/// kept, `turn` how many radians a smooth normal may turn over a pixel. *Worst* is an angle between normals, radians.
pub fn capture(
    scene: &Scene,
    camera: &Camera,
    expected: &Layers,
    s: &StoreData,
    k: usize,
    (encoding, turn): (NormalEncoding, f64),
) -> Comparison {
    let view = View::new(camera, [s.width, s.height], DVec2::ZERO);
    let slopes = Slopes::new(scene, camera);
    // A smooth normal turns as the sample moves on its facet.
    let normal_by = encoding_error(encoding) + turn / 256.0;
    let mut result = Comparison::default();
    for (pixel, expected) in expected.pixels.iter().enumerate() {
        result.samples += expected.fragments.len();
        let tolerance = |f: &Fragment| slopes.tolerance(f, &view);
        let range = s.range(pixel);
        let mut last: Option<&Fragment> = None;
        for i in range.clone() {
            let Some(f) = expected.fragments.iter().find(|f| f.triangle == s.triangle[i]) else {
                if expected.ambiguous {
                    result.ambiguous += 1;
                } else {
                    result.fault(pixel, || format!("triangle {} is not there", s.triangle[i]));
                }
                continue;
            };
            // Snapping may swap two surfaces that are as close as the depth of either may be off.
            if let Some(nearer) = last.replace(f)
                && (nearer.depth_key, nearer.triangle) > (f.depth_key, f.triangle)
            {
                if nearer.depth - f.depth <= tolerance(nearer) + tolerance(f) {
                    result.ambiguous += 1;
                } else {
                    result.fault(pixel, || format!("triangles {} and {} are swapped", nearer.triangle, f.triangle));
                }
            }
            if f.ambiguous {
                continue;
            }
            let (off, fault) = surface_fault(s, i, f, tolerance(f), normal_by);
            result.worst = result.worst.max(off);
            if let Some(what) = fault {
                result.fault(pixel, || what);
            }
        }
        result.ambiguous += expected.fragments.iter().filter(|f| f.ambiguous).count();
        let there = |f: &Fragment| s.triangle[range.clone()].contains(&f.triangle);
        for (layer, f) in expected.fragments.iter().enumerate() {
            let cut = layer >= k || (s.overflowed[pixel] && s.counts[pixel] as usize == k);
            if !(f.ambiguous || cut || there(f)) {
                result.fault(pixel, || format!("triangle {} is missing", f.triangle));
            }
        }
        if !expected.ambiguous && s.overflowed[pixel] != (expected.fragments.len() > k) {
            result.fault(pixel, || "overflow is marked where there is none, or not where there is".to_owned());
        }
    }
    result
}

/// Links exactly, except where two candidates are as good.
pub fn links(
    scene: &Scene,
    camera: &Camera,
    s: &StoreData,
    found: &[[Link; 4]],
    (term, reverse_check): (DepthTerm, bool),
) -> Comparison {
    links_cut(scene, camera, &[], s, found, (term, reverse_check))
}

/// The same of a scene that planes cut.
pub fn links_cut(
    scene: &Scene,
    camera: &Camera,
    planes: &[CutPlane],
    s: &StoreData,
    found: &[[Link; 4]],
    (term, reverse_check): (DepthTerm, bool),
) -> Comparison {
    let view = View::new(camera, [s.width, s.height], DVec2::ZERO);
    let extents = Extents::new(scene, camera);
    let mut expected = neighbours_by(s, &extents, &view, (term, reverse_check));
    if !planes.is_empty() {
        ViewCut::new(planes, camera, view).apply(s, &mut expected);
    }
    let pixel_of = s.pixel_of_fragment();
    let mut result = Comparison { samples: 4 * expected.links.len(), ..Comparison::default() };
    if found.len() != expected.links.len() {
        result.fault(0, || format!("{} links of {}", found.len(), expected.links.len()));
    }
    for (i, (found, links)) in found.iter().zip(&expected.links).enumerate() {
        for d in 0..4 {
            if expected.ambiguous[i][d] {
                result.ambiguous += 1;
            } else if found[d] != links[d] {
                let what = || format!("fragment {i}, direction {d}: {:?}, expected {:?}", found[d], links[d]);
                result.fault(pixel_of[i], what);
            }
        }
    }
    result
}

/// Where every layer ends, over the same links; what lies behind, over the same ends. Samples are missing neighbours.
pub fn ends(camera: &Camera, s: &StoreData, links: &[[Link; 4]], found: &Ends) -> Comparison {
    let view = View::new(camera, [s.width, s.height], DVec2::ZERO);
    let mut result = Comparison::default();
    let columns = [&found.surface, &found.open, &found.behind];
    if columns.iter().any(|c| c.len() != s.len()) {
        result.fault(0, || format!("ends of {:?} fragments, not {}", columns.map(Vec::len), s.len()));
        return result;
    }
    let (expected, unsure) = Ends::seams(s, links, &view);
    let (behind, behind_unsure) = Ends::behind(s, links, &view, &found.open);
    for (i, &pixel) in s.pixel_of_fragment().iter().enumerate() {
        for d in 0..4 {
            result.samples += usize::from(links[i][d] == Link::Missing);
            let wrong = (found.surface[i][d], found.open[i][d]) != (expected.surface[i][d], expected.open[i][d]);
            let wrong_behind = found.behind[i][d] != behind[i][d];
            if unsure[i][d] || behind_unsure[i][d] {
                result.ambiguous += 1;
            }
            if (wrong && !unsure[i][d]) || (wrong_behind && !behind_unsure[i][d]) {
                let found = columns.map(|c| c[i][d]);
                let expected = [expected.surface[i][d], expected.open[i][d], behind[i][d]];
                result.fault(pixel, || format!("fragment {i}, direction {d}: {found:?}, expected {expected:?}"));
            }
        }
    }
    result
}

/// κ within 1e-3 of the oracle's over the same links. *Worst* is a difference of κ.
pub fn kappa(
    scene: &Scene,
    camera: &Camera,
    s: &StoreData,
    (links, found): (&[[Link; 4]], &[f32]),
    settings: &CurvatureSettings,
) -> Comparison {
    let links = Neighbours { links: links.to_vec(), ambiguous: vec![[false; 4]; links.len()] };
    let view = View::new(camera, [s.width, s.height], DVec2::ZERO);
    let expected = curvature(s, &links, &view, &Extents::new(scene, camera), settings);
    let pixel_of = s.pixel_of_fragment();
    let mut result = Comparison { samples: s.len(), ..Comparison::default() };
    for (i, (&found, &kappa)) in found.iter().zip(&expected.kappa).enumerate() {
        if expected.ambiguous[i] {
            result.ambiguous += 1;
            continue;
        }
        let off = (f64::from(found) - kappa).abs();
        result.worst = result.worst.max(off);
        if off.is_nan() || off > 1e-3 {
            result.fault(pixel_of[i], || {
                let (sum, normal, links) = (expected.sum[i], s.normal[i], links.links[i]);
                let at = s.xy(pixel_of[i]);
                format!("kappa of fragment {i} in {at:?}: {found} and {kappa}, sum {sum}, normal {normal:?}, links {links:?}")
            });
        }
    }
    result
}

/// Colours by fragment or pixel: the first three channels as sRGB, the fourth as it is. *Worst* is in steps of 1/255,
/// which is also where a fault begins.
pub fn colors(found: &[[f32; 4]], expected: &[[f64; 4]]) -> Comparison {
    let mut result = Comparison { samples: found.len(), ..Comparison::default() };
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        let channel = |c: usize| {
            let f = f64::from(f[c]);
            let off = if c < 3 { srgb_from_linear(f) - srgb_from_linear(e[c]) } else { f - e[c] };
            if off.is_nan() { f64::INFINITY } else { 255.0 * off.abs() }
        };
        let off = (0..4).map(channel).fold(0.0, f64::max);
        result.worst = result.worst.max(off);
        if off > 1.0 {
            result.fault(i, || format!("{i}: {f:?} and {e:?}"));
        }
    }
    result
}

/// The whole way in `f64`, from the scene alone: the picture that a user should see, premultiplied and linear, without
/// background. `jitter` in pixels.
pub fn picture(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    transfer: &TransferFunction,
    size: [u32; 2],
    jitter: DVec2,
) -> composite::LinearImage {
    let extents = Extents::new(scene, camera);
    let store = StoreData::from_layers(&rasterize(scene, camera, size, jitter));
    let view = View::new(camera, size, jitter);
    let how = (settings.features.depth_term, settings.features.reverse_check);
    let links = neighbours_by(&store, &extents, &view, how);
    let bent = curvature(&store, &links, &view, &extents, &settings.features.curvature);
    let lit = shade::shade(&store, &view, &rig(&settings.light));
    let tables = Tables::of(transfer);
    let mut colors = stylize::stylize(&store, &lit, &bent.kappa, &extents, &settings.opacity, &tables);
    for (color, opacity) in colors.iter_mut().zip(models::opacities(&store, &links.links, &view, &settings.opacity)) {
        color[3] *= opacity;
    }
    if settings.opacity.model == OpacityModel::Illustrative {
        let base: Vec<f64> = colors.iter().map(|c| c[3]).collect();
        let (ends, _) = Ends::find(&store, &links.links, &view);
        let surfaces = Surfaces { store: &store, links: &links.links, ends: &ends, bare: false };
        let (_, opacities) = illustrated(&surfaces, &base, &settings.opacity.illustrative);
        colors.iter_mut().zip(opacities).for_each(|(color, opacity)| color[3] = opacity);
    }
    composite::front_to_back(&store, &colors, None)
}

/// Fields after diffusion and the opacity of every fragment, from where surfaces end and base opacity. Never as printed.
pub fn illustrated(
    surfaces: &Surfaces<'_>,
    base: &[f64],
    settings: &IllustrativeSettings,
) -> (illustration::Fields, Vec<f64>) {
    let settings = settings.in_pixels([surfaces.store.width, surfaces.store.height]);
    let settings = IllustrativeSettings { printed: PrintedForm::None, ..settings };
    let surfaces = Surfaces { bare: false, ..*surfaces };
    let base: Vec<f64> = base.iter().map(|b| b * settings.base_gain).collect();
    let begun = illustration::boundary(&surfaces, &base);
    let fields = illustration::diffuse(&illustration::Graph::of(&surfaces, &settings), &begun, &settings);
    let opacities = illustration::opacities(&fields, &settings);
    (fields, opacities)
}
