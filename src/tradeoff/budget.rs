//! Settings chosen by a promise: as accurate as possible within a time, or as fast as possible below an error.
//!
//! What is chosen was measured, on this machine, for this scene and view ([`Measurements`], which may be kept between runs).
//! Every candidate is judged by one reference, the exact picture with at least 16 samples and twice as many as any candidate, so that a missing layer and a jagged edge count
//! on one scale: mean FLIP. Two steps:
//!
//! 1. **Techniques.** The configurations of every axis but those of look, at the size asked for with one sample a pixel.
//!    Those that no other beats in both time and error go on, at most [`MOST_TECHNIQUES`] of them, and what was asked for.
//! 2. **Density.** Each of them with fewer pixels (enlarged to the size asked for) or more samples. Time grows and error falls
//!    with density: for a time, the densest that fits is searched outwards from where proportion puts it; for an error, the
//!    sparsest that suffices by halving.
//!
//! A time fits if the upper end of its 95 % interval does, and still does with as many frames again from later on. That is a promise about a machine that stays as busy as it was; the
//! error is deterministic. Where nothing keeps the promise, what comes closest is chosen, and said so.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::axis::{self, AS_ASKED, AxisError, Configuration, Judge};
use super::diagram::{Point, pareto_front};
use super::image_error::{self, ImageError};
use super::reference;
use super::statistics::{Estimate, estimate, median};
use super::workbench::{Lane, Wanted, Workbench};
use crate::math::LinearImage;
use crate::render::RenderError;
use crate::settings::{Effect, Settings};

/// Techniques that are tried at several densities.
pub const MOST_TECHNIQUES: usize = 4;
/// Timed frames behind a first impression.
const FRAMES: usize = 3;
/// Timed frames behind a promise: from six on an interval can hold 95 % (see `statistics`).
const PROMISED_FRAMES: usize = 7;

/// How densely the scene is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Density {
    /// Factor of the size.
    scale: f64,
    /// Samples a pixel.
    samples: u32,
}

impl Density {
    /// The size asked for, one sample.
    const PLAIN: Density = Density { scale: 1.0, samples: 1 };

    /// Pixels times samples, over the plain picture's.
    fn relative(self) -> f64 {
        self.scale * self.scale * f64::from(self.samples)
    }
}

/// Densities in ascending order; those that are asked for are among them.
fn densities(asked: u32, resize: bool) -> Vec<Density> {
    let sparse = [0.125, 0.1875, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875].map(|scale| Density { scale, samples: 1 });
    let sparse = sparse.into_iter().filter(|_| resize);
    let mut samples = vec![1, 2, 3, 4, 6, 8, asked];
    samples.sort_unstable();
    samples.dedup();
    let dense = samples.into_iter().map(|samples| Density { scale: 1.0, samples });
    sparse.chain(dense).collect()
}

/// What is promised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// A frame takes at most this long, milliseconds of wall time from settings to picture.
    Time(f64),
    /// Mean FLIP against the supersampled reference is at most this, 0 to 1.
    Error(f64),
}

/// How it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// What is behind the picture, linear light.
    pub background: Option<[f32; 3]>,
    /// Time for measuring: after it no further candidate is begun.
    pub limit: Duration,
    /// Whether pictures may be drawn smaller and enlarged.
    pub resize: bool,
}

/// What is known of one candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// What differs from what was asked for.
    pub name: String,
    /// Its settings.
    pub settings: Settings,
    /// Factor of the size of the picture.
    pub scale: f64,
    /// Errors against the supersampled reference.
    pub error: Option<ImageError>,
    /// Wall time of frames, milliseconds.
    pub frames: Vec<f64>,
    /// Why it could not be drawn.
    pub refused: Option<String>,
}

impl Entry {
    fn is_measured(&self) -> bool {
        self.error.is_some() && !self.frames.is_empty()
    }
}

/// What is known so far of a scene and view on a machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measurements {
    /// The candidates, in the order in which they were first drawn.
    pub entries: Vec<Entry>,
}

/// Whether a promise holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// By all that was measured.
    Kept,
    /// It seems so, from too few frames to tell.
    Unsure,
    /// Nothing that was measured keeps it.
    Broken,
}

