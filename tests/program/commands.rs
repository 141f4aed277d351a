//! Every subcommand through the real binary: exit codes, what goes to standard output and what to standard error, files.

use std::path::Path;

use image::{ColorType, ImageReader};
use pellucid::scene::builtin;
use serde_json::{Value, json};

use super::place::Place;
use super::support::{boxes, glb, gpu, program};

fn size_and_color(png: &[u8]) -> ((u32, u32), ColorType) {
    let picture = ImageReader::with_format(std::io::Cursor::new(png), image::ImageFormat::Png).decode().unwrap();
    ((picture.width(), picture.height()), picture.color())
}

fn picture(path: &Path) -> image::RgbaImage {
    ImageReader::open(path).unwrap().decode().unwrap().into_rgba8()
}

#[test]
fn help_names_commands_environment_and_exit_codes() {
    let place = Place::new();
    let help = place.done("--help");
    assert!(help.err.is_empty());
    for word in [
        "render",
        "plan",
        "inspect",
        "adapters",
        "settings",
        "presets",
        "formats",
        "scenes",
        "transfer",
        "assets",
        "bench",
        "compare",
        "config",
        "completions",
        "man",
        "tradeoff",
        "hard-cases",
    ] {
        assert!(help.text().contains(word), "{word}");
        let own = place.done(&format!("{word} --help"));
        assert!(own.text().contains("Usage: pellucid") && own.err.is_empty());
    }
    for line in [
        "--help",
        "render --help",
        "plan --help",
        "inspect --help",
        "adapters --help",
        "bench --help",
        "tradeoff --help",
        "hard-cases --help",
    ] {
        let text = place.done(line).text();
        let end = text.split("Environment:").nth(1).unwrap_or_else(|| panic!("{line}"));
        for name in ["WGPU_BACKEND", "WGPU_ADAPTER_NAME", "RUST_LOG", "NO_COLOR", "Exit codes:"] {
            assert!(end.contains(name), "{line} does not end with {name}");
        }
    }
    for option in ["--size", "--k", "--preset", "--settings", "--set", "--stats", "--samples", "--compare", "--bits"] {
        assert!(place.done("render --help").text().contains(option), "{option}");
    }
    for option in ["direction", "azimuth-angle", "elevation-angle", "zoom-factor", "focal-point", "position", "view-up"]
    {
        assert!(place.done("plan --help").text().contains(&format!("--camera-{option}")), "{option}");
    }
    assert_eq!(place.done("--version").text(), format!("pellucid {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_wrong_command_line_exits_with_2() {
    let place = Place::new();
    place.fails(2, "paint", &["no such command"]);
    place.fails(2, "paint boxes.glb", &["paint"]);
    place.fails(2, "render boxes.glb", &["--output"]);
    place.fails(2, "render boxes.glb -o a.png --size 10", &["--size", "1920x1080"]);
    place.fails(2, "render boxes.glb -o a.png --bits 12", &["8, 16 or 32"]);
    place.fails(2, "render boxes.glb -o a.png --k 65", &["capture.bucketed_k_buffer.k", "1 to 64"]);
    place.fails(2, "render boxes.glb -o a.png --set opacity.gian=2", &["did you mean 'opacity.gain'"]);
    place.fails(2, "render boxes.glb -o a.png --set opacity.gain", &["PATH=VALUE"]);
    place.fails(2, "render boxes.glb -o a.png --preset papr", &["'papr'", "x-ray", "did you mean 'paper'"]);
    place.fails(2, "render boxes.glb -o a.png --transfer glass", &["'glass'"]);
    place.fails(2, "render boxes.glb -o a.png --background white", &["#rrggbb"]);
    place.fails(2, "render boxes.glb -o a.png --camera nowhere", &["'nowhere'", "isometric"]);
    place.fails(2, "render boxes.glb -o a.png --camera-position 0,0,0 --camera-focal-point 0,0,0", &["coincide"]);
    place.fails(2, "render boxes.glb -o a.jpg", &["a.jpg", ".png"]);
    place.fails(2, "render boxes.glb -o - --stats -", &["standard output"]);
    place.fails(2, "render boxes.glb -o a.png --stats a.png", &["the same file"]);
    place.fails(2, "render builtin:no-such-scene -o a.png", &["no-such-scene", "gearbox"]);
    place.fails(2, "render builtin:gearbx -o a.png", &["did you mean 'gearbox'"]);
    place.fails(2, "boxes.glb render boxes.glb", &["render", "no such command"]);
    place.fails(2, "boxes.glb --no-config render boxes.glb -o a.png", &["boxes.glb", "before the command"]);
    place.fails(2, "bench", &["buckets", "frame", "illustration", "flicker"]);
    assert!(!place.path("a.png").exists() && !place.path("a.jpg").exists());
}

#[test]
fn what_cannot_be_written_exits_with_1() {
    let place = Place::new();
    place.fails(1, "render boxes.glb -o no/such/a.png", &["no/such/a.png"]);
    place.fails(1, "render boxes.glb --stats no/such/a.json", &["no/such/a.json"]);
    std::fs::create_dir(place.path("folder.png")).unwrap();
    place.fails(1, "render boxes.glb -o folder.png", &["folder.png", "is a folder"]);
}

#[test]
fn input_that_cannot_be_read_exits_with_3_and_names_the_file() {
    let place = Place::new();
    let (json, binary) = boxes(1);
    let whole = glb(&json, &binary);
    place.write("short.glb", &whole[..whole.len() - 10]);
    place.write("text.glb", b"solid cube\n");
    place.write("model.step", b"ISO-10303-21;");
    let mut needy = json.clone();
    needy["extensionsRequired"] = json!(["EXAMPLE_other_geometry"]);
    needy["extensionsUsed"] = needy["extensionsRequired"].clone();
    place.write("needy.glb", &glb(&needy, &binary));
    let mut far = json;
    far["accessors"][2]["count"] = json!(3000);
    place.write("far.glb", &glb(&far, &binary));
    for (file, words) in [
        ("missing.glb", &["No such file"] as &[&str]),
        ("short.glb", &["bytes"]),
        ("text.glb", &["glTF"]),
        ("model.step", &["unknown kind", "gmsh"]),
        ("needy.glb", &["EXAMPLE_other_geometry", "not supported"]),
        ("far.glb", &["accessors[2]"]),
    ] {
        for command in ["render -o a.png", "plan", "inspect", "inspect --json"] {
            let words: Vec<&str> = words.iter().copied().chain([file, "pellucid: "]).collect();
            let run = place.fails(3, &format!("{command} {file}"), &words);
            assert_eq!(run.err.lines().count(), 1, "{}", run.err);
        }
    }
    assert!(!place.path("a.png").exists());
}

#[test]
fn broken_settings_and_transfer_functions_exit_with_3_and_name_the_line() {
    let place = Place::new();
    place.write("syntax.toml", b"[opacity]\ngain = \n");
    place.write("range.toml", b"opacity.gain = -3\n");
    place.write("name.toml", b"[opacity]\ngian = 2\n");
    place.write("kappa.toml", b"[color]\npoints = [{ kappa = 0, color = 1 }]\n\n[opacity]\ncurves = 7\n");
    place.write("point.toml", b"[color]\n# far out\npoints = [{ kappa = 2, color = 1 }]\n");
    place.write("uses.toml", b"opacity.transfer = 'point.toml'\n");
    place.fails(3, "render boxes.glb -o a.png --settings syntax.toml", &["syntax.toml:2:"]);
    place.fails(3, "render boxes.glb -o a.png --settings range.toml", &["range.toml", "opacity.gain", "expected"]);
    place.fails(3, "plan boxes.glb --settings name.toml", &["name.toml", "did you mean 'opacity.gain'"]);
    place.fails(3, "render boxes.glb -o a.png --transfer kappa.toml", &["kappa.toml:5:"]);
    place.fails(3, "render boxes.glb -o a.png --transfer point.toml", &["point.toml:3:", "kappa = 2"]);
    place.fails(3, "plan boxes.glb --settings uses.toml", &["point.toml:3:"]);
    place.fails(3, "plan boxes.glb --transfer missing.toml", &["missing.toml"]);
}

#[test]
fn transfer_functions_are_described_and_converted() {
    let place = Place::new();
    let run = place.done("transfer pellucid");
    assert!(run.err.is_empty() && run.text().contains("varies with depth") && run.text().lines().count() <= 40);
    for ending in ["toml", "csv", "json", "xml", "vp", "png", "opacity.png"] {
        let run = place.done(&format!("transfer x-ray -o look.{ending}"));
        assert!(run.out.is_empty());
        let own = ["toml", "csv"].contains(&ending);
        let lines = run.err.lines().all(|l| l.starts_with(&format!("look.{ending}: ")));
        assert!(lines && run.err.is_empty() == own, "{ending}: {}", run.err);
        place.done(&format!("transfer look.{ending}"));
    }
    assert_eq!(place.done("transfer look.csv").text().lines().skip(1).collect::<Vec<_>>(), {
        let text = place.done("transfer look.toml").text();
        text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    });
    let maps = br#"[{"Name":"A","RGBPoints":[0,0,0,0,1,0,0,0]},{"Name":"B","RGBPoints":[0,1,1,1,1,1,1,1]}]"#;
    place.write("maps.json", maps);
    place.done("transfer maps.json --name B -o b.json");
    assert!(std::fs::read_to_string(place.path("b.json")).unwrap().contains("\"B\""));
    place.write("broken.json", b"[\n{\"RGBPoints\": [1, 2]}]");
    place.fails(3, "transfer broken.json", &["broken.json:2:", "groups of 4"]);
    place.fails(3, "transfer maps.json --name C", &["'C'", "'A', 'B'"]);
    place.fails(2, "transfer glass", &["'glass'"]);
    place.fails(2, "transfer x-ray -o look.gif", &["look.gif", ".vp"]);
    place.fails(1, "transfer x-ray -o no/such/a.csv", &["no/such/a.csv"]);
    // Wherever a function is taken, with its notices once.
    if gpu("transfer functions of other programs").is_none() {
        return;
    }
    place.write("uses.toml", b"opacity.transfer = 'maps.json#B'\n");
    for options in ["--transfer maps.json", "--settings uses.toml"] {
        let run = place.done(&format!("render boxes.glb -o a.png --size 32x32 --compare {options}"));
        assert_eq!(run.err.matches("mapped onto kappa").count(), 1, "{options}: {}", run.err);
    }
}

#[test]
fn no_adapter_exits_with_4() {
    let place = Place::new();
    let nothing = [("WGPU_ADAPTER_NAME", "nonexistent")];
    for line in ["render boxes.glb -o a.png", "plan boxes.glb"] {
        let run = place.run_with(line, &nothing);
        assert_eq!(run.code, Some(4), "{}", run.err);
        assert!(run.out.is_empty() && run.err.contains("no graphics adapter answers"), "{}", run.err);
        assert!(run.err.contains("nonexistent"), "{}", run.err);
    }
    // What needs no adapter does not ask for one.
    assert_eq!(place.run_with("inspect boxes.glb", &nothing).code, Some(0));
    assert!(!place.path("a.png").exists());
}

#[test]
fn adapters_are_listed_as_text_and_as_json() {
    if gpu("adapters").is_none() {
        return;
    }
    let place = Place::new();
    assert!(place.done("adapters").text().contains("can be used"));
    let json = place.done("adapters --json").json();
    let adapters = json["adapters"].as_array().unwrap();
    assert!(adapters.iter().any(|a| a["unusable"].is_null()));
    for adapter in adapters {
        assert!(adapter["name"].is_string() && adapter["capabilities"]["max_binding"].is_u64(), "{adapter}");
    }
}

#[test]
fn pictures_go_to_files_and_data_to_standard_output() {
    if gpu("render: outputs").is_none() {
        return;
    }
    let place = Place::new();
    let run = place.done("render boxes.glb -o a.png --size 48x32");
    assert!(run.out.is_empty());
    let line = run.err.lines().last().unwrap();
    assert!(line.contains("boxes.glb") && line.contains("48×32") && line.contains("0 dropped"), "{}", run.err);
    let file = std::fs::read(place.path("a.png")).unwrap();
    assert_eq!(size_and_color(&file), ((48, 32), ColorType::Rgb8));

    let run = place.done("render boxes.glb -o - --size 48x32");
    assert_eq!(run.out, file, "standard output is the file, and nothing else");

    let run = place.done("render boxes.glb --stats - --size 48x32");
    assert_eq!(run.json()["size"], json!([48, 32]));
    // Logs and the colours of logs do not reach data.
    let run = place.run_with("render boxes.glb -o - --size 48x32", &[("RUST_LOG", "debug"), ("CLICOLOR_FORCE", "1")]);
    assert_eq!((run.code, run.out == file), (Some(0), true));
    assert!(run.err.contains("DEBUG") && !run.err.contains('\u{1b}'), "no colours off a terminal");
}

#[test]
fn no_color_is_obeyed() {
    let place = Place::new();
    let colored = place.run_with("render boxes.glb", &[("CLICOLOR_FORCE", "1")]);
    let plain = place.run_with("render boxes.glb", &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]);
    assert!(colored.err.contains('\u{1b}'), "{}", colored.err);
    assert!(!plain.err.contains('\u{1b}'), "{}", plain.err);
    assert_eq!((colored.code, plain.code), (Some(2), Some(2)));
}

#[test]
fn the_books_of_the_statistics_balance() {
    if gpu("render: statistics").is_none() {
        return;
    }
    let place = Place::new();
    for (options, drops) in [("", false), ("--k 64", false), ("--k 2", true), ("--preset paper --k 1", true)] {
        let run = place.done(&format!("render boxes.glb --stats s.json --size 64x64 {options}"));
        let stats: Value = serde_json::from_slice(&std::fs::read(place.path("s.json")).unwrap()).unwrap();
        let frame = &stats["pictures"][0];
        assert_eq!(frame["name"], "picture");
        let count = |name: &str| frame["layers"][name].as_u64().unwrap_or_else(|| panic!("{name}: {frame}"));
        assert_eq!(count("rasterized"), count("stored") + count("merged") + count("dropped"), "{options}");
        assert_eq!((count("lost"), count("dropped") > 0), (0, drops), "{options}");
        assert_eq!(run.err.contains("the deepest pixel has"), drops, "{}", run.err);
        assert!(count("deepest") >= 6 && count("covered") > 500, "{frame}");
        assert!(frame["plan"]["passes"].as_array().is_some_and(|p| p.len() > 5));
        assert!(frame["adapter"]["name"].is_string() && frame["milliseconds"].as_f64().is_some_and(|m| m > 0.0));
    }
}

#[test]
fn backgrounds_and_bits_are_as_asked() {
    if gpu("render: backgrounds and bits").is_none() {
        return;
    }
    let place = Place::new();
    place.done("render boxes.glb -o none.png --size 32x32 --background none");
    let none = picture(&place.path("none.png"));
    assert_eq!(none.get_pixel(0, 0).0, [0, 0, 0, 0]);
    assert!(none.get_pixel(16, 16).0[3] > 100);
    place.done("render boxes.glb -o red.png --size 32x32 --background #ff0000 --bits 16");
    assert_eq!(picture(&place.path("red.png")).get_pixel(0, 0).0, [255, 0, 0, 255]);
    for (options, color) in [
        ("--bits 16", ColorType::Rgb16),
        ("--bits 16 --background none", ColorType::Rgba16),
        ("--background none", ColorType::Rgba8),
    ] {
        let png = place.done(&format!("render boxes.glb -o - --size 32x32 {options}")).out;
        assert_eq!(size_and_color(&png), ((32, 32), color), "{options}");
    }
}

#[test]
fn averaging_frames_softens_edges_and_nothing_else() {
    if gpu("render --samples").is_none() {
        return;
    }
    let place = Place::new();
    let look = "--size 32x32 --preset plain --camera front --background none";
    place.done(&format!("render boxes.glb -o one.png {look}"));
    place.done(&format!("render boxes.glb -o many.png --samples 5 {look}"));
    let (one, many) = (picture(&place.path("one.png")), picture(&place.path("many.png")));
    assert_ne!(one, many);
    assert_eq!(one.get_pixel(0, 0), many.get_pixel(0, 0));
    let [a, b] = [&one, &many].map(|p| p.get_pixel(16, 16).0.map(i32::from));
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 3), "{a:?} and {b:?}");
}

