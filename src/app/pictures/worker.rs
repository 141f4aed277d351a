//! A thread with a device of its own that draws what it was last asked for.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::pace::Pace;
use super::simplify::simplified;
use super::{Delivery, Fault, Kind, Order, PickOrder, Picked, Picture, Wish};
use crate::app::document::Seen;
use crate::export::image::parse_background;
use crate::export::png::rgba8;
use crate::gpu::{Gpu, GpuError, GpuOptions, Timing};
use crate::render::{GpuScene, RenderError, Renderer};
use crate::scene::{Arrangement, Scene};

/// Triangles of a preview on a software rasterizer.
const SOFTWARE_TRIANGLES: u64 = 15_000;

#[derive(Default)]
struct Slot {
    order: Option<Order>,
    pick: Option<PickOrder>,
    /// For when there is nothing else.
    hover: Option<PickOrder>,
    closed: bool,
}

/// What the window's thread and the worker share.
struct Desk {
    slot: Mutex<Slot>,
    posted: Condvar,
    /// Raised while the picture at work is no longer wanted.
    cancel: Arc<AtomicBool>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A thread that draws.
pub struct Worker {
    desk: Arc<Desk>,
    kind: Kind,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; the device is opened there. `deliver` is called after everything sent.
    pub fn start(
        kind: Kind,
        pace: Arc<Mutex<Pace>>,
        sender: Sender<Delivery>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Worker {
        let desk = Arc::new(Desk { slot: Mutex::default(), posted: Condvar::new(), cancel: Arc::default() });
        let theirs = Arc::clone(&desk);
        let run = move || {
            let mut studio = Studio { kind, pace, bench: None, cancel: Arc::clone(&theirs.cancel) };
            while let Some(work) = theirs.next() {
                let delivery = match work {
                    Work::Pick(order) => studio.pick(&order),
                    Work::Draw(order) => {
                        let delivery = studio.fill(&order);
                        if delivery.is_none() {
                            theirs.take_back(order);
                        }
                        delivery
                    }
                };
                if let Some(delivery) = delivery {
                    if sender.send(delivery).is_err() {
                        return;
                    }
                    wake();
                }
            }
        };
        let thread = std::thread::Builder::new().name(kind.name().to_owned()).spawn(run).ok();
        if thread.is_none() {
            tracing::error!("no thread could be started for the {} picture", kind.name());
        }
        Worker { desk, kind, thread }
    }

    /// Asks for a picture instead of whatever was asked for before. An exact picture at work is abandoned; a preview is
    /// finished, so that there is one now and then.
    pub fn post(&self, order: Order) {
        let mut slot = lock(&self.desk.slot);
        self.desk.cancel.store(self.kind == Kind::Exact, Ordering::Relaxed);
        slot.order = Some(order);
        self.desk.posted.notify_one();
    }

    /// Asks for the layers under a pixel, before anything else; a picture at work is begun again afterwards. What is only
    /// hovered over waits until nothing else is wanted, and is given up for anything that is.
    pub fn pick(&self, order: PickOrder) {
        let mut slot = lock(&self.desk.slot);
        if order.wish == Wish::Hover {
            slot.hover = Some(order);
        } else {
            self.desk.cancel.store(true, Ordering::Relaxed);
            slot.pick = Some(order);
        }
        self.desk.posted.notify_one();
    }

    /// Nothing is hovered over any more.
    pub fn stop_hovering(&self) {
        lock(&self.desk.slot).hover = None;
    }

    /// Abandons everything.
    pub fn clear(&self) {
        let mut slot = lock(&self.desk.slot);
        slot.order = None;
        slot.pick = None;
        slot.hover = None;
        self.desk.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let mut slot = lock(&self.desk.slot);
        slot.closed = true;
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.posted.notify_one();
        drop(slot);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread of the {} picture ended badly", self.kind.name());
        }
    }
}

impl Desk {
    /// Waits for the newest order and for its time to come; `None` when the window closes.
    fn next(&self) -> Option<Work> {
        let mut slot = lock(&self.slot);
        loop {
            if slot.closed {
                return None;
            }
            if let Some(pick) = slot.pick.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(Work::Pick(pick));
            }
            if slot.order.is_none()
                && let Some(hover) = slot.hover.take()
            {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(Work::Pick(hover));
            }
            let wait = slot.order.as_ref().map(|o| o.not_before.saturating_duration_since(Instant::now()));
            slot = match wait {
                None => self.posted.wait(slot).unwrap_or_else(PoisonError::into_inner),
                Some(left) if !left.is_zero() => {
                    self.posted.wait_timeout(slot, left).unwrap_or_else(PoisonError::into_inner).0
                }
                Some(_) => {
                    self.cancel.store(false, Ordering::Relaxed);
                    return slot.order.take().map(Work::Draw);
                }
            };
        }
    }

    /// Puts back an order that was given up only for a pick.
    fn take_back(&self, order: Order) {
        let mut slot = lock(&self.slot);
        if slot.pick.is_some() && slot.order.is_none() {
            slot.order = Some(order);
        }
    }
}

/// What the thread does next.
enum Work {
    Draw(Order),
    Pick(PickOrder),
}

/// A device with a scene on it.
struct Bench {
    renderer: Renderer,
    software: bool,
    scene: Option<Uploaded>,
}

/// A scene on the device.
struct Uploaded {
    number: u64,
    /// What was uploaded: the model, or a simpler one.
    source: Arc<Scene>,
    scene: GpuScene,
    arrangement: Arrangement,
}

