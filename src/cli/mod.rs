//! The command-line program: one of two faces of settings → plan → render.
//!
//! Standard output carries data only (pictures, JSON, lists). Everything else goes to standard error: notices of the
//! importer and a summary of the picture, one line each, progress if it is a terminal, logs. An output file appears
//! whole or not at all. A failure is one line, `pellucid: FILE: place: cause`, and an exit code ([`Exit`]).

mod bench;
mod budget;
mod camera;
#[cfg(test)]
mod copied_tests;
mod failure;
mod hard_cases;
mod inspect;
mod load;
mod looks;
mod options;
mod output;
mod render;
mod section;
mod study;
mod tradeoff;
mod transfer;
mod view;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;

use crate::app;
use crate::export::image::{Difference, LinearImage, compare, parse_background};
use crate::export::png::{read_png, write_png};
use crate::import::features;
use crate::render::FrameReport;
use crate::scene::builtin;
use crate::session::camera_in_scene;
use crate::settings::looks::opacity_models;
use crate::settings::{OpacityModel, Settings};
use crate::tradeoff::budget::{Choice, Goal, Verdict};
use crate::tradeoff::image_error::resized;
use crate::transfer::{OpacityFunction, TransferSource};
pub use failure::{Exit, Failure};
use options::{Cli, Command, PlanArgs, RenderArgs};
use output::Progress;
use render::{Session, summary};

/// Ends the help of every command that uses an adapter.
const ENVIRONMENT: &str = "\
Environment:
  WGPU_BACKEND       graphics interface: vulkan, metal, dx12 or gl
  WGPU_ADAPTER_NAME  part of an adapter's name, as `pellucid adapters` prints it
  RUST_LOG           what is logged to standard error, as in pellucid=debug
  NO_COLOR           if set, no colours on a terminal

Exit codes:
  0 done
  1 anything else that fails
  2 the command line is wrong
  3 an input file cannot be read
  4 no graphics adapter can be used
  5 the picture differs from the reference, or an error is above its limit
  6 the reference does not exist
  7 over the limits of the adapter";

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help asked for goes to standard output and is no failure.
            let _ = e.print();
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(Exit::Usage as u8));
        }
    };
    log_to_stderr();
    let done = match cli.command {
        Some(command) => run(command),
        None => app::run(&cli.files).map_err(|e| Failure::of(Exit::General, &e)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::complain(&failure.line());
            ExitCode::from(failure.exit as u8)
        }
    }
}

fn log_to_stderr() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| {
        tracing_subscriber::EnvFilter::new(
            "warn,wgpu_core=error,wgpu_hal=error,wgpu_hal::gles=off,naga=error,rfd=off,zbus=error",
        )
    });
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    // Fails only where a host program logs already.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(colours)
        .with_writer(std::io::stderr)
        .log_internal_errors(false)
        .try_init();
}

fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render(&args),
        Command::Plan(args) => plan(&args),
        Command::Inspect { file, json } => {
            let scene = load::scene(&file, &Progress::new())?;
            let report = inspect::Report::of(&scene);
            let text = if json { output::json(&report)? } else { report.text() };
            output::print(text.as_bytes())
        }
        Command::Adapters { json } => render::adapters(json),
        Command::Settings { toml } => output::print(settings(toml)?.as_bytes()),
        Command::Formats { markdown } => {
            output::print(if markdown { features::markdown() } else { features::text() }.as_bytes())
        }
        Command::Presets => output::print(presets().as_bytes()),
        Command::Transfer(args) => transfer::run(&args),
        Command::Scenes => output::print(scenes().as_bytes()),
        Command::Assets { folder } => load::write_assets(&folder),
        Command::HardCases(args) => hard_cases::run(&args),
        Command::Bench { what } => bench::run(&what, &Progress::new()),
        Command::Tradeoff(args) => tradeoff::run(&args),
    }
}

/// A picture of `--compare` or `--compare-opacity`, or the only one.
struct Take {
    name: &'static str,
    settings: Settings,
}

