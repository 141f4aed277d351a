use glam::{DMat4, DVec3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::scene::builtin::{self, samples};
use crate::scene::{Mesh, PartLook, Presence, Primitive};

fn section(normal: DVec3, offset: f64) -> Section {
    Section { normal: normal.normalize(), offset, enabled: true, caps: true }
}

fn cut(scene: &Scene, sections: impl IntoIterator<Item = Section>) -> Cut {
    let arrangement = Arrangement { sections: sections.into_iter().collect(), ..Arrangement::default() };
    arrangement.check(scene).unwrap();
    Cut::new(scene, &arrangement, &Solids::of(scene))
}

/// One part for each mesh and transform.
fn placed(meshes: Vec<Primitive>, nodes: Vec<(usize, DMat4)>) -> Scene {
    let meshes = meshes.into_iter().map(|p| samples::mesh("m", p)).collect();
    samples::scene(samples::grey(), meshes, nodes).finish().unwrap()
}

fn unit_cube() -> Primitive {
    samples::cuboid(DVec3::splat(0.5))
}

fn area(cut: &Cut) -> f64 {
    cut.caps.iter().map(Cap::area).sum()
}

/// Vertices of a cap in scene space.
fn corners(cap: &Cap) -> Vec<DVec3> {
    let at = |p: &[f32; 2]| cap.world_from_cap.transform_point3(DVec3::new(p[0].into(), p[1].into(), 0.0));
    cap.positions.iter().map(at).collect()
}

#[test]
fn a_cube_cut_in_the_middle_has_a_cap_of_area_one() {
    let scene = placed(vec![unit_cube()], vec![(0, DMat4::IDENTITY)]);
    for normal in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        let found = cut(&scene, [section(normal, 0.0)]);
        assert_eq!(found.caps.len(), 1);
        let cap = &found.caps[0];
        assert!((cap.area() - 1.0).abs() < 1e-7, "{normal}: {}", cap.area());
        assert_eq!((cap.part, cap.first_triangle, found.planes[0].caps.clone()), (0, 12, 1..2));
        assert_eq!((found.owner(0), found.owner(1)), (0, 0));
        assert!(cap.world_from_cap.transform_vector3(DVec3::Z).distance(normal) < 1e-15);
        assert!(corners(cap).iter().all(|p| p.dot(normal).abs() < 1e-12));
        assert!(found.open.is_empty() && cap.triangles.iter().flatten().all(|&i| i < cap.positions.len() as u32));
    }
    // A quarter of the way, and beyond.
    assert!((area(&cut(&scene, [section(DVec3::X, 0.25)])) - 1.0).abs() < 1e-7);
    assert!(cut(&scene, [section(DVec3::X, 0.75)]).caps.is_empty());
    let mut without = section(DVec3::X, 0.0);
    without.caps = false;
    let found = cut(&scene, [without]);
    assert_eq!((found.planes.len(), found.caps.len()), (1, 0));
    without.enabled = false;
    assert!(cut(&scene, [without]).planes.is_empty());
}

#[test]
fn a_plane_in_a_face_replaces_it_or_takes_it_away() {
    let scene = placed(vec![unit_cube()], vec![(0, DMat4::IDENTITY)]);
    // The cube lies below its face: the cap stands for it. It lies above the other: nothing is left.
    assert!((area(&cut(&scene, [section(DVec3::Y, 0.5)])) - 1.0).abs() < 1e-7);
    assert!(cut(&scene, [section(DVec3::NEG_Y, -0.5)]).caps.is_empty());
    // The same where rounding has to be forgiven: turned about an odd angle, far out.
    let turned = DMat4::from_translation(DVec3::new(70.3, 11.7, -3.1)) * DMat4::from_rotation_x(0.37);
    let scene = placed(vec![unit_cube()], vec![(0, turned)]);
    let normal = turned.transform_vector3(DVec3::Y);
    let offset = normal.dot(turned.transform_point3(DVec3::Y * 0.5));
    assert!((area(&cut(&scene, [section(normal, offset)])) - 1.0).abs() < 1e-6);
    assert!(cut(&scene, [section(-normal, -offset)]).caps.is_empty());
}

