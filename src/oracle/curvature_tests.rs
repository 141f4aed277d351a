//! Curvature on cases with known answers.

use super::*;
use crate::oracle::analytic::{Placed, Shape};
use crate::oracle::neighbours::neighbours;
use glam::DMat3;

fn view(size: u32, perspective: bool) -> View {
    let half = if perspective { 0.25 } else { 1.0 };
    View { width: size, height: size, perspective, half_extent: DVec2::splat(half), shift: DVec2::ZERO }
}

fn extents() -> Extents {
    Extents { part_radii: vec![1.0], scene_radius: 1.0, visible_height: 2.0, depth_range: [3.0, 5.0] }
}

fn settings(kind: CurvatureKind) -> CurvatureSettings {
    CurvatureSettings { kind, ..CurvatureSettings::default() }
}

fn placed(shape: Shape) -> Placed {
    let turned = DMat3::from_rotation_x(0.5) * DMat3::from_rotation_y(-0.4) * DMat3::from_rotation_z(0.3);
    Placed { shape, view_from_shape: turned, center_in_view: DVec3::new(0.05, -0.03, -4.0) }
}

const SURFACES: [Shape; 4] = [
    Shape::Sphere { radius: 0.8 },
    Shape::Cylinder { radius: 0.5 },
    Shape::Torus { major: 0.65, minor: 0.25 },
    Shape::Saddle { bend: 1.2 },
];

/// The error of every fragment with n·v > `facing` whose links are all there, sorted.
fn errors(
    shape: &Placed,
    facing: f64,
    view: &View,
    settings: &CurvatureSettings,
    error: impl Fn(f64, [f64; 3], &crate::oracle::analytic::Known) -> f64,
) -> Vec<f64> {
    let store = shape.store(view, [2.0, 6.0]);
    let links = neighbours(&store, &extents(), true);
    let found = curvature(&store, &links, view, &extents(), settings);
    let pixel_of = store.pixel_of_fragment();
    let mut errors = Vec::new();
    for (i, &pixel) in pixel_of.iter().enumerate() {
        let (x, y) = store.xy(pixel);
        let point = view.position(x, y, store.depth[i]);
        let known = shape.known(point, view.to_eye(point));
        if known.facing > facing && links.links[i].iter().all(|l| matches!(l, Link::To(_))) {
            errors.push(error(found.sum[i], found.operator[i], &known));
        }
    }
    assert!(errors.len() > 1000, "{:?}: only {} fragments", shape.shape, errors.len());
    errors.sort_by(f64::total_cmp);
    errors
}

fn p95(errors: &[f64]) -> f64 {
    errors[errors.len() * 95 / 100]
}

#[test]
fn surface_curvature_is_within_two_percent() {
    for perspective in [false, true] {
        for shape in SURFACES {
            let errors = errors(
                &placed(shape),
                0.3,
                &view(96, perspective),
                &settings(CurvatureKind::Surface),
                |sum, _, known| {
                    let [a, b] = known.principal;
                    (sum - (a + b)).abs() / (a.abs() + b.abs())
                },
            );
            println!("surface, perspective {perspective}, {shape:?}: p95 {:.4}", p95(&errors));
            assert!(p95(&errors) < 0.02, "{shape:?}: {}", p95(&errors));
        }
    }
}

#[test]
fn principal_directions_are_kept() {
    // The whole operator, not only its trace: its determinant is the Gaussian curvature.
    for shape in SURFACES {
        let errors =
            errors(&placed(shape), 0.3, &view(96, false), &settings(CurvatureKind::Surface), |_, [xx, xy, yy], k| {
                let [a, b] = k.principal;
                (xx * yy - xy * xy - a * b).abs() / (a.abs() + b.abs()).powi(2)
            });
        assert!(p95(&errors) < 0.02, "{shape:?}: {}", p95(&errors));
    }
}

#[test]
fn view_centred_curvature_is_the_depth_hessian() {
    // Towards silhouettes the Hessian grows like (n·v)⁻³ and differences over a pixel fall behind it, so besides being
    // close the error has to fall with the square of the pixel size.
    let at = |shape: Shape, size: u32| {
        let settings = CurvatureSettings { radius: 0.0, ..settings(CurvatureKind::ViewCentred) };
        errors(&placed(shape), 0.5, &view(size, false), &settings, |sum, [xx, xy, yy], known| {
            let h = known.depth_hessian;
            let size = h.x_axis.length() + h.y_axis.length();
            let worst = [xx - h.x_axis.x, xy - h.x_axis.y, yy - h.y_axis.y, sum - h.x_axis.x - h.y_axis.y]
                .iter()
                .fold(0.0_f64, |m, e| m.max(e.abs()));
            worst / size
        })
    };
    for shape in SURFACES {
        let (coarse, fine) = (at(shape, 96), at(shape, 192));
        println!("view centred, {shape:?}: p95 {:.4}, {:.4} at twice the resolution", p95(&coarse), p95(&fine));
        assert!(p95(&fine) < 0.03, "{shape:?}: {}", p95(&fine));
        assert!(p95(&fine) < 0.35 * p95(&coarse), "{shape:?}: {} {}", p95(&coarse), p95(&fine));
    }
}

