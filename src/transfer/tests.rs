use super::*;

fn resolve(name: &str) -> TransferFunction {
    TransferSource::Named(name.to_owned()).resolve(None).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(text: &str) -> (usize, usize, String) {
    match TransferFunction::from_toml(text, "bad.toml") {
        Err(TransferError::Text { path, line, column, reason }) => {
            assert_eq!(path, "bad.toml");
            assert!(!reason.contains('\n'), "{reason}");
            (line, column, reason)
        }
        other => panic!("{other:?}"),
    }
}

const GOOD: &str = r##"
[color]
mode = "multiply"
interpolation = "linear"
points = [
    { kappa = -1, color = 1 },
    { kappa = 0.0, color = [0.5, 0.25, 0.5] },
    { kappa = 1.0, color = "#330000" },
]

[opacity]
interpolation = "linear"
depth_interpolation = "linear"
curves = [
    { depth = 0.0, points = [[0.0, 0.1], [1.0, 0.9]] },
    { depth = 0.5, points = [[0, 0.5]] },
]
"##;

#[test]
fn control_points_are_interpolated_in_both_directions() {
    let f = TransferFunction::from_toml(GOOD, "good").unwrap();
    assert_eq!(f.color.mode, ColorMode::Multiply);
    assert_eq!(f.color.sample(-1.0), [1.0; 3]);
    assert_eq!(f.color.sample(0.0), [0.5, 0.25, 0.5]);
    let [r, g, b] = f.color.sample(0.5);
    assert!((r - 0.35).abs() < 1e-12 && (g - 0.125).abs() < 1e-12 && (b - 0.25).abs() < 1e-12, "{r} {g} {b}");
    assert_eq!(f.color.sample(7.0), f.color.sample(1.0));
    for (depth, kappa, opacity) in
        [(0.0, 0.0, 0.1), (0.0, 0.5, 0.5), (0.25, 0.0, 0.3), (0.25, 1.0, 0.7), (0.8, 1.0, 0.5)]
    {
        let found = f.opacity.sample(depth, kappa);
        assert!((found - opacity).abs() < 1e-12, "({depth}, {kappa}): {found}, not {opacity}");
    }
}

#[test]
fn tables_hold_the_ends_and_answer_as_the_function_does() {
    let f = TransferFunction::from_toml(GOOD, "good").unwrap();
    let tables = f.bake();
    assert_eq!((tables.color.len(), tables.opacity.len()), (256, 65536));
    assert_eq!(tables.color[0], [1.0; 3]);
    assert_eq!(tables.color[255], f.color.sample(1.0).map(|v| v as f32));
    // x is depth, y is |κ|.
    for (x, y) in [(0, 0), (255, 0), (0, 255), (255, 255), (40, 200)] {
        let exact = f.opacity.sample(x as f64 / 255.0, y as f64 / 255.0);
        assert_eq!(tables.opacity[y * 256 + x], exact as f32);
    }
    for i in 0..=200 {
        let (depth, kappa) = (f64::from(i) / 200.0, f64::from(200 - i) / 200.0);
        assert!((tables.sample_opacity(depth, kappa) - f.opacity.sample(depth, kappa)).abs() < 2e-3);
        assert!((tables.sample_color(2.0 * kappa - 1.0)[1] - f.color.sample(2.0 * kappa - 1.0)[1]).abs() < 2e-3);
    }
}

#[test]
fn what_a_function_depends_on_is_read_off_its_tables() {
    let with = |color: &str, opacity: &str| {
        let text = format!("[color]\npoints = {color}\n[opacity]\ncurves = {opacity}");
        let f = TransferFunction::from_toml(&text, "test").unwrap();
        let tables = f.bake();
        assert_eq!(tables.depends_on_curvature(), f.depends_on_curvature());
        assert_eq!(tables.depends_on_depth(), f.depends_on_depth());
        assert_eq!(tables.constant(), f.constant());
        (f.depends_on_curvature(), f.depends_on_depth(), f.constant())
    };
    let grey = "[{ kappa = -0.5, color = 0.7 }, { kappa = 0.1, color = 0.7 }]";
    let ramp = "[{ kappa = -1, color = 0.7 }, { kappa = 1, color = 0.6 }]";
    let flat = "[{ depth = 0.2, points = [[0, 0.3], [0.7, 0.3]] }, { depth = 1, points = [[0.3, 0.3]] }]";
    let deep = "[{ depth = 0.2, points = [[0, 0.3]] }, { depth = 1, points = [[0.3, 0.4]] }]";
    let curved = "[{ depth = 0.2, points = [[0, 0.3], [1, 0.4]] }]";
    assert_eq!(with(grey, flat), (false, false, Some(([0.7; 3], 0.3))));
    assert_eq!(with(ramp, flat), (true, false, None));
    assert_eq!(with(grey, deep), (false, true, None));
    assert_eq!(with(grey, curved), (true, false, None));
    // A rise that no table entry sees does not count: the table is what is drawn.
    let hidden = "[{ depth = 0, points = [[0.0, 0.3], [0.0001, 0.9], [0.0002, 0.3]] }]";
    assert_eq!(with(grey, hidden), (false, false, Some(([0.7; 3], 0.3))));
    assert_eq!(TransferFunction::uniform(0.25).constant(), Some(([0.5; 3], 0.25)));
}

#[test]
fn a_broken_file_is_refused_with_line_column_and_reason() {
    let replaced = |from: &str, to: &str| {
        assert!(GOOD.contains(from), "{from}");
        refused(&GOOD.replace(from, to))
    };
    for (from, to, line, reason) in [
        ("kappa = -1,", "kappa = -1.5,", 6, "kappa = -1.5: expected a number from -1 to 1"),
        ("kappa = -1,", "kappa = nan,", 6, "kappa = NaN"),
        ("kappa = 0.0,", "kappa = -1.0,", 7, "points must stand in increasing order"),
        ("[0.5, 0.25, 0.5]", "[0.5, 1.25, 0.5]", 7, "color = 1.25"),
        ("[0.5, 0.25, 0.5]", "[0.5, 0.25]", 7, "expected a colour"),
        ("#330000", "#33000", 8, "#rrggbb"),
        ("color = 1 ", "colour = 1 ", 6, "unknown field `colour`"),
        ("[1.0, 0.9]", "[1.0, 1.9]", 15, "opacity = 1.9: expected a number from 0 to 1"),
        ("[1.0, 0.9]", "[0.0, 0.9]", 15, "|kappa| = 0 follows 0"),
        ("[1.0, 0.9]", "[1.0, inf]", 15, "opacity = inf"),
        ("[1.0, 0.9]", "[1.0]", 15, "invalid length"),
        ("depth = 0.5", "depth = 0.0", 16, "depth = 0 follows 0"),
        ("depth = 0.5", "depth = 1.5", 16, "depth = 1.5"),
        ("[[0, 0.5]]", "[]", 16, "there is no point"),
        ("\"multiply\"", "\"divide\"", 3, "unknown variant `divide`"),
        ("[opacity]", "[opacity", 11, ""),
        ("mode = ", "image = \"x.png\"\nmode = ", 2, "either points or an image"),
    ] {
        let (found_line, column, found) = replaced(from, to);
        assert_eq!(found_line, line, "{to}: {found}");
        assert!(found.contains(reason), "{to}: {found}");
        assert!(column >= 1);
    }
    assert_eq!(replaced("kappa = 0.0,", "kappa = -1.0,").1, 5, "column of the point");
    assert!(refused("[color]\npoints = []\n").2.contains("no point"));
    assert!(refused("[color]\npoints = [{ kappa = 0, color = 1 }]\n").2.contains("opacity"));
    let e = TransferFunction::from_toml("é = [1,\n  = 2", "x.toml").unwrap_err().to_string();
    assert!(e.starts_with("x.toml:2:"), "{e}");
}

#[test]
fn every_preset_loads_describes_itself_and_round_trips() {
    assert!(names().len() >= 7);
    for preset in presets() {
        let function = resolve(preset.name);
        assert!(preset.description.len() > 20 && preset.description.ends_with('.'), "{preset:?}");
        let text = function.to_toml().unwrap();
        let again = TransferFunction::from_toml(&text, preset.name).unwrap();
        assert_eq!(again.to_toml().unwrap(), text, "{}", preset.name);
        let images = matches!(function.color.shape, ColorShape::Strip(_));
        if !images {
            assert_eq!(again, function, "{}\n{text}", preset.name);
        }
        let tables = function.bake();
        assert!(tables.opacity.iter().chain(tables.color.iter().flatten()).all(|v| (0.0..=1.0).contains(v)));
        let constant = preset.name == "constant";
        assert_eq!(function.constant().is_some(), constant, "{}", preset.name);
    }
    assert_eq!(resolve("constant").constant(), Some(([0.5; 3], 0.3)));
}

#[test]
fn the_default_shows_every_layer() {
    let f = resolve("pellucid");
    assert_eq!(TransferSource::default().resolve(None).unwrap(), f);
    assert_eq!(f.color.sample(0.0), [0.5; 3], "a flat face keeps its colour");
    assert!(f.color.sample(-1.0)[0] > 0.6 && f.color.sample(1.0)[0] < 0.25);
    // Ten flat walls in front of a part leave four fifths of it, and can still be told from none.
    assert!((0.015..=0.05).contains(&f.opacity.sample(0.0, 0.0)));
    for i in 0..20 {
        for j in 0..=20 {
            let (a, b, c) = (f64::from(i) / 20.0, f64::from(i + 1) / 20.0, f64::from(j) / 20.0);
            assert!(f.opacity.sample(b, c) >= f.opacity.sample(a, c) - 1e-12, "opacity grows with depth");
            assert!(f.opacity.sample(c, b) >= f.opacity.sample(c, a), "and with curvature");
        }
    }
}

#[test]
fn the_papers_figures_look_as_it_says() {
    let (a, b, d, inverted) =
        (resolve("murray-6a-7a"), resolve("murray-6a-7b"), resolve("murray-6a-8d"), resolve("murray-6b-7a"));
    for f in [&a, &b, &d] {
        assert!(f.color.sample(-1.0)[0] > 0.95 && f.color.sample(1.0)[0] < 0.05, "6(a)");
        assert!((f.color.sample(0.0)[0] - 0.5).abs() < 0.01);
    }
    assert!(inverted.color.sample(-1.0)[0] > 0.9 && inverted.color.sample(1.0)[0] > 0.9, "6(b): curved is bright");
    assert!(inverted.color.sample(0.0)[0] < 0.2, "6(b): flat is dark");
    assert!(a.opacity.sample(0.0, 0.0) < 0.05 && a.opacity.sample(0.0, 1.0) > 0.9, "7(a): flat clear, curved opaque");
    assert!(a.opacity.sample(0.6, 0.0) > 0.5, "7(a): opacity grows quickly with depth");
    assert!(b.opacity.sample(0.0, 1.0) < a.opacity.sample(0.0, 1.0) - 0.2, "7(b): less focus in front");
    assert!(b.opacity.sample(0.6, 0.0) < 0.3, "7(b): shape over a wider range of depth");
    for kappa in [0.0, 0.5, 1.0] {
        assert!(d.opacity.sample(0.0, kappa) > d.opacity.sample(1.0, kappa) + 0.3, "8(d): the front is more opaque");
    }
}

#[test]
fn the_images_are_what_their_generators_make() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("transfer_functions");
    for (name, made) in [("murray-6a.png", presets::strip_6a()), ("murray-7b.png", presets::map_7b())] {
        if std::env::var_os("PELLUCID_WRITE_PRESETS").is_some() {
            made.save(folder.join(name)).unwrap();
        }
        let kept = image::open(folder.join(name)).unwrap().into_luma8();
        assert_eq!(kept, made, "{name}: run this test with PELLUCID_WRITE_PRESETS=1");
    }
}

