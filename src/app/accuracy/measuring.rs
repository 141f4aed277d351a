//! Sweeps and budgets in a thread with a device of its own, behind a gate: while the window has anything to draw, they rest.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::{Swept, Underway, Wanted};
use crate::app::document::Seen;
use crate::app::workspace::Workspace;
use crate::export::image::parse_background;
use crate::gpu::{Gpu, GpuOptions};
use crate::render::RenderError;
use crate::scene::Scene;
use crate::tradeoff::budget::{self, BudgetError};
use crate::tradeoff::gate::{Gate, Gated};
use crate::tradeoff::kept::{self, Chosen, Subject};
use crate::tradeoff::sweep::{self, Row};
use crate::tradeoff::workbench::{RendererBench, Workbench};
use crate::tradeoff::{axis, reference};

/// What is to be measured.
#[derive(Clone)]
pub struct Task {
    /// What of it.
    pub wanted: Wanted,
    /// The model.
    pub scene: Arc<Scene>,
    /// Its number.
    pub scene_number: u64,
    /// As it is seen.
    pub seen: Seen,
    /// The same with the transfer functions as they are used.
    pub resolved: Seen,
    /// Size of the pictures.
    pub size: [u32; 2],
    /// Time for it.
    pub seconds: u64,
}

impl Task {
    /// For what is seen, as the panel has it; `None` without a model or a viewport.
    pub fn of(workspace: &Workspace, wanted: Wanted) -> Option<Task> {
        let document = workspace.document.as_ref()?;
        let form = &workspace.accuracy.form;
        let viewport = workspace.viewport.size;
        let size = match wanted {
            Wanted::Sweep => within(viewport, form.side),
            // What is promised is the picture in the window.
            Wanted::Budget(_) => viewport,
        };
        (!viewport.contains(&0)).then(|| Task {
            wanted,
            scene: Arc::clone(&document.scene),
            scene_number: workspace.scene_number,
            seen: document.seen.clone(),
            resolved: workspace.resolved(&document.seen),
            size,
            seconds: form.seconds,
        })
    }
}

/// A size of the same shape whose longest side is `side`.
pub fn within([width, height]: [u32; 2], side: u32) -> [u32; 2] {
    let longest = f64::from(width.max(height).max(1));
    [width, height].map(|n| (f64::from(n) * f64::from(side) / longest).round().max(1.0) as u32)
}

/// What came of it.
pub enum Found {
    /// All rows of a sweep, and how long it took, seconds.
    Sweep(Vec<Row>, f64),
    /// A choice.
    Chosen(Box<Chosen>),
    /// It was called off; what is known so far has been delivered.
    CalledOff,
}

#[derive(Default)]
struct Progress {
    done: usize,
    of: usize,
    name: String,
    /// Rows that nobody has taken yet.
    rows: Vec<Row>,
    result: Option<Result<Found, String>>,
}

