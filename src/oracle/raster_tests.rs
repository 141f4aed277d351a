//! Rasterization on cases that can be worked out by hand.

use super::*;
use crate::scene::{Mesh, Node};

/// A scene of one material and one part per list of positions (three a triangle), with normals +z.
fn scene_of(parts: &[&[[f32; 3]]]) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    for (index, &positions) in parts.iter().enumerate() {
        let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let primitive = Primitive {
            positions: positions.to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; positions.len()],
            triangles,
            ..Primitive::default()
        };
        scene.meshes.push(Mesh { name: String::new(), primitives: vec![primitive] });
        scene.nodes.push(Node::root("", Some(index), DMat4::IDENTITY));
    }
    scene.finish().unwrap()
}

fn quad(half: f32, z: f32) -> [[f32; 3]; 6] {
    let [a, b, c, d] = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    [a, b, c, a, c, d]
}

/// Looks along -z from z = 5; two units high.
fn camera(orthographic: bool) -> Camera {
    Camera {
        position: DVec3::new(0.0, 0.0, 5.0),
        focal_point: DVec3::ZERO,
        view_up: DVec3::Y,
        projection: if orthographic {
            Projection::Orthographic { height: 2.0 }
        } else {
            Projection::Perspective { fov_y: 2.0 * (0.2_f64).atan() }
        },
    }
}

#[test]
fn two_triangles_in_a_pixel_by_hand() {
    let near = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]];
    let far = [[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [3.0, -1.0, 0.0]];
    for orthographic in [false, true] {
        let layers = rasterize(&scene_of(&[&far, &near]), &camera(orthographic), [4, 4], DVec2::ZERO);
        // Pixel (1, 2) shows (-0.25, -0.25) of the focal plane.
        let pixel = &layers.pixels[2 * 4 + 1];
        assert_eq!(pixel.fragments.iter().map(|f| (f.part, f.triangle)).collect::<Vec<_>>(), [(1, 1), (0, 0)]);
        let [front, back] = [&pixel.fragments[0], &pixel.fragments[1]];
        let scale = if orthographic { 1.0 } else { 0.8 };
        assert!((front.position_in_view - DVec3::new(-0.25 * scale, -0.25 * scale, -4.0)).length() < 1e-12);
        assert!((back.depth - 5.0).abs() < 1e-12);
        assert_eq!(front.normal_in_view, DVec3::Z);
        assert!(front.side && front.clip_z > back.clip_z && front.depth_key < back.depth_key);
        // The far triangle is wound the other way round, against its normals: opposed, so it still shows its outer side.
        assert_eq!(back.normal_in_view, DVec3::Z);
        assert!(back.side && !pixel.ambiguous);
        let [a, b, c] = back.barycentrics;
        assert!((a - 0.4375).abs() < 1e-12 && (b - 0.375).abs() < 1e-12 && (c - 0.1875).abs() < 1e-12);
    }
}

#[test]
fn a_shared_edge_through_pixel_centres_has_neither_gaps_nor_doubles() {
    for orthographic in [false, true] {
        let layers = rasterize(&scene_of(&[&quad(10.0, 0.3)]), &camera(orthographic), [16, 16], DVec2::ZERO);
        assert!(layers.pixels.iter().all(|p| p.fragments.len() == 1));
        assert_eq!(layers.pixels.iter().filter(|p| p.ambiguous).count(), 16, "the diagonal");
    }
}

#[test]
fn a_sample_on_the_outline_follows_the_top_left_rule_and_is_ambiguous() {
    // Eight pixels over two units: a quad of half width 5/8 has its outline at 1.5 and 6.5 pixels, on pixel centres.
    let layers = rasterize(&scene_of(&[&quad(0.625, 0.0)]), &camera(true), [8, 8], DVec2::ZERO);
    let covered: Vec<usize> = (0..8).filter(|&x| !layers.pixels[4 * 8 + x].fragments.is_empty()).collect();
    assert_eq!(covered, [1, 2, 3, 4, 5], "left edge in, right edge (6.5 pixels) out");
    let column: Vec<usize> = (0..8).filter(|&y| !layers.pixels[y * 8 + 4].fragments.is_empty()).collect();
    assert_eq!(column, [1, 2, 3, 4, 5], "top edge in, bottom edge out");
    assert!(layers.pixels[4 * 8 + 1].ambiguous && layers.pixels[4 * 8 + 6].ambiguous);
    assert!(!layers.pixels[4 * 8 + 7].ambiguous);
}

#[test]
fn jitter_moves_the_image() {
    let scene = scene_of(&[&quad(0.5, 0.0)]);
    let at = |jitter| rasterize(&scene, &camera(false), [8, 8], jitter);
    let (still, moved) = (at(DVec2::ZERO), at(DVec2::new(1.0, 2.0)));
    for y in 0..6 {
        for x in 0..7 {
            let (a, b) = (&still.pixels[y * 8 + x].fragments, &moved.pixels[(y + 2) * 8 + x + 1].fragments);
            assert_eq!(a.len(), b.len());
            assert!(a.iter().zip(b).all(|(a, b)| (a.position_in_view - b.position_in_view).length() < 1e-12));
        }
    }
}