#[test]
fn images_are_read_as_plain_numbers_beside_the_file_that_names_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("looks")).unwrap();
    let at = |name: &str| folder.path().join("looks").join(name);
    // A strip has its first row read; |κ| runs upwards in the map.
    image::RgbImage::from_vec(2, 2, vec![0, 51, 102, 255, 255, 255, 9, 9, 9, 9, 9, 9])
        .unwrap()
        .save(at("c.png"))
        .unwrap();
    image::ImageBuffer::<image::Luma<u16>, _>::from_vec(2, 2, vec![65535, 65535, 0, 13107])
        .unwrap()
        .save(at("o.png"))
        .unwrap();
    std::fs::write(at("f.toml"), "[color]\nimage = 'c.png'\n[opacity]\nimage = 'o.png'\n").unwrap();
    let f = TransferSource::Named("looks/f.toml".to_owned()).resolve(Some(folder.path())).unwrap();
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(f.color.sample(-1.0), [0.0, 0.2, 0.4]) && close(f.color.sample(0.0), [0.5, 0.6, 0.7]));
    for (depth, kappa, opacity) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.2), (0.5, 0.0, 0.1), (0.0, 1.0, 1.0), (1.0, 0.5, 0.6)]
    {
        assert!((f.opacity.sample(depth, kappa) - opacity).abs() < 1e-6, "({depth}, {kappa})");
    }

    std::fs::write(at("c.png"), b"not a png").unwrap();
    let e = TransferSource::Named(at("f.toml").display().to_string()).resolve(None).unwrap_err().to_string();
    assert!(e.contains("c.png: not a usable PNG"), "{e}");
    std::fs::remove_file(at("c.png")).unwrap();
    let e = TransferSource::Named("looks/f.toml".to_owned()).resolve(Some(folder.path())).unwrap_err().to_string();
    assert!(e.contains("c.png: No such file"), "{e}");
    // An image by itself is a function too: this one, as high as wide, of opacities.
    let map = TransferSource::Named("looks/o.png".to_owned()).import(Some(folder.path()), None).unwrap();
    assert!((map.function.opacity.sample(1.0, 0.0) - 0.2).abs() < 1e-6);
    assert!(map.notices.iter().any(|n| n.contains("no colour")), "{:?}", map.notices);
}

