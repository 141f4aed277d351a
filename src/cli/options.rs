//! Commands and options. Each option's help is one sentence; settings have theirs in [`crate::settings`].

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::ENVIRONMENT;
use super::bench::BenchCommand;
use super::budget::BudgetArgs;
use super::camera::CameraArgs;
use super::compare::CompareArgs;
use super::hard_cases::HardCasesArgs;
use super::importing::ImportArgs;
use super::looks::LookArgs;
use super::picture::Format;
use super::section::SectionArgs;
use super::shells::{CompletionsArgs, ManArgs};
use super::tradeoff::TradeoffArgs;
use super::transfer::TransferArgs;
use super::view::PartArgs;
use crate::session::configuration::picture_size;

/// Shows the inside of 3D models without losing their shape.
#[derive(Parser, Clone, Debug)]
#[command(
    name = "pellucid",
    version,
    about,
    after_help = ENVIRONMENT,
    override_usage = "pellucid [FILE]...\n       pellucid <COMMAND>"
)]
pub struct Cli {
    /// What to do; without a command a window opens.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// A model or session to open in the window, or builtin:NAME; further ones are put under Open recent
    #[arg(value_name = "FILE", value_parser = model)]
    pub files: Vec<String>,
    /// The configuration.
    #[command(flatten)]
    pub configuration: ConfigurationArgs,
}

/// Which configuration files are read.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Configuration")]
pub struct ConfigurationArgs {
    /// Read this configuration file too; it counts more than those of the system and of the user
    #[arg(long, global = true, value_name = "FILE", conflicts_with = "no_config")]
    pub config: Option<PathBuf>,
    /// Read no configuration file
    #[arg(long, global = true)]
    pub no_config: bool,
}

/// What to do.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Render a model to a PNG or an EXR
    #[command(after_help = ENVIRONMENT)]
    Render(Box<RenderArgs>),
    /// Print what rendering a model would do: passes with reasons, buffers with bytes
    #[command(after_help = ENVIRONMENT)]
    Plan(Box<PlanArgs>),
    /// Print what is in a model: parts, hierarchy, materials, notices, and how long it took to read
    #[command(after_help = ENVIRONMENT)]
    Inspect(InspectArgs),
    /// Compare two pictures: largest and mean error, pixels that differ, FLIP, and a picture of the differences
    #[command(after_help = ENVIRONMENT)]
    Compare(CompareArgs),
    /// List graphics adapters and what they can do
    #[command(after_help = ENVIRONMENT)]
    Adapters {
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// List every setting: path, range, default, meaning
    Settings {
        /// Print a settings file with every default
        #[arg(long)]
        toml: bool,
    },
    /// Print what configuration files say, merged, and which file and line each value is from
    #[command(after_help = ENVIRONMENT)]
    Config,
    /// List the looks for --preset and --transfer
    Presets,
    /// Describe a transfer function, or write it in another format
    Transfer(TransferArgs),
    /// List what is read of each file format
    Formats {
        /// Print the table of `docs/formats.md`
        #[arg(long)]
        markdown: bool,
    },
    /// List the built-in scenes
    Scenes,
    /// Write the built-in scenes as GLB files
    Assets {
        /// The folder to write to
        folder: PathBuf,
    },
    /// Run every numerically hard case on this adapter against exact results, and print a table
    #[command(after_help = ENVIRONMENT)]
    HardCases(HardCasesArgs),
    /// Measure
    #[command(after_help = ENVIRONMENT)]
    Bench {
        /// What is measured.
        #[command(subcommand)]
        what: BenchCommand,
    },
    /// Measure what is wrong in a picture and what it would cost to have it right: a report of accuracy against time
    #[command(after_help = ENVIRONMENT)]
    Tradeoff(Box<TradeoffArgs>),
    /// Print what makes a shell complete commands and options
    Completions(CompletionsArgs),
    /// Print the manual page, or write those of all commands
    Man(ManArgs),
}

