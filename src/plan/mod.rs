//! The plan of a frame, as data: which passes run and why, which do not and why not, what memory they take.
//!
//! [`plan`] is a pure function of settings, scene, view and adapter, tested without a GPU. The renderer executes exactly the
//! passes of a [`FramePlan`], in order; a pass that is not in it allocates nothing and dispatches nothing. *Simulate only the
//! effects a scene calls for* lives here: constant functions need no neighbours, opaque surfaces need no capture.

mod layers;
mod memory;
mod pass;
mod refusal;
mod report;
#[cfg(test)]
mod tests;

use serde::Serialize;

use layers::{Draft, choose_capture, choose_features, counted, plan_sections};
pub use memory::{Band, PlannedBuffer, bands_of_rows};
pub use pass::Pass;
pub use refusal::Refusal;

use crate::math::Camera;
use crate::scene::SceneStats;
use crate::settings::{
    CaptureKind, DepthQuantization, DepthTerm, KeyFormat, ListSort, NeighbourSearch, NormalEncoding, OpacityModel,
    PrintedForm, Settings, SlotSearch, Tail,
};
use crate::transfer::TransferFunction;

/// What a plan may assume of the adapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Capabilities {
    /// Largest storage buffer binding, bytes.
    pub max_binding: u64,
    /// Largest buffer, bytes.
    pub max_buffer: u64,
    /// Largest width or height of an image.
    pub max_texture: u32,
    /// Storage buffers that one stage may bind.
    pub max_storage_buffers: u32,
    /// Atomic minimum on 64-bit integers that returns the old value.
    pub atomic_min_64: bool,
    /// Most layers that a pixel's list may have.
    pub most_layers: u32,
}

/// Most layers of a pixel: links and positions in buckets have 16 bits, two values of which mean something else.
pub const MOST_LAYERS: u32 = 65_533;

/// Most layers of a pixel on Mesa's software rasterizer. An invocation may go through 65 535 rounds of loops there, all its
/// loops together; then they end in silence, wherever they are. Sorting a list takes about 2 n log2 n rounds, searching the
/// neighbours of one layer up to 4 n.
pub const MOST_LAYERS_LLVMPIPE: u32 = 2048;

impl Capabilities {
    /// Bytes that one buffer of a frame may have. Shaders number words of 4 bytes with 32 bits, whatever the adapter allows.
    pub fn largest_buffer(&self) -> u64 {
        self.max_binding.min(self.max_buffer).min(1 << 33)
    }
}

impl Default for Capabilities {
    /// What WebGPU guarantees.
    fn default() -> Capabilities {
        Capabilities {
            max_binding: 128 << 20,
            max_buffer: 256 << 20,
            max_texture: 8192,
            max_storage_buffers: 8,
            atomic_min_64: false,
            most_layers: MOST_LAYERS,
        }
    }
}

/// What a plan may assume of the view: what the camera shows, and what the last frame of it measured.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ViewStats {
    /// Visible height at the focal point, scene units.
    pub visible_height: f64,
    /// Fragments that the last frame rasterized, if there was one.
    pub fragments: Option<u64>,
}

impl ViewStats {
    /// What is known before the first frame.
    pub fn of(camera: &Camera) -> ViewStats {
        ViewStats { visible_height: camera.visible_height(), fragments: None }
    }
}

/// A pass that runs, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedPass {
    /// Which.
    pub pass: Pass,
    /// Why it runs.
    pub reason: String,
}

/// An effect that does not run, and why not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Skipped {
    /// What would have run.
    pub what: &'static str,
    /// Why it does not.
    pub reason: String,
}

/// Which capture fills the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Capture {
    /// Nothing is captured.
    None,
    /// The k nearest layers.
    BucketedKBuffer {
        /// Slots a pixel.
        k: u32,
        /// Key format.
        key: KeyFormat,
        /// Depth of packed keys.
        depth: DepthQuantization,
        /// Whether the tail is kept.
        tail: bool,
        /// How data storage finds slots.
        slot_search: SlotSearch,
    },
    /// Every layer.
    Compacted,
    /// Every layer, by linked lists.
    LinkedList {
        /// How lists are sorted.
        sort: ListSort,
        /// Fragments for which room is made before their number is known; 0 for as many as an estimate expects.
        capacity: u32,
        /// Most bytes of lists and layers.
        memory: u64,
    },
}

