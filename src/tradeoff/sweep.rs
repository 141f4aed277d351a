//! Measures configurations: what is wrong in each, and how long it takes.
//!
//! Each is warmed up (the first frame compiles its shaders), compared with its reference, and then timed in turn with the
//! baseline, what the user asked for, so that whatever else the machine does meets both: wall time from settings to picture.
//! The times of the passes come from frames of their own, by timestamps or, where those are wrong, pass by pass.
//! The time that is left is shared among the configurations that are left by the frames that they need; errors go before
//! times. What is refused or fails is a row with its reason, and so is what the time limit did not reach.
//!
//! Layers are compared in a picture of at most [`LAYER_SIDE`] pixels a side: reading millions of layers back would take longer
//! than drawing them.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::axis::{AS_ASKED, Configuration, Judge};
use super::diagram::Point;
use super::image_error::{self, ImageError};
use super::layer_error::{Identity, LayerError, layer_error};
use super::picture::Thumbnails;
use super::statistics::{ENOUGH, Estimate, estimate, median};
use super::workbench::{Drawn, Lane, Layers, Wanted, Workbench};
use crate::gpu::PassTime;
use crate::math::LinearImage;
use crate::passes::capture::LayerCounts;
use crate::render::RenderError;
use crate::settings::Settings;

/// Longest side of the picture in which layers are compared, pixels.
pub const LAYER_SIDE: u32 = 256;

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Options {
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// What is behind the picture, linear light.
    pub background: Option<[f32; 3]>,
    /// Time for everything; errors alone have no limit.
    pub limit: Option<Duration>,
    /// Frames of which times are taken, at most; 0 measures errors alone.
    pub most_frames: usize,
    /// Seed of the intervals.
    pub seed: u64,
    /// Longest side of the thumbnails, pixels; 0 makes none.
    pub thumbnail: u32,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            size: [256, 256],
            background: None,
            limit: Some(Duration::from_secs(120)),
            most_frames: 15,
            seed: 1,
            thumbnail: 160,
        }
    }
}

/// Times of one configuration, milliseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Times {
    /// Whole frames, wall time.
    pub samples: Vec<f64>,
    /// The baseline's frames drawn in turn with them.
    pub baseline_samples: Vec<f64>,
    /// Median of `samples`; for the baseline, of every frame of it in the sweep.
    pub whole: Option<Estimate>,
    /// Median of each sample over the baseline's beside it; 1 for the baseline.
    pub ratio: Option<Estimate>,
    /// Median of each pass.
    pub passes: Vec<PassTime>,
    /// Frames behind `passes`.
    pub pass_frames: Vec<Vec<PassTime>>,
}

/// What was measured of one configuration.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Errors of the picture.
    pub image: ImageError,
    /// Errors of the layers, where there are layers to compare.
    pub layers: Option<LayerError>,
    /// What the GPU counted.
    pub counts: LayerCounts,
    /// Bytes of the frame's buffers.
    pub buffer_bytes: u64,
    /// Times; `None` where only errors were measured or time ran out.
    pub times: Option<Times>,
    /// Pictures for the report.
    #[serde(skip)]
    pub thumbnails: Option<Thumbnails>,
}

/// A configuration and what came of it.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was measured.
    pub configuration: Configuration,
    /// What came of it, or why nothing did.
    pub outcome: Result<Measured, String>,
}

impl Row {
    /// Its place in a diagram over `error`, if it was timed: time over that of the baseline's frames beside it, which a busy
    /// machine slows down as much.
    pub fn point(&self, error: impl Fn(&Measured) -> f64) -> Option<Point> {
        let measured = self.outcome.as_ref().ok()?;
        let ratio = measured.times.as_ref()?.ratio?;
        // Two runs of the baseline against each other tell of the machine alone.
        let is_baseline = self.configuration.name == AS_ASKED;
        let time = if is_baseline { [1.0; 3] } else { [ratio.low, ratio.median, ratio.high] };
        let label = self.configuration.short.clone();
        Some(Point { label, time, error: error(measured), sure: is_baseline || ratio.count >= ENOUGH })
    }
}

/// Where a sweep has got to.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Configurations done.
    pub done: usize,
    /// Configurations altogether.
    pub of: usize,
    /// The one that begins.
    pub name: &'a str,
    /// The one that has just been done.
    pub finished: Option<&'a Row>,
}