/// The paper's Figures 1 and 9: plain transparency, curvature shading on opaque surfaces, and the look asked for, by default
/// both together.
fn takes(settings: Settings, compare: bool, compare_opacity: bool) -> Result<Vec<Take>, Failure> {
    if compare_opacity {
        return Ok(opacity_models(&settings).into_iter().map(|(name, settings)| Take { name, settings }).collect());
    }
    if !compare {
        return Ok(vec![Take { name: "picture", settings }]);
    }
    let mut plain = settings.clone();
    plain.opacity.model = OpacityModel::Constant;
    let mut opaque = settings.clone();
    opaque.opacity.model = OpacityModel::Curvature;
    opaque.opacity.gain = 1.0;
    let mut function = opaque.opacity.transfer.resolve(None).map_err(|e| Failure::of(Exit::Input, &e))?;
    function.opacity = OpacityFunction::uniform(1.0);
    opaque.opacity.transfer = TransferSource::Inline(Box::new(function));
    Ok(vec![
        Take { name: "plain", settings: plain },
        Take { name: "opaque", settings: opaque },
        Take { name: "as asked", settings },
    ])
}

/// A picture in what `--stats` writes.
#[derive(Serialize)]
struct Picture {
    name: &'static str,
    #[serde(flatten)]
    report: FrameReport,
}

/// What `--stats` writes.
#[derive(Serialize)]
struct Stats {
    file: String,
    size: [u32; 2],
    /// How the passes were timed.
    timing: &'static str,
    pictures: Vec<Picture>,
    /// What `--budget` or `--max-error` chose.
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<Choice>,
    #[serde(skip_serializing_if = "Option::is_none")]
    difference: Option<Difference>,
}