/// Options of `inspect`.
#[derive(Args, Clone, Debug)]
pub struct InspectArgs {
    /// A model, - for standard input, or builtin:NAME
    pub file: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What is looked at and how.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// A model, - for standard input, or builtin:NAME (`pellucid scenes` lists them); a session names its own
    #[arg(required_unless_present = "session")]
    pub file: Option<PathBuf>,
    /// A session that was saved: model, camera, settings and parts; options beside it count more
    #[arg(long, value_name = "FILE")]
    pub session: Option<PathBuf>,
    /// Picture size in pixels [default: 1000x1000]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// How the model is read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// The look.
    #[command(flatten)]
    pub look: LookArgs,
    /// Section planes.
    #[command(flatten)]
    pub sections: SectionArgs,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// The parts.
    #[command(flatten)]
    pub parts: PartArgs,
}

/// Options of `render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// What is looked at and how.
    #[command(flatten)]
    pub view: ViewArgs,
    /// The PNG or EXR to write; - is standard output
    #[arg(help_heading = "Output", short, long, value_name = "FILE", required_unless_present_any = ["reference", "stats", "save_session"])]
    pub output: Option<PathBuf>,
    /// What to write where the name does not say it: a PNG in sRGB over the background, or an EXR in linear light,
    /// premultiplied, unclamped, without the background
    #[arg(help_heading = "Output", long, value_enum)]
    pub format: Option<Format>,
    /// Bits of a channel: 8 or 16 of a PNG [default: 8], 16 or 32 (floats) of an EXR [default: 32]
    #[arg(help_heading = "Output", long, value_name = "8|16|32", value_parser = bits)]
    pub bits: Option<u8>,
    /// Write each layer as a part of its own into the EXR, at most the N nearest: colour times opacity (R, G, B), opacity (A),
    /// depth (Z), part (id), normal (N.X, N.Y, N.Z) and curvature (kappa), at each pixel's middle
    #[arg(help_heading = "Output", long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "4294967295", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["compare", "compare_opacity", "budget", "max_error"])]
    pub layers: Option<u32>,
    /// Render again whenever the model, a file that it names, the session, the settings or the transfer functions change
    #[arg(help_heading = "Output", long, conflicts_with_all = ["reference", "save_session", "budget", "max_error"])]
    pub watch: bool,
    /// Three pictures side by side: plain transparency, curvature shading on opaque surfaces, and the look asked for
    #[arg(help_heading = "Output", long)]
    pub compare: bool,
    /// Five pictures side by side, for five opacity models: opaque, constant, angle-based, normal variation, illustrative
    #[arg(help_heading = "Output", long, conflicts_with_all = ["compare", "reference"])]
    pub compare_opacity: bool,
    /// Write layer counts, milliseconds per pass and the plan as JSON; - is standard output
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Write what the options mean as a session for --session; - is standard output
    #[arg(help_heading = "Output", long, value_name = "FILE", conflicts_with_all = ["budget", "max_error"])]
    pub save_session: Option<PathBuf>,
    /// Compare with this PNG or EXR as `pellucid compare` does, and exit with 5 if the mean error is above the threshold
    #[arg(help_heading = "Output", long, value_name = "IMAGE")]
    pub reference: Option<PathBuf>,
    /// Largest mean error, in sRGB values from 0 to 1
    #[arg(help_heading = "Output", long, value_name = "T", value_parser = threshold, default_value = "0.002", requires = "reference")]
    pub threshold: f64,
    /// Settings chosen by a promise.
    #[command(flatten)]
    pub budget: BudgetArgs,
}

/// Options of `plan`.
#[derive(Args, Clone, Debug)]
pub struct PlanArgs {
    /// What is looked at and how.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A file for the window. A bare word that is no file was meant to be a command.
fn model(text: &str) -> Result<String, String> {
    let word = !text.contains(['.', '/', '\\', ':']);
    if word && !std::path::Path::new(text).exists() {
        return Err("there is no such command and no such file; `pellucid --help` lists the commands".to_owned());
    }
    Ok(text.to_owned())
}

/// Parses `WxH`: both whole and at least 1.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    picture_size(text)
}

fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        "32" => Ok(32),
        _ => Err("expected 8, 16 or 32".to_owned()),
    }
}

