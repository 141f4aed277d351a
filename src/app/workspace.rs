//! What the window knows, apart from the window: the document, what is on screen, what is said, what the panels ask for.
//!
//! Panels read and change this and nothing else, so tests can show them without a display or an adapter. What needs more than
//! this (a dialog, a thread, the clipboard) is put into [`Workspace::asks`], and the shell does it after the frame.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::accuracy::{Accuracy, Wanted};
use super::camera::{self, Frame};
use super::compare::{Compare, PictureOfA};
use super::config::Preferences;
use super::dialogs::{Choice, Prompt};
use super::document::{Document, Seen};
use super::editors;
use super::functions::{Functions, Resolved};
use super::loader::{HARD_CASE, MADE_IN_MEMORY, Opened};
use super::measure::Measure;
use super::models::Models;
use super::panels::parts::Tree;
use super::panels::planes;
use super::panels::room::Sizes;
use super::pictures::{Counted, Extras, Kind, Picked, Picture, Wish};
use super::viewport::Shown;
use super::watch::{Changed, ShaderTexts};
use crate::import::Phase;
use crate::math::{Camera, LinearImage};
use crate::plan::{self, Capabilities, FramePlan, ViewStats};
use crate::render::FrameReport;
use crate::scene::cut::Solids;
use crate::scene::{Arrangement, Cut, Scene, SceneStats};
use crate::session::configuration::Configuration;
use crate::session::{Session, camera_in_file, camera_in_scene};
use crate::settings::Settings;
use crate::transfer::{TransferFunction, TransferSource};

/// Something for the shell to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Choose a file in a dialog.
    Choose(Choice),
    /// Do with a path what it was chosen for.
    Use {
        /// What for.
        choice: Choice,
        /// Of a file.
        path: String,
        /// In the window's own line: asked for again if nothing could be written there.
        typed: bool,
    },
    /// Take over size and theme of the interface.
    Restyle,
    /// Open this file.
    Open(String),
    /// Stop loading.
    CancelLoading,
    /// Put text on the clipboard.
    Copy(String),
    /// Find the layers under a pixel of the picture.
    Pick([u32; 2], Wish),
    /// Draw a frame.
    Redraw,
    /// Write what the export panel says into this file.
    Export(String),
    /// Stop writing pictures.
    CancelExport,
    /// Draw the opacity models that are compared.
    DrawModels,
    /// Measure configurations of what is seen.
    Measure(Wanted),
    /// Stop measuring.
    StopMeasuring,
    /// Write the preferences.
    Remember,
    /// Close the window.
    Quit,
}

/// How bad a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gravity {
    /// Something went as it should.
    Note,
    /// The picture or the file is not quite what was asked for.
    Notice,
    /// Something did not work.
    Error,
}

/// Something said to the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// How bad it is.
    pub gravity: Gravity,
    /// One sentence or two.
    pub text: String,
}

/// What is on screen.
pub struct OnScreen {
    /// Its pixels.
    pub shown: Arc<Shown>,
    /// Of which order.
    pub number: u64,
    /// Exact or not.
    pub kind: Kind,
    /// Camera and viewport that it is of.
    pub view: (Camera, [u32; 2]),
    /// Settings and arrangement that it is of.
    pub look: (Settings, Arrangement),
    /// Its own size.
    pub size: [u32; 2],
    /// The exact picture before it was rounded, linear light.
    pub linear: Option<Arc<LinearImage>>,
    /// From order to pixels, milliseconds.
    pub milliseconds: f64,
}

/// A model on its way, for show.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadingView {
    /// As asked for.
    pub file: String,
    /// What the importer is at, and the share of that which is done; nothing where a scene is generated.
    pub phase: Option<(Phase, f32)>,
}

/// Where the picture is, in physical pixels of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Viewport {
    /// Left and top.
    pub origin: [u32; 2],
    /// Width and height; 0 before the first frame.
    pub size: [u32; 2],
}

impl Viewport {
    /// Whether a pixel of the window is in it.
    pub fn contains(self, at: DVec2) -> bool {
        let [x, y] = self.origin.map(f64::from);
        let [w, h] = self.size.map(f64::from);
        at.x >= x && at.y >= y && at.x < x + w && at.y < y + h
    }