#[test]
fn the_back_of_a_mirrored_part_shows_its_inner_side() {
    let scene = {
        let mut scene = scene_of(&[&quad(1.0, 0.0), &quad(1.0, 0.0), &quad(1.0, 0.0)]);
        scene.nodes[1].parent_from_node = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        scene.nodes[2].parent_from_node = DMat4::from_rotation_y(std::f64::consts::PI);
        scene.finish().unwrap()
    };
    let layers = rasterize(&scene, &camera(false), [3, 3], DVec2::new(0.1, 0.2));
    let fragments = &layers.pixels[4].fragments;
    assert_eq!(fragments.len(), 3);
    for f in fragments {
        assert_eq!(f.side, f.part != 2, "part {}", f.part);
        assert!((f.normal_in_view - DVec3::Z).length() < 1e-12, "every normal faces the viewer");
        assert!(f.ambiguous, "three surfaces at one depth");
    }
}

#[test]
fn a_floor_that_passes_under_the_eye_is_cut_at_the_near_plane() {
    // Seen from inside: the floor reaches from behind the eye to far in front of it.
    let (w, y) = (4.0, -0.5);
    let floor = [[-w, y, 9.0], [w, y, 9.0], [w, y, -20.0], [-w, y, 9.0], [w, y, -20.0], [-w, y, -20.0]];
    let scene = scene_of(&[&floor]);
    let camera = Camera { projection: Projection::Perspective { fov_y: 1.5 }, ..camera(false) };
    let near = camera.frustum(&scene.bounds()).near;
    let layers = rasterize(&scene, &camera, [9, 9], DVec2::ZERO);
    let column: Vec<usize> = (0..9).map(|y| layers.pixels[y * 9 + 4].fragments.len()).collect();
    assert_eq!(column, [0, 0, 0, 0, 0, 1, 1, 1, 1]);
    for f in layers.pixels.iter().flat_map(|p| &p.fragments) {
        assert!((f.position_in_view.y - f64::from(y)).abs() < 1e-9 && f.depth >= near && f.clip_z <= 1.0);
    }
    // Just above the floor, the bottom row would see it nearer than the near plane.
    let frame_camera = Camera { position: DVec3::new(0.0, -0.499, 5.0), ..camera };
    let layers = rasterize(&scene, &frame_camera, [9, 9], DVec2::ZERO);
    assert!(layers.pixels[8 * 9 + 4].fragments.is_empty());
}

#[test]
fn empty_scenes_and_degenerate_triangles_give_empty_pixels() {
    let layers = rasterize(&Scene::default(), &camera(false), [1, 1], DVec2::ZERO);
    assert_eq!(layers.pixels, [Pixel::default()]);
    assert!(rasterize(&scene_of(&[&quad(1.0, 0.0)]), &camera(false), [0, 0], DVec2::ZERO).pixels.is_empty());
    let point = [[0.0; 3]; 3];
    let needle = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let layers = rasterize(&scene_of(&[&point, &needle]), &camera(false), [5, 5], DVec2::ZERO);
    assert!(layers.pixels.iter().all(|p| p.fragments.is_empty()));
    let one = rasterize(&scene_of(&[&quad(1.0, 0.0)]), &camera(false), [1, 1], DVec2::ZERO);
    assert_eq!(one.pixels[0].fragments.len(), 1);
}

#[test]
fn a_triangle_without_normals_shows_its_geometric_one() {
    let mut scene = scene_of(&[&quad(1.0, 0.0)]);
    scene.meshes[0].primitives[0].normals.fill([0.0; 3]);
    let layers = rasterize(&scene, &camera(false), [2, 2], DVec2::new(0.1, 0.0));
    assert_eq!(layers.pixels[0].fragments[0].normal_in_view, DVec3::Z);
}

#[test]
fn a_mask_cuts_and_only_blending_materials_have_alpha() {
    let alpha_of = |mode| {
        let mut scene = scene_of(&[&quad(1.0, 0.0)]);
        scene.materials[0].alpha_mode = mode;
        scene.materials[0].base_color = [0.5, 0.25, 1.0, 0.75];
        scene.meshes[0].primitives[0].colors = vec![[0.5, 1.0, 1.0, 0.5]; 6];
        let layers = rasterize(&scene, &camera(false), [2, 2], DVec2::new(0.1, 0.0));
        layers.pixels[0].fragments.first().map(|f| f.surface.base_color)
    };
    assert_eq!(alpha_of(AlphaMode::Opaque), Some([0.25, 0.25, 1.0, 1.0]));
    let blended = alpha_of(AlphaMode::Blend).unwrap();
    assert!((blended[3] - 0.375).abs() < 1e-12);
    assert_eq!(alpha_of(AlphaMode::Mask { cutoff: 0.4 }), None);
    assert_eq!(alpha_of(AlphaMode::Mask { cutoff: 0.3 }).unwrap()[3], 1.0);
}

#[test]
fn keys_order_like_depths() {
    assert_eq!(depth_key(1.0), 0);
    assert_eq!(depth_key(2.0), 0);
    assert_eq!(depth_key(0.0), KEY_OF_NEAR);
    assert!(depth_key(0.5) < depth_key(0.25));
}
