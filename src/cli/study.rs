//! `pellucid bench study`: the tasks of a user study, measured from the pictures.

use std::path::Path;

use clap::Args;
use serde::Serialize;

use super::camera::CameraArgs;
use super::failure::{Exit, Failure};
use super::importing::ImportArgs;
use super::options::size;
use super::output::Progress;
use super::render::failed;
use crate::gpu::{Gpu, GpuOptions};
use crate::import::ImportOptions;
use crate::render::Renderer;
use crate::settings::Settings;
use crate::tradeoff::study::{self, Options, Study, StudyError};

/// Options of `bench study`.
#[derive(Args, Clone, Debug)]
pub struct StudyArgs {
    /// Models, or builtin:NAME
    #[arg(default_values_t = ["builtin:flow", "builtin:gearbox"].map(str::to_owned))]
    pub files: Vec<String>,
    /// How they are read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// From where they are looked at
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Views all around among which junctions are chosen
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=360), default_value_t = 12)]
    pub views: u32,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "800x800")]
    pub size: [u32; 2],
    /// T-junctions of each model
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), default_value_t = 200)]
    pub junctions: u32,
    /// What their choice depends on
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Named {
    file: String,
    study: Study,
}

/// Runs the study of each model and prints the tables.
///
/// # Errors
/// [`Failure`] of the adapter, the file or the renderer.
pub fn run(args: &StudyArgs, configured: &ImportOptions, progress: &Progress) -> Result<(), Failure> {
    let import = args.import.options(None, configured.clone());
    let mut all = Vec::new();
    let mut text = String::new();
    for file in &args.files {
        let scene = super::load::scene(Path::new(file), &import, progress)?;
        let camera = args.camera.camera(&scene, f64::from(args.size[0]) / f64::from(args.size[1]))?;
        let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
        let mut renderer = Renderer::new(gpu).map_err(failed)?;
        let loaded = renderer.load(&scene).map_err(failed)?;
        let options = Options { size: args.size, junctions: args.junctions as usize, seed: args.seed };
        let mut say = |what: &str| progress.stage(&format!("{file}: {what}"));
        let cameras = study::around(&camera, args.views);
        let study = study::run(&mut renderer, &loaded, &cameras, &Settings::default(), &options, &mut say).map_err(
            |e| match e {
                StudyError::Render(e) => failed(e),
                StudyError::Banded { .. } => Failure::of(Exit::Limits, &e),
                e => Failure::of(Exit::General, &e),
            },
        )?;
        text += &format!("{file}, {} views at {}x{}: {}", args.views, args.size[0], args.size[1], study::table(&study));
        all.push(Named { file: file.clone(), study });
    }
    let text = if args.json { super::output::json(&all)? } else { text };
    super::output::print(text.as_bytes())
}
