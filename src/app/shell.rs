//! The loop: winit's events in, frames out, and everything that panels only ask for.
//!
//! A frame is drawn when the window system, egui, or a thread has something to show, and at no other time. Movements of the
//! mouse go straight to the camera and from there to the threads that draw, before any frame.

mod accuracy;
mod asks;
mod frames;
mod latency;
mod places;
mod turns;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use glam::DVec2;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::AppError;
use super::config::{self, Preferences};
use super::dialogs::{self, Choice, Chosen, Prompt};
use super::exports::Exporting;
use super::hand::Hand;
use super::loader::Loading;
use super::models;
use super::panels::style;
use super::pictures::{Delivery, Kind, Pictures, supersedes};
use super::surface::Surface;
use super::watch::{Watch, Workshop};
use super::workspace::{Gravity, Workspace};
use crate::session::configuration::Configuration;

/// Most that frames that follow the mouse are held back.
const LONGEST_REST: Duration = Duration::from_millis(40);
/// Events between two looks of egui at them whose times are kept.
const MOST_UNSEEN: usize = 256;
/// Devices that are opened again in a row before giving up.
const MOST_REOPENED: u32 = 5;

/// What reaches the loop from elsewhere.
#[derive(Debug)]
pub enum Event {
    /// A thread has something.
    Wake,
    /// A dialog was answered.
    Chosen(Chosen),
    /// From assistive technology.
    Accesskit(egui_winit::accesskit_winit::Event),
}

impl From<egui_winit::accesskit_winit::Event> for Event {
    fn from(event: egui_winit::accesskit_winit::Event) -> Event {
        Event::Accesskit(event)
    }
}

/// Opens the window, with the first of these files in it, and returns when it is closed.
///
/// # Errors
/// [`AppError::Display`] if there is no display or nothing can draw on it.
pub fn run(files: &[String], configuration: Configuration) -> Result<(), AppError> {
    let event_loop = EventLoop::<Event>::with_user_event().build().map_err(|e| AppError::Display(reason(&e)))?;
    let mut shell = Shell::new(event_loop.create_proxy(), files);
    shell.workspace.configuration = Arc::new(configuration);
    event_loop.run_app(&mut shell).map_err(|e| AppError::Display(e.to_string()))?;
    shell.failure.map_or(Ok(()), Err)
}

/// Where files are worked on.
fn workshop() -> Workshop {
    let shaders = std::env::var_os("PELLUCID_SHADERS").map(std::path::PathBuf::from);
    std::env::current_dir().map(|here| Workshop::find(&here, shaders)).unwrap_or_default()
}

/// What an error of winit says, without the place in winit's source that it begins with.
fn reason(error: &winit::error::EventLoopError) -> String {
    let text = error.to_string();
    match text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")) {
        Some((_, rest)) if text.starts_with("os error at") => rest.to_owned(),
        _ => text,
    }
}

/// The window itself.
struct Open {
    window: Arc<Window>,
    egui: egui_winit::State,
    surface: Surface,
}

/// What stands for the program in lists of windows: the gearbox, drawn by itself (`scripts/icon`).
fn icon() -> Option<winit::window::Icon> {
    let image = image::load_from_memory(include_bytes!("../../assets/desktop/pellucid.png")).ok()?.into_rgba8();
    let (width, height) = image.dimensions();
    winit::window::Icon::from_rgba(image.into_raw(), width, height).ok()
}

/// The name by which a desktop finds the icon and the `.desktop` file.
#[cfg(target_os = "linux")]
fn named(attributes: winit::window::WindowAttributes) -> winit::window::WindowAttributes {
    use winit::platform::{wayland, x11};
    let attributes = wayland::WindowAttributesExtWayland::with_name(attributes, "pellucid", "");
    x11::WindowAttributesExtX11::with_name(attributes, "pellucid", "Pellucid")
}

/// When the next preview is let go.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Release {
    /// There is no reason to.
    None,
    /// When the events have been dealt with that came during the last frame.
    Soon,
    /// Now.
    Now,
}

