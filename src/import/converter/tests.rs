//! Converters made of standard tools, and the one that the advice names, where it is installed.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::*;
use crate::import::{ImportError, Limits, load_bytes_with, load_with};
use crate::scene::Scene;

const STL: &[u8] =
    b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                     endsolid";
/// A model of no known kind.
const STRANGE: &[u8] = b"ISO-10303-21; of no kind that is read";

fn options(command: &str) -> ImportOptions {
    ImportOptions { converters: BTreeMap::from([("step".to_owned(), command.to_owned())]), ..ImportOptions::default() }
}

fn convert_file(content: &[u8], options: &ImportOptions) -> Result<Scene, ImportError> {
    let folder = tempfile::tempdir().expect("a folder");
    // Blanks and quotes in names are the business of nobody.
    let path = folder.path().join("it's a $(model) {in}.STEP");
    std::fs::write(&path, content).expect("written");
    load_with(&path, options)
}

fn failure(command: &str) -> String {
    let error = convert_file(STRANGE, &options(command)).expect_err(command);
    assert!(matches!(error, ImportError::Converter { .. }), "{error}");
    error.to_string()
}

#[test]
fn an_unknown_kind_says_what_to_configure() {
    for (name, part) in [
        ("a.step", "step = \"gmsh {in} -2 -clcurv 20 -format stl -o {out.stl}\", with Debian's package gmsh"),
        ("a.fbx", "fbx = \"assimp export {in} {out}\", with Debian's package assimp-utils"),
        ("a.usd", "usd = \"PROGRAM {in} {out}\""),
        ("a", "step = "),
        ("a.b c", "\"b c\" = "),
    ] {
        let error = load_bytes_with(STRANGE, name, None, &ImportOptions::default()).expect_err(name);
        assert!(error.to_string().contains(part) && error.to_string().contains("[converters]"), "{error}");
        assert!(matches!(error, ImportError::UnknownKind { .. }));
    }
}

#[test]
fn words_are_split_as_by_a_shell_and_files_put_into_their_places() {
    let split = |command: &str| words(command, Path::new("/a b.step"), Path::new("/t"));
    let text = |command: &str| {
        let (words, output) = split(command).expect(command);
        (words.into_iter().map(|w| w.into_string().expect("text")).collect::<Vec<_>>(), output)
    };
    let (line, output) = text("conv 'two words' --from={in} {x} {out.stl} $HOME | x\\ y");
    assert_eq!(line, ["conv", "two words", "--from=/a b.step", "{x}", "/t/out.stl", "$HOME", "|", "x y"]);
    assert_eq!(output, Path::new("/t/out.stl"));
    assert_eq!(text("c {in} {out}").1, Path::new("/t/out.glb"));
    assert_eq!(text("c {in} {out:obj} {out.obj}").1, Path::new("/t/out.obj"));
    for (bad, cause) in [
        ("c {in}", "no {out}"),
        ("c {out}", "no {in}"),
        ("c 'x", "quote"),
        ("c {in} {out.exe}", "is one of"),
        ("c {in} {out} {out.stl}", "different kinds"),
        ("", "has no {in}"),
    ] {
        assert!(split(bad).expect_err(bad).contains(cause), "{bad}");
    }
}

#[cfg(unix)]
#[test]
fn what_a_program_writes_is_read() {
    let scene = convert_file(STL, &options("cp {in} {out.stl}"));
    // By its content it is an STL, so nothing is converted.
    assert!(scene.expect("a scene").notices.iter().all(|n| !n.message.contains("converted")));
    // Such as can be known by nothing: behind three bytes that `tail` takes away again.
    let hidden = [b"???", STL].concat();
    let command = "dd if={in} of={out.stl} bs=1 skip=3";
    let scene = convert_file(&hidden, &options(command)).expect("a scene");
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(scene.notices[0].message, format!("the file was converted to STL by '{command}'"));
    assert_eq!(scene.name, "it's a $(model) {in}", "named after the file, not the output");
    // And from memory.
    let scene = load_bytes_with(&hidden, "x.step", None, &options(command)).expect("a scene");
    assert_eq!(scene.triangle_count(), 1);
}

