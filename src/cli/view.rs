//! What is seen: a model or a session, and the options beside it, as one [`Session`] with its scene.
//!
//! Everything goes through the session that `--save-session` writes, the camera in the file's coordinates included, so that
//! rendering it again gives the same picture bit for bit.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::{Exit, Failure};
use super::load::{self, BUILTIN, STDIN};
use super::options::ViewArgs;
use super::output::Progress;
use crate::import::ImportOptions;
use crate::scene::arrangement::MOST_EXPLODED;
use crate::scene::{Arrangement, Notice, PartLook, PartStyle, Presence, Scene};
use crate::session::configuration::Configuration;
use crate::session::{Importing, PartNames, Session, SessionFile, camera_in_file, camera_in_scene};
use crate::settings::Settings;

/// Options for parts, each by its path in the hierarchy or by a name that only one has; a group's name means all below it.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Parts")]
pub struct PartArgs {
    /// Show this part, or all of a group, and ghost the rest
    #[arg(long, value_name = "PART")]
    pub isolate: Vec<String>,
    /// Show this part as a ghost of itself
    #[arg(long, value_name = "PART")]
    pub ghost: Vec<String>,
    /// Do not draw this part
    #[arg(long, value_name = "PART")]
    pub hide: Vec<String>,
    /// Outline this part through everything in front of it
    #[arg(long, value_name = "PART")]
    pub select: Vec<String>,
    /// How this part is drawn, as in 'housing:opacity=0.3,color=#cc4400,style=solid'
    #[arg(long, value_name = "PART:LOOK", value_parser = own_look)]
    pub part: Vec<OwnLook>,
    /// Move parts apart, level by level of the hierarchy: 0 to 4
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    pub explode: Option<f64>,
}

fn factor(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|v| (0.0..=MOST_EXPLODED).contains(v))
        .ok_or_else(|| format!("expected a number from 0 to {MOST_EXPLODED}"))
}

/// What `--part` asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLook {
    part: String,
    opacity: Option<f64>,
    color: Option<[f64; 3]>,
    style: Option<PartStyle>,
}

/// Parses `PART:NAME=VALUE,…`. No value has a colon, so the last one ends the part's name, whatever is in it.
fn own_look(text: &str) -> Result<OwnLook, String> {
    let expected = || "expected PART:LOOK, as in 'housing:opacity=0.3,color=#cc4400,style=solid'".to_owned();
    let (part, looks) = text.rsplit_once(':').ok_or_else(expected)?;
    let mut look = OwnLook { part: part.to_owned(), opacity: None, color: None, style: None };
    for pair in looks.split(',') {
        match pair.split_once('=').ok_or_else(expected)? {
            ("opacity", value) => look.opacity = Some(share(value).ok_or("opacity: expected a number from 0 to 1")?),
            ("color", value) => {
                look.color = Some(own_color(value).ok_or("color: expected #rrggbb, or R/G/B from 0 to 1 each")?);
            }
            ("style", "as_set") => look.style = Some(PartStyle::AsSet),
            ("style", "solid") => look.style = Some(PartStyle::Solid),
            ("style", _) => return Err("style: expected as_set or solid".to_owned()),
            (name, _) => return Err(format!("'{name}' is no look of a part: opacity, color and style are")),
        }
    }
    Ok(look)
}

fn share(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|v| (0.0..=1.0).contains(v))
}

/// sRGB, 0 to 1.
fn own_color(text: &str) -> Option<[f64; 3]> {
    if let Some(digits) = text.strip_prefix('#') {
        let six = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        let value = u32::from_str_radix(digits, 16).ok().filter(|_| six)?;
        return Some([16, 8, 0].map(|shift| f64::from(value >> shift & 0xff) / 255.0));
    }
    let channels: Vec<f64> = text.split('/').map(share).collect::<Option<_>>()?;
    channels.try_into().ok()
}

