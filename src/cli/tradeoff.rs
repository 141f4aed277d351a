//! `pellucid tradeoff`: what is wrong in a picture, by how much, and what it would cost to have it right.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::camera::CameraArgs;
use super::failure::{Exit, Failure};
use super::importing::ImportArgs;
use super::load::shown;
use super::looks::LookArgs;
use super::options::size;
use super::output::{self, Progress};
use crate::export::image::parse_background;
use crate::gpu::{Gpu, GpuOptions};
use crate::scene::Scene;
use crate::session::configuration::Configuration;
use crate::tradeoff::limits::{Judgement, Limits};
use crate::tradeoff::report::{self, Subject};
use crate::tradeoff::sweep::{self, Options, Sweep};
use crate::tradeoff::workbench::RendererBench;
use crate::tradeoff::{axis, reference};

/// Options of `tradeoff`.
#[derive(Args, Clone, Debug)]
pub struct TradeoffArgs {
    /// A model, or builtin:NAME (`pellucid scenes` lists them)
    pub file: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// The folder for sweep.csv, sweep.json and index.html; made if it does not exist
    #[arg(short, long, value_name = "DIR", required_unless_present = "check")]
    pub output: Option<PathBuf>,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "256x256")]
    pub size: [u32; 2],
    /// Axes to vary, all if none are named: capture, k, key, normals, …
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    pub axes: Vec<String>,
    /// Time for everything, seconds; what it does not reach is a row that says so. Without effect with --check
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=86_400), default_value_t = 120)]
    pub limit_seconds: u64,
    /// Exit with 5 if an error is above its limit in this file; times are never judged, and without --output not taken
    #[arg(long, value_name = "TOML")]
    pub check: Option<PathBuf>,
    /// The look.
    #[command(flatten)]
    pub look: LookArgs,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,
}

/// Runs the sweep, writes the report, judges the errors.
///
/// # Errors
/// [`Exit::Differ`] if an error is above its limit; [`Failure`] of the command line, the files, the adapter.
pub fn run(args: &TradeoffArgs, configuration: &Configuration) -> Result<(), Failure> {
    let settings = args.look.settings_over(configuration.picture_settings(args.look.preset.is_none()))?;
    let background = parse_background(&settings.image.background).map_err(|e| Failure::new(Exit::Usage, e))?;
    let axes = axis::named(&args.axes).map_err(|e| Failure::new(Exit::Usage, format!("--axes: {e}")))?;
    let limits = args.check.as_deref().map(read_limits).transpose()?;
    if let Some(folder) = &args.output {
        prepare(folder)?;
    }
    let progress = Progress::new();
    let file = shown(&args.file);
    let options = args.import.options(None, configuration.import_options());
    let scene = super::load::scene(&args.file, &options, &progress)?;
    let options = Options {
        size: args.size,
        background,
        // What is checked is measured whole, however long it takes.
        limit: limits.is_none().then(|| Duration::from_secs(args.limit_seconds)),
        most_frames: match (&args.output, &limits) {
            (None, _) => 0,
            (Some(_), None) => Options::default().most_frames,
            (Some(_), Some(_)) => FRAMES_WITHOUT_LIMIT,
        },
        thumbnail: if args.output.is_some() { Options::default().thumbnail } else { 0 },
        ..Options::default()
    };
    let (sweep, subject) = measure(args, &scene, &settings, &axes, (&options, limits.as_ref()), &progress)?;
    if let Some(folder) = &args.output {
        progress.stage("writing");
        for file in report::files(&sweep, &subject) {
            output::write(&folder.join(file.name), file.content.as_bytes())?;
        }
    }
    let failed = sweep.rows.iter().filter(|r| r.outcome.is_err()).count();
    let untimed = sweep.rows.iter().filter(|r| r.outcome.as_ref().is_ok_and(|m| m.times.is_none())).count();
    let untimed = if untimed > 0 && options.most_frames > 0 {
        format!(", {untimed} without times (a longer --limit-seconds gives more)")
    } else {
        String::new()
    };
    let covered = sweep.rows.iter().any(|r| r.outcome.as_ref().is_ok_and(|m| m.counts.rasterized > 0));
    if !covered {
        progress.say(&format!("{file}: nothing is in view"));
    }
    let place = args.output.as_ref().map_or_else(String::new, |f| format!("; {}", f.join("index.html").display()));
    progress.say(&format!(
        "{file}: {} configurations in {:.0} s, {failed} without figures{untimed}{place}",
        sweep.rows.len(),
        sweep.seconds
    ));
    match (limits, &args.check) {
        (Some(_), Some(path)) if !covered => {
            Err(Failure::new(Exit::Input, format!("{}: nothing is in view: there is nothing to check", path.display())))
        }
        (Some(limits), Some(path)) => judge(&limits, path, &sweep, &progress),
        _ => Ok(()),
    }
}

