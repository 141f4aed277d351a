use glam::DMat4;

use super::*;
use crate::scene::{Material, Mesh, Node, Primitive};

/// A scene with one part for each path. Nodes of groups are shared; empty names are none.
pub fn scene_of(paths: &[&str]) -> Scene {
    let primitive = Primitive {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    let mut scene = Scene {
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        materials: vec![Material::default()],
        ..Scene::default()
    };
    for path in paths {
        let levels: Vec<&str> = path.split('/').collect();
        let mut parent = None;
        for (i, name) in levels.iter().enumerate() {
            let is_part = i + 1 == levels.len();
            let known = scene.nodes.iter().position(|n| n.parent == parent && n.name == *name && n.mesh.is_none());
            parent = Some(known.filter(|_| !is_part).unwrap_or_else(|| {
                let node = scene.nodes.len();
                let new = Node { parent, ..Node::root(*name, is_part.then_some(0), DMat4::IDENTITY) };
                scene.nodes.push(new);
                if let Some(parent) = parent {
                    scene.nodes[parent].children.push(node);
                }
                node
            }));
        }
    }
    scene.finish().unwrap()
}

fn session() -> Session {
    let look = PartLook {
        presence: Presence::Ghosted,
        opacity: 1.0 / 3.0,
        color: Some([0.1, 0.2, 0.7]),
        style: PartStyle::Solid,
    };
    let mut settings = Settings::default();
    settings.set("opacity.gain", "1.7").unwrap();
    settings.set("opacity.transfer", "looks/mine.toml").unwrap();
    Session {
        file: "models/gear.glb".to_owned(),
        size: [640, 480],
        camera: Camera {
            position: DVec3::new(0.1, 2.0 / 3.0, 1e6 + 0.1),
            focal_point: DVec3::ZERO,
            view_up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 0.523 },
        },
        settings,
        arrangement: Arrangement {
            parts: BTreeMap::from([
                (1, look),
                (2, PartLook { presence: Presence::Hidden, ..PartLook::default() }),
                (3, PartLook { opacity: 0.25, ..PartLook::default() }),
            ]),
            explode: 0.3,
            sections: vec![
                Section { normal: DVec3::X, offset: 1e6 / 3.0, enabled: true, caps: false },
                Section { normal: DVec3::NEG_Y, offset: -0.5, enabled: false, caps: true },
            ],
            selected: BTreeSet::from([0, 2]),
        },
        import: Importing { crease_angle: 40.5, ..Importing::default() },
    }
}

const PATHS: [&str; 4] = ["housing/bolt", "housing/bolt", "gear/wheel", "shaft"];

