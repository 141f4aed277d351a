//! The machinery on itself, with a stand-in that draws pictures whose errors and delays are planted.

use super::*;
use crate::math::color::linear_from_srgb;
use crate::plan::{Pass, Refusal};
use crate::settings::{Axis, NormalEncoding};
use crate::tradeoff::axis::configurations;
use crate::tradeoff::axis::{AS_ASKED, named};

/// Draws even grey; `xy15` is 5 steps lighter and 20 ms slower, of which 12 ms in one pass; a scene without `printed` depths.
#[derive(Default)]
struct StandIn {
    frames: Vec<(Lane, [u32; 2], Wanted)>,
}

impl Workbench for StandIn {
    fn draw(&mut self, lane: Lane, settings: &Settings, size: [u32; 2], wanted: Wanted) -> Result<Drawn, RenderError> {
        self.frames.push((lane, size, wanted));
        if settings.features.depth_term == crate::settings::DepthTerm::Printed {
            return Err(Refusal::TooManyParts { parts: 70_000 }.into());
        }
        let worse = settings.capture.normals == NormalEncoding::Xy15;
        std::thread::sleep(Duration::from_millis(if worse { 22 } else { 2 }));
        let grey = linear_from_srgb(0.5 + if worse { 5.0 / 255.0 } else { 0.0 }) as f32;
        let image = LinearImage {
            width: size[0],
            height: size[1],
            pixels: vec![[grey, grey, grey, 1.0]; (size[0] * size[1]) as usize],
        };
        let shade = PassTime { pass: Pass::Shade, milliseconds: if worse { 13.0 } else { 1.0 } };
        Ok(Drawn {
            image,
            milliseconds: if worse { 22.0 } else { 2.0 },
            passes: if wanted.pass_times { vec![shade] } else { Vec::new() },
            counts: LayerCounts::default(),
            buffer_bytes: 0,
            layers: None,
        })
    }
}

/// The axes with these names; that of normals with the two values that the stand-in tells apart.
fn axes(names: &[&str]) -> Vec<Axis> {
    let mut found = named(&names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>()).unwrap();
    found.iter_mut().filter(|a| a.name == "normals").for_each(|a| a.values = &["octahedral", "xy15"]);
    found
}

fn sweep(bench: &mut StandIn, names: &[&str], options: &Options) -> Sweep {
    let base = Settings::default();
    let all = configurations(&base, &axes(names)).unwrap();
    run(bench, &all, [&base, &base], options, &mut |_| {}).unwrap()
}

fn small() -> Options {
    Options { size: [16, 12], thumbnail: 8, most_frames: 7, ..Options::default() }
}

#[test]
fn planted_errors_and_delays_show_up_as_large_as_they_are() {
    let swept = sweep(&mut StandIn::default(), &["normals"], &small());
    let names: Vec<&str> = swept.rows.iter().map(|r| r.configuration.name.as_str()).collect();
    assert_eq!(names, [AS_ASKED, "normals=xy15"]);
    let [asked, worse] = [0, 1].map(|i| swept.rows[i].outcome.as_ref().unwrap());
    assert_eq!(asked.image, ImageError::default(), "two runs of one configuration");
    assert!((worse.image.maximum - 5.0).abs() < 1e-3 && (worse.image.mean - 5.0).abs() < 1e-3, "{:?}", worse.image);
    assert_eq!((worse.image.above_1, worse.image.above_8), (1.0, 0.0));
    let times = [asked, worse].map(|m| m.times.as_ref().unwrap());
    let [fast, slow] = times.map(|t| t.whole.unwrap());
    assert_eq!((times[1].samples.len(), times[1].baseline_samples.len()), (7, 7));
    assert!((15.0..40.0).contains(&(slow.median - fast.median)), "{fast:?} {slow:?}");
    assert!(slow.low > fast.high, "the intervals are apart: {fast:?} {slow:?}");
    assert!(times[1].ratio.unwrap().low > 2.0, "{:?}", times[1].ratio);
    let of_baseline = times[0].ratio.unwrap();
    assert_eq!([of_baseline.low, of_baseline.median, of_baseline.high], [1.0; 3], "times are relative to it");
    assert_eq!(times[1].passes, [PassTime { pass: Pass::Shade, milliseconds: 13.0 }]);
}

#[test]
fn what_is_refused_is_a_row_with_its_reason() {
    let swept = sweep(&mut StandIn::default(), &["depth-term", "normals"], &small());
    let refused = swept.rows.iter().find(|r| r.configuration.name == "depth-term=printed").unwrap();
    let reason = refused.outcome.as_ref().unwrap_err();
    assert!(reason.contains("70000 parts"), "{reason}");
    assert!(swept.rows.iter().filter(|r| r.outcome.is_ok()).count() == 3, "the others go on");
}

#[test]
fn the_time_limit_ends_the_sweep_and_is_said() {
    let options = Options { limit: Some(Duration::from_millis(300)), ..small() };
    let begin = Instant::now();
    let swept = sweep(&mut StandIn::default(), &["normals", "reverse-check", "radius"], &options);
    assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
    assert!(swept.rows[0].outcome.as_ref().unwrap().times.as_ref().unwrap().whole.unwrap().count >= 1);
    let none = Options { limit: Some(Duration::ZERO), ..small() };
    let swept = sweep(&mut StandIn::default(), &["normals"], &none);
    assert!(swept.rows.iter().all(|r| r.outcome.as_ref().is_err_and(|e| e.contains("time limit of 0 s"))));
}

#[test]
fn errors_alone_draw_once_and_heed_no_limit() {
    let options = Options { most_frames: 0, limit: Some(Duration::ZERO), ..small() };
    let mut bench = StandIn::default();
    let swept = sweep(&mut bench, &["normals"], &options);
    assert!(swept.rows.iter().all(|r| r.outcome.as_ref().is_ok_and(|m| m.times.is_none())));
    assert_eq!(bench.frames.len(), 3, "the reference and two configurations");
}

#[test]
fn smaller_pictures_are_drawn_smaller_and_judged_at_the_size_asked_for() {
    let mut bench = StandIn::default();
    let swept = sweep(&mut bench, &["resolution"], &Options { size: [300, 200], ..small() });
    let half = swept.rows.iter().find(|r| r.configuration.name == "resolution=0.5").unwrap();
    assert!(half.outcome.as_ref().unwrap().image.maximum < 1e-4, "interpolation rounds");
    assert!(bench.frames.iter().any(|(lane, size, _)| *size == [150, 100] && *lane == Lane::Candidate));
    assert_eq!(swept.layer_size, [256, 170]);
}

#[test]
fn candidates_are_drawn_in_turn_with_the_baseline() {
    let mut bench = StandIn::default();
    sweep(&mut bench, &["normals"], &small());
    let lanes: Vec<Lane> = bench.frames.iter().map(|f| f.0).collect();
    let turns = lanes.windows(2).filter(|w| w[0] != w[1]).count();
    assert!(turns >= 2 * 7, "{lanes:?}");
    assert!(bench.frames.iter().filter(|f| f.2.pass_times).all(|f| f.0 == Lane::Candidate));
}