impl Capture {
    /// Whether keys hold triangle numbers (and not shape ids).
    pub fn is_wide(self) -> bool {
        !matches!(self, Capture::BucketedKBuffer { key: KeyFormat::Packed32, .. })
    }

    /// Whether the store is a run without gaps that holds every layer, however many there are.
    pub fn is_whole(self) -> bool {
        matches!(self, Capture::Compacted | Capture::LinkedList { .. })
    }
}

/// The features of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Features {
    /// Whether curvature is computed, and not neighbours alone.
    pub curvature: bool,
    /// How neighbours are searched.
    pub search: NeighbourSearch,
    /// With which depth candidates are compared.
    pub depth_term: DepthTerm,
    /// Whether a neighbour must see the layer as its own.
    pub reverse_check: bool,
    /// Steps along the links over which curvature is estimated.
    pub radius: u32,
    /// Steps of the walk: the radius, or as far as lines are wide.
    pub reach: u32,
    /// Width of rims and creases, pixels, at least 1.
    pub line: f64,
    /// Sensitivity times unit of length; for [`CurvatureUnit::Part`] the sensitivity alone.
    pub scale: f64,
    /// Whether the unit is the part's radius.
    pub scale_by_part: bool,
}

/// What happens to the image after the store is lit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Opacity {
    /// The same for every layer.
    Constant {
        /// Multiplies the material's own opacity; the product is clamped, so it may exceed 1.
        alpha: f64,
    },
    /// Transfer functions that do not vary with curvature.
    Depth,
    /// Transfer functions over curvature.
    Curvature,
    /// The same for all layers of a pixel, so that together they have this one.
    Adaptive {
        /// Opacity of all together.
        share: f64,
    },
    /// By the angle between normal and sight line.
    AngleBased,
    /// By how fast the normal turns.
    NormalVariation,
    /// By layer index, so that each is seen as much as any other in the whole image.
    EqualShare,
}

/// Illustrative transparency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Illustration {
    /// Steps of diffusion that are always taken.
    pub heat_steps: u32,
    /// Most steps; the GPU stops earlier where nothing changes.
    pub most_steps: u32,
    /// Pixels below which a surface is small and diffusion reaches less far; 0 for isotropic diffusion.
    pub feature_size: u32,
    /// Whether what passes a layer is 1 − α, as printed (T14).
    pub printed_transmittance: bool,
}

impl Illustration {
    /// Rows from which the opacity of a layer is gathered.
    fn reach(&self) -> u32 {
        self.most_steps + if self.most_steps > 0 { self.feature_size } else { 0 }
    }
}

/// A frame, ready to be executed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FramePlan {
    /// Width and height of the image, pixels.
    pub size: [u32; 2],
    /// Frames averaged.
    pub samples: u32,
    /// How fragments are captured.
    pub capture: Capture,
    /// How normals are stored.
    pub normals: NormalEncoding,
    /// Features, if any opacity needs them.
    pub features: Option<Features>,
    /// Opacity of the layers.
    pub opacity: Opacity,
    /// What illustrative transparency makes of it.
    pub illustration: Option<Illustration>,
    /// Whether parts have opacities of their own: ghosted, translucent, solid.
    pub faded: bool,
    /// Whether parts have colours of their own.
    pub recolored: bool,
    /// Section planes that cut.
    pub section_planes: u64,
    /// What runs, in order.
    pub passes: Vec<PlannedPass>,
    /// What does not.
    pub skipped: Vec<Skipped>,
    /// Memory.
    pub buffers: Vec<PlannedBuffer>,
    /// Rows above and below a band that it needs besides its own.
    pub apron: u32,
    /// Most rows of a band: those whose per-pixel buffers fit a binding.
    pub most_rows: u32,
    /// The bands, from top to bottom. Where the whole of every list is kept they are an estimate: the count decides.
    pub bands: Vec<Band>,
}

impl FramePlan {
    /// Whether a pass runs.
    pub fn runs(&self, pass: Pass) -> bool {
        self.passes.iter().any(|p| p.pass == pass)
    }

    /// What blending multiplies the opacity of every layer with.
    pub fn blend_opacity(&self) -> f64 {
        match self.opacity {
            Opacity::Constant { alpha } if self.illustration.is_none() => alpha,
            _ => 1.0,
        }
    }