fn render(args: &RenderArgs) -> Result<(), Failure> {
    let targets = [("--output", &args.output), ("--stats", &args.stats), ("--save-session", &args.save_session)];
    let written: Vec<(&str, &PathBuf)> = targets.iter().filter_map(|(o, path)| Some((*o, path.as_ref()?))).collect();
    for (i, (option, path)) in written.iter().enumerate() {
        for (other, second) in &written[i + 1..] {
            let fault = match std::path::absolute(path).ok() == std::path::absolute(second).ok() {
                true if path.as_path() == Path::new("-") => "cannot both go to standard output",
                true => "name the same file",
                false => continue,
            };
            return Err(Failure::new(Exit::Usage, format!("{option} and {other} {fault}")));
        }
        output::check(path)?;
    }
    if let Some(output) = args.output.as_ref().filter(|o| o.extension().is_some_and(|e| !e.eq_ignore_ascii_case("png")))
    {
        let message =
            format!("--output {}: pictures are written as PNG, so the name must end in .png", output.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let asked = args.view.asked()?;
    let background = parse_background(&asked.settings.image.background).map_err(|e| Failure::new(Exit::Usage, e))?;
    let mut takes = takes(asked.settings.clone(), args.compare, args.compare_opacity)?;
    let side_by_side = takes.len() > 1;
    let reference = args.reference.as_deref().map(read_reference).transpose()?;

    let progress = Progress::new();
    let (scene, seen) = asked.load(&progress)?;
    if let Some(path) = &args.save_session {
        output::write(path, view::session_text(&seen, &scene, path)?.as_bytes())?;
        if args.output.is_none() && args.stats.is_none() && args.reference.is_none() {
            return Ok(());
        }
    }
    let (file, size, camera) = (&seen.file, &seen.size, camera_in_scene(&seen.camera, &scene));
    progress.stage("starting the adapter");
    let chosen = match args.budget.goal() {
        Some(goal) => {
            let picture = (*size, background);
            let chosen = budget::chosen(
                &args.budget,
                goal,
                (&scene, &seen.arrangement),
                &camera,
                &takes[0].settings,
                picture,
                &progress,
            )?;
            progress.say(&format!("{file}: {}", chosen.sentence));
            takes[0].settings = chosen.choice.settings.clone();
            Some(chosen.choice)
        }
        None => None,
    };
    let scale = chosen.as_ref().map_or(1.0, |c| c.scale);
    let drawn_size = size.map(|s| ((f64::from(s) * scale).round() as u32).max(1));
    let mut session = Session::open_arranged(&scene, &seen.arrangement)?;
    for notice in &session.notices {
        progress.say(&format!("{file}: {notice}"));
    }
    let timing = if args.stats.is_some() { session.time_passes() } else { "not measured" };
    let mut images = Vec::new();
    let mut pictures = Vec::new();
    for Take { name, settings } in &takes {
        progress.stage(&format!("rendering {name}"));
        if chosen.is_some() {
            // What is promised is the time of a frame; the first one compiles shaders besides.
            session.render(&camera, settings, drawn_size)?;
        }
        let frame = session.render(&camera, settings, drawn_size)?;
        let subject = if side_by_side { format!("{file}: {name}") } else { file.clone() };
        progress.say(&summary(&subject, drawn_size, &frame.report));
        images.push(resized(&frame.image, *size));
        pictures.push(Picture { name, report: frame.report });
    }
    let image =
        if side_by_side { LinearImage::side_by_side(&images, (size[0] / 100).max(1)) } else { images.remove(0) };

    progress.stage("writing");
    let png = write_png(&image, background, args.bits).map_err(|e| Failure::of(Exit::General, &e))?;
    if let Some(output) = &args.output {
        output::write(output, &png)?;
    }
    let mut stats = Stats { file: file.clone(), size: *size, timing, pictures, choice: chosen, difference: None };
    let verdict = match (&args.reference, reference) {
        (Some(path), Some(reference)) => {
            let (difference, verdict) = judge(path, &png, &reference, args.threshold)?;
            stats.difference = difference;
            verdict
        }
        _ => Ok(()),
    };
    if let Some(target) = &args.stats {
        output::write(target, output::json(&stats)?.as_bytes())?;
    }
    match (args.budget.goal(), &stats.choice) {
        // Times are never judged: a machine may be busy. An error is what it is.
        (Some(Goal::Error(limit)), Some(choice)) if choice.verdict == Verdict::Broken && verdict.is_ok() => {
            Err(Failure::new(Exit::Differ, format!("{file}: no configuration was found below FLIP {limit}")))
        }
        _ => verdict,
    }
}

fn read_reference(path: &Path) -> Result<LinearImage, Failure> {
    let png = std::fs::read(path).map_err(|e| {
        let missing = e.kind() == std::io::ErrorKind::NotFound;
        Failure::about(if missing { Exit::NoReference } else { Exit::Input }, path.display(), &e)
    })?;
    read_png(&png).map_err(|e| Failure::about(Exit::Input, path.display(), &e))
}

type Judgement = (Option<Difference>, Result<(), Failure>);

/// Compares the picture as written with the reference. Pictures of different sizes have no difference to report.
fn judge(path: &Path, png: &[u8], reference: &LinearImage, threshold: f64) -> Result<Judgement, Failure> {
    let differs = |what: String| Failure::new(Exit::Differ, format!("{}: {what}", path.display()));
    let written = read_png(png).map_err(|e| Failure::of(Exit::General, &e))?;
    let difference = match compare(&written, reference) {
        Ok(difference) => difference,
        Err(sizes) => return Ok((None, Err(differs(sizes)))),
    };
    let text = format!(
        "mean difference {:.5}, threshold {threshold}; largest {:.3}, {:.2} % of pixels visibly different",
        difference.mean,
        difference.max,
        difference.visible * 100.0
    );
    let verdict = if difference.mean > threshold { Err(differs(text)) } else { Ok(()) };
    Ok((Some(difference), verdict))
}

fn plan(args: &PlanArgs) -> Result<(), Failure> {
    let progress = Progress::new();
    let (scene, seen) = args.view.asked()?.load(&progress)?;
    let camera = camera_in_scene(&seen.camera, &scene);
    let plan = Session::open_arranged(&scene, &seen.arrangement)?.plan(&camera, &seen.settings, seen.size)?;
    drop(progress);
    let text = if args.json { output::json(&plan)? } else { format!("{}\n", plan.to_string().trim_end()) };
    output::print(text.as_bytes())
}

fn settings(as_toml: bool) -> Result<String, Failure> {
    if as_toml {
        return Settings::default().to_toml().map_err(|e| Failure::of(Exit::General, &e));
    }
    let all = Settings::declarations();
    Ok(all.iter().map(|d| format!("{} = {}\n    {}\n    {}\n", d.path, d.default, d.help, d.range)).collect())
}

fn presets() -> String {
    crate::settings::looks::presets().map(|(name, what)| format!("{name:14} {what}\n")).collect()
}

fn scenes() -> String {
    let all: String = builtin::names().iter().map(|b| format!("builtin:{:18}{}\n", b.name, b.description)).collect();
    all + "\nParameters go behind the name, as in builtin:quads?layers=8&parts=3\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comparing_gives_the_papers_three_pictures() {
        let mut settings = Settings::default();
        settings.opacity.transfer = TransferSource::Named("murray-6a-7b".to_owned());
        settings.opacity.gain = 0.5;
        let three = takes(settings.clone(), true, false).unwrap();
        assert_eq!(three.iter().map(|t| t.name).collect::<Vec<_>>(), ["plain", "opaque", "as asked"]);
        assert_eq!(three[0].settings.opacity.model, OpacityModel::Constant);
        let opaque = &three[1].settings.opacity;
        let function = opaque.transfer.resolve(None).unwrap();
        assert_eq!((function.opacity.constant(), opaque.gain), (Some(1.0), 1.0));
        assert!(function.color.depends_on_curvature(), "shaded by curvature");
        assert_eq!(three[2].settings, settings);
        assert_eq!(takes(settings.clone(), false, false).unwrap()[0].settings, settings);
    }

    #[test]
    fn a_reference_that_is_missing_broken_or_different_has_its_own_code() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.png");
        let exit = |result: Result<LinearImage, Failure>| result.map(|_| ()).map_err(|f| f.exit);
        assert_eq!(exit(read_reference(&path)), Err(Exit::NoReference));
        std::fs::write(&path, b"no").unwrap();
        assert_eq!(exit(read_reference(&path)), Err(Exit::Input));
        let image = LinearImage { width: 1, height: 1, pixels: vec![[0.5, 0.5, 0.5, 1.0]] };
        let png = write_png(&image, Some([1.0; 3]), 8).unwrap();
        std::fs::write(&path, &png).unwrap();
        let reference = read_reference(&path).unwrap();
        let (difference, verdict) = judge(&path, &png, &reference, 0.0).unwrap();
        assert_eq!((difference.map(|d| d.max), verdict), (Some(0.0), Ok(())));
        let other = write_png(&LinearImage { pixels: vec![[0.0, 0.0, 0.0, 1.0]], ..image }, Some([1.0; 3]), 8).unwrap();
        let (_, verdict) = judge(&path, &other, &reference, 0.1).unwrap();
        assert_eq!(verdict.unwrap_err().exit, Exit::Differ);
        let larger = write_png(&LinearImage::clear(2, 1), None, 8).unwrap();
        let (difference, verdict) = judge(&path, &larger, &reference, 1.0).unwrap();
        assert_eq!((difference, verdict.map_err(|f| f.exit)), (None, Err(Exit::Differ)));
    }

    #[test]
    fn lists_are_complete() {
        assert_eq!(Settings::from_toml(&settings(true).unwrap()).unwrap(), Settings::default());
        let text = settings(false).unwrap();
        assert!(Settings::declarations().iter().all(|d| text.contains(&format!("{} = {}", d.path, d.default))));
        let names: Vec<String> =
            presets().lines().filter_map(|l| l.split_whitespace().next().map(str::to_owned)).collect();
        assert!(["plain", "opaque", "paper", "pellucid", "x-ray"].iter().all(|n| names.contains(&(*n).to_owned())));
        let missing = run(Command::Inspect { file: "builtin:no-such-scene".to_owned(), json: false }).unwrap_err();
        assert_eq!(missing.exit, Exit::Usage);
    }
}
