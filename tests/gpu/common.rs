//! The shared renderer, settings from text, and comparison.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use glam::{DVec2, DVec3};
use pellucid::gpu::{Gpu, GpuOptions};
use pellucid::math::Camera;
use pellucid::oracle::{Extents, View};
use pellucid::render::{DrawOrder, Renderer, StoreReadback};
use pellucid::scene::Scene;
use pellucid::scene::hard_case::ShaderChange;
use pellucid::settings::{LengthUnit, OpacityModel, Settings};
pub use pellucid::tradeoff::hard_cases::Shot;
use pellucid::tradeoff::hard_cases::changed_module;
use pellucid::transfer::{TransferFunction, TransferSource};

pub type Lock = MutexGuard<'static, Renderer>;

fn open(cell: &'static OnceLock<Option<Mutex<Renderer>>>, options: &GpuOptions) -> Option<Lock> {
    let opened = cell.get_or_init(|| match Gpu::new(options) {
        Ok(gpu) => {
            println!("adapter: {} ({})", gpu.facts().name, gpu.facts().backend);
            Some(Mutex::new(Renderer::new(gpu).expect("a renderer")))
        }
        Err(error) if std::env::var_os("CI").is_some() => panic!("CI is set and no adapter answers: {error}"),
        Err(_) => None,
    });
    match opened {
        Some(renderer) => {
            let mut renderer = renderer.lock().unwrap_or_else(PoisonError::into_inner);
            renderer.draw_order = DrawOrder::default();
            Some(renderer)
        }
        None if std::env::var_os("CI").is_some() => panic!("CI is set and no adapter answers"),
        None => {
            println!("SKIPPED: no adapter answers, tests on the GPU did not run");
            None
        }
    }
}

/// The renderer that all tests share.
pub fn renderer() -> Option<Lock> {
    static RENDERER: OnceLock<Option<Mutex<Renderer>>> = OnceLock::new();
    open(&RENDERER, &GpuOptions::default())
}

/// A renderer whose bindings hold only so much that small pictures need bands.
pub const SMALL_BINDING: u64 = 128 << 10;

pub fn small_renderer() -> Option<Lock> {
    static RENDERER: OnceLock<Option<Mutex<Renderer>>> = OnceLock::new();
    open(&RENDERER, &GpuOptions { max_binding: Some(SMALL_BINDING), ..GpuOptions::default() })
}

/// Whether expensive matrices run whole.
pub fn full() -> bool {
    std::env::var_os("PELLUCID_TEST_FULL").is_some()
}

/// Curvature alone and lengths in pixels, changed by `path=value` pairs, separated by spaces.
pub fn settings(pairs: &str) -> Settings {
    let mut settings = Settings::default();
    settings.opacity.model = OpacityModel::Curvature;
    settings.opacity.illustrative.unit = LengthUnit::Pixel;
    for pair in pairs.split_whitespace() {
        let (path, value) = pair.split_once('=').unwrap_or_else(|| panic!("{pair}"));
        let path = match path {
            "kind" => "capture.kind",
            "k" => "capture.bucketed_k_buffer.k",
            "key" => "capture.bucketed_k_buffer.key",
            "depth" => "capture.bucketed_k_buffer.depth",
            "sort" => "capture.linked_list.sort",
            "tail" => "capture.bucketed_k_buffer.tail",
            "normals" => "capture.normals",
            "search" => "features.neighbours",
            "reverse" => "features.reverse_check",
            "curvature" => "features.curvature.kind",
            "unit" => "features.curvature.unit",
            "scale" => "features.curvature.scale",
            "radius" => "features.curvature.radius",
            "crease" => "features.curvature.crease_angle",
            "line" => "features.curvature.line_width",
            "model" => "opacity.model",
            "constant" => "opacity.constant",
            "gain" => "opacity.gain",
            path => path,
        };
        let value = match value {
            "bkb" => "bucketed_k_buffer",
            "lists" => "linked_list",
            value => value,
        };
        settings.set(path, value).unwrap_or_else(|e| panic!("{e}"));
    }
    settings
}

/// The same settings with an inline transfer function.
pub fn with_transfer(mut settings: Settings, transfer: TransferFunction) -> Settings {
    settings.opacity.transfer = TransferSource::Inline(Box::new(transfer));
    settings
}