    /// The same, as gestures measure it.
    pub fn frame(self) -> Frame {
        Frame { size: DVec2::from(self.size.map(f64::from)) }
    }
}

/// What the panels keep for themselves.
#[derive(Default)]
pub struct Layout {
    /// How large the panels are.
    pub sizes: Sizes,
    /// The list of shortcuts is shown.
    pub shortcuts: bool,
    /// A path that is asked for.
    pub prompt: Option<Prompt>,
    /// The last file to be opened whose path was typed.
    pub typed: Option<String>,
    /// What is searched among the parts.
    pub search: String,
    /// The tree of parts, laid out for the scene at hand.
    pub tree: Option<Tree>,
    /// Layers to choose from, where a list of them was asked for.
    pub stack: Option<Picked>,
    /// The name of a view that is to be saved.
    pub naming: Option<String>,
    /// What is to be written as pictures, while that is asked for.
    pub export: Option<super::exports::Form>,
    /// A setting's text while it is typed: its path and the text.
    pub typing: Option<(String, String)>,
    /// What is selected in the transfer-function editors.
    pub editors: editors::State,
    /// Handles of the section planes.
    pub planes: planes::State,
}

/// What the planner has to know of the arranged scene, caps included, as the renderer counts it: filling them takes a while,
/// so it is kept.
struct Counts {
    scene_number: u64,
    solids: Solids,
    of: Option<(Arrangement, SceneStats)>,
}

impl Counts {
    fn of(&mut self, scene: &Scene, arrangement: &Arrangement) -> SceneStats {
        match &self.of {
            Some((of, stats)) if of == arrangement => stats.clone(),
            _ => {
                let stats = Cut::new(scene, arrangement, &self.solids).stats(scene, arrangement);
                self.of = Some((arrangement.clone(), stats.clone()));
                stats
            }
        }
    }
}

/// What a plan was made for.
struct Planned {
    scene_number: u64,
    seen: Seen,
    transfer: Option<Arc<TransferFunction>>,
    size: [u32; 2],
}

/// Everything that the window knows.
pub struct Workspace {
    /// The model and what is seen of it.
    pub document: Option<Document>,
    /// Another model has another number.
    pub scene_number: u64,
    /// What is remembered.
    pub preferences: Preferences,
    /// What configuration files say.
    pub configuration: Arc<Configuration>,
    /// What is said, oldest first.
    pub messages: Vec<Message>,
    /// What is being opened.
    pub loading: Option<LoadingView>,
    /// What is on screen.
    pub screen: Option<OnScreen>,
    /// The report of the last exact picture, and of what it was.
    pub report: Option<(Seen, FrameReport)>,
    /// The number of the last order: what is on screen is up to date if it has it.
    pub order: u64,
    /// Why there is no exact picture of the last order.
    pub refusal: Option<String>,
    /// What the adapter can do, once it has answered.
    pub capabilities: Option<Capabilities>,
    /// Its name.
    pub adapter: Option<String>,
    /// What would run; `None` without a model or an adapter.
    pub plan: Option<Result<FramePlan, String>>,
    planned: Option<Planned>,
    arranged: Option<Counts>,
    /// Where the picture is.
    pub viewport: Viewport,
    /// What turning turns about; the focal point if `None`.
    pub pivot: Option<DVec3>,
    /// What was found under the last click, and which of its layers is chosen.
    pub picked: Option<(Picked, usize)>,
    /// The transfer functions, resolved.
    pub functions: Functions,
    /// Layers by depth and curvature of the last picture worth counting.
    pub counts: Option<Counted>,
    /// Texts that stand in for shader modules.
    pub shaders: Arc<ShaderTexts>,
    /// Settings that the present ones are compared with.
    pub compare: Option<Compare>,
    /// What is wrong in the picture, and what it would cost to have it right.
    pub accuracy: Accuracy,
    /// What is under the resting cursor.
    pub hover: Option<Picked>,
    /// What is measured.
    pub measure: Measure,
    /// Pictures that are being written: how many are done, of how many.
    pub exporting: Option<(u32, u32)>,
    /// Opacity models beside each other, while they are shown.
    pub models: Option<Models>,
    /// The settings from before a hard case was opened, which has its own.
    settings_before_case: Option<Settings>,
    /// What the panels keep.
    pub layout: Layout,
    /// What the shell has to do.
    pub asks: Vec<Ask>,
}

