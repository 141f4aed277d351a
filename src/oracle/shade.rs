//! Lights every fragment of a store: surface inputs in, lit colour out. One call of [`light_surface`] a fragment.

use glam::{DVec3, Vec3};

use super::lighting::{Surface, light_surface};
use super::store::StoreData;
use super::view::View;
use crate::math::LightRig;

/// Linear rgb that each fragment sends to the eye, by fragment.
pub fn shade(store: &StoreData, view: &View, rig: &LightRig) -> Vec<[f64; 3]> {
    let pixel_of = store.pixel_of_fragment();
    (0..store.len())
        .map(|i| {
            let (x, y) = store.xy(pixel_of[i]);
            let [r, g, b, _] = store.base_color[i].map(f64::from);
            let surface = Surface {
                base_color: DVec3::new(r, g, b),
                metallic: f64::from(store.metallic[i]),
                roughness: f64::from(store.roughness[i]),
                occlusion: f64::from(store.occlusion[i]),
                emissive: Vec3::from(store.emissive[i]).as_dvec3(),
                unlit: store.unlit[i],
                back_side: !store.side[i],
            };
            let to_eye = view.to_eye(view.position(x, y, store.depth[i]));
            light_surface(&surface, Vec3::from(store.normal[i]).as_dvec3(), to_eye, rig).to_array()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LightLevels;
    use crate::oracle::analytic::{Placed, Shape};
    use glam::{DMat3, DVec2};

    #[test]
    fn the_middle_of_a_sphere_is_lit_as_a_surface_that_faces_the_viewer() {
        let view = View { width: 9, height: 9, perspective: true, half_extent: DVec2::splat(0.3), shift: DVec2::ZERO };
        let center_in_view = DVec3::new(0.0, 0.0, -5.0);
        let sphere = Placed { shape: Shape::Sphere { radius: 1.0 }, view_from_shape: DMat3::IDENTITY, center_in_view };
        let mut store = sphere.store(&view, [3.0, 7.0]);
        let middle = store.range(4 * 9 + 4);
        assert_eq!(middle.len(), 2);
        assert_eq!([store.side[middle.start], store.side[middle.start + 1]], [true, false]);
        let rig = LightRig::studio(LightLevels::default());
        let lit = shade(&store, &view, &rig);
        assert_eq!(lit.len(), store.len());
        let surface = Surface {
            base_color: DVec3::splat(0.5),
            metallic: 0.0,
            roughness: 0.5,
            occlusion: 1.0,
            emissive: DVec3::ZERO,
            unlit: false,
            back_side: false,
        };
        let expected = light_surface(&surface, DVec3::Z, DVec3::Z, &rig);
        assert!((DVec3::from(lit[middle.start]) - expected).length() < 1e-6);
        assert!(lit[middle.start + 1][1] < expected.y, "the inside is darker");
        store.unlit.fill(true);
        assert!(shade(&store, &view, &rig).iter().all(|c| *c == [0.5; 3]));
    }
}
