//! The renderer's stages in `f64` on the CPU: slow and obviously right.
//!
//! Every stage here takes plain data and gives plain data, so that a picture from the GPU can be judged stage by stage:
//! the oracle's stage is fed with the *read-back of the stage before*, and what comes out must be what the GPU made of
//! the same input. Only rasterization starts from the scene itself.
//!
//! | stage | module | takes | gives |
//! |---|---|---|---|
//! | capture | [`raster`] | scene, camera | [`Layers`]: every fragment of every pixel |
//! | | [`buckets`] | the fragments of one pixel, k | the paper's Z, B and data slots |
//! | | [`linked_list`] | fragments in order of arrival | the lists of all pixels, and the paper's sort |
//! | | [`store`] | layers | [`StoreData`], the neutral form that read-backs have too |
//! | | [`cut`] | positions, links | what section planes cut away and leave unknown |
//! | features | [`neighbours()`] | store | four [`Link`]s a fragment |
//! | | [`continuity`] | store | the same by the illustration buffer's measure |
//! | | [`curvature()`] | store, links | κ and the 2×2 operator |
//! | shading | [`shade`], [`lighting`] | store, lights | lit colour |
//! | opacity | [`stylize`] | store, lit colour, κ, tables | colour and alpha |
//! | | [`models`] | store, links | opacity by the other models |
//! | | [`ends`] | store, links | where surfaces end, and what that hides |
//! | | [`feature_size`] | store, links, ends | how much flows through each link |
//! | | [`illustration`] | store, links, ends, base opacity | the fields α, β, γ and opacity |
//! | composite | [`composite`] | store, colour and alpha | the image |
//!
//! An [`arranged`] scene is a scene again. [`compare`] holds each stage of a GPU against these. [`view`] reads camera and image size as the shaders do; [`analytic`] makes stores of surfaces whose curvature is
//! known in closed form.
//!
//! # Where either answer passes
//! Rasterizers snap vertices to 1/256 pixel, and `f32` has near-ties. A result that lies within such a threshold carries
//! an `ambiguous` flag; a comparison lets either answer pass there and counts how often it did (at most 2 %).
//!
//! # Where the contract left a choice
//! Noted in the module that had to choose, under *Choices*.

pub mod analytic;
pub mod arranged;
pub mod buckets;
pub mod compare;
pub mod composite;
pub mod continuity;
pub mod curvature;
pub mod cut;
pub mod ends;
pub mod feature_size;
pub mod illustration;
pub mod lighting;
pub mod linked_list;
pub mod models;
pub mod neighbours;
pub mod raster;
pub mod shade;
pub mod store;
pub mod stylize;
mod texture;
pub mod view;

