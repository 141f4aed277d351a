//! Sessions through the real binary: what `--save-session` writes, `--session` renders again bit for bit.

use std::path::Path;
use std::process::Output;

use serde_json::{Value, json};

use super::support::{boxes, full, glb, gpu, program};

fn run(folder: &Path, words: &[&str]) -> Output {
    program().current_dir(folder).args(words).output().unwrap()
}

fn done(folder: &Path, words: &[&str]) -> Output {
    let output = run(folder, words);
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn fails(folder: &Path, code: i32, words: &[&str]) -> String {
    let output = run(folder, words);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
    said
}

/// Three boxes, far from the origin: the scene is re-based.
fn far_boxes() -> Vec<u8> {
    let (mut model, binary) = boxes(3);
    let nodes = model["nodes"].as_array_mut().unwrap();
    let root = nodes.len();
    for (i, node) in nodes.iter_mut().enumerate() {
        // Beside each other, so that there is something to move apart.
        node["translation"] = json!([0.9 * i as f64, 0.0, 0.2]);
        node["name"] = json!(["outer", "middle", "inner"][i.min(2)]);
    }
    nodes.push(json!({ "name": "all", "children": [0, 1, 2], "translation": [1.0e6 + 1.0 / 3.0, 7.7, -3.0e5] }));
    for scene in model["scenes"].as_array_mut().into_iter().flatten() {
        scene["nodes"] = json!([root]);
    }
    glb(&model, &binary)
}

#[test]
fn a_saved_session_gives_the_same_picture_bit_for_bit() {
    if gpu("sessions").is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    std::fs::create_dir_all(folder.join("models")).unwrap();
    std::fs::create_dir_all(folder.join("work")).unwrap();
    std::fs::write(folder.join("models/far.glb"), far_boxes()).unwrap();
    let cases: [&[&str]; 4] = [
        &["models/far.glb", "--ghost", "outer", "--select", "inner", "--explode", "0.7"],
        &[
            "models/far.glb",
            "--isolate",
            "all/middle",
            "--orthographic",
            "--camera",
            "top",
            "--set",
            "opacity.ghost=0.5",
        ],
        &["models/far.glb", "--k", "4", "--hide", "outer", "--camera-azimuth-angle", "33", "--set", "opacity.gain=1.7"],
        &["builtin:gearbox", "--explode", "0.4", "--opacity", "constant", "--set", "opacity.constant=0.3333"],
    ];
    for (i, options) in cases.iter().enumerate() {
        let common = ["--size", "90x70", "--bits", "16"];
        let direct: Vec<&str> = ["render"]
            .iter()
            .chain(*options)
            .chain(&common)
            .chain(&["-o", "a.png", "--save-session", "models/s.toml"])
            .copied()
            .collect();
        done(folder, &direct);
        let a = std::fs::read(folder.join("a.png")).unwrap();
        // From another folder, and from a session that was saved from the session.
        done(&folder.join("work"), &["render", "--session", "../models/s.toml", "--bits", "16", "-o", "b.png"]);
        assert!(a == std::fs::read(folder.join("work/b.png")).unwrap(), "case {i}: the session's picture differs");
        done(&folder.join("work"), &["render", "--session", "../models/s.toml", "--save-session", "t.toml"]);
        done(folder, &["render", "--session", "work/t.toml", "--bits", "16", "-o", "c.png"]);
        assert!(a == std::fs::read(folder.join("c.png")).unwrap(), "case {i}: the second session's picture differs");
        let text = std::fs::read_to_string(folder.join("models/s.toml")).unwrap();
        assert!(text.contains("file = \"far.glb\"") || text.contains("file = \"builtin:gearbox\""), "{text}");
        // Without its looks it is another picture.
        done(folder, &["render", options[0], "--size", "90x70", "--bits", "16", "-o", "d.png"]);
        assert!(a != std::fs::read(folder.join("d.png")).unwrap(), "case {i}: the options do nothing");
        let plan = done(folder, &["plan", "--session", "models/s.toml", "--json"]).stdout;
        let plan: Value = serde_json::from_slice(&plan).unwrap();
        assert_eq!(plan["size"], json!([90, 70]));
    }
}

#[test]
fn what_is_wrong_is_said() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    std::fs::write(folder.join("far.glb"), far_boxes()).unwrap();
    let said = fails(folder, 2, &["render", "far.glb", "-o", "a.png", "--hide", "outre"]);
    assert!(said.contains("--hide: no part is called 'outre'; did you mean 'all/outer'?"), "{said}");
    let said = fails(folder, 2, &["render", "far.glb", "-o", "-", "--save-session", "-"]);
    assert!(said.contains("--output and --save-session cannot both go to standard output"), "{said}");
    let said = fails(folder, 2, &["render", "far.glb", "-o", "a.png", "--set", "image.background=blue"]);
    assert!(said.contains("image.background = \"blue\": expected none or the form #rrggbb"), "{said}");
    let said = fails(folder, 2, &["render", "far.glb", "-o", "a.png", "--set", "outline.color=gold"]);
    assert!(said.contains("outline.color = \"gold\": expected the form #rrggbb"), "{said}");
    assert!(!folder.join("a.png").exists());
    // No adapter is needed to save a session, to standard output too.
    let text = done(folder, &["render", "far.glb", "--ghost", "inner", "--save-session", "-"]).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("part = \"all/inner\"") && text.contains("presence = \"ghosted\""), "{text}");
    std::fs::write(folder.join("s.toml"), text.replace("all/inner", "all/iner")).unwrap();
    let said = fails(folder, 3, &["plan", "--session", "s.toml"]);
    assert!(said.contains("s.toml: no part is called 'all/iner'; did you mean 'all/inner'?"), "{said}");
}

