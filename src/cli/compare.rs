//! `pellucid compare`: how far a picture is from another, in figures and as a picture. `render --reference` says the same.
//!
//! Both are compared as displayed: laid over one background in linear light, encoded as sRGB, values outside 0 to 1 cut off as
//! a screen does. The mean is over the three channels of all pixels, a pixel's difference is that of its most different
//! channel, and FLIP is Andersson 2020 at its usual 67 pixels a degree.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::budget::flip;
use super::camera::positive;
use super::failure::{Exit, Failure};
use super::options::threshold;
use super::output;
use crate::export::image::{LinearImage, parse_background, read_picture};
use crate::export::png::png_of_rgba8;
use crate::tradeoff::difference;
use crate::tradeoff::image_error::{self, ErrorMap, ImageError, displayed};

/// Largest picture file that is read, bytes.
const LARGEST: u64 = 4 << 30;

/// Options of `compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// A picture: PNG with 8 or 16 bits, or EXR
    #[arg(value_name = "PICTURE")]
    pub picture: PathBuf,
    /// The picture that it should be, as large
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,
    /// Write where they differ as a PNG; - is standard output, and the figures go to standard error then
    #[arg(long, value_name = "FILE")]
    pub difference: Option<PathBuf>,
    /// What the difference image shows
    #[arg(long, value_enum, default_value_t = Map::Flip, requires = "difference")]
    pub map: Map,
    /// Multiplies what --map absolute shows
    #[arg(long, value_name = "FACTOR", value_parser = positive, default_value = "8", requires = "difference")]
    pub amplify: f64,
    /// What both are laid over where they are transparent: #rrggbb [default: #808080, middle grey]
    #[arg(long, value_name = "COLOUR", value_parser = background)]
    pub background: Option<Background>,
    /// Exit with 5 if the mean error is above this, 0 to 1
    #[arg(long, value_name = "T", value_parser = threshold)]
    pub threshold: Option<f64>,
    /// Exit with 5 if the mean FLIP is above this, 0 to 1
    #[arg(long, value_name = "FLIP", value_parser = flip)]
    pub max_flip: Option<f64>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What a difference image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Map {
    /// FLIP from 0 (black) over violet and orange to 1 (pale yellow)
    Flip,
    /// Steps of 1/255 in the same colours, each stop twice the one before: 1, 2, 4 … 64
    Steps,
    /// The difference of each channel, amplified
    Absolute,
}

/// A colour in linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background([f32; 3]);

fn background(text: &str) -> Result<Background, String> {
    parse_background(text)?.map(Background).ok_or_else(|| "expected the form #rrggbb".to_owned())
}

/// How far two pictures differ, everything from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Largest difference of a channel, in sRGB values.
    pub maximum: f64,
    /// Mean difference over all channels and pixels, in sRGB values.
    pub mean: f64,
    /// Share of pixels of which a channel differs by more than 1/255.
    pub over_1: f64,
    /// Share of pixels of which a channel differs by more than 8/255.
    pub over_8: f64,
    /// Mean FLIP.
    pub flip_mean: f64,
}

impl Figures {
    fn of(error: &ImageError) -> Figures {
        Figures {
            maximum: error.maximum / 255.0,
            mean: error.mean / 255.0,
            over_1: error.above_1,
            over_8: error.above_8,
            flip_mean: error.flip_mean,
        }
    }

    /// In one line.
    pub fn sentence(&self) -> String {
        format!(
            "mean error {:.5}, maximum {:.5}, {:.2} % of pixels over 1/255, {:.2} % over 8/255, FLIP {:.5}",
            self.mean,
            self.maximum,
            self.over_1 * 100.0,
            self.over_8 * 100.0,
            self.flip_mean
        )
    }

    fn table(&self) -> String {
        let steps = |v: f64| format!("{v:.5}   {:.2}/255", v * 255.0);
        let share = |v: f64| format!("{:.4} % of pixels", v * 100.0);
        format!(
            "maximum error  {}\nmean error     {}\nover 1/255     {}\nover 8/255     {}\nmean FLIP      {:.5}\n",
            steps(self.maximum),
            steps(self.mean),
            share(self.over_1),
            share(self.over_8),
            self.flip_mean
        )
    }
}

