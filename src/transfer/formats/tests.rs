use super::scalar_map::{Space, between};
use super::*;
use crate::transfer::names;

/// Round trips through a format of straight pieces, over κ and |κ|.
const ROUND_TRIP: f64 = 1e-3;

fn preset(name: &str) -> TransferFunction {
    TransferSource::Named(name.to_owned()).resolve(None).unwrap()
}

fn good(text: &str, path: &str) -> Imported {
    read(text.as_bytes(), path, None).unwrap_or_else(|e| panic!("{e}"))
}

fn bad(text: &str, path: &str) -> String {
    let e = read(text.as_bytes(), path, None).unwrap_err().to_string();
    assert!(!e.contains('\n'), "{e}");
    e
}

fn near(a: &[f64], b: &[f64], by: f64) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= by), "{a:?}, not {b:?}");
}

const JSON: &str = r#"[
  {
    "ColorSpace" : "RGB", "Name" : "Cold", "NanColor" : [ 1, 1, 0 ],
    "RGBPoints" : [ 0, 0, 0.5, 1,   5, 1, 1, 1,   10, 1, 0, 0 ],
    "Points" : [ 0, 0.1, 0.5, 0,   10, 0.9, 0.5, 0 ]
  },
  { "Name" : "Rainbow", "ColorSpace" : "HSV", "RGBPoints" : [ -1, 0, 0, 1, 1, 1, 0, 0 ] },
  { "Name" : "Bands", "IndexedColors" : [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ] }
]"#;

const XML: &str = r#"<ColorMaps>
  <ColorMap name="Ramp" space="RGB">
    <Point x="0" o="0.2" r="0" g="0" b="0"/>
    <Point x="4" o="0.8" r="1" g="0.5" b="0"/>
    <NaN r="1" g="0" b="0"/>
  </ColorMap>
  <ColorMap name="Grey" space="Lab"><Point x="-1" r="0" g="0" b="0"/><Point x="1" r="1" g="1" b="1"/></ColorMap>
</ColorMaps>
"#;

const VP: &str = "1\n1\n0.9\n0.1\n0.2\n10\n6 -1000 0 0 0.25 1000 1\n4 0 0.5 255 1\n8 -1000 0 0 0 1000 1 0.5 0\n";

const CSV: &str =
    "# a comment\n kappa , R, g,b # another\n-1,0,0,0\n1, 1,0.5 ,0\n\ndepth,kappa,opacity\n0,0,0.1\n0,1,0.9\n1,0,0.5\n";

#[test]
fn paraview_json_is_read_by_name_or_the_first() {
    let Imported { function, notices } = good(JSON, "m.json");
    near(&function.color.sample(-0.5), &[0.5, 0.75, 1.0], 1e-12);
    near(&[function.opacity.sample(0.3, 0.5)], &[0.5], 1e-12);
    let all = notices.join("\n");
    for word in ["'Rainbow', 'Bands'", "NanColor", "colour over 0 to 10 mapped onto kappa", "opacity over 0 to 10"] {
        assert!(all.contains(word), "{word}: {all}");
    }
    let rainbow = read(JSON.as_bytes(), "m.json", Some("Rainbow")).unwrap();
    near(&rainbow.function.color.sample(0.0), &[0.0, 1.0, 0.0], 1e-3);
    near(&rainbow.function.color.sample(-0.25), &[0.0, 1.0, 0.5], 1e-3);
    assert_eq!(rainbow.function.opacity, preset("pellucid").opacity);
    assert!(rainbow.notices.iter().any(|n| n.contains("no opacity")), "{:?}", rainbow.notices);
    let bands = read(JSON.as_bytes(), "m.json", Some("Bands")).unwrap().function.color;
    for (kappa, rgb) in
        [(-1.0, [1.0, 0.0, 0.0]), (-0.34, [1.0, 0.0, 0.0]), (0.0, [0.0, 1.0, 0.0]), (0.5, [0.0, 0.0, 1.0])]
    {
        assert_eq!(bands.sample(kappa), rgb, "{kappa}");
    }
    let e = read(JSON.as_bytes(), "m.json", Some("Hot")).unwrap_err().to_string();
    assert!(e.contains("'Hot'") && e.contains("'Cold', 'Rainbow', 'Bands'"), "{e}");
    let alone = JSON.trim_start_matches('[').split("},").next().unwrap().to_owned() + "}";
    assert_eq!(good(&alone, "m.json").function, function, "a lone map");
}

