//! What becomes a part, on scenes built here.

use glam::{DVec3, Vec3};

use super::components::{ALWAYS, Components, NEVER};
use super::*;
use crate::import::Limits;
use crate::scene::{Material, Mesh, Node, Primitive, SceneCamera};

/// A square of side 1 in the plane z = 0, two triangles without common vertices, beginning at `at`.
fn square(at: [f32; 3], material: usize) -> Primitive {
    let corner = |x: f32, y: f32| [at[0] + x, at[1] + y, at[2]];
    let positions = vec![
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    Primitive {
        normals: vec![[0.0, 0.0, 1.0]; 6],
        uvs: [positions.iter().map(|p| [p[0], p[1]]).collect(), Vec::new()],
        positions,
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        material,
        ..Primitive::default()
    }
}

fn join(mut a: Primitive, b: Primitive) -> Primitive {
    let offset = a.positions.len() as u32;
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + offset)));
    a.positions.extend(b.positions);
    a.normals.extend(b.normals);
    a.uvs[0].extend(&b.uvs[0]);
    a
}

/// Two nodes that share a mesh of two squares, the second mirrored and far away; a third with a mesh of its own.
fn scene() -> Scene {
    let materials = ["red", ""].map(|name| Material { name: name.into(), ..Material::default() });
    let shared = join(square([0.0; 3], 0), square([0.0, 0.0, 2.0], 0));
    let mirrored = DMat4::from_translation(DVec3::X * 10.0) * DMat4::from_scale(DVec3::new(-3.0, 1.0, 1.0));
    let mut scene = Scene {
        name: "file".into(),
        materials: materials.to_vec(),
        meshes: vec![
            Mesh { name: "pair".into(), primitives: vec![shared] },
            Mesh { name: "single".into(), primitives: vec![square([0.0; 3], 1)] },
        ],
        nodes: vec![
            Node::root("a", Some(0), DMat4::IDENTITY),
            Node::root("b", Some(0), mirrored),
            Node::root("c", Some(1), DMat4::from_translation(DVec3::Y * 5.0)),
        ],
        ..Scene::default()
    }
    .finish()
    .expect("finished");
    let world_from_camera = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0) - scene.origin);
    let projection = crate::math::Projection::Perspective { fov_y: 1.0 };
    scene.cameras.push(SceneCamera { name: "eye".into(), world_from_camera, projection });
    scene
}

fn divided(by: PartsBy, scene: Scene, limits: Limits) -> Scene {
    let options = ImportOptions { parts: Some(by), limits, ..ImportOptions::default() };
    divide(Draft::gltf(scene), &options).expect("divided")
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.parts.iter().map(|p| p.name.as_str()).collect()
}

/// The area of everything in the file's space, with its normals' sum.
fn area(scene: &Scene) -> (f64, DVec3) {
    let mut sum = (0.0, DVec3::ZERO);
    for part in &scene.parts {
        for p in &scene.meshes[part.mesh].primitives {
            for t in &p.triangles {
                let at = |v: u32| part.world_from_part.transform_point3(Vec3::from(p.positions[v as usize]).as_dvec3());
                let mut cross = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])) / 2.0;
                if part.world_from_part.determinant() < 0.0 {
                    cross = -cross;
                }
                sum = (sum.0 + cross.length(), sum.1 + cross);
            }
        }
    }
    sum
}

#[test]
fn components_of_shared_meshes_stay_shared() {
    let whole = area(&scene());
    let scene = divided(PartsBy::Component, scene(), Limits::default());
    assert_eq!(names(&scene), ["a component 1", "a component 2", "b component 1", "b component 2", "c"]);
    assert_eq!(scene.meshes.len(), 3);
    assert_eq!(scene.parts[0].mesh, scene.parts[2].mesh);
    assert_eq!(scene.parts[1].mesh, scene.parts[3].mesh);
    assert!(scene.nodes[0].mesh.is_none() && scene.nodes[0].children.len() == 2);
    assert!((area(&scene).1 - whole.1).length() < 1e-9);
    assert_eq!(scene.partition, "connected components: as asked for");
    let p = &scene.meshes[scene.parts[1].mesh].primitives[0];
    assert_eq!((p.positions.len(), p.normals.len(), p.uvs[0].len()), (6, 6, 6));
}