#[test]
fn a_source_can_be_used_from_another_folder_and_a_resolved_function_again() {
    let folder = tempfile::tempdir().unwrap();
    image::GrayImage::from_pixel(1, 1, image::Luma([51])).save(folder.path().join("o.png")).unwrap();
    let text = "[color]\npoints = [{ kappa = 0, color = 0.5 }]\n[opacity]\nimage = 'o.png'\n";
    let inline = TransferSource::Inline(Box::new(TransferFunction::from_toml(text, "inline").unwrap()));
    assert!(inline.resolve(None).is_err(), "o.png is not in the current folder");
    let function = inline.clone().rebased(folder.path()).resolve(None).unwrap();
    assert_eq!(function.opacity.constant(), Some(0.2));
    assert_eq!(inline.resolve(Some(folder.path())).unwrap().bake(), function.bake());
    assert_eq!(TransferSource::Inline(Box::new(function.clone())).resolve(None).unwrap(), function, "loaded already");
    std::fs::write(folder.path().join("f.toml"), text).unwrap();
    assert!(TransferSource::Named("f.toml".to_owned()).rebased(folder.path()).resolve(None).is_ok());
    assert_eq!(TransferSource::default().rebased(folder.path()), TransferSource::default());
}

#[test]
fn files_of_other_programs_work_by_path_and_maps_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let maps = r#"[{"Name":"A","RGBPoints":[-1,0,0,0,1,0,0,0]},{"Name":"B","RGBPoints":[-1,1,1,1,1,1,1,1]}]"#;
    std::fs::write(folder.path().join("maps.json"), maps).unwrap();
    let resolve = |name: &str| TransferSource::Named(name.to_owned()).resolve(Some(folder.path())).map(|f| f.color);
    assert_eq!(resolve("maps.json").unwrap().constant(), Some([0.0; 3]));
    assert_eq!(resolve("maps.json#B").unwrap().constant(), Some([1.0; 3]));
    assert!(resolve("maps.json#C").unwrap_err().to_string().contains("'C'"));
    let rebased = TransferSource::Named("maps.json#B".to_owned()).rebased(folder.path());
    assert_eq!(rebased.resolve(None).unwrap().color.constant(), Some([1.0; 3]));
    // A file that is called so comes first.
    std::fs::write(folder.path().join("maps.json#B"), maps).unwrap();
    assert_eq!(resolve("maps.json#B").unwrap().constant(), Some([0.0; 3]));
}