#[test]
fn comparing_puts_three_pictures_side_by_side() {
    if gpu("render --compare").is_none() {
        return;
    }
    let place = Place::new();
    place.done("render boxes.glb -o c.png --compare --size 40x30 --stats c.json --background #ffffff");
    let three = picture(&place.path("c.png"));
    assert_eq!(three.dimensions(), (3 * 40 + 2, 30));
    let stats: Value = serde_json::from_slice(&std::fs::read(place.path("c.json")).unwrap()).unwrap();
    let names: Vec<&str> = stats["pictures"].as_array().unwrap().iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(names, ["plain", "opaque", "as asked"]);
    assert!(stats["timing"].as_str().is_some_and(|t| t.contains("time")));
    let part = |i: u32| image::imageops::crop_imm(&three, i * 41, 0, 40, 30).to_image();
    assert!(part(0) != part(1) && part(1) != part(2) && part(0) != part(2));
    assert!((0..30).all(|y| three.get_pixel(40, y).0 == [255; 4]), "the gap is background");
    // The third is what was asked for.
    place.done("render boxes.glb -o p.png --compare --preset plain --size 40x30 --background #ffffff");
    let plain = picture(&place.path("p.png"));
    assert_eq!(image::imageops::crop_imm(&plain, 82, 0, 40, 30).to_image(), part(0));
}

