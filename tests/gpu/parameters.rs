//! Neighbours by distance in the surface's parametrization.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap};

use glam::{DVec2, DVec3, Vec3};
use pellucid::oracle::{Direction, Link, StoreData, compare, continuity, rasterize};
use pellucid::plan::Pass;
use pellucid::scene::{Scene, builtin};
use pellucid::settings::DepthTerm;

use crate::common::*;
use crate::meshes;

const SIZE: [u32; 2] = [64, 56];
const CAPTURES: [&str; 4] = ["kind=compacted", "kind=lists", "kind=bkb k=64", "kind=bkb k=64 normals=full"];

fn flow(rows: u32) -> Scene {
    builtin::build(&format!("flow?rows={rows}")).expect("a scene")
}

/// Parameters within what snapping vertices to 1/256 pixel may move them; how far they go over a pixel within a tenth.
fn compare_parameters(found: &StoreData, expected: &StoreData, ambiguous: impl Fn(usize) -> bool) -> (usize, usize) {
    let pixels = found.pixel_of_fragment();
    let (mut compared, mut steps_off) = (0, 0);
    for (i, &pixel) in pixels.iter().enumerate().filter(|(_, pixel)| !ambiguous(**pixel)) {
        let other = expected.range(pixel).find(|&j| expected.triangle[j] == found.triangle[i]);
        let (a, Some(b)) = (found.parameters[i], other.map(|j| expected.parameters[j])) else {
            panic!("triangle {} is not there", found.triangle[i]);
        };
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
        let may = (b[2] + b[3]) / 128.0 + 2e-5;
        assert!(apart <= may, "pixel {pixel}: {a:?} and {b:?}");
        let close = |a: f32, b: f32| (a - b).abs() <= 0.1 * b + 1e-5;
        steps_off += usize::from(!close(a[2], b[2]) || !close(a[3], b[3]));
        compared += 1;
    }
    (compared, steps_off)
}

#[test]
fn parameters_and_links_are_the_oracles_over_every_capture() {
    let Some(mut r) = renderer() else { return };
    for (name, scene, orthographic) in
        [("flow", flow(32), false), ("flow in parallel", flow(32), true), ("assembly", meshes::assembly(5), false)]
    {
        let camera = camera(&scene, orthographic);
        let layers = rasterize(&scene, &camera, SIZE, DVec2::ZERO);
        let expected = StoreData::from_layers(&layers);
        let mut first: Option<Vec<[Link; 4]>> = None;
        for capture in CAPTURES {
            let s = settings(&format!("model=illustrative features.depth_term=parameters {capture}"));
            let shot = draw(&mut r, &scene, &camera, &s, SIZE);
            assert_finite(&shot, capture);
            assert!(shot.frame.report.plan.runs(Pass::Parametrize));
            let store = &shot.store.layers;
            assert_eq!(store.parameters.len(), store.len());
            let (compared, off) = compare_parameters(store, &expected, |pixel| layers.pixels[pixel].ambiguous);
            assert!(compared > 1500 && off * 50 < compared, "{name}, {capture}: {off} steps of {compared} are off");
            let links = compare::links(&scene, &camera, store, &shot.store.links, (DepthTerm::Parameters, true));
            println!("{name}, {capture}: {compared} layers, {} ambiguous links of {}", links.ambiguous, links.samples);
            assert_eq!(links.faults, Vec::new(), "{name}, {capture}");
            assert!(links.ambiguous_share() <= compare::AMBIGUOUS, "{name}, {capture}");
            assert_eq!(continuity::one_way(store, &shot.store.links), 0, "{name}, {capture}");
            // Full normals may decide a seam otherwise; everything else is the same.
            if !capture.contains("full") {
                let first = first.get_or_insert_with(|| shot.store.links.clone());
                assert_first(first, &shot.store.links, capture);
            }
        }
    }
}

#[test]
fn without_a_parametrization_it_is_continuity_and_the_plan_says_so() {
    let Some(mut r) = renderer() else { return };
    let scene = meshes::soups(4, 5, 14);
    let camera = camera(&scene, false);
    let by = |r: &mut _, term: &str| {
        draw(r, &scene, &camera, &settings(&format!("model=illustrative features.depth_term={term}")), SIZE)
    };
    let (continuity, parameters) = (by(&mut r, "continuity"), by(&mut r, "parameters"));
    continuity.assert_same(&parameters, "no parametrization");
    let plan = &parameters.frame.report.plan;
    assert!(!plan.runs(Pass::Parametrize));
    assert!(plan.skipped.iter().any(|s| s.what == "parametrize" && s.reason.contains("continuity")), "{plan}");
    // Of the assembly, one part has coordinates.
    let scene = meshes::assembly(5);
    let shot = draw(&mut r, &scene, &camera, &settings("model=illustrative features.depth_term=parameters"), SIZE);
    let planned = shot.frame.report.plan.passes.iter().find(|p| p.pass == Pass::Parametrize).expect("it runs");
    assert!(planned.reason.contains("9 parts without one are measured by continuity"), "{}", planned.reason);
}

