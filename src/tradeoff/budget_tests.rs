//! The choice on a stand-in whose times and errors are planted.

use super::*;
use crate::math::color::linear_from_srgb;
use crate::passes::capture::LayerCounts;
use crate::plan::Refusal;
use crate::settings::CaptureKind;
use crate::tradeoff::workbench::Drawn;

/// A frame takes 8 ms a picture of full size and sample, a third of that with a Bucketed k-Buffer. Pictures are stripes of
/// which half a step is wrong in a share of pixels that shrinks with density, and the smaller k is the larger.
struct StandIn {
    size: [u32; 2],
    drawn: usize,
    /// Every frame is refused.
    broken: bool,
}

fn stand_in() -> StandIn {
    StandIn { size: [48, 40], drawn: 0, broken: false }
}

impl Workbench for StandIn {
    fn draw(&mut self, _: Lane, settings: &Settings, size: [u32; 2], _: Wanted) -> Result<Drawn, RenderError> {
        self.drawn += 1;
        if self.broken {
            return Err(Refusal::TooManyParts { parts: 70_000 }.into());
        }
        let pixels = f64::from(size[0] * size[1]) / f64::from(self.size[0] * self.size[1]);
        let density = pixels * f64::from(settings.image.samples);
        let bucketed = settings.capture.kind == CaptureKind::BucketedKBuffer;
        let milliseconds = 8.0 * density * if bucketed { 1.0 / 3.0 } else { 1.0 };
        // A little noise, the same in every run.
        let milliseconds = milliseconds * (1.0 + 0.002 * (self.drawn % 5) as f64);
        std::thread::sleep(Duration::from_micros(300));
        let lost = if bucketed { 0.1 / f64::from(settings.capture.bucketed_k_buffer.k) } else { 0.0 };
        // The supersampled reference has 16 samples and no error.
        let off = if density > 15.0 { 0.0 } else { 0.02 / density + lost };
        let grey = linear_from_srgb(0.4 + off.min(0.5)) as f32;
        let count = (size[0] * size[1]) as usize;
        Ok(Drawn {
            image: LinearImage { width: size[0], height: size[1], pixels: vec![[grey, grey, grey, 1.0]; count] },
            milliseconds,
            passes: Vec::new(),
            counts: LayerCounts::default(),
            buffer_bytes: 0,
            layers: None,
        })
    }
}

fn options() -> Options {
    Options { size: [48, 40], background: None, limit: Duration::from_secs(60), resize: true }
}

fn chosen(bench: &mut StandIn, goal: Goal, measured: &mut Measurements) -> Choice {
    choose(bench, &Settings::default(), goal, &options(), measured, &mut |_| {}).unwrap()
}

#[test]
fn within_a_time_the_most_accurate_is_chosen() {
    let mut measured = Measurements::default();
    // Compacted takes 8 ms a sample: three fit into 30 ms, four do not.
    let choice = chosen(&mut stand_in(), Goal::Time(30.0), &mut measured);
    println!("{choice:#?}");
    assert!(
        choice.verdict == Verdict::Kept
            && !choice.cut_short
            && choice.time.high <= 30.0
            && choice.time.count >= PROMISED_FRAMES
    );
    let fits = |e: &&Entry| estimate(&e.frames, 1).is_some_and(|t| t.high <= 30.0 && t.count >= PROMISED_FRAMES);
    let best = measured.entries.iter().filter(fits).filter_map(|e| Some(e.error?.flip_mean)).fold(1.0, f64::min);
    assert!(choice.flip <= 1.02 * best, "nothing that fits is noticeably more accurate");
    assert!(choice.reason.contains("takes"), "{}", choice.reason);
    // A shorter time gives a sparser picture.
    let shorter = chosen(&mut stand_in(), Goal::Time(4.0), &mut measured);
    assert!(shorter.verdict == Verdict::Kept && shorter.time.high <= 4.0 && shorter.flip > choice.flip, "{shorter:?}");
    assert!(shorter.scale < 1.0 || shorter.settings.capture.kind == CaptureKind::BucketedKBuffer);
}