impl Workspace {
    /// An empty one.
    pub fn new(preferences: Preferences) -> Workspace {
        Workspace {
            document: None,
            scene_number: 0,
            preferences,
            configuration: Arc::default(),
            messages: Vec::new(),
            loading: None,
            screen: None,
            report: None,
            order: 0,
            refusal: None,
            capabilities: None,
            adapter: None,
            plan: None,
            planned: None,
            arranged: None,
            viewport: Viewport::default(),
            pivot: None,
            picked: None,
            functions: Functions::default(),
            counts: None,
            shaders: Arc::default(),
            compare: None,
            accuracy: Accuracy::default(),
            hover: None,
            measure: Measure::default(),
            exporting: None,
            models: None,
            settings_before_case: None,
            layout: Layout::default(),
            asks: Vec::new(),
        }
    }

    /// Says something; what is said already is not repeated.
    pub fn say(&mut self, gravity: Gravity, text: impl Into<String>) {
        let message = Message { gravity, text: text.into() };
        if self.messages.last() != Some(&message) {
            match gravity {
                Gravity::Error => tracing::error!("{}", message.text),
                Gravity::Note | Gravity::Notice => tracing::info!("{}", message.text),
            }
            self.messages.push(message);
        }
        // Old ones give way.
        if self.messages.len() > 8 {
            self.messages.remove(0);
        }
    }

    /// Shows another model: as its session says, or as first seen, with the settings that are there.
    pub fn open(&mut self, file: String, opened: Opened) {
        let Opened { scene, session, case, import } = opened;
        let replaces = self.document.is_some();
        let present = self.document.take().map_or_else(|| self.configuration.settings(), |d| d.seen.settings);
        let settings = self.settings_before_case.take().unwrap_or(present);
        if case.is_some() {
            self.settings_before_case = Some(settings.clone());
        }
        let aspect = self.viewport.frame().aspect();
        let remembered = file.clone();
        let (file, seen) = match session {
            Some(s) => {
                let camera = camera_in_scene(&s.camera, &scene);
                (s.file, Seen { settings: s.settings, camera, arrangement: s.arrangement })
            }
            None => {
                let camera = camera::first(&scene.bounds(), aspect);
                (file, Seen { settings, camera, arrangement: Arrangement::default() })
            }
        };
        self.end_case();
        self.forget_accuracy();
        // What was wrong with another one is over; what was wrong before any is not.
        match replaces {
            true => self.messages.clear(),
            false => self.messages.retain(|m| m.gravity == Gravity::Error),
        }
        let notices: Vec<String> = scene.notices.iter().map(|n| format!("{}: {}", n.kind.name(), n.message)).collect();
        if !notices.is_empty() {
            self.say(Gravity::Notice, notices.join("\n"));
        }
        match case {
            Some(case) => {
                self.say(Gravity::Note, format!("{}: {}", case.name, case.why));
                self.show_case(case);
                if let Some(Err(reason)) = self.accuracy.case.as_ref().map(|c| c.contrast.clone()) {
                    self.say(Gravity::Note, reason);
                }
            }
            None => {
                self.preferences.remember(&remembered);
                self.asks.push(Ask::Remember);
            }
        }
        let mut document = Document::new(file, Arc::new(scene), seen);
        document.import = import;
        self.document = Some(document);
        self.scene_number += 1;
        tracing::debug!("opened {remembered}");
        self.screen = None;
        self.report = None;
        self.refusal = None;
        self.pivot = None;
        self.picked = None;
        self.hover = None;
        self.measure.ends.clear();
        self.layout.stack = None;
        self.layout.naming = None;
        self.layout.planes = planes::State::default();
    }

