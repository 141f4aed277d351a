//! The threads behind the window's accuracy panel against `pellucid tradeoff`, for the same settings, view and size.

use std::sync::Arc;
use std::time::{Duration, Instant};

use pellucid::app::accuracy::measuring::{Found, Measuring, Task};
use pellucid::app::accuracy::reference::{Job, References};
use pellucid::app::accuracy::{Referenced, Wanted};
use pellucid::app::document::Seen;
use pellucid::export::image::parse_background;
use pellucid::export::png::rgba8;
use pellucid::gpu::{Gpu, GpuOptions};
use pellucid::render::Renderer;
use pellucid::scene::Arrangement;
use pellucid::settings::Settings;
use pellucid::tradeoff::axis::{AS_ASKED, configurations, named};
use pellucid::tradeoff::difference;
use pellucid::tradeoff::image_error::compare;
use pellucid::tradeoff::reference::both;
use pellucid::tradeoff::sweep::{self, Options};
use pellucid::tradeoff::workbench::RendererBench;

use crate::common::*;
use crate::meshes;

const SIZE: [u32; 2] = [72, 56];

fn wait<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(begin.elapsed() < Duration::from_secs(240), "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn seen(base: &Settings) -> (Arc<pellucid::scene::Scene>, Seen) {
    let scene = meshes::assembly(2);
    let camera = camera(&scene, false);
    let seen = Seen { settings: base.clone(), camera, arrangement: Arrangement::default() };
    (Arc::new(scene), seen)
}

#[test]
fn the_panels_reference_and_figures_are_those_of_tradeoff() {
    let Some(lock) = renderer() else { return };
    drop(lock);
    let base = with_transfer(settings("kind=bkb k=4 normals=xy15"), lively());
    let (scene, seen) = seen(&base);
    let gpu = Gpu::new(&GpuOptions::default()).unwrap();
    let background = parse_background(&base.image.background).unwrap();

    // As the command line has it.
    let mut bench = RendererBench::new(&gpu, &scene, &seen.camera).unwrap();
    let references = both(&base).unwrap();
    let rows = configurations(&base, &named(&["reverse-check".to_owned()]).unwrap()).unwrap();
    let options = Options { size: SIZE, background, most_frames: 0, thumbnail: 0, ..Options::default() };
    let [exact, many] = &references;
    let swept = sweep::run(&mut bench, &rows, [exact, many], &options, &mut |_| {}).unwrap();
    assert_eq!(swept.rows[0].configuration.name, AS_ASKED);
    let expected = swept.rows[0].outcome.as_ref().unwrap().image;

    // The window: the exact picture by one renderer, the reference by the thread's own.
    let mut renderer = Renderer::new(gpu).unwrap();
    let loaded = renderer.load(&scene).unwrap();
    let picture = renderer.render(&loaded, &seen.camera, &base, SIZE).unwrap().image;
    let reference = renderer.render(&loaded, &seen.camera, exact, SIZE).unwrap().image;
    let thread = References::start(|| {});
    let job = Job {
        number: 3,
        scene: Arc::clone(&scene),
        scene_number: 1,
        seen,
        shaders: Arc::default(),
        picture: Arc::new(picture.clone()),
    };
    // Only the newest is of interest.
    thread.post(Job { number: 2, ..job.clone() });
    thread.post(job);
    let found: Referenced = wait("a reference", || {
        thread.take().into_iter().map(|o| o.unwrap_or_else(|e| panic!("{e:?}"))).find(|f| f.number == 3)
    });
    println!("{:?}", found.error);
    assert!(expected.maximum > 1.0, "there is something to be compared");
    assert_eq!(found.error, expected);
    assert!(found.reference.rgba == rgba8(&reference, background), "the reference, bit for bit");
    let map = compare(&picture, &reference, background).unwrap();
    assert!(found.difference.rgba == difference::rgba(&map));
}

#[test]
fn a_sweep_rests_while_the_gate_is_closed_and_ends_when_called_off() {
    let Some(lock) = renderer() else { return };
    drop(lock);
    let (scene, seen) = seen(&with_transfer(Settings::default(), lively()));
    let task = Task {
        wanted: Wanted::Sweep,
        scene,
        scene_number: 1,
        resolved: seen.clone(),
        seen,
        size: [48, 40],
        seconds: 3600,
    };
    let measuring = Measuring::begin(task, || {});
    measuring.let_pass(false);
    wait("the reference is next", || (measuring.underway().name == "reference").then_some(()));
    std::thread::sleep(Duration::from_secs(2));
    let resting = measuring.underway();
    assert!(resting.rests && resting.done == 0 && resting.of > 10 && measuring.rows().is_empty(), "{resting:?}");
    assert!(measuring.take().is_none());
    measuring.let_pass(true);
    let rows = wait("a row", || Some(measuring.rows()).filter(|r| !r.is_empty()));
    assert_eq!(rows[0].configuration.name, AS_ASKED);
    let times = rows[0].outcome.as_ref().unwrap().times.as_ref().unwrap();
    assert!(times.samples.iter().all(|t| *t < 2000.0), "no rest is in the times: {:?}", times.samples);
    measuring.stop();
    match wait("the end", || measuring.take()).unwrap() {
        Found::Sweep(rows, _) => {
            assert!(rows.last().unwrap().outcome.as_ref().is_err_and(|e| e.contains("called off")));
        }
        _ => panic!("a sweep gives rows"),
    }
}