#[test]
fn a_plane_through_vertices_and_edges_closes() {
    let scene = placed(vec![unit_cube()], vec![(0, DMat4::IDENTITY)]);
    // Through two opposite edges: 1 by √2. Through six vertices' middle: a hexagon with sides of √½.
    assert!((area(&cut(&scene, [section(DVec3::new(1.0, 1.0, 0.0), 0.0)])) - 2.0_f64.sqrt()).abs() < 1e-6);
    let hexagon = 1.5 * 3.0_f64.sqrt() * 0.5;
    assert!((area(&cut(&scene, [section(DVec3::ONE, 0.0)])) - hexagon).abs() < 1e-6);
    // Through three vertices, then just the corner.
    let triangle = 3.0_f64.sqrt() / 4.0 * 2.0;
    assert!((area(&cut(&scene, [section(DVec3::ONE, 0.5 / 3.0_f64.sqrt())])) - triangle).abs() < 1e-6);
    let corner = cut(&scene, [section(DVec3::ONE, 1.5 / 3.0_f64.sqrt())]);
    assert!(area(&corner) < 1e-9 && corner.open.is_empty());
    // A ball through its poles and a ring of vertices.
    let ball = placed(vec![samples::sphere(1.0, 64, 32)], vec![(0, DMat4::IDENTITY)]);
    let disc = 0.5 * 64.0 * (std::f64::consts::TAU / 64.0).sin();
    for normal in [DVec3::X, DVec3::Y, DVec3::Z] {
        let found = cut(&ball, [section(normal, 0.0)]);
        assert!(found.open.is_empty() && (area(&found) - disc).abs() < 0.01, "{normal}: {}", area(&found));
    }
}

#[test]
fn a_torus_is_two_discs_or_an_annulus() {
    let torus = placed(vec![samples::torus(1.0, 0.4, 96, 48)], vec![(0, DMat4::IDENTITY)]);
    let thinnest = torus.bounds().size().min_element();
    let axis = if torus.bounds().size().z == thinnest { DVec3::Z } else { DVec3::Y };
    let across = axis.any_orthonormal_vector();
    let polygon = |n: f64, r: f64| 0.5 * n * r * r * (std::f64::consts::TAU / n).sin();
    let discs = cut(&torus, [section(across, 0.0)]);
    assert!((area(&discs) - 2.0 * polygon(48.0, 0.4)).abs() < 2e-3, "{}", area(&discs));
    let annulus = cut(&torus, [section(axis, 1e-3)]);
    let expected = polygon(96.0, 1.4) - polygon(96.0, 0.6);
    assert!((area(&annulus) - expected).abs() < 0.01, "{} {expected}", area(&annulus));
    assert!(discs.open.is_empty() && annulus.open.is_empty());
}

#[test]
fn contours_inside_contours_are_holes_by_winding_and_by_parity() {
    let (outer, inner) = (unit_cube(), samples::cuboid(DVec3::splat(0.25)));
    let turned = |p: &Primitive| {
        let mut p = p.clone();
        p.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        p
    };
    let both = |inner: &Primitive| {
        let mut all = outer.clone();
        samples::append(&mut all, inner);
        placed(vec![all], vec![(0, DMat4::IDENTITY)])
    };
    let middle = [section(DVec3::X, 0.0)];
    // A cavity is wound inwards; a body inside a body is material either way.
    assert!((area(&cut(&both(&turned(&inner)), middle)) - 0.75).abs() < 1e-6);
    assert!((area(&cut(&both(&inner), middle)) - 1.0).abs() < 1e-6);
    // With one triangle of the outside turned, nothing can be said of winding: parity.
    let mut muddled = both(&inner);
    muddled.meshes[0].primitives[0].triangles[0].swap(1, 2);
    let side = muddled.meshes[0].primitives[0].triangles[0];
    let normal = muddled.meshes[0].primitives[0].normals[side[0] as usize];
    let across = Vec3::from(normal).as_dvec3().any_orthonormal_vector();
    let found = cut(&muddled, [section(across, 0.01)]);
    assert!((area(&found) - 0.75).abs() < 1e-6 && found.open.is_empty(), "{}", area(&found));
    // Bodies that overlap, as in a weldment, are filled once.
    let mut overlapping = unit_cube();
    samples::append(&mut overlapping, &samples::moved(unit_cube(), DVec3::new(0.0, 0.5, 0.0)));
    let scene = placed(vec![overlapping], vec![(0, DMat4::IDENTITY)]);
    assert!((area(&cut(&scene, middle)) - 1.5).abs() < 1e-6);
}

