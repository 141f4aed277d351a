//! The look of a picture: settings from presets, files and single options, in that order of rank.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::failure::{Exit, Failure};
use super::transfer::{failure, say};
use crate::settings::looks::{self, LookError};
use crate::settings::{CaptureKind, OpacityModel, Settings};
use crate::transfer::{TransferSource, place_of};

/// Largest settings file that is read, bytes.
const LARGEST_SETTINGS: u64 = 1 << 20;

/// Options for the look. A settings file counts first, then a preset, then single options, then `--set` in order.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Look")]
pub struct LookArgs {
    /// A look by name; `pellucid presets` lists them
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// A settings file; `pellucid settings --toml` prints one with every default
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// One setting by its path, as in capture.bucketed_k_buffer.k=24; `pellucid settings` lists them
    #[arg(long, value_name = "PATH=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// Keep the k nearest layers in a Bucketed k-Buffer
    #[arg(long, value_name = "N")]
    pub k: Option<u32>,
    /// Capture technique
    #[arg(long, value_name = "KIND", value_parser = PossibleValuesParser::new(CaptureKind::NAMES))]
    pub capture: Option<String>,
    /// Opacity model
    #[arg(long, value_name = "MODEL", value_parser = PossibleValuesParser::new(OpacityModel::NAMES))]
    pub opacity: Option<String>,
    /// Transfer functions: a name from `pellucid presets`, or a file that `pellucid transfer` reads
    #[arg(long, value_name = "NAME|FILE")]
    pub transfer: Option<String>,
    /// Frames averaged, each shifted by a fraction of a pixel
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Background: #rrggbb, or none for a transparent picture
    #[arg(long, value_name = "COLOUR")]
    pub background: Option<String>,
}

impl LookArgs {
    /// The settings that the options ask for, over settings that count less than anything here, with a transfer function that is
    /// known to be sound. A settings file says everything, so it replaces what is below.
    ///
    /// # Errors
    /// [`Exit::Usage`] for what the command line says, [`Exit::Input`] for what files say.
    pub fn settings_over(&self, base: Settings) -> Result<Settings, Failure> {
        let usage = |e: &dyn std::fmt::Display| Failure::new(Exit::Usage, e);
        let mut settings = match &self.settings {
            Some(path) => read_settings(path)?,
            None => base,
        };
        if let Some(name) = &self.preset {
            apply_preset(&mut settings, name)?;
        }
        if self.k.is_some() && self.capture.as_deref().is_some_and(|c| c != CaptureKind::BucketedKBuffer.name()) {
            return Err(usage(&"--k is for --capture bucketed_k_buffer: the other captures keep every layer"));
        }
        let bucketed = self.k.map(|_| CaptureKind::BucketedKBuffer.name().to_owned());
        if self.transfer.is_some() {
            settings.opacity.follow_transfer();
        }
        for (option, path, value) in [
            ("--k", "capture.kind", bucketed),
            ("--k", "capture.bucketed_k_buffer.k", self.k.map(|k| k.to_string())),
            ("--capture", "capture.kind", self.capture.clone()),
            ("--transfer", "opacity.transfer", self.transfer.clone()),
            ("--opacity", "opacity.model", self.opacity.clone()),
            ("--samples", "image.samples", self.samples.map(|n| n.to_string())),
            ("--background", "image.background", self.background.clone()),
        ] {
            if let Some(value) = value {
                settings.set(path, &value).map_err(|e| usage(&format!("{option}: {e}")))?;
            }
        }
        for (path, value) in &self.set {
            settings.set(path, value).map_err(|e| usage(&format!("--set: {e}")))?;
        }
        check_transfer(&settings)?;
        Ok(settings)
    }
}

