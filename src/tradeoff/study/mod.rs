//! What Carnecky 2013 asked 36 people, asked of the picture: is it plain which sheet lies in front?
//!
//! Their study (section 8) has tasks that can only be solved by somebody who sees which of two crossing edges occludes the other:
//! which layer a point lies on, where a boundary runs on, what is nearest. What tells is the contrast across the occluding edge
//! where it crosses another (section 3: T-junctions order depth, and the strength of the cue goes with the contrast). So the
//! luminance of the PNG, and nothing else, is taken on both sides of the occluding edge at junctions that are found in the geometry
//! ([`junctions`]), the same for all models.
//!
//! - **Luminance** is relative luminance Y: 0.2126 R + 0.7152 G + 0.0722 B of the PNG's sRGB values decoded to linear light.
//! - **The step** of a junction is |ΔY| across the edge, each side the mean of three places 1.5 to 3.5 pixels away from it, in the
//!   mean over two crossings.
//! - **No model wins by brightness.** The opacities of each model are multiplied with one number, found by trying, so that the
//!   mean luminance of all covered pixels is that of constant opacity within two percent. What cannot get there is said.
//!
//! Where we differ from the paper: nobody is asked. A step in luminance is a cue, not an answer.

pub mod junctions;

use glam::{DQuat, DVec2, DVec3};
use serde::Serialize;

use crate::export::image::parse_background;
use crate::export::png::{PngError, read_png, write_png};
use crate::math::{Camera, LinearImage};
use crate::render::{GpuScene, RenderError, Renderer};
use crate::settings::{Settings, SettingsError, looks};
use junctions::Junction;

/// A way to make layers transparent that takes part.
#[derive(Clone, Copy, Debug)]
pub struct Contender {
    /// What to call it.
    pub name: &'static str,
    /// A preset that it begins with; one that does not exist does not take part.
    pub look: Option<&'static str>,
    /// `path=value` pairs on top.
    pub settings: &'static str,
    /// The settings that make it as a whole more or less opaque: all are multiplied with one number.
    pub gains: &'static [&'static str],
}

/// All that take part. The first is what the others are compared with, and takes the settings as they are.
pub const CONTENDERS: &[Contender] = &[
    Contender { name: "constant", look: None, settings: "opacity.model=constant", gains: &["opacity.constant"] },
    Contender {
        name: "angle-based",
        look: None,
        settings: "opacity.model=angle_based",
        gains: &["opacity.angle.low", "opacity.angle.high"],
    },
    Contender {
        name: "normal variation",
        look: None,
        settings: "opacity.model=normal_variation",
        gains: &["opacity.variation.low", "opacity.variation.high"],
    },
    Contender { name: "curvature", look: None, settings: "opacity.model=curvature", gains: &["opacity.gain"] },
    Contender {
        name: "illustrative",
        look: None,
        settings: "opacity.model=illustrative opacity.illustrative.base=adaptive opacity.illustrative.base_gain=1 \
                   opacity.illustrative.unit=pixel opacity.illustrative.feature_size=0",
        gains: &["opacity.adaptive"],
    },
    Contender { name: "pellucid", look: Some("pellucid"), settings: "", gains: &["opacity.illustrative.base_gain"] },
];

/// Why a study could not be made.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A picture could not be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture could not be written or read.
    #[error(transparent)]
    Png(#[from] PngError),
    /// A contender's settings are not allowed.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The picture takes several bands, so that its layers cannot be read back.
    #[error("the picture takes {bands} bands: junctions are found in pictures of one; a smaller size is needed")]
    Banded {
        /// Bands that it takes.
        bands: usize,
    },
    /// The background is none.
    #[error("{0}")]
    Background(String),
}

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Size of the pictures.
    pub size: [u32; 2],
    /// Junctions to take.
    pub junctions: usize,
    /// What their choice depends on.
    pub seed: u64,
}

