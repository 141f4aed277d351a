//! Random scenes against the oracle: as tiles of one picture, so that a draw call and a read-back pay for many of them.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::measure::{Stand, TURN};
use super::{CaseError, Figure, Shot};
use crate::math::Camera;
use crate::oracle::compare::{self, Comparison};
use crate::oracle::{composite, rasterize};
use crate::plan::Capture;
use crate::scene::hard_case::Source;
use crate::scene::{Scene, builtin};

/// Random scenes along an edge of a picture.
const COLUMNS: u32 = 16;

/// Draws as many pictures as the effort asks for, in parallel projection and perspective in turn, and counts the scenes of
/// which a fragment, a link, a κ or a colour is wrong.
pub(super) fn scenes(stand: &mut Stand<'_>) -> Result<Figure, CaseError> {
    let Source::Builtin(name) = stand.case.scene else {
        return Err(CaseError::Broken("random scenes are built in".to_owned()));
    };
    let mut figure = Figure::default();
    let pictures = stand.effort.random_scenes.div_ceil(COLUMNS * COLUMNS);
    let settings = stand.settings.clone();
    let mut first = None;
    for picture in 0..pictures {
        let scene = builtin::build(&format!("{name}?columns={COLUMNS}&seed={}", picture + 1))?;
        let size = stand.case.size;
        let parallel = picture % 2 == 0;
        let camera = Camera::framing(&scene.bounds(), DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, parallel, 0.6);
        let shot = stand.shoot(&scene, &camera, &settings)?;
        let found = compared(&scene, &camera, &shot, &settings);
        figure.samples += found.samples;
        figure.ambiguous += found.ambiguous;
        let tile = |pixel: usize| {
            let (x, y) = (pixel as u32 % size[0], pixel as u32 / size[0]);
            (x * COLUMNS / size[0], y * COLUMNS / size[1])
        };
        let wrong: HashSet<(u32, u32)> = found.faults.iter().map(|f| tile(f.pixel)).collect();
        figure.value += wrong.len() as f64;
        if let Some(fault) = found.faults.first().filter(|_| first.is_none()) {
            tracing::info!("seed {}, pixel {}: {}", picture + 1, fault.pixel, fault.what);
            first = Some(picture);
        }
    }
    Ok(figure)
}

/// All stages of one picture.
fn compared(scene: &Scene, camera: &Camera, shot: &Shot, settings: &crate::settings::Settings) -> Comparison {
    let store = &shot.store;
    let layers = &store.layers;
    let size = [layers.width, layers.height];
    let k = match shot.frame.report.plan.capture {
        Capture::BucketedKBuffer { k, .. } => k as usize,
        Capture::Compacted | Capture::LinkedList { .. } | Capture::None => usize::MAX,
    };
    let exact = rasterize(scene, camera, size, DVec2::ZERO);
    let mut all = compare::capture(scene, camera, &exact, layers, k, (settings.capture.normals, TURN));
    let how = (settings.features.depth_term, settings.features.reverse_check);
    all.add(compare::links(scene, camera, layers, &store.links, how));
    let features = (store.links.as_slice(), store.kappa.as_slice());
    all.add(compare::kappa(scene, camera, layers, features, &settings.features.curvature));
    all.add(compare::colors(&shot.frame.image.pixels, &composite::front_to_back(layers, &shot.colors(), None)));
    all
}