#[test]
fn parts_have_caps_of_their_own_also_mirrored_ones_of_one_mesh() {
    let mirror = DMat4::from_scale(DVec3::new(-1.0, 2.0, 1.0));
    let aside = DMat4::from_translation(DVec3::Z * 3.0);
    let scene = placed(vec![unit_cube()], vec![(0, DMat4::IDENTITY), (0, aside * mirror), (0, aside * aside)]);
    let found = cut(&scene, [section(DVec3::X, 0.0), section(DVec3::NEG_X, 0.1)]);
    assert_eq!(
        found.caps.iter().map(|c| (c.plane, c.part)).collect::<Vec<_>>(),
        [0, 1].map(|p| [(p, 0), (p, 1), (p, 2)]).concat()
    );
    let areas: Vec<f64> = found.caps.iter().map(|c| c.area().round()).collect();
    assert_eq!(areas, [1.0, 2.0, 1.0, 1.0, 2.0, 1.0]);
    assert_eq!((found.planes[0].caps.clone(), found.planes[1].caps.clone()), (3..6, 6..9));
    let firsts: Vec<u32> = found.caps.iter().map(|c| c.first_triangle).collect();
    assert!(firsts[0] == 36 && firsts.windows(2).all(|w| w[0] < w[1]));
    assert_eq!(found.owner(7), 1);
    // Hidden parts have none; moved ones are cut where they are.
    let mut arrangement =
        Arrangement { sections: vec![section(DVec3::Z, 3.0)], explode: 1.0, ..Arrangement::default() };
    let solids = Solids::of(&scene);
    let at = arrangement.placed(&scene).parts[2].bounds.center().z;
    arrangement.sections[0].offset = at;
    assert_eq!(Cut::new(&scene, &arrangement, &solids).caps[0].part, 2);
    arrangement.parts.insert(2, PartLook { presence: Presence::Hidden, ..PartLook::default() });
    assert!(Cut::new(&scene, &arrangement, &solids).caps.is_empty());
    let mut stats = arrangement.stats(&scene);
    found.count_into(&mut stats);
    assert_eq!((stats.parts, stats.caps, stats.section_planes), (9, 6, 2));
}

#[test]
fn of_parts_that_overlap_the_smaller_has_the_whole_cap() {
    let solids = vec![unit_cube(), samples::cuboid(DVec3::splat(0.25))];
    // One inside, one half inside, mirrored.
    let aside = DMat4::from_translation(DVec3::Y * 0.5) * DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let scene = placed(solids, vec![(0, DMat4::IDENTITY), (1, DMat4::IDENTITY), (1, aside)]);
    let areas = |arrangement: &Arrangement| {
        let found = Cut::new(&scene, arrangement, &Solids::of(&scene));
        found.caps.iter().map(|c| (c.part, (1e4 * c.area()).round() / 1e4)).collect::<Vec<_>>()
    };
    let mut arrangement = Arrangement { sections: vec![section(DVec3::X, 0.0)], ..Arrangement::default() };
    assert_eq!(areas(&arrangement), [(0, 0.625), (1, 0.25), (2, 0.25)]);
    // A ghost takes nothing from what is shown, and a plane that is there twice cuts once.
    for ghost in [1, 2] {
        arrangement.parts.insert(ghost, PartLook { presence: Presence::Ghosted, ..PartLook::default() });
    }
    arrangement.sections.push(arrangement.sections[0]);
    assert_eq!(areas(&arrangement), [(0, 1.0), (2, 0.125)]);
}

#[test]
fn planes_count_in_the_coordinates_of_the_file() {
    let far = DMat4::from_translation(DVec3::new(1e6, 0.0, 0.0));
    let scene = placed(vec![unit_cube()], vec![(0, far)]);
    assert_ne!(scene.origin, DVec3::ZERO);
    let found = cut(&scene, [section(DVec3::X, 1e6 + 0.25)]);
    assert!((area(&found) - 1.0).abs() < 1e-6);
    assert!((corners(&found.caps[0])[0].x + scene.origin.x - (1e6 + 0.25)).abs() < 1e-9);
}