/// What a contender reached.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub name: &'static str,
    /// What its opacities were multiplied with.
    pub gain: f64,
    /// Mean luminance of the covered pixels.
    pub luminance: f64,
    /// That over the first contender's.
    pub luminance_ratio: f64,
    /// Mean of the junctions' steps.
    pub mean: f64,
    /// Their median.
    pub median: f64,
    /// The mean over the first contender's.
    pub ratio: f64,
    /// Mean step at each of the distances from the edge alone, in the order of [`junctions::DISTANCES`].
    pub by_distance: [f64; junctions::DISTANCES.len()],
}

/// A study of one model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Junctions that there are; at most as many as asked for are taken.
    pub found: usize,
    /// Places at which one was looked for.
    pub cracks: usize,
    /// Every contender.
    pub rows: Vec<Row>,
    /// Contenders that took no part, and why.
    pub absent: Vec<String>,
    /// The junctions that were taken: in which view, and where, pixels.
    pub places: Vec<(usize, [f64; 2])>,
}

/// A view, the pixels that something covers in it, and its junctions.
struct Sight {
    camera: Camera,
    covered: Vec<bool>,
    junctions: Vec<Junction>,
}

/// What the contenders are drawn in.
struct Scenery<'a> {
    renderer: &'a mut Renderer,
    scene: &'a GpuScene,
    size: [u32; 2],
    sights: Vec<Sight>,
}

/// A picture as somebody sees it who has the PNG.
struct Seen {
    width: usize,
    luminance: Vec<f64>,
}

impl Seen {
    fn of(image: &LinearImage, background: Option<[f32; 3]>) -> Result<Seen, StudyError> {
        let decoded = read_png(&write_png(image, background, 8)?)?;
        let y = |p: &[f32; 4]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
        Ok(Seen { width: decoded.width as usize, luminance: decoded.pixels.iter().map(y).collect() })
    }

    /// Between four pixels.
    fn at(&self, place: DVec2) -> f64 {
        let corner = (place - 0.5).max(DVec2::ZERO);
        let (x, y) = (corner.x.floor() as usize, corner.y.floor() as usize);
        let t = corner - corner.floor();
        let height = self.luminance.len() / self.width.max(1);
        let value = |x: usize, y: usize| self.luminance[y.min(height - 1) * self.width + x.min(self.width - 1)];
        let row = |y: usize| value(x, y) * (1.0 - t.x) + value(x + 1, y) * t.x;
        row(y) * (1.0 - t.y) + row(y + 1) * t.y
    }

    /// The step of a junction: of all distances together, and of each.
    fn step(&self, junction: &Junction) -> (f64, [f64; junctions::DISTANCES.len()]) {
        let crossings = junction.crossings();
        let n = junctions::DISTANCES.len();
        let mean = |places: &[DVec2]| places.iter().map(|p| self.at(*p)).sum::<f64>() / places.len() as f64;
        let over = |of: &dyn Fn(&junctions::Crossing) -> f64| crossings.iter().map(of).sum::<f64>() / 2.0;
        let all = over(&|[inner, outer]| (mean(inner) - mean(outer)).abs());
        let mut each = [0.0; junctions::DISTANCES.len()];
        for (d, step) in each.iter_mut().enumerate().take(n) {
            *step = over(&|[inner, outer]| (self.at(inner[d]) - self.at(outer[d])).abs());
        }
        (all, each)
    }
}

/// All views of one contender.
struct Shown {
    seen: Vec<Seen>,
    /// Mean luminance of the covered pixels.
    luminance: f64,
    gain: f64,
}