#[cfg(unix)]
#[test]
fn failures_name_the_command_and_the_cause() {
    assert!(failure("no-such-program {in} {out}").ends_with("there is no program 'no-such-program'"));
    assert!(failure("false {in} {out}").ends_with("ended with code 1"));
    let said = failure("sh -c 'echo the reason; exit 3' {in} {out}");
    assert!(said.ends_with("ended with code 3: the reason"), "what it says on standard output: {said}");
    assert!(failure("true {in} {out.ply}").ends_with("ended well and wrote no out.ply"));
    assert!(failure("cp {in} {out}").contains("what it wrote cannot be read"));
    let said = failure("ls --no-such-option {in} {out}");
    assert!(said.contains("ended with code 2: "), "{said}");
    assert!(failure("c 'x {in} {out}").contains("a quote that does not end"));
}

#[cfg(unix)]
#[test]
fn a_program_that_does_not_end_is_ended() {
    let begin = Instant::now();
    let limits = Limits { converter_seconds: 1, ..Limits::default() };
    // The second is a child of the program, which holds its standard error.
    let options = ImportOptions { limits, ..options("") };
    for command in ["tail -f {in} --retry {out}", "nice timeout 50 tail -f {in} --retry {out}"] {
        let error = convert_file(STRANGE, &options_with(&options, command)).expect_err("ended");
        assert!(error.to_string().contains("took longer than 1 s"), "{error}");
    }
    assert!(begin.elapsed() < Duration::from_secs(8), "{:?}", begin.elapsed());

    let called_off = options_with(&options, "tail -f {in} --retry {out}");
    let cancel = called_off.cancel.clone();
    std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        cancel.cancel();
    });
    let error = convert_file(STRANGE, &called_off).expect_err("called off");
    assert!(matches!(error, ImportError::Cancelled { .. }), "{error}");

    let limits = Limits { bytes: 1000, converter_seconds: 20, ..Limits::default() };
    // Of two inputs dd takes the last.
    let much = ImportOptions { limits, ..options_with(&options, "dd if={in} if=/dev/zero of={out} bs=64k") };
    let error = convert_file(STRANGE, &much).expect_err("too much");
    assert!(error.to_string().contains("wrote more than 1000 bytes"), "{error}");
}

fn options_with(options: &ImportOptions, command: &str) -> ImportOptions {
    ImportOptions {
        converters: BTreeMap::from([("step".to_owned(), command.to_owned())]),
        cancel: crate::import::Cancel::default(),
        ..options.clone()
    }
}

/// The line that the advice gives for STEP, on a box with a hole that the same program writes.
#[test]
fn the_advice_for_step_works() {
    if Command::new("gmsh").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err() {
        println!("SKIPPED: converting STEP: there is no program gmsh");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (script, step) = (folder.path().join("part.geo"), folder.path().join("part.step"));
    let geometry = format!(
        "SetFactory(\"OpenCASCADE\");\nBox(1) = {{0, 0, 0, 4, 3, 2}};\nCylinder(2) = {{2, 1.5, -1, 0, 0, 4, 0.75}};\n\
         BooleanDifference(3) = {{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }};\nSave \"{}\";\n",
        step.display()
    );
    std::fs::write(&script, geometry).expect("written");
    let made = Command::new("gmsh").arg(&script).arg("-0").stdout(Stdio::null()).status().expect("gmsh runs");
    assert!(made.success() && step.is_file(), "gmsh wrote no STEP file");
    let advice = advice("step");
    let command = advice.split('"').nth(1).expect("a command line");
    let scene = load_with(&step, &options(command)).expect("a scene");
    let size = scene.bounds().size();
    assert!((size - glam::DVec3::new(4.0, 3.0, 2.0)).length() < 1e-3, "{size}");
    assert!(scene.triangle_count() > 50, "{}", scene.triangle_count());
    assert_eq!(scene.parts.len(), 1, "{}", scene.partition);
    // The hole is one.
    let volume: f64 = scene.meshes[0].primitives[0]
        .triangles
        .iter()
        .map(|t| {
            let p = &scene.meshes[0].primitives[0].positions;
            let [a, b, c] = t.map(|v| glam::Vec3::from(p[v as usize]).as_dvec3());
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    let expected = 24.0 - 2.0 * std::f64::consts::PI * 0.75 * 0.75;
    assert!((volume.abs() - expected).abs() < 0.2, "{volume} instead of {expected}");
}