    /// Everything seen, as a file that `pellucid render --session` draws.
    ///
    /// # Errors
    /// A sentence if it cannot be written down.
    pub fn session(&self, folder: &std::path::Path) -> Result<String, String> {
        let document = self.document.as_ref().ok_or("there is no model")?;
        let seen = &document.seen;
        if document.file.starts_with(HARD_CASE) {
            return Err(MADE_IN_MEMORY.to_owned());
        }
        let session = Session {
            file: document.file.clone(),
            size: self.viewport.size,
            camera: camera_in_file(&seen.camera, &document.scene),
            settings: seen.settings.clone(),
            arrangement: seen.arrangement.clone(),
            import: document.import.clone(),
        };
        session.for_folder(folder).and_then(|s| s.to_toml(&document.scene)).map_err(|e| e.to_string())
    }

    /// Takes a picture onto the screen.
    pub fn show(&mut self, picture: Picture) {
        if picture.scene_number != self.scene_number {
            return;
        }
        self.capabilities.get_or_insert_with(|| picture.report.adapter.capabilities.clone());
        self.adapter.get_or_insert_with(|| picture.report.adapter.name.clone());
        // Another model begins another count.
        let serial = self.screen.as_ref().map_or(0, |s| s.shown.serial) + 1 + (self.scene_number << 32);
        let Picture { number, kind, size, milliseconds, viewport, .. } = picture;
        let linear = picture.linear.clone();
        let view = (picture.seen.camera, viewport);
        let look = (picture.seen.settings.clone(), picture.seen.arrangement.clone());
        let exact = (kind == Kind::Exact).then(|| (picture.seen.clone(), picture.report.clone()));
        if exact.is_some() {
            self.report = exact;
            self.refusal = None;
        }
        let shown = Arc::new(shown_of(serial, picture));
        self.screen = Some(OnScreen { shown, number, kind, view, look, size, linear, milliseconds });
    }

    /// Whether what is on screen is the exact picture of what is to be seen.
    pub fn is_exact(&self) -> bool {
        self.screen.as_ref().is_some_and(|s| s.kind == Kind::Exact && s.number == self.order)
    }

    /// The transfer functions of what is seen, or why there are none; `None` without a model.
    pub fn transfer(&mut self) -> Option<Resolved> {
        let source = &self.document.as_ref()?.seen.settings.opacity.transfer;
        let resolved = self.functions.of(source);
        for notice in self.functions.notices() {
            self.say(Gravity::Notice, notice);
        }
        Some(resolved)
    }

    /// What pictures depend on beside what is seen.
    pub fn extras(&mut self) -> Extras {
        let transfer = self.transfer().and_then(Result::ok);
        Extras {
            transfer,
            against: self.against(),
            counts: self.preferences.editors,
            shaders: Arc::clone(&self.shaders),
        }
    }

    /// What is seen, with the transfer functions as they are used: their file may have changed or be broken since.
    pub fn resolved(&self, seen: &Seen) -> Seen {
        let mut seen = seen.clone();
        if let Some(function) = self.functions.known(&seen.settings.opacity.transfer) {
            seen.settings.opacity.transfer = TransferSource::Inline(Box::new((*function).clone()));
        }
        seen
    }

    /// Takes the exact picture of the settings that are compared with.
    pub fn show_compared(&mut self, picture: Picture) {
        let number = self.scene_number;
        if let Some(compare) = self.compare.as_mut().filter(|_| picture.scene_number == number)
            && compare.kept.settings == picture.seen.settings
        {
            let view = (picture.seen.camera, picture.viewport);
            let serial = picture.number + (number << 32);
            compare.shown = Some(PictureOfA { view, shown: Arc::new(shown_of(serial, picture)) });
        }
    }