#[test]
fn open_parts_are_named_and_seams_that_nearly_close_are_mended() {
    let mut open = unit_cube();
    open.triangles.pop();
    let scene =
        placed(vec![open, unit_cube()], vec![(0, DMat4::IDENTITY), (1, DMat4::from_translation(DVec3::Y * 2.0))]);
    let sections: Vec<Section> = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().map(|n| section(n, 0.1)).collect();
    let found = cut(&scene, sections);
    // The last triangle is crossed by two of the three planes.
    assert_eq!(found.open.iter().map(|o| (o.part, o.ends)).collect::<Vec<_>>(), [(0, 2), (0, 2)]);
    assert!(found.caps.iter().filter(|c| c.part == 0).count() == 1);
    let notices = found.notices(&scene);
    assert_eq!(notices.len(), 2);
    assert!(notices[0].ends_with("is not closed there and gets no cap"), "{notices:?}");
    // An edge that is two edges on one side of it.
    let mut split = unit_cube();
    let [a, b, c] = split.triangles[0];
    let middle = |f: &[[f32; 3]]| std::array::from_fn(|i| 0.5 * (f[a as usize][i] + f[b as usize][i]));
    let (position, normal) = (middle(&split.positions), middle(&split.normals));
    split.positions.push(position);
    split.normals.push(normal);
    let m = split.positions.len() as u32 - 1;
    split.triangles[0] = [a, m, c];
    split.triangles.push([m, b, c]);
    let scene = placed(vec![split], vec![(0, DMat4::IDENTITY)]);
    for normal in [DVec3::X, DVec3::Y, DVec3::Z] {
        let found = cut(&scene, [section(normal, 0.1)]);
        assert!(found.open.is_empty() && (area(&found) - 1.0).abs() < 1e-6, "{normal}");
    }
    // Every triangle with vertices of its own, off by less than a millionth.
    let cube = unit_cube();
    let mut torn = Primitive::default();
    for (i, &corner) in cube.triangles.iter().flatten().enumerate() {
        let off = if i % 2 == 0 { 1e-7 } else { 0.0 };
        torn.positions.push(cube.positions[corner as usize].map(|v| v + off));
        torn.normals.push(cube.normals[corner as usize]);
    }
    torn.triangles = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let scene = placed(vec![torn], vec![(0, DMat4::IDENTITY)]);
    let found = cut(&scene, [section(DVec3::new(0.3, 0.5, 0.7), 0.05)]);
    assert!(found.open.is_empty() && found.caps.len() == 1, "{:?}", found.open);
}

#[test]
fn broken_geometry_gives_no_caps_and_no_panic() {
    let scene = builtin::build("hard/broken").unwrap();
    for normal in [DVec3::X, DVec3::Y, DVec3::ONE] {
        let found = cut(&scene, [section(normal, 0.1)]);
        assert!(found.caps.iter().all(|c| c.area().is_finite()));
    }
    let empty = Scene { meshes: vec![Mesh::default()], ..Scene::default() }.finish().unwrap();
    assert!(cut(&empty, [section(DVec3::X, 0.0)]).caps.is_empty());
}

/// The area of the polygon in which a plane cuts a box with half axes `axes` (orthogonal) around `center`: its corners are
/// where the plane meets the twelve edges.
fn exact_area(axes: [DVec3; 3], center: DVec3, normal: DVec3, offset: f64) -> f64 {
    let corner = |i: usize| (0..3).fold(center, |p, a| p + axes[a] * if i >> a & 1 == 1 { 1.0 } else { -1.0 });
    let mut points = Vec::new();
    for (i, axis) in (0..8).flat_map(|i| (0..3).map(move |a| (i, a))).filter(|(i, a)| i >> a & 1 == 0) {
        let (p, q) = (corner(i), corner(i | 1 << axis));
        let (a, b) = (normal.dot(p) - offset, normal.dot(q) - offset);
        if (a > 0.0) != (b > 0.0) {
            points.push(p + (q - p) * (a / (a - b)));
        }
    }
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    let angle = |p: &DVec3| v.dot(*p - middle).atan2(u.dot(*p - middle));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| 0.5 * normal.dot((*a - middle).cross(*b - middle))).sum()
}

proptest! {
    #[test]
    fn caps_of_boxes_have_the_area_of_the_polygon(
        half in prop::array::uniform3(0.1..3.0_f64),
        turn in prop::array::uniform3(-3.0..3.0_f64),
        center in prop::array::uniform3(-5.0..5.0_f64),
        toward in prop::array::uniform3(-1.0..1.0_f64),
        at in -1.0..1.0_f64,
        mirrored: bool,
    ) {
        let normal = DVec3::from(toward).normalize_or(DVec3::X);
        let turned = DMat4::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
        let sign = if mirrored { -1.0 } else { 1.0 };
        let half = DVec3::from(half.map(|v| f64::from(v as f32)));
        let world = DMat4::from_translation(center.into()) * turned * DMat4::from_scale(DVec3::new(1.0, sign, 1.0));
        let scene = placed(vec![samples::cuboid(half)], vec![(0, world)]);
        let axes = [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z].map(|a| world.transform_vector3(a));
        let reach: f64 = axes.iter().map(|a| normal.dot(*a).abs()).sum();
        let offset = normal.dot(center.into()) + at * reach;
        let expected = exact_area(axes, center.into(), normal, offset);
        let found = cut(&scene, [section(normal, offset)]);
        prop_assert!(found.open.is_empty());
        let scale = half.length_squared();
        prop_assert!((area(&found) - expected).abs() < 1e-5 * scale, "{} {expected}", area(&found));
    }
}
