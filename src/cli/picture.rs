//! `pellucid render`: a model and what is asked of it, as a picture in a file.
//!
//! What is wrong on the command line is said before any work is done. Then the model is read, the settings are chosen where a
//! promise asks for it, the pictures are drawn, written, and compared with a reference; [`draw`] is the middle of it, which
//! `--watch` repeats.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::ValueEnum;
use serde::Serialize;

use super::budget;
use super::compare::{self, Figures, differ};
use super::failure::{Exit, Failure};
use super::load::{STDIN, shown};
use super::options::RenderArgs;
use super::output::{self, Progress, grouped};
use super::render::{FrameReport, Layers, Renderer, Session, summary};
use super::view::{self, Asked};
use super::watch;
use crate::export::exr::{Facts, write_exr};
use crate::export::image::{LinearImage, parse_background};
use crate::export::png::{read_png, write_png};
use crate::math::LayerImage;
use crate::scene::{Notice, Scene};
use crate::session::configuration::Configuration;
use crate::session::{PartNames, Session as SavedSession, camera_in_scene};
use crate::settings::looks::opacity_models;
use crate::settings::{CaptureKind, OpacityModel, PrintedForm, Settings, Tail};
use crate::tradeoff::budget::{Choice, Goal, Verdict};
use crate::tradeoff::image_error::resized;
use crate::transfer::{OpacityFunction, TransferSource};

/// What a picture is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// sRGB in 8 or 16 bits, over the background
    Png,
    /// Linear light in floats of 16 or 32 bits, premultiplied, without the background
    Exr,
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
    difference: Option<Figures>,
}

/// How pictures leave: their format and the bits of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// The format.
    pub format: Format,
    /// Bits of a channel.
    pub bits: u8,
}

/// The format by `--format` and the name of the file, and the bits that suit it.
///
/// # Errors
/// [`Exit::Usage`] where they contradict each other.
pub fn encoding(args: &RenderArgs, configuration: &Configuration) -> Result<Encoding, Failure> {
    let usage = |message: String| Err(Failure::new(Exit::Usage, message));
    let ending = args.output.as_ref().and_then(|o| o.extension()).map(|e| e.to_string_lossy().to_ascii_lowercase());
    let output = || args.output.as_deref().unwrap_or(Path::new("")).display().to_string();
    let format = match (args.format, ending.as_deref()) {
        (Some(Format::Png), Some("exr")) | (Some(Format::Exr), Some("png")) => {
            return usage(format!("--output {}: the name and --format say different formats", output()));
        }
        (Some(format), _) => format,
        (None, Some("exr")) => Format::Exr,
        (None, Some("png") | None) => Format::Png,
        (None, Some(_)) => {
            return usage(format!(
                "--output {}: pictures are written as PNG or EXR, so the name must end in .png or .exr, or --format say which",
                output()
            ));
        }
    };
    let bits = match (format, args.bits) {
        (Format::Png, None) => configuration.bits(),
        (Format::Exr, None) => 32,
        (Format::Png, Some(bits @ (8 | 16))) | (Format::Exr, Some(bits @ (16 | 32))) => bits,
        (Format::Png, Some(bits)) => return usage(format!("--bits {bits}: a channel of a PNG has 8 or 16")),
        (Format::Exr, Some(bits)) => return usage(format!("--bits {bits}: a channel of an EXR has 16 or 32")),
    };
    if args.layers.is_some() && format != Format::Exr {
        return usage("--layers: layers are written into an EXR file, as in -o layers.exr".to_owned());
    }
    Ok(Encoding { format, bits })
}

/// Checks what can be checked of the command line before any work is done.
fn check(args: &RenderArgs) -> Result<(), Failure> {
    let targets = [("--output", &args.output), ("--stats", &args.stats), ("--save-session", &args.save_session)];
    let written: Vec<(&str, &PathBuf)> = targets.iter().filter_map(|(o, path)| Some((*o, path.as_ref()?))).collect();
    for (i, (option, path)) in written.iter().enumerate() {
        for (other, second) in &written[i + 1..] {
            let fault = match std::path::absolute(path).ok() == std::path::absolute(second).ok() {
                true if path.as_path() == Path::new(STDIN) => "cannot both go to standard output",
                true => "name the same file",
                false => continue,
            };
            return Err(Failure::new(Exit::Usage, format!("{option} and {other} {fault}")));
        }
        output::check(path)?;
    }
    Ok(())
}

