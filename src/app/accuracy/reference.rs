//! A thread with a device of its own that draws the reference of the exact picture on screen, and compares the two.
//!
//! It keeps only the newest job and gives up, between passes, the one at work when another picture is wanted. The reference is
//! that of `pellucid tradeoff` for the same settings, view and size.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::Referenced;
use crate::app::document::Seen;
use crate::app::viewport::Shown;
use crate::app::watch::ShaderTexts;
use crate::app::workspace::Workspace;
use crate::export::image::parse_background;
use crate::export::png::rgba8;
use crate::gpu::{Gpu, GpuError, GpuOptions, Timing};
use crate::math::LinearImage;
use crate::math::color::srgb_from_linear;
use crate::render::{GpuScene, RenderError, Renderer};
use crate::scene::{Arrangement, Scene};
use crate::tradeoff::{difference, image_error, reference};

/// A picture whose reference is wanted.
#[derive(Clone)]
pub struct Job {
    /// Of which order it is.
    pub number: u64,
    /// The model.
    pub scene: Arc<Scene>,
    /// Another one has another number.
    pub scene_number: u64,
    /// What it shows, with the transfer functions as they are used.
    pub seen: Seen,
    /// Texts that stand in for shader modules.
    pub shaders: Arc<ShaderTexts>,
    /// The exact picture.
    pub picture: Arc<LinearImage>,
}

impl Job {
    /// For what is on screen, if that is an exact picture.
    pub fn of(workspace: &Workspace) -> Option<Job> {
        let (document, screen) = (workspace.document.as_ref()?, workspace.screen.as_ref()?);
        Some(Job {
            number: workspace.order,
            scene: Arc::clone(&document.scene),
            scene_number: workspace.scene_number,
            seen: workspace.resolved(&document.seen),
            shaders: Arc::clone(&workspace.shaders),
            picture: Arc::clone(screen.linear.as_ref().filter(|_| workspace.is_exact())?),
        })
    }
}

/// What became of a job: what was found, or its number and why nothing was.
pub type Outcome = Result<Referenced, (u64, String)>;

#[derive(Default)]
struct Slot {
    job: Option<Job>,
    closed: bool,
}