/// Makes the folder and finds out before the work whether files can be written there.
fn prepare(folder: &Path) -> Result<(), Failure> {
    if folder == Path::new("-") {
        return Err(Failure::new(Exit::Usage, "--output names a folder; a report is three files"));
    }
    let about = |e: std::io::Error| Failure::about(Exit::General, folder.display(), &e);
    std::fs::create_dir_all(folder).map_err(about)?;
    for name in report::NAMES {
        output::check(&folder.join(name))?;
    }
    let trial = folder.join(format!(".{}.part", std::process::id()));
    std::fs::write(&trial, b"").and_then(|()| std::fs::remove_file(&trial)).map_err(about)
}

/// Frames of which times are taken where no time limit ends them.
const FRAMES_WITHOUT_LIMIT: usize = 3;

fn measure(
    args: &TradeoffArgs,
    scene: &Scene,
    settings: &crate::settings::Settings,
    axes: &[crate::settings::Axis],
    (options, limits): (&Options, Option<&Limits>),
    progress: &Progress,
) -> Result<(Sweep, Subject), Failure> {
    let general = |e: &(dyn std::error::Error + 'static)| Failure::of(Exit::General, e);
    let configurations = axis::configurations(settings, axes).map_err(|e| general(&e))?;
    if let (Some(limits), Some(path)) = (limits, &args.check) {
        limits.check_names(&configurations).map_err(|e| Failure::about(Exit::Input, path.display(), &e))?;
    }
    let [exact, supersampled] = reference::both(settings).map_err(|e| general(&e))?;
    let camera = args.camera.camera(scene, f64::from(args.size[0]) / f64::from(args.size[1]))?;
    progress.stage("starting the adapter");
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
    let mut bench = RendererBench::new(&gpu, scene, &camera).map_err(super::render::failed)?;
    let sweep = sweep::run(&mut bench, &configurations, [&exact, &supersampled], options, &mut |step| {
        progress.count(step.done, step.of, step.name);
    })
    .map_err(super::render::failed)?;
    let subject = Subject {
        model: shown(&args.file),
        camera: args.camera.describe(),
        adapter: Some(gpu.facts().clone()),
        limit_seconds: options.limit.map(|l| l.as_secs()),
    };
    Ok((sweep, subject))
}

fn read_limits(path: &Path) -> Result<Limits, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| Failure::about(Exit::Input, path.display(), &e))?;
    Limits::from_toml(&text).map_err(|e| Failure::about(Exit::Input, path.display(), &e))
}

fn judge(limits: &Limits, path: &Path, sweep: &Sweep, progress: &Progress) -> Result<(), Failure> {
    let Judgement { checked, violations } =
        limits.judge(sweep).map_err(|e| Failure::about(Exit::Input, path.display(), &e))?;
    progress.say(&format!("{}: {checked} figures checked, {} over their limits", path.display(), violations.len()));
    let Some((last, others)) = violations.split_last() else { return Ok(()) };
    others.iter().for_each(|v| progress.say(&format!("{}: {v}", path.display())));
    Err(Failure::new(Exit::Differ, format!("{}: {last}", path.display())))
}
