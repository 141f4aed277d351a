//! `render --budget` and `--max-error`: settings chosen from what was measured on this machine, for this scene and view.
//! [`kept`] keeps the measurements and has the words.

use std::time::Duration;

use clap::Args;

use super::failure::{Exit, Failure};
use super::output::Progress;
use crate::gpu::{Gpu, GpuOptions};
use crate::math::Camera;
use crate::scene::{Arrangement, Scene};
use crate::settings::Settings;
use crate::tradeoff::budget::{BudgetError, Goal, Options};
use crate::tradeoff::kept::{self, Chosen, Subject};
use crate::tradeoff::workbench::RendererBench;

/// Options of `render` that choose settings.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Promise")]
pub struct BudgetArgs {
    /// As accurate as possible within this time a frame, as in 33ms or 0.5s: capture, resolution and samples are chosen
    #[arg(long, value_name = "TIME", value_parser = milliseconds, conflicts_with_all = ["max_error", "compare", "compare_opacity", "k", "capture", "samples"])]
    pub budget: Option<f64>,
    /// As fast as possible below this error: mean FLIP, 0 to 1, against the exact picture with 16 samples a pixel or twice
    /// as many as are asked for
    #[arg(long, value_name = "FLIP", value_parser = flip, conflicts_with_all = ["compare", "compare_opacity", "k", "capture", "samples"])]
    pub max_error: Option<f64>,
    /// Time for measuring what is not known yet, seconds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=86_400), default_value_t = 300)]
    pub measure_seconds: u64,
    /// Measure again what is known
    #[arg(long)]
    pub remeasure: bool,
}

impl BudgetArgs {
    /// What is promised, if anything is.
    pub fn goal(&self) -> Option<Goal> {
        self.budget.map(Goal::Time).or(self.max_error.map(Goal::Error))
    }
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let (number, unit) = match (text.strip_suffix("ms"), text.strip_suffix('s')) {
        (Some(number), _) => (number, 1.0),
        (None, Some(number)) => (number, 1000.0),
        (None, None) => return Err("expected a time with its unit, as in 33ms or 0.5s".to_owned()),
    };
    let time = number.trim().parse::<f64>().ok().map(|n| n * unit).filter(|t| t.is_finite() && *t > 0.0);
    time.ok_or_else(|| "expected a time above 0, as in 33ms or 0.5s".to_owned())
}

/// Parses a mean FLIP.
pub fn flip(text: &str) -> Result<f64, String> {
    let error = text.parse::<f64>().ok().filter(|e| (0.0..=1.0).contains(e));
    error.ok_or_else(|| "expected a mean FLIP from 0 to 1, as in 0.01".to_owned())
}

/// Chooses settings for `goal`, measures what is not known yet and keeps it.
///
/// # Errors
/// [`Failure`] of the adapter or the renderer, if nothing can be drawn.
pub fn chosen(
    args: &BudgetArgs,
    goal: Goal,
    (scene, arrangement): (&Scene, &Arrangement),
    camera: &Camera,
    settings: &Settings,
    (size, background): ([u32; 2], Option<[f32; 3]>),
    progress: &Progress,
) -> Result<Chosen, Failure> {
    let options = Options { size, background, limit: Duration::from_secs(args.measure_seconds), resize: true };
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
    let mut bench = RendererBench::new(&gpu, scene, camera).map_err(super::render::failed)?;
    bench.arrange(scene, arrangement).map_err(super::render::failed)?;
    let subject = Subject { scene, arrangement, camera, settings, facts: gpu.facts() };
    let chosen =
        kept::chosen(&mut bench, subject, goal, &options, (args.remeasure, "--measure-seconds"), &mut |count, name| {
            progress.stage(&format!("measuring, frame {count}: {name}"));
        })
        .map_err(failed)?;
    if let Some(reason) = &chosen.not_kept {
        progress.say(&format!("measurements are not kept: {reason}"));
    }
    Ok(chosen)
}

/// The failure that an error of a choice is.
pub fn failed(error: BudgetError) -> Failure {
    match error {
        BudgetError::Render(e) => super::render::failed(e),
        e @ BudgetError::NothingDrawn { .. } => Failure::of(Exit::Limits, &e),
        e => Failure::of(Exit::General, &e),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_errors_parse_strictly() {
        assert_eq!(
            (milliseconds("33ms"), milliseconds("0.5s"), milliseconds("2 s")),
            (Ok(33.0), Ok(500.0), Ok(2000.0))
        );
        for bad in ["33", "ms", "-1ms", "0ms", "NaNms", "infs", "1m", ""] {
            assert!(milliseconds(bad).is_err(), "{bad}");
        }
        assert_eq!((flip("0.01"), flip("1")), (Ok(0.01), Ok(1.0)));
        assert!(["-0.1", "1.1", "NaN", "1%"].iter().all(|bad| flip(bad).is_err()));
    }
}