    /// Whether all of so many bands have to be captured before the first can be lit, because opacity depends on the whole image.
    pub fn gathers_first(&self, bands: usize) -> bool {
        bands > 1 && self.runs(Pass::LayerHistogram)
    }

    /// Rows above and below those of a band that layers have to be lit in, because their opacity spreads from there.
    pub fn lit_apron(&self) -> u32 {
        self.illustration.map_or(0, |i| i.most_steps)
    }

    /// Sum of all buffers, bytes.
    pub fn total_bytes(&self) -> u64 {
        self.buffers.iter().map(|b| b.bytes).sum()
    }
}

/// Storage buffers that the largest pass binds, without and with a tail, and where parts have looks of their own.
pub fn storage_buffers(tail: bool, looks: bool) -> u32 {
    // Links by buckets. Data storage binds the tail's sums and the tables of the transfer functions that weigh them, and the
    // table of parts for their looks. A test counts.
    match (tail, looks) {
        (false, _) => 10,
        (true, false) => 11,
        (true, true) => 12,
    }
}

/// Plans a frame.
///
/// # Errors
/// A [`Refusal`] says what was asked, what the limit is, and what would fit.
pub fn plan(
    settings: &Settings,
    transfer: &TransferFunction,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
) -> Result<FramePlan, Refusal> {
    plan_with(settings, choose_opacity(settings, transfer), scene, view, capabilities, size)
}

/// Plans a frame whose opacity is already chosen ([`choose_opacity`]).
///
/// # Errors
/// As [`plan`].
pub fn plan_with(
    settings: &Settings,
    opacity: Opacity,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
) -> Result<FramePlan, Refusal> {
    plan_for(Purpose::Picture, settings, opacity, scene, view, capabilities, size)
}

/// Plans a frame whose layers are read back: one sample a pixel, its middle. Opaque frames are captured too, and curvature is
/// always computed; the picture is that of [`plan`] with one sample.
///
/// # Errors
/// As [`plan`].
pub fn plan_layers(
    settings: &Settings,
    transfer: &TransferFunction,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
) -> Result<FramePlan, Refusal> {
    plan_for(Purpose::Layers, settings, choose_opacity(settings, transfer), scene, view, capabilities, size)
}

/// Plans the layers of one pixel in `row` of a frame, and of as many rows around it as features reach: everything that the
/// frame does up to the colours of its layers. Opaque frames are captured too, and curvature is always computed.
///
/// # Errors
/// As [`plan`].
pub fn plan_pick(
    settings: &Settings,
    transfer: &TransferFunction,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
    row: u32,
) -> Result<FramePlan, Refusal> {
    plan_for(Purpose::Pixel(row), settings, choose_opacity(settings, transfer), scene, view, capabilities, size)
}

/// What a plan is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Purpose {
    /// A picture.
    Picture,
    /// A picture and the layers that it is made of.
    Layers,
    /// The layers of a pixel in this row.
    Pixel(u32),
}