#[test]
fn references_that_match_differ_or_are_missing() {
    if gpu("render --reference").is_none() {
        return;
    }
    let place = Place::new();
    place.done("render boxes.glb -o r.png --size 32x32");
    place.done("render boxes.glb --reference r.png --threshold 0 --size 32x32");
    let look = "--size 32x32 --opacity opaque";
    place.fails(
        5,
        &format!("render boxes.glb --reference r.png {look}"),
        &["r.png", "mean error above the threshold 0.002"],
    );
    place.fails(5, "render boxes.glb --reference r.png --size 31x32", &["r.png", "31×32", "32×32"]);
    let run = place.run(&format!("render boxes.glb --reference r.png --stats d.json {look}"));
    let stats: Value = serde_json::from_slice(&std::fs::read(place.path("d.json")).unwrap()).unwrap();
    assert_eq!(run.code, Some(5));
    assert!(stats["difference"]["mean"].as_f64().is_some_and(|d| d > 0.002), "statistics are written all the same");
    place.fails(6, "render boxes.glb --reference missing.png --size 32x32", &["missing.png"]);
    place.write("broken.png", b"no picture");
    place.fails(3, "render boxes.glb --reference broken.png --size 32x32", &["broken.png"]);
}

#[test]
fn what_exceeds_the_adapter_exits_with_7_and_says_the_limit() {
    if gpu("render: limits").is_none() {
        return;
    }
    let place = Place::new();
    place.fails(7, "render boxes.glb -o a.png --size 4000000x10", &["4000000x10", "largest"]);
    place.fails(7, "plan boxes.glb --size 10x4000000", &["10x4000000"]);
    assert!(!place.path("a.png").exists());
}