#[test]
fn bands_do_not_show() {
    let (Some(mut r), Some(mut small)) = (renderer(), small_renderer()) else { return };
    let scene = flow(32);
    let camera = camera(&scene, false);
    for capture in ["kind=compacted", "kind=lists", "kind=bkb k=16"] {
        let s = settings(&format!(
            "model=illustrative features.depth_term=parameters opacity.illustrative.feature_size=0 opacity.illustrative.iterations=2 \
             opacity.illustrative.beta.lambda=0.5 opacity.illustrative.gamma.lambda=0.5 {capture}"
        ));
        let whole = draw(&mut r, &scene, &camera, &s, [64, 90]);
        let banded = draw(&mut small, &scene, &camera, &s, [64, 90]);
        assert!(banded.frame.report.bands > 1, "{capture}");
        assert_first(&whole.bits(), &banded.bits(), capture);
    }
}

/// Shortest ways along the edges of a mesh, which say whether two points are near on the surface itself.
struct Geodesics {
    corners: Vec<[u32; 3]>,
    points: Vec<DVec3>,
    edges: HashMap<u32, BTreeSet<u32>>,
}

impl Geodesics {
    fn new(scene: &Scene) -> Geodesics {
        let primitive = &scene.meshes[0].primitives[0];
        let mut edges: HashMap<u32, BTreeSet<u32>> = HashMap::new();
        for t in &primitive.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                edges.entry(a).or_default().insert(b);
                edges.entry(b).or_default().insert(a);
            }
        }
        let points = primitive.positions.iter().map(|&p| Vec3::from(p).as_dvec3()).collect();
        Geodesics { corners: primitive.triangles.clone(), points, edges }
    }

    /// Whether a way of at most `most` leads from a point on one triangle to a point on another.
    fn is_near(&self, (from, a): (usize, DVec3), (to, b): (usize, DVec3), most: f64) -> bool {
        if from == to {
            return true;
        }
        let mut reached: HashMap<u32, f64> = HashMap::new();
        let mut heap = BinaryHeap::new();
        // Distances are positive, so their bits are in their order.
        for &v in &self.corners[from] {
            heap.push(Reverse((a.distance(self.points[v as usize]).to_bits(), v)));
        }
        while let Some(Reverse((bits, v))) = heap.pop() {
            let so_far = f64::from_bits(bits);
            if so_far > most {
                return false;
            }
            if reached.contains_key(&v) {
                continue;
            }
            reached.insert(v, so_far);
            if self.corners[to].contains(&v) && so_far + b.distance(self.points[v as usize]) <= most {
                return true;
            }
            for &next in &self.edges[&v] {
                let on = so_far + self.points[v as usize].distance(self.points[next as usize]);
                heap.push(Reverse((on.to_bits(), next)));
            }
        }
        false
    }
}

/// The sheets of the scrolls nearly touch. Whether two linked layers are neighbours on the surface is judged by the mesh alone:
/// the way along its edges must not be much longer than the straight one.
#[test]
fn on_a_rolled_up_sheet_parameters_go_wrong_less_often_than_continuity() {
    let Some(mut r) = renderer() else { return };
    let scene = flow(96);
    let ways = Geodesics::new(&scene);
    let mut wrong_by = HashMap::new();
    for direction in [DVec3::new(-0.37, -0.41, -0.83), DVec3::new(-1.0, -0.1, -0.2)] {
        let camera = pellucid::math::Camera::framing(&scene.bounds(), direction, DVec3::Y, 1.0, 1.9, false, 0.6);
        let world_from_view = camera.view_from_world().inverse();
        let view = view_of(&camera, SIZE);
        for term in ["slope", "continuity", "parameters"] {
            let s = settings(&format!("model=illustrative normals=full features.depth_term={term}"));
            let store = draw(&mut r, &scene, &camera, &s, SIZE).store;
            let pixels = store.layers.pixel_of_fragment();
            let place = |i: usize| {
                let (x, y) = store.layers.xy(pixels[i]);
                let point = world_from_view.transform_point3(view.position(x, y, store.layers.depth[i]));
                (store.layers.triangle[i] as usize, point)
            };
            let (wrong, links) = wrong_by.entry(term).or_insert((0, 0));
            for (i, all) in store.links.iter().enumerate() {
                for direction in [Direction::Right, Direction::Down] {
                    let Link::To(layer) = all[direction as usize] else { continue };
                    let q = direction.step(pixels[i], SIZE[0] as usize, SIZE[1] as usize).expect("a pixel");
                    let (a, b) = (place(i), place(store.layers.offsets[q] + layer as usize));
                    *links += 1;
                    // Ways along edges zigzag, and begin and end at corners.
                    *wrong += usize::from(!ways.is_near(a, b, 2.0 * a.1.distance(b.1) + 0.15));
                }
            }
        }
    }
    let share = |term: &str| {
        let (wrong, links) = wrong_by[term];
        println!("{term}: {wrong} of {links} links lead to another sheet");
        assert!(links > 5000);
        wrong as f64 / links as f64
    };
    let [slope, continuity, parameters] = ["slope", "continuity", "parameters"].map(share);
    assert!(parameters < 0.25 * continuity && parameters < 0.5 * slope);
}
