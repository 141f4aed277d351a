//! `pellucid bench`: what things cost, as ratios measured in one run, interleaved, medians.

mod flicker;
mod illustration;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, Subcommand};
use serde::Serialize;

use super::camera::CameraArgs;
use super::failure::{Exit, Failure};
use super::importing::ImportArgs;
use super::load::shown;
use super::options::size;
use super::output::Progress;
use super::render::Session;
use crate::export::image::parse_background;
use crate::gpu::{Gpu, GpuOptions, PassTime};
use crate::import::ImportOptions;
use crate::math::Camera;
use crate::plan::Pass;
use crate::scene::Scene;
use crate::session::configuration::Configuration;
use crate::settings::{OpacityModel, Settings};
use crate::tradeoff::budget::{self, Afresh, Choice, Goal, Measurements, Options, Verdict};
use crate::tradeoff::statistics::{Estimate, median};
use crate::tradeoff::sweep::median_passes;
use crate::tradeoff::workbench::RendererBench;

/// What is measured.
#[derive(Subcommand, Clone, Debug)]
pub enum BenchCommand {
    /// Neighbour search and curvature by buckets over brute force, on the paper's synthetic stack of quads
    Buckets(BucketsArgs),
    /// A whole frame of a model: unsorted blend, compacted lists and k-buffer, plain and stylized
    Frame(Box<FrameArgs>),
    /// The steps of the illustration buffer against the number of fragments, and frames with and without iterations
    Illustration(Box<illustration::IllustrationArgs>),
    /// What changes from frame to frame of an orbit beyond what moves, with one sample a pixel against many
    Flicker(Box<flicker::FlickerArgs>),
    /// How plainly opacity models show what lies in front: luminance steps at T-junctions
    Study(Box<super::study::StudyArgs>),
    /// Whether settings chosen by --budget and --max-error keep their promise when measured afresh
    Budgets(BudgetsArgs),
}

/// Options of `bench budgets`.
#[derive(Args, Clone, Debug)]
pub struct BudgetsArgs {
    /// Models, or builtin:NAME
    #[arg(default_values_t = ["builtin:gearbox", "builtin:engine", "builtin:quads"].map(str::to_owned))]
    pub files: Vec<String>,
    /// How they are read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "256x256")]
    pub size: [u32; 2],
    /// Mean FLIP to stay below
    #[arg(long, value_name = "FLIP", value_parser = super::budget::flip, default_value = "0.02")]
    pub max_error: f64,
    /// Time to stay within, over that of what the default settings take
    #[arg(long, value_name = "FACTOR", value_parser = super::camera::positive, default_value = "0.6")]
    pub factor: f64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `bench buckets`.
#[derive(Args, Clone, Debug)]
pub struct BucketsArgs {
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "512x512")]
    pub size: [u32; 2],
    /// Stacked full-screen quads
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), default_value_t = 32)]
    pub layers: u32,
    /// Interleaved runs of which the median is taken
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 7)]
    pub runs: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `bench frame`.
#[derive(Args, Clone, Debug)]
pub struct FrameArgs {
    /// A model, or builtin:NAME
    pub file: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// From where it is looked at
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1000x1000")]
    pub size: [u32; 2],
    /// Layers of the Bucketed k-Buffer
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), default_value_t = 16)]
    pub k: u32,
    /// Interleaved runs of which the median is taken
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 7)]
    pub runs: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs a measurement.
///
/// # Errors
/// [`Failure`] of the adapter, the file or the renderer.
pub fn run(command: &BenchCommand, configuration: &Configuration, progress: &Progress) -> Result<(), Failure> {
    let configured = &configuration.import_options();
    match command {
        BenchCommand::Buckets(args) => buckets(args, progress),
        BenchCommand::Frame(args) => frame(args, configured, progress),
        BenchCommand::Illustration(args) => illustration::run(args, configured, progress),
        BenchCommand::Flicker(args) => flicker::run(args, configured, progress),
        BenchCommand::Study(args) => super::study::run(args, configured, progress),
        BenchCommand::Budgets(args) => budgets(args, configured, progress),
    }
}

