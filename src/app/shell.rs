//! The loop: winit's events in, frames out, and everything that panels only ask for.
//!
//! A frame is drawn when the window system, egui, or a thread has something to show, and at no other time. Movements of the
//! mouse go straight to the camera and from there to the threads that draw, before any frame.

mod mouse;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use glam::DVec2;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use super::AppError;
use super::config::{self, Preferences};
use super::dialogs::{self, Chosen};
use super::keys;
use super::loader::{Loading, Phase};
use super::panels::{self, style};
use super::pictures::{Delivery, Kind, Pictures, supersedes};
use super::surface::{Drawn, Surface};
use super::watch::{Watch, Workshop};
use super::workspace::{Ask, Gravity, LoadingView, Workspace};
use mouse::Drag;

/// Turning the wheel is one gesture until it rests so long.
const WHEEL_RESTS: Duration = Duration::from_millis(300);
/// Most that frames that follow the mouse are held back.
const LONGEST_REST: Duration = Duration::from_millis(40);
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
pub fn run(files: &[String]) -> Result<(), AppError> {
    let event_loop = EventLoop::<Event>::with_user_event().build().map_err(|e| AppError::Display(reason(&e)))?;
    let mut shell = Shell::new(event_loop.create_proxy(), files);
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

struct Shell {
    proxy: EventLoopProxy<Event>,
    context: egui::Context,
    open: Option<Open>,
    workspace: Workspace,
    pictures: Option<Pictures>,
    watch: Option<Watch>,
    loading: Option<Loading>,
    first_file: Option<String>,
    held: ModifiersState,
    cursor: DVec2,
    drag: Option<Drag>,
    wheel_at: Option<Instant>,
    repaint_at: Option<Instant>,
    /// Frames that only follow the mouse take half of the time at most: on a software rasterizer they are drawn by the same
    /// processor as the pictures.
    rest_until: Instant,
    reopened: u32,
    frames: u64,
    /// Inputs that no frame answers yet, and those of which no picture is drawn yet: of which order, and when they came.
    inputs: VecDeque<(u64, Instant)>,
    undrawn: VecDeque<(u64, Instant)>,
    /// When the event at hand came.
    now: Instant,
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
        Shell {
            proxy,
            context,
            open: None,
            workspace,
            pictures: None,
            watch: None,
            loading: None,
            first_file: files.first().cloned(),
            held: ModifiersState::empty(),
            cursor: DVec2::ZERO,
            drag: None,
            wheel_at: None,
            repaint_at: None,
            rest_until: Instant::now(),
            reopened: 0,
            frames: 0,
            inputs: VecDeque::new(),
            undrawn: VecDeque::new(),
            now: Instant::now(),
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
            .with_visible(false);
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
        self.loading = Some(Loading::begin(file, self.waker()));
        self.redraw();
    }

    /// Takes what threads have delivered; says whether anything is to be shown.
    fn collect(&mut self) -> bool {
        let mut changed = false;
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
                        self.drag = None;
                        let name = self.workspace.document.as_ref().map_or("", |d| &d.file);
                        if let Some(open) = &self.open {
                            open.window.set_title(&format!("{name} – Pellucid"));
                        }
                    }
                    Err(reason) => self.workspace.say(Gravity::Error, reason),
                }
            }
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
            tracing::debug!("order {number}, viewport {:?}", self.workspace.viewport);
            self.workspace.refusal = None;
            self.inputs.push_back((number, self.now));
            self.undrawn.push_back((number, self.now));
        }
    }

    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let begin = Instant::now();
        self.workspace.loading = self.loading.as_ref().map(|l| {
            let (doing, share) = match l.phase() {
                Phase::Reading(share) => ("Reading", Some(share)),
                Phase::Building => ("Building", None),
            };
            LoadingView { file: l.file.clone(), doing, share }
        });
        let Some(open) = &mut self.open else {
            return;
        };
        let size = open.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return;
        }
        let input = open.egui.take_egui_input(&open.window);
        let workspace = &mut self.workspace;
        let output = self.context.run_ui(input, |ui| panels::show(ui, workspace));
        open.egui.handle_platform_output_with_event_loop(&open.window, event_loop, output.platform_output);
        let wheel = self.wheel_at.is_some_and(|at| at.elapsed() < WHEEL_RESTS);
        let held = self.context.input(|i| i.pointer.any_down());
        if let Some(document) = &mut self.workspace.document
            && !held
            && !wheel
        {
            document.settle();
        }
        self.order();
        let waker = self.waker();
        let watch = self.watch.get_or_insert_with(|| Watch::start(workshop(), waker));
        watch.follow(self.workspace.document.as_ref().map(|d| &d.seen.settings.opacity.transfer));
        let Some(open) = &mut self.open else {
            return;
        };
        let laid_out = begin.elapsed();
        let shapes = self.context.tessellate(output.shapes, output.pixels_per_point);
        let trace = tracing::enabled!(tracing::Level::DEBUG);
        let drawn = open.surface.draw(&shapes, output.textures_delta, output.pixels_per_point, trace);
        if let Some(complaint) = open.surface.complaint() {
            self.workspace.say(Gravity::Error, format!("The window's graphics device reports: {complaint}"));
        }
        self.frames += 1;
        self.rest_until = Instant::now() + begin.elapsed().min(LONGEST_REST);
        tracing::debug!(
            "frame {} in {:.1} ms, {:.1} of it layout",
            self.frames,
            begin.elapsed().as_secs_f64() * 1e3,
            laid_out.as_secs_f64() * 1e3
        );
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        match drawn {
            Drawn::Presented => {
                self.reopened = 0;
                self.note_latency();
            }
            Drawn::Skipped => {}
            Drawn::Again => open.window.request_redraw(),
            Drawn::Lost => self.reopen(event_loop),
        }
        let asked = Instant::now().checked_add(delay).filter(|_| delay < Duration::from_secs(3600));
        // A frame at the end of turning the wheel makes a step of it.
        let rested = self.wheel_at.map(|at| at + WHEEL_RESTS).filter(|at| *at > Instant::now());
        self.repaint_at = [asked, rested].into_iter().flatten().min();
        self.fulfil(event_loop);
    }

    /// Logs how long inputs waited for the frame that has just been drawn.
    fn note_latency(&mut self) {
        let Some(screen) = &self.workspace.screen else {
            return;
        };
        let ms = |came: Instant| came.elapsed().as_secs_f64() * 1e3;
        // The picture is moved along with the camera, so the frame answers whatever only moves that.
        let settings =
            |d: &super::document::Document| d.seen.settings == screen.look.0 && d.seen.arrangement == screen.look.1;
        let follows = self.workspace.document.as_ref().is_some_and(settings);
        let up_to = if follows { self.workspace.order } else { screen.number };
        while let Some(&(number, came)) = self.inputs.front()
            && number <= up_to
        {
            self.inputs.pop_front();
            let how = if number <= screen.number { screen.kind.name() } else { "moved" };
            tracing::debug!("answered in {:.1} ms, input {number}, {how}", ms(came));
        }
        while let Some(&(number, came)) = self.undrawn.front()
            && number <= screen.number
        {
            self.undrawn.pop_front();
            tracing::debug!("drawn in {:.1} ms, input {number}, {} {}", ms(came), screen.kind.name(), screen.number);
        }
    }

    /// Makes the window's device anew. What egui has drawn into textures is drawn again when their greatest size changes.
    fn reopen(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = self.open.take() else {
            return;
        };
        self.reopened += 1;
        let Open { window, mut egui, surface } = open;
        drop(surface);
        if self.reopened > MOST_REOPENED {
            self.failure = Some(AppError::Display("the graphics device is lost again and again".to_owned()));
            event_loop.exit();
            return;
        }
        match Surface::new(event_loop, Arc::clone(&window)) {
            Ok(surface) => {
                egui.set_max_texture_side((surface.largest() - self.reopened) as usize);
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

    /// Does what panels and keys have asked for.
    fn fulfil(&mut self, event_loop: &ActiveEventLoop) {
        let asks = std::mem::take(&mut self.workspace.asks);
        let redraw = !asks.is_empty();
        for ask in asks {
            match ask {
                Ask::Open(file) => self.load(&file),
                Ask::CancelLoading => self.loading = None,
                Ask::Copy(text) => self.context.copy_text(text),
                Ask::Remember => {
                    if let Some(path) = config::path()
                        && let Err(reason) = self.workspace.preferences.write(&path)
                    {
                        self.workspace.say(Gravity::Error, format!("The preferences cannot be written: {reason}"));
                    }
                }
                Ask::Quit => self.quit = true,
                Ask::Choose(choice) => {
                    let proxy = self.proxy.clone();
                    let window = self.open.as_ref().map(|o| Arc::clone(&o.window));
                    let file = self.workspace.document.as_ref().map(|d| d.file.clone());
                    dialogs::choose(choice, window.as_deref(), file.as_deref(), move |chosen| {
                        let _ = proxy.send_event(Event::Chosen(chosen));
                    });
                }
                Ask::Use(choice, path) => dialogs::fulfil(&mut self.workspace, choice, &path),
            }
        }
        if self.quit {
            event_loop.exit();
        } else if redraw {
            self.redraw();
        }
    }

    fn key(&mut self, event: &KeyEvent) -> bool {
        let typing = self.context.text_edit_focused();
        event.state == ElementState::Pressed && keys::press(&mut self.workspace, event, self.held, typing)
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
                self.held = held.state();
                redraw = false;
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.cursor = DVec2::new(position.x, position.y);
                self.moved();
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } => self.pressed(button),
            WindowEvent::MouseInput { state: ElementState::Released, button, .. } => self.released(button),
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
                if let Some(drag) = &self.drag {
                    let button = drag.button;
                    self.released(button);
                }
            }
            _ => {}
        }
        if redraw && follows && Instant::now() < self.rest_until {
            self.repaint_at = Some(self.repaint_at.map_or(self.rest_until, |at| at.min(self.rest_until)));
        } else if redraw {
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.repaint_at.is_some_and(|at| at <= Instant::now()) {
            self.repaint_at = None;
            self.redraw();
        }
        event_loop.set_control_flow(self.repaint_at.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The clipboard and the surface need a window that is still there.
        self.pictures = None;
        self.open = None;
    }
}