/// Parses a share from 0 to 1.
pub fn threshold(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|t| (0.0..=1.0).contains(t))
        .ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn parse(line: &str) -> Result<Cli, clap::Error> {
        Cli::try_parse_from(std::iter::once("pellucid").chain(line.split_whitespace()))
    }

    #[test]
    fn the_command_line_is_consistent_and_names_its_environment() {
        Cli::command().debug_assert();
        let mut command = Cli::command();
        command.build();
        for name in ["render", "plan", "inspect", "compare", "adapters", "bench", "tradeoff", "hard-cases", "config"] {
            let help = command.find_subcommand_mut(name).unwrap().render_long_help().to_string();
            for variable in ["WGPU_BACKEND", "WGPU_ADAPTER_NAME", "RUST_LOG", "NO_COLOR", "PELLUCID_CONFIG"] {
                assert!(help.contains(variable), "{name} --help does not name {variable}");
            }
        }
    }

    #[test]
    fn sizes_parse_strictly() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in
            ["0x0", "640", "640x", "x480", "640x0", "-1x5", "+1x5", "1e3x5", "640X480", "640x480x1", "4294967296x1", ""]
        {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn usage_errors_exit_with_2() {
        for line in [
            "render",
            "render a.glb",
            "render a.glb -o b.png --size 0x0",
            "render a.glb -o b.png --bits 12",
            "render a.glb -o b.png --capture telepathy",
            "render a.glb -o b.png --opacity glass",
            "render a.glb -o b.png --threshold 0.1",
            "render a.glb --reference b.png --threshold 2",
            "render a.glb -o b.png --set nonsense",
            "render a.glb -o b.png --k many",
            "render a.glb -o b.png --explode -1",
            "render -o b.png",
            "paint a.glb",
            "tradeoff a.glb",
            "tradeoff a.glb -o d --limit-seconds 0",
            "compare a.png",
            "compare a.png b.png --map flip",
            "compare a.png b.png --threshold 2",
            "compare a.png b.png --background none",
            "render a.glb -o a.exr --layers=0",
            "render a.glb -o a.exr --layers --compare",
            "render a.glb -o a.png --watch --reference b.png",
            "inspect a.glb --parts wheels",
            "inspect a.glb --limit bites=1",
            "completions tcsh",
            "plan a.glb --config a.toml --no-config",
        ] {
            let code = parse(line).map(|_| ()).map_err(|e| e.exit_code());
            assert_eq!(code, Err(2), "{line}");
        }
        for line in [
            "",
            "a.glb builtin:gearbox",
            "render a.glb -o b.png",
            "render a.glb --reference b.png --threshold 0.1",
            "render a.glb --stats -",
            "render builtin:gearbox -o - --k 8 --camera isometric --set a.b=c --set d=e --orthographic --bits 16",
            "render --session s.toml -o b.png --hide housing --ghost a/b --isolate gear --select gear --explode 0.5",
            "render a.glb --save-session s.toml",
            "plan --session s.toml",
            "plan a.glb --json --preset paper",
            "inspect a.glb",
            "hard-cases t01 --json",
            "bench buckets",
            "bench frame a.glb --k 16",
            "tradeoff a.glb -o d --axes k,key --limit-seconds 5 --k 8 --camera front",
            "tradeoff a.glb --check limits.toml",
            "transfer pellucid",
            "transfer maps.json --name Hot -o hot.toml",
            "compare a.png b.exr --difference d.png --map absolute --amplify 4 --json --threshold 0.1 --max-flip 0.2",
            "render a.glb -o a.exr --layers --bits 16",
            "render --layers=8 a.glb -o - --format exr",
            "render a.glb -o a.png --watch",
            "render - -o - --parts component --variant red --crease-angle 40 --limit bytes=512M --limit node_depth=7",
            "inspect - --parts file --json",
            "completions zsh",
            "man -o pages",
            "config --no-config",
            "--no-config config",
            "--config c.toml a.glb",
            "plan a.glb --config c.toml",
        ] {
            parse(line).unwrap_or_else(|e| panic!("{line}: {e}"));
        }
    }
}