struct Shell {
    proxy: EventLoopProxy<Event>,
    context: egui::Context,
    open: Option<Open>,
    workspace: Workspace,
    pictures: Option<Pictures>,
    watch: Option<Watch>,
    loading: Option<Loading>,
    first_file: Option<String>,
    exporting: Option<Exporting>,
    models: Option<models::Drawing>,
    accuracy: accuracy::Threads,
    hand: Hand,
    /// The order and the pixel for which layers beside the cursor were asked for last.
    hovered: Option<(u64, [u32; 2])>,
    repaint_at: Option<Instant>,
    /// Frames that only follow the mouse take half of the time at most: on a software rasterizer they are drawn by the same
    /// processor as the pictures.
    rest_until: Instant,
    /// Devices that were lost since the last frame that could be drawn, and in all.
    reopened: u32,
    losses: u32,
    frames: u64,
    /// Changes of egui's textures that no frame has drawn with yet.
    textures: egui::TexturesDelta,
    /// Events have come that egui has not seen, and when each came.
    unseen: Vec<Instant>,
    /// The next preview may begin, in this turn of the loop or the one after.
    release: Release,
    /// What frames with another picture take, milliseconds, smoothed.
    frame_time: f64,
    /// The last preview that a frame has shown.
    turned: Option<u64>,
    /// Inputs that no frame answers yet, and those of which no picture is drawn yet: of which order, and when they came.
    inputs: VecDeque<(u64, Instant)>,
    undrawn: VecDeque<(u64, Instant)>,
    /// The last of them, until its exact picture is there.
    last_input: Option<(u64, Instant)>,
    /// When the event at hand came.
    now: Instant,
    places: places::Places,
    failure: Option<AppError>,
    quit: bool,
}

impl Shell {
    fn new(proxy: EventLoopProxy<Event>, files: &[String]) -> Shell {
        let read = config::path().map_or_else(|| Ok(Preferences::default()), |p| Preferences::read(&p));
        let mut workspace = Workspace::new(read.as_ref().cloned().unwrap_or_default());
        if let Err(reason) = read {
            workspace.say(Gravity::Error, format!("The preferences cannot be read: {reason}"));
        }
        for other in files.iter().skip(1).rev() {
            workspace.preferences.remember(other);
        }
        if files.len() > 1 {
            workspace.say(Gravity::Note, "One model is shown at a time; the others are under Open recent.");
        }
        let context = egui::Context::default();
        style::set_up(&context);
        style::apply(&context, &workspace.preferences);
        if places::wanted() {
            context.enable_accesskit();
        }
        Shell {
            proxy,
            context,
            open: None,
            workspace,
            pictures: None,
            watch: None,
            loading: None,
            first_file: files.first().cloned(),
            exporting: None,
            models: None,
            accuracy: accuracy::Threads::default(),
            hand: Hand::default(),
            hovered: None,
            repaint_at: None,
            rest_until: Instant::now(),
            reopened: 0,
            losses: 0,
            frames: 0,
            textures: egui::TexturesDelta::default(),
            unseen: Vec::new(),
            release: Release::None,
            frame_time: 0.0,
            turned: None,
            inputs: VecDeque::new(),
            undrawn: VecDeque::new(),
            last_input: None,
            now: Instant::now(),
            places: places::Places::default(),
            failure: None,
            quit: false,
        }
    }