/// One line of a result.
#[derive(Serialize)]
struct Row {
    /// What was measured.
    name: String,
    /// Median of the whole frame, wall time.
    milliseconds: f64,
    /// That over the row that counts as 1.
    ratio: f64,
    /// Median of each pass.
    passes: Vec<PassTime>,
}

/// The median, or no number of none.
fn middle(values: &[f64]) -> f64 {
    median(values).unwrap_or(f64::NAN)
}

/// One thing that is measured, with a renderer of its own, so that no buffers are made anew between frames.
struct Candidate {
    name: String,
    session: Session,
    settings: Settings,
    unsorted: bool,
    whole: Vec<f64>,
    passes: Vec<Vec<PassTime>>,
    /// Of the last frame.
    fragments: u64,
    bands: usize,
}

impl Candidate {
    fn new(name: &str, scene: &Scene, settings: Settings, unsorted: bool) -> Result<Candidate, Failure> {
        let session = Session::open(scene)?;
        let (whole, passes) = (Vec::new(), Vec::new());
        Ok(Candidate { name: name.to_owned(), session, settings, unsorted, whole, passes, fragments: 0, bands: 0 })
    }

    /// Draws once; `counted` frames add to the result, `by_pass` frames give the times of the passes.
    fn run(&mut self, camera: &Camera, size: [u32; 2], counted: bool, by_pass: bool) -> Result<(), Failure> {
        if self.unsorted {
            if !by_pass {
                let time = self.session.time_unsorted(camera, &self.settings, size)?;
                if counted {
                    self.whole.push(time);
                }
            }
            return Ok(());
        }
        self.session.time_serially(by_pass);
        let report = self.session.render(camera, &self.settings, size)?.report;
        (self.fragments, self.bands) = (report.layers.rasterized, report.bands);
        match (counted, by_pass) {
            (true, false) => self.whole.push(report.milliseconds),
            (true, true) => self.passes.push(report.passes),
            (false, _) => {}
        }
        Ok(())
    }

    fn row(self, one: f64) -> Row {
        let milliseconds = middle(&self.whole);
        Row { ratio: milliseconds / one, milliseconds, passes: median_passes(&self.passes), name: self.name }
    }
}

/// Draws all candidates in turn: two warm-up rounds, then `runs` of whole frames, then `runs` pass by pass.
fn interleave(
    candidates: &mut [Candidate],
    camera: &Camera,
    size: [u32; 2],
    runs: u32,
    progress: &Progress,
) -> Result<(), Failure> {
    for round in 0..2 + 2 * runs {
        progress.stage(&format!("round {} of {}", round + 1, 2 + 2 * runs));
        for candidate in candidates.iter_mut() {
            candidate.run(camera, size, round >= 2, round >= 2 + runs)?;
        }
    }
    Ok(())
}

/// Curvature shading, unless something else is asked for: what the paper's figures measure.
fn settings_of(changes: &[(&str, String)]) -> Result<Settings, Failure> {
    let mut settings = Settings::default();
    settings.opacity.model = OpacityModel::Curvature;
    for (path, value) in changes {
        settings.set(path, value).map_err(|e| Failure::of(Exit::General, &e))?;
    }
    Ok(settings)
}

fn print_rows<T: Serialize>(rows: &T, text: &str, json: bool) -> Result<(), Failure> {
    let text = if json { super::output::json(rows)? } else { text.to_owned() };
    super::output::print(text.as_bytes())
}