impl Scenery<'_> {
    fn show(&mut self, settings: &Settings, gain: f64) -> Result<Shown, StudyError> {
        let background = parse_background(&settings.image.background).map_err(StudyError::Background)?;
        let mut shown = Shown { seen: Vec::new(), luminance: 0.0, gain };
        let mut pixels = 0;
        for sight in &self.sights {
            let frame = self.renderer.render(self.scene, &sight.camera, settings, self.size)?;
            let seen = Seen::of(&frame.image, background)?;
            let covered = seen.luminance.iter().zip(&sight.covered).filter(|(_, covered)| **covered);
            pixels += covered.clone().count();
            shown.luminance += covered.map(|(y, _)| y).sum::<f64>();
            shown.seen.push(seen);
        }
        shown.luminance /= pixels.max(1) as f64;
        Ok(shown)
    }

    /// The contender as bright as `wanted`, or as near as its gains lead.
    fn equalized(
        &mut self,
        base: &Settings,
        contender: &Contender,
        wanted: Option<f64>,
    ) -> Result<Option<Shown>, StudyError> {
        let Some(plain) = contender.settings(base, 1.0)? else { return Ok(None) };
        let mut shown = self.show(&plain, 1.0)?;
        let Some(wanted) = wanted else { return Ok(Some(shown)) };
        // Surfaces are brighter than the ground, so that more opacity is more light. The next try is where a straight line
        // between the ends of the interval would have it, once both are known.
        let (mut low, mut high) = ((-MOST_GAIN.ln(), None), (MOST_GAIN.ln(), None));
        for _ in 0..TRIES {
            if (shown.luminance / wanted - 1.0).abs() <= CLOSE {
                break;
            }
            let here = (shown.gain.ln(), Some(shown.luminance));
            if shown.luminance < wanted {
                low = here
            } else {
                high = here
            }
            let next = match (low, high) {
                ((a, Some(dark)), (b, Some(bright))) => {
                    a + (b - a) * ((wanted - dark) / (bright - dark)).clamp(0.1, 0.9)
                }
                // A factor of two at first, then as far as it goes.
                ((a, Some(_)), (b, None)) => (a + std::f64::consts::LN_2).min(0.5 * (a + b).max(a)),
                ((a, None), (b, Some(_))) => (b - std::f64::consts::LN_2).max(0.5 * (a + b).min(b)),
                ((a, None), (b, None)) => 0.5 * (a + b),
            };
            let Some(settings) = contender.settings(base, next.exp())? else { break };
            shown = self.show(&settings, next.exp())?;
        }
        Ok(Some(shown))
    }
}

/// As many cameras as asked for, all around what the first looks at.
pub fn around(camera: &Camera, views: u32) -> Vec<Camera> {
    let turned = |i: u32| {
        let turn = DQuat::from_axis_angle(
            camera.view_up.normalize_or(DVec3::Y),
            std::f64::consts::TAU * f64::from(i) / f64::from(views.max(1)),
        );
        Camera { position: camera.focal_point + turn * (camera.position - camera.focal_point), ..*camera }
    };
    (0..views.max(1)).map(turned).collect()
}

impl Contender {
    /// Its settings with all gains multiplied, each as far as its range goes. `None` if it does not exist.
    fn settings(&self, base: &Settings, gain: f64) -> Result<Option<Settings>, StudyError> {
        let mut settings = base.clone();
        if let Some(look) = self.look
            && (!looks::LOOKS.iter().any(|l| l.name == look) || looks::apply(&mut settings, look).is_err())
        {
            return Ok(None);
        }
        for pair in self.settings.split_whitespace() {
            let (path, value) = pair.split_once('=').unwrap_or((pair, ""));
            settings.set(path, value)?;
        }
        for path in self.gains {
            let value = settings.get(path).and_then(|v| v.as_float()).unwrap_or(0.0);
            // Gains go up to 8, opacities to 1.
            let most = if *path == "opacity.gain" { 8.0 } else { 1.0 };
            settings.set(path, &format!("{}", (value * gain).clamp(0.0, most)))?;
        }
        Ok(Some(settings))
    }
}

/// How near the mean luminance has to come, and how often it is tried.
const CLOSE: f64 = 0.02;
const TRIES: u32 = 14;
/// Largest factor, and one over the smallest.
const MOST_GAIN: f64 = 32.0;