impl PartArgs {
    /// Changes an arrangement as the options say: isolated parts first, then ghosts, then what is hidden.
    ///
    /// # Errors
    /// [`Exit::Usage`] for a name that no part has, or several have.
    pub(super) fn apply(&self, arrangement: &mut Arrangement, scene: &Scene) -> Result<(), Failure> {
        if let Some(explode) = self.explode {
            arrangement.explode = explode;
        }
        if [&self.isolate, &self.ghost, &self.hide, &self.select].iter().all(|list| list.is_empty())
            && self.part.is_empty()
        {
            return Ok(());
        }
        let names = PartNames::new(scene);
        let found = |option: &str, list: &[String]| -> Result<BTreeSet<u32>, Failure> {
            let mut all = BTreeSet::new();
            for name in list {
                all.extend(names.find(name).map_err(|e| Failure::new(Exit::Usage, format!("{option}: {e}")))?);
            }
            Ok(all)
        };
        if !self.isolate.is_empty() {
            arrangement.isolate(&found("--isolate", &self.isolate)?, scene.parts.len() as u32);
        }
        for (option, list, presence) in
            [("--ghost", &self.ghost, Presence::Ghosted), ("--hide", &self.hide, Presence::Hidden)]
        {
            for part in found(option, list)? {
                arrangement.parts.entry(part).or_default().presence = presence;
            }
        }
        for own in &self.part {
            for part in found("--part", std::slice::from_ref(&own.part))? {
                let look = arrangement.parts.entry(part).or_default();
                look.opacity = own.opacity.unwrap_or(look.opacity);
                look.color = own.color.or(look.color);
                look.style = own.style.unwrap_or(look.style);
            }
        }
        arrangement.parts.retain(|_, look| *look != PartLook::default());
        arrangement.selected.extend(found("--select", &self.select)?);
        Ok(())
    }
}

/// A view whose options are known to be sound; the scene is not there yet.
pub struct Asked<'a> {
    args: &'a ViewArgs,
    session: Option<SessionFile>,
    /// The model, `-`, or `builtin:NAME`.
    pub file: PathBuf,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The settings.
    pub settings: Settings,
    /// How the model is read.
    pub options: ImportOptions,
}

impl ViewArgs {
    /// Reads the session, if there is one, and the settings. A session says everything but what the command line says; where
    /// there is none, the configuration counts, and a preset of the command line takes the place of a configured one.
    ///
    /// # Errors
    /// [`Exit::Usage`] for what the command line says, [`Exit::Input`] for what files say.
    pub fn asked(&self, configuration: &Configuration) -> Result<Asked<'_>, Failure> {
        let session = self.session.as_deref().map(read_session).transpose()?;
        let configured = || configuration.picture_settings(self.look.preset.is_none());
        let base = session.as_ref().map_or_else(configured, |s| s.settings().clone());
        let settings = self.look.settings_over(base)?;
        let file = match (&self.file, &session) {
            (Some(file), _) => file.clone(),
            (None, Some(session)) => PathBuf::from(session.file()),
            (None, None) => return Err(Failure::new(Exit::Usage, "neither a model nor --session is given")),
        };
        let size = self.size.or(session.as_ref().map(SessionFile::size)).unwrap_or_else(|| configuration.size());
        let import = session.as_ref().map(SessionFile::import);
        let options = self.import.options(import, configuration.import_options());
        Ok(Asked { args: self, session, file, size, settings, options })
    }
}