fn plan_for(
    purpose: Purpose,
    settings: &Settings,
    opacity: Opacity,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
) -> Result<FramePlan, Refusal> {
    let picked = match purpose {
        Purpose::Pixel(row) => Some(row),
        Purpose::Picture | Purpose::Layers => None,
    };
    let read_back = purpose != Purpose::Picture;
    let [width, height] = size;
    if width == 0 || height == 0 {
        return Err(Refusal::EmptyImage { width, height });
    }
    if width > capabilities.max_texture || height > capabilities.max_texture {
        return Err(Refusal::ImageTooLarge { width, height, limit: capabilities.max_texture });
    }
    let tail = settings.capture.kind == CaptureKind::BucketedKBuffer
        && settings.capture.bucketed_k_buffer.tail == Tail::Average;
    let looks = scene.faded_parts + scene.solid_parts + scene.recolored_parts > 0;
    let needed = storage_buffers(tail, looks);
    if capabilities.max_storage_buffers < needed {
        let limit = capabilities.max_storage_buffers;
        let without_tail = Some(storage_buffers(false, looks)).filter(|&n| tail && n <= limit);
        return Err(Refusal::TooFewBindings { needed, limit, without_tail });
    }
    let mut draft = Draft::default();
    let illustration = (settings.opacity.model == OpacityModel::Illustrative).then(|| {
        let s = settings.opacity.illustrative.in_pixels(size);
        let steps = s.steps();
        let printed_transmittance = s.printed == PrintedForm::Transmittance;
        let (heat_steps, most_steps) = (steps.heat, steps.most);
        Illustration { heat_steps, most_steps, feature_size: s.feature_size, printed_transmittance }
    });
    let all_opaque = matches!(opacity, Opacity::Constant { alpha } if alpha >= 1.0)
        && illustration.is_none()
        && scene.blended_materials == 0
        && scene.faded_parts == 0
        && !read_back;
    let capture = if all_opaque {
        draft.run(Pass::Opaque, "every surface is opaque: only the nearest can be seen");
        draft.run(Pass::ShowOpaque, "the opaque pass draws into a target of its own");
        draft.skip("capture", "every surface is opaque");
        draft.skip("neighbours, curvature", "every surface is opaque and the colour is not modulated");
        Capture::None
    } else {
        choose_capture(settings, scene, capabilities, picked.is_some())?
    };
    let with_curvature = opacity == Opacity::Curvature || read_back;
    let features = (with_curvature || opacity == Opacity::NormalVariation || illustration.is_some())
        .then(|| choose_features(settings, scene, view, size, with_curvature, &mut draft));
    if capture != Capture::None {
        layers::plan_layers(&mut draft, settings, scene, capture, (features, opacity, illustration));
    }
    plan_sections(&mut draft, scene);
    match scene.selected_parts {
        0 => draft.skip("outline", "nothing is selected"),
        n => {
            draft.run(Pass::OutlineMask, format!("{} outlined through what is in front", counted(n, "is", "are")));
            draft.run(Pass::Outline, "a line around what is selected");
        }
    }
    let samples = if read_back { 1 } else { settings.image.samples };
    if samples > 1 {
        draft.run(Pass::Accumulate, format!("{samples} jittered frames are averaged"));
    } else {
        draft.skip("accumulate", "one sample a pixel");
    }
    if picked.is_some() {
        draft.passes.retain(|p| !matches!(p.pass, Pass::Blend | Pass::OutlineMask | Pass::Outline));
    }
    // A picked pixel's opacity depends on all others too.
    let all = picked.is_some() && opacity == Opacity::EqualShare;
    let apron = if all { width.max(height) } else { 0 }
        .max(features.map_or(0, |f| f.reach.max(1)) + illustration.map_or(0, |i| i.reach()));
    let mut plan = FramePlan {
        size,
        samples,
        capture,
        normals: settings.capture.normals,
        features,
        opacity,
        illustration,
        faded: capture != Capture::None && scene.faded_parts + scene.solid_parts > 0,
        recolored: scene.recolored_parts > 0,
        section_planes: scene.section_planes,
        passes: draft.passes,
        skipped: draft.skipped,
        buffers: Vec::new(),
        apron,
        most_rows: size[1],
        bands: Vec::new(),
    };
    memory::fill(&mut plan, picked, view, capabilities)?;
    Ok(plan)
}

/// What the settings and the transfer functions make of the layers' opacity. Bakes the functions: a millisecond or two.
pub fn choose_opacity(settings: &Settings, transfer: &TransferFunction) -> Opacity {
    match settings.opacity.base_model() {
        OpacityModel::Adaptive => Opacity::Adaptive { share: settings.opacity.adaptive },
        OpacityModel::AngleBased => Opacity::AngleBased,
        OpacityModel::NormalVariation => Opacity::NormalVariation,
        OpacityModel::EqualShare => Opacity::EqualShare,
        OpacityModel::Opaque => Opacity::Constant { alpha: 1.0 },
        OpacityModel::Constant => Opacity::Constant { alpha: settings.opacity.constant },
        // No base is illustrative itself.
        OpacityModel::Curvature | OpacityModel::Illustrative => {
            if transfer.depends_on_curvature() {
                Opacity::Curvature
            } else if let (true, Some(alpha)) =
                (transfer.color.constant() == Some([0.5; 3]), transfer.opacity.constant())
            {
                Opacity::Constant { alpha: f64::from(alpha) * settings.opacity.gain }
            } else {
                Opacity::Depth
            }
        }
    }
}