/// Reads a settings file; relative paths in it count from its folder.
fn read_settings(path: &Path) -> Result<Settings, Failure> {
    let at = path.display();
    let input = |message: String| Failure::new(Exit::Input, message);
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(|e| input(format!("{at}: {e}")))?;
    file.take(LARGEST_SETTINGS + 1).read_to_string(&mut text).map_err(|e| input(format!("{at}: {e}")))?;
    if text.len() as u64 > LARGEST_SETTINGS {
        return Err(input(format!("{at}: larger than {} MiB", LARGEST_SETTINGS >> 20)));
    }
    let table: toml::Table = toml::from_str(&text).map_err(|e| {
        let (line, column, reason) = place_of(&text, &e);
        input(format!("{at}:{line}:{column}: {reason}"))
    })?;
    let mut settings = Settings::default();
    settings.merge(&table).map_err(|e| input(format!("{at}: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    settings.opacity.transfer = std::mem::take(&mut settings.opacity.transfer).rebased(folder);
    Ok(settings)
}

fn apply_preset(settings: &mut Settings, name: &str) -> Result<(), Failure> {
    looks::apply(settings, name).map_err(|e| {
        let exit = if matches!(e, LookError::Unknown { .. }) { Exit::Usage } else { Exit::General };
        Failure::of(exit, &e)
    })
}

/// Refuses a broken transfer function before any work is done, where it is used, and says what reading it changed.
fn check_transfer(settings: &Settings) -> Result<(), Failure> {
    if settings.opacity.base_model() != OpacityModel::Curvature {
        return Ok(());
    }
    let imported = settings.opacity.transfer.import(None, None).map_err(|e| failure(&e))?;
    if let TransferSource::Named(file) = &settings.opacity.transfer {
        say(file, &imported.notices);
    }
    Ok(())
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() => Ok((path.trim().to_owned(), value.to_owned())),
        _ => Err("expected PATH=VALUE".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{CurvatureKind, KeyFormat, NormalEncoding};

    fn look() -> LookArgs {
        LookArgs::default()
    }

    impl LookArgs {
        fn settings(&self) -> Result<Settings, Failure> {
            self.settings_over(Settings::default())
        }
    }

    #[test]
    fn every_preset_applies() {
        for (name, _) in looks::presets() {
            LookArgs { preset: Some(name.to_owned()), ..look() }.settings().unwrap_or_else(|e| panic!("{e:?}"));
        }
        let paper = LookArgs { preset: Some("paper".to_owned()), ..look() }.settings().unwrap();
        assert_eq!(paper.capture.kind, CaptureKind::BucketedKBuffer);
        assert_eq!(paper.capture.bucketed_k_buffer.k, 16);
        assert_eq!(paper.capture.bucketed_k_buffer.key, KeyFormat::Packed32);
        assert_eq!(paper.capture.normals, NormalEncoding::Xy15);
        assert_eq!(paper.features.curvature.kind, CurvatureKind::ViewCentred);
        let plain = LookArgs { preset: Some("plain".to_owned()), ..look() }.settings().unwrap();
        assert_eq!((plain.opacity.model, plain.opacity.constant), (OpacityModel::Constant, 0.3));
        let unknown = LookArgs { preset: Some("plane".to_owned()), ..look() }.settings().unwrap_err();
        assert_eq!(unknown.exit, Exit::Usage);
        assert!(unknown.message.contains("did you mean 'plain'") && unknown.message.contains("x-ray"), "{unknown:?}");
    }

    #[test]
    fn k_switches_the_capture_and_is_checked() {
        let k = |k| LookArgs { k: Some(k), ..look() };
        let settings = k(8).settings().unwrap();
        assert_eq!(settings.capture.kind, CaptureKind::BucketedKBuffer);
        assert_eq!(settings.capture.bucketed_k_buffer.k, 8);
        for wrong in [k(0), k(65), LookArgs { capture: Some("compacted".to_owned()), ..k(8) }] {
            assert_eq!(wrong.settings().unwrap_err().exit, Exit::Usage);
        }
    }

    #[test]
    fn later_ranks_win() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        std::fs::write(&file, "opacity.constant = 0.9\nopacity.gain = 2\nimage.background = '#000000'\n").unwrap();
        let args = LookArgs {
            settings: Some(file),
            preset: Some("plain".to_owned()),
            background: Some("none".to_owned()),
            set: vec![("image.background".to_owned(), "#102030".to_owned())],
            ..look()
        };
        let settings = args.settings().unwrap();
        assert_eq!((settings.opacity.constant, settings.opacity.gain), (0.3, 2.0));
        assert_eq!(settings.image.background, "#102030");
    }

    #[test]
    fn transfer_functions_may_stand_in_a_settings_file() {
        let text = "
            [opacity.transfer.color]
            points = [{ kappa = 0, color = 1 }]
            [opacity.transfer.opacity]
            curves = [{ depth = 0, points = [[0, 0.5], [1, 1]] }]";
        let settings = Settings::from_toml(text).unwrap();
        let function = settings.opacity.transfer.resolve(None).unwrap();
        assert_eq!((function.color.constant(), function.opacity.sample(0.3, 0.0)), (Some([1.0; 3]), 0.5));
        assert_eq!(Settings::from_toml(&settings.to_toml().unwrap()).unwrap(), settings);
        let e = Settings::from_toml(&text.replace("[0, 0.5]", "[0, 5.0]")).unwrap_err().to_string();
        assert!(e.contains("opacity.transfer") && e.contains("opacity = 5"), "{e}");
    }

    #[test]
    fn what_is_wrong_on_the_line_is_usage_and_in_a_file_is_input() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            folder.path().join(name)
        };
        let input = |settings: PathBuf| {
            let failure = LookArgs { settings: Some(settings), ..look() }.settings().unwrap_err();
            assert_eq!(failure.exit, Exit::Input, "{failure:?}");
            failure.message
        };
        assert!(input(file("a.toml", "[opacity]\nmodel = \n")).contains("a.toml:2:"));
        assert!(input(file("b.toml", "opacity.modell = 'opaque'")).contains("did you mean 'opacity.model'"));
        assert!(input(file("c.toml", "opacity.transfer = 'tf.toml'")).contains("tf.toml: "));
        file("tf.toml", "[color]\npoints = [{ kappa = 2, color = 1 }]\n");
        assert!(input(folder.path().join("c.toml")).contains("tf.toml:2:11: kappa = 2"));
        assert!(input(folder.path().join("missing.toml")).contains("missing.toml: "));
        for wrong in [
            LookArgs { background: Some("white".to_owned()), ..look() },
            LookArgs { samples: Some(0), ..look() },
            LookArgs { transfer: Some("nothing".to_owned()), ..look() },
            LookArgs { set: vec![("no.such".to_owned(), "1".to_owned())], ..look() },
        ] {
            assert_eq!(wrong.settings().unwrap_err().exit, Exit::Usage);
        }
        assert!(assignment("a.b=c=d").is_ok_and(|(path, value)| path == "a.b" && value == "c=d"));
        assert!(assignment("a.b").is_err() && assignment("=1").is_err());
    }
}