    /// Something that a thread calls to be heard.
    fn waker(&self) -> impl Fn() + Send + Sync + Clone + 'static {
        let proxy = self.proxy.clone();
        move || {
            // The loop is gone only when the window is.
            let _ = proxy.send_event(Event::Wake);
        }
    }

    fn open_window(&mut self, event_loop: &ActiveEventLoop) -> Result<(), AppError> {
        let attributes = Window::default_attributes()
            .with_title("Pellucid")
            .with_inner_size(winit::dpi::LogicalSize::new(1280.0, 800.0))
            .with_min_inner_size(winit::dpi::LogicalSize::new(320.0, 240.0))
            .with_window_icon(icon())
            .with_visible(false);
        #[cfg(target_os = "linux")]
        let attributes = named(attributes);
        let window = Arc::new(event_loop.create_window(attributes).map_err(|e| AppError::Display(e.to_string()))?);
        let surface = Surface::new(event_loop, Arc::clone(&window))?;
        let mut egui = egui_winit::State::new(
            self.context.clone(),
            ViewportId::ROOT,
            event_loop,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(surface.largest() as usize),
        );
        egui.init_accesskit(event_loop, &window, self.proxy.clone());
        window.set_visible(true);
        window.request_redraw();
        self.open = Some(Open { window, egui, surface });
        Ok(())
    }

    fn redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    fn load(&mut self, file: &str) {
        self.loading = Some(Loading::begin(file, &self.workspace.configuration.import_options(), self.waker()));
        self.redraw();
    }

    /// Takes what threads have delivered; says whether anything is to be shown.
    fn collect(&mut self) -> bool {
        let mut changed = self.collect_export() | self.collect_models() | self.collect_accuracy();
        if let Some(loading) = &self.loading {
            changed = true;
            if let Some(result) = loading.take() {
                let file = loading.file.clone();
                self.loading = None;
                match result {
                    Ok(opened) => {
                        self.workspace.open(file, opened);
                        self.inputs.clear();
                        self.undrawn.clear();
                        self.hand.let_go();
                        let name = self.workspace.document.as_ref().map_or("", |d| &d.file);
                        if let Some(open) = &self.open {
                            open.window.set_title(&format!("{name} – Pellucid"));
                        }
                    }
                    Err(reason) => {
                        self.workspace.say(Gravity::Error, reason);
                        // Whoever typed it mends it rather than types it again.
                        if self.workspace.layout.typed.take().is_some_and(|typed| typed == file) {
                            self.workspace.layout.prompt = Some(Prompt::new(Choice::Open, &file));
                        }
                    }
                }
            }
        }
        if let Some(pictures) = &mut self.pictures {
            pictures.draws_ahead = self.workspace.accuracy.underway.is_none();
        }
        let deliveries = self.pictures.as_mut().map(Pictures::take).unwrap_or_default();
        for delivery in deliveries {
            match delivery {
                Delivery::Picture(picture) => {
                    let shown = self.workspace.screen.as_ref().map(|s| (s.number, s.kind));
                    if picture.scene_number == self.workspace.scene_number
                        && supersedes((picture.number, picture.kind), shown)
                    {
                        self.workspace.show(*picture);
                        changed = true;
                    }
                }
                Delivery::Fault(fault) if fault.number == self.workspace.order && fault.kind == Kind::Exact => {
                    self.workspace.refusal = Some(fault.message);
                    changed = true;
                }
                Delivery::Picked(picked) => {
                    self.workspace.take_picked(picked);
                    changed = true;
                }
                Delivery::Compared(picture) => {
                    self.workspace.show_compared(*picture);
                    changed = true;
                }
                Delivery::Counts(counted) => {
                    if self.workspace.counts.as_ref().is_none_or(|c| counted.supersedes(c)) {
                        self.workspace.counts = Some(*counted);
                    }
                    changed = true;
                }
                Delivery::Said(text) => {
                    self.workspace.say(Gravity::Error, text);
                    changed = true;
                }
                // The exact picture has the same fault, and says so; an older one is of no interest.
                Delivery::Fault(fault) => tracing::debug!("{}: {}", fault.kind.name(), fault.message),
            }
        }
        for change in self.watch.as_ref().map(Watch::take).unwrap_or_default() {
            self.workspace.take_changed(change);
            changed = true;
        }
        self.follow_accuracy();
        changed
    }

    /// Asks for the picture of what is to be seen now.
    fn order(&mut self) {
        let extras = self.workspace.extras();
        let Some(document) = &self.workspace.document else {
            if let Some(pictures) = &mut self.pictures {
                pictures.clear();
            }
            return;
        };
        if self.workspace.viewport.size.contains(&0) {
            return;
        }
        let waker = self.waker();
        let pictures = self.pictures.get_or_insert_with(|| Pictures::start(waker));
        let number = pictures.ask(
            &document.scene,
            self.workspace.scene_number,
            &document.seen,
            extras,
            self.workspace.viewport.size,
        );
        if number != self.workspace.order {
            self.workspace.order = number;
            // It is of another view.
            self.workspace.hover = None;
            pictures.stop_hovering();
            tracing::debug!("order {number}, viewport {:?}", self.workspace.viewport);
            self.workspace.refusal = None;
            // What was moved by events that egui has seen since is asked for at once; all of them have waited.
            let mut came = std::mem::take(&mut self.unseen);
            if came.is_empty() {
                came.push(self.now);
            }
            self.inputs.extend(came.iter().map(|&at| (number, at)));
            self.undrawn.extend(came.iter().map(|&at| (number, at)));
            self.last_input = came.last().map(|&at| (number, at));
        }
        self.follow_accuracy();
    }

    /// Makes the window's device anew. Egui draws its letters into textures again when their greatest size changes, which it
    /// therefore does by one to and fro; the editors paint their thumbnails and the map again.
    fn reopen(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = self.open.take() else {
            return;
        };
        self.reopened += 1;
        self.losses += 1;
        let Open { window, mut egui, surface } = open;
        drop(surface);
        if self.reopened > MOST_REOPENED {
            self.failure = Some(AppError::Display("the graphics device is lost again and again".to_owned()));
            event_loop.exit();
            return;
        }
        match Surface::new(event_loop, Arc::clone(&window)) {
            Ok(surface) => {
                egui.set_max_texture_side((surface.largest() - self.losses % 2) as usize);
                self.workspace.layout.editors.forget_textures();
                self.workspace.models.iter_mut().for_each(models::Models::forget_textures);
                self.workspace.say(Gravity::Notice, "The graphics device was lost and has been opened again.");
                window.request_redraw();
                self.open = Some(Open { window, egui, surface });
            }
            Err(e) => {
                self.failure = Some(e);
                event_loop.exit();
            }
        }
    }
}