#[test]
fn settings_are_listed_written_and_read_back() {
    let place = Place::new();
    let list = place.done("settings").text();
    for path in ["capture.kind", "capture.bucketed_k_buffer.k", "features.curvature.radius", "image.samples"] {
        assert!(list.contains(path), "{path}");
    }
    assert!(list.contains("from 1 to 64"));
    let toml = place.done("settings --toml");
    place.write("default.toml", &toml.out);
    let presets = place.done("presets").text();
    assert!(["plain", "paper", "pellucid", "x-ray", "murray-6a-7a"].iter().all(|p| presets.contains(p)), "{presets}");
    if gpu("plan: settings").is_none() {
        return;
    }
    let plan = |options: &str| place.done(&format!("plan boxes.glb --json --size 64x64 {options}")).json();
    assert_eq!(plan("--settings default.toml"), plan(""));
    assert_eq!(plan("--set capture.kind=bucketed_k_buffer --set capture.bucketed_k_buffer.k=5"), plan("--k 5"));
    assert_eq!(plan("--k 5")["capture"]["k"], 5);
    assert_eq!(plan("--preset paper")["capture"]["key"], "packed32");
    assert_eq!(plan("--preset opaque")["capture"]["kind"], "none");
    assert_eq!(plan("--preset plain")["features"], Value::Null);
    assert_eq!(plan("--samples 4")["samples"], 4);
    place.write("own.toml", b"[capture]\nkind = 'bucketed_k_buffer'\nbucketed_k_buffer.k = 7\n");
    assert_eq!(plan("--settings own.toml")["capture"]["k"], 7);
    assert_eq!(plan("--settings own.toml --k 9")["capture"]["k"], 9, "options outrank files");
    place.write(
        "tf.toml",
        b"[color]\npoints = [{ kappa = 0, color = 0.5 }]\n[opacity]\ncurves = [{ depth = 0, points = [[0, 0.5]] }]\n",
    );
    assert_eq!(plan("--transfer tf.toml")["features"]["curvature"], false, "constant functions need no curvature");
    assert_eq!(plan("--transfer tf.toml --opacity curvature")["features"], Value::Null, "nor neighbours");
}

