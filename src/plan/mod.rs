//! The plan of a frame, as data: which passes run and why, which do not and why not, what memory they take.
//!
//! [`plan`] is a pure function of settings, scene, view and adapter, tested without a GPU. The renderer executes exactly the
//! passes of a [`FramePlan`], in order; a pass that is not in it allocates nothing and dispatches nothing. *Simulate only the
//! effects a scene calls for* lives here: constant functions need no neighbours, opaque surfaces need no capture.

mod memory;
mod pass;
mod refusal;
mod report;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub use memory::{Band, PlannedBuffer, bands_of_rows};
pub use pass::Pass;
pub use refusal::Refusal;

use crate::math::Camera;
use crate::scene::SceneStats;
use crate::settings::{
    CaptureKind, CurvatureUnit, DepthQuantization, DepthTerm, KeyFormat, NeighbourSearch, NormalEncoding, OpacityModel,
    Settings, SlotSearch, Tail,
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
}

impl Capture {
    /// Whether keys hold triangle numbers (and not shape ids).
    pub fn is_wide(self) -> bool {
        !matches!(self, Capture::BucketedKBuffer { key: KeyFormat::Packed32, .. })
    }
}

/// The features of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Features {
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
    /// The bands, from top to bottom. For [`Capture::Compacted`] they are an estimate: the count decides.
    pub bands: Vec<Band>,
}