/// Compares a picture with the reference, both by name.
///
/// # Errors
/// [`Exit::Differ`] if they differ in size, with both sizes.
pub fn differ(
    (name, picture): (&str, &LinearImage),
    (reference_name, reference): (&str, &LinearImage),
    background: Option<[f32; 3]>,
) -> Result<(Figures, ErrorMap), Failure> {
    let map = image_error::compare(picture, reference, background).map_err(|e| {
        let [w, h] = e.found;
        let [rw, rh] = e.expected;
        Failure::new(Exit::Differ, format!("{name}: {w}×{h} pixels, but {reference_name} has {rw}×{rh}"))
    })?;
    Ok((Figures::of(&map.error), map))
}

/// Reads a PNG or an EXR.
///
/// # Errors
/// `missing` if it does not exist, [`Exit::Input`] if it cannot be read.
pub fn read(path: &Path, missing: Exit) -> Result<LinearImage, Failure> {
    use std::io::Read;
    let failed = |e: std::io::Error| {
        let exit = if e.kind() == std::io::ErrorKind::NotFound { missing } else { Exit::Input };
        Failure::about(exit, path.display(), &e)
    };
    let mut bytes = Vec::new();
    std::fs::File::open(path).map_err(failed)?.take(LARGEST).read_to_end(&mut bytes).map_err(failed)?;
    read_picture(&bytes).map_err(|e| Failure::about(Exit::Input, path.display(), &e))
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    picture: String,
    reference: String,
    size: [u32; 2],
    #[serde(flatten)]
    figures: Figures,
}

/// Compares two files.
///
/// # Errors
/// [`Exit::NoReference`] or [`Exit::Input`] for a file that is missing, [`Exit::Differ`] for sizes that differ and errors above
/// a threshold.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    if let Some(target) = &args.difference {
        let ending = target.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if target != Path::new("-") && ending.as_deref() != Some("png") {
            let message =
                format!("--difference {}: a difference image is a PNG; end its name in .png", target.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        output::check(target)?;
    }
    let (name, reference_name) = (args.picture.display().to_string(), args.reference.display().to_string());
    let picture = read(&args.picture, Exit::Input)?;
    let reference = read(&args.reference, Exit::NoReference)?;
    let background = args.background.map(|b| b.0);
    let (figures, map) = differ((&name, &picture), (&reference_name, &reference), background)?;
    let size = [picture.width, picture.height];
    if let Some(target) = &args.difference {
        let rgba = match args.map {
            Map::Flip => opaque(map.flip.iter().map(|f| difference::color_of_share(*f))),
            Map::Steps => difference::rgba(&map),
            Map::Absolute => {
                let (a, b) = (displayed(&picture, background), displayed(&reference, background));
                let byte = |x: f64, y: f64| ((x - y).abs() * args.amplify * 255.0).round().min(255.0) as u8;
                opaque(a.iter().zip(&b).map(|(x, y)| std::array::from_fn(|c| byte(x[c], y[c]))))
            }
        };
        let png = png_of_rgba8(&rgba, size, true).map_err(|e| Failure::of(Exit::General, &e))?;
        output::write(target, &png)?;
    }
    let text = if args.json {
        output::json(&Report { picture: name.clone(), reference: reference_name.clone(), size, figures })?
    } else {
        format!("{name} against {reference_name}, {}×{}\n{}", size[0], size[1], figures.table())
    };
    if args.difference.as_deref() == Some(Path::new("-")) {
        text.lines().for_each(output::complain);
    } else {
        output::print(text.as_bytes())?;
    }
    judge(&name, &figures, args.threshold, args.max_flip)
}

/// Whether the errors of a picture are below their thresholds.
///
/// # Errors
/// [`Exit::Differ`] with the figures if one is not.
pub fn judge(name: &str, figures: &Figures, threshold: Option<f64>, max_flip: Option<f64>) -> Result<(), Failure> {
    let above = match (threshold, max_flip) {
        (Some(limit), _) if figures.mean > limit => format!("mean error above the threshold {limit}"),
        (_, Some(limit)) if figures.flip_mean > limit => format!("mean FLIP above {limit}"),
        _ => return Ok(()),
    };
    Err(Failure::new(Exit::Differ, format!("{name}: {above}: {}", figures.sentence())))
}

