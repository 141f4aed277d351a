//! Curvature on the GPU over meshes whose surface has a known curvature: sphere, cylinder, torus, saddle.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3};
use pellucid::math::{Camera, Projection};
use pellucid::oracle::Link;
use pellucid::oracle::analytic::{Known, Placed, Shape};
use pellucid::render::Renderer;
use pellucid::scene::Scene;

use crate::common::*;
use crate::meshes;

/// Sensitivity: small enough that κ can be turned back into a curvature.
const SCALE: f64 = 0.02;

/// Each shape as a fine mesh with exact normals, turned so that it is seen from a corner.
fn shapes() -> Vec<(&'static str, Shape, Scene)> {
    let turned = DMat4::from_rotation_x(0.5) * DMat4::from_rotation_y(-0.4) * DMat4::from_rotation_z(0.3);
    let list = [
        ("sphere", Shape::Sphere { radius: 0.8 }, meshes::sphere(0.8, 256, 128)),
        ("cylinder", Shape::Cylinder { radius: 0.5 }, meshes::cylinder(0.5, 0.9, 256)),
        ("torus", Shape::Torus { major: 0.65, minor: 0.25 }, meshes::torus(0.65, 0.25, 256, 128)),
        ("saddle", Shape::Saddle { bend: 1.2 }, meshes::saddle(1.2, 0.8, 128)),
    ];
    list.into_iter()
        .map(|(name, shape, mesh)| {
            (name, shape, meshes::scene(meshes::grey(), vec![meshes::mesh(name, mesh)], vec![(0, turned)]))
        })
        .collect()
}

fn eye(orthographic: bool) -> Camera {
    let projection =
        if orthographic { Projection::Orthographic { height: 2.0 } } else { Projection::Perspective { fov_y: 0.5 } };
    Camera {
        position: DVec3::new(0.05, -0.03, 4.0),
        focal_point: DVec3::new(0.05, -0.03, 0.0),
        view_up: DVec3::Y,
        projection,
    }
}

/// A fragment: κ₁ + κ₂ as found, and what is known there.
#[derive(Clone, Copy)]
struct Found {
    x: u32,
    y: u32,
    layer: usize,
    sum: f64,
    known: Known,
}

/// For every fragment that has all four neighbours and faces the viewer enough: what is found, what is known.
fn found(
    r: &mut Renderer,
    shape: Shape,
    scene: &Scene,
    camera: &Camera,
    row: &str,
    size: u32,
    facing: f64,
) -> Vec<Found> {
    let row = format!("unit=world scale={SCALE} line=0 {row}");
    let shot = draw(r, scene, camera, &with_transfer(settings(&row), lively()), [size, size]);
    assert_finite(&shot, &row);
    let view = view_of(camera, [size, size]);
    let view_from_shape = camera.view_from_world() * scene.parts[0].world_from_part;
    let placed = Placed {
        shape,
        view_from_shape: DMat3::from_mat4(view_from_shape),
        center_in_view: view_from_shape.transform_point3(DVec3::ZERO),
    };
    let layers = &shot.store.layers;
    let pixel_of = layers.pixel_of_fragment();
    let mut all = Vec::new();
    for (i, &pixel) in pixel_of.iter().enumerate() {
        if shot.store.links[i].iter().any(|l| !matches!(l, Link::To(_))) {
            continue;
        }
        let (x, y) = layers.xy(pixel);
        let point = view.position(x, y, layers.depth[i]);
        let known = placed.known(point, view.to_eye(point));
        if known.facing > facing {
            let layer = i - layers.range(pixel).start;
            all.push(Found { x, y, layer, sum: -f64::from(shot.store.kappa[i]).atanh() / SCALE, known });
        }
    }
    assert!(all.len() > 1500, "only {} fragments", all.len());
    all
}

#[test]
fn surface_curvature_is_within_two_percent() {
    let Some(mut r) = renderer() else { return };
    for (name, shape, scene) in shapes() {
        for orthographic in [false, true] {
            for row in ["", "radius=0.02 crease=60", "kind=bkb k=8"] {
                let all = found(&mut r, shape, &scene, &eye(orthographic), row, 128, 0.3);
                let mut errors: Vec<f64> = all
                    .iter()
                    .map(|f| {
                        let [a, b] = f.known.principal;
                        (f.sum - a - b).abs() / (a.abs() + b.abs())
                    })
                    .collect();
                let p95 = percentile(&mut errors, 0.95);
                println!(
                    "surface, {name}, orthographic {orthographic} [{row}]: p95 {:.3} % of |κ₁| + |κ₂|, {} fragments",
                    100.0 * p95,
                    errors.len()
                );
                assert!(p95 < 0.02, "{name}: {p95}");
            }
        }
    }
}

#[test]
fn view_centred_curvature_is_the_hessian_of_depth() {
    let Some(mut r) = renderer() else { return };
    for (name, shape, scene) in shapes() {
        let mut at = |size: u32| {
            let all = found(&mut r, shape, &scene, &eye(true), "curvature=view_centred radius=0 crease=180", size, 0.5);
            let mut errors: Vec<f64> = all
                .iter()
                .map(|f| {
                    let h = f.known.depth_hessian;
                    (f.sum - h.x_axis.x - h.y_axis.y).abs() / (h.x_axis.length() + h.y_axis.length())
                })
                .collect();
            percentile(&mut errors, 0.95)
        };
        let (coarse, fine) = (at(96), at(192));
        println!(
            "view-centred, {name}: p95 {:.2} % of the Hessian at 96², {:.2} % at 192²",
            100.0 * coarse,
            100.0 * fine
        );
        // Differences over a pixel fall behind with the square of its size, down to what facets leave.
        assert!(fine < 0.03 && (fine < 0.5 * coarse || coarse < 0.005), "{name}: {coarse} {fine}");
    }
}

#[test]
fn kappa_is_the_same_when_the_resolution_doubles() {
    let Some(mut r) = renderer() else { return };
    for (name, shape, scene) in shapes() {
        for kind in ["surface", "view_centred"] {
            let row = format!("curvature={kind} radius=0.015625 crease=60");
            let [coarse, fine] = [128, 256].map(|size| found(&mut r, shape, &scene, &eye(false), &row, size, 0.5));
            let nearest = |all: &[Found]| -> HashMap<(u32, u32), Found> {
                all.iter().filter(|f| f.layer == 0).map(|f| ((f.x, f.y), *f)).collect()
            };
            let (coarse, fine) = (nearest(&coarse), nearest(&fine));
            let mut errors = Vec::new();
            for (&(x, y), f) in &coarse {
                let four: Vec<f64> = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .iter()
                    .filter_map(|(i, j)| fine.get(&(2 * x + i, 2 * y + j)))
                    .map(|f| f.sum)
                    .collect();
                if four.len() == 4 {
                    let h = f.known.depth_hessian;
                    let size = match kind {
                        "surface" => f.known.principal[0].abs() + f.known.principal[1].abs(),
                        _ => h.x_axis.length() + h.y_axis.length(),
                    };
                    errors.push((f.sum - 0.25 * four.iter().sum::<f64>()).abs() / size);
                }
            }
            assert!(errors.len() > 500);
            let p95 = percentile(&mut errors, 0.95);
            println!("{name}, {kind}: p95 {:.2} % between 128² and 256², {} pixels", 100.0 * p95, errors.len());
            assert!(p95 < if kind == "surface" { 0.02 } else { 0.05 }, "{name}, {kind}: {p95}");
        }
    }
}
