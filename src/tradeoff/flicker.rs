//! Flicker: how much of a picture changes from frame to frame that no motion explains.
//!
//! The camera goes round the model in small steps. Each frame is brought to the next by the depth of the surface that weighs most
//! in each pixel, if it weighs a tenth, where both frames see that surface, and compared with it there. What still changes is light, parallax of the
//! layers behind, and flicker. The same orbit with many samples a pixel has the first two and little of the third, and is compared
//! over the same pixels: their ratio is what one sample adds.
//!
//! Steps have to be small. At 1° a surface moves by about one pixel in a hundred, and its light hardly; at 10° most of what is
//! compared is another view of other layers, with any number of samples.

use serde::Serialize;

use super::image_error::displayed;
use crate::math::{Camera, LinearImage};
use crate::oracle::{StoreData, View};
use crate::render::{GpuScene, RenderError, Renderer};
use crate::settings::Settings;

/// Changes from this on, in sRGB values from 0 to 1, are seen on their own: 8 steps of 255.
pub const STRONG: f64 = 8.0 / 255.0;

/// Least weight of a surface, of 1 for the whole pixel, by which a pixel is followed. What is clearer shows the background, which does
/// not move.
const LEAST_WEIGHT: f64 = 0.1;

/// Where the surface that weighs most in each pixel lies.
#[derive(Clone, Debug)]
pub struct Seen {
    camera: Camera,
    size: [u32; 2],
    /// Depth, scene units; infinite where no surface weighs enough.
    depth: Vec<f64>,
}

impl Seen {
    /// Of layers with these opacities, 0 to 1, in the order of the store.
    pub fn new(camera: &Camera, store: &StoreData, opacities: &[f64]) -> Seen {
        let depth = (0..store.counts.len())
            .map(|pixel| {
                let (mut left, mut best) = (1.0, (LEAST_WEIGHT, f64::INFINITY));
                for i in store.range(pixel) {
                    let weight = left * opacities[i];
                    left *= 1.0 - opacities[i];
                    if weight > best.0 {
                        best = (weight, store.depth[i]);
                    }
                }
                best.1
            })
            .collect();
        Seen { camera: *camera, size: [store.width, store.height], depth }
    }

    fn view(&self) -> View {
        View::new(&self.camera, self.size, glam::DVec2::ZERO)
    }

    fn at(&self, x: i64, y: i64) -> Option<(usize, f64)> {
        let [width, height] = self.size.map(i64::from);
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        let index = inside.then(|| (y * width + x) as usize)?;
        self.depth[index].is_finite().then(|| (index, self.depth[index]))
    }

    /// Where each pixel of this frame is found in `next`: pixels there and their weights. Empty where that frame does not see the
    /// same surface.
    pub fn brought_to(&self, next: &Seen) -> Vec<Vec<(usize, f64)>> {
        let (from, to) = (self.view(), next.view());
        let motion = next.camera.view_from_world() * self.camera.view_from_world().inverse();
        let [width, height] = next.size.map(f64::from);
        let find = |(pixel, depth): (usize, &f64)| -> Vec<(usize, f64)> {
            if !depth.is_finite() {
                return Vec::new();
            }
            let (x, y) = (pixel as u32 % self.size[0], pixel as u32 / self.size[0]);
            let point = motion.transform_point3(from.position(x, y, *depth));
            let depth = -point.z;
            if depth <= 0.0 {
                return Vec::new();
            }
            let ndc = point.truncate() / (to.half_extent * if to.perspective { depth } else { 1.0 });
            let (px, py) = (0.5 * (ndc.x + 1.0) * width - 0.5, 0.5 * (1.0 - ndc.y) * height - 0.5);
            // The same surface, seen at up to 60°, does not differ by more from one pixel to the next.
            let tolerance = 2.0 * to.pixel_size(depth).max_element();
            let same = |x: i64, y: i64| next.at(x, y).filter(|(_, d)| (d - depth).abs() <= tolerance);
            if same(px.round() as i64, py.round() as i64).is_none() {
                return Vec::new();
            }
            let (left, top) = (px.floor(), py.floor());
            let (u, v) = (px - left, py - top);
            let corners = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
            let found: Vec<(usize, f64)> = corners
                .into_iter()
                .filter_map(|(dx, dy, weight)| {
                    same(left as i64 + dx, top as i64 + dy).map(|(index, _)| (index, weight)).filter(|_| weight > 0.0)
                })
                .collect();
            let sum: f64 = found.iter().map(|f| f.1).sum();
            found.into_iter().map(|(index, weight)| (index, weight / sum)).collect()
        };
        self.depth.iter().enumerate().map(find).collect()
    }
}

