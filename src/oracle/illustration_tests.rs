//! Cases worked out by hand, and the traps T12 to T19 in numbers.

use super::*;
use crate::oracle::ends::Ends;

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A row of pixels with so many layers each.
fn row(counts: &[u32]) -> StoreData {
    let mut store = StoreData { width: counts.len() as u32, height: 1, ..StoreData::default() };
    for &count in counts {
        store.offsets.push(store.depth.len());
        store.counts.push(count);
        store.overflowed.push(false);
        // One sheet behind the other, all of one part.
        store.depth.extend((0..count).map(|layer| f64::from(layer + 1)));
        store.part.resize(store.depth.len(), 0);
    }
    store
}

/// Sections 5.2 and 5.3, where every missing neighbour ends the surface openly.
fn begun(store: &StoreData, links: &[[Link; 4]], base: &[f64], bare: bool) -> Fields {
    let open: Vec<_> = links.iter().map(|l| l.map(|l| l == Link::Missing)).collect();
    let ends = Ends { surface: open.clone(), behind: vec![[false; 4]; open.len()], open };
    boundary(&Surfaces { store, links, ends: &ends, bare }, base)
}

/// Links to the right and to the left; nothing is known above and below.
fn link(right: Option<u32>, left: Option<u32>) -> [Link; 4] {
    let to = |l: Option<u32>| l.map_or(Link::Missing, Link::To);
    [to(right), to(left), Link::Unknown, Link::Unknown]
}

/// A sheet over four pixels, and before its right half another that begins there and goes on beyond the image.
fn two_sheets() -> (StoreData, Vec<[Link; 4]>) {
    let store = row(&[1, 1, 2, 2]);
    let mut links = vec![
        link(Some(0), None),
        link(Some(1), Some(0)),
        link(Some(0), None),
        link(Some(1), Some(0)),
        link(None, Some(0)),
        link(None, Some(1)),
    ];
    // Beyond the edges nothing is known.
    links[0][1] = Link::Unknown;
    links[4][0] = Link::Unknown;
    links[5][0] = Link::Unknown;
    (store, links)
}

fn settings() -> IllustrativeSettings {
    IllustrativeSettings::default()
}

#[test]
fn boundary_conditions_by_hand() {
    let (store, links) = two_sheets();
    let fields = begun(&store, &links, &[0.3; 6], false);
    // In order: far sheet in pixels 0 and 1, then near and far sheet in pixels 2 and 3.
    let expected = [
        ([0.3, 0.0, 0.0], [false, false]),
        ([0.3, 0.0, 1.0], [false, true]),
        ([0.3, 1.0, 0.0], [true, false]),
        ([0.3, 0.0, 0.0], [true, false]),
        ([0.3, 0.0, 0.0], [false, false]),
        ([0.3, 0.0, 0.0], [false, false]),
    ];
    for (i, (values, fixed)) in expected.into_iter().enumerate() {
        assert_eq!((fields.values[i], fields.fixed[i]), (values, fixed), "fragment {i}");
    }
}

#[test]
fn unknown_neighbours_make_no_silhouette() {
    let (store, mut links) = two_sheets();
    links[2][1] = Link::Unknown;
    let fields = begun(&store, &links, &[0.3; 6], false);
    assert!(
        fields.values.iter().all(|v| v[1] == 0.0 && v[2] == 0.0),
        "the near sheet's beginning is not known to be one"
    );
    assert!(fields.fixed.iter().all(|f| *f == [false; 2]));
}

/// Two faces that touch and swap places from pixel to pixel: nothing ends, so there is no halo.
#[test]
fn t19_touching_faces_sprinkle_halos_only_as_printed() {
    let store = row(&[2; 6]);
    let mut links: Vec<[Link; 4]> = (0..12).map(|i| link(Some(1 - i % 2), Some(1 - i % 2))).collect();
    for i in [0, 1] {
        links[i][1] = Link::Unknown;
        links[10 + i][0] = Link::Unknown;
    }
    let ours = begun(&store, &links, &[0.3; 12], false);
    assert!(ours.values.iter().all(|v| v[1..] == [0.0, 0.0]) && ours.fixed.iter().all(|f| *f == [false; 2]));
    let printed = begun(&store, &links, &[0.3; 12], true);
    assert_eq!(printed.values.iter().filter(|v| v[2] == 1.0).count(), 6, "every front layer");
    assert_eq!(printed.fixed.iter().filter(|f| f[0]).count(), 6, "every back layer");
}