/// The paper's Figure 9 question for any model: what does stylization cost, and what does being exact cost?
fn frame(args: &FrameArgs, configured: &ImportOptions, progress: &Progress) -> Result<(), Failure> {
    let options = args.import.options(None, configured.clone());
    let scene = super::load::scene(&args.file, &options, progress)?;
    let camera = args.camera.camera(&scene, f64::from(args.size[0]) / f64::from(args.size[1]))?;
    let k = args.k.to_string();
    let compacted = ("capture.kind", "compacted".to_owned());
    let bkb = [("capture.kind", "bucketed_k_buffer".to_owned()), ("capture.bucketed_k_buffer.k", k)];
    let plain = ("opacity.model", "constant".to_owned());
    let [kind, layers] = bkb;
    let mut candidates = vec![
        Candidate::new("unsorted blend", &scene, settings_of(std::slice::from_ref(&plain))?, true)?,
        Candidate::new("compacted, plain", &scene, settings_of(&[compacted.clone(), plain.clone()])?, false)?,
        Candidate::new("compacted, stylized", &scene, settings_of(&[compacted])?, false)?,
        Candidate::new("k-buffer, plain", &scene, settings_of(&[kind.clone(), layers.clone(), plain])?, false)?,
        Candidate::new("k-buffer, stylized", &scene, settings_of(&[kind, layers])?, false)?,
    ];
    interleave(&mut candidates, &camera, args.size, args.runs, progress)?;
    let one = middle(&candidates[0].whole);
    let rows: Vec<Row> = candidates.into_iter().map(|c| c.row(one)).collect();
    let mut text = format!(
        "{} at {}x{}, k = {}, medians of {} interleaved frames; passes: each run alone, wall time\n",
        shown(&args.file),
        args.size[0],
        args.size[1],
        args.k,
        args.runs
    );
    for row in &rows {
        text += &format!("{:<22}{:>9.1} ms  {:>6.2} x unsorted\n", row.name, row.milliseconds, row.ratio);
        for time in &row.passes {
            text += &format!("    {:<22}{:>9.2} ms\n", time.pass.name(), time.milliseconds);
        }
    }
    let over = |a: usize, b: usize| rows[a].milliseconds / rows[b].milliseconds;
    text += &format!("k-buffer: stylized over plain {:.2}; compacted: {:.2}\n", over(4, 3), over(2, 1));
    print_rows(&rows, &text, args.json)
}

/// One promise.
#[derive(Serialize)]
struct BudgetRow {
    file: String,
    promise: Goal,
    choice: Choice,
    afresh: Afresh,
    /// Whether what was measured afresh keeps the promise.
    kept: bool,
}

/// Chooses by time and by error, and measures what was chosen again on a device of its own.
fn budgets(args: &BudgetsArgs, configured: &ImportOptions, progress: &Progress) -> Result<(), Failure> {
    let import = args.import.options(None, configured.clone());
    let settings = Settings::default();
    let background = parse_background(&settings.image.background).map_err(|e| Failure::new(Exit::Usage, e))?;
    let options = Options { size: args.size, background, limit: Duration::from_secs(600), resize: true };
    let mut rows = Vec::new();
    for file in &args.files {
        let scene = super::load::scene(Path::new(file), &import, progress)?;
        let camera = CameraArgs::default().camera(&scene, f64::from(args.size[0]) / f64::from(args.size[1]))?;
        let bench = || -> Result<RendererBench, Failure> {
            let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
            RendererBench::new(&gpu, &scene, &camera).map_err(super::render::failed)
        };
        let mut measurements = Measurements::default();
        let mut chosen = |goal| {
            let mut say = |name: &str| progress.stage(&format!("{file}: {name}"));
            budget::choose(&mut bench()?, &settings, goal, &options, &mut measurements, &mut say)
                .map_err(super::budget::failed)
        };
        // What the default settings take is the first thing that a choice measures.
        let plain = chosen(Goal::Error(1.0))?.asked;
        for goal in [Goal::Time(args.factor * plain), Goal::Error(args.max_error)] {
            let choice = chosen(goal)?;
            progress.stage(&format!("{file}: afresh"));
            let afresh = budget::afresh(&mut bench()?, &settings, &choice, &options).map_err(super::budget::failed)?;
            let kept = match goal {
                Goal::Time(limit) => afresh.time.median <= limit,
                Goal::Error(limit) => afresh.flip <= limit,
            };
            rows.push(BudgetRow { file: file.clone(), promise: goal, choice, afresh, kept });
        }
    }
    let mut text = format!(
        "{}x{}, medians and 95 % intervals of 7 frames; afresh: chosen settings on a new device\n",
        args.size[0], args.size[1]
    );
    for BudgetRow { file, promise, choice, afresh, kept } in &rows {
        let promise = crate::tradeoff::kept::promise(*promise);
        let time = |t: &Estimate| format!("{:.1} ms ({:.1} to {:.1})", t.median, t.low, t.high);
        text += &format!(
            "{file}, {promise}: '{}'{}\n    then   {:<32} FLIP {:.4}\n    afresh {:<32} FLIP {:.4}  {}\n",
            choice.name,
            if choice.verdict == Verdict::Kept { "" } else { ", which does not keep it" },
            time(&choice.time),
            choice.flip,
            time(&afresh.time),
            afresh.flip,
            if *kept { "kept" } else { "BROKEN" }
        );
    }
    print_rows(&rows, &text, args.json)?;
    // Times are never judged: a machine may be busy. An error is what it is.
    let wrong = rows.iter().find(|r| !r.kept && matches!(r.promise, Goal::Error(_)));
    wrong.map_or(Ok(()), |r| Err(Failure::new(Exit::Differ, format!("{}: the error is not what was promised", r.file))))
}