fn refused(text: &str, scene: &Scene) -> String {
    match Session::from_toml(text).and_then(|file| file.resolve(scene)) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn a_session_comes_back_as_it_was() {
    let scene = scene_of(&PATHS);
    let session = session();
    let text = session.to_toml(&scene).unwrap();
    assert!(text.contains("\"housing/bolt#2\""), "{text}");
    let file = Session::from_toml(&text).unwrap();
    assert_eq!((file.file(), file.size(), file.settings()), ("models/gear.glb", [640, 480], &session.settings));
    assert_eq!(file.resolve(&scene).unwrap(), session);

    let plain = Session {
        arrangement: Arrangement::default(),
        camera: Camera { projection: Projection::Orthographic { height: 3.0 }, ..session.camera },
        ..session
    };
    let text = plain.to_toml(&scene).unwrap();
    assert_eq!(Session::from_toml(&text).unwrap().resolve(&scene).unwrap(), plain);
}

#[test]
fn looks_that_say_nothing_are_not_written() {
    let mut session = session();
    session.arrangement.parts.insert(0, PartLook::default());
    let scene = scene_of(&PATHS);
    let text = session.to_toml(&scene).unwrap();
    assert_eq!(text.matches("[[arrangement.parts]]").count(), 3, "{text}");
}

const HEAD: &str = "file = 'a.glb'\nsize = [8, 8]\n[camera]\nposition = [0, 0, 9]\nfocal_point = [0, 0, 0]\n\
                    view_up = [0, 1, 0]\nprojection = { kind = 'perspective', fov_y = 0.5 }\n";

#[test]
fn what_is_left_out_is_at_its_default() {
    let session = Session::from_toml(HEAD).unwrap().resolve(&scene_of(&PATHS)).unwrap();
    assert_eq!((session.settings, session.arrangement), (Settings::default(), Arrangement::default()));
    assert_eq!(session.camera.position, DVec3::Z * 9.0);
    let text = format!(
        "{HEAD}[[arrangement.parts]]\npart = 'shaft'\n[[arrangement.sections]]\nnormal = [0, 0, 1]\noffset = 2\n"
    );
    let session = Session::from_toml(&text).unwrap().resolve(&scene_of(&PATHS)).unwrap();
    assert_eq!(session.arrangement.look(3), PartLook::default());
    let section = Section { normal: DVec3::Z, offset: 2.0, enabled: true, caps: true };
    assert_eq!(session.arrangement.sections, [section]);
}

#[test]
fn what_is_wrong_is_named() {
    let scene = scene_of(&PATHS);
    let part = |text: &str| refused(&format!("{HEAD}[[arrangement.parts]]\n{text}\n"), &scene);
    let e = part("part = 'housing/bold'");
    assert!(e.contains("'housing/bold'") && e.contains("did you mean 'housing/bolt'"), "{e}");
    let e = refused(&format!("{HEAD}[arrangement]\nselected = ['shaft#2']\n"), &scene);
    assert!(e.contains("did you mean 'shaft'"), "{e}");
    assert!(part("part = 'shaft'\n[[arrangement.parts]]\npart = 'shaft'").contains("'shaft' is listed twice"));
    assert!(refused(&format!("{HEAD}[arrangement]\nselected = ['shaft', 'shaft']"), &scene).contains("twice"));
    assert!(part("part = 'shaft'\nopacity = 1.5").contains("opacity of a part = 1.5"));
    assert!(part("part = 'shaft'\npresence = 'gone'").contains("10:"));
    assert!(part("part = 'shaft'\nglow = 1").contains("glow"));
    let e = refused(&format!("{HEAD}[settings]\nopacity.gian = 2\n"), &scene);
    assert!(e.contains("did you mean 'opacity.gain'"), "{e}");
    assert!(refused(&format!("{HEAD}[arrangement]\nexplode = 9\n"), &scene).contains("explode = 9"));
    for (from, to, word) in [
        ("[8, 8]", "[8, 0]", "size"),
        ("[0, 0, 9]", "[0, 0, 0]", "focal_point"),
        ("[0, 0, 9]", "[0, nan, 9]", "finite"),
        ("[0, 1, 0]", "[0, 0, 2]", "view_up"),
        ("[0, 1, 0]", "[0, 0, 0]", "view_up"),
        ("0.5", "4.0", "fov_y"),
        ("'perspective', fov_y = 0.5", "'orthographic', height = 0", "height"),
        ("file = 'a.glb'", "", "file"),
        ("size", "sizes", "1:"),
    ] {
        let text = HEAD.replacen(from, to, 1);
        let e = refused(&text, &scene);
        assert!(e.contains(word) || word == "1:" && e.contains("sizes"), "{to}: {e}");
    }
}

#[test]
fn cameras_are_in_the_files_coordinates() {
    let mut scene = scene_of(&PATHS);
    scene.origin = DVec3::new(1e6, 0.0, -3.0);
    let session = session();
    let text = session.to_toml(&scene).unwrap();
    let read = Session::from_toml(&text).unwrap().resolve(&scene).unwrap();
    assert_eq!(read, session, "the origin takes no part in the file");
    let inside = camera_in_scene(&session.camera, &scene);
    assert_eq!(inside.position, session.camera.position - scene.origin);
    assert_eq!(inside.projection, session.camera.projection);
    assert!((camera_in_file(&inside, &scene).position - session.camera.position).length() < 1e-9);
}

#[test]
fn paths_count_from_the_folder_of_the_session() {
    let here = std::env::current_dir().unwrap();
    let written = session().for_folder(Path::new("models")).unwrap();
    assert_eq!(written.file, "gear.glb");
    let outside = here.join("looks/mine.toml").to_string_lossy().into_owned();
    assert_eq!(written.settings.opacity.transfer, TransferSource::Named(outside.clone()));
    let scene = scene_of(&PATHS);
    let text = written.to_toml(&scene).unwrap();
    let file = Session::from_toml(&text).unwrap().rebased(Path::new("models"));
    assert_eq!(file.file(), "models/gear.glb");
    assert_eq!(file.settings().opacity.transfer, TransferSource::Named(outside));

    let builtin = Session { file: "builtin:gearbox".to_owned(), ..session() };
    let text = builtin.for_folder(Path::new("x")).unwrap().to_toml(&scene).unwrap();
    assert_eq!(Session::from_toml(&text).unwrap().rebased(Path::new("y")).file(), "builtin:gearbox");
}