/// What changes from one picture (sRGB values) to the next at each pixel, mean of the channels from 0 to 1; not a number where
/// nothing is compared.
pub fn change(from: &[[f64; 3]], to: &[[f64; 3]], brought: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let one = |(a, places): (&[f64; 3], &Vec<(usize, f64)>)| {
        if places.is_empty() {
            return f64::NAN;
        }
        (0..3).map(|c| (places.iter().map(|(i, w)| w * to[*i][c]).sum::<f64>() - a[c]).abs()).sum::<f64>() / 3.0
    };
    from.iter().zip(brought).map(one).collect()
}

/// Changes of an orbit taken together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Changes {
    /// Pixels that were compared.
    pub pixels: u64,
    /// Their mean change, sRGB values from 0 to 1.
    pub mean: f64,
    /// Share of them, percent, that changes by [`STRONG`] or more.
    pub strong_percent: f64,
}

impl Changes {
    /// Of all that were compared.
    pub fn of<'a>(maps: impl IntoIterator<Item = &'a Vec<f64>>) -> Changes {
        let (mut pixels, mut sum, mut strong) = (0_u64, 0.0, 0_u64);
        for change in maps.into_iter().flatten().filter(|c| !c.is_nan()) {
            pixels += 1;
            sum += change;
            strong += u64::from(*change >= STRONG);
        }
        let of = pixels.max(1) as f64;
        Changes { pixels, mean: sum / of, strong_percent: 100.0 * strong as f64 / of }
    }
}

/// An orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitOptions {
    /// Size of the pictures.
    pub size: [u32; 2],
    /// Frames.
    pub frames: u32,
    /// Degrees from frame to frame, around the axis that is up.
    pub degrees: f64,
    /// Samples a pixel of the orbit that is compared with.
    pub samples: u32,
    /// What lies behind, in linear light.
    pub background: Option<[f32; 3]>,
}

/// A pair of frames in pictures, with one sample and with many.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Number of the first frame, from 0.
    pub frame: u32,
    /// Both frames with one sample, then both with many.
    pub pictures: [LinearImage; 4],
    /// What changes with one sample, and with many.
    pub changes: [Vec<f64>; 2],
}

/// What an orbit gave.
#[derive(Clone, Debug)]
pub struct Orbit {
    /// Pixels with a surface in all frames but the last.
    pub surfaces: u64,
    /// With one sample.
    pub single: Changes,
    /// With many.
    pub many: Changes,
    /// The pair of frames between which most changes that does not with many samples.
    pub worst: Option<Pair>,
}

impl Orbit {
    /// Change with one sample over that with many.
    pub fn ratio(&self) -> f64 {
        self.single.mean / self.many.mean
    }
}