#[test]
fn an_unknown_name_lists_the_known_and_a_missing_file_its_path() {
    let e = TransferSource::Named("pelucid".to_owned()).resolve(None).unwrap_err().to_string();
    assert!(e.contains("'pelucid'") && e.contains("murray-6a-7a") && e.contains("x-ray"), "{e}");
    let e = TransferSource::Named("missing/f.toml".to_owned()).resolve(None).unwrap_err().to_string();
    assert!(e.starts_with("missing/f.toml: "), "{e}");
}

#[test]
fn a_source_reads_a_name_or_a_table_from_any_format() {
    let inline = TransferFunction::from_toml(GOOD, "good").unwrap();
    let source = TransferSource::Inline(Box::new(inline.clone()));
    assert_eq!(source.resolve(None).unwrap(), inline);
    for source in [source, TransferSource::default()] {
        let json = serde_json::to_string(&source).unwrap();
        assert_eq!(serde_json::from_str::<TransferSource>(&json).unwrap(), source);
        let value = toml::Value::try_from(&source).unwrap();
        assert_eq!(value.try_into::<TransferSource>().unwrap(), source);
    }
    let e = serde_json::from_str::<TransferSource>("{\"color\": 1}").unwrap_err().to_string();
    assert!(e.contains("expected struct"), "{e}");
    assert!(
        serde_json::from_str::<TransferSource>("7").unwrap_err().to_string().contains("a name, a path, or a table")
    );
}