impl FramePlan {
    /// Whether a pass runs.
    pub fn runs(&self, pass: Pass) -> bool {
        self.passes.iter().any(|p| p.pass == pass)
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
    plan_rows(settings, opacity, scene, view, capabilities, size, None)
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
    plan_rows(settings, choose_opacity(settings, transfer), scene, view, capabilities, size, Some(row))
}

fn plan_rows(
    settings: &Settings,
    opacity: Opacity,
    scene: &SceneStats,
    view: &ViewStats,
    capabilities: &Capabilities,
    size: [u32; 2],
    picked: Option<u32>,
) -> Result<FramePlan, Refusal> {
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
    let mut draft = Draft { passes: Vec::new(), skipped: Vec::new() };
    let all_opaque = matches!(opacity, Opacity::Constant { alpha } if alpha >= 1.0)
        && scene.blended_materials == 0
        && scene.faded_parts == 0
        && picked.is_none();
    let capture = if all_opaque {
        draft.run(Pass::Opaque, "every surface is opaque: only the nearest can be seen");
        draft.run(Pass::ShowOpaque, "the opaque pass draws into a target of its own");
        draft.skip("capture", "every surface is opaque");
        draft.skip("neighbours, curvature", "every surface is opaque and the colour is not modulated");
        Capture::None
    } else {
        choose_capture(settings, scene, capabilities)?
    };
    let features = (opacity == Opacity::Curvature || picked.is_some())
        .then(|| choose_features(settings, scene, view, size, &mut draft));
    if capture != Capture::None {
        plan_layers(&mut draft, settings, scene, capture, features, opacity);
    }
    plan_sections(&mut draft, scene);
    match scene.selected_parts {
        0 => draft.skip("outline", "nothing is selected"),
        n => {
            draft.run(Pass::OutlineMask, format!("{} outlined through what is in front", counted(n, "is", "are")));
            draft.run(Pass::Outline, "a line around what is selected");
        }
    }
    let samples = if picked.is_some() { 1 } else { settings.image.samples };
    if samples > 1 {
        draft.run(Pass::Accumulate, format!("{samples} jittered frames are averaged"));
    } else {
        draft.skip("accumulate", "one sample a pixel");
    }
    if picked.is_some() {
        draft.passes.retain(|p| !matches!(p.pass, Pass::Blend | Pass::OutlineMask | Pass::Outline));
    }
    let apron = features.map_or(0, |f| f.reach.max(1));
    let mut plan = FramePlan {
        size,
        samples,
        capture,
        normals: settings.capture.normals,
        features,
        opacity,
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

/// Section planes belong to the passes that draw geometry: the first of them says so.
fn plan_sections(draft: &mut Draft, scene: &SceneStats) {
    let (planes, caps) = match (scene.section_planes, scene.caps) {
        (0, _) => return draft.skip("sections", "no plane cuts the scene"),
        (1, caps) => ("1 plane cuts the scene".to_owned(), caps),
        (n, caps) => (format!("{n} planes cut the scene"), caps),
    };
    let drawn = [Pass::Opaque, Pass::ZInsertion, Pass::Count];
    if let Some(first) = draft.passes.iter_mut().find(|p| drawn.contains(&p.pass)) {
        let closed = match caps {
            0 => String::new(),
            1 => ", 1 cap closes it".to_owned(),
            n => format!(", {n} caps close it"),
        };
        first.reason += &format!("; sections: {planes}{closed}");
    }
}

/// "1 part is", "3 parts are".
fn counted(parts: u64, one: &str, more: &str) -> String {
    if parts == 1 { format!("1 part {one}") } else { format!("{parts} parts {more}") }
}

struct Draft {
    passes: Vec<PlannedPass>,
    skipped: Vec<Skipped>,
}

impl Draft {
    fn run(&mut self, pass: Pass, reason: impl Into<String>) {
        self.passes.push(PlannedPass { pass, reason: reason.into() });
    }

    fn skip(&mut self, what: &'static str, reason: impl Into<String>) {
        self.skipped.push(Skipped { what, reason: reason.into() });
    }
}

/// What the settings and the transfer functions make of the layers' opacity. Bakes the functions: a millisecond or two.
pub fn choose_opacity(settings: &Settings, transfer: &TransferFunction) -> Opacity {
    match settings.opacity.model {
        OpacityModel::Opaque => Opacity::Constant { alpha: 1.0 },
        OpacityModel::Constant => Opacity::Constant { alpha: settings.opacity.constant },
        OpacityModel::Curvature => {
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

fn choose_capture(settings: &Settings, scene: &SceneStats, capabilities: &Capabilities) -> Result<Capture, Refusal> {
    match settings.capture.kind {
        CaptureKind::Compacted => Ok(Capture::Compacted),
        CaptureKind::BucketedKBuffer => {
            let s = &settings.capture.bucketed_k_buffer;
            match s.key {
                // Shape id 65535 with depth 65535 would be the empty slot; depth stops at 65534, so every id is legal.
                KeyFormat::Packed32 if scene.parts > 65_535 => Err(Refusal::TooManyParts { parts: scene.parts }),
                KeyFormat::Wide64 if !capabilities.atomic_min_64 => Err(Refusal::NoAtomics64),
                key => Ok(Capture::BucketedKBuffer {
                    k: s.k,
                    key,
                    depth: s.depth,
                    tail: s.tail == Tail::Average,
                    slot_search: s.slot_search,
                }),
            }
        }
    }
}

fn choose_features(
    settings: &Settings,
    scene: &SceneStats,
    view: &ViewStats,
    size: [u32; 2],
    draft: &mut Draft,
) -> Features {
    let c = &settings.features.curvature;
    let shorter = f64::from(size[0].min(size[1]));
    let radius = (c.radius * shorter).round().max(1.0) as u32;
    let line = (c.line_width * shorter).max(1.0);
    let search = if settings.features.neighbours == NeighbourSearch::Buckets && !settings.features.reverse_check {
        draft.skip("buckets", "features.reverse_check is off: the search by buckets includes it");
        NeighbourSearch::BruteForce
    } else {
        settings.features.neighbours
    };
    let (unit, scale_by_part) = match c.unit {
        CurvatureUnit::View => (view.visible_height, false),
        CurvatureUnit::Scene => (scene.radius(), false),
        CurvatureUnit::World => (1.0, false),
        CurvatureUnit::Part => (1.0, true),
    };
    Features {
        search,
        depth_term: settings.features.depth_term,
        reverse_check: settings.features.reverse_check,
        radius,
        reach: radius.max(line.ceil() as u32),
        line,
        scale: c.scale * unit,
        scale_by_part,
    }
}

fn plan_layers(
    draft: &mut Draft,
    settings: &Settings,
    scene: &SceneStats,
    capture: Capture,
    features: Option<Features>,
    opacity: Opacity,
) {
    let otherwise_opaque = opacity == (Opacity::Constant { alpha: 1.0 });
    let transparent = match (scene.blended_materials, scene.faded_parts) {
        (1, _) if otherwise_opaque => "1 material blends".to_owned(),
        (n @ 2.., _) if otherwise_opaque => format!("{n} materials blend"),
        (_, n @ 1..) if otherwise_opaque => format!("{} ghosted or translucent", counted(n, "is", "are")),
        _ if otherwise_opaque => "a pixel is picked through".to_owned(),
        _ => "layers are transparent".to_owned(),
    };
    let buckets = features.is_some_and(|f| f.search == NeighbourSearch::Buckets);
    let bucket_passes = |draft: &mut Draft| {
        draft.run(Pass::ZReordering, "buckets group a pixel's layers by part");
        draft.run(Pass::BucketCreation, "searches read only the bucket of the same part");
    };
    match capture {
        Capture::None => {}
        Capture::BucketedKBuffer { k, slot_search, .. } => {
            draft.run(Pass::Clear, "the rows hold the last frame");
            draft.run(Pass::ZInsertion, format!("{transparent}: the {k} nearest of each pixel are kept"));
            draft.run(Pass::CountLayers, "what was stored, merged and dropped is reported");
            let by_bucket = slot_search == SlotSearch::Bucket;
            if !by_bucket {
                draft.run(Pass::DataStorage, "the surfaces of the stored keys, found by depth");
            }
            if by_bucket {
                draft.run(Pass::PartLookup, "buckets group layers by part");
            }
            if buckets || by_bucket {
                bucket_passes(draft);
            } else {
                draft.skip("z reordering, bucket creation", "nothing searches by part");
            }
            if by_bucket {
                draft.run(Pass::DataStorage, "the surfaces of the stored keys, found by bucket and depth");
            }
        }
        Capture::Compacted => {
            draft.run(Pass::Count, format!("{transparent}: every layer is kept"));
            draft.run(Pass::PrefixSum, "where each pixel's layers begin");
            draft.run(Pass::Append, "keys and surfaces as they come");
            draft.run(Pass::Sort, "by depth, then by triangle number");
            draft.run(Pass::Gather, "surfaces in the order of the sort");
            if features.is_some() {
                draft.run(Pass::PartLookup, "neighbours belong to the same part");
            }
            if buckets {
                bucket_passes(draft);
            } else {
                draft.skip("z reordering, bucket creation", "nothing searches by part");
            }
        }
    }
    if let Some(f) = features {
        let check = "a neighbour must see the layer as its own (Murray 2016, Figure 5)";
        if f.search == NeighbourSearch::Buckets {
            draft.run(Pass::NeighbourLinks, format!("curvature needs neighbours; {check}"));
        } else {
            draft.run(Pass::NeighbourCandidates, "curvature needs neighbours");
            if f.reverse_check {
                draft.run(Pass::NeighbourLinks, check);
            } else {
                draft.skip("neighbour links", "features.reverse_check is off");
            }
        }
        if scene.section_planes > 0 {
            draft.run(Pass::CutLinks, "a cut is unknown to features, not a silhouette (T10)");
        }
        draft.run(Pass::Curvature, "a transfer function varies with curvature");
    } else {
        draft.skip(
            "neighbours, curvature",
            match settings.opacity.model {
                OpacityModel::Curvature => "no transfer function varies with curvature",
                OpacityModel::Constant => "opacity is constant",
                OpacityModel::Opaque => "opacity does not depend on curvature",
            },
        );
    }
    draft.run(Pass::Shade, "every stored layer is lit once");
    match opacity {
        Opacity::Curvature => draft.run(Pass::Stylize, "colour and opacity follow curvature and depth"),
        Opacity::Depth => draft.run(Pass::Stylize, "opacity follows depth"),
        Opacity::Constant { .. } => draft.skip("stylize", "opacity is the same for all layers"),
    }
    let of_parts = match scene.faded_parts + scene.solid_parts {
        0 => "",
        _ => ", by the opacity of their parts",
    };
    draft.run(Pass::Blend, format!("the layers of each pixel over each other{of_parts}"));
}
