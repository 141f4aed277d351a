//! How models are read, through the real binary: standard input, limits, phases, names that are no text, sessions that
//! remember it.

use std::io::Write;
use std::process::Stdio;

use serde_json::json;

use super::place::{Place, Run};
use super::support::{boxes, glb, gpu, program};

/// Runs the program with bytes on its standard input.
fn with_input(place: &Place, line: &str, input: &[u8]) -> Run {
    let mut child = program()
        .current_dir(place.folder.path())
        .args(line.split_whitespace())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // It may stop reading before the end.
    let _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    Run { code: output.status.code(), out: output.stdout, err: String::from_utf8(output.stderr).unwrap() }
}

#[test]
fn a_model_is_read_from_standard_input() {
    let place = Place::new();
    let (json, binary) = boxes(3);
    let bytes = glb(&json, &binary);
    let run = with_input(&place, "inspect - --json", &bytes);
    assert_eq!((run.code, run.json()["triangles"].as_u64()), (Some(0), Some(36)), "{}", run.err);
    let run = with_input(&place, "inspect - --limit bytes=1k", &bytes);
    assert_eq!(run.code, Some(3));
    assert!(run.err.starts_with("pellucid: standard input: ") && run.err.contains("1024"), "{}", run.err);
    let run = with_input(&place, "inspect -", b"nothing of the kind");
    assert_eq!(run.code, Some(3));
    assert!(run.err.starts_with("pellucid: standard input: ") && run.err.lines().count() == 1, "{}", run.err);
    let run = with_input(&place, "render - --save-session s.toml", &bytes);
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("standard input has no name"), "{}", run.err);
    if gpu("render from standard input").is_some() {
        let piped = with_input(&place, "render - -o - --size 24x24", &bytes);
        assert_eq!(piped.code, Some(0), "{}", piped.err);
        assert!(piped.err.contains("standard input: 24×24"), "{}", piped.err);
        assert!(piped.out == place.done("render boxes.glb -o - --size 24x24").out);
    }
}

#[test]
fn limits_refuse_and_are_named() {
    let place = Place::new();
    place.done("inspect boxes.glb --limit triangles=36 --limit bytes=64k");
    for command in ["inspect boxes.glb", "plan boxes.glb", "render boxes.glb -o a.png", "tradeoff boxes.glb -o d"] {
        for limit in ["bytes=100", "triangles=11", "node_depth=0"] {
            place.fails(3, &format!("{command} --limit {limit}"), &["boxes.glb"]);
        }
    }
    place.fails(2, "inspect boxes.glb --limit bites=1", &["did you mean 'bytes'", "image_side"]);
    place.fails(2, "inspect boxes.glb --parts wheel", &["auto, node, material, component, file"]);
    place.fails(2, "inspect boxes.glb --crease-angle 181", &["0 to 180"]);
    place.done("inspect boxes.glb --parts node --crease-angle 40");
}

#[test]
fn inspecting_tells_how_long_it_took() {
    let place = Place::new();
    let text = place.done("inspect boxes.glb").text();
    let time = text.split("\ntime\n").nth(1).unwrap();
    assert!(time.lines().last().unwrap().trim_start().starts_with("all "), "{text}");
    let times = place.done("inspect boxes.glb --json").json()["times"].clone();
    let all = times["milliseconds"].as_f64().unwrap();
    let sum: f64 = times["phases"].as_array().unwrap().iter().map(|p| p["milliseconds"].as_f64().unwrap()).sum();
    assert!(all > 0.0 && sum <= all + 1e-6, "{times}");
}

#[test]
fn sessions_keep_how_the_model_was_read() {
    let place = Place::new();
    let line = "render boxes.glb --parts node --crease-angle 12.5 --hide box~2 --save-session s.toml";
    place.done_words(&line.split(' ').map(|w| w.replace('~', " ")).collect::<Vec<_>>());
    let text = std::fs::read_to_string(place.path("s.toml")).unwrap();
    assert!(text.contains("[import]\nparts = \"node\"\ncrease_angle = 12.5\n"), "{text}");
    place.done("render --session s.toml --save-session t.toml");
    assert_eq!(std::fs::read_to_string(place.path("t.toml")).unwrap(), text);
    place.done("render --session s.toml --crease-angle 30 --parts auto --save-session u.toml");
    assert!(!std::fs::read_to_string(place.path("u.toml")).unwrap().contains("[import]"));
    // A configuration does not change what a session shows.
    place.write("c.toml", b"[import]\nparts = 'file'\ncrease_angle = 99\n[settings]\nopacity.gain = 3\n");
    place.done("render --session s.toml --config c.toml --save-session v.toml");
    assert_eq!(std::fs::read_to_string(place.path("v.toml")).unwrap(), text);
    place.write("w.toml", text.replace("12.5", "-1").as_bytes());
    place.fails(3, "render --session w.toml --save-session x.toml", &["w.toml", "import.crease_angle"]);
    place.write("w.toml", text.replace("\"node\"", "\"nodes\"").as_bytes());
    place.fails(3, "render --session w.toml --save-session x.toml", &["w.toml", "did you mean 'node'"]);
}

#[test]
fn errors_are_one_line_that_names_file_place_and_cause() {
    let place = Place::new();
    let (mut json, binary) = boxes(1);
    json["accessors"][2]["count"] = json!(3000);
    json["nodes"][0]["name"] = json!("two\nlines\u{1b}[31m");
    place.write("far.glb", &glb(&json, &binary));
    let run = place.fails(3, "inspect far.glb", &["pellucid: far.glb: accessors[2]"]);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    assert!(!run.err.contains('\u{1b}'));
    let run = place.fails(2, "render boxes.glb -o a.png --hide bx~0", &["did you mean"]);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
}

/// Names of files are bytes on Linux; what is no UTF-8 is read and written all the same.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_names() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new();
    let name = OsStr::from_bytes(b"caf\xe9.glb");
    std::fs::copy(place.path("boxes.glb"), place.folder.path().join(name)).unwrap();
    let run = |words: &[&OsStr]| program().current_dir(place.folder.path()).args(words).output().unwrap();
    let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
    let inspected = run(&[OsStr::new("inspect"), name]);
    assert_eq!(inspected.status.code(), Some(0), "{}", String::from_utf8_lossy(&inspected.stderr));
    let refused = run(&[OsStr::new("render"), name, OsStr::new("--save-session"), OsStr::new("s.toml")]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("not UTF-8"));
    if gpu("names that are no text").is_some() {
        let target = OsStr::from_bytes(b"\xff.png");
        let rest = words("--size 16x16 -o");
        let line: Vec<&OsStr> = [OsStr::new("render"), name]
            .into_iter()
            .chain(rest.iter().map(OsString::as_os_str))
            .chain([target])
            .collect();
        let rendered = run(&line);
        assert_eq!(rendered.status.code(), Some(0), "{}", String::from_utf8_lossy(&rendered.stderr));
        assert!(place.folder.path().join(target).exists());
        assert_eq!(run(&[OsStr::new("plan"), name]).status.code(), Some(0));
    }
}