#[test]
fn it_is_the_same_when_the_resolution_doubles() {
    let shape = placed(SURFACES[2]);
    for kind in [CurvatureKind::Surface, CurvatureKind::ViewCentred] {
        let kappa_at = |size: u32, x: f64, y: f64| {
            let view = view(size, false);
            let store = shape.store(&view, [2.0, 6.0]);
            let links = neighbours(&store, &extents(), true);
            let found = curvature(&store, &links, &view, &extents(), &settings(kind));
            let pixel = (y * f64::from(size)) as usize * size as usize + (x * f64::from(size)) as usize;
            found.kappa[store.offsets[pixel]]
        };
        // The front of the tube's right-hand side.
        let (coarse, fine) = (kappa_at(64, 0.8, 0.52), kappa_at(128, 0.8, 0.52));
        assert!((coarse - fine).abs() < 0.01, "{kind:?}: {coarse} {fine}");
        assert!(coarse < -0.05, "convex: {coarse}");
    }
}

#[test]
fn an_oblique_plane_is_flat() {
    for perspective in [false, true] {
        let view = view(24, perspective);
        let plane = placed(Shape::Plane { normal: DVec3::new(0.9, 0.3, 0.3) });
        let store = plane.store(&view, [1.0, 9.0]);
        let links = neighbours(&store, &extents(), true);
        for kind in [CurvatureKind::Surface, CurvatureKind::ViewCentred] {
            let settings = CurvatureSettings { radius: 0.05, line_width: 0.0, ..settings(kind) };
            let found = curvature(&store, &links, &view, &extents(), &settings);
            let inner = (0..store.len()).filter(|&i| links.links[i].iter().all(|l| matches!(l, Link::To(_))));
            assert!(inner.clone().count() > 100);
            assert!(inner.clone().all(|i| found.kappa[i].abs() < 1e-6 && found.sum[i].abs() < 1e-5));
        }
    }
}

/// A row of fragments, one a pixel, with the given normals, at depth 1.
fn row(normals: &[DVec3], depth: impl Fn(f64) -> f64) -> (StoreData, View) {
    let mut store = StoreData { width: normals.len() as u32, height: 1, ..StoreData::default() };
    let view = View {
        width: store.width,
        height: 1,
        perspective: false,
        half_extent: DVec2::new(0.5 * normals.len() as f64, 0.5),
        shift: DVec2::ZERO,
    };
    for (x, n) in normals.iter().enumerate() {
        store.offsets.push(x);
        store.counts.push(1);
        store.overflowed.push(false);
        store.part.push(0);
        store.depth.push(depth(x as f64));
        store.normal.push(n.as_vec3().to_array());
    }
    (store, view)
}

fn kappas(store: &StoreData, view: &View, settings: &CurvatureSettings) -> Curvature {
    let extents = Extents { part_radii: vec![100.0], ..extents() };
    curvature(store, &neighbours(store, &extents, true), view, &extents, settings)
}

#[test]
fn a_crease_by_hand() {
    // A roof, its ridge between pixels 2 and 3: 60° between the two slopes.
    let (left, right) = (DVec3::new(-0.5, 0.0, 0.75_f64.sqrt()), DVec3::new(0.5, 0.0, 0.75_f64.sqrt()));
    let settings = CurvatureSettings {
        scale: 0.5,
        unit: CurvatureUnit::World,
        radius: 0.0,
        line_width: 0.0,
        ..settings(CurvatureKind::Surface)
    };
    let slope = 0.5 / 0.75_f64.sqrt();
    for (sign, normals) in
        [(-1.0, [left, left, left, right, right, right]), (1.0, [right, right, right, left, left, left])]
    {
        let (store, view) = row(&normals, |x| 5.0 - sign * slope * (x - 2.5).abs());
        let found = kappas(&store, &view, &settings);
        let expected = sign * (0.5 * std::f64::consts::FRAC_PI_3).tanh();
        for (i, kappa) in found.kappa.iter().enumerate() {
            let expected = if i == 2 || i == 3 { expected } else { 0.0 };
            assert!((kappa - expected).abs() < 1e-6, "{sign} {i}: {kappa}");
        }
    }
}

