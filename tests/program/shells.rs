//! Completions and manual pages through the real binary.

use super::place::Place;

/// The commands, as the help lists them.
fn commands(place: &Place) -> Vec<String> {
    let help = place.done("--help").text();
    let list = help.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let word = |line: &str| {
        let name = line.strip_prefix("  ").filter(|l| !l.starts_with(' '))?.split_whitespace().next()?;
        Some(name.to_owned())
    };
    list.lines().filter_map(word).filter(|name| name != "help").collect()
}

#[test]
fn completions_name_every_command() {
    let place = Place::new();
    let names = commands(&place);
    assert!(names.len() > 15 && names.contains(&"compare".to_owned()), "{names:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = place.done(&format!("completions {shell}")).text();
        for name in &names {
            assert!(script.contains(name.as_str()), "{shell}: {name}");
        }
        assert!(script.contains("pellucid") && script.contains("no-config"), "{shell}");
    }
    place.fails(2, "completions tcsh", &["tcsh", "fish"]);
    place.write("c.bash", &place.done("completions bash").out);
    // Where there is a bash, it takes the script.
    if let Ok(run) = std::process::Command::new("bash").arg("-n").arg(place.path("c.bash")).output() {
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    }
}

#[test]
fn there_is_a_page_for_every_command() {
    let place = Place::new();
    let page = place.done("man").text();
    assert!(page.contains(".TH pellucid 1"), "{}", page.lines().take(5).collect::<Vec<_>>().join("\n"));
    let listed = place.done("man -o pages/deep").text();
    for name in commands(&place) {
        assert!(page.replace('\\', "").contains(&format!("pellucid-{name}(1)")), "{name}");
        let file = place.path(&format!("pages/deep/pellucid-{name}.1"));
        assert!(std::fs::read_to_string(&file).unwrap().contains(".SH NAME"), "{name}");
        assert!(listed.contains(&format!("pellucid-{name}.1")));
    }
    assert!(place.path("pages/deep/pellucid-bench-frame.1").exists());
    place.write("file", b"");
    place.fails(1, "man -o file/pages", &["file/pages"]);
}
