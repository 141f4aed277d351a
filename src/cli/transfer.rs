//! `pellucid transfer`: what a transfer function is, and the same in another format.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::{Exit, Failure, printable};
use super::output;
use crate::transfer::formats::{Exported, Format, Imported, write};
use crate::transfer::{
    self, ColorMode, ColorShape, Interpolation, OpacityShape, TransferError, TransferFunction, TransferSource,
};

/// More points of a function are not listed.
const MOST_LISTED: usize = 12;

/// Options of `transfer`.
#[derive(Args, Clone, Debug)]
pub struct TransferArgs {
    /// A name from `pellucid presets`, or a file: TOML, PNG, ParaView JSON or XML, Slicer .vp, CSV
    #[arg(value_name = "FILE|NAME")]
    pub source: String,
    /// The file to write, its format by its ending: .toml, .png (colours), .opacity.png, .json, .xml, .vp or .csv
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Which map of a file that holds several [default: the first]
    #[arg(long, value_name = "MAP")]
    pub name: Option<String>,
}

/// Converts, or describes.
///
/// # Errors
/// [`Exit::Usage`] for what the command line says, [`Exit::Input`] for what the file says, [`Exit::General`] if the
/// output cannot be written.
pub fn run(args: &TransferArgs) -> Result<(), Failure> {
    let target = args.output.as_deref().map(|path| Ok((path, format_of(path)?))).transpose()?;
    if let Some((path, _)) = target {
        output::check(path)?;
    }
    let Imported { function, notices } =
        TransferSource::Named(args.source.clone()).import(None, args.name.as_deref()).map_err(|e| failure(&e))?;
    say(&args.source, &notices);
    let Some((path, format)) = target else {
        return output::print(describe(&args.source, &function).as_bytes());
    };
    let Exported { bytes, notices } = write(&function, format, &name_of(args)).map_err(|e| failure(&e))?;
    say(&path.display().to_string(), &notices);
    output::write(path, &bytes)
}

/// Says the notices of a file on standard error, a line each.
pub fn say(file: &str, notices: &[String]) {
    for notice in notices {
        output::complain(&printable(&format!("{file}: {notice}")));
    }
}

/// A refusal as the program's failure: an unknown name is the command line's fault, anything else the file's.
pub fn failure(e: &TransferError) -> Failure {
    let exit = if matches!(e, TransferError::Unknown { .. }) { Exit::Usage } else { Exit::Input };
    Failure::of(exit, e)
}

fn format_of(path: &Path) -> Result<Format, Failure> {
    Format::of_path(path).ok_or_else(|| {
        let endings: Vec<String> = Format::ALL.iter().map(|f| format!(".{}", f.extension())).collect();
        let message = format!("--output {}: its name must end in one of {}", path.display(), endings.join(", "));
        Failure::new(Exit::Usage, message)
    })
}

/// What the written map is called: as it was, or as its file.
fn name_of(args: &TransferArgs) -> String {
    let (file, map) = match args.source.rsplit_once('#') {
        Some((file, map)) if !Path::new(&args.source).exists() => (file, Some(map)),
        _ => (args.source.as_str(), None),
    };
    let stem = Path::new(file).file_stem().map(|s| s.to_string_lossy().into_owned());
    args.name.clone().or(map.map(str::to_owned)).or(stem).unwrap_or_else(|| args.source.clone())
}

fn word(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Step => "step",
        Interpolation::Linear => "linear",
        Interpolation::Monotone => "monotone",
    }
}

/// What a function is, on one screen.
fn describe(source: &str, function: &TransferFunction) -> String {
    let mut text = format!("{source}\n");
    if let Some(preset) = transfer::presets().iter().find(|p| p.name == source) {
        let _ = writeln!(text, "{}", preset.description);
    }
    let yes = |varies: bool| if varies { "varies" } else { "does not vary" };
    let mode = match function.color.mode {
        ColorMode::Tint => "tint",
        ColorMode::Multiply => "multiply",
    };
    let _ = writeln!(text, "\nColour over kappa from -1 (convex) to 1 (concave), 0.5 changes nothing: {mode}");
    let _ = writeln!(text, "  {} with curvature", yes(function.color.depends_on_curvature()));
    match &function.color.shape {
        ColorShape::Points { interpolation, points } => {
            let points = points.as_slice();
            let _ = writeln!(text, "  {} points, {}", points.len(), word(*interpolation));
            for i in listed(points.len()) {
                let (kappa, [r, g, b]) = (points[i].kappa, points[i].color.0);
                let _ = writeln!(text, "  {kappa:8.4}  {r:.4} {g:.4} {b:.4}");
            }
        }
        ColorShape::Strip(raster) => {
            let _ = writeln!(text, "  image {}", raster.path());
        }
    }
    let _ = writeln!(text, "\nOpacity over depth from 0 (near) to 1 (far), and |kappa| from 0 to 1");
    let opacity = &function.opacity;
    let _ = writeln!(text, "  {} with curvature", yes(opacity.depends_on_curvature()));
    let _ = writeln!(text, "  {} with depth", yes(opacity.depends_on_depth()));
    match &opacity.shape {
        OpacityShape::Curves { interpolation, depth_interpolation, curves } => {
            let curves = curves.as_slice();
            let counts = curves.iter().map(|c| c.points.as_slice().len()).sum::<usize>();
            let (along, between) = (word(*interpolation), word(*depth_interpolation));
            let _ = match curves.len() {
                1 => writeln!(text, "  {counts} points, {along}"),
                n => writeln!(text, "  {counts} points on {n} curves, {along}; {between} between curves"),
            };
        }
        OpacityShape::Image(raster) => {
            let _ = writeln!(text, "  image {}", raster.path());
        }
    }
    let places = [0.0, 0.25, 0.5, 0.75, 1.0];
    text.push_str("  |kappa|      depth 0   0.25    0.5   0.75      1\n");
    for kappa in places.into_iter().rev() {
        let row: String = places.iter().map(|depth| format!(" {:6.3}", opacity.sample(*depth, kappa))).collect();
        let _ = writeln!(text, "  {kappa:7.2}       {row}");
    }
    printable_lines(&text)
}

/// Indices of all of `count`, or of some evenly spread, the ends among them.
fn listed(count: usize) -> Vec<usize> {
    let shown = count.min(MOST_LISTED);
    (0..shown).map(|i| if shown < 2 { 0 } else { i * (count - 1) / (shown - 1) }).collect()
}

fn printable_lines(text: &str) -> String {
    text.lines().map(|line| printable(line) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_fits_on_a_screen() {
        for name in transfer::names() {
            let function = TransferSource::Named(name.to_owned()).resolve(None).unwrap();
            let text = describe(name, &function);
            assert!(text.lines().count() <= 40 && text.lines().all(|l| l.chars().count() <= 110), "{text}");
            let deep = text.contains("  varies with depth");
            assert_eq!(deep, function.depends_on_depth(), "{text}");
        }
        assert_eq!(listed(3), [0, 1, 2]);
        assert_eq!((listed(500).len(), listed(500)[11], listed(1)), (12, 499, vec![0]));
    }

    #[test]
    fn a_map_keeps_its_name() {
        let named = |source: &str, name: Option<&str>| {
            name_of(&TransferArgs { source: source.to_owned(), output: None, name: name.map(str::to_owned) })
        };
        assert_eq!(named("x-ray", None), "x-ray");
        assert_eq!(named("looks/hot.json", None), "hot");
        assert_eq!(named("looks/hot.json#A b", None), "A b");
        assert_eq!(named("looks/hot.json", Some("C")), "C");
    }
}
