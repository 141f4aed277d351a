//! The layers counted behind the transfer-function editors are those of the store.

use pellucid::render::LayerHistogram;
use pellucid::scene::builtin;

use crate::common::*;

const SIZE: [u32; 2] = [72, 56];

#[test]
fn layers_are_counted_as_the_store_has_them() {
    let Some(mut r) = renderer() else { return };
    let scene = builtin::build("hard/assembly?seed=3").expect("a scene");
    let loaded = r.load(&scene).expect("a scene");
    for (pairs, orthographic) in [("", false), ("", true), ("kind=bkb k=5", false), ("kind=bkb k=8", true)] {
        let what = format!("{pairs}, orthographic {orthographic}");
        let (camera, settings) = (camera(&scene, orthographic), settings(pairs));
        let frame = r.render(&loaded, &camera, &settings, SIZE).expect("a frame");
        let counted = r.layer_histogram(&frame.report, &loaded, &camera).expect("counts").expect("something to count");
        let store = r.read_store(&frame.report, &loaded, &camera).expect("the store");
        let sphere = loaded.stats.bounds.bounding_sphere();
        let center = -camera.view_from_world().transform_point3(sphere.center).z;
        // The bounds as the shaders have them, in single precision.
        let [from, to] = [center - sphere.radius, center + sphere.radius].map(|v| f64::from(v as f32));
        let mut expected = LayerHistogram::empty();
        for (depth, kappa) in store.layers.depth.iter().zip(&store.kappa) {
            expected.add((depth - from) / (to - from), f64::from(*kappa));
        }
        assert!(expected.map.total() > 500, "{what}: only {} layers", expected.map.total());
        assert_eq!(counted.kappa.iter().sum::<u64>(), expected.map.total(), "{what}");
        assert_eq!(counted, expected, "{what}");
    }
    let opaque = r.render(&loaded, &camera(&scene, false), &settings("model=opaque"), SIZE).expect("a frame");
    let counted = r.layer_histogram(&opaque.report, &loaded, &camera(&scene, false)).expect("an answer");
    assert_eq!(counted, None, "no curvature is computed");
}