impl ApplicationHandler<Event> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        if let Err(e) = self.open_window(event_loop) {
            self.failure = Some(e);
            event_loop.exit();
        } else if let Some(file) = self.first_file.take() {
            self.load(&file);
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        self.now = Instant::now();
        match event {
            Event::Wake => {
                if self.collect() {
                    self.redraw();
                } else {
                    // Nothing of it will be shown.
                    self.release = Release::Soon;
                }
            }
            Event::Chosen(chosen) => {
                dialogs::answered(&mut self.workspace, chosen);
                self.fulfil(event_loop);
                self.redraw();
            }
            Event::Accesskit(event) => {
                use egui_winit::accesskit_winit::WindowEvent as Asked;
                if let Some(open) = &mut self.open {
                    match event.window_event {
                        Asked::InitialTreeRequested => self.context.enable_accesskit(),
                        Asked::ActionRequested(request) => open.egui.on_accesskit_action_request(request),
                        Asked::AccessibilityDeactivated => self.context.disable_accesskit(),
                    }
                    open.window.request_redraw();
                }
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        self.now = Instant::now();
        let is_input = matches!(
            event,
            WindowEvent::CursorMoved { .. }
                | WindowEvent::MouseInput { .. }
                | WindowEvent::MouseWheel { .. }
                | WindowEvent::KeyboardInput { .. }
        );
        if is_input && self.unseen.len() < MOST_UNSEEN {
            self.unseen.push(self.now);
        }
        let Some(open) = &mut self.open else {
            return;
        };
        let response = open.egui.on_window_event(&open.window, &event);
        let mut redraw = response.repaint;
        let follows = matches!(event, WindowEvent::CursorMoved { .. } | WindowEvent::MouseWheel { .. });
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                self.frame(event_loop);
                redraw = false;
            }
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } | WindowEvent::Occluded(false) => {
                redraw = true;
            }
            WindowEvent::ModifiersChanged(held) => {
                self.hold(held.state());
                redraw = false;
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.hand.cursor = DVec2::new(position.x, position.y);
                let over = self.over_picture();
                if self.hand.moved(&mut self.workspace, self.hand.cursor, over) {
                    self.order();
                }
                self.fulfil(event_loop);
            }
            WindowEvent::CursorLeft { .. } => {
                self.hand.moved(&mut self.workspace, self.hand.cursor, false);
                self.fulfil(event_loop);
            }
            WindowEvent::MouseInput { state, button, .. } => {
                if let Some(button) = asks::known(button) {
                    if state == ElementState::Pressed {
                        let over = self.over_picture();
                        self.hand.pressed(&mut self.workspace, button, over);
                    } else {
                        self.hand.released(&mut self.workspace, button);
                    }
                    self.fulfil(event_loop);
                    redraw = true;
                }
            }
            WindowEvent::MouseWheel { delta, .. } if self.over_picture() => {
                self.wheel(delta);
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if self.key(&event) => {
                self.fulfil(event_loop);
                redraw = true;
            }
            WindowEvent::DroppedFile(path) => self.load(&path.to_string_lossy()),
            WindowEvent::Focused(false) => {
                // A button let go elsewhere is not heard of.
                self.hand.let_go();
                if let Some(document) = &mut self.workspace.document {
                    document.end_gesture();
                }
            }
            _ => {}
        }
        let rest_until = if follows { self.rests_until() } else { self.now };
        if redraw && Instant::now() < rest_until {
            self.repaint_at = Some(self.repaint_at.map_or(rest_until, |at| at.min(rest_until)));
        } else if redraw {
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let polls = self.take_turns(event_loop);
        if let Some(at) = self.repaint_at
            && at <= Instant::now()
        {
            let rests_until = self.rests_until();
            self.repaint_at = (self.waits_for_preview() && Instant::now() < rests_until).then_some(rests_until);
            if self.repaint_at.is_none() {
                self.redraw();
            }
        }
        let next = [self.repaint_at, self.hover()].into_iter().flatten().min();
        let waits = next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil);
        event_loop.set_control_flow(if polls { ControlFlow::Poll } else { waits });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The clipboard and the surface need a window that is still there.
        self.textures.clear();
        self.pictures = None;
        self.accuracy = accuracy::Threads::default();
        self.open = None;
    }
}