/// Renders as the command line says.
///
/// # Errors
/// [`Failure`] of the command line, the files, the adapter, the renderer; [`Exit::Differ`] for a reference.
pub fn run(args: &RenderArgs, configuration: &Configuration) -> Result<(), Failure> {
    let encoding = encoding(args, configuration)?;
    check(args)?;
    if args.watch {
        return watch::run(args, configuration, encoding);
    }
    let asked = args.view.asked(configuration)?;
    if args.save_session.is_some() {
        view::check_saved(&asked.file)?;
    }
    let reference = args.reference.as_deref().map(|path| compare::read(path, Exit::NoReference)).transpose()?;
    let progress = Progress::new();
    let mut studio = Studio::default();
    let drawn = draw(args, asked, encoding, &mut studio, &progress)?;
    let Some(mut drawn) = drawn else { return Ok(()) };
    progress.stage("writing");
    let bytes = drawn.bytes(encoding)?;
    if let Some(output) = &args.output {
        output::write(output, &bytes)?;
    }
    drawn.say(&progress);
    let verdict = match (&args.reference, reference) {
        (Some(path), Some(reference)) => {
            let written = match encoding.format {
                Format::Png => read_png(&bytes).map_err(|e| Failure::of(Exit::General, &e))?,
                Format::Exr => drawn.image.clone(),
            };
            let (file, path) = (drawn.stats.file.clone(), path.display().to_string());
            match differ((&file, &written), (&path, &reference), drawn.background) {
                Ok((figures, _)) => {
                    drawn.stats.difference = Some(figures);
                    progress.say(&format!("{file} against {path}: {}", figures.sentence()));
                    compare::judge(&path, &figures, Some(args.threshold), None)
                }
                // Pictures of different sizes have no difference to report.
                Err(sizes) => Err(sizes),
            }
        }
        _ => Ok(()),
    };
    drawn.write_stats(args)?;
    match (args.budget.goal(), &drawn.stats.choice) {
        // Times are never judged: a machine may be busy. An error is what it is.
        (Some(Goal::Error(limit)), Some(choice)) if choice.verdict == Verdict::Broken && verdict.is_ok() => {
            let file = &drawn.stats.file;
            Err(Failure::new(Exit::Differ, format!("{file}: no configuration was found below FLIP {limit}")))
        }
        _ => verdict,
    }
}

/// What is kept from one picture to the next while files are watched.
#[derive(Default)]
pub struct Studio {
    /// Compiled shaders and buffers.
    renderer: Option<Renderer>,
    /// Raised when the picture at work is no longer wanted.
    pub cancel: Option<Arc<AtomicBool>>,
    /// What was said of the last model.
    notices: Vec<Notice>,
    /// What was said of the last arrangement and of the last layers.
    remarks: Vec<String>,
}

/// A picture, and what belongs to it.
pub struct Drawn {
    image: LinearImage,
    background: Option<[f32; 3]>,
    layers: Option<Layers>,
    facts: Facts,
    stats: Stats,
    /// What is said when the picture is where it belongs, a line for each that was drawn.
    summaries: Vec<String>,
}

impl Drawn {
    /// The picture as a file.
    ///
    /// # Errors
    /// [`Exit::General`] if it cannot be encoded.
    pub fn bytes(&self, encoding: Encoding) -> Result<Vec<u8>, Failure> {
        match encoding.format {
            Format::Png => {
                write_png(&self.image, self.background, encoding.bits).map_err(|e| Failure::of(Exit::General, &e))
            }
            Format::Exr => {
                let layers: &[LayerImage] = self.layers.as_ref().map_or(&[], |l| &l.images);
                write_exr(&self.image, layers, encoding.bits, &self.facts).map_err(|e| Failure::of(Exit::General, &e))
            }
        }
    }

