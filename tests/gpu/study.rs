//! The user study's tasks, measured from the picture.

use pellucid::scene::builtin;
use pellucid::settings::Settings;
use pellucid::tradeoff::study::{self, Options};

use crate::common::*;

/// The whole study takes minutes: `pellucid bench study` makes it.
#[test]
fn illustrative_transparency_shows_twice_as_plainly_what_lies_in_front() {
    let Some(mut r) = renderer() else { return };
    let (views, size, wanted, least) = if full() { (12, 800, 200, 200) } else { (2, 480, 40, 16) };
    for name in ["flow", "gearbox"] {
        let scene = builtin::build(name).expect("a scene");
        let camera = camera(&scene, false);
        let loaded = r.load(&scene).expect("upload");
        let options = Options { size: [size; 2], junctions: wanted, seed: 1 };
        let cameras = study::around(&camera, views);
        let found =
            study::run(&mut r, &loaded, &cameras, &Settings::default(), &options, &mut |_| {}).expect("a study");
        println!("{name}: {}", study::table(&found));
        assert!(found.places.len() >= least, "{name}: {} junctions", found.found);
        for row in &found.rows {
            assert!((row.luminance_ratio - 1.0).abs() <= 0.1, "{name}: {} is {}", row.name, row.luminance_ratio);
        }
        let row = found.rows.iter().find(|row| row.name == "illustrative").expect("it takes part");
        assert!(row.ratio >= 2.0, "{name}: {}", row.ratio);
    }
}