#[test]
fn below_an_error_the_fastest_is_chosen() {
    let mut measured = Measurements::default();
    let plain = chosen(&mut stand_in(), Goal::Error(1.0), &mut measured);
    let errors: Vec<f64> = measured.entries.iter().filter_map(|e| Some(e.error?.flip_mean)).collect();
    let (least, most) = (errors.iter().copied().fold(1.0, f64::min), errors.iter().copied().fold(0.0, f64::max));
    assert!(plain.verdict == Verdict::Kept && plain.scale == 0.125, "any picture will do: {plain:?}");
    let limit = 0.5 * (least + most).min(3.0 * least);
    let choice = chosen(&mut stand_in(), Goal::Error(limit), &mut measured);
    assert!(choice.verdict == Verdict::Kept && choice.flip <= limit, "{choice:?}");
    let suffices = |e: &&Entry| e.error.is_some_and(|e| e.flip_mean <= limit) && e.frames.len() >= PROMISED_FRAMES;
    let fastest = measured.entries.iter().filter(suffices).filter_map(|e| median(&e.frames)).fold(f64::MAX, f64::min);
    assert!(choice.time.median <= 1.1 * fastest, "nothing that suffices is noticeably faster");
}

#[test]
fn what_is_known_is_not_measured_again() {
    let mut measured = Measurements::default();
    let first = chosen(&mut stand_in(), Goal::Error(0.1), &mut measured);
    let mut bench = stand_in();
    let known = measured.clone();
    let again = chosen(&mut bench, Goal::Error(0.1), &mut measured);
    assert_eq!((bench.drawn, &again, measured == known), (0, &first, true));
    // Through a file.
    let text = serde_json::to_string(&measured).unwrap();
    assert_eq!(serde_json::from_str::<Measurements>(&text).unwrap(), measured);
}

#[test]
fn a_promise_that_cannot_be_kept_is_said() {
    let mut measured = Measurements::default();
    let choice = chosen(&mut stand_in(), Goal::Time(0.001), &mut measured);
    assert!(choice.verdict == Verdict::Broken && choice.reason.contains("nothing fits"), "{choice:?}");
    assert_eq!(choice.scale, 0.125, "the fastest");
    let choice = chosen(&mut stand_in(), Goal::Error(0.0), &mut measured);
    assert!(
        choice.verdict == Verdict::Broken
            && choice.reason.contains("nothing suffices")
            && choice.settings.image.samples == 8
    );
}

#[test]
fn when_time_ends_what_is_known_is_chosen_from() {
    let short = Options { limit: Duration::ZERO, ..options() };
    let mut measured = Measurements::default();
    let goal = Goal::Error(1.0);
    let result = choose(&mut stand_in(), &Settings::default(), goal, &short, &mut measured, &mut |_| {});
    let choice = result.unwrap();
    assert!(choice.cut_short, "{choice:?}");
}

#[test]
fn an_adapter_that_refuses_everything_is_an_error_with_the_reason() {
    let mut broken = StandIn { broken: true, ..stand_in() };
    let goal = Goal::Error(0.1);
    let error = choose(&mut broken, &Settings::default(), goal, &options(), &mut Measurements::default(), &mut |_| {});
    let text = error.unwrap_err().to_string();
    assert!(text.contains("70000 parts"), "{text}");
}

#[test]
fn more_samples_than_usual_are_tried_where_they_are_asked_for() {
    let asked = Settings::from_pairs("image.samples=24").unwrap();
    let mut measured = Measurements::default();
    let choice = choose(&mut stand_in(), &asked, Goal::Time(1000.0), &options(), &mut measured, &mut |_| {}).unwrap();
    assert_eq!((choice.name.as_str(), choice.settings.image.samples), (AS_ASKED, 24), "{choice:?}");
    assert_eq!(choice.reference_samples, 48);
    // Names say what differs from what was asked for.
    let plain = measured.entries.iter().find(|e| e.settings.image.samples == 1 && e.scale == 1.0).unwrap();
    assert!(plain.name.ends_with("samples=1"), "{}", plain.name);
}

#[test]
fn what_too_few_frames_say_is_not_called_broken() {
    let mut measured = Measurements::default();
    let short = Options { limit: Duration::ZERO, ..options() };
    let goal = Goal::Time(30.0);
    let choice = choose(&mut stand_in(), &Settings::default(), goal, &short, &mut measured, &mut |_| {}).unwrap();
    assert!(choice.verdict == Verdict::Unsure && choice.time.high < 30.0 && choice.cut_short, "{choice:?}");
}