/// Draws all contenders over the junctions of some views. `base` says everything that is no contender's: capture, lights,
/// background. `say` hears what is being done.
///
/// # Errors
/// [`StudyError`].
pub fn run(
    renderer: &mut Renderer,
    scene: &GpuScene,
    cameras: &[Camera],
    base: &Settings,
    options: &Options,
    say: &mut dyn FnMut(&str),
) -> Result<Study, StudyError> {
    say("junctions");
    let mut found_by = base.clone();
    found_by.set("opacity.model", "illustrative")?;
    found_by.set("features.depth_term", "continuity")?;
    let mut sights = Vec::new();
    let mut pool: Vec<(usize, Junction)> = Vec::new();
    let mut cracks = 0;
    for (view, camera) in cameras.iter().enumerate() {
        let frame = renderer.render(scene, camera, &found_by, options.size)?;
        if frame.report.bands > 1 {
            return Err(StudyError::Banded { bands: frame.report.bands });
        }
        let store = renderer.read_store(&frame.report, scene, camera)?;
        let covered = store.layers.counts.iter().map(|&n| n > 0).collect();
        let (found, looked_at) = junctions::find(&store.layers, &store.links, options.seed);
        cracks += looked_at;
        pool.extend(found.into_iter().map(|junction| (view, junction)));
        sights.push(Sight { camera: *camera, covered, junctions: Vec::new() });
    }
    let found = pool.len();
    junctions::shuffle(&mut pool, options.seed);
    pool.truncate(options.junctions);
    let places = pool.iter().map(|(view, j)| (*view, j.place.to_array())).collect();
    for (view, junction) in pool {
        sights[view].junctions.push(junction);
    }
    let mut scenery = Scenery { renderer, scene, size: options.size, sights };
    let (rows, absent) = rows(&mut scenery, base, say)?;
    Ok(Study { found, cracks, rows, absent, places })
}

fn rows(
    scenery: &mut Scenery<'_>,
    base: &Settings,
    say: &mut dyn FnMut(&str),
) -> Result<(Vec<Row>, Vec<String>), StudyError> {
    let mut rows: Vec<Row> = Vec::new();
    let mut absent = Vec::new();
    for contender in CONTENDERS {
        say(contender.name);
        let wanted = rows.first().map(|first| first.luminance);
        let Some(shown) = scenery.equalized(base, contender, wanted)? else {
            absent.push(format!("{}: there is no such preset", contender.name));
            continue;
        };
        let views = shown.seen.iter().zip(&scenery.sights);
        let steps: Vec<_> = views.flat_map(|(seen, sight)| sight.junctions.iter().map(|j| seen.step(j))).collect();
        let n = steps.len().max(1) as f64;
        let mean = steps.iter().map(|s| s.0).sum::<f64>() / n;
        let mut sorted: Vec<f64> = steps.iter().map(|s| s.0).collect();
        sorted.sort_by(f64::total_cmp);
        let mut by_distance = [0.0; junctions::DISTANCES.len()];
        for (d, value) in by_distance.iter_mut().enumerate() {
            *value = steps.iter().map(|s| s.1[d]).sum::<f64>() / n;
        }
        let (one, bright) = rows.first().map_or((mean, shown.luminance), |first| (first.mean, first.luminance));
        rows.push(Row {
            name: contender.name,
            gain: shown.gain,
            luminance: shown.luminance,
            luminance_ratio: shown.luminance / bright,
            mean,
            median: sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN),
            ratio: mean / one,
            by_distance,
        });
    }
    Ok((rows, absent))
}

/// The table, one line a contender.
pub fn table(study: &Study) -> String {
    let mut text = format!(
        "{} junctions of {} found at {} places; steps of relative luminance across the occluding edge\n\
         {:<18}{:>8}{:>8}{:>8}{:>12}{:>8}",
        study.places.len(),
        study.found,
        study.cracks,
        "model",
        "mean",
        "median",
        "ratio",
        "luminance",
        "gain"
    );
    for d in junctions::DISTANCES {
        text += &format!("{:>9}", format!("at {d}"));
    }
    text += "\n";
    for row in &study.rows {
        text += &format!(
            "{:<18}{:>8.4}{:>8.4}{:>8.2}{:>8.4}{:>4.0}%{:>7.3}",
            row.name,
            row.mean,
            row.median,
            row.ratio,
            row.luminance,
            100.0 * row.luminance_ratio,
            row.gain
        );
        for step in row.by_distance {
            text += &format!("{step:>9.4}");
        }
        text += "\n";
    }
    for line in &study.absent {
        text += &format!("{line}\n");
    }
    text
}