/// What came of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The rows, the baseline first.
    pub rows: Vec<Row>,
    /// Size of the pictures.
    pub size: [u32; 2],
    /// Size of those in which layers were compared.
    pub layer_size: [u32; 2],
    /// Settings of the reference.
    pub reference: Settings,
    /// Its picture.
    pub reference_thumbnail: Option<String>,
    /// Samples of the supersampled reference.
    pub reference_samples: u32,
    /// Every time of a whole frame of the baseline, milliseconds.
    pub baseline_samples: Vec<f64>,
    /// How long it took, seconds.
    pub seconds: f64,
}

/// A picture to compare with, and its layers.
struct Target {
    image: LinearImage,
    layers: Option<Layers>,
}

/// What a reference is: drawn when the first row needs it, or the reason why it could not be.
type Reference = Result<Target, String>;

struct Run<'a> {
    bench: &'a mut dyn Workbench,
    options: &'a Options,
    layer_size: [u32; 2],
    begin: Instant,
    baseline_samples: Vec<f64>,
    /// Single frames drawn so far, and how long they took.
    drawn: (u32, Duration),
    /// Somebody has called it off.
    stopped: bool,
}

/// The time of a configuration, since the sweep began.
#[derive(Clone, Copy)]
struct Share {
    /// When its fair share ends: no further frames are timed.
    fair: Duration,
    /// When it must end for the others' errors to be measured.
    last: Duration,
}

/// Single frames that a configuration needs for its errors and, besides, for times at least: warm-up, a pair with the
/// baseline, the passes.
fn frames_needed(configuration: &Configuration) -> [u32; 2] {
    let samples = configuration.settings.image.samples;
    // Several samples are their own warm-up.
    let warm_up = if samples > 1 { 0 } else { 1 };
    [samples, 2 * samples + warm_up + 1]
}

/// The size in which layers are compared.
fn layer_size([width, height]: [u32; 2]) -> [u32; 2] {
    let longest = width.max(height);
    if longest <= LAYER_SIDE {
        return [width, height];
    }
    [width, height].map(|side| ((u64::from(side) * u64::from(LAYER_SIDE) / u64::from(longest)) as u32).max(1))
}

