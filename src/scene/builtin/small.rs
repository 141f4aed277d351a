//! Small scenes for tests.

use glam::{DMat4, DVec2};

use super::assembly::{Assembly, shift};
use super::kit::{Chamfer, Path, Shell, Step, Tolerance, ball_divided, prism};
use crate::scene::{AlphaMode, Scene};

fn cuboid(half: f64) -> Shell {
    let corners = [Step::To(-half, -half), Step::To(half, -half), Step::To(half, half), Step::To(-half, half)];
    prism(&Path::closed(&corners, Tolerance(0.01)), &[], -half, half, Chamfer::None)
}

/// Five nested transparent bodies: box, ball, box, ball, and a ring of gear-like outline in the middle.
pub(super) fn stack() -> Scene {
    let mut assembly = Assembly::new("stack");
    let root = assembly.group(None, "stack", DMat4::IDENTITY);
    let ring =
        prism(&Path::circle(DVec2::ZERO, 0.3, 16), &[Path::circle(DVec2::ZERO, 0.15, 16)], -0.2, 0.2, Chamfer::None);
    let bodies = [
        ("outer box", cuboid(1.6), 0x9FB4C8),
        ("outer ball", ball_divided(1.4, 3), 0xC8A878),
        ("inner box", cuboid(0.7), 0x8FB58F),
        ("inner ball", ball_divided(0.5, 2), 0xC08080),
        ("ring", ring, 0xA890C0),
    ];
    let mut materials = Vec::new();
    for (name, shell, color) in bodies {
        let material = assembly.material(name, color, 0.0, 0.5);
        materials.push(material);
        assembly.single(root, name, &shell, material);
    }
    let mut scene = assembly.into_scene();
    for material in &mut scene.materials {
        material.base_color[3] = 0.35;
        material.alpha_mode = AlphaMode::Blend;
    }
    scene
}

/// Two boxes side by side along x, of one mesh, whose faces at x = 0 are the same rectangle.
pub(super) fn touching() -> Scene {
    let mut assembly = Assembly::new("touching");
    let root = assembly.group(None, "touching", DMat4::IDENTITY);
    for (name, x, color) in [("left", -1.0, 0x9FB4C8), ("right", 1.0, 0xC8A878)] {
        let material = assembly.material(name, color, 0.0, 0.5);
        let mesh = assembly.mesh(name, &cuboid(1.0), material);
        assembly.part(root, name, mesh, shift(x, 0.0, 0.0));
    }
    assembly.into_scene()
}

#[cfg(test)]
mod tests {
    use super::super::{build, kit::shell::faults, probe::Rays};
    use glam::DVec3;

    #[test]
    fn the_stack_is_small_closed_and_ten_deep() {
        let scene = build("stack").unwrap();
        assert_eq!(scene.parts.len(), 5);
        assert!(scene.triangle_count() < 500, "{}", scene.triangle_count());
        for mesh in &scene.meshes {
            assert_eq!(faults(&mesh.primitives[0]), Vec::<String>::new(), "{}", mesh.name);
        }
        let ray = |x: f64| Rays::new(&scene).crossings(DVec3::new(x, 0.013, 9.0), DVec3::NEG_Z);
        assert_eq!((ray(0.21), ray(0.011), ray(1.5)), (10, 8, 2));
    }

    #[test]
    fn touching_faces_coincide() {
        let scene = build("touching").unwrap();
        assert_eq!(scene.parts[0].bounds.max.x, scene.parts[1].bounds.min.x);
        assert_eq!(Rays::new(&scene).crossings(DVec3::new(-9.0, 0.1, 0.2), DVec3::X), 4);
    }
}
