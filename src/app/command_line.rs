//! What is seen, as a command for a shell.
//!
//! Everything has an option but transfer functions that are in no file: for those a session is needed, or a file that they are
//! exported to. Parts are named by path, or by their group where all of it is meant. The camera is written to the last digit,
//! but angles go through degrees and a parallel view through the angle that shows as much, so a session is what reproduces a
//! picture bit for bit.

use std::collections::BTreeSet;

use glam::DVec3;

use super::document::Document;
use super::loader::{HARD_CASE, MADE_IN_MEMORY};
use crate::math::views::VIEW_ANGLE;
use crate::math::{Camera, Projection};
use crate::scene::{Arrangement, PartStyle, Presence, Scene, Section};
use crate::session::configuration::Configuration;
use crate::session::{PartNames, camera_in_file};
use crate::settings::Settings;

/// The command that renders what is seen in a picture of this size, whether or not `configuration` is there.
///
/// # Errors
/// A sentence where no options say it.
pub fn of(document: &Document, configuration: &Configuration, size: [u32; 2]) -> Result<String, String> {
    let words: Vec<String> = words(document, configuration, size)?.iter().map(|word| quoted(word)).collect();
    Ok(words.join(" "))
}

/// The same as the words that the program gets, its own name first.
///
/// # Errors
/// As [`of`].
pub fn words(document: &Document, configuration: &Configuration, size: [u32; 2]) -> Result<Vec<String>, String> {
    let seen = &document.seen;
    if document.file.starts_with(HARD_CASE) {
        return Err(MADE_IN_MEMORY.to_owned());
    }
    // A name must not be taken for an option.
    let file = if document.file.starts_with('-') { format!("./{}", document.file) } else { document.file.clone() };
    let mut words = ["pellucid", "render", &file, "-o", "picture.png"].map(str::to_owned).to_vec();
    words.extend(["--size".to_owned(), format!("{}x{}", size[0], size[1])]);
    words.extend(camera_options(&camera_in_file(&seen.camera, &document.scene)));
    words.extend(arrangement_options(&seen.arrangement, &document.scene));
    for (option, value) in document.import.words(&configuration.importing()) {
        words.push(format!("--{option}={value}"));
    }
    let (defaults, configured) = (Settings::default(), configuration.picture_settings(true));
    for declaration in Settings::declarations() {
        let value = seen.settings.get(&declaration.path);
        if value == defaults.get(&declaration.path) && value == configured.get(&declaration.path) {
            continue;
        }
        let text = match value {
            Some(toml::Value::String(text)) => text,
            Some(toml::Value::Table(_)) | None => {
                return Err(
                    "The transfer functions are in no file, and no option holds them: export them and use that file, \
                            or save a session."
                        .to_owned(),
                );
            }
            Some(other) => other.to_string(),
        };
        words.extend(["--set".to_owned(), format!("{}={text}", declaration.path)]);
    }
    Ok(words)
}

/// How the parts are shown, as options.
fn arrangement_options(arrangement: &Arrangement, scene: &Scene) -> Vec<String> {
    let mut words = Vec::new();
    let mut say = |option: &str, value: &str| words.push(format!("--{option}={value}"));
    if !(arrangement.parts.is_empty() && arrangement.selected.is_empty()) {
        let names = PartNames::new(scene);
        let all = 0..scene.parts.len() as u32;
        let having =
            |presence| all.clone().filter(|&p| arrangement.look(p).presence == presence).collect::<BTreeSet<u32>>();
        let [shown, ghosted, hidden] =
            [Presence::Shown, Presence::Ghosted, Presence::Hidden].map(|p| names.said(&having(p)));
        // Whichever is shorter. What is isolated must be something.
        if shown.is_empty() || ghosted.len() <= shown.len() {
            ghosted.iter().for_each(|name| say("ghost", name));
        } else {
            shown.iter().for_each(|name| say("isolate", name));
        }
        hidden.iter().for_each(|name| say("hide", name));
        for (look, parts) in same_looks(arrangement) {
            names.said(&parts).iter().for_each(|name| say("part", &format!("{name}:{look}")));
        }
        names.said(&arrangement.selected).iter().for_each(|name| say("select", name));
    }
    if arrangement.explode != 0.0 {
        say("explode", &arrangement.explode.to_string());
    }
    let open = !arrangement.sections.is_empty() && arrangement.sections.iter().all(|s| !s.caps);
    arrangement.sections.iter().for_each(|s| say("section", &plane(s, open)));
    if open {
        words.push("--no-caps".to_owned());
    }
    words
}