impl Asked<'_> {
    /// Loads the scene and says what is seen of it. The importer's notices are said if they are not those that were `said`
    /// last.
    ///
    /// # Errors
    /// [`Exit::Input`] for a file that cannot be read or a session that does not fit it, [`Exit::Usage`] for names that the
    /// command line has wrong.
    pub fn load(self, said: &mut Vec<Notice>, progress: &Progress) -> Result<(Scene, Session), Failure> {
        let Asked { args, session, file, size, settings, options } = self;
        let (scene, _) = load::quietly(&file, &options, progress)?;
        if scene.notices != *said {
            load::say(&file, &scene.notices, progress);
            said.clone_from(&scene.notices);
        }
        if args.import != Default::default() && file.to_str().is_some_and(|f| f.starts_with(BUILTIN)) {
            progress.say(&format!("{}: is generated, so options for reading a model do nothing", load::shown(&file)));
        }
        let path = args.session.as_deref().unwrap_or(Path::new(""));
        let kept = session.map(|s| s.resolve(&scene)).transpose();
        let kept = kept.map_err(|e| Failure::about(Exit::Input, path.display(), &e))?;
        let mut arrangement = kept.as_ref().map_or_else(Arrangement::default, |s| s.arrangement.clone());
        args.parts.apply(&mut arrangement, &scene)?;
        args.sections.apply(&mut arrangement, &scene)?;
        arrangement.check(&scene).map_err(|e| Failure::of(Exit::Usage, &e))?;
        let camera = match &kept {
            Some(session) if args.camera.only_turns() => {
                camera_in_file(&args.camera.turned(camera_in_scene(&session.camera, &scene)), &scene)
            }
            Some(session) if !args.camera.is_given() => session.camera,
            _ => {
                let aspect = f64::from(size[0]) / f64::from(size[1]);
                let bounds = arrangement.framed_bounds(&scene);
                camera_in_file(&args.camera.camera_around(&scene, &bounds, aspect)?, &scene)
            }
        };
        let (file, import) = (file.to_string_lossy().into_owned(), Importing::of(&options));
        Ok((scene, Session { file, size, camera, settings, arrangement, import }))
    }
}

/// Reads a session; relative paths in it count from its folder.
fn read_session(path: &Path) -> Result<SessionFile, Failure> {
    let at = path.display();
    let input = |message: String| Failure::new(Exit::Input, message);
    let text = crate::session::read_text(path).map_err(|e| input(format!("{at}: {e}")))?;
    let session = Session::from_toml(&text).map_err(|e| match e {
        crate::session::SessionError::Syntax { .. } => input(format!("{at}:{e}")),
        _ => input(format!("{at}: {e}")),
    })?;
    Ok(session.rebased(path.parent().unwrap_or(Path::new(""))))
}

/// Checks that a session can name the model.
///
/// # Errors
/// [`Exit::Usage`] for standard input, and for a name that TOML cannot hold.
pub fn check_saved(file: &Path) -> Result<(), Failure> {
    let cause = match file.to_str() {
        Some(STDIN) => "standard input has no name that a session could keep".to_owned(),
        None => format!("{}: the name is not UTF-8, so no session can keep it", file.display()),
        Some(_) => return Ok(()),
    };
    Err(Failure::new(Exit::Usage, format!("--save-session: {cause}")))
}

