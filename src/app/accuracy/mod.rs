//! What is wrong in the picture, by how much, and what it would cost to have it right: the state behind the accuracy panel.
//!
//! The same functions as `pellucid tradeoff` and `render --budget` ([`crate::tradeoff`]), beside the picture. Two threads with
//! devices of their own: [`reference`] draws the reference of the exact picture on screen and compares the two; [`measuring`]
//! runs sweeps and budgets, between frames, and rests while the window has anything to draw. What they find belongs to a
//! model, a view and a look; of any other it is shown as such or not at all.

pub mod cases;
pub mod measuring;
pub mod overlay;
pub mod reference;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::LazyLock;

use super::document::Seen;
use super::viewport::Shown;
use super::workspace::{Ask, Gravity, Workspace};
use crate::settings::Settings;
use crate::tradeoff::axis::{self, Judge};
use crate::tradeoff::budget::Goal;
use crate::tradeoff::diagram::Point;
use crate::tradeoff::image_error::ImageError;
use crate::tradeoff::kept::Chosen;
use crate::tradeoff::statistics::median;
use crate::tradeoff::sweep::{Measured, Row};
use cases::CaseShown;
use overlay::Overlay;

/// Longest side of the pictures of a sweep that is offered, pixels.
pub const SIDES: std::ops::RangeInclusive<u32> = 16..=4096;
/// Times for measuring that are offered, seconds.
pub const SECONDS: std::ops::RangeInclusive<u64> = 1..=86_400;

/// How far the exact picture of an order is from its reference.
pub struct Referenced {
    /// Of which order.
    pub number: u64,
    /// The figures.
    pub error: ImageError,
    /// The reference.
    pub reference: Arc<Shown>,
    /// The difference in false colours.
    pub difference: Arc<Shown>,
    /// What drawing the reference took, milliseconds.
    pub milliseconds: f64,
}

/// What a diagram shows against time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shows {
    /// Mean error to the exact picture.
    #[default]
    Mean,
    /// Mean FLIP to the exact picture.
    Flip,
    /// Layers lost and merged.
    Layers,
    /// Mean error to the picture with many samples, of what changes the sampling.
    Sampling,
}

impl Shows {
    /// All of them.
    pub const ALL: [Shows; 4] = [Shows::Mean, Shows::Flip, Shows::Layers, Shows::Sampling];

    /// What the vertical axis is called.
    pub fn name(self) -> &'static str {
        match self {
            Shows::Mean => "Mean error, steps of 1/255",
            Shows::Flip => "FLIP, mean",
            Shows::Layers => "Layers missing, %",
            Shows::Sampling => "Mean error to many samples",
        }
    }

    fn judge(self) -> Judge {
        if self == Shows::Sampling { Judge::Supersampled } else { Judge::Exact }
    }

    /// The figure of a row; `None` where there is none of this kind.
    pub fn of(self, measured: &Measured) -> Option<f64> {
        match self {
            Shows::Mean | Shows::Sampling => Some(measured.image.mean),
            Shows::Flip => Some(measured.image.flip_mean),
            Shows::Layers => {
                let layers = measured.layers.as_ref()?;
                Some(100.0 * (layers.lost + layers.merged) as f64 / layers.layers.max(1) as f64)
            }
        }
    }
}

/// The paths of the settings that axes vary.
static PATHS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let mut paths: Vec<&str> = axis::all().iter().filter_map(crate::settings::Axis::path).collect();
    paths.sort_unstable();
    paths.dedup();
    paths
});

/// Settings that axes vary, by path.
pub type Technique = BTreeMap<&'static str, toml::Value>;

/// What of some settings the axes vary.
pub fn technique(settings: &Settings) -> Technique {
    let Ok(tree) = toml::Value::try_from(settings) else {
        return Technique::new();
    };
    let at = |path: &str| path.split('.').try_fold(&tree, |at, key| at.get(key)).cloned();
    PATHS.iter().filter_map(|path| Some((*path, at(path)?))).collect()
}

/// Settings with another technique.
///
/// # Errors
/// A sentence if a value is none that its setting has.
fn with_technique(settings: &Settings, technique: &Technique) -> Result<Settings, String> {
    let present = self::technique(settings);
    let mut settings = settings.clone();
    for (path, value) in technique.iter().filter(|(path, value)| present.get(*path) != Some(value)) {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        settings.set(path, &text).map_err(|e| e.to_string())?;
    }
    Ok(settings)
}