/// Parts by what `--part` says of them; those of which it says nothing are left out.
fn same_looks(arrangement: &Arrangement) -> Vec<(String, BTreeSet<u32>)> {
    let mut all: Vec<(String, BTreeSet<u32>)> = Vec::new();
    for (&part, look) in &arrangement.parts {
        let mut said = Vec::new();
        if look.opacity != 1.0 {
            said.push(format!("opacity={}", look.opacity));
        }
        if let Some(color) = look.color {
            let bytes = color.map(|c| (c * 255.0).round() as u8);
            // A byte holds less than a number.
            said.push(if bytes.map(|b| f64::from(b) / 255.0) == color {
                format!("color=#{:02x}{:02x}{:02x}", bytes[0], bytes[1], bytes[2])
            } else {
                format!("color={}/{}/{}", color[0], color[1], color[2])
            });
        }
        if look.style == PartStyle::Solid {
            said.push("style=solid".to_owned());
        }
        let said = said.join(",");
        match all.iter_mut().find(|(known, _)| *known == said) {
            _ if said.is_empty() => {}
            Some((_, parts)) => {
                parts.insert(part);
            }
            None => all.push((said, BTreeSet::from([part]))),
        }
    }
    all
}

/// A plane as `--section` takes it; `open` if another option says that there are no caps.
fn plane(section: &Section, open: bool) -> String {
    let axes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
    let along = axes.iter().find(|(_, axis)| *axis == section.normal);
    let against = axes.iter().find(|(_, axis)| -*axis == section.normal);
    let n = section.normal;
    let mut text = match (along, against) {
        (Some((axis, _)), _) => format!("{axis}={}", section.offset),
        (_, Some((axis, _))) => format!("-{axis}={}", -section.offset),
        _ => format!("{},{},{},{}", n.x, n.y, n.z, section.offset),
    };
    if !section.caps && !open {
        text += ":open";
    }
    if !section.enabled {
        text += ":off";
    }
    text
}

fn camera_options(camera: &Camera) -> Vec<String> {
    let point = |p: DVec3| format!("{},{},{}", p.x, p.y, p.z);
    let mut words = Vec::new();
    for (option, value) in
        [("position", camera.position), ("focal-point", camera.focal_point), ("view-up", camera.view_up)]
    {
        words.extend([format!("--camera-{option}"), point(value)]);
    }
    let fov_y = match camera.projection {
        Projection::Perspective { fov_y } => fov_y,
        Projection::Orthographic { height } => {
            words.push("--orthographic".to_owned());
            2.0 * (height * 0.5 / camera.distance()).atan()
        }
    };
    if (fov_y.to_degrees() - VIEW_ANGLE).abs() > 1e-12 {
        words.extend(["--camera-view-angle".to_owned(), fov_y.to_degrees().to_string()]);
    }
    words
}

/// A word as a POSIX shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::camera;
    use crate::app::document::Seen;
    use crate::scene::{PartLook, builtin};

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a.glb"), "a.glb");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("image.background=#fff"), "'image.background=#fff'");
    }

    #[test]
    fn changed_settings_and_the_camera_are_named() {
        let scene = Arc::new(builtin::build("quads").unwrap());
        let camera = camera::other_projection(&camera::first(&scene.bounds(), 1.5));
        let mut settings = Settings::default();
        settings.set("capture.bucketed_k_buffer.k", "24").unwrap();
        settings.image.background = "#102030".to_owned();
        let seen = Seen { settings, camera, arrangement: Arrangement::default() };
        let mut document = Document::new("my file.glb".to_owned(), scene, seen);
        let plain = Configuration::default();
        let line = of(&document, &plain, [640, 480]).unwrap();
        for piece in [
            "pellucid render 'my file.glb' -o picture.png --size 640x480",
            "--orthographic",
            "--set capture.bucketed_k_buffer.k=24",
            "--set 'image.background=#102030'",
        ] {
            assert!(line.contains(piece), "{line}");
        }
        assert_eq!(line.matches("--set").count(), 2);
        let arrangement = &mut document.seen.arrangement;
        arrangement.explode = 1.0;
        arrangement.sections = vec![Section { normal: -DVec3::Y, offset: -0.25, enabled: true, caps: false }];
        arrangement.parts.insert(0, PartLook { opacity: 0.5, color: Some([1.0, 0.0, 0.2]), ..PartLook::default() });
        document.import.parts = Some(crate::import::PartsBy::Component);
        document.import.variant = Some("midnight blue".to_owned());
        let line = of(&document, &plain, [640, 480]).unwrap();
        assert!(line.contains("--parts=component '--variant=midnight blue'"), "{line}");
        for piece in ["--explode=1 ", "--section=-y=0.25 --no-caps", ":opacity=0.5,color=#ff0033'"] {
            assert!(line.contains(piece), "{line}");
        }
        let edited = Box::new(crate::transfer::TransferFunction::uniform(0.5));
        document.seen.settings.opacity.transfer = crate::transfer::TransferSource::Inline(edited);
        assert!(of(&document, &plain, [640, 480]).unwrap_err().contains("session"));
    }
}