#[test]
fn a_step_by_hand() {
    let (store, links) = two_sheets();
    let graph = Graph::isotropic(adjacency(&store, &links));
    assert_eq!(graph.around[1], [Some(3), Some(0), None, None]);
    let base = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    let mut s = settings();
    s.alpha.lambda = 0.5;
    s.beta.lambda = 0.25;
    s.gamma.lambda = 0.2;
    let next = step(&graph, &begun(&store, &links, &base, false), &s, 0);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} and {b}");
    // 0.1 + 0.125 · (0.2 − 0.1); 0.2 + 0.125 · ((0.4 − 0.2) + (0.1 − 0.2)).
    near(next.values[0][0], 0.1125);
    near(next.values[1][0], 0.2125);
    // β goes from the near sheet's edge to its next pixel, and stays fixed under it.
    assert_eq!(next.values.iter().map(|v| v[1]).collect::<Vec<_>>(), [0.0, 0.0, 1.0, 0.0, 0.75, 0.0]);
    // γ goes both ways along the far sheet.
    let gamma: Vec<f64> = next.values.iter().map(|v| v[2]).collect();
    for (found, expected) in gamma.into_iter().zip([0.8, 1.0, 0.0, 0.8, 0.0, 0.0]) {
        near(found, expected);
    }
    let none = IllustrativeSettings { iterations: 0, ..s };
    assert_eq!(step(&graph, &begun(&store, &links, &base, false), &none, 0).values[0][0], 0.1);
}

/// A random part of the pixel grid, its links with random conductances, and fields; without silhouettes everything is free.
fn subgraph(random: &mut Random) -> (Graph, Fields) {
    let (width, height) = (2 + (random.next() * 7.0) as usize, 2 + (random.next() * 7.0) as usize);
    let cut = 0.4 * random.next();
    let mut around = vec![[None; 4]; width * height];
    for p in 0..width * height {
        for d in [Direction::Right, Direction::Down] {
            if let Some(q) = d.step(p, width, height)
                && random.next() > cut
            {
                around[p][d as usize] = Some(q);
                around[q][d.opposite() as usize] = Some(p);
            }
        }
    }
    let values = (0..around.len())
        .map(|p| {
            let checkerboard = ((p % width + p / width) % 2) as f64;
            [if random.next() < 0.5 { checkerboard } else { random.next() }, random.next(), random.next()]
        })
        .collect();
    let fixed = vec![[false; 2]; around.len()];
    let mut graph = Graph::isotropic(around);
    for p in 0..width * height {
        for d in [Direction::Right, Direction::Down] {
            if let Some(q) = graph.around[p][d as usize] {
                let conductance = if random.next() < 0.3 { 1.0 } else { random.next() };
                graph.conductance[p][d as usize] = conductance;
                graph.conductance[q][d.opposite() as usize] = conductance;
            }
        }
    }
    (graph, Fields { values, fixed })
}

#[test]
fn t12_heat_keeps_the_maximum_principle_and_the_sum_for_every_lambda() {
    let mut random = Random(1);
    let mut s = settings();
    (s.beta.diffusion, s.gamma.diffusion, s.iterations) = (Diffusion::Heat, Diffusion::Heat, 100);
    for number in 0..1000 {
        let (graph, start) = subgraph(&mut random);
        // Both ends of the range, and something between.
        s.alpha.lambda = 0.9;
        s.beta.lambda = 0.01;
        s.gamma.lambda = 0.01 + 0.89 * random.next();
        let mut fields = start.clone();
        for k in 0..20 {
            let next = step(&graph, &fields, &s, k);
            for c in 0..3 {
                let column = |f: &Fields| f.values.iter().map(|v| v[c]).collect::<Vec<_>>();
                let (before, after) = (column(&fields), column(&next));
                let range = |v: &[f64]| (v.iter().copied().fold(1e9, f64::min), v.iter().copied().fold(-1e9, f64::max));
                let ((low, high), (l, h)) = (range(&before), range(&after));
                assert!(l >= low - 1e-12 && h <= high + 1e-12, "graph {number}, field {c}: {l} {h} of {low} {high}");
                let sums = (before.iter().sum::<f64>(), after.iter().sum::<f64>());
                assert!((sums.0 - sums.1).abs() < 1e-9 * before.len() as f64, "graph {number}, field {c}: {sums:?}");
            }
            fields = next;
        }
    }
}

#[test]
fn t12_as_printed_a_checkerboard_grows_sevenfold_a_step() {
    let (width, height) = (12, 12);
    let graph =
        Graph::isotropic((0..width * height).map(|p| Direction::ALL.map(|d| d.step(p, width, height))).collect());
    let values = (0..width * height).map(|p| [((p % width + p / width) % 2) as f64, 0.0, 0.0]).collect();
    let start = Fields { values, fixed: vec![[false; 2]; width * height] };
    let mut s = settings();
    s.iterations = 20;
    let spread = |f: &Fields| f.values.iter().map(|v| v[0].abs()).fold(0.0, f64::max);
    let ours = (0..20).fold(start.clone(), |f, k| step(&graph, &f, &s, k));
    assert!(spread(&ours) < 0.51);
    s.printed = PrintedForm::Laplacian;
    let printed = (0..20).fold(start, |f, k| step(&graph, &f, &s, k));
    println!("as printed: {:e} after 20 steps", spread(&printed));
    assert!(spread(&printed) > 1e15);
}