    /// Takes over a file that somebody has edited, or says what is wrong with it.
    pub fn take_changed(&mut self, change: Changed) {
        match change {
            Changed::Function(name, read) => match self.functions.reload(&name, read) {
                // The command line has those with a bare name as they were when it was built.
                Ok(()) if !name.contains(['/', '\\', '.']) => self.say(
                    Gravity::Notice,
                    format!(
                        "{name} is as in transfer_functions/{name}.toml now. `pellucid render` shows it so when it is built \
                         anew, or with --transfer transfer_functions/{name}.toml."
                    ),
                ),
                Ok(()) => self.say(Gravity::Note, format!("{name} has been read again.")),
                Err(reason) => self.say(Gravity::Error, reason),
            },
            Changed::Shaders(texts) => {
                let what = match texts.len() {
                    0 => "The program's own shaders are used again.".to_owned(),
                    n => format!("Shaders have been read again: {n} differ from the program's."),
                };
                self.say(Gravity::Note, what);
                self.shaders = texts;
            }
            Changed::BrokenShader(reason) => self.say(Gravity::Error, reason),
            Changed::Fault(reason) => self.say(Gravity::Notice, reason),
        }
    }

    /// Plans anew if what a plan depends on has changed.
    pub fn replan(&mut self) {
        let transfer = self.transfer();
        let (Some(document), Some(capabilities)) = (&self.document, &self.capabilities) else {
            self.plan = None;
            self.planned = None;
            return;
        };
        let view = ViewStats::of(&document.seen.camera);
        let resolved = transfer.as_ref().and_then(|t| t.as_ref().ok()).cloned();
        let same = |planned: &Planned| {
            (planned.scene_number, planned.size) == (self.scene_number, self.viewport.size)
                && planned.transfer == resolved
                && planned.seen == document.seen
        };
        if self.planned.as_ref().is_some_and(same) || self.viewport.size.contains(&0) {
            return;
        }
        // While a plane is dragged the plan waits for the hand to stop: its caps are filled for the picture as it is.
        let cut = document.seen.arrangement.sections.iter().any(|s| s.enabled && s.caps);
        if cut && document.in_gesture() && self.planned.as_ref().is_some_and(|p| p.scene_number == self.scene_number) {
            return;
        }
        let number = self.scene_number;
        let counts = match &mut self.arranged {
            Some(counts) if counts.scene_number == number => counts,
            other => other.insert(Counts { scene_number: number, solids: Solids::of(&document.scene), of: None }),
        };
        let stats = counts.of(&document.scene, &document.seen.arrangement);
        let settings = &document.seen.settings;
        let planned = match transfer {
            Some(Ok(transfer)) => plan::plan(settings, &transfer, &stats, &view, capabilities, self.viewport.size)
                .map_err(|refusal| refusal.to_string()),
            Some(Err(reason)) => Err(reason),
            None => return,
        };
        self.plan = Some(planned);
        self.planned = Some(Planned {
            scene_number: self.scene_number,
            seen: document.seen.clone(),
            transfer: resolved,
            size: self.viewport.size,
        });
    }

    /// Makes a step of what has changed, unless the hand is still at it.
    pub fn settle(&mut self, busy: bool) {
        #[cfg(test)]
        let busy = busy || super::planted::is(super::planted::Fault::Unsettled);
        if let Some(document) = self.document.as_mut().filter(|_| !busy) {
            document.settle();
        }
    }

    /// One step back.
    pub fn undo(&mut self) {
        let done = self.document.as_mut().is_some_and(Document::undo);
        tracing::debug!("{}", if done { "undone" } else { "nothing to undo" });
    }

    /// One step forward.
    pub fn redo(&mut self) {
        let done = self.document.as_mut().is_some_and(Document::redo);
        tracing::debug!("{}", if done { "redone" } else { "nothing to redo" });
    }

    /// Changes the camera as one step.
    pub fn look(&mut self, change: impl FnOnce(&camera::Frame, &Scene, &Camera) -> Option<Camera>) {
        let frame = self.viewport.frame();
        if let Some(document) = &mut self.document
            && let Some(camera) = change(&frame, &document.scene, &document.seen.camera)
        {
            document.settle();
            document.seen.camera = camera;
            document.settle();
        }
    }
}

/// A picture as the viewport takes it.
fn shown_of(serial: u64, picture: Picture) -> Shown {
    let srgb = |v: f32| crate::math::color::srgb_from_linear(f64::from(v)) as f32;
    Shown { serial, size: picture.size, rgba: picture.rgba, background: picture.background.map(|rgb| rgb.map(srgb)) }
}