/// One number of parts of the synthetic test.
#[derive(Serialize)]
struct BucketsRow {
    parts: u32,
    /// Neighbour search and curvature, milliseconds.
    buckets: f64,
    brute_force: f64,
    ratio: f64,
    /// Z reordering and bucket creation, which the search by buckets needs besides, milliseconds.
    making_buckets: f64,
}

/// The paper's Figure 10: stacked full-screen quads with random part ids.
fn buckets(args: &BucketsArgs, progress: &Progress) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for parts in [1, 2, 4, 6, 8, 16, 32].into_iter().filter(|&p| p <= args.layers) {
        progress.stage(&format!("{parts} parts"));
        let name = format!("builtin:quads?layers={}&parts={parts}", args.layers);
        let scene = super::load::scene(Path::new(&name), &ImportOptions::default(), progress)?;
        let front = CameraArgs { camera: Some("0".to_owned()), ..CameraArgs::default() };
        let camera = front.camera(&scene, 1.0)?;
        let with = |search: &str| {
            settings_of(&[
                ("capture.kind", "bucketed_k_buffer".to_owned()),
                ("capture.bucketed_k_buffer.k", args.layers.to_string()),
                ("features.neighbours", search.to_owned()),
            ])
        };
        let mut candidates = vec![
            Candidate::new("buckets", &scene, with("buckets")?, false)?,
            Candidate::new("brute force", &scene, with("brute_force")?, false)?,
        ];
        for round in 0..1 + args.runs {
            for candidate in &mut candidates {
                candidate.run(&camera, args.size, round >= 1, true)?;
            }
        }
        let time = |candidate: &Candidate, passes: &[Pass]| -> f64 {
            let medians = median_passes(&candidate.passes);
            medians.iter().filter(|t| passes.contains(&t.pass)).map(|t| t.milliseconds).fold(0.0, |a, b| a + b)
        };
        let features = [Pass::NeighbourCandidates, Pass::NeighbourLinks, Pass::Curvature];
        let (a, b) = (time(&candidates[0], &features), time(&candidates[1], &features));
        let making_buckets = time(&candidates[0], &[Pass::ZReordering, Pass::BucketCreation]);
        rows.push(BucketsRow { parts, buckets: a, brute_force: b, ratio: a / b, making_buckets });
    }
    let mut text = format!(
        "{} full-screen quads at {}x{}, neighbour search and curvature, medians of {} interleaved frames\n\
         parts    buckets  brute force   ratio   making buckets\n",
        args.layers, args.size[0], args.size[1], args.runs
    );
    for r in &rows {
        text += &format!(
            "{:>5}{:>8.1} ms{:>10.1} ms{:>8.3}{:>12.1} ms\n",
            r.parts, r.buckets, r.brute_force, r.ratio, r.making_buckets
        );
    }
    print_rows(&rows, &text, args.json)
}
