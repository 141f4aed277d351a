//! `pellucid tradeoff` through the real binary: the report's files, and limits for continuous integration.

use std::path::PathBuf;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use super::support::{boxes, glb, gpu, program};

/// A folder with a model of three boxes.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        let (json, binary) = boxes(3);
        std::fs::write(place.path("boxes.glb"), glb(&json, &binary)).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// Exit code, standard output and standard error.
    fn run(&self, line: &str) -> (Option<i32>, String, String) {
        let mut command = program();
        command.current_dir(self.0.path()).args(line.split_whitespace());
        let Output { status, stdout, stderr } = command.output().unwrap();
        (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
    }

    fn exits(&self, code: i32, line: &str, words: &[&str]) {
        let (found, out, err) = self.run(line);
        assert_eq!(found, Some(code), "{line}: {err}");
        assert!(out.is_empty(), "{line}: data goes to files: {out}");
        let last = err.lines().last().unwrap_or_default();
        assert!(words.iter().all(|w| last.contains(w)), "{line}: {words:?} in {err}");
    }
}

#[test]
fn a_report_is_three_files_that_agree() {
    if gpu("tradeoff").is_none() {
        return;
    }
    let place = Place::new();
    let line = "tradeoff boxes.glb -o out/report --size 48x40 --axes capture,k,key,normals,neighbours,samples";
    place.exits(0, &format!("{line} --limit-seconds 60"), &["boxes.glb", "configurations", "index.html"]);
    let csv = place.read("out/report/sweep.csv");
    let json: Value = serde_json::from_str(&place.read("out/report/sweep.json")).unwrap();
    let html = place.read("out/report/index.html");
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(csv.lines().count(), 1 + rows.len());
    assert!(rows.len() > 10 && json["adapter"]["name"].as_str().is_some_and(|n| !n.is_empty()));
    let row = |name: &str| {
        rows.iter().find(|r| r["configuration"] == name).unwrap_or_else(|| panic!("{name}: {csv}"))["measured"].clone()
    };
    // With normals in full, what was asked for is the reference; the search by brute force finds the same neighbours as that
    // by buckets.
    for name in ["normals=full", "as asked", "neighbours=brute_force"] {
        let measured = row(name);
        for error in ["maximum", "mean", "flip_mean"] {
            let found = measured["image"][error].as_f64().unwrap();
            assert!(found <= if name == "normals=full" { 0.0 } else { 0.2 }, "{name}: {error} is {found}");
        }
        if name != "normals=full" {
            assert_eq!(measured["image"], row("as asked")["image"], "{name}");
        }
        assert_eq!((&measured["layers"]["lost"], &measured["layers"]["out_of_order"]), (&0.into(), &0.into()));
        assert_eq!(measured["layers"]["neighbours_different"], 0.0, "{name}");
    }
    // Three boxes are six layers: four are too few, eight are enough.
    let four = row("capture=bucketed_k_buffer, key=wide64, k=4");
    assert!(four["layers"]["lost"].as_u64().is_some_and(|n| n > 0) && four["image"]["maximum"].as_f64() > Some(1.0));
    assert_eq!(four["layers"]["lost"], four["counts"]["dropped"], "as the GPU counted");
    let eight = row("capture=bucketed_k_buffer, key=wide64, k=8");
    assert_eq!((&eight["layers"]["lost"], &eight["image"]), (&0.into(), &row("as asked")["image"]));
    assert!(row("normals=xy15")["image"]["mean"].as_f64() > Some(0.0));
    assert!(row("samples=1")["image"]["mean"].as_f64() > row("samples=4")["image"]["mean"].as_f64(), "aliasing");
    let times = &row("as asked")["times"];
    assert!(
        times["samples"].as_array().is_some_and(|s| !s.is_empty()) && times["whole"]["median"].as_f64() > Some(0.0)
    );
    assert!(times["passes"].to_string().contains("curvature"));
    assert!(html.contains("In words") && html.matches("<svg").count() == 4 && !html.contains("http"));
}

#[test]
fn limits_fail_on_errors() {
    if gpu("tradeoff --check").is_none() {
        return;
    }
    let place = Place::new();
    let write = |text: &str| std::fs::write(place.path("limits.toml"), text).unwrap();
    let line = "tradeoff boxes.glb --size 32x32 --axes k,normals --check limits.toml";
    write("['as asked']\nmaximum_steps = 1\nlost = 0\n['k=8']\nmaximum_steps = 1\n");
    place.exits(0, line, &["limits.toml", "3 figures checked, 0 over"]);
    write("['as asked']\nmaximum_steps = 1\n['k=4']\nlost = 3\n");
    place.exits(5, line, &["limits.toml", "k=4", "lost", "limit 3"]);
    write("['as asked']\ntime_ms = 3\n");
    place.exits(3, line, &["limits.toml", "time_ms"]);
    write("['k=5']\nlost = 3\n");
    place.exits(3, line, &["limits.toml", "k=5"]);
    write("['as asked']\n");
    place.exits(3, line, &["limits.toml", "no limit is given"]);
    // A check that compares nothing is no success.
    write("['*']\nlost = 0\n");
    let away = format!("{line} --camera-position 100,0,0 --camera-focal-point 200,0,0");
    place.exits(3, &away, &["limits.toml", "nothing is in view"]);
    assert_eq!(std::fs::read_dir(place.0.path()).unwrap().count(), 2, "without --output nothing is written");
}

#[test]
fn wrong_command_lines_and_files_are_refused_before_any_work() {
    let place = Place::new();
    place.exits(2, "tradeoff boxes.glb -o out --axes colour", &["colour", "normals"]);
    place.exits(2, "tradeoff boxes.glb -o -", &["folder"]);
    place.exits(1, "tradeoff missing.glb -o boxes.glb/out", &["boxes.glb/out"]);
    place.exits(3, "tradeoff boxes.glb --check missing.toml", &["missing.toml"]);
    place.exits(3, "tradeoff missing.glb -o out", &["missing.glb"]);
    let (code, _, err) = place.run("tradeoff boxes.glb");
    assert_eq!(code, Some(2), "{err}");
}