#[test]
fn without_a_crease_angle_one_axis_gives_the_curvature_along_it() {
    // As printed: a cylinder across the row, normals turning by 0.1 radian a pixel, so the slope of the
    // normal is sin(0.1) a pixel.
    let normals: Vec<DVec3> =
        (-3..=3).map(|i| DVec3::new((0.1 * f64::from(i)).sin(), 0.0, (0.1 * f64::from(i)).cos())).collect();
    let (store, view) = row(&normals, |_| 5.0);
    let settings = CurvatureSettings {
        scale: 1.0,
        unit: CurvatureUnit::World,
        radius: 0.0,
        crease_angle: 180.0,
        line_width: 0.0,
        ..settings(CurvatureKind::Surface)
    };
    let found = kappas(&store, &view, &settings);
    assert!((found.sum[3] - 0.1_f64.sin()).abs() < 1e-6, "{}", found.sum[3]);
    assert!((found.kappa[3] + 0.1_f64.sin().tanh()).abs() < 1e-6);
    assert!((found.operator[3][0] - 0.1_f64.sin()).abs() < 1e-6 && found.operator[3][2].abs() < 1e-9);
}

#[test]
fn a_rim_is_convex_and_the_border_of_the_image_is_not() {
    let (mut store, view) = row(&[DVec3::Z; 6], |_| 5.0);
    let settings = CurvatureSettings { line_width: 0.0, ..settings(CurvatureKind::Surface) };
    assert_eq!(kappas(&store, &view, &settings).kappa, [0.0; 6], "unknown beyond the border");
    store.part[5] = 1;
    assert_eq!(kappas(&store, &view, &settings).kappa, [0.0, 0.0, 0.0, 0.0, -1.0, -1.0]);
    store.overflowed[5] = true;
    assert_eq!(
        kappas(&store, &view, &settings).kappa,
        [0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
        "unknown where the list of the last pixel is cut"
    );
}

#[test]
fn lines_have_their_width() {
    // 200 × 200 pixels, line width 0.0125: 2.5 pixels of rim, covered 1, 1, 0.5.
    let size = 200_usize;
    let mut store = StoreData { width: size as u32, height: size as u32, ..StoreData::default() };
    for pixel in 0..size * size {
        let (x, y) = (pixel % size, pixel / size);
        store.offsets.push(store.depth.len());
        let there = y == 100 && x < 50;
        store.counts.push(u32::from(there));
        store.overflowed.push(y == 99 || y == 101);
        if there {
            store.part.push(0);
            store.depth.push(5.0);
            store.normal.push([0.0, 0.0, 1.0]);
        }
    }
    let settings = CurvatureSettings { line_width: 0.0125, ..settings(CurvatureKind::Surface) };
    let found = kappas(&store, &view(size as u32, false), &settings);
    assert_eq!(found.kappa[44..50], [0.0, 0.0, 0.0, -0.5, -1.0, -1.0]);
}

#[test]
fn a_fragment_alone_and_no_fragment_at_all_are_flat() {
    let (store, view) = row(&[DVec3::Z], |_| 1.0);
    assert_eq!(kappas(&store, &view, &settings(CurvatureKind::ViewCentred)).kappa, [0.0]);
    let empty = StoreData {
        width: 1,
        height: 1,
        counts: vec![0],
        overflowed: vec![false],
        offsets: vec![0],
        ..StoreData::default()
    };
    assert!(kappas(&empty, &view, &settings(CurvatureKind::Surface)).kappa.is_empty());
    let none = StoreData::default();
    assert!(kappas(&none, &view, &settings(CurvatureKind::Surface)).kappa.is_empty());
}

#[test]
fn degenerate_normals_stay_finite() {
    for n in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(0.0, 1.0, -1e-9)] {
        let (store, view) = row(&[DVec3::Z, n, DVec3::Z], |x| 5.0 + x * 1e6);
        for kind in [CurvatureKind::Surface, CurvatureKind::ViewCentred] {
            let settings = CurvatureSettings { crease_angle: 180.0, ..settings(kind) };
            let found = kappas(&store, &view, &settings);
            assert!(found.kappa.iter().all(|k| k.is_finite() && k.abs() <= 1.0), "{n} {kind:?}: {:?}", found.kappa);
        }
    }
}
