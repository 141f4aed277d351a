//! The measurements: each a figure of one method over one case.

use std::collections::HashSet;

use glam::{DVec2, DVec3, Vec3};

use super::shot::scene_of;
use super::{CaseError, Effort, Figure, Shot, random};
use crate::math::Camera;
use crate::math::color::srgb_from_linear;
use crate::oracle::compare::{self, Comparison, rig};
use crate::oracle::stylize::Tables;
use crate::oracle::{Extents, Layers, Link, View, composite, rasterize, shade, stylize};
use crate::plan::Capture;
use crate::render::{DrawOrder, RenderError, Renderer};
use crate::scene::hard_case::{HardCase, Measure, Method, Source};
use crate::scene::{Arrangement, Scene, Section};
use crate::settings::{CaptureKind, OpacityModel, Settings};

/// Radians that a smooth normal may turn over a pixel in a case's picture.
pub(super) const TURN: f64 = 0.5;

/// A case with one of its methods, ready to be drawn.
pub(super) struct Stand<'a> {
    pub(super) r: &'a mut Renderer,
    pub(super) case: &'a HardCase,
    method: &'a Method,
    pub(super) settings: Settings,
    pub(super) scene: Scene,
    /// What cuts it.
    sections: Vec<Section>,
    pub(super) effort: Effort,
}

/// A share in percent.
fn percent(part: usize, of: usize) -> f64 {
    100.0 * part as f64 / of.max(1) as f64
}

/// The value below which a share `p` of the values lies.
fn percentile(values: &mut [f64], p: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    if values.is_empty() { f64::NAN } else { values[((values.len() - 1) as f64 * p) as usize] }
}

pub(super) fn share(wrong: usize, samples: usize) -> Figure {
    Figure { value: percent(wrong, samples), samples, ambiguous: 0 }
}

fn faults(found: &Comparison) -> Figure {
    // A layer that is missing and one that stands in its place are two faults: a share of all that is there or should be.
    let value = percent(found.faults.len(), found.samples.max(found.faults.len()));
    Figure { value, samples: found.samples, ambiguous: found.ambiguous }
}

