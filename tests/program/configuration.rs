//! Configuration files through the real binary: which counts more, what is wrong in them, and what never changes.

use super::place::Place;
use super::support::gpu;

const FILE: &str = "pellucid/config.toml";

/// A folder with configurations of the system and of the user.
fn configured(system: &str, user: &str) -> Place {
    let place = Place::new();
    for (folder, text) in [("xdg", system), ("home", user)] {
        std::fs::create_dir_all(place.path(folder).join("pellucid")).unwrap();
        std::fs::write(place.path(folder).join(FILE), text).unwrap();
    }
    place
}

impl Place {
    fn with_files(&self, line: &str, named: &str) -> super::place::Run {
        let [system, user] = ["xdg", "home"].map(|f| self.path(f).display().to_string());
        let all =
            [("XDG_CONFIG_DIRS", system.as_str()), ("XDG_CONFIG_HOME", user.as_str()), ("PELLUCID_CONFIG", named)];
        self.run_with(line, &all)
    }
}

#[test]
fn the_named_counts_more_than_the_users_and_that_more_than_the_systems() {
    let place = configured(
        "[settings]\nopacity.gain = 2\nopacity.constant = 0.7\nlight.key = 3\n",
        "[settings]\nopacity.gain = 3\nlight.key = 4\n[render]\nsize = '31x32'\n[converters]\nstep = 'convert {in} {out}'\n",
    );
    place.write("named.toml", b"settings.light.key = 5\n[import]\nlimits.bytes = '1G'\n");
    let run = place.with_files("config", "named.toml");
    assert_eq!(run.code, Some(0), "{}", run.err);
    let text = run.text();
    let said = |line: &str| assert!(text.lines().any(|l| l == line), "{line}: {text}");
    said(&format!("settings.opacity.constant = 0.7  # {}:3", place.path("xdg").join(FILE).display()));
    said(&format!("settings.opacity.gain = 3  # {}:2", place.path("home").join(FILE).display()));
    said("settings.light.key = 5  # named.toml:1");
    said("settings.light.fill = 0.7  # built in");
    said("import.limits.bytes = \"1G\"  # named.toml:3");
    said(&format!("render.size = \"31x32\"  # {}:5", place.path("home").join(FILE).display()));
    assert!(text.contains("named.toml: read") && text.contains("step = \"convert {in} {out}\""), "{text}");
    // An option counts more than the variable, and none of them if none is wanted.
    let option = place.with_files("config --config named.toml", "missing.toml").text();
    assert!(option.contains("settings.light.key = 5"), "{option}");
    let none = place.with_files("config --no-config", "named.toml").text();
    assert!(none.contains("settings.opacity.gain = 1.0  # built in") && !none.contains("converters"), "{none}");
    // What is printed can be read.
    place.write("printed.toml", &run.out);
    let again = place.done("config --config printed.toml").text();
    assert!(again.contains("settings.light.key = 5  # printed.toml:"), "{again}");
}

#[test]
fn what_is_wrong_in_a_file_exits_with_3_and_names_the_line() {
    let place = configured("", "[settings]\n\nopacity.gian = 2\n");
    let run = place.with_files("inspect boxes.glb", "");
    assert_eq!(run.code, Some(3));
    let path = place.path("home").join(FILE).display().to_string();
    let expected = format!("pellucid: {path}:3: no setting is called 'opacity.gian'; did you mean 'opacity.gain'?\n");
    assert_eq!(run.err, expected);
    assert_eq!(place.with_files("inspect boxes.glb --no-config", "").code, Some(0));
    place.fails(3, "config --config missing.toml", &["missing.toml"]);
    for (text, words) in [
        ("[render]\nsise = 3", "did you mean 'render.size'"),
        ("[importt]\nparts = 'file'", "did you mean [import]"),
        ("[import]\nparts = 'wheel'", "component"),
        ("[import.limits]\nbytes = 'lots'", "4G"),
        ("[converters]\nstep = 'convert'", "{in} and {out}"),
        ("[settings\n", "wrong.toml:1: "),
    ] {
        place.write("wrong.toml", text.as_bytes());
        place.fails(3, "config --config wrong.toml", &["wrong.toml:", words]);
    }
    place.fails(2, "config --config a.toml --no-config", &["--no-config"]);
}

#[test]
fn pictures_and_imports_follow_it_and_options_count_more() {
    let place = configured("", "");
    place.write("limits.toml", b"[import]\nlimits.triangles = 11\n");
    place.fails(3, "inspect boxes.glb --config limits.toml", &["boxes.glb", "11"]);
    place.done("inspect boxes.glb --config limits.toml --limit triangles=36");
    if gpu("configuration: pictures").is_none() {
        return;
    }
    place.write(
        "c.toml",
        b"[settings]\nopacity.gain = 0.5\n[render]\nsize = '24x20'\nsamples = 2\nbackground = '#ffffff'\nbits = 16\npreset = 'curvature'\n",
    );
    let same = |configured: &str, plain: &str| {
        let a = place.done(&format!("render boxes.glb -o - --config c.toml {configured}")).out;
        let b = place.done(&format!("render boxes.glb -o - {plain}")).out;
        assert!(a == b, "{configured}: {plain}");
    };
    let all = "--size 24x20 --samples 2 --background #ffffff --bits 16 --set opacity.gain=0.5";
    same("", &format!("{all} --preset curvature"));
    // Another preset takes the place of the configured one; a single option that of a single value.
    same("--preset x-ray", &format!("{all} --preset x-ray"));
    same(
        "--size 16x16 --bits 8 --set opacity.gain=1",
        "--size 16x16 --samples 2 --background #ffffff --preset curvature",
    );
    // A settings file and a session say everything, so the configuration says nothing.
    place.write("all.toml", b"opacity.constant = 0.4\n");
    same("--settings all.toml --size 16x16 --bits 8", "--settings all.toml --size 16x16");
    place.done("render boxes.glb --size 18x16 --save-session s.toml");
    let a = place.done("render --session s.toml -o - --bits 8 --config c.toml").out;
    assert!(a == place.done("render --session s.toml -o -").out);
}