    /// Says what became of the layers, when the picture is where it belongs.
    pub fn say(&self, progress: &Progress) {
        for line in &self.summaries {
            progress.say(line);
        }
    }

    /// Writes what `--stats` asks for.
    ///
    /// # Errors
    /// [`Exit::General`] if it cannot be written.
    pub fn write_stats(&self, args: &RenderArgs) -> Result<(), Failure> {
        match &args.stats {
            Some(target) => output::write(target, output::json(&self.stats)?.as_bytes()),
            None => Ok(()),
        }
    }
}

/// Reads the model and draws what is asked for; `None` if only a session was to be saved.
///
/// # Errors
/// As [`run`].
pub fn draw(
    args: &RenderArgs,
    asked: Asked<'_>,
    encoding: Encoding,
    studio: &mut Studio,
    progress: &Progress,
) -> Result<Option<Drawn>, Failure> {
    let background = parse_background(&asked.settings.image.background).map_err(|e| Failure::new(Exit::Usage, e))?;
    let mut takes = takes(asked.settings.clone(), args.compare, args.compare_opacity)?;
    let side_by_side = takes.len() > 1;
    let (scene, seen) = asked.load(&mut studio.notices, progress)?;
    if let Some(path) = &args.save_session {
        output::write(path, view::session_text(&seen, &scene, path)?.as_bytes())?;
        if args.output.is_none() && args.stats.is_none() && args.reference.is_none() {
            return Ok(None);
        }
    }
    let (file, size, camera) = (shown(Path::new(&seen.file)), seen.size, camera_in_scene(&seen.camera, &scene));
    progress.stage("starting the adapter");
    let chosen = match args.budget.goal() {
        Some(goal) => {
            let picture = (size, background);
            let arranged = (&scene, &seen.arrangement);
            let chosen = budget::chosen(&args.budget, goal, arranged, &camera, &takes[0].settings, picture, progress)?;
            progress.say(&format!("{file}: {}", chosen.sentence));
            takes[0].settings = chosen.choice.settings.clone();
            Some(chosen.choice)
        }
        None => None,
    };
    let scale = chosen.as_ref().map_or(1.0, |c| c.scale);
    let drawn_size = size.map(|s| ((f64::from(s) * scale).round() as u32).max(1));
    let mut session = Session::open_with(studio.renderer.take(), studio.cancel.clone(), &scene, &seen.arrangement)?;
    let mut remarks = session.notices.clone();
    let timing = if args.stats.is_some() { session.time_passes() } else { "not measured" };
    let mut images = Vec::new();
    let mut pictures = Vec::new();
    let mut summaries = Vec::new();
    for Take { name, settings } in &takes {
        progress.stage(&format!("rendering {name}"));
        if chosen.is_some() {
            // What is promised is the time of a frame; the first one compiles shaders besides.
            session.render(&camera, settings, drawn_size)?;
        }
        let frame = session.render(&camera, settings, drawn_size)?;
        let subject = if side_by_side { format!("{file}: {name}") } else { file.clone() };
        summaries.push(summary(&subject, drawn_size, &frame.report));
        images.push(resized(&frame.image, size));
        pictures.push(Picture { name, report: frame.report });
    }
    let layers = match args.layers {
        Some(most) if encoding.format == Format::Exr => {
            progress.stage("rendering layers");
            let settings = &takes[0].settings;
            let (report, layers) = session.layers(&camera, settings, size, most)?;
            remarks.extend(about_layers(&layers, &report, settings, !seen.arrangement.selected.is_empty()));
            Some(layers)
        }
        _ => None,
    };
    studio.renderer = Some(session.into_renderer());
    // Beside many pictures, what is said again and again is read by nobody.
    if remarks != studio.remarks {
        for remark in &remarks {
            progress.say(&format!("{file}: {remark}"));
        }
        studio.remarks = remarks;
    }
    let image =
        if side_by_side { LinearImage::side_by_side(&images, (size[0] / 100).max(1)) } else { images.remove(0) };
    let facts = match encoding.format {
        Format::Exr => facts(&seen, &scene, layers.as_ref()),
        Format::Png => Facts::default(),
    };
    let stats = Stats { file, size, timing, pictures, choice: chosen, difference: None };
    Ok(Some(Drawn { image, background, layers, facts, stats, summaries }))
}