/// Measures all `configurations`, of which the first is the baseline, against the settings of the two references. A bench whose
/// frames end in [`RenderError::Cancelled`] has been called off: what is not measured by then is not measured.
///
/// # Errors
/// [`RenderError`] if not even the reference can be drawn.
pub fn run(
    bench: &mut dyn Workbench,
    configurations: &[Configuration],
    references: [&Settings; 2],
    options: &Options,
    progress: &mut dyn FnMut(Step<'_>),
) -> Result<Sweep, RenderError> {
    let [exact_settings, supersampled_settings] = references;
    let mut run = Run {
        bench,
        options,
        layer_size: layer_size(options.size),
        begin: Instant::now(),
        baseline_samples: Vec::new(),
        drawn: (0, Duration::ZERO),
        stopped: false,
    };
    progress(Step { done: 0, of: configurations.len(), name: "reference", finished: None });
    let exact: Reference = Ok(run.target(exact_settings)?);
    let mut supersampled: Option<Reference> = None;
    let baseline = configurations.first().map(|c| c.settings.clone()).unwrap_or_default();
    if options.most_frames > 0 && !run.out_of_time() {
        // Compiles in the baseline's lane, so that the first configuration need not pay for it. What is refused here is refused
        // again as a row.
        let _ = run.draw(Lane::Baseline, &baseline, options.size, Wanted::default());
    }
    let mut rows: Vec<Row> = Vec::with_capacity(configurations.len());
    for (done, configuration) in configurations.iter().enumerate() {
        progress(Step { done, of: configurations.len(), name: &configuration.name, finished: rows.last() });
        let out_of_time = run.out_of_time();
        if configuration.judge == Judge::Supersampled && supersampled.is_none() && !out_of_time {
            supersampled = Some(run.target(supersampled_settings).map_err(sentence));
        }
        let share = run.share(&configurations[done..], supersampled.is_none().then_some(supersampled_settings));
        let reference = match configuration.judge {
            Judge::Exact => Some(&exact),
            Judge::Supersampled => supersampled.as_ref(),
        };
        let outcome = match reference {
            Some(Ok(target)) if !out_of_time => {
                let outcome = run.measure(configuration, &baseline, target, share);
                if run.stopped { Err(CALLED_OFF.to_owned()) } else { outcome }
            }
            _ if run.stopped => Err(CALLED_OFF.to_owned()),
            Some(Err(reason)) => Err(format!("its reference could not be drawn: {reason}")),
            _ => Err(format!("not measured: the time limit of {} s was reached", run.limit_seconds())),
        };
        rows.push(Row { configuration: configuration.clone(), outcome });
    }
    // The baseline was drawn in turn with everything: all its frames count.
    if let Some(Row { outcome: Ok(Measured { times: Some(times), .. }), .. }) = rows.first_mut() {
        times.whole = estimate(&run.baseline_samples, options.seed);
        // It is what times are relative to. Its frames against each other would tell of the machine alone.
        let count = run.baseline_samples.len();
        times.ratio = times.ratio.map(|_| Estimate { median: 1.0, low: 1.0, high: 1.0, count });
    }
    let reference_thumbnail = exact
        .ok()
        .filter(|_| options.thumbnail > 0)
        .map(|t| super::picture::picture(&t.image, options.background, options.thumbnail));
    let seconds = run.now().as_secs_f64();
    Ok(Sweep {
        rows,
        size: options.size,
        layer_size: run.layer_size,
        reference: exact_settings.clone(),
        reference_thumbnail,
        reference_samples: supersampled_settings.image.samples,
        baseline_samples: run.baseline_samples,
        seconds,
    })
}

/// Why there is nothing of what was left when somebody called it off.
const CALLED_OFF: &str = "not measured: called off";

fn sentence(error: impl std::error::Error) -> String {
    error.to_string()
}

impl Run<'_> {
    fn limit_seconds(&self) -> u64 {
        self.options.limit.map_or(0, |l| l.as_secs())
    }

    /// Time since the beginning, without what was spent waiting.
    fn now(&self) -> Duration {
        self.begin.elapsed().saturating_sub(self.bench.idle())
    }

    fn remaining(&self) -> Option<Duration> {
        self.options.limit.map(|limit| limit.saturating_sub(self.now()))
    }

    fn out_of_time(&self) -> bool {
        self.stopped || self.options.most_frames > 0 && self.remaining().is_some_and(|r| r.is_zero())
    }

    /// Time of a single frame as it was so far.
    fn frame_time(&self) -> Duration {
        self.drawn.1 / self.drawn.0.max(1)
    }

    /// Time for the first of the configurations that are left, by the frames that each needs. What the errors of the others
    /// need, and a reference that is still to be drawn, is kept for them.
    fn share(&self, left: &[Configuration], reference: Option<&Settings>) -> Option<Share> {
        let remaining = self.remaining()?;
        let (first, others) = left.split_first()?;
        let sum = |of: usize| others.iter().map(|c| frames_needed(c)[of]).sum::<u32>();
        let sampled = left.iter().any(|c| c.judge == Judge::Supersampled);
        let kept = sum(0) + reference.filter(|_| sampled).map_or(0, |s| s.image.samples);
        let own: u32 = frames_needed(first).iter().sum();
        let free = remaining.saturating_sub(self.frame_time() * kept);
        Some(Share { fair: self.now() + free * own / (own + sum(1)), last: self.now() + free })
    }

    /// Draws, and notes how long single frames take.
    fn draw(
        &mut self,
        lane: Lane,
        settings: &Settings,
        size: [u32; 2],
        wanted: Wanted,
    ) -> Result<(f64, Drawn), RenderError> {
        let begin = self.now();
        let drawn = self.bench.draw(lane, settings, size, wanted).inspect_err(|e| {
            self.stopped |= matches!(e, RenderError::Cancelled);
        })?;
        let took = self.now().saturating_sub(begin);
        self.drawn.0 += settings.image.samples.max(1);
        self.drawn.1 += took;
        Ok((took.as_secs_f64() * 1e3, drawn))
    }

    /// Draws the picture and the layers, in one frame where the sizes agree.
    fn target(&mut self, settings: &Settings) -> Result<Target, RenderError> {
        let (drawn, layers) = self.picture_and_layers(settings, self.options.size)?;
        Ok(Target { image: drawn.image, layers })
    }

    fn picture_and_layers(
        &mut self,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<(Drawn, Option<Layers>), RenderError> {
        let layers = Wanted { layers: true, pass_times: false };
        // Layers first, so that the buffers are left in the size of the picture.
        let apart = if size == self.layer_size || settings.image.samples > 1 {
            None
        } else {
            self.draw(Lane::Candidate, settings, self.layer_size, layers)?.1.layers
        };
        let (_, mut drawn) = self.draw(Lane::Candidate, settings, size, layers_if(size == self.layer_size))?;
        let layers = apart.or_else(|| drawn.layers.take());
        Ok((drawn, layers))
    }

    fn measure(
        &mut self,
        configuration: &Configuration,
        baseline: &Settings,
        target: &Target,
        share: Option<Share>,
    ) -> Result<Measured, String> {
        let settings = &configuration.settings;
        let size = self.options.size.map(|s| ((f64::from(s) * configuration.scale).round() as u32).max(1));
        let comparable = configuration.scale == 1.0 && target.layers.is_some();
        let (drawn, layers) = if comparable {
            self.picture_and_layers(settings, size).map_err(sentence)?
        } else {
            (self.draw(Lane::Candidate, settings, size, Wanted::default()).map_err(sentence)?.1, None)
        };
        let image = image_error::resized(&drawn.image, self.options.size);
        let map = image_error::compare(&image, &target.image, self.options.background).map_err(sentence)?;
        let layers = match (layers, &target.layers) {
            (Some(found), Some(expected)) => {
                let identity = if found.wide { Identity::Triangle } else { Identity::PartAndDepth };
                Some(layer_error(&found.store, &expected.store, identity).map_err(sentence)?)
            }
            _ => None,
        };
        let thumbnails = (self.options.thumbnail > 0)
            .then(|| Thumbnails::new(&image, &target.image, &map, self.options.background, self.options.thumbnail));
        let least = self.frame_time() * frames_needed(configuration)[1];
        let enough = share.is_none_or(|s| self.now() + least < s.last) || self.baseline_samples.is_empty();
        let times = if self.options.most_frames > 0 && enough {
            Some(self.time(settings, size, baseline, share.map(|s| s.fair)).map_err(sentence)?)
        } else {
            None
        };
        Ok(Measured {
            image: map.error,
            layers,
            counts: drawn.counts,
            buffer_bytes: drawn.buffer_bytes,
            times,
            thumbnails,
        })
    }

    /// Draws the configuration and the baseline in turn until `slice` ends, at least once each.
    fn time(
        &mut self,
        settings: &Settings,
        size: [u32; 2],
        baseline: &Settings,
        slice: Option<Duration>,
    ) -> Result<Times, RenderError> {
        let mut times = Times::default();
        // Warm-up: the shaders are compiled by now, caches and buffers are not all as they will be.
        if settings.image.samples == 1 {
            self.draw(Lane::Candidate, settings, size, Wanted::default())?;
        }
        if self.baseline_samples.is_empty() {
            self.draw(Lane::Baseline, baseline, self.options.size, Wanted::default())?;
        }
        // What the next round and the frames for the passes will take.
        let mut each = Duration::ZERO;
        let most = self.options.most_frames;
        while times.samples.len() < most && slice.is_none_or(|end| times.samples.is_empty() || self.now() + each <= end)
        {
            let round = self.now();
            times.samples.push(self.draw(Lane::Candidate, settings, size, Wanted::default())?.0);
            let beside = self.draw(Lane::Baseline, baseline, self.options.size, Wanted::default())?.0;
            times.baseline_samples.push(beside);
            each = self.now().saturating_sub(round) * 2;
        }
        self.baseline_samples.extend(&times.baseline_samples);
        let serial = Wanted { layers: false, pass_times: true };
        for _ in 0..times.samples.len().div_ceil(3).min(3) {
            times.pass_frames.push(self.draw(Lane::Candidate, settings, size, serial)?.1.passes);
        }
        times.passes = median_passes(&times.pass_frames);
        times.whole = estimate(&times.samples, self.options.seed);
        let ratios: Vec<f64> = times.samples.iter().zip(&times.baseline_samples).map(|(a, b)| a / b).collect();
        times.ratio = estimate(&ratios, self.options.seed);
        Ok(times)
    }
}

fn layers_if(layers: bool) -> Wanted {
    Wanted { layers, pass_times: false }
}

/// Median of each pass over the frames that ran it, in the order of the first.
pub fn median_passes(frames: &[Vec<PassTime>]) -> Vec<PassTime> {
    let mut passes: Vec<PassTime> = Vec::new();
    for time in frames.iter().flatten() {
        if passes.iter().all(|p| p.pass != time.pass) {
            let all: Vec<f64> =
                frames.iter().flatten().filter(|t| t.pass == time.pass).map(|t| t.milliseconds).collect();
            passes.extend(median(&all).map(|milliseconds| PassTime { pass: time.pass, milliseconds }));
        }
    }
    passes
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