/// What was chosen and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// What differs from what was asked for.
    pub name: String,
    /// Its settings.
    pub settings: Settings,
    /// Factor of the size of the picture.
    pub scale: f64,
    /// Mean FLIP.
    pub flip: f64,
    /// Samples a pixel of the picture that it is taken against.
    pub reference_samples: u32,
    /// Time of a frame, milliseconds.
    pub time: Estimate,
    /// First impression of the time of what was asked for, with one sample, milliseconds.
    pub asked: f64,
    /// Whether the promise holds.
    pub verdict: Verdict,
    /// Candidates that were compared.
    pub compared: usize,
    /// Whether the time for measuring ended before everything was compared.
    pub cut_short: bool,
    /// Why not the next better one.
    pub reason: String,
}

/// Why nothing could be chosen.
#[derive(Debug, thiserror::Error)]
pub enum BudgetError {
    /// Neither the reference nor anything else can be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A declaration is wrong.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Every candidate was refused.
    #[error("none of {candidates} configurations can be drawn; the first: {first}")]
    NothingDrawn {
        /// How many were tried.
        candidates: usize,
        /// Why the first was refused.
        first: String,
    },
}

struct Chooser<'a> {
    bench: &'a mut dyn Workbench,
    options: &'a Options,
    base: &'a Settings,
    reference_settings: Settings,
    reference: Option<LinearImage>,
    measured: &'a mut Measurements,
    /// The candidate whose buffers are ready.
    warm: Option<usize>,
    end: Instant,
    cut_short: bool,
    progress: &'a mut dyn FnMut(&str),
}

/// Chooses settings for `goal` around `base`, measuring what `measured` does not have yet and adding it there.
///
/// # Errors
/// [`BudgetError`] if nothing can be drawn.
pub fn choose(
    bench: &mut dyn Workbench,
    base: &Settings,
    goal: Goal,
    options: &Options,
    measured: &mut Measurements,
    progress: &mut dyn FnMut(&str),
) -> Result<Choice, BudgetError> {
    let mut chooser = Chooser::new(bench, base, options, measured, progress)?;
    for technique in chooser.techniques()? {
        match goal {
            Goal::Time(limit) => chooser.densest_within(&technique, limit)?,
            Goal::Error(limit) => chooser.sparsest_below(&technique, limit)?,
        }
    }
    loop {
        let (at, choice) = chooser.decide(goal)?;
        // What fits by a lucky moment is found out by frames of another moment.
        let frames = chooser.measured.entries[at].frames.len();
        let sure = choice.verdict == Verdict::Broken || matches!(goal, Goal::Error(_)) || frames >= 2 * PROMISED_FRAMES;
        if sure || !chooser.may_go_on() {
            return Ok(choice);
        }
        chooser.time(at, 2 * PROMISED_FRAMES, f64::INFINITY)?;
    }
}

/// How many settings a configuration changes, by its name.
fn changes(name: &str) -> usize {
    name.matches('=').count()
}

/// The configurations of step 1: one sample a pixel, every axis but look and sampling.
fn technique_configurations(base: &Settings) -> Result<Vec<Configuration>, AxisError> {
    let mut base = base.clone();
    base.image.samples = 1;
    let axes: Vec<_> =
        axis::all().into_iter().filter(|a| !matches!(a.effect, Effect::Look | Effect::Sampling)).collect();
    let mut all = axis::configurations(&base, &axes)?;
    all.retain(|c| c.judge == Judge::Exact);
    Ok(all)
}

/// A configuration at a density, named by what differs from what was asked for.
fn at_density(configuration: &Configuration, density: Density, asked: u32) -> Entry {
    let Density { scale, samples } = density;
    let mut settings = configuration.settings.clone();
    settings.image.samples = samples;
    let mut changes = Vec::new();
    if configuration.name != AS_ASKED {
        changes.push(configuration.name.clone());
    }
    if scale != 1.0 {
        changes.push(format!("resolution={scale}"));
    }
    if samples != asked {
        changes.push(format!("samples={samples}"));
    }
    let name = if changes.is_empty() { AS_ASKED.to_owned() } else { changes.join(", ") };
    Entry { name, settings, scale, error: None, frames: Vec::new(), refused: None }
}

