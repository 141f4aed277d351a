//! What is seen, as a command for a shell.
//!
//! Settings and camera only: an arrangement of parts, and transfer functions that are in no file, have no options and need a
//! session file. The camera is written to the last digit, but angles go through degrees, so a session is what reproduces a
//! picture bit for bit.

use glam::DVec3;

use super::document::Document;
use super::loader::{HARD_CASE, MADE_IN_MEMORY};
use crate::math::views::VIEW_ANGLE;
use crate::math::{Camera, Projection};
use crate::scene::Arrangement;
use crate::session::camera_in_file;
use crate::settings::Settings;

/// The command that renders what is seen in a picture of this size.
///
/// # Errors
/// A sentence where no options say it.
pub fn of(document: &Document, size: [u32; 2]) -> Result<String, String> {
    let seen = &document.seen;
    if seen.arrangement != Arrangement::default() {
        return Err("Parts, sections and the exploded view have no options: save a session instead.".to_owned());
    }
    if document.file.starts_with(HARD_CASE) {
        return Err(MADE_IN_MEMORY.to_owned());
    }
    let mut words = vec!["pellucid".to_owned(), "render".to_owned(), quoted(&document.file)];
    words.extend(["-o".to_owned(), "picture.png".to_owned()]);
    words.push(format!("--size {}x{}", size[0], size[1]));
    words.extend(camera_options(&camera_in_file(&seen.camera, &document.scene)));
    let defaults = Settings::default();
    for declaration in Settings::declarations() {
        let value = seen.settings.get(&declaration.path);
        if value == defaults.get(&declaration.path) {
            continue;
        }
        let text = match value {
            Some(toml::Value::String(text)) => text,
            Some(toml::Value::Table(_)) | None => {
                return Err(format!("{} is in no file: save a session instead.", declaration.path));
            }
            Some(other) => other.to_string(),
        };
        words.push(format!("--set {}", quoted(&format!("{}={text}", declaration.path))));
    }
    Ok(words.join(" "))
}

fn camera_options(camera: &Camera) -> Vec<String> {
    let point = |p: DVec3| format!("{},{},{}", p.x, p.y, p.z);
    let mut words = vec![
        format!("--camera-position {}", point(camera.position)),
        format!("--camera-focal-point {}", point(camera.focal_point)),
        format!("--camera-view-up {}", point(camera.view_up)),
    ];
    let fov_y = match camera.projection {
        Projection::Perspective { fov_y } => fov_y,
        Projection::Orthographic { height } => {
            words.push("--orthographic".to_owned());
            2.0 * (height * 0.5 / camera.distance()).atan()
        }
    };
    if (fov_y.to_degrees() - VIEW_ANGLE).abs() > 1e-12 {
        words.push(format!("--camera-view-angle {}", fov_y.to_degrees()));
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
    use crate::scene::builtin;

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
        let line = of(&document, [640, 480]).unwrap();
        for piece in [
            "pellucid render 'my file.glb' -o picture.png --size 640x480",
            "--orthographic",
            "--set capture.bucketed_k_buffer.k=24",
            "--set 'image.background=#102030'",
        ] {
            assert!(line.contains(piece), "{line}");
        }
        assert_eq!(line.matches("--set").count(), 2);
        document.seen.arrangement.explode = 1.0;
        assert!(of(&document, [640, 480]).unwrap_err().contains("session"));
    }
}