/// A transfer function in which every entry of both tables differs.
pub fn lively() -> TransferFunction {
    transfer(
        "[color]\nmode = \"tint\"\ninterpolation = \"linear\"\npoints = [{ kappa = -1.0, color = [0.95, 0.9, 0.7] }, \
         { kappa = 0.0, color = 0.5 }, { kappa = 1.0, color = [0.1, 0.2, 0.3] }]\n[opacity]\ninterpolation = \"linear\"\n\
         depth_interpolation = \"linear\"\ncurves = [{ depth = 0.0, points = [[0.0, 0.15], [1.0, 0.9]] }, \
         { depth = 1.0, points = [[0.0, 0.35], [1.0, 1.0]] }]\n",
    )
}

pub fn transfer(text: &str) -> TransferFunction {
    TransferFunction::from_toml(text, "test").unwrap_or_else(|e| panic!("{e}"))
}

/// A camera that shows most of the scene: some of it lies beyond the image.
pub fn camera(scene: &Scene, orthographic: bool) -> Camera {
    Camera::framing(&scene.bounds(), DVec3::new(-0.37, -0.41, -0.83), DVec3::Y, 1.0, 1.9, orthographic, 0.6)
}

/// The same from +z.
pub fn front(scene: &Scene, orthographic: bool) -> Camera {
    Camera::framing(&scene.bounds(), DVec3::NEG_Z, DVec3::Y, 1.0, 0.9, orthographic, 0.6)
}

/// Uploads, draws and reads back; the store is empty where there is none, or only that of the last band.
pub fn draw(r: &mut Renderer, scene: &Scene, camera: &Camera, settings: &Settings, size: [u32; 2]) -> Shot {
    Shot::take(r, scene, camera, settings, size).expect("a frame")
}

/// What tests ask of a frame and its store.
pub trait Compared {
    fn kappa_bits(&self) -> Vec<u32>;

    /// Everything that must be equal where two ways lead to the same store and picture.
    fn assert_same(&self, other: &Self, what: &str);
}

impl Compared for Shot {
    fn kappa_bits(&self) -> Vec<u32> {
        self.store.kappa.iter().map(|k| k.to_bits()).collect()
    }

    fn assert_same(&self, other: &Shot, what: &str) {
        let (a, b) = (&self.store, &other.store);
        assert_eq!(a.layers.counts, b.layers.counts, "{what}: layers of the pixels");
        assert_first(&a.words, &b.words, &format!("{what}: stored words"));
        assert_first(&a.layers.part, &b.layers.part, &format!("{what}: parts"));
        assert_first(&a.links, &b.links, &format!("{what}: links"));
        assert_first(&self.kappa_bits(), &other.kappa_bits(), &format!("{what}: kappa"));
        let bits = |s: &StoreReadback| s.lit.iter().map(|c| c.map(f32::to_bits)).collect::<Vec<_>>();
        assert_first(&bits(a), &bits(b), &format!("{what}: lit colour"));
        assert_first(&self.bits(), &other.bits(), &format!("{what}: image"));
    }
}

/// Equality of long lists that names the first difference only.
pub fn assert_first<T: PartialEq + std::fmt::Debug>(a: &[T], b: &[T], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}: length");
    let differing = a.iter().zip(b).filter(|(a, b)| a != b).count();
    if let Some(i) = a.iter().zip(b).position(|(a, b)| a != b) {
        panic!("{what}: {differing} of {} differ, first {i}: {:?} and {:?}", a.len(), a[i], b[i]);
    }
}

pub fn view_of(camera: &Camera, size: [u32; 2]) -> View {
    View::new(camera, size, DVec2::ZERO)
}

pub fn extents_of(scene: &Scene, camera: &Camera) -> Extents {
    Extents::new(scene, camera)
}

pub fn percentile(values: &mut [f64], p: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    if values.is_empty() { 0.0 } else { values[((values.len() - 1) as f64 * p) as usize] }
}

pub fn assert_finite(shot: &Shot, what: &str) {
    assert_eq!(shot.fault(), None, "{what}");
    assert!(shot.frame.report.layers.balanced(), "{what}: {:?}", shot.frame.report.layers);
}

/// Text of a shader module with a change.
pub fn changed(module: &'static str, from: &'static str, to: &'static str) -> String {
    changed_module(&ShaderChange { module, from, to }).unwrap_or_else(|e| panic!("{e}"))
}
