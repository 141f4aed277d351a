//! The command-line program: one of two faces of settings → plan → render.
//!
//! Standard output carries data only (pictures, JSON, lists). Everything else goes to standard error: notices of the
//! importer and a summary of the picture, one line each, progress if it is a terminal, logs. An output file appears
//! whole or not at all. A failure is one line, `pellucid: FILE: place: cause`, and an exit code ([`Exit`]).

mod bench;
mod budget;
mod camera;
mod compare;
#[cfg(all(test, feature = "window"))]
mod copied_tests;
mod failure;
mod hard_cases;
mod importing;
mod inspect;
mod load;
mod looks;
mod options;
mod output;
mod picture;
mod render;
mod section;
mod shells;
mod study;
mod tradeoff;
mod transfer;
mod view;
mod watch;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

#[cfg(feature = "window")]
use crate::app;
use crate::import::features;
use crate::scene::builtin;
use crate::session::camera_in_scene;
use crate::session::configuration::{Configuration, Places};
use crate::settings::Settings;
pub use failure::{Exit, Failure};
use options::{Cli, Command, ConfigurationArgs, InspectArgs, PlanArgs};
use output::Progress;
use render::Session;

/// Ends the help of every command that uses an adapter.
const ENVIRONMENT: &str = "\
Environment:
  WGPU_BACKEND       graphics interface: vulkan, metal, dx12 or gl
  WGPU_ADAPTER_NAME  part of an adapter's name, as `pellucid adapters` prints it
  PELLUCID_CONFIG    a configuration file, unless --config names one
  PELLUCID_SHADERS   the folder of shaders that the window watches and takes over
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
    let parsed = Cli::try_parse().and_then(|cli| match (&cli.command, cli.files.first()) {
        (Some(_), Some(file)) => {
            let text = format!("'{file}' stands before the command, which takes its files behind it");
            Err(Cli::command().error(clap::error::ErrorKind::ArgumentConflict, text))
        }
        _ => Ok(cli),
    });
    let cli = match parsed {
        Ok(cli) => cli,
        Err(e) => {
            // Help asked for goes to standard output and is no failure.
            let _ = e.print();
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(Exit::Usage as u8));
        }
    };
    log_to_stderr();
    let done = configuration(&cli.configuration).and_then(|configuration| match cli.command {
        Some(command) => run(command, &configuration),
        #[cfg(feature = "window")]
        None => app::run(&cli.files, configuration).map_err(|e| Failure::of(Exit::General, &e)),
        #[cfg(not(feature = "window"))]
        None => Err(Failure::new(Exit::General, "this pellucid was built without a window; see --help for commands")),
    });
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

/// Reads the configuration files that count.
fn configuration(args: &ConfigurationArgs) -> Result<Configuration, Failure> {
    if args.no_config {
        return Ok(Configuration::default());
    }
    let variable = |name: &str| std::env::var_os(name);
    let named = args.config.clone().or_else(|| variable("PELLUCID_CONFIG").filter(|v| !v.is_empty()).map(Into::into));
    Configuration::read(&Places::of(variable, named.as_deref())).map_err(|e| Failure::of(Exit::Input, &e))
}

fn run(command: Command, configuration: &Configuration) -> Result<(), Failure> {
    match command {
        Command::Render(args) => picture::run(&args, configuration),
        Command::Plan(args) => plan(&args, configuration),
        Command::Inspect(args) => inspect(&args, configuration),
        Command::Compare(args) => compare::run(&args),
        Command::Adapters { json } => render::adapters(json),
        Command::Settings { toml } => output::print(settings(toml)?.as_bytes()),
        Command::Formats { markdown } => {
            output::print(if markdown { features::markdown() } else { features::text() }.as_bytes())
        }
        Command::Config => output::print(configuration.listing().as_bytes()),
        Command::Presets => output::print(presets().as_bytes()),
        Command::Transfer(args) => transfer::run(&args),
        Command::Scenes => output::print(scenes().as_bytes()),
        Command::Assets { folder } => load::write_assets(&folder),
        Command::HardCases(args) => hard_cases::run(&args),
        Command::Bench { what } => bench::run(&what, configuration, &Progress::new()),
        Command::Tradeoff(args) => tradeoff::run(&args, configuration),
        Command::Completions(args) => shells::completions(&args),
        Command::Man(args) => shells::man(&args),
    }
}

fn inspect(args: &InspectArgs, configuration: &Configuration) -> Result<(), Failure> {
    let options = args.import.options(None, configuration.import_options());
    let (scene, times) = load::timed(&args.file, &options, &Progress::new())?;
    let report = inspect::Report::of(&scene, times);
    let text = if args.json { output::json(&report)? } else { report.text() };
    output::print(text.as_bytes())
}

fn plan(args: &PlanArgs, configuration: &Configuration) -> Result<(), Failure> {
    let progress = Progress::new();
    let (scene, seen) = args.view.asked(configuration)?.load(&mut Vec::new(), &progress)?;
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
    fn lists_are_complete() {
        assert_eq!(Settings::from_toml(&settings(true).unwrap()).unwrap(), Settings::default());
        let text = settings(false).unwrap();
        assert!(Settings::declarations().iter().all(|d| text.contains(&format!("{} = {}", d.path, d.default))));
        let names: Vec<String> =
            presets().lines().filter_map(|l| l.split_whitespace().next().map(str::to_owned)).collect();
        assert!(["plain", "opaque", "paper", "pellucid", "x-ray"].iter().all(|n| names.contains(&(*n).to_owned())));
        let missing = inspect(
            &InspectArgs { file: "builtin:no-such-scene".into(), import: Default::default(), json: false },
            &Configuration::default(),
        )
        .unwrap_err();
        assert_eq!(missing.exit, Exit::Usage);
    }
}
