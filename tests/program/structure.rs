//! The order of dependencies among the rooms of `src/`, and the length of files.

use std::path::{Path, PathBuf};

use super::support::repository;

/// The rooms. Each may use those before it, and itself.
const ROOMS: &[&str] = &[
    "math", "scene", "transfer", "import", "settings", "session", "plan", "oracle", "gpu", "passes", "render",
    "export", "tradeoff", "app", "cli",
];

/// Rooms that must be usable without a GPU: nothing in them names these.
const WITHOUT_GPU: &[&str] =
    &["math", "scene", "transfer", "import", "settings", "session", "plan", "oracle", "export"];
const GPU_CRATES: &[&str] = &["wgpu::", "naga::", "egui", "winit"];

const MOST_LINES: usize = 600;

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.to_string_lossy().ends_with(ending) {
                all.push(path);
            }
        }
    }
    all.sort();
    all
}

/// A line without its comment. A string that holds `//` loses its end, which no check here minds.
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or_default()
}

/// The rooms that a text names: after `crate::`, in `crate::{…}`, and by as many `super::` as lead out of the room.
/// `depth` is the number of modules from the crate down to the text's own, so 1 for `src/room/mod.rs`.
fn rooms_named(text: &str, depth: usize) -> Vec<(usize, String)> {
    let mut named = Vec::new();
    let first_word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut inner = 0;
    let mut group = false;
    for (number, line) in text.lines().enumerate().map(|(n, l)| (n + 1, code(l))) {
        // An inline module lies one deeper, between its lines at the margin.
        if line.starts_with("mod ") || line.starts_with("pub mod ") {
            inner = usize::from(line.trim_end().ends_with('{'));
        } else if line.starts_with('}') {
            inner = 0;
        }
        let climb = "super::".repeat(depth + inner);
        let mut rest = line;
        while let Some((at, prefix)) =
            ["crate::", climb.as_str()].iter().filter_map(|p| Some((rest.find(p)?, p.len()))).min()
        {
            rest = &rest[at + prefix..];
            if rest.starts_with('{') {
                group = true;
            } else {
                named.push((number, first_word(rest)));
            }
        }
        if group {
            // The members of `use crate::{…}`: a word at the beginning or after a comma at the outermost level.
            let mut level = 0;
            let mut word = String::new();
            for c in rest.chars() {
                match c {
                    '{' => level += 1,
                    '}' => level -= 1,
                    _ => {}
                }
                if c.is_alphanumeric() || c == '_' {
                    word.push(c);
                } else {
                    if level <= 1 && c == ':' && ROOMS.contains(&word.as_str()) {
                        named.push((number, word.clone()));
                    }
                    word.clear();
                }
            }
            group = !line.contains(';');
        }
    }
    named
}