#[test]
fn steps_jumps_midpoints_and_sharpness_come_as_paraview_draws_them() {
    let step = r#"[{"ColorSpace":"Step","RGBPoints":[-1,1,0,0, 0,0,1,0, 1,0,0,1]}]"#;
    let f = good(step, "s.json").function.color;
    for (kappa, rgb) in [
        (-1.0, [1.0, 0.0, 0.0]),
        (-0.999, [0.0, 1.0, 0.0]),
        (0.0, [0.0, 1.0, 0.0]),
        (1e-6, [0.0, 0.0, 1.0]),
        (1.0, [0.0, 0.0, 1.0]),
    ] {
        assert_eq!(f.sample(kappa), rgb, "{kappa}");
    }
    let jump = r#"[{"RGBPoints":[-1,0,0,0, 0,0.5,0.5,0.5, 0,1,0,0, 1,1,0,0]}]"#;
    let f = good(jump, "j.json").function.color;
    assert_eq!((f.sample(0.0), f.sample(1e-9)), ([0.5; 3], [1.0, 0.0, 0.0]));
    let curve = |points: &str| {
        good(&format!(r#"[{{"RGBPoints":[-1,0,0,0,1,1,1,1],"Points":[{points}]}}]"#), "p.json").function.opacity
    };
    let bent = curve("0,0,0.25,0, 1,1,0.5,0");
    near(&[bent.sample(0.0, 0.25), bent.sample(0.0, 0.625)], &[0.5, 0.75], 1e-12);
    let sharp = curve("0,0.2,0.25,1, 1,0.8,0.5,0");
    assert_eq!([0.2499, 0.2501].map(|k| sharp.sample(0.0, k)), [0.2, 0.8]);
    // The value of `midpoint_and_sharpness_bend_as_vtk_does`.
    near(&[curve("0,0,0.5,0.2, 1,1,0.5,0").sample(0.0, 0.25)], &[0.052_246], 6e-4);
    let falling = r#"[{"RGBPoints":[1,1,1,1,-1,0,0,0]}]"#;
    let f = good(falling, "f.json");
    assert_eq!(f.function.color.sample(-1.0), [0.0; 3]);
    assert!(f.notices.iter().any(|n| n.contains("increasing order")), "{:?}", f.notices);
    let bytes = good(r#"[{"RGBPoints":[-1,0,51,255, 1,0,0,0]}]"#, "b.json");
    assert_eq!(bytes.function.color.sample(-1.0), [0.0, 0.2, 1.0]);
    assert!(bytes.notices.iter().any(|n| n.contains("bytes")), "{:?}", bytes.notices);
}

/// What resampling costs, measured against a hundred times finer samples than the reader looks at.
#[test]
fn resampled_spaces_are_as_close_as_the_essay_says() {
    for (space, finest) in [("HSV", 4000), ("Lab", 4000), ("Diverging", 4000), ("Wrapped", 4000)] {
        let text = format!(r#"[{{"ColorSpace":"{space}","RGBPoints":[-1,0.2,0.3,0.8, 0,0.9,0.6,0.1, 1,0.7,0,0.2]}}]"#);
        let Imported { function, notices } = good(&text, "s.json");
        assert!(notices.iter().any(|n| n.contains("largest error 0.000")), "{notices:?}");
        let said = Space::named(space).unwrap();
        for i in 0..=finest {
            let kappa = 2.0 * f64::from(i) / f64::from(finest) - 1.0;
            let exact = if kappa < 0.0 {
                between(said, [0.2, 0.3, 0.8], [0.9, 0.6, 0.1], kappa + 1.0)
            } else {
                between(said, [0.9, 0.6, 0.1], [0.7, 0.0, 0.2], kappa)
            };
            near(&function.color.sample(kappa), &exact, 7e-4);
        }
    }
}

#[test]
fn paraview_xml_is_read() {
    let Imported { function, notices } = good(XML, "m.xml");
    near(&function.color.sample(0.0), &[0.5, 0.25, 0.0], 1e-12);
    near(&[function.opacity.sample(0.0, 0.5)], &[0.5], 1e-12);
    let all = notices.join("\n");
    assert!(all.contains("'Grey'") && all.contains("NaN") && all.contains("0 to 4"), "{all}");
    let grey = read(XML.as_bytes(), "m.xml", Some("Grey")).unwrap();
    // L* of 50 in sRGB.
    near(&grey.function.color.sample(0.0), &[0.4663; 3], 2e-3);
    let indexed = r#"<ColorMap name="i" indexedLookup="1"><Point x="0" r="1" g="0" b="0"/><Point x="1" r="0" g="0" b="1"/></ColorMap>"#;
    let f = good(indexed, "i.xml").function.color;
    assert_eq!((f.sample(-0.1), f.sample(0.1)), ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
}

#[test]
fn slicer_vp_is_read_and_says_what_it_leaves_out() {
    let Imported { function, notices } = good(VP, "ct.vp");
    near(&function.color.sample(0.0), &[0.5, 0.25, 0.0], 1e-12);
    near(&[function.opacity.sample(0.0, 0.25), function.opacity.sample(0.9, 0.75)], &[0.125, 0.625], 1e-12);
    let all = notices.join("\n");
    for word in ["lighting", "gradient opacity, 2 points", "-1000 to 1000"] {
        assert!(all.contains(word), "{word}: {all}");
    }
}

#[test]
fn csv_is_read_with_spaces_comments_and_any_range() {
    let Imported { function, notices } = good(CSV, "t.csv");
    assert!(notices.is_empty(), "{notices:?}");
    near(&function.color.sample(0.0), &[0.5, 0.25, 0.0], 1e-12);
    near(&[function.opacity.sample(0.0, 0.5), function.opacity.sample(0.5, 0.0)], &[0.5, 0.3], 1e-12);
    let wide = good("b,g,r,kappa\n0,0,0,10\n0,0,255,30\n", "w.csv");
    near(&wide.function.color.sample(0.0), &[0.5, 0.0, 0.0], 1e-12);
    assert!(wide.notices.iter().any(|n| n.contains("10 to 30")), "{:?}", wide.notices);
    let curve = good("kappa,opacity,note\n0.2,0.5,x\n0.4,0.7,\n", "c.csv");
    assert_eq!(curve.function.opacity.sample(0.9, 0.2), 0.5, "taken as it is: it lies inside");
    assert!(curve.notices.iter().any(|n| n.contains("'note'")), "{:?}", curve.notices);
}

#[test]
fn a_broken_file_names_itself_the_line_and_the_cause() {
    for (text, path, start, cause) in [
        (&*JSON.replace("10, 1, 0, 0 ]", "10, 1, 0 ]"), "m.json", "m.json:4:", "no whole groups of 4"),
        (&JSON.replace("\"HSV\"", "\"CMYK\""), "m.json", "m.json:7:", "'CMYK'"),
        (&JSON.replace("{ \"Name\" : \"Bands\",", "{ \"Name\" "), "m.json", "m.json:8:", "expected"),
        ("[1, 2]", "m.json", "m.json:1:", "invalid type"),
        ("[]", "m.json", "m.json:1:", "no colour map"),
        ("[{\"Name\": \"x\"}]", "m.json", "m.json:1:", "neither colour nor opacity"),
        (&JSON.replace("0.9, 0.5, 0 ]", "1e999, 0.5, 0 ]"), "m.json", "m.json:5:", "number out of range"),
        (&XML.replace("r=\"1\" g=\"0.5\"", "r=\"1\""), "m.xml", "m.xml:4:", "no g"),
        (&XML.replace("x=\"4\"", "x=\"four\""), "m.xml", "m.xml:4:", "\"four\" is not a number"),
        (&XML.replace("</ColorMaps>", ""), "m.xml", "m.xml:", ""),
        ("<svg/>", "m.xml", "m.xml:1:", "<svg>"),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><ColorMap/>", "m.xml", "m.xml:1:", ""),
        (&VP.replace("6 -1000", "5 -1000"), "a.vp", "a.vp:7:", "5 numbers are announced, 6 follow"),
        (&VP.replace("0.25", "a quarter"), "a.vp", "a.vp:7:", "'a' is not a number"),
        ("1\n1\n0.9\n", "a.vp", "a.vp:3:", "ends before its ambient"),
        (&CSV.replace("1, 1,0.5 ,0", "1, 1,half ,0"), "t.csv", "t.csv:4:", "g = 'half'"),
        (&CSV.replace("kappa , R", "curvature, R"), "t.csv", "t.csv:2:", "header row"),
        ("setting,value\nmode,paint\n", "t.csv", "t.csv:2:", "'paint'"),
        ("[color]\npoints = 1\n", "t.toml", "t.toml:2:", ""),
        (JSON, "t.toml", "t.toml:1:", "the name says TOML, the content looks like ParaView JSON"),
        (VP, "t.csv", "t.csv:1:", "the content looks like 3D Slicer"),
        ("Dear reader", "t.txt", "t.txt:1:", "not a transfer function"),
        ("", "t.txt", "t.txt:1:", "not a transfer function"),
        ("no png", "t.png", "t.png: ", "not a usable PNG"),
    ] {
        let e = bad(text, path);
        assert!(e.starts_with(start) && e.contains(cause), "{path}: {start} {cause}: {e}");
    }
    let e = read(&[0xff, 0xfe, 0, 1], "x.csv", None).unwrap_err().to_string();
    assert!(e.starts_with("x.csv:1:") && e.contains("neither text nor an image"), "{e}");
    let e = read(CSV.as_bytes(), "t.csv", Some("x")).unwrap_err().to_string();
    assert!(e.contains("no names to choose from"), "{e}");
    let deep = "<a>".repeat(200_000);
    assert!(bad(&deep, "deep.xml").starts_with("deep.xml:"));
    assert!(bad(&"[".repeat(200_000), "deep.json").starts_with("deep.json:1:"));
    let long = "kappa,opacity\n".to_owned() + &"0,0\n".repeat(MOST_POINTS + 1);
    assert!(bad(&long, "long.csv").contains("more than 65536 points"));
    assert!(bad(&" ".repeat(LARGEST_TEXT + 1), "big.toml").contains("larger than 16 MiB"));
}

#[test]
fn content_decides_where_the_name_does_not() {
    for (text, path) in [(JSON, "m.txt"), (XML, "m.xmlmap"), (VP, "m"), (CSV, "m.dat")] {
        assert!(!good(text, path).function.color.sample(1.0).is_empty());
    }
    let toml = preset("x-ray").to_toml().unwrap();
    assert_eq!(good(&toml, "x-ray.cfg").function, preset("x-ray"));
    assert_eq!(Format::of_path(Path::new("a/b.opacity.PNG")), Some(Format::PngMap));
    assert_eq!(Format::of_path(Path::new("a.json/b.png")), Some(Format::PngStrip));
    assert_eq!([Format::of_path(Path::new("a.gif")), Format::of_path(Path::new("json"))], [None, None]);
}

/// Everything that a format can hold of every preset, and of stepped functions, comes back.
#[test]
fn round_trips_keep_what_the_format_holds() {
    let stepped = "[color]\nmode = 'multiply'\ninterpolation = 'step'\npoints = [
        { kappa = -0.5, color = 0.2 }, { kappa = 0.1, color = [1, 0.5, 0] }, { kappa = 0.7, color = 0.9 }]
        [opacity]\ninterpolation = 'step'\ncurves = [{ depth = 0, points = [[0.1, 0.2], [0.30001, 0.9], [0.9, 0.1]] }]";
    let stepped = TransferFunction::from_toml(stepped, "stepped").unwrap();
    let mut all: Vec<(&str, TransferFunction)> = names().into_iter().map(|n| (n, preset(n))).collect();
    all.push(("stepped", stepped));
    all.push(("opaque", TransferFunction::uniform(1.0)));
    for (name, f) in &all {
        for format in Format::ALL {
            let Exported { bytes, notices } = write(f, format, name).unwrap();
            let path = format!("{name}.{}", format.extension());
            let back = read(&bytes, &path, None).unwrap_or_else(|e| panic!("{e}"));
            let images = f.without_images().0 != *f;
            let own = matches!(format, Format::Toml | Format::Csv);
            if own && !images {
                assert_eq!(back.function, *f, "{path}");
                assert!(notices.is_empty(), "{path}: {notices:?}");
                continue;
            }
            let by = if images { 2.0 / 255.0 } else { ROUND_TRIP };
            if format != Format::PngMap {
                let worst = (0..=2000).fold(0.0_f64, |worst, i| {
                    // Off the places where steps may lie.
                    let kappa = (f64::from(i) + 0.123) / 1000.0 - 1.0;
                    let kappa = if format == Format::PngStrip { (f64::from(i % 256) / 127.5) - 1.0 } else { kappa };
                    let [a, b] = [f, &back.function].map(|f| f.color.sample(kappa));
                    a.iter().zip(b).fold(worst, |worst, (a, b)| worst.max((a - b).abs()))
                });
                assert!(worst <= by, "{path}: colour {worst}");
            }
            if format != Format::PngStrip {
                let one = !own && format != Format::PngMap;
                for i in 0..=255 {
                    for j in (0..=255).step_by(15) {
                        let (kappa, depth) = (f64::from(i) / 255.0, f64::from(j) / 255.0);
                        let written = if one { 0.5 } else { depth };
                        let (a, b) = (f.opacity.sample(written, kappa), back.function.opacity.sample(depth, kappa));
                        assert!((a - b).abs() <= by, "{path}: opacity at {depth}, {kappa}: {a} {b}");
                    }
                }
                let said = notices.iter().any(|n| n.contains("no depth"));
                assert_eq!(said, one && f.opacity.depends_on_depth(), "{path}: {notices:?}");
            }
            if !own && format != Format::PngMap {
                assert!(notices.iter().any(|n| n.contains("how colours act")), "{path}: {notices:?}");
            }
        }
    }
}

#[test]
fn images_become_points_within_two_steps() {
    // A picture of noise has no straight pieces; it comes back whole.
    let mut noise = preset("murray-6a-7b");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("n.png").display().to_string();
    image::GrayImage::from_fn(40, 40, |x, y| image::Luma([(x * x * 31 + y * 97 + x * y * y * 13) as u8]))
        .save(&path)
        .unwrap();
    noise.opacity = TransferSource::Named(path).resolve(None).unwrap().opacity;
    for (name, f) in [("noise", noise), ("6a-7b", preset("murray-6a-7b"))] {
        let (points, error) = f.without_images();
        assert!(error > 0.0 && error <= 2.0 / 255.0 + 1e-6, "{name}: {error}");
        let (a, b) = (f.bake(), points.bake());
        let color = a.color.iter().flatten().zip(b.color.iter().flatten());
        let worst = color.chain(a.opacity.iter().zip(&b.opacity)).fold(0.0_f32, |m, (a, b)| m.max((a - b).abs()));
        assert!(f64::from(worst) <= error, "{name}: {worst}");
        assert!(matches!(points.color.shape, ColorShape::Points { .. }));
        assert_eq!(points.without_images(), (points.clone(), 0.0));
        // Few enough to be edited, where the image is smooth.
        let OpacityShape::Curves { curves, .. } = &points.opacity.shape else { panic!("{name}") };
        let count = curves.as_slice().iter().map(|c| c.points.as_slice().len()).sum::<usize>();
        assert!(name == "noise" || count < 1000, "{name}: {count} points");
    }
}

/// Names with letters that a format gives a meaning.
#[test]
fn names_survive() {
    let name = "a <b> & \"c\" ü";
    for format in [Format::ParaviewJson, Format::ParaviewXml] {
        let Exported { bytes, .. } = write(&preset("x-ray"), format, name).unwrap();
        let path = format!("n.{}", format.extension());
        assert!(read(&bytes, &path, Some(name)).is_ok(), "{}", String::from_utf8_lossy(&bytes));
        assert!(read(&bytes, &path, Some("b")).is_err());
    }
}

/// Bytes changed, removed, doubled and cut, by a fixed seed: nothing may panic, and what is read must be drawable.
#[test]
fn mutated_files_never_panic() {
    let toml = preset("pellucid").to_toml().unwrap();
    let small = TransferFunction::from_toml(
        "[color]\npoints = [{ kappa = 0, color = 0.5 }]\n[opacity]\ncurves = [{ depth = 0, points = [[0, 0.5]] }]",
        "small",
    )
    .unwrap();
    let [strip, map] = [Format::PngStrip, Format::PngMap].map(|f| write(&small, f, "x").unwrap().bytes);
    let seeds: [(&str, &[u8]); 7] = [
        ("a.json", JSON.as_bytes()),
        ("a.xml", XML.as_bytes()),
        ("a.vp", VP.as_bytes()),
        ("a.csv", CSV.as_bytes()),
        ("a.toml", toml.as_bytes()),
        ("a.png", &strip),
        ("b.png", &map),
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % below.max(1)
    };
    let words: [&[u8]; 16] = [
        b"1e308",
        b"-1e308",
        b"nan",
        b"inf",
        b"-0",
        b"1e-320",
        b"",
        b",",
        b"\"",
        b"[",
        b"]",
        b"<",
        b">",
        b"\n",
        b"99999999999",
        b"0.5",
    ];
    let (mut read_well, mut refused) = (0, 0);
    for (path, seed) in seeds {
        let rounds = if path.ends_with("png") { 300 } else { 2000 };
        for _ in 0..rounds {
            let mut bytes = seed.to_vec();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                match random(6) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at, random(256) as u8),
                    2 if !bytes.is_empty() => bytes[at] = random(256) as u8,
                    3 => {
                        let end = (at + random(20)).min(bytes.len());
                        bytes.drain(at..end);
                    }
                    4 => {
                        let end = (at + random(40)).min(bytes.len());
                        let part = bytes[at..end].to_vec();
                        let to = random(bytes.len());
                        bytes.splice(to..to, part);
                    }
                    _ => {
                        // A number or a sign in the place of a digit.
                        let digit = bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |i| at + i);
                        let end = (digit + 1).min(bytes.len());
                        bytes.splice(digit..end, words[random(words.len())].iter().copied());
                    }
                }
            }
            match read(&bytes, path, None) {
                Ok(Imported { function, .. }) => {
                    read_well += 1;
                    // The name of an image may have changed; it is not loaded then.
                    for i in 0..=8 {
                        let x = f64::from(i) / 8.0;
                        let values = function.color.sample(2.0 * x - 1.0);
                        let all = values.into_iter().chain([function.opacity.sample(0.5, x)]);
                        assert!(all.into_iter().all(|v| (0.0..=1.0).contains(&v)), "{path}: {function:?}");
                    }
                    if read_well % 16 == 0 && !path.ends_with("png") {
                        for format in Format::ALL {
                            if let Ok(written) = write(&function, format, "x") {
                                let again = format!("a.{}", format.extension());
                                read(&written.bytes, &again, None).unwrap_or_else(|e| panic!("{path}: {e}"));
                            }
                        }
                    }
                }
                Err(e) => {
                    refused += 1;
                    assert!(e.to_string().starts_with(path), "{e}");
                }
            }
        }
    }
    assert!(read_well > 500 && refused > 2000, "{read_well} read, {refused} refused");
}