#[test]
fn materials_and_the_whole_file_bring_triangles_into_one_space() {
    let before = scene();
    let whole = area(&before);
    let camera = before.cameras[0].world_from_camera.transform_point3(DVec3::ZERO) + before.origin;
    for (by, expected) in [(PartsBy::Material, vec!["red", "material 1"]), (PartsBy::File, vec!["file"])] {
        let scene = divided(by, scene(), Limits::default());
        assert_eq!(names(&scene), expected);
        let now = area(&scene);
        assert!((now.0 - whole.0).abs() < 1e-5 && (now.1 - whole.1).length() < 1e-5, "{now:?} {whole:?}");
        for p in scene.meshes.iter().flat_map(|m| &m.primitives) {
            // Mirrored triangles still agree with their normals.
            assert!(p.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]), "{:?}", p.normals);
            assert_eq!(p.uvs[0].len(), p.positions.len());
        }
        let moved = scene.cameras[0].world_from_camera.transform_point3(DVec3::ZERO) + scene.origin;
        assert!((moved - camera).length() < 1e-9);
    }
    assert_eq!(divided(PartsBy::Node, scene(), Limits::default()).digest(), scene().digest());
}

#[test]
fn components_are_numbered_by_size_and_the_same_every_time() {
    let mut large = square([5.0, 0.0, 0.0], 0);
    large.positions.iter_mut().for_each(|p| p[1] *= 3.0);
    let p = join(join(square([0.0; 3], 0), large), square([0.0, 0.0, 9.0], 0));
    let scene = || Scene {
        materials: vec![Material::default()],
        meshes: vec![Mesh { name: String::new(), primitives: vec![p.clone()] }],
        nodes: vec![Node::root("", Some(0), DMat4::IDENTITY)],
        ..Scene::default()
    };
    let one = divided(PartsBy::Component, scene(), Limits::default());
    let heights: Vec<f64> = one.parts.iter().map(|p| p.bounds.size().y).collect();
    assert_eq!(heights, [3.0, 1.0, 1.0]);
    assert_eq!(one.parts[1].bounds.min.z + one.origin.z, 0.0, "of equal ones the first in the file");
    assert_eq!(names(&one), ["component 1", "component 2", "component 3"]);
    assert_eq!(one.digest(), divided(PartsBy::Component, scene(), Limits::default()).digest());
}

#[test]
fn gaps_of_rounding_do_not_part_and_gaps_that_can_be_seen_do() {
    let mesh = |gap: f64| {
        let mut next = square([1.0, 0.0, 0.0], 0);
        next.positions.iter_mut().for_each(|p| p[0] += gap as f32);
        Mesh { name: String::new(), primitives: vec![square([0.0; 3], 0), next] }
    };
    let diagonal = 5_f64.sqrt();
    // In f32 at 1, steps are 1.2e-7: distances are what they became.
    for (gap, count) in [(0.0, 1), (0.9 * ALWAYS * diagonal, 1), (1.2 * NEVER * diagonal, 2), (1e-3, 2)] {
        assert_eq!(Components::of(&mesh(gap)).count, count, "{gap}");
    }
    assert_eq!(Components::of(&Mesh::default()).count, 0);
}

#[test]
fn a_cloud_of_loose_triangles_is_one_part_and_that_is_told() {
    let mut p = Primitive::default();
    for i in 0..100_000_u32 {
        let (x, y) = ((i % 317) as f32, (i / 317) as f32);
        p.positions.extend([[x, y, 0.0], [x + 0.4, y, 0.0], [x, y + 0.4, 0.0]]);
        p.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    p.normals = vec![[0.0, 0.0, 1.0]; p.positions.len()];
    let cloud = Scene {
        materials: vec![Material::default()],
        meshes: vec![Mesh { name: String::new(), primitives: vec![p] }],
        nodes: vec![Node::root("cloud", Some(0), DMat4::IDENTITY)],
        ..Scene::default()
    };
    let begin = std::time::Instant::now();
    let scene = divide(Draft::new(cloud, PartsBy::Component, "loose"), &ImportOptions::default()).expect("divided");
    assert_eq!(scene.parts.len(), 1);
    assert!(scene.partition.contains("100000 connected components would be more than the limit of 4096"));
    assert!(scene.notices.iter().any(|n| n.message.contains("is not divided into 100000 connected components")));
    assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
}