pub use buckets::{Books, BucketedPixel, PackedKey, WideKey, bucket_k_buffer};
pub use curvature::{Curvature, curvature};
pub use cut::ViewCut;
pub use ends::{Ends, Surfaces};
pub use linked_list::Lists;
pub use neighbours::{Direction, Link, Neighbours, neighbours, neighbours_expected};
pub use raster::{Fragment, Layers, Pixel, SurfaceInputs, rasterize, rasterize_cut};
pub use store::StoreData;
pub use view::{Extents, View};

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec2, DVec3};

    use super::*;
    use crate::math::{Camera, LightLevels, LightRig, Projection};
    use crate::scene::{Material, Mesh, Node, Primitive, Scene};
    use crate::settings::{CurvatureSettings, OpacityModel, OpacitySettings};

    /// A cube of side 2 around the origin, turned, with one normal a face.
    fn cube() -> Scene {
        let mut primitive = Primitive::default();
        for axis in 0..3 {
            for sign in [-1.0_f32, 1.0] {
                let first = primitive.positions.len() as u32;
                for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let mut position = [0.0; 3];
                    position[axis] = sign;
                    // Swapping sides with the sign keeps the winding outwards.
                    position[(axis + 1) % 3] = a * sign;
                    position[(axis + 2) % 3] = b;
                    let mut normal = [0.0; 3];
                    normal[axis] = sign;
                    primitive.positions.push(position);
                    primitive.normals.push(normal);
                }
                primitive.triangles.push([first, first + 1, first + 2]);
                primitive.triangles.push([first, first + 2, first + 3]);
            }
        }
        let turned = DMat4::from_rotation_x(0.6) * DMat4::from_rotation_y(0.7);
        Scene {
            materials: vec![Material { metallic: 0.0, roughness: 0.5, ..Material::default() }],
            meshes: vec![Mesh { name: "cube".to_owned(), primitives: vec![primitive] }],
            nodes: vec![Node::root("cube", Some(0), turned)],
            ..Scene::default()
        }
        .finish()
        .unwrap()
    }

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(0.0, 0.0, 10.0),
            focal_point: DVec3::ZERO,
            view_up: DVec3::Y,
            projection: Projection::Orthographic { height: 4.0 },
        }
    }

    const SIZE: u32 = 64;

    #[test]
    fn a_cube_is_two_layers_with_an_outer_and_an_inner_side() {
        let layers = rasterize(&cube(), &camera(), [SIZE; 2], DVec2::ZERO);
        let mut solid = 0;
        for pixel in layers.pixels.iter().filter(|p| !p.ambiguous) {
            match pixel.fragments[..] {
                [] => {}
                [front, back] => {
                    solid += 1;
                    assert!(front.side && !back.side && front.depth < back.depth);
                    assert!(front.normal_in_view.z > 0.0 && back.normal_in_view.z > 0.0);
                }
                _ => panic!("{} layers", pixel.fragments.len()),
            }
        }
        assert!(solid > 1000);
        let ambiguous = layers.pixels.iter().filter(|p| p.ambiguous).count();
        assert!(ambiguous * 50 < layers.pixels.len(), "{ambiguous} ambiguous pixels are more than 2 %");
    }

    #[test]
    fn all_stages_on_a_cube() {
        let (scene, camera) = (cube(), camera());
        let view = View::new(&camera, [SIZE; 2], DVec2::ZERO);
        let extents = Extents::new(&scene, &camera);
        let layers = rasterize(&scene, &camera, [SIZE; 2], DVec2::ZERO);
        let store = StoreData::from_layers(&layers);
        let links = neighbours(&store, &extents, true);
        let settings = CurvatureSettings { scale: 1.0, ..CurvatureSettings::default() };
        let bent = curvature(&store, &links, &view, &extents, &settings);

        // Flat faces are flat, edges are convex seen from outside and concave from inside, rims convex.
        let count = |f: &dyn Fn(usize) -> bool| (0..store.len()).filter(|&i| f(i)).count();
        let rim = |i: usize| links.links[i].contains(&Link::Missing);
        assert!(count(&|i| bent.kappa[i].abs() < 1e-6) * 10 > store.len() * 8);
        assert!(count(&|i| rim(i) && bent.kappa[i] == -1.0) > 150);
        assert_eq!(count(&|i| rim(i) && bent.kappa[i] != -1.0), 0);
        assert!(count(&|i| !rim(i) && store.side[i] && bent.kappa[i] < -0.9) > 60);
        assert!(count(&|i| !rim(i) && !store.side[i] && bent.kappa[i] > 0.9) > 60);
        assert_eq!(count(&|i| store.side[i] && bent.kappa[i] > 1e-6), 0);
        assert_eq!(count(&|i| !rim(i) && !store.side[i] && bent.kappa[i] < -1e-6), 0);

        let lit = shade::shade(&store, &view, &LightRig::studio(LightLevels::default()));
        let opacity = OpacitySettings { model: OpacityModel::Constant, constant: 0.5, ..OpacitySettings::default() };
        let tables = stylize::Tables {
            color: vec![[0.5; 3]],
            mode: stylize::ColorMode::Tint,
            opacity: vec![1.0],
            opacity_width: 1,
        };
        let colors = stylize::stylize(&store, &lit, &bent.kappa, &extents, &opacity, &tables);
        let image = composite::front_to_back(&store, &colors, Some([1.0; 3]));
        let middle = (SIZE / 2 * SIZE + SIZE / 2) as usize + 7;
        let [front, back] = [store.offsets[middle], store.offsets[middle] + 1];
        assert_eq!(store.counts[middle], 2);
        let expected = 0.5 * lit[front][1] + 0.25 * lit[back][1] + 0.25;
        assert!((image[middle][1] - expected).abs() < 1e-12);
        assert_eq!(image[0], [1.0; 4]);
    }

    #[test]
    fn keeping_only_the_nearest_layer_makes_no_rims() {
        let (scene, camera) = (cube(), camera());
        let extents = Extents::new(&scene, &camera);
        let layers = rasterize(&scene, &camera, [SIZE; 2], DVec2::ZERO);
        let (all, one) = (StoreData::from_layers(&layers), StoreData::from_nearest_layers(&layers, 1));
        let missing = |store: &StoreData| {
            neighbours(store, &extents, true).links.iter().filter(|l| l.contains(&Link::Missing)).count()
        };
        assert!(one.len() < all.len() && one.overflowed.contains(&true));
        assert!(missing(&one) <= missing(&all) / 2 + 4, "{} {}", missing(&one), missing(&all));
    }

    #[test]
    fn an_empty_scene_and_a_single_pixel_pass_through_all_stages() {
        for (scene, size) in [(Scene::default(), [1, 1]), (cube(), [1, 1]), (cube(), [0, 0]), (cube(), [3, 1])] {
            let camera = camera();
            let (view, extents) = (View::new(&camera, size, DVec2::ZERO), Extents::new(&scene, &camera));
            let store = StoreData::from_layers(&rasterize(&scene, &camera, size, DVec2::ZERO));
            let links = neighbours(&store, &extents, true);
            let bent = curvature(&store, &links, &view, &extents, &CurvatureSettings::default());
            let lit = shade::shade(&store, &view, &LightRig::studio(LightLevels::default()));
            let tables = stylize::Tables {
                color: vec![],
                mode: stylize::ColorMode::Multiply,
                opacity: vec![],
                opacity_width: 0,
            };
            let colors = stylize::stylize(&store, &lit, &bent.kappa, &extents, &OpacitySettings::default(), &tables);
            let image = composite::back_to_front(&store, &colors, None);
            assert_eq!(image.len(), (size[0] * size[1]) as usize);
            assert!(image.iter().flatten().all(|c| c.is_finite()));
        }
    }
}