/// A session as text, with its paths as they count from where it is written.
///
/// # Errors
/// [`Exit::General`] if it cannot be written.
pub fn session_text(session: &Session, scene: &Scene, path: &Path) -> Result<String, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = session.clone().for_folder(folder).and_then(|s| s.to_toml(scene));
    text.map_err(|e| Failure::about(Exit::General, path.display(), &e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    fn view(line: &str) -> Result<(Scene, Session), Failure> {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            view: ViewArgs,
        }
        let words = std::iter::once("test").chain(line.split_whitespace());
        let line = <Line as clap::Parser>::try_parse_from(words).map_err(|e| Failure::new(Exit::Usage, e))?;
        line.view.asked(&Configuration::default())?.load(&mut Vec::new(), &Progress::new())
    }

    fn shot(line: &str) -> Session {
        view(line).unwrap_or_else(|e| panic!("{line}: {e:?}")).1
    }

    #[test]
    fn a_session_stands_for_the_options_that_made_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        let line =
            "builtin:gearbox --size 320x200 --k 7 --explode 0.5 --camera front --orthographic --set opacity.gain=2";
        let (scene, session) = view(line).unwrap();
        std::fs::write(&path, session_text(&session, &scene, &path).unwrap()).unwrap();
        let again = format!("--session {}", path.display());
        assert_eq!(shot(&again), session);
        // Options beside it win.
        let other = shot(&format!("{again} --size 8x8 --explode 0 --set opacity.gain=3"));
        assert_eq!((other.size, other.arrangement.explode), ([8, 8], 0.0));
        assert_eq!((other.settings.opacity.gain, other.settings.capture.bucketed_k_buffer.k), (3.0, 7));
        assert_eq!(other.camera, session.camera);
        let turned = shot(&format!("{again} --camera-azimuth-angle 90"));
        assert!((turned.camera.distance() - session.camera.distance()).abs() < 1e-9);
        assert!((turned.camera.direction() - glam::DVec3::NEG_X).length() < 1e-9);
        let framed = shot(&format!("{again} --camera top"));
        assert!((framed.camera.direction() - glam::DVec3::NEG_Y).length() < 1e-9);
    }

    #[test]
    fn parts_are_named_by_options() {
        let scene = builtin::build("gearbox").unwrap();
        let names = PartNames::new(&scene);
        let (a, b) = (names.path(0).unwrap(), names.path(1).unwrap());
        let quoted = |line: String| {
            #[derive(clap::Parser)]
            struct Line {
                #[command(flatten)]
                view: ViewArgs,
            }
            let words = line.split('|').map(str::to_owned).collect::<Vec<_>>();
            let line = <Line as clap::Parser>::try_parse_from(words).unwrap();
            line.view.asked(&Configuration::default())?.load(&mut Vec::new(), &Progress::new())
        };
        let (_, session) = quoted(format!("test|builtin:gearbox|--isolate|{a}|--hide|{b}|--select|{a}")).unwrap();
        let look = |part: u32| session.arrangement.look(part).presence;
        assert_eq!((look(0), look(1), look(2)), (Presence::Shown, Presence::Hidden, Presence::Ghosted));
        assert_eq!(session.arrangement.selected, BTreeSet::from([0]));
        let e = quoted("test|builtin:gearbox|--ghost|no such part".to_owned()).unwrap_err();
        assert!(
            e.exit == Exit::Usage && e.message.starts_with("--ghost: no part is called 'no such part'; did"),
            "{e:?}"
        );
        assert_eq!(view("builtin:gearbox --explode 5").unwrap_err().exit, Exit::Usage);
    }

    #[test]
    fn looks_of_parts_are_read_as_they_are_meant() {
        let look = |text: &str| own_look(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        let all = look("a/b: c:d:opacity=0.25,color=#ff8000,style=solid");
        assert_eq!((all.part.as_str(), all.opacity, all.style), ("a/b: c:d", Some(0.25), Some(PartStyle::Solid)));
        assert_eq!(all.color, Some([1.0, 128.0 / 255.0, 0.0]));
        let plain = look("x:color=0.1/0.2/1,style=as_set");
        assert_eq!((plain.opacity, plain.color, plain.style), (None, Some([0.1, 0.2, 1.0]), Some(PartStyle::AsSet)));
        for wrong in [
            "x",
            "x:",
            "x:opacity",
            "x:opacity=2",
            "x:color=red",
            "x:color=#ff80",
            "x:color=1/2/3",
            "x:size=1",
            "x:style=own",
        ] {
            assert!(own_look(wrong).is_err(), "{wrong}");
        }
        let session = shot("builtin:quads --part quads:opacity=0.5 --part quads:opacity=1");
        assert!(session.arrangement.parts.is_empty(), "{:?}", session.arrangement);
    }

    #[test]
    fn what_is_wrong_in_a_session_is_said_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        let said = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let e = view(&format!("--session {}", path.display())).unwrap_err();
            assert_eq!(e.exit, Exit::Input, "{e:?}");
            e.message
        };
        let (scene, session) = view("builtin:gearbox").unwrap();
        let text = session_text(&session, &scene, &path).unwrap();
        assert!(said("file = ").contains("s.toml:1:"));
        assert!(said(&text.replace("builtin:gearbox", "gone.glb")).contains("gone.glb"));
        let e = said(&format!("{text}\n[[arrangement.parts]]\npart = 'nothing'\n"));
        assert!(e.contains("s.toml: no part is called 'nothing'"), "{e}");
        let e = view("--session nowhere.toml").unwrap_err();
        assert!(e.exit == Exit::Input && e.message.contains("nowhere.toml"), "{e:?}");
        assert_eq!(view("").unwrap_err().exit, Exit::Usage);
    }
}