/// A measurement under way.
pub struct Measuring {
    /// What is measured.
    pub task: Arc<Task>,
    gate: Arc<Gate>,
    progress: Arc<Mutex<Progress>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Measuring {
    /// Begins. `wake` is called, from the thread, as it gets on and at the end.
    pub fn begin(task: Task, wake: impl Fn() + Send + 'static) -> Measuring {
        let (task, gate) = (Arc::new(task), Arc::new(Gate::default()));
        let progress =
            Arc::new(Mutex::new(Progress { name: "starting the adapter".to_owned(), ..Progress::default() }));
        let (what, door, theirs) = (Arc::clone(&task), Arc::clone(&gate), Arc::clone(&progress));
        let run = move || {
            let result = catch_unwind(AssertUnwindSafe(|| measure(&what, &door, &theirs, &wake)))
                .unwrap_or_else(|_| Err("the renderer panicked; the log says where".to_owned()));
            lock(&theirs).result = Some(result);
            wake();
        };
        if let Err(e) = std::thread::Builder::new().name("measuring".to_owned()).spawn(run) {
            lock(&progress).result = Some(Err(e.to_string()));
        }
        Measuring { task, gate, progress }
    }

    /// Lets it go on, or rest.
    pub fn let_pass(&self, pass: bool) {
        if pass { self.gate.open() } else { self.gate.close() }
    }

    /// Calls it off.
    pub fn stop(&self) {
        self.gate.stop();
    }

    /// How far it is.
    pub fn underway(&self) -> Underway {
        let progress = lock(&self.progress);
        Underway {
            wanted: self.task.wanted,
            done: progress.done,
            of: progress.of,
            name: progress.name.clone(),
            rests: self.gate.is_closed(),
        }
    }

    /// Rows since the last call.
    pub fn rows(&self) -> Vec<Row> {
        std::mem::take(&mut lock(&self.progress).rows)
    }

    /// What came of it, once.
    pub fn take(&self) -> Option<Result<Found, String>> {
        lock(&self.progress).result.take()
    }

    /// What its rows are put into.
    pub fn empty(&self) -> Swept {
        let Task { scene_number, seen, size, .. } = &*self.task;
        Swept { scene_number: *scene_number, seen: seen.clone(), size: *size, entries: Vec::new() }
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        self.stop();
    }
}

fn measure(task: &Task, gate: &Gate, progress: &Mutex<Progress>, wake: &impl Fn()) -> Result<Found, String> {
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| e.to_string())?;
    let Seen { camera, arrangement, .. } = &task.resolved;
    let mut bench = RendererBench::new(&gpu, &task.scene, camera).map_err(|e| e.to_string())?;
    bench.arrange(&task.scene, arrangement).map_err(|e| e.to_string())?;
    bench.cancelled_by(gate.raised());
    let facts = gpu.facts();
    let mut bench = Gated::new(bench, gate);
    match task.wanted {
        Wanted::Sweep => sweep_on(&mut bench, task, progress, wake),
        Wanted::Budget(goal) => {
            let settings = &task.resolved.settings;
            let options = budget::Options {
                size: task.size,
                background: parse_background(&settings.image.background)?,
                limit: Duration::from_secs(task.seconds),
                resize: false,
            };
            let subject = Subject { scene: &task.scene, arrangement, camera, settings, facts };
            let longer = (false, "a longer time limit measures more");
            let chosen = kept::chosen(&mut bench, subject, goal, &options, longer, &mut |count, name| {
                // Not for every frame: showing it takes time from those that are measured.
                let mut progress = lock(progress);
                if progress.name != name {
                    (progress.done, progress.name) = (count, name.to_owned());
                    drop(progress);
                    wake();
                }
            });
            match chosen {
                Ok(chosen) => Ok(Found::Chosen(Box::new(chosen))),
                Err(BudgetError::Render(RenderError::Cancelled)) => Ok(Found::CalledOff),
                Err(e) => Err(e.to_string()),
            }
        }
    }
}

/// The sweep of `pellucid tradeoff`, all axes; rows are delivered as they come.
fn sweep_on(
    bench: &mut dyn Workbench,
    task: &Task,
    progress: &Mutex<Progress>,
    wake: &impl Fn(),
) -> Result<Found, String> {
    let settings = &task.resolved.settings;
    let configurations = axis::configurations(settings, &axis::all()).map_err(|e| e.to_string())?;
    let [exact, supersampled] = reference::both(settings).map_err(|e| e.to_string())?;
    let options = sweep::Options {
        size: task.size,
        background: parse_background(&settings.image.background)?,
        limit: Some(Duration::from_secs(task.seconds)),
        thumbnail: 0,
        ..sweep::Options::default()
    };
    let swept = sweep::run(bench, &configurations, [&exact, &supersampled], &options, &mut |step| {
        let mut progress = lock(progress);
        (progress.done, progress.of, progress.name) = (step.done, step.of, step.name.to_owned());
        progress.rows.extend(step.finished.cloned());
        drop(progress);
        wake();
    });
    match swept {
        Ok(swept) => Ok(Found::Sweep(swept.rows, swept.seconds)),
        Err(RenderError::Cancelled) => Ok(Found::CalledOff),
        Err(e) => Err(e.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_shape() {
        assert_eq!(within([1280, 800], 256), [256, 160]);
        assert_eq!(within([10, 1000], 100), [1, 100]);
        assert_eq!(within([0, 0], 100), [1, 1]);
    }
}