/// What the window saves and what `--set` says of the same setting give the same bytes.
#[test]
fn settings_render_alike_from_the_window_and_from_the_command_line() {
    use std::sync::Arc;

    use pellucid::app::camera;
    use pellucid::app::config::Preferences;
    use pellucid::app::document::{Document, Seen};
    use pellucid::app::workspace::Workspace;
    use pellucid::scene::{Arrangement, builtin};
    use pellucid::session::{Session, camera_in_scene};
    use pellucid::settings::Settings;

    if !full() || gpu("settings both ways").is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let scene = Arc::new(builtin::build("stack").unwrap());
    for (i, declaration) in Settings::declarations().iter().enumerate().filter(|(i, _)| i % 3 == 0) {
        let set = format!("{}={}", declaration.path, declaration.another());
        let words = ["render", "builtin:stack", "--size", "96x72", "--set", &set, "-o", "line.png"];
        done(folder, &[&words[..], &["--save-session", "line.toml"]].concat());
        // The same camera under the window's hand.
        let text = std::fs::read_to_string(folder.join("line.toml")).unwrap();
        let kept = Session::from_toml(&text).and_then(|s| s.resolve(&scene)).unwrap();
        let mut workspace = Workspace::new(Preferences::default());
        workspace.viewport.size = [96, 72];
        let seen = Seen {
            settings: Settings::default(),
            camera: camera_in_scene(&kept.camera, &scene),
            arrangement: Arrangement::default(),
        };
        assert!(camera::is_sound(&seen.camera));
        let mut document = Document::new("builtin:stack".to_owned(), Arc::clone(&scene), seen);
        document.seen.settings.set(&declaration.path, &declaration.another()).unwrap();
        workspace.document = Some(document);
        std::fs::write(folder.join("window.toml"), workspace.session(folder).unwrap()).unwrap();
        done(folder, &["render", "--session", "window.toml", "-o", "window.png"]);
        let [a, b] = ["line.png", "window.png"].map(|name| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{i}: {set}");
    }
}