/// What lives on the thread.
struct Studio {
    kind: Kind,
    pace: Arc<Mutex<Pace>>,
    bench: Option<Bench>,
    cancel: Arc<AtomicBool>,
}

impl Studio {
    /// Draws what was ordered. A device that failed is given up and another one tried, once.
    fn fill(&mut self, order: &Order) -> Option<Delivery> {
        let mut result = self.attempt(order);
        if let Err(RenderError::Gpu(GpuError::Lost(_) | GpuError::Device(_) | GpuError::Exhausted)) = &result {
            tracing::warn!("{} picture: the device failed and is opened again", self.kind.name());
            self.bench = None;
            result = self.attempt(order);
        }
        match result {
            Ok(picture) => Some(Delivery::Picture(Box::new(picture))),
            Err(RenderError::Cancelled) => None,
            Err(error) => {
                let refused = matches!(
                    error,
                    RenderError::Refused(_)
                        | RenderError::PixelTooDeep { .. }
                        | RenderError::RowTooDeep { .. }
                        | RenderError::Transfer(_)
                );
                if !refused {
                    self.bench = None;
                }
                let fault = Fault { number: order.number, kind: self.kind, message: error.to_string() };
                Some(Delivery::Fault(fault))
            }
        }
    }

    fn attempt(&mut self, order: &Order) -> Result<Picture, RenderError> {
        // wgpu may panic after a device is lost.
        match catch_unwind(AssertUnwindSafe(|| self.draw(order))) {
            Ok(result) => result,
            Err(_) => {
                self.bench = None;
                Err(GpuError::Lost("the renderer panicked; the log says where".to_owned()).into())
            }
        }
    }

    /// The device, with the scene on it and its parts arranged.
    fn prepare(
        &mut self,
        scene: &Arc<Scene>,
        number: u64,
        arrangement: &Arrangement,
    ) -> Result<&mut Bench, RenderError> {
        if self.bench.is_none() {
            let gpu = Gpu::new(&GpuOptions::default())?;
            let software = gpu.facts().device_type == "Cpu";
            let mut renderer = Renderer::new(gpu)?;
            renderer.cancel = Some(Arc::clone(&self.cancel));
            if self.kind == Kind::Exact && software {
                // Passes one by one: they can be cancelled in between, and their times are right.
                renderer.timing = Timing::Serial;
            }
            self.bench = Some(Bench { renderer, software, scene: None });
        }
        let Some(bench) = &mut self.bench else {
            return Err(RenderError::Cancelled);
        };
        if bench.scene.as_ref().is_none_or(|s| s.number != number) {
            bench.scene = None;
            let coarse = if self.kind == Kind::Preview && bench.software {
                simplified(scene, SOFTWARE_TRIANGLES).map(Arc::new)
            } else {
                None
            };
            let source = coarse.unwrap_or_else(|| Arc::clone(scene));
            let scene = bench.renderer.load(&source)?;
            bench.scene = Some(Uploaded { number, source, scene, arrangement: Arrangement::default() });
            lock(&self.pace).restart();
        }
        if let Some(uploaded) = &mut bench.scene
            && uploaded.arrangement != *arrangement
        {
            bench.renderer.arrange(&mut uploaded.scene, &uploaded.source, arrangement)?;
            uploaded.arrangement = arrangement.clone();
        }
        Ok(bench)
    }

    /// The layers under a pixel. What fails is said, and nothing is picked.
    fn pick(&mut self, order: &PickOrder) -> Option<Delivery> {
        let result = catch_unwind(AssertUnwindSafe(|| {
            let bench = self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
            let Some(uploaded) = &bench.scene else {
                return Ok(Vec::new());
            };
            let Seen { camera, settings, .. } = &order.seen;
            bench.renderer.pick(&uploaded.scene, camera, settings, order.size, order.pixel)
        }));
        match result {
            Ok(Ok(layers)) => Some(Delivery::Picked(Picked {
                scene_number: order.scene_number,
                wish: order.wish,
                pixel: order.pixel,
                of: order.seen.camera,
                layers,
            })),
            Ok(Err(RenderError::Cancelled)) => None,
            Ok(Err(error)) => {
                tracing::warn!("nothing could be picked: {error}");
                None
            }
            Err(_) => {
                self.bench = None;
                None
            }
        }
    }

    fn draw(&mut self, order: &Order) -> Result<Picture, RenderError> {
        let (kind, pace) = (self.kind, Arc::clone(&self.pace));
        let bench = self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
        let Some(Uploaded { scene, .. }) = &bench.scene else {
            return Err(RenderError::Cancelled);
        };
        let begin = Instant::now();
        let mut settings = order.seen.settings.clone();
        let size = match kind {
            Kind::Exact => order.size,
            Kind::Preview => {
                settings.image.samples = 1;
                lock(&pace).size(order.size)
            }
        };
        let frame = bench.renderer.render(scene, &order.seen.camera, &settings, size)?;
        let background = parse_background(&settings.image.background).unwrap_or_default();
        let rgba = rgba8(&frame.image, background);
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        tracing::debug!("{} {}: {size:?} in {milliseconds:.1} ms", kind.name(), order.number);
        if kind == Kind::Preview {
            lock(&pace).measured(milliseconds);
        }
        Ok(Picture {
            number: order.number,
            kind,
            scene_number: order.scene_number,
            viewport: order.size,
            size,
            rgba,
            background,
            milliseconds,
            software: bench.software,
            report: frame.report,
            seen: order.seen.clone(),
        })
    }
}