/// A row of a sweep and its technique.
pub struct Entry {
    /// What was measured.
    pub row: Row,
    /// What of its settings the axes vary.
    pub technique: Technique,
}

impl From<Row> for Entry {
    fn from(row: Row) -> Entry {
        Entry { technique: technique(&row.configuration.settings), row }
    }
}

/// What a sweep has measured so far.
pub struct Swept {
    /// Of which model.
    pub scene_number: u64,
    /// Of what: as asked for.
    pub seen: Seen,
    /// Size of the pictures.
    pub size: [u32; 2],
    /// The rows, what was asked for first.
    pub entries: Vec<Entry>,
}

/// A point of the diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Plotted {
    /// Which entry.
    pub entry: usize,
    /// Its place; times in milliseconds.
    pub point: Point,
    /// Whether no other is both faster and closer.
    pub on_front: bool,
    /// Whether the present settings are these.
    pub is_present: bool,
}

impl Swept {
    /// Whether this model, view and look are those that were measured; the technique may be another one.
    pub fn is_of(&self, scene_number: u64, seen: &Seen) -> bool {
        let look = |settings: &Settings| with_technique(settings, &technique(&self.seen.settings)).ok();
        self.scene_number == scene_number
            && (&self.seen.camera, &self.seen.arrangement) == (&seen.camera, &seen.arrangement)
            && look(&seen.settings).is_some_and(|s| s == self.seen.settings)
    }

    /// The points of a diagram, with the present settings marked if `seen` is what was measured.
    pub fn points(&self, shows: Shows, present: Option<&Settings>) -> Vec<Plotted> {
        let present = present.map(technique);
        let times = |e: &Entry| e.row.outcome.as_ref().ok().and_then(|m| m.times.clone());
        let samples: Vec<f64> = self.entries.iter().filter_map(times).flat_map(|t| t.baseline_samples).collect();
        let asked = median(&samples).unwrap_or(1.0);
        let mut found: Vec<Plotted> = self
            .entries
            .iter()
            .enumerate()
            .filter(|(_, e)| e.row.configuration.judge == shows.judge())
            .filter_map(|(entry, e)| {
                let error = shows.of(e.row.outcome.as_ref().ok()?)?;
                let mut point = e.row.point(|_| error)?;
                point.time = point.time.map(|t| t * asked);
                let same = present.as_ref() == Some(&e.technique) && e.row.configuration.scale == 1.0;
                Some(Plotted { entry, point, on_front: false, is_present: same })
            })
            .collect();
        let points: Vec<Point> = found.iter().map(|p| p.point.clone()).collect();
        for (plotted, on_front) in found.iter_mut().zip(crate::tradeoff::diagram::pareto_front(&points)) {
            plotted.on_front = on_front;
        }
        found
    }
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// All configurations.
    Sweep,
    /// Settings that keep a promise.
    Budget(Goal),
}

/// A measurement under way, for show.
#[derive(Clone, Debug, PartialEq)]
pub struct Underway {
    /// What is measured.
    pub wanted: Wanted,
    /// Configurations done.
    pub done: usize,
    /// Of how many, where that is known; otherwise 0.
    pub of: usize,
    /// What is drawn.
    pub name: String,
    /// Whether it waits for the window.
    pub rests: bool,
}

/// What a budget has chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// In words, as on the command line.
    pub sentence: String,
    /// What was chosen.
    pub technique: Technique,
    /// For what it was chosen.
    pub scene_number: u64,
    /// As it was seen then.
    pub seen: Seen,
}

/// What is to be measured, and how much of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// Longest side of the pictures of a sweep, pixels.
    pub side: u32,
    /// Time for measuring, seconds.
    pub seconds: u64,
    /// What the diagram shows.
    pub shows: Shows,
    /// A budget of time, milliseconds.
    pub milliseconds: f64,
    /// A budget of error, mean FLIP.
    pub flip: f64,
}

impl Default for Form {
    fn default() -> Form {
        Form { side: 256, seconds: 120, shows: Shows::default(), milliseconds: 100.0, flip: 0.02 }
    }
}