impl<'a> Stand<'a> {
    pub(super) fn new(
        r: &'a mut Renderer,
        case: &'a HardCase,
        method: &'a Method,
        effort: Effort,
    ) -> Result<Stand<'a>, CaseError> {
        let settings = Settings::from_pairs(method.settings)?;
        let source = method.scene.as_ref().unwrap_or(&case.scene);
        let scene = scene_of(source)?;
        let sections = match *source {
            Source::Cut(_, normal, offset) => vec![Section { normal, offset, enabled: true, caps: false }],
            Source::Builtin(_) | Source::ThroughFile(_) | Source::Bytes(_) => Vec::new(),
        };
        r.draw_order = DrawOrder::default();
        Ok(Stand { r, case, method, settings, scene, sections, effort })
    }

    pub(super) fn camera(&self, scene: &Scene) -> Camera {
        self.case.camera.of(&scene.bounds(), self.case.size)
    }

    pub(super) fn measure(&mut self) -> Result<Figure, CaseError> {
        match self.case.measure {
            Measure::FragmentsLost => self.fragments_lost(),
            Measure::LayersWrong => self.layers_wrong(),
            Measure::OutOfOrder => self.out_of_order(),
            Measure::Unaccounted => self.unaccounted(),
            Measure::NormalError => self.normal_error(),
            Measure::LinksWrong => self.links_wrong(),
            Measure::FalseRims => self.false_rims(),
            Measure::LinksUnlike(twin) => self.links_unlike(&twin),
            Measure::KappaUnlike(twin) => self.kappa_unlike(&twin),
            Measure::SphereCurvature(facing) => self.sphere_curvature(facing),
            Measure::CurvatureSpread => self.curvature_spread(),
            Measure::CurvaturePeak => self.curvature_peak(),
            Measure::NotRefused => self.not_refused(),
            Measure::KappaError => self.kappa_error(),
            Measure::ColorError => self.color_error(),
            Measure::LightError => self.light_error(),
            Measure::StyleError => self.style_error(),
            Measure::BlendError => self.blend_error(),
            Measure::PictureError => self.picture_error(),
            Measure::UnlikeExact => self.unlike_exact(),
            Measure::OrderDependence(orders) => self.order_dependence(orders),
            Measure::PictureUnlike(twin) => self.picture_unlike(&twin),
            Measure::LinksOneWay => self.links_one_way(),
            Measure::FieldError => self.field_error(),
            Measure::FieldOpacityError => self.field_opacity_error(),
            Measure::Halos => self.halos(),
            Measure::HalosOffContours => self.halos_off_contours(),
            Measure::RandomScenes => random::scenes(self),
        }
    }

    /// Draws `scene`; a picture that is not finite, or of ours whose books do not balance, is no figure but a fault.
    pub(super) fn shoot(&mut self, scene: &Scene, camera: &Camera, settings: &Settings) -> Result<Shot, CaseError> {
        let mut loaded = self.r.load(scene)?;
        if !self.sections.is_empty() {
            let arrangement = Arrangement { sections: self.sections.clone(), ..Arrangement::default() };
            self.r.arrange(&mut loaded, scene, &arrangement)?;
        }
        let shot = Shot::of(self.r, &loaded, camera, settings, self.case.size)?;
        let report = &shot.frame.report;
        if report.bands > 1 {
            return Err(CaseError::Banded { bands: report.bands });
        }
        if let Some(fault) = shot.fault() {
            return Err(CaseError::Broken(fault.to_owned()));
        }
        // Where the books themselves are measured, they are the figure.
        let measured = matches!(self.case.measure, Measure::Unaccounted);
        if std::ptr::eq(self.method, &self.case.ours) && !measured && !report.layers.balanced() {
            return Err(CaseError::Broken(format!("the books do not balance: {:?}", report.layers)));
        }
        Ok(shot)
    }

    pub(super) fn shot(&mut self) -> Result<Shot, CaseError> {
        let (scene, settings) = (self.scene.clone(), self.settings.clone());
        self.shoot(&scene, &self.camera(&scene), &settings)
    }

    /// The same by shaders without a change.
    pub(super) fn unchanged(&mut self, scene: &Scene, settings: &Settings) -> Result<Shot, CaseError> {
        let replaced = match &self.method.shader {
            Some(change) => Some((change.module, super::changed_module(change)?)),
            None => None,
        };
        if let Some((module, _)) = &replaced {
            self.r.replace_shader(module, None);
        }
        let shot = self.shoot(scene, &self.camera(scene), settings);
        if let Some((module, text)) = replaced {
            self.r.replace_shader(module, Some(text));
        }
        shot
    }

    /// Whole lists, unchanged shaders.
    fn exact_shot(&mut self) -> Result<Shot, CaseError> {
        let mut settings = self.settings.clone();
        settings.capture.kind = CaptureKind::Compacted;
        let scene = self.scene.clone();
        self.unchanged(&scene, &settings)
    }

    fn layers(&self) -> Layers {
        rasterize(&self.scene, &self.camera(&self.scene), self.case.size, DVec2::ZERO)
    }

    fn fragments_lost(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let (store, wide) = (&shot.store.layers, shot.frame.report.plan.capture.is_wide());
        let mut figure = Figure::default();
        let mut wrong = 0;
        for (pixel, exact) in self.layers().pixels.iter().enumerate() {
            figure.samples += exact.fragments.len();
            if exact.uncertain_fragments {
                figure.ambiguous += exact.fragments.len();
                continue;
            }
            wrong += if wide {
                let stored: HashSet<u32> = store.range(pixel).map(|i| store.triangle[i]).collect();
                let there: HashSet<u32> = exact.fragments.iter().map(|f| f.triangle).collect();
                stored.symmetric_difference(&there).count()
            } else {
                (store.counts[pixel] as usize).abs_diff(exact.fragments.len())
            };
        }
        figure.value = percent(wrong, figure.samples - figure.ambiguous);
        Ok(figure)
    }

    fn layers_wrong(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let k = match shot.frame.report.plan.capture {
            Capture::BucketedKBuffer { k, .. } => k as usize,
            Capture::Compacted | Capture::LinkedList { .. } | Capture::None => usize::MAX,
        };
        let camera = self.camera(&self.scene);
        let how = (self.settings.capture.normals, TURN);
        Ok(faults(&compare::capture(&self.scene, &camera, &self.layers(), &shot.store.layers, k, how)))
    }

    fn out_of_order(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let store = &shot.store.layers;
        let (mut inversions, mut pairs) = (0, 0);
        for (pixel, exact) in self.layers().pixels.iter().enumerate() {
            let depth_of = |part: u32| exact.fragments.iter().find(|f| f.part == part).map(|f| f.depth);
            let depths: Vec<f64> = store.range(pixel).filter_map(|i| depth_of(store.part[i])).collect();
            pairs += depths.len().saturating_sub(1);
            inversions += depths.windows(2).filter(|w| w[0] > w[1]).count();
        }
        Ok(share(inversions, pairs))
    }

    fn unaccounted(&mut self) -> Result<Figure, CaseError> {
        let counts = self.shot()?.frame.report.layers;
        let explained = counts.stored + counts.merged + counts.dropped;
        let wrong = counts.lost.max(counts.rasterized.abs_diff(explained));
        Ok(share(wrong as usize, counts.rasterized as usize))
    }

    /// Stored fragments beside the oracle's, in pixels where nothing is ambiguous and all are there.
    fn paired(&self, shot: &Shot, mut see: impl FnMut(usize, &crate::oracle::Fragment)) -> usize {
        let store = &shot.store.layers;
        let mut samples = 0;
        for (pixel, exact) in self.layers().pixels.iter().enumerate() {
            let range = store.range(pixel);
            if !exact.ambiguous && range.len() == exact.fragments.len() {
                samples += range.len();
                range.zip(&exact.fragments).for_each(|(i, f)| see(i, f));
            }
        }
        samples
    }

    fn normal_error(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let mut worst = 0.0_f64;
        let samples = self.paired(&shot, |i, f| {
            let n = Vec3::from(shot.store.layers.normal[i]).as_dvec3().normalize();
            worst = worst.max((n - f.normal_in_view).length().to_degrees());
        });
        Ok(Figure { value: worst, samples, ambiguous: 0 })
    }

    fn color_error(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let mut worst = 0.0_f64;
        let samples = self.paired(&shot, |i, f| {
            for c in 0..3 {
                let stored = srgb_from_linear(f64::from(shot.store.layers.base_color[i][c]));
                worst = worst.max(255.0 * (stored - srgb_from_linear(f.surface.base_color[c])).abs());
            }
        });
        Ok(Figure { value: worst, samples, ambiguous: 0 })
    }

    fn links_wrong(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let f = &self.settings.features;
        let (camera, how) = (self.camera(&self.scene), (f.depth_term, f.reverse_check));
        Ok(faults(&compare::links(&self.scene, &camera, &shot.store.layers, &shot.store.links, how)))
    }

    fn kappa_error(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let features = (shot.store.links.as_slice(), shot.store.kappa.as_slice());
        let (camera, settings) = (self.camera(&self.scene), &self.settings.features.curvature);
        let found = compare::kappa(&self.scene, &camera, &shot.store.layers, features, settings);
        Ok(Figure { value: found.worst, samples: found.samples, ambiguous: found.ambiguous })
    }

    /// Fragments are matched by pixel and triangle: a k-buffer's rows are cut.
    fn false_rims(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        // What was never cut knows where surfaces end.
        let sections = std::mem::take(&mut self.sections);
        let exact = self.exact_shot();
        self.sections = sections;
        let exact = exact?;
        let (a, b) = (&shot.store, &exact.store);
        let mut wrong = 0;
        for pixel in 0..a.layers.counts.len().min(b.layers.counts.len()) {
            let all = b.layers.range(pixel);
            for i in a.layers.range(pixel) {
                let same = all.clone().find(|&j| b.layers.triangle[j] == a.layers.triangle[i]);
                let Some(j) = same else { continue };
                let ends = |l: Link| l == Link::Missing;
                wrong += (0..4).filter(|&d| ends(a.links[i][d]) && !ends(b.links[j][d])).count();
            }
        }
        Ok(share(wrong, 4 * a.links.len()))
    }

    fn links_unlike(&mut self, twin: &Source) -> Result<Figure, CaseError> {
        let twin = scene_of(twin)?;
        let settings = self.settings.clone();
        let (a, b) = (self.shot()?, self.shoot(&twin, &self.camera(&twin), &settings)?);
        let samples = 4 * a.store.links.len();
        if a.store.layers.counts != b.store.layers.counts {
            return Ok(share(samples, samples));
        }
        let pairs = a.store.links.iter().flatten().zip(b.store.links.iter().flatten());
        Ok(share(pairs.filter(|(a, b)| a != b).count(), samples))
    }

    fn kappa_unlike(&mut self, twin: &Source) -> Result<Figure, CaseError> {
        let twin = scene_of(twin)?;
        let settings = self.settings.clone();
        let (a, b) = (self.shot()?, self.unchanged(&twin, &settings)?);
        let samples = a.store.kappa.len();
        if a.store.layers.counts != b.store.layers.counts {
            return Ok(share(samples, samples));
        }
        let pairs = a.store.kappa.iter().zip(&b.store.kappa);
        Ok(share(pairs.filter(|(a, b)| (*a - *b).abs() > 0.01).count(), samples))
    }

    /// κ₁ + κ₂ of a fragment in 1 / scene unit, out of κ; the case's unit is the world's.
    fn sum_of(&self, kappa: f32) -> f64 {
        -f64::from(kappa).clamp(-0.999_999, 0.999_999).atanh() / self.settings.features.curvature.scale
    }

    fn sphere_curvature(&mut self, facing: f64) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let layers = &shot.store.layers;
        let mut errors: Vec<f64> = (0..layers.len())
            .filter(|&i| layers.side[i] && (f64::from(layers.normal[i][2]) - facing).abs() < 0.02)
            .filter(|&i| !shot.store.links[i].contains(&Link::Missing))
            .map(|i| 100.0 * (self.sum_of(shot.store.kappa[i]) - 2.0).abs() / 2.0)
            .collect();
        Ok(Figure { value: percentile(&mut errors, 0.5), samples: errors.len(), ambiguous: 0 })
    }

    /// κ₁ + κ₂ of the front of a cylinder, away from its ends and rims.
    fn cylinder_curvatures(&mut self) -> Result<Vec<f64>, CaseError> {
        let shot = self.shot()?;
        let layers = &shot.store.layers;
        let pixel_of = layers.pixel_of_fragment();
        let middle = self.case.size[1] / 2;
        let in_the_middle = |i: usize| layers.xy(pixel_of[i]).1.abs_diff(middle) < self.case.size[1] * 5 / 32;
        Ok((0..layers.len())
            .filter(|&i| layers.side[i] && layers.normal[i][2] > 0.5 && in_the_middle(i))
            .map(|i| self.sum_of(shot.store.kappa[i]))
            .collect())
    }

    fn curvature_peak(&mut self) -> Result<Figure, CaseError> {
        let mut sums = self.cylinder_curvatures()?;
        Ok(Figure { value: percentile(&mut sums, 0.99), samples: sums.len(), ambiguous: 0 })
    }

    /// Draws what cannot be drawn, with both captures and without layers; for the contrast one pixel, which can.
    fn not_refused(&mut self) -> Result<Figure, CaseError> {
        let (scene, camera) = (self.scene.clone(), self.camera(&self.scene));
        let size = if std::ptr::eq(self.method, &self.case.ours) { self.case.size } else { [1, 1] };
        let mut drawn = 0;
        let kinds = ["capture.kind=compacted", "capture.kind=bucketed_k_buffer", "opacity.model=opaque"];
        for kind in kinds {
            let settings = Settings::from_pairs(&format!("{} {kind}", self.method.settings))?;
            match Shot::take(self.r, &scene, &camera, &settings, size) {
                Ok(_) => drawn += 1,
                Err(RenderError::Refused(refusal)) if !refusal.to_string().is_empty() => {}
                Err(e) => return Err(e.into()),
            }
        }
        Ok(share(drawn, kinds.len()))
    }

    fn curvature_spread(&mut self) -> Result<Figure, CaseError> {
        let mut sums = self.cylinder_curvatures()?;
        let value = percentile(&mut sums, 0.9) - percentile(&mut sums, 0.1);
        Ok(Figure { value, samples: sums.len(), ambiguous: 0 })
    }

    /// The same frame before stylization: lit colours as light alone makes them.
    fn plain(&self) -> Settings {
        let mut settings = self.settings.clone();
        settings.opacity.model = OpacityModel::Constant;
        settings
    }

    fn light_error(&mut self) -> Result<Figure, CaseError> {
        let (scene, settings) = (self.scene.clone(), self.plain());
        let camera = self.camera(&scene);
        let shot = self.shoot(&scene, &camera, &settings)?;
        let layers = &shot.store.layers;
        let lit = shade::shade(layers, &View::new(&camera, self.case.size, DVec2::ZERO), &rig(&settings.light));
        let expected: Vec<[f64; 4]> =
            lit.iter().zip(&layers.base_color).map(|(c, b)| [c[0], c[1], c[2], f64::from(b[3])]).collect();
        let found = compare::colors(&shot.store.lit, &expected);
        Ok(Figure { value: found.worst, samples: found.samples, ambiguous: 0 })
    }

    fn style_error(&mut self) -> Result<Figure, CaseError> {
        let (scene, settings) = (self.scene.clone(), self.plain());
        let camera = self.camera(&scene);
        let plain = self.unchanged(&scene, &settings)?;
        let shot = self.shot()?;
        let transfer = self.settings.opacity.transfer.resolve(None).map_err(crate::render::RenderError::from)?;
        let lit: Vec<[f64; 3]> =
            plain.store.lit.iter().map(|c| DVec3::from([c[0], c[1], c[2]].map(f64::from)).to_array()).collect();
        let kappa: Vec<f64> = shot.store.kappa.iter().map(|&k| f64::from(k)).collect();
        let extents = Extents::new(&scene, &camera);
        let styled = stylize::stylize(
            &shot.store.layers,
            &lit,
            &kappa,
            &extents,
            &self.settings.opacity,
            &Tables::of(&transfer),
        );
        let found = compare::colors(&shot.store.lit, &styled);
        Ok(Figure { value: found.worst, samples: found.samples, ambiguous: 0 })
    }

    fn blend_error(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let exact = composite::front_to_back(&shot.store.layers, &shot.colors(), None);
        let off = off_by(&shot, &exact);
        let covered = shot.store.layers.counts.iter().filter(|c| **c > 0).count();
        Ok(Figure { value: off.into_iter().fold(0.0, f64::max), samples: covered, ambiguous: 0 })
    }

    fn picture_error(&mut self) -> Result<Figure, CaseError> {
        let shot = self.shot()?;
        let transfer = self.settings.opacity.transfer.resolve(None).map_err(crate::render::RenderError::from)?;
        let camera = self.camera(&self.scene);
        let exact = compare::picture(&self.scene, &camera, &self.settings, &transfer, self.case.size, DVec2::ZERO);
        let off = off_by(&shot, &exact);
        let samples = off.len();
        Ok(Figure { value: off.iter().sum::<f64>() / samples.max(1) as f64, samples, ambiguous: 0 })
    }

    fn unlike_exact(&mut self) -> Result<Figure, CaseError> {
        let (a, b) = (self.shot()?.bits(), self.exact_shot()?.bits());
        Ok(share(a.iter().zip(&b).filter(|(a, b)| a != b).count(), a.len()))
    }

    fn order_dependence(&mut self, orders: u32) -> Result<Figure, CaseError> {
        let first = self.shot()?.bits();
        let camera = self.camera(&self.scene);
        let mut differ = vec![false; first.len()];
        for seed in 1..=u64::from(orders) {
            let loaded = self.r.load_shuffled(&self.scene, seed)?;
            self.r.draw_order = DrawOrder::Shuffled(seed);
            let shot = Shot::of(self.r, &loaded, &camera, &self.settings, self.case.size);
            self.r.draw_order = DrawOrder::default();
            for (differ, (a, b)) in differ.iter_mut().zip(first.iter().zip(shot?.bits())) {
                *differ |= *a != b;
            }
        }
        Ok(share(differ.iter().filter(|d| **d).count(), first.len()))
    }

    fn picture_unlike(&mut self, twin: &Source) -> Result<Figure, CaseError> {
        let twin = scene_of(twin)?;
        let settings = self.settings.clone();
        let (a, b) = (self.shot()?, self.unchanged(&twin, &settings)?);
        let pairs = a.frame.image.pixels.iter().zip(&b.frame.image.pixels);
        let differ = pairs.filter(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 1.0 / 255.0)).count();
        Ok(share(differ, a.frame.image.pixels.len()))
    }
}

/// For each pixel the largest difference of a channel from the exact picture, linear, in steps of 1/255.
fn off_by(shot: &Shot, exact: &[[f64; 4]]) -> Vec<f64> {
    let off =
        |(f, e): (&[f32; 4], &[f64; 4])| (0..4).map(|c| 255.0 * (f64::from(f[c]) - e[c]).abs()).fold(0.0, f64::max);
    shot.frame.image.pixels.iter().zip(exact).map(off).collect()
}