#[test]
fn a_plan_says_what_runs_and_why() {
    if gpu("plan").is_none() {
        return;
    }
    let place = Place::new();
    let text = place.done("plan boxes.glb --size 64x64").text();
    for words in ["64x64", "curvature", "a transfer function varies with curvature", "not needed", "total", "one band"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let banded = place.done("plan boxes.glb --size 2000x2000 --opacity curvature --k 64 --json").json();
    assert!(banded["bands"].as_array().is_some_and(|b| b.len() > 1));
}

#[test]
fn cameras_are_where_they_are_put() {
    if gpu("render: cameras").is_none() {
        return;
    }
    let place = Place::new();
    let shot = |options: &str| place.done(&format!("render boxes.glb -o - --size 32x32 {options}")).out;
    let usual = shot("");
    assert_eq!(shot("--camera three-quarter"), usual);
    assert_ne!(shot("--camera front"), usual);
    assert_eq!(shot("--camera-direction 0,0,-1"), shot("--camera front"));
    assert_eq!(shot("--camera front --camera-azimuth-angle 0"), shot("--camera front"));
    assert_ne!(shot("--camera front --camera-azimuth-angle 20"), shot("--camera front"));
    assert_ne!(shot("--orthographic"), usual);
    assert_ne!(shot("--camera-zoom-factor 1.5"), usual);
    assert_ne!(shot("--camera-position 0,0,6"), usual);
}

#[test]
fn inspecting_tells_parts_materials_and_notices() {
    let place = Place::new();
    let run = place.done("inspect boxes.glb");
    let text = run.text();
    for words in
        ["3 parts of 1 mesh", "36 triangles", "size    2 × 2 × 2", "box 0: part 0", "box 2", "'steel' of 3 parts"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let json = place.done("inspect boxes.glb --json").json();
    assert_eq!((&json["triangles"], json["parts"].as_array().unwrap().len()), (&json!(36), 3));
    assert_eq!(json["bounds"]["max"], json!([1.0, 1.0, 1.0]));
    assert_eq!(json["materials"][0]["name"], "steel");
    assert!(json["notices"].is_array());

    // What the importer leaves out is said on standard error too, so that standard output can be piped.
    let (mut animated, binary) = boxes(1);
    animated["extensionsUsed"] = json!(["KHR_materials_sheen"]);
    animated["materials"][0]["extensions"] = json!({ "KHR_materials_sheen": {} });
    place.write("sheen.glb", &glb(&animated, &binary));
    let run = place.done("inspect sheen.glb --json");
    assert!(run.err.contains("sheen.glb: ") && run.err.contains("KHR_materials_sheen"), "{}", run.err);
    assert!(run.json()["notices"].to_string().contains("KHR_materials_sheen"));
}

#[test]
fn built_in_scenes_work_wherever_a_file_does() {
    let names: Vec<&str> = builtin::names().iter().map(|b| b.name).collect();
    let place = Place::new();
    let listed = place.done("scenes").text();
    for name in &names {
        assert!(listed.contains(&format!("builtin:{name}")), "{listed}");
        let json = place.done(&format!("inspect builtin:{name} --json")).json();
        assert!(json["triangles"].as_u64().is_some_and(|t| t > 0), "{name}");
    }
    place.fails(2, "inspect builtin:no-such-scene", &[names[0]]);
    if gpu("built-in scenes: rendering").is_none() {
        return;
    }
    for name in &names {
        let png = place.done(&format!("render builtin:{name} -o - --size 40x40")).out;
        assert_eq!(size_and_color(&png).0, (40, 40), "{name}");
    }
    std::fs::create_dir(place.path("assets")).unwrap();
    let listed = place.done("assets assets").text();
    let written: Vec<_> = std::fs::read_dir(place.path("assets")).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(!written.is_empty() && listed.lines().count() == written.len(), "{listed}");
    for file in written.iter().filter_map(|p| p.file_name()?.to_str()) {
        place.done(&format!("inspect assets/{file}"));
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let place = Place::new();
    let mut child = program()
        .current_dir(place.folder.path())
        .arg("settings")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
    // Nor one of messages: the code is that of the failure.
    let mut child = program()
        .current_dir(place.folder.path())
        .args(["inspect", "nothing-there.glb"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(3));
}