fn opaque(colors: impl Iterator<Item = [u8; 3]>) -> Vec<u8> {
    colors.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::png::{read_png, write_png};
    use crate::math::color::linear_from_srgb;

    /// A PNG whose pixels are these bytes, read back.
    fn bytes(pixels: &[[u8; 3]], width: u32) -> LinearImage {
        let rgba: Vec<u8> = opaque(pixels.iter().copied());
        read_png(&png_of_rgba8(&rgba, [width, pixels.len() as u32 / width], true).unwrap()).unwrap()
    }

    /// Four pixels. One channel of the first is 1 step off, one of the second 8, one of the third 9, the last is equal:
    /// mean 18 / 12 steps; the step of exactly 1 and that of exactly 8 are not over.
    #[test]
    fn a_pair_worked_out_by_hand() {
        let a = bytes(&[[100, 100, 100], [50, 60, 70], [200, 10, 10], [0, 255, 128]], 2);
        let b = bytes(&[[101, 100, 100], [50, 68, 70], [200, 10, 1], [0, 255, 128]], 2);
        let (figures, map) = differ(("a", &a), ("b", &b), None).unwrap();
        assert!((figures.maximum * 255.0 - 9.0).abs() < 1e-4, "{figures:?}");
        assert!((figures.mean * 255.0 - 1.5).abs() < 1e-4, "{figures:?}");
        assert_eq!((figures.over_1, figures.over_8), (0.5, 0.25));
        assert!(figures.flip_mean > 0.0 && map.flip.len() == 4);
        let back = differ(("b", &b), ("a", &a), None).unwrap().0;
        assert!((back.mean - figures.mean).abs() < 1e-12, "the order does not matter");
        assert_eq!(differ(("a", &a), ("a", &a), None).unwrap().0, Figures::default());
    }

    /// Half transparent black over grey of linear 0.2140 (sRGB 0.5) against opaque black: what is left of the grey is 0.1070
    /// linear, sRGB 0.3608; over white it is 0.5 linear, sRGB 0.7354.
    #[test]
    fn transparency_is_judged_over_the_background() {
        let half = LinearImage { width: 1, height: 1, pixels: vec![[0.0, 0.0, 0.0, 0.5]] };
        let black = LinearImage { pixels: vec![[0.0, 0.0, 0.0, 1.0]], ..half.clone() };
        let maximum = |background| differ(("a", &half), ("b", &black), background).unwrap().0.maximum;
        assert!((maximum(None) - 0.3608).abs() < 2e-4, "{}", maximum(None));
        assert!((maximum(Some([1.0; 3])) - 0.7354).abs() < 2e-4);
        assert_eq!(maximum(Some([0.0; 3])), 0.0);
    }

    #[test]
    fn sizes_that_differ_are_both_said() {
        let (a, b) = (bytes(&[[0; 3]; 6], 3), bytes(&[[0; 3]; 4], 2));
        let failure = differ(("a.png", &a), ("b.png", &b), None).unwrap_err();
        assert_eq!(failure.exit, Exit::Differ);
        assert_eq!(failure.message, "a.png: 3×2 pixels, but b.png has 2×2");
    }

    #[test]
    fn a_reference_that_is_missing_or_broken_has_its_own_code() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.png");
        let exit = |missing| read(&path, missing).map(|_| ()).map_err(|f| f.exit);
        assert_eq!((exit(Exit::NoReference), exit(Exit::Input)), (Err(Exit::NoReference), Err(Exit::Input)));
        std::fs::write(&path, b"no").unwrap();
        assert_eq!(exit(Exit::NoReference), Err(Exit::Input));
        let image = LinearImage { width: 1, height: 1, pixels: vec![[0.5, 0.5, 0.5, 1.0]] };
        std::fs::write(&path, write_png(&image, None, 16).unwrap()).unwrap();
        let read = read(&path, Exit::Input).unwrap();
        assert!((read.pixels[0][0] - 0.5).abs() < 1e-4, "{read:?}");
    }

    #[test]
    fn thresholds_are_the_largest_that_still_pass() {
        let figures = Figures { mean: 0.25, flip_mean: 0.5, ..Figures::default() };
        assert!(judge("a", &figures, None, None).is_ok() && judge("a", &figures, Some(0.25), Some(0.5)).is_ok());
        for (threshold, flip, word) in [(Some(0.2), None, "threshold 0.2"), (Some(0.3), Some(0.4), "FLIP above 0.4")] {
            let failure = judge("a", &figures, threshold, flip).unwrap_err();
            assert!(failure.exit == Exit::Differ && failure.message.contains(word), "{failure:?}");
        }
        assert!((linear_from_srgb(0.5) - 0.2140).abs() < 1e-4, "what the comment above says");
    }
}
