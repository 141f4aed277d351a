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
    Order { number, scene, scene_number: 1, seen, extras: Extras::default(), size, change, not_before }
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
