//! What becomes of pictures when devices are lost. Without an adapter these say so and are skipped, except where `CI` is set.

use super::*;
use crate::app::camera;
use crate::app::pictures::TARGET;
use crate::scene::builtin;
use crate::settings::Settings;

fn studio(kind: Kind) -> Option<Studio> {
    if let Err(e) = Gpu::new(&GpuOptions::default()) {
        assert!(std::env::var_os("CI").is_none(), "{e}");
        println!("SKIPPED: lost devices: {e}");
        return None;
    }
    let pace = Arc::new(Mutex::new(Paces::new(TARGET)));
    Some(Studio { kind, pace, bench: None, cancel: Arc::default(), shaders: Arc::default(), refused: None, said: None })
}

fn order(number: u64) -> Order {
    let scene = Arc::new(builtin::build("stack").unwrap());
    let camera = camera::first(&scene.bounds(), 1.5);
    let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
    let (size, change, not_before) = ([48, 32], Change::Whole, Instant::now());
    Order {
        number,
        scene,
        scene_number: 1,
        seen,
        extras: Extras::default(),
        size,
        change,
        same_settings: false,
        not_before,
    }
}

/// The pixel in the middle of the same view.
fn pick_order() -> PickOrder {
    let Order { scene, scene_number, seen, size, .. } = order(1);
    PickOrder { scene, scene_number, seen, size, pixel: [24, 16], wish: Wish::List }
}

fn picture(delivery: Option<Delivery>) -> Box<Picture> {
    match delivery {
        Some(Delivery::Picture(picture)) => picture,
        Some(Delivery::Fault(fault)) => panic!("{}", fault.message),
        _ => panic!("no picture"),
    }
}

fn picked(delivery: Option<Delivery>) -> Picked {
    match delivery {
        Some(Delivery::Picked(picked)) => picked,
        _ => panic!("nothing picked"),
    }
}

fn lose(studio: &Studio) {
    studio.bench.as_ref().unwrap().renderer.gpu().device.destroy();
}

#[test]
fn a_device_that_is_lost_between_pictures_is_opened_again() {
    for kind in [Kind::Exact, Kind::Preview] {
        let Some(mut studio) = studio(kind) else {
            return;
        };
        let first = picture(studio.fill(&order(1)));
        assert!(first.rgba.chunks(4).any(|p| p != &first.rgba[..4]), "something is seen");
        for n in 2..4 {
            lose(&studio);
            let again = picture(studio.fill(&order(n)));
            assert!(again.rgba == first.rgba && again.size == first.size, "{kind:?}: another picture");
            assert_eq!(studio.said, None, "the picture is there, so there is nothing to say");
        }
        // It is a new one, not none at every picture.
        let kept = studio.bench.as_ref().unwrap().renderer.gpu().device.clone();
        picture(studio.fill(&order(9)));
        assert_eq!(studio.bench.as_ref().unwrap().renderer.gpu().device, kept);
    }
}

#[test]
fn what_lies_under_a_pixel_is_found_after_a_loss() {
    let Some(mut studio) = studio(Kind::Exact) else {
        return;
    };
    let first = picked(studio.pick(&pick_order()));
    assert!(first.layers.len() > 2, "{first:?}");
    lose(&studio);
    assert_eq!(picked(studio.pick(&pick_order())).layers, first.layers);
}

/// Of a model that is too much for previews, as it is.
fn heavy_order(number: u64, change: Change) -> Order {
    let scene = Arc::new(builtin::build("gearbox").unwrap());
    assert!(scene.triangle_count() > SOFTWARE_TRIANGLES && scene.triangle_count() <= MOST_AHEAD);
    let camera = camera::first(&scene.bounds(), 1.5);
    let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
    Order { scene, seen, size: [192, 128], change, ..order(number) }
}