#[test]
fn rooms_use_only_rooms_before_them() {
    let source = repository().join("src");
    let place = |room: &str| ROOMS.iter().position(|r| *r == room);
    let mut faults = Vec::new();
    let mut seen = 0;
    for file in files(&source, ".rs") {
        let path = file.strip_prefix(&source).unwrap();
        let parts: Vec<String> = path.iter().map(|p| p.to_string_lossy().replace(".rs", "")).collect();
        let room = parts[0].as_str();
        if ["main", "lib"].contains(&room) {
            continue;
        }
        let Some(own) = place(room) else {
            faults.push(format!("src/{}: '{room}' is no room; the design names them", path.display()));
            continue;
        };
        let depth = parts.iter().filter(|p| *p != "mod").count();
        let text = std::fs::read_to_string(&file).unwrap();
        for (line, used) in rooms_named(&text, depth) {
            seen += 1;
            match place(&used) {
                Some(other) if other <= own => {}
                Some(_) => faults.push(format!("src/{}:{line}: {room} uses {used}, a later room", path.display())),
                None => faults.push(format!("src/{}:{line}: '{used}' is no room", path.display())),
            }
        }
        if WITHOUT_GPU.contains(&room) {
            let program = text.lines().take_while(|l| !l.starts_with("#[cfg(test)]"));
            for (line, code) in program.map(code).enumerate() {
                if let Some(name) = GPU_CRATES.iter().find(|c| code.contains(**c)) {
                    faults.push(format!("src/{}:{}: {room} names {name}", path.display(), line + 1));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen > 100, "only {seen} uses were found: the search is broken");
}

#[test]
fn uses_are_found_however_they_are_written() {
    let names = |text: &str, depth| rooms_named(text, depth).into_iter().map(|(_, n)| n).collect::<Vec<_>>();
    assert_eq!(
        names("use crate::plan::Pass;\nlet x = crate::math::Camera::new(crate::gpu::Gpu);", 1),
        ["plan", "math", "gpu"]
    );
    assert_eq!(names("use crate::{\n    gpu::{Gpu, shaders::Spec},\n    plan::Pass,\n};\n", 1), ["gpu", "plan"]);
    assert_eq!(names("use super::plan;", 1), ["plan"]);
    assert_eq!(names("use super::plan;", 2), [] as [&str; 0]);
    assert_eq!(names("use super::super::plan;", 2), ["plan"]);
    assert_eq!(names("mod tests {\n    use super::*;\n    use super::super::cli;\n}\n", 1), ["cli"]);
    assert_eq!(names("// crate::cli\n//! [`crate::cli`]", 1), [] as [&str; 0]);
}

#[test]
fn no_file_is_longer_than_two_rooms() {
    let root = repository();
    let mut long = Vec::new();
    for (folder, ending) in [("src", ".rs"), ("shaders", ".wgsl"), ("tests", ".rs"), ("benches", ".rs")] {
        for file in files(&root.join(folder), ending) {
            let lines = std::fs::read_to_string(&file).unwrap().lines().count();
            if lines > MOST_LINES {
                long.push(format!("{}: {lines} lines", file.strip_prefix(&root).unwrap().display()));
            }
        }
    }
    assert!(long.is_empty(), "over {MOST_LINES} lines:\n{}", long.join("\n"));
}

/// The tests in a text: name and body.
fn tests_in(text: &str) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for part in text.split("#[test]\n").skip(1) {
        let Some((head, rest)) = part.trim_start().strip_prefix("fn ").and_then(|p| p.split_once("()")) else {
            continue;
        };
        let body = rest.split("\n}").next().unwrap_or_default();
        all.push((head.to_owned(), body.to_owned()));
    }
    all
}

/// A panel that no test operates by what a screen reader reads fails here: one of them has to have its name in its own.
#[test]
fn every_panel_is_operated_by_a_test_of_its_name() {
    let panels = repository().join("src/app/panels");
    let mut texts = vec![panels.join("tests.rs"), panels.join("planes_tests.rs"), panels.join("settings_tests.rs")];
    texts.push(repository().join("src/app/accuracy/tests.rs"));
    texts.extend(files(&panels.join("tests"), ".rs"));
    let tests: Vec<(String, String)> = texts
        .iter()
        .flat_map(|file| tests_in(&std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))))
        .filter(|(_, body)| ["get_by_", "get_all_by_", "click(", "choose("].iter().any(|call| body.contains(call)))
        .collect();
    let mut count = 0;
    for entry in std::fs::read_dir(&panels).unwrap().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(panel) = name.strip_suffix(".rs").filter(|p| *p != "mod" && !p.ends_with("tests")) else {
            continue;
        };
        let named = tests.iter().any(|(test, _)| test.split('_').any(|word| word == panel));
        assert!(named, "no test in src/app/panels/tests is named after the panel '{panel}'");
        count += 1;
    }
    assert!(count >= 14 && tests.len() >= count, "{count} panels, {} tests: the search is broken", tests.len());
}