#[test]
fn t16_max_propagation_ends_after_one_over_lambda_steps_and_keeps_what_is_fixed() {
    // A row of 60 with a silhouette at its left end.
    let around = (0..60).map(|p| [(p < 59).then_some(p + 1), (p > 0).then(|| p - 1), None, None]).collect();
    let graph = Graph::isotropic(around);
    for lambda in [0.05, 0.07, 0.3, 0.9] {
        let mut s = settings();
        (s.beta.lambda, s.gamma.diffusion, s.alpha.diffusion) = (lambda, Diffusion::None, Diffusion::None);
        let mut values = vec![[0.5, 0.0, 0.0]; 60];
        values[0][1] = 1.0;
        let mut fixed = vec![[false; 2]; 60];
        fixed[0] = [true, false];
        let start = Fields { values, fixed };
        let end = diffuse(&graph, &start, &s);
        assert_eq!(step(&graph, &end, &s, 99), end, "λ = {lambda}: nothing changes any more");
        for (p, v) in end.values.iter().enumerate() {
            assert!((v[1] - (1.0 - lambda * p as f64).max(0.0)).abs() < 1e-9, "λ = {lambda}, {p} from the edge");
        }
        // One step less, and the profile is cut off.
        let reach = (1.0 / lambda - 1e-9) as u32;
        let short = (0..reach - u32::from(reach > 0)).fold(start.clone(), |f, k| step(&graph, &f, &s, k));
        assert!(reach == 0 || short != end);

        // A fragment under an edge holds β = 0 and lets nothing pass; as printed it is overwritten at once.
        let mut under = start.clone();
        under.fixed[1] = [true, false];
        let ours = diffuse(&graph, &under, &s);
        assert!(ours.values[1..].iter().all(|v| v[1] == 0.0));
        s.printed = PrintedForm::Propagation;
        assert!((diffuse(&graph, &under, &s).values[1][1] - (1.0 - lambda)).abs() < 1e-12);
    }
}

#[test]
fn t14_shares_sum_to_one_and_as_printed_to_anything() {
    let mut random = Random(3);
    let s = settings();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for _ in 0..2000 {
        let values: Vec<[f64; 3]> = (0..8).map(|_| [random.next(), random.next(), random.next()]).collect();
        let fields = Fields { fixed: vec![[false; 2]; 8], values };
        let opacities = opacities(&fields, &s);
        let own: Vec<f64> = opacities.iter().map(|a| 1.0 - a).collect();
        let (shares_of, left) = shares(&opacities, &own);
        assert!((shares_of.iter().sum::<f64>() + left - 1.0).abs() < 1e-12);
        let printed: Vec<f64> = fields.values.iter().map(|v| 1.0 - v[0]).collect();
        let (printed, left) = shares(&opacities, &printed);
        let sum = printed.iter().sum::<f64>() + left;
        (least, most) = (least.min(sum), most.max(sum));
    }
    println!("as printed the shares sum to {least:.3} to {most:.2}");
    assert!(least < 0.2 && most > 1.5);
}

#[test]
fn t15_profiles_are_bijections_of_the_unit_interval_with_their_limits() {
    for p in [0.0, 1e-12, 1e-8, 1e-3, 0.5, 3.0, 50.0] {
        let of = |profile, u| profiled(profile, u, p);
        let mut last = -1.0;
        for k in 0..=100 {
            let u = f64::from(k) / 100.0;
            let bell = of(Profile::Bell, u);
            assert!((0.0..=1.0 + 1e-12).contains(&bell) && bell > last, "p = {p}, u = {u}: {bell}");
            last = bell;
            if p < 1e-6 {
                assert!((bell - (1.0 - (1.0 - u) * (1.0 - u))).abs() < 1e-6);
            }
        }
        assert!(of(Profile::Bell, 0.0).abs() < 1e-12 && (of(Profile::Bell, 1.0) - 1.0).abs() < 1e-12);
        assert_eq!((of(Profile::Power, 0.0), of(Profile::Power, 1.0), of(Profile::None, 0.3)), (0.0, 1.0, 0.3));
    }
    // By hand: (e^{−2/4} − e^{−2}) / (1 − e^{−2}).
    let expected = ((-0.5_f64).exp() - (-2.0_f64).exp()) / (1.0 - (-2.0_f64).exp());
    assert!((profiled(Profile::Bell, 0.5, 2.0) - expected).abs() < 1e-12);
    assert_eq!(profiled(Profile::Power, 0.5, 2.0), 0.25);
}

#[test]
fn opacity_by_hand() {
    let fields =
        Fields { values: vec![[0.2, 0.5, 0.25], [0.2, 1.0, 0.0], [0.2, 0.0, 1.0]], fixed: vec![[false; 2]; 3] };
    let mut s = settings();
    s.beta.profile = Profile::None;
    let found = opacities(&fields, &s);
    for (found, expected) in found.into_iter().zip([0.75 * 0.6, 1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-15);
    }
}