#[test]
fn where_only_light_changes_previews_show_the_model_itself() {
    let Some(mut studio) = studio(Kind::Preview) else {
        return;
    };
    let simple = picture(studio.fill(&heavy_order(1, Change::Whole)));
    if !simple.software {
        println!("SKIPPED: previews of the model itself: a GPU draws no simpler one");
        return;
    }
    let resting = heavy_order(2, Change::Light);
    studio.draw_ahead(&resting);
    let mut other = resting.clone();
    other.seen.settings.opacity.gain = 0.5;
    // As where something else than the settings asks for the same light: the model itself is no simpler one.
    let transfer = Arc::new(other.seen.settings.opacity.transfer.resolve(None).unwrap());
    (other.same_settings, other.extras.transfer) = (true, Some(Arc::clone(&transfer)));
    let shown = picture(studio.fill(&other));
    assert_eq!(shown.report.kept, Kept::Features);
    let mut renderer = Renderer::new(Gpu::new(&GpuOptions::default()).unwrap()).unwrap();
    let model = renderer.load(&resting.scene).unwrap();
    let settings = lowered(&other.seen.settings, divisor(other.size, shown.size));
    let expected = renderer.render_with(&model, &other.seen.camera, &settings, &transfer, shown.size).unwrap();
    assert!(shown.rgba == rgba8(&expected.image, shown.background), "another picture than of the whole model");
    assert_ne!(shown.report.layers.stored, simple.report.layers.stored, "the simpler one has the same layers: no test");
    // After the next rest of the same view it is the model still, and nothing is captured again but for another size.
    let ahead = studio.bench.as_ref().unwrap().ahead.unwrap();
    studio.draw_ahead(&other);
    let then = studio.bench.as_ref().unwrap().ahead.unwrap();
    assert!(then == ahead || then.size != ahead.size, "{then:?} {ahead:?}");
    let mut third = other.clone();
    third.seen.settings.opacity.gain = 0.7;
    let shown = picture(studio.fill(&third));
    assert_eq!((shown.report.kept, shown.report.layers.stored > simple.report.layers.stored), (Kept::Features, true));
    // A viewport of another size is another picture, whatever else has changed.
    let mut resized = third.clone();
    resized.size = [96, 128];
    picture(studio.fill(&resized));
    assert_eq!(studio.bench.as_ref().unwrap().ahead, None);
    studio.draw_ahead(&third);
    // Another view is of the simpler one, and so is the light of that view, until it is drawn ahead again.
    let turned = |number, change| {
        let mut order = heavy_order(number, change);
        order.seen.camera = order.seen.camera.azimuth(30.0);
        order
    };
    let view = picture(studio.fill(&turned(3, Change::View)));
    let light = picture(studio.fill(&turned(4, Change::Light)));
    assert!(studio.bench.as_ref().unwrap().ahead.is_none());
    assert!(view.report.layers.stored > 0 && light.report.layers.stored > 0);
    studio.draw_ahead(&turned(5, Change::Light));
    assert_eq!(picture(studio.fill(&turned(6, Change::Light))).report.kept, Kept::Features);
}

#[test]
fn where_layers_are_not_kept_nothing_is_drawn_ahead() {
    let Some(mut studio) = studio(Kind::Preview) else {
        return;
    };
    for opaque in [
        "opacity.model=constant opacity.constant=1",
        "capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.tail=average",
    ] {
        let mut order = heavy_order(1, Change::Light);
        order.seen.settings = Settings::from_pairs(opaque).unwrap();
        studio.draw_ahead(&order);
        assert_eq!(studio.bench.as_ref().unwrap().ahead, None, "{opaque}");
        assert!(picture(studio.fill(&order)).rgba.iter().any(|&b| b > 0));
    }
}

#[test]
fn what_is_drawn_ahead_becomes_coarser_only() {
    let ahead = Ahead { size: [160, 100], viewport: [1280, 800], milliseconds: 100.0 };
    assert_eq!(ahead.at([160, 100]), Some(ahead));
    assert_eq!(ahead.at([320, 200]), Some(ahead), "finer ones wait");
    assert_eq!(ahead.at([80, 50]), Some(Ahead { size: [80, 50], ..ahead }));
    let slow = Ahead { milliseconds: 2.0 * LONGEST_AGAIN, ..ahead };
    assert_eq!((slow.at([160, 100]), slow.at([80, 50])), (Some(slow), None), "not worth a second capture");
}