/// What a user has to know of layers in a file, a sentence each.
fn about_layers(layers: &Layers, report: &FrameReport, settings: &Settings, selected: bool) -> Vec<String> {
    let mut said = Vec::new();
    let mut say = |text: String| said.push(text);
    say(format!("{} layers are written, of {} in the deepest pixel", layers.images.len(), layers.deepest));
    if layers.left_out > 0 {
        let (all, most) = (grouped(layers.left_out), layers.images.len());
        say(format!("{all} layers of single pixels lie behind the {most} nearest and are left out"));
    }
    if settings.image.samples > 1 {
        let n = settings.image.samples;
        say(format!("layers are those at each pixel's middle; the picture is the average of {n} samples"));
    }
    let (dropped, merged) = (report.layers.dropped, report.layers.merged);
    if dropped > 0 {
        say(format!("{} layers behind the k nearest are in no image", grouped(dropped)));
    }
    if merged > 0 {
        say(format!("{} layers were merged with others and have no image of their own", grouped(merged)));
    }
    let bucketed = settings.capture.kind == CaptureKind::BucketedKBuffer;
    if dropped > 0 && bucketed && settings.capture.bucketed_k_buffer.tail == Tail::Average {
        say("what lies behind the k nearest is in the picture as an average, and no layer".to_owned());
    }
    let illustrative = settings.opacity.model == OpacityModel::Illustrative;
    if illustrative && settings.opacity.illustrative.printed == PrintedForm::Transmittance {
        say("the printed form lets through another share than a layer covers: the layers do not add up to the picture"
            .to_owned());
    }
    if selected {
        say("the line around what is selected is in the picture, and no layer".to_owned());
    }
    said
}

/// What stands beside the pixels of an EXR: what would be drawn again, and the names of the parts that are there.
fn facts(seen: &SavedSession, scene: &Scene, layers: Option<&Layers>) -> Facts {
    let names_of = |layers: &Layers| {
        let mut parts: Vec<u32> = layers.images.iter().flat_map(|l| &l.part).copied().collect();
        parts.sort_unstable();
        parts.dedup();
        let names = PartNames::new(scene);
        parts.iter().filter_map(|&p| Some(format!("{p} {}\n", names.path(p)?))).collect()
    };
    Facts {
        background: seen.settings.image.background.clone(),
        // A session that cannot be written down is missing, and no reason for having no picture.
        session: seen.to_toml(scene).ok(),
        parts: layers.map(names_of).unwrap_or_default(),
        world_to_camera: Some(seen.camera.view_from_world().as_mat4().to_cols_array()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::options::{Cli, Command};
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
    fn the_format_is_that_of_the_name_or_of_the_option() {
        let of = |line: &str| {
            let words = ["pellucid", "render", "a.glb"].into_iter().chain(line.split_whitespace());
            let Some(Command::Render(args)) = Cli::try_parse_from(words).unwrap().command else { panic!("{line}") };
            encoding(&args, &Configuration::default()).map(|e| (e.format, e.bits)).map_err(|f| f.message)
        };
        assert_eq!(of("-o a.png"), Ok((Format::Png, 8)));
        assert_eq!(of("-o a.EXR"), Ok((Format::Exr, 32)));
        assert_eq!(of("-o - --format exr --bits 16"), Ok((Format::Exr, 16)));
        assert_eq!(of("-o - --bits 16"), Ok((Format::Png, 16)));
        assert_eq!(of("-o picture.tmp --format exr"), Ok((Format::Exr, 32)));
        assert_eq!(of("-o a.exr --layers"), Ok((Format::Exr, 32)));
        for (line, word) in [
            ("-o a.png --format exr", "different formats"),
            ("-o a.jpg", ".png or .exr"),
            ("-o a.png --bits 32", "8 or 16"),
            ("-o a.exr --bits 8", "16 or 32"),
            ("-o a.png --layers", ".exr"),
        ] {
            let said = of(line).unwrap_err();
            assert!(said.contains(word), "{line}: {said}");
        }
    }
}