impl<'a> Chooser<'a> {
    fn new(
        bench: &'a mut dyn Workbench,
        base: &'a Settings,
        options: &'a Options,
        measured: &'a mut Measurements,
        progress: &'a mut dyn FnMut(&str),
    ) -> Result<Chooser<'a>, BudgetError> {
        let mut reference_settings = reference::supersampled(base, &axis::all()).map_err(AxisError::from)?;
        let most = densities(base.image.samples, options.resize).iter().map(|d| d.samples).fold(1, u32::max);
        reference_settings.image.samples = reference_settings.image.samples.max(2 * most);
        Ok(Chooser {
            bench,
            options,
            base,
            reference_settings,
            reference: None,
            measured,
            warm: None,
            end: Instant::now() + options.limit,
            cut_short: false,
            progress,
        })
    }

    /// The place of a candidate in the measurements.
    fn enter(&mut self, entry: Entry) -> usize {
        let same = |e: &Entry| e.settings == entry.settings && e.scale == entry.scale;
        self.measured.entries.iter().position(same).unwrap_or_else(|| {
            self.measured.entries.push(entry);
            self.measured.entries.len() - 1
        })
    }

    fn drawn_size(&self, at: usize) -> [u32; 2] {
        let scale = self.measured.entries[at].scale;
        self.options.size.map(|s| ((f64::from(s) * scale).round() as u32).max(1))
    }

    /// Draws a candidate once; `None` where that is refused.
    fn draw(&mut self, at: usize) -> Result<Option<(f64, LinearImage)>, RenderError> {
        let size = self.drawn_size(at);
        let settings = self.measured.entries[at].settings.clone();
        (self.progress)(&self.measured.entries[at].name.clone());
        match self.bench.draw(Lane::Candidate, &settings, size, Wanted::default()) {
            Ok(drawn) => {
                self.warm = Some(at);
                Ok(Some((drawn.milliseconds, drawn.image)))
            }
            Err(RenderError::Cancelled) => Err(RenderError::Cancelled),
            Err(e) => {
                self.measured.entries[at].refused = Some(e.to_string());
                Ok(None)
            }
        }
    }

    /// Whether there is time for another candidate. The first is measured in any case.
    fn may_go_on(&mut self) -> bool {
        let time_is_left = Instant::now() < self.end + self.bench.idle();
        self.cut_short |= !time_is_left;
        time_is_left || !self.measured.entries.iter().any(Entry::is_measured)
    }

    /// The first impression of a candidate's time: what later frames say changes no earlier decision.
    fn impression(&self, at: usize) -> Option<Estimate> {
        let frames = &self.measured.entries[at].frames;
        estimate(&frames[..frames.len().min(FRAMES)], 1)
    }

    /// Mean FLIP of a candidate, drawn if it is not known.
    fn error(&mut self, at: usize) -> Result<Option<f64>, RenderError> {
        let entry = &self.measured.entries[at];
        if let Some(error) = entry.error {
            return Ok(Some(error.flip_mean));
        }
        if entry.refused.is_some() || !self.may_go_on() {
            return Ok(None);
        }
        let Some((_, image)) = self.draw(at)? else { return Ok(None) };
        let reference = match self.reference.take() {
            Some(reference) => reference,
            None => {
                (self.progress)("reference");
                self.warm = None;
                self.bench.draw(Lane::Baseline, &self.reference_settings, self.options.size, Wanted::default())?.image
            }
        };
        let image = image_error::resized(&image, self.options.size);
        let compared = image_error::compare(&image, &reference, self.options.background);
        self.reference = Some(reference);
        let entry = &mut self.measured.entries[at];
        match compared {
            Ok(map) => entry.error = Some(map.error),
            Err(sizes) => entry.refused = Some(sizes.to_string()),
        }
        Ok(entry.error.map(|e| e.flip_mean))
    }

    /// Time of a candidate from at least so many frames; fewer, if a frame takes longer than `hopeless` milliseconds.
    fn time(&mut self, at: usize, frames: usize, hopeless: f64) -> Result<Option<Estimate>, RenderError> {
        let entry = &self.measured.entries[at];
        let missing = frames.saturating_sub(entry.frames.len());
        let known_hopeless = median(&entry.frames).is_some_and(|m| m > hopeless);
        if entry.refused.is_none() && missing > 0 && !known_hopeless && self.may_go_on() {
            // The first frame may compile shaders and make buffers.
            if self.warm != Some(at) && self.draw(at)?.is_none() {
                return Ok(None);
            }
            for _ in 0..missing {
                let Some((took, _)) = self.draw(at)? else { return Ok(None) };
                self.measured.entries[at].frames.push(took);
                if took > hopeless {
                    break;
                }
            }
        }
        Ok(estimate(&self.measured.entries[at].frames, 1))
    }

    fn nothing_drawn(&self) -> BudgetError {
        let entries = &self.measured.entries;
        let first = entries.iter().find_map(|e| e.refused.clone()).unwrap_or_default();
        BudgetError::NothingDrawn { candidates: entries.len(), first }
    }

    /// Step 1: the techniques that no other beats, fastest first.
    fn techniques(&mut self) -> Result<Vec<Configuration>, BudgetError> {
        let all = technique_configurations(self.base)?;
        let mut points = Vec::new();
        for (i, configuration) in all.iter().enumerate() {
            let at = self.enter(at_density(configuration, Density::PLAIN, self.base.image.samples));
            let Some(error) = self.error(at)? else { continue };
            self.time(at, FRAMES, f64::INFINITY)?;
            let Some(time) = self.impression(at) else { continue };
            points
                .push((i, Point { label: String::new(), time: [time.low, time.median, time.high], error, sure: true }));
        }
        if points.is_empty() {
            return Err(self.nothing_drawn());
        }
        let on_front = pareto_front(&points.iter().map(|(_, p)| p.clone()).collect::<Vec<_>>());
        let mut front: Vec<(usize, Point)> =
            points.into_iter().zip(on_front).filter(|(_, f)| *f).map(|(p, _)| p).collect();
        front.sort_by(|a, b| a.1.time[1].total_cmp(&b.1.time[1]));
        // Of equals the first.
        front.dedup_by(|b, a| a.1.error == b.1.error);
        let last = front.len() - 1;
        let kept = MOST_TECHNIQUES.min(front.len());
        let mut spread: Vec<usize> =
            (0..kept).map(|i| front[if kept == 1 { 0 } else { i * last / (kept - 1) }].0).collect();
        // What was asked for is tried in any case: where others are no better, it is kept.
        if !spread.contains(&0) {
            spread.push(0);
        }
        Ok(spread.into_iter().map(|i| all[i].clone()).collect())
    }

    /// Step 2 for a time: measures around the densest that fits.
    fn densest_within(&mut self, technique: &Configuration, limit: f64) -> Result<(), RenderError> {
        let asked = self.base.image.samples;
        let all = densities(asked, self.options.resize);
        let plain = self.enter(at_density(technique, Density::PLAIN, asked));
        let Some(time) = self.impression(plain) else { return Ok(()) };
        let mut density = all.iter().rposition(|d| d.relative() * time.median <= limit).unwrap_or(0);
        let mut last_fitted = None;
        loop {
            let at = self.enter(at_density(technique, all[density], asked));
            let fits = self.time(at, PROMISED_FRAMES, 1.5 * limit)?.is_some_and(|t| t.high <= limit);
            self.error(at)?;
            match (fits, last_fitted) {
                // Up as long as it fits, then the last was the densest; down until one fits.
                (true, Some(false)) | (false, Some(true)) => break,
                (true, _) if density + 1 < all.len() => density += 1,
                (false, _) if density > 0 => density -= 1,
                _ => break,
            }
            last_fitted = Some(fits);
        }
        Ok(())
    }

    /// Step 2 for an error: measures around the sparsest that suffices.
    fn sparsest_below(&mut self, technique: &Configuration, limit: f64) -> Result<(), RenderError> {
        let mut tried = Vec::new();
        // All below `low` are too wrong, all from `high` on suffice, if error falls with density.
        let asked = self.base.image.samples;
        let all = densities(asked, self.options.resize);
        let (mut low, mut high) = (0, all.len());
        let mut next = all.iter().position(|d| *d == Density::PLAIN).unwrap_or(0);
        while low < high {
            let at = self.enter(at_density(technique, all[next], asked));
            let Some(error) = self.error(at)? else { break };
            tried.push(at);
            if error <= limit {
                high = next
            } else {
                low = next + 1
            }
            next = (low + high) / 2;
        }
        // Only what suffices need be timed; without any, what comes closest is chosen by its error.
        for &at in &tried {
            let suffices = self.measured.entries[at].error.is_some_and(|e| e.flip_mean <= limit);
            self.time(at, if suffices { PROMISED_FRAMES } else { 1 }, f64::INFINITY)?;
        }
        Ok(())
    }

    /// The best of all that is measured, and its place.
    fn decide(&self, goal: Goal) -> Result<(usize, Choice), BudgetError> {
        struct Candidate {
            at: usize,
            flip: f64,
            time: Estimate,
        }
        let found: Vec<Candidate> = self
            .measured
            .entries
            .iter()
            .enumerate()
            .filter(|(_, entry)| self.options.resize || entry.scale == 1.0)
            .filter_map(|(at, entry)| {
                Some(Candidate { at, flip: entry.error?.flip_mean, time: estimate(&entry.frames, 1)? })
            })
            .collect();
        let keeps = |c: &Candidate| match goal {
            Goal::Time(limit) => c.time.high <= limit,
            Goal::Error(limit) => c.flip <= limit,
        };
        // An interval of few frames promises nothing.
        let is_sure = |c: &Candidate| matches!(goal, Goal::Error(_)) || c.time.count >= PROMISED_FRAMES;
        let name = |c: &Candidate| self.measured.entries[c.at].name.as_str();
        let surely: Vec<&Candidate> = found.iter().filter(|c| keeps(c) && is_sure(c)).collect();
        let perhaps: Vec<&Candidate> = found.iter().filter(|c| keeps(c)).collect();
        let all: Vec<&Candidate> = found.iter().collect();
        let (verdict, among) = match (surely.is_empty(), perhaps.is_empty()) {
            (false, _) => (Verdict::Kept, surely),
            (true, false) => (Verdict::Unsure, perhaps),
            (true, true) => (Verdict::Broken, all),
        };
        let by_error = matches!(goal, Goal::Time(_)) == (verdict != Verdict::Broken);
        let best = |of: &dyn Fn(&Candidate) -> f64| among.iter().map(|c| of(c)).fold(f64::INFINITY, f64::min);
        // Of what cannot be told apart, the one that changes least of what was asked for.
        let (least_error, least_time) = (best(&|c| c.flip), best(&|c| c.time.median));
        let as_good = |c: &&&Candidate| {
            let within_noise = c.time.low <= least_time && c.time.median <= 1.1 * least_time;
            if by_error { c.flip <= 1.02 * least_error } else { within_noise }
        };
        let chosen = among.iter().filter(as_good).min_by(|a, b| {
            let key = |c: &Candidate| (changes(name(c)), if by_error { c.time.median } else { c.flip });
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let Some(chosen) = chosen.copied() else {
            return Err(self.nothing_drawn());
        };
        let others = found.iter().filter(|c| !keeps(c));
        let reason = match (goal, verdict) {
            (_, Verdict::Broken) if by_error => "the most accurate found; nothing suffices".to_owned(),
            (_, Verdict::Broken) => "the fastest found; nothing fits".to_owned(),
            (Goal::Time(_), _) => {
                let better = others.filter(|c| c.flip < 0.98 * chosen.flip);
                better.min_by(|a, b| a.time.median.total_cmp(&b.time.median)).map_or_else(
                    || "nothing noticeably more accurate was found".to_owned(),
                    |c| {
                        let Estimate { median, high, .. } = c.time;
                        format!("'{}', with FLIP {:.4}, takes {median:.1} ms (up to {high:.1})", name(c), c.flip)
                    },
                )
            }
            (Goal::Error(_), _) => {
                let faster = others.filter(|c| c.time.median < chosen.time.median);
                faster.min_by(|a, b| a.flip.total_cmp(&b.flip)).map_or_else(
                    || "nothing faster was found".to_owned(),
                    |c| format!("'{}', {:.1} ms, has FLIP {:.4}", name(c), c.time.median, c.flip),
                )
            }
        };
        let entry = &self.measured.entries[chosen.at];
        let choice = Choice {
            name: entry.name.clone(),
            settings: entry.settings.clone(),
            scale: entry.scale,
            flip: chosen.flip,
            reference_samples: self.reference_settings.image.samples,
            time: chosen.time,
            asked: self.impression(0).map_or(f64::NAN, |t| t.median),
            verdict,
            compared: found.len(),
            cut_short: self.cut_short,
            reason,
        };
        Ok((chosen.at, choice))
    }
}

/// What a choice is worth when it is measured again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Afresh {
    /// Mean FLIP.
    pub flip: f64,
    /// Time of a frame, milliseconds.
    pub time: Estimate,
}

/// Measures a choice again, with nothing known: the error against a reference drawn anew, the time over as many frames as the
/// promise had.
///
/// # Errors
/// [`BudgetError`] if it cannot be drawn.
pub fn afresh(
    bench: &mut dyn Workbench,
    base: &Settings,
    choice: &Choice,
    options: &Options,
) -> Result<Afresh, BudgetError> {
    let Choice { name, settings, scale, .. } = choice.clone();
    let entry = Entry { name, settings, scale, error: None, frames: Vec::new(), refused: None };
    let mut measured = Measurements { entries: vec![entry] };
    let mut silent = |_: &str| {};
    let mut chooser = Chooser::new(bench, base, options, &mut measured, &mut silent)?;
    let flip = chooser.error(0)?;
    let time = chooser.time(0, PROMISED_FRAMES, f64::INFINITY)?;
    match (flip, time) {
        (Some(flip), Some(time)) => Ok(Afresh { flip, time }),
        _ => Err(chooser.nothing_drawn()),
    }
}

#[cfg(test)]
#[path = "budget_tests.rs"]
mod tests;
