//! `pellucid hard-cases` through the real binary, and the table in the README.

use std::process::Output;

use pellucid::tradeoff::hard_cases;
use serde_json::Value;

use super::support::{gpu, program, repository};

fn run(line: &str) -> Output {
    program().arg("hard-cases").args(line.split_whitespace()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn cases_are_listed_without_an_adapter() {
    let list = run("--list");
    assert_eq!(list.status.code(), Some(0));
    for (technique, case) in hard_cases::all() {
        let heading = format!("{} ({technique})\n    {}\n", case.name, case.why);
        assert!(text(&list.stdout).contains(&heading), "{heading}");
    }
    let json: Value = serde_json::from_slice(&run("--list --json t0").stdout).unwrap();
    let names: Vec<&str> = json.as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert!(names.len() > 10 && names.iter().all(|n| n.starts_with("t0")), "{names:?}");
}

#[test]
fn names_that_no_case_has_are_usage_and_no_adapter_is_said() {
    let unknown = run("t01 t77");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("'t77'") && unknown.stdout.is_empty());
    let none = program().args(["hard-cases", "t01"]).env("WGPU_ADAPTER_NAME", "nonexistent").output().unwrap();
    assert_eq!(none.status.code(), Some(4), "{}", text(&none.stderr));
}

/// How far a figure may lie from the one in the README: a share of it. Bounds are equal.
const TOLERANCE: f64 = 0.1;

/// Figures at which rounding is all there is.
const ROUNDING: f64 = 1e-3;

fn number(cell: &str) -> Option<f64> {
    let end = cell.find([' ', '°', '/', '*']).unwrap_or(cell.len());
    cell[..end].parse().ok()
}

fn same(printed: &str, found: &str) -> bool {
    match (number(printed), number(found)) {
        (Some(a), Some(b)) => (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()) || a.abs().max(b.abs()) < ROUNDING,
        _ => printed == found,
    }
}

fn rows(table: &str) -> Vec<Vec<String>> {
    let lines = table.lines().skip_while(|l| !l.starts_with("| case |")).take_while(|l| l.starts_with('|')).skip(2);
    lines.map(|l| l.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect()).collect()
}

/// All cases pass on the adapter of continuous integration, none is skipped, and the README says what they give.
#[test]
fn the_table_in_the_readme_is_true() {
    let Some(gpu) = gpu("hard-cases: the table in the README") else { return };
    let found = run("--markdown");
    assert_eq!(found.status.code(), Some(0), "{}{}", text(&found.stdout), text(&found.stderr));
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let (printed, found) = (rows(&readme), rows(&text(&found.stdout)));
    assert!(found.iter().all(|row| row[5] == "passed"), "{found:?}");
    if !gpu.facts().name.contains("llvmpipe") {
        println!("SKIPPED: the README has the figures of lavapipe");
        return;
    }
    let names = |rows: &[Vec<String>]| {
        rows.iter().map(|r| (r[0].clone(), r[1].clone(), r[4].clone(), r[5].clone())).collect::<Vec<_>>()
    };
    assert_eq!(names(&printed), names(&found), "`pellucid hard-cases --markdown` prints the table anew");
    for (printed, found) in printed.iter().zip(&found) {
        assert!((2..4).all(|i| same(&printed[i], &found[i])), "README: {printed:?}, now {found:?}");
    }
}

#[test]
fn results_are_data() {
    if gpu("hard-cases --json").is_none() {
        return;
    }
    let found = run("t01 t09 --json");
    assert_eq!(found.status.code(), Some(0));
    let json: Value = serde_json::from_slice(&found.stdout).unwrap();
    assert!(json["adapter"]["name"].is_string());
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2);
    for case in cases {
        let [ours, bound, printed] =
            [&case["ours"], &case["bound"], &case["contrast"]["figure"]].map(|v| v.as_f64().unwrap());
        assert!(ours <= bound && printed > bound && case["verdict"] == "passed" && case["samples"].as_u64() > Some(0));
    }
    assert!(text(&run("t01 --ours-only").stdout).contains("1 passed, 0 failed, 0 skipped"));
}
