//! `pellucid bench illustration`: what each step of the illustration buffer costs against the number of fragments (Carnecky 2013,
//! section 6: every one is linear), and what the iterations add to a frame.

use std::path::Path;

use clap::Args;
use serde::Serialize;

use super::{Candidate, middle, print_rows, settings_of};
use crate::cli::camera::CameraArgs;
use crate::cli::failure::Failure;
use crate::cli::importing::ImportArgs;
use crate::cli::output::{Progress, grouped};
use crate::gpu::PassTime;
use crate::import::ImportOptions;
use crate::plan::Pass;
use crate::tradeoff::statistics::exponent;
use crate::tradeoff::sweep::median_passes;

/// Options of `bench illustration`.
#[derive(Args, Clone, Debug)]
pub struct IllustrationArgs {
    /// Models, or builtin:NAME
    #[arg(default_values_t = ["builtin:gearbox", "builtin:engine"].map(str::to_owned))]
    pub files: Vec<String>,
    /// How they are read.
    #[command(flatten)]
    pub import: ImportArgs,
    /// From where they are looked at
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Sides of the square pictures, in pixels
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "128,256,512,1024",
          value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub sides: Vec<u32>,
    /// Iterations of the diffusion
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100), default_value_t = 20)]
    pub iterations: u32,
    /// Interleaved runs of which the median is taken
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 5)]
    pub runs: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The steps of the paper, and which passes they are here.
const STEPS: [(&str, &[Pass]); 6] = [
    ("fill", &[Pass::Fill, Pass::PrefixSum]),
    ("sort", &[Pass::Sort, Pass::Gather]),
    (
        "connect",
        &[
            Pass::PartLookup,
            Pass::ZReordering,
            Pass::BucketCreation,
            Pass::NeighbourCandidates,
            Pass::NeighbourLinks,
            Pass::CutLinks,
        ],
    ),
    ("light", &[Pass::Shade, Pass::Stylize]),
    ("iterate", &[Pass::Boundary, Pass::Diffuse]),
    ("composite", &[Pass::Illustrate, Pass::Blend]),
];

/// One size of picture.
#[derive(Serialize)]
struct SizeRow {
    side: u32,
    fragments: u64,
    /// Bands that the frame was made in.
    bands: usize,
    /// Wall time of the frame with an unsorted blend, milliseconds.
    unsorted: f64,
    /// Of the frame without iterations.
    without: f64,
    /// Of the frame with them.
    with: f64,
    /// Of each of the steps, run alone, in the frame with iterations.
    steps: Vec<f64>,
}

impl SizeRow {
    /// What the iterations multiply the frame's time by.
    fn factor(&self) -> f64 {
        self.with / self.without
    }
}

/// Everything about one model.
#[derive(Serialize)]
struct ModelRows {
    file: String,
    iterations: u32,
    steps: Vec<&'static str>,
    sizes: Vec<SizeRow>,
    /// Exponents of the steps over the number of fragments; no number from fewer than two sizes.
    exponents: Vec<Option<f64>>,
    /// Of the frame with iterations.
    frame_exponent: Option<f64>,
}

/// What was measured of one size.
#[derive(Default)]
struct Times {
    /// Of each candidate, frame by frame.
    whole: [Vec<f64>; 3],
    /// Of the frame with iterations.
    passes: Vec<Vec<PassTime>>,
    fragments: u64,
    bands: usize,
}

fn time_of(passes: &[PassTime], step: &[Pass]) -> f64 {
    passes.iter().filter(|t| step.contains(&t.pass)).map(|t| t.milliseconds).fold(0.0, |a, b| a + b)
}

/// Measures.
///
/// # Errors
/// [`Failure`] of the adapter, the file or the renderer.
pub fn run(args: &IllustrationArgs, configured: &ImportOptions, progress: &Progress) -> Result<(), Failure> {
    let options = args.import.options(None, configured.clone());
    let mut all = Vec::new();
    for file in &args.files {
        all.push(measure(args, file, &options, progress)?);
    }
    let text: String = all.iter().map(|rows| table(rows, args.runs)).collect();
    print_rows(&all, &text, args.json)
}