/// Draws an orbit with one sample a pixel and with many, and compares frame by frame. `say` hears of each frame.
///
/// # Errors
/// [`RenderError`] of the renderer, or if a frame takes several bands: then the store cannot be read back.
pub fn orbit(
    renderer: &mut Renderer,
    scene: &GpuScene,
    camera: &Camera,
    settings: &Settings,
    options: &OrbitOptions,
    say: &mut dyn FnMut(u32),
) -> Result<Orbit, RenderError> {
    let mut single = settings.clone();
    single.image.samples = 1;
    let mut many = settings.clone();
    many.image.samples = options.samples;
    let mut before: Option<(Seen, [LinearImage; 2])> = None;
    let (mut maps, mut worst, mut surfaces) = ([Vec::new(), Vec::new()], None::<Pair>, 0);
    let mut most = f64::NEG_INFINITY;
    for frame in 0..options.frames {
        say(frame);
        let camera = camera.azimuth(f64::from(frame) * options.degrees);
        let smooth = renderer.render(scene, &camera, &many, options.size)?.image;
        let drawn = renderer.render(scene, &camera, &single, options.size)?;
        let store = renderer.read_store(&drawn.report, scene, &camera)?;
        let opacity = drawn.report.plan.blend_opacity();
        let opacities: Vec<f64> = store.lit.iter().map(|c| (f64::from(c[3]) * opacity).clamp(0.0, 1.0)).collect();
        let seen = Seen::new(&camera, &store.layers, &opacities);
        let pictures = [drawn.image, smooth];
        if let Some((from, old)) = before.replace((seen.clone(), pictures.clone())) {
            let brought = from.brought_to(&seen);
            surfaces += from.depth.iter().filter(|d| d.is_finite()).count() as u64;
            let shown = |image: &LinearImage| displayed(image, options.background);
            let changes = [0, 1].map(|i| change(&shown(&old[i]), &shown(&pictures[i]), &brought));
            let added = Changes::of([&changes[0]]).mean - Changes::of([&changes[1]]).mean;
            if added > most {
                most = added;
                let [[a, c], [b, d]] = [old, pictures];
                worst = Some(Pair { frame: frame - 1, pictures: [a, b, c, d], changes: changes.clone() });
            }
            maps.iter_mut().zip(changes).for_each(|(all, change)| all.push(change));
        }
    }
    let [one, more] = &maps;
    Ok(Orbit { surfaces, single: Changes::of(one), many: Changes::of(more), worst })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::Projection;

    const SIZE: [u32; 2] = [32, 24];

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(0.0, 0.0, 4.0),
            focal_point: DVec3::ZERO,
            view_up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 0.6 },
        }
    }

    /// A plane across z = 0 behind a clear layer, as a camera sees it.
    fn plane(camera: &Camera, opacity: f64) -> Seen {
        let view = View::new(camera, SIZE, glam::DVec2::ZERO);
        let world = camera.view_from_world().inverse();
        let mut store = StoreData { width: SIZE[0], height: SIZE[1], ..StoreData::default() };
        for pixel in 0..SIZE[0] * SIZE[1] {
            let at = |depth: f64| world.transform_point3(view.position(pixel % SIZE[0], pixel / SIZE[0], depth));
            let (eye, along) = (camera.position, at(1.0) - camera.position);
            let depth = -eye.z / along.z;
            store.offsets.push(store.depth.len());
            store.counts.push(2);
            store.depth.extend([0.5 * depth, depth]);
        }
        let opacities = [0.05, opacity].repeat(store.counts.len());
        Seen::new(camera, &store, &opacities)
    }

    /// A pattern on the plane z = 0, smooth over pixels, as a camera sees it.
    fn picture(camera: &Camera) -> Vec<[f64; 3]> {
        let view = View::new(camera, SIZE, glam::DVec2::ZERO);
        let world = camera.view_from_world().inverse();
        let color = |pixel: u32| {
            let at = world.transform_point3(view.position(pixel % SIZE[0], pixel / SIZE[0], 1.0));
            let along = at - camera.position;
            let p = camera.position - along * (camera.position.z / along.z);
            [0.5 + 0.3 * p.x, 0.5 + 0.3 * p.y, 0.5]
        };
        (0..SIZE[0] * SIZE[1]).map(color).collect()
    }

    #[test]
    fn what_only_moves_does_not_change() {
        let (a, b) = (camera(), camera().azimuth(2.0));
        let brought = plane(&a, 0.9).brought_to(&plane(&b, 0.9));
        let (from, to) = (picture(&a), picture(&b));
        let moved = Changes::of([&change(&from, &to, &brought)]);
        assert!(moved.pixels > 600, "{moved:?}");
        // Not exactly nothing: perspective is not linear between pixels, and at the border one side is missing.
        assert!(moved.mean < 2e-4, "{moved:?}");
        let still: Vec<_> = (0..from.len()).map(|i| vec![(i, 1.0)]).collect();
        let unmoved = Changes::of([&change(&from, &to, &still)]);
        assert!(unmoved.mean > 10.0 * moved.mean, "{unmoved:?} {moved:?}");
        // What changes besides is found, and how much.
        let brighter: Vec<_> = to.iter().map(|c| c.map(|v| v + 0.04)).collect();
        let changed = Changes::of([&change(&from, &brighter, &brought)]);
        assert!((changed.mean - 0.04).abs() < 1e-3 && changed.strong_percent == 100.0, "{changed:?}");
    }

    #[test]
    fn what_weighs_most_is_followed_and_what_the_other_frame_does_not_see_is_left_out() {
        let front = plane(&camera(), 0.9);
        assert!((front.depth[0] - 4.0).abs() < 1e-9);
        let background = plane(&camera(), 0.08);
        assert!(background.depth.iter().all(|d| d.is_infinite()));
        assert!(front.brought_to(&background).iter().all(Vec::is_empty));
        let mut hidden = front.clone();
        hidden.depth.iter_mut().step_by(2).for_each(|d| *d *= 0.5);
        let found = front.brought_to(&hidden);
        assert_eq!(found.iter().filter(|f| f.is_empty()).count(), front.depth.len() / 2);
    }
}