/// What the accuracy panel knows.
#[derive(Default)]
pub struct Accuracy {
    /// What lies over the picture.
    pub overlay: Overlay,
    /// The reference is wanted once, without anything over the picture.
    pub once: bool,
    /// The order whose reference is being drawn.
    pub drawing: Option<u64>,
    /// The last reference that was found.
    pub found: Option<Referenced>,
    /// Why there is no reference of an order.
    pub fault: Option<(u64, String)>,
    /// Where the divider stands, and for which overlay.
    pub divider: Option<(Overlay, f32)>,
    /// What the user has set.
    pub form: Form,
    /// What is being measured.
    pub underway: Option<Underway>,
    /// The last sweep.
    pub swept: Option<Swept>,
    /// The last choice.
    pub told: Option<Told>,
    /// The hard case that is open.
    pub case: Option<CaseShown>,
}

impl Workspace {
    /// Whether the reference of the picture on screen is wanted and not there yet.
    pub fn wants_reference(&self) -> bool {
        let accuracy = &self.accuracy;
        let known = accuracy.found.as_ref().is_some_and(|f| f.number == self.order)
            || accuracy.fault.as_ref().is_some_and(|(number, _)| *number == self.order);
        (accuracy.overlay != Overlay::Off || accuracy.once) && self.is_exact() && !known
    }

    /// What was found of the very picture on screen.
    pub fn referenced(&self) -> Option<&Referenced> {
        self.accuracy.found.as_ref().filter(|f| f.number == self.order && self.is_exact())
    }

    /// Whether the window has nothing to draw, so that others may.
    pub fn is_at_rest(&self) -> bool {
        self.loading.is_none()
            && self.exporting.is_none()
            && (self.document.is_none() || self.is_exact() || self.refusal.is_some())
            && self.accuracy.drawing.is_none()
            && !self.wants_reference()
    }

    /// Takes what the thread of the reference has found.
    pub fn take_referenced(&mut self, outcome: Result<Referenced, (u64, String)>) {
        let number = outcome.as_ref().map_or_else(|fault| fault.0, |found| found.number);
        self.accuracy.drawing.take_if(|drawing| *drawing == number);
        if number != self.order {
            // Of a picture that is gone, perhaps with its model.
            return;
        }
        self.accuracy.once = false;
        match outcome {
            Ok(found) => (self.accuracy.found, self.accuracy.fault) = (Some(found), None),
            Err(fault) => self.accuracy.fault = Some(fault),
        }
    }

    /// Asks for a measurement, unless there is one.
    pub fn measure(&mut self, wanted: Wanted) {
        if self.accuracy.underway.is_none() && self.document.is_some() {
            self.asks.push(Ask::Measure(wanted));
        }
    }

    /// Makes a technique the present one, as one step of undo. Everything else stays as it is.
    pub fn apply_technique(&mut self, technique: &Technique) {
        let Some(document) = &mut self.document else {
            return;
        };
        match with_technique(&document.seen.settings, technique) {
            Ok(settings) => {
                document.settle();
                document.seen.settings = settings;
                document.settle();
            }
            Err(reason) => self.say(Gravity::Error, reason),
        }
    }

    /// Applies what a row of the sweep measured.
    pub fn apply_row(&mut self, entry: usize) {
        let Some(entry) = self.accuracy.swept.as_ref().and_then(|s| s.entries.get(entry)) else {
            return;
        };
        if entry.row.configuration.scale == 1.0 {
            let technique = entry.technique.clone();
            self.apply_technique(&technique);
        } else {
            let text = "The window draws as many pixels as it shows: a smaller resolution is for the command line.";
            self.say(Gravity::Note, text);
        }
    }

    /// Takes what a budget has chosen, and applies it if what it was chosen for is still what is seen.
    pub fn take_chosen(&mut self, chosen: Chosen, scene_number: u64, seen: Seen) {
        if let Some(reason) = chosen.not_kept {
            self.say(Gravity::Notice, format!("Measurements are not kept: {reason}"));
        }
        let technique = technique(&chosen.choice.settings);
        let same = self.document.as_ref().is_some_and(|d| d.seen == seen) && scene_number == self.scene_number;
        if same {
            self.apply_technique(&technique);
        }
        self.accuracy.told = Some(Told { sentence: chosen.sentence, technique, scene_number, seen });
    }

    /// Forgets what belongs to a model that is gone. What was measured is kept, as of another model.
    pub fn forget_accuracy(&mut self) {
        let accuracy = &mut self.accuracy;
        (accuracy.found, accuracy.fault, accuracy.drawing) = (None, None, None);
        (accuracy.once, accuracy.case) = (false, None);
        if accuracy.underway.is_some() {
            self.asks.push(Ask::StopMeasuring);
        }
    }
}