#[derive(Default)]
struct Desk {
    slot: Mutex<Slot>,
    posted: Condvar,
    /// Raised while what is at work is no longer wanted.
    cancel: Arc<AtomicBool>,
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn next(&self) -> Option<Job> {
        let mut slot = self.lock();
        loop {
            if slot.closed {
                return None;
            }
            if let Some(job) = slot.job.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(job);
            }
            slot = self.posted.wait(slot).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// The thread.
pub struct References {
    desk: Arc<Desk>,
    outcomes: Receiver<Outcome>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl References {
    /// Starts it. `wake` is called, from the thread, when there is something to [`References::take`].
    pub fn start(wake: impl Fn() + Send + 'static) -> References {
        let desk = Arc::new(Desk::default());
        let theirs = Arc::clone(&desk);
        let (sender, outcomes) = channel();
        let run = move || {
            let mut studio = Studio { bench: None, cancel: Arc::clone(&theirs.cancel) };
            while let Some(job) = theirs.next() {
                let outcome = match studio.compare(&job) {
                    Err(RenderError::Cancelled) => continue,
                    outcome => outcome.map_err(|e| (job.number, e.to_string())),
                };
                let there = sender.send(outcome).is_ok();
                wake();
                if !there {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("reference".to_owned()).spawn(run).ok();
        if thread.is_none() {
            tracing::error!("no thread could be started for the reference");
        }
        References { desk, outcomes, thread }
    }

    /// Asks for the reference of a picture instead of whatever was asked for before.
    pub fn post(&self, job: Job) {
        let mut slot = self.desk.lock();
        self.desk.cancel.store(true, Ordering::Relaxed);
        slot.job = Some(job);
        self.desk.posted.notify_one();
    }

    /// Nothing is wanted any more.
    pub fn clear(&self) {
        let mut slot = self.desk.lock();
        slot.job = None;
        self.desk.cancel.store(true, Ordering::Relaxed);
    }

    /// What was found since the last call.
    pub fn take(&self) -> Vec<Outcome> {
        self.outcomes.try_iter().collect()
    }
}

impl Drop for References {
    fn drop(&mut self) {
        let mut slot = self.desk.lock();
        slot.closed = true;
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.posted.notify_one();
        drop(slot);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread of the reference ended badly");
        }
    }
}

/// A device with a scene on it.
struct Bench {
    renderer: Renderer,
    shaders: Arc<ShaderTexts>,
    scene: Option<(u64, GpuScene, Arrangement)>,
}

struct Studio {
    bench: Option<Bench>,
    cancel: Arc<AtomicBool>,
}

impl Studio {
    /// Draws and compares. A device that failed is given up and another one tried, once.
    fn compare(&mut self, job: &Job) -> Result<Referenced, RenderError> {
        let mut result = self.attempt(job);
        if let Err(RenderError::Gpu(GpuError::Lost(_) | GpuError::Device(_) | GpuError::Exhausted)) = &result {
            tracing::warn!("reference: the device failed and is opened again");
            self.bench = None;
            result = self.attempt(job);
        }
        if let Err(RenderError::Gpu(_)) = &result {
            self.bench = None;
        }
        result
    }

    fn attempt(&mut self, job: &Job) -> Result<Referenced, RenderError> {
        // wgpu may panic after a device is lost.
        match catch_unwind(AssertUnwindSafe(|| self.draw(job))) {
            Ok(result) => result,
            Err(_) => {
                self.bench = None;
                Err(GpuError::Lost("the renderer panicked; the log says where".to_owned()).into())
            }
        }
    }

    fn prepare(&mut self, job: &Job) -> Result<&mut Bench, RenderError> {
        if self.bench.as_ref().is_none_or(|b| b.shaders != job.shaders) {
            self.bench = None;
            let gpu = Gpu::new(&GpuOptions::default())?;
            let software = gpu.facts().device_type == "Cpu";
            let mut renderer = Renderer::new(gpu)?;
            renderer.cancel = Some(Arc::clone(&self.cancel));
            if software {
                // Pass by pass, so that it can be given up in between.
                renderer.timing = Timing::Serial;
            }
            for (module, text) in job.shaders.iter() {
                renderer.replace_shader(module, Some(text.clone()));
            }
            self.bench = Some(Bench { renderer, shaders: Arc::clone(&job.shaders), scene: None });
        }
        let Some(bench) = &mut self.bench else {
            return Err(RenderError::Cancelled);
        };
        if bench.scene.as_ref().is_none_or(|(number, ..)| *number != job.scene_number) {
            bench.scene = None;
            let scene = bench.renderer.load(&job.scene)?;
            bench.scene = Some((job.scene_number, scene, Arrangement::default()));
        }
        if let Some((_, scene, arrangement)) = &mut bench.scene
            && *arrangement != job.seen.arrangement
        {
            bench.renderer.arrange(scene, &job.scene, &job.seen.arrangement)?;
            *arrangement = job.seen.arrangement.clone();
        }
        Ok(bench)
    }

    fn draw(&mut self, job: &Job) -> Result<Referenced, RenderError> {
        let begin = Instant::now();
        let Seen { settings, camera, .. } = &job.seen;
        let size = [job.picture.width, job.picture.height];
        let bench = self.prepare(job)?;
        let Some((_, scene, _)) = &bench.scene else {
            return Err(RenderError::Cancelled);
        };
        // A declaration that names no value of its setting: a test excludes it.
        let [exact, _] = reference::both(settings).map_err(|e| GpuError::Device(e.to_string()))?;
        let frame = bench.renderer.render(scene, camera, &exact, size)?;
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        self.go_on()?;
        let background = parse_background(&settings.image.background).unwrap_or_default();
        // Both have the size of the picture.
        let wanted = || !self.cancel.load(Ordering::Relaxed);
        let map = image_error::compare_while(&job.picture, &frame.image, background, &wanted)
            .map_err(|e| GpuError::Device(e.to_string()))?
            .ok_or(RenderError::Cancelled)?;
        self.go_on()?;
        // Pictures of orders have small numbers; these are apart from them.
        let serial = |i: u64| (1 << 63) | (2 * job.number + i);
        let behind = background.map(|rgb| rgb.map(|v| srgb_from_linear(f64::from(v)) as f32));
        let reference = Shown { serial: serial(0), size, rgba: rgba8(&frame.image, background), background: behind };
        let difference = Shown { serial: serial(1), size, rgba: difference::rgba(&map), background: Some([0.0; 3]) };
        tracing::debug!(
            "reference of {}: {size:?} in {milliseconds:.1} ms, compared in {:.1} ms",
            job.number,
            begin.elapsed().as_secs_f64() * 1e3 - milliseconds
        );
        Ok(Referenced {
            number: job.number,
            error: map.error,
            reference: Arc::new(reference),
            difference: Arc::new(difference),
            milliseconds,
        })
    }

    fn go_on(&self) -> Result<(), RenderError> {
        if self.cancel.load(Ordering::Relaxed) { Err(RenderError::Cancelled) } else { Ok(()) }
    }
}
