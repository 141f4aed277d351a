//! `pellucid bench flicker`: what changes from frame to frame of an orbit beyond what moves, with one sample a pixel against many.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::{Session, print_rows};
use crate::cli::camera::{CameraArgs, positive};
use crate::cli::failure::{Exit, Failure};
use crate::cli::importing::ImportArgs;
use crate::cli::looks::LookArgs;
use crate::cli::options::size;
use crate::cli::output::Progress;
use crate::export::image::parse_background;
use crate::export::png::{png_of_rgba8, write_png};
use crate::import::ImportOptions;
use crate::settings::{OpacityModel, Settings};
use crate::tradeoff::difference;
use crate::tradeoff::flicker::{Changes, OrbitOptions, Pair};

/// Options of `bench flicker`.
#[derive(Args, Clone, Debug)]
pub struct FlickerArgs {
    /// Models, or builtin:NAME
    #[arg(default_values_t = ["builtin:gearbox", "builtin:engine"].map(str::to_owned))]
    pub files: Vec<String>,
    /// How they are read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// From where the orbit begins
    #[command(flatten)]
    pub camera: CameraArgs,
    /// The look; illustrative, unless it says otherwise
    #[command(flatten)]
    pub look: LookArgs,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "256x256")]
    pub size: [u32; 2],
    /// Frames of the orbit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600), default_value_t = 36)]
    pub frames: u32,
    /// Degrees from frame to frame
    #[arg(long, value_name = "DEGREES", value_parser = positive, default_value = "1")]
    pub step: f64,
    /// Samples a pixel of the orbit to compare with
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=64), default_value_t = 16)]
    pub against: u32,
    /// Write the two frames between which it flickers most, and what changes
    #[arg(long, value_name = "FOLDER")]
    pub save: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// One model.
#[derive(Serialize)]
struct Row {
    file: String,
    /// Share of the pixels with a surface that the next frame shows too, percent.
    compared_percent: f64,
    /// With one sample a pixel.
    single: Changes,
    /// With many.
    many: Changes,
    /// Mean change with one over that with many.
    ratio: f64,
    /// First of the two frames between which it flickers most.
    worst_frame: Option<u32>,
}

/// Measures.
///
/// # Errors
/// [`Failure`] of the adapter, the files or the renderer.
pub fn run(args: &FlickerArgs, configured: &ImportOptions, progress: &Progress) -> Result<(), Failure> {
    let mut usual = Settings::default();
    usual.opacity.model = OpacityModel::Illustrative;
    let settings = args.look.settings_over(usual)?;
    let background = parse_background(&settings.image.background).map_err(|e| Failure::new(Exit::Usage, e))?;
    let options =
        OrbitOptions { size: args.size, frames: args.frames, degrees: args.step, samples: args.against, background };
    let import = args.import.options(None, configured.clone());
    let mut rows = Vec::new();
    for file in &args.files {
        let scene = crate::cli::load::scene(Path::new(file), &import, progress)?;
        let camera = args.camera.camera(&scene, f64::from(args.size[0]) / f64::from(args.size[1]))?;
        let mut session = Session::open(&scene)?;
        let mut say = |frame| progress.stage(&format!("{file}: frame {} of {}", frame + 1, args.frames));
        let orbit = session.flicker(&camera, &settings, &options, &mut say)?;
        if let (Some(folder), Some(pair)) = (&args.save, &orbit.worst) {
            save(folder, file, pair, background)?;
        }
        rows.push(Row {
            file: file.clone(),
            compared_percent: 100.0 * orbit.single.pixels as f64 / orbit.surfaces.max(1) as f64,
            ratio: orbit.ratio(),
            worst_frame: orbit.worst.as_ref().map(|w| w.frame),
            single: orbit.single,
            many: orbit.many,
        });
    }
    let mut text = format!(
        "{} at {}x{}, {} frames, {}° each; mean change between frames after re-projection, steps of 1/255; share of pixels that \
         change by 8 steps or more\n{:<32}{:>10}{:>12}{:>9}{:>12}{:>9}{:>8}\n",
        settings.opacity.model.name(),
        args.size[0],
        args.size[1],
        args.frames,
        args.step,
        "model",
        "compared",
        "1 sample",
        "strong",
        format!("{} samples", args.against),
        "strong",
        "ratio"
    );
    for row in &rows {
        text += &format!(
            "{:<32}{:>8.1} %{:>12.3}{:>7.2} %{:>12.3}{:>7.2} %{:>8.2}\n",
            row.file,
            row.compared_percent,
            255.0 * row.single.mean,
            row.single.strong_percent,
            255.0 * row.many.mean,
            row.many.strong_percent,
            row.ratio
        );
    }
    print_rows(&rows, &text, args.json)
}

/// Writes the four pictures of a pair and what changes in them.
fn save(folder: &Path, file: &str, pair: &Pair, background: Option<[f32; 3]>) -> Result<(), Failure> {
    let failed = |e: &dyn std::error::Error| Failure::new(Exit::General, e.to_string());
    std::fs::create_dir_all(folder).map_err(|e| Failure::new(Exit::General, format!("{}: {e}", folder.display())))?;
    let stem = Path::new(file).file_stem().map_or_else(|| file.to_owned(), |s| s.to_string_lossy().into_owned());
    let stem = stem.replace([':', '?', '&', '='], "-");
    let size = [pair.pictures[0].width, pair.pictures[0].height];
    let names = ["one-a", "one-b", "many-a", "many-b"];
    for (name, picture) in names.iter().zip(&pair.pictures) {
        let png = write_png(picture, background, 8).map_err(|e| failed(&e))?;
        crate::cli::output::write(&folder.join(format!("{stem}-{}-{name}.png", pair.frame)), &png)?;
    }
    for (name, change) in ["one-change", "many-change"].iter().zip(&pair.changes) {
        // Where nothing is compared: a dark green that no difference has.
        let color = |c: &f64| if c.is_nan() { [8, 40, 24] } else { difference::color(255.0 * c) };
        let rgba: Vec<u8> = change.iter().flat_map(|c| color(c).into_iter().chain([255])).collect();
        let png = png_of_rgba8(&rgba, size, true).map_err(|e| failed(&e))?;
        crate::cli::output::write(&folder.join(format!("{stem}-{}-{name}.png", pair.frame)), &png)?;
    }
    Ok(())
}