fn measure(
    args: &IllustrationArgs,
    file: &str,
    options: &ImportOptions,
    progress: &Progress,
) -> Result<ModelRows, Failure> {
    let scene = crate::cli::load::scene(Path::new(file), options, progress)?;
    let camera = args.camera.camera(&scene, 1.0)?;
    let lists = ("capture.kind", "linked_list".to_owned());
    // As in the paper: lengths in pixels, an adaptive base, isotropic.
    let printed = [
        ("opacity.model", "illustrative"),
        ("opacity.illustrative.unit", "pixel"),
        ("opacity.illustrative.base", "adaptive"),
        ("opacity.illustrative.feature_size", "0"),
    ];
    let model = printed.map(|(path, value)| (path, value.to_owned()));
    let of = |more: &[(&'static str, String)]| settings_of(&[std::slice::from_ref(&lists), &model[..], more].concat());
    let with = of(&[("opacity.illustrative.iterations", args.iterations.to_string())])?;
    let still = |field| (field, "none".to_owned());
    let without = of(&[
        still("opacity.illustrative.alpha.diffusion"),
        still("opacity.illustrative.beta.diffusion"),
        still("opacity.illustrative.gamma.diffusion"),
    ])?;
    let mut candidates = [
        Candidate::new("unsorted blend", &scene, without.clone(), true)?,
        Candidate::new("no iterations", &scene, without, false)?,
        Candidate::new("iterations", &scene, with, false)?,
    ];
    // Sizes are interleaved too: a machine that slows down meanwhile must not bend the exponents.
    let mut times: Vec<Times> = args.sides.iter().map(|_| Times::default()).collect();
    for round in 0..1 + 2 * args.runs {
        progress.stage(&format!("{file}: round {} of {}", round + 1, 1 + 2 * args.runs));
        for (&side, times) in args.sides.iter().zip(&mut times) {
            for (candidate, whole) in candidates.iter_mut().zip(&mut times.whole) {
                candidate.run(&camera, [side; 2], round >= 1, round > args.runs)?;
                whole.append(&mut candidate.whole);
            }
            let [.., iterated] = &mut candidates;
            times.passes.append(&mut iterated.passes);
            (times.fragments, times.bands) = (iterated.fragments, iterated.bands);
        }
    }
    let row = |(&side, times): (&u32, &Times)| {
        let [unsorted, without, with] = times.whole.each_ref().map(|all| middle(all));
        let passes = median_passes(&times.passes);
        let steps = STEPS.iter().map(|(_, step)| time_of(&passes, step)).collect();
        SizeRow { side, fragments: times.fragments, bands: times.bands, unsorted, without, with, steps }
    };
    let sizes: Vec<SizeRow> = args.sides.iter().zip(&times).map(row).collect();
    let over_fragments = |time: &dyn Fn(&SizeRow) -> f64| {
        exponent(&sizes.iter().map(|r| (r.fragments as f64, time(r))).collect::<Vec<_>>())
    };
    let exponents = (0..STEPS.len()).map(|i| over_fragments(&|r| r.steps[i])).collect();
    let frame_exponent = over_fragments(&|r| r.with);
    let steps = STEPS.iter().map(|(name, _)| *name).collect();
    Ok(ModelRows { file: file.to_owned(), iterations: args.iterations, steps, sizes, exponents, frame_exponent })
}

fn table(rows: &ModelRows, runs: u32) -> String {
    let mut text = format!(
        "{}, linked lists, illustrative, {} iterations; medians of {runs} interleaved frames, ms; steps: each run alone, wall time\n\
         {:>6}{:>12}{:>7}",
        rows.file, rows.iterations, "side", "fragments", "bands"
    );
    for name in &rows.steps {
        text += &format!("{name:>11}");
    }
    text += &format!("{:>11}{:>11}{:>11}\n", "unsorted", "without", "with");
    for row in &rows.sizes {
        text += &format!("{:>6}{:>12}{:>7}", row.side, grouped(row.fragments), row.bands);
        for time in row.steps.iter().chain([&row.unsorted, &row.without, &row.with]) {
            text += &format!("{time:>11.1}");
        }
        text.push('\n');
    }
    let number = |e: &Option<f64>| e.map_or_else(|| format!("{:>11}", "-"), |e| format!("{e:>11.3}"));
    text += &format!("{:>25}", "exponent");
    text.extend(rows.exponents.iter().map(&number));
    text += &format!("{:>22}{}\n", "", number(&rows.frame_exponent));
    text += "over an unsorted blend:\n";
    for row in &rows.sizes {
        text += &format!(
            "{:>6}   without iterations {:>7.2}   with {:>7.2}   with over without {:>6.2}\n",
            row.side,
            row.without / row.unsorted,
            row.with / row.unsorted,
            row.factor()
        );
    }
    text + "\n"
}
