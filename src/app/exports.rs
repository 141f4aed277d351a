//! Pictures into files: one of any size, or the frames of a turntable. A thread with a device of its own draws them exactly,
//! says how far it is, and can be called off.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::camera;
use super::dialogs::write;
use super::document::Seen;
use super::workspace::Workspace;
use crate::export::image::parse_background;
use crate::export::png::write_png;
use crate::gpu::{Gpu, GpuOptions};
use crate::render::{RenderError, Renderer};
use crate::scene::Scene;

/// Longest side that is offered, pixels.
pub const LONGEST_SIDE: u32 = 16_384;
/// Most frames of a turntable.
pub const MOST_FRAMES: u32 = 3600;

/// What is to be written, as the panel has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Whether the background of the settings is behind the model; otherwise nothing is.
    pub background: bool,
    /// The frames of one full turn instead of one picture.
    pub turntable: bool,
    /// How many of them.
    pub frames: u32,
}

/// Pictures to write.
pub struct Job {
    /// The model.
    pub scene: Arc<Scene>,
    /// How it is seen.
    pub seen: Seen,
    /// What is written.
    pub form: Form,
    /// The file, or what the names of frames are made of.
    pub path: PathBuf,
}

impl Job {
    /// What the panel asks for, into this file.
    ///
    /// # Errors
    /// A sentence without a model or the panel.
    pub fn of(workspace: &Workspace, path: &str) -> Result<Job, String> {
        let document = workspace.document.as_ref().ok_or("there is no model")?;
        let form = workspace.layout.export.clone().ok_or("nothing is to be written")?;
        Ok(Job {
            scene: Arc::clone(&document.scene),
            seen: workspace.resolved(&document.seen),
            form,
            path: PathBuf::from(path),
        })
    }

    /// How many pictures.
    pub fn count(&self) -> u32 {
        if self.form.turntable { self.form.frames.clamp(1, MOST_FRAMES) } else { 1 }
    }

    /// The file of a frame: `name.png`, or `name-0042.png`.
    pub fn file(&self, frame: u32) -> PathBuf {
        if !self.form.turntable {
            return self.path.clone();
        }
        let stem = self.path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        self.path.with_file_name(format!("{stem}-{frame:04}.png"))
    }
}

#[derive(Default)]
struct Shared {
    called_off: Arc<AtomicBool>,
    done: AtomicU32,
    result: Mutex<Option<Result<String, String>>>,
}

/// Pictures on their way.
pub struct Exporting {
    /// How many there are to be.
    pub count: u32,
    shared: Arc<Shared>,
}

impl Exporting {
    /// Begins. `wake` is called, from the thread, after every picture and at the end.
    pub fn begin(job: Job, wake: impl Fn() + Send + 'static) -> Exporting {
        let (shared, count) = (Arc::new(Shared::default()), job.count());
        let theirs = Arc::clone(&shared);
        let run = move || {
            let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| export(&job, &theirs, &wake)))
                .unwrap_or_else(|_| Err("the renderer panicked; the log says where".to_owned()));
            // Called off is no fault.
            let result = match result {
                Err(_) if theirs.called_off.load(Ordering::Relaxed) => {
                    let done = theirs.done.load(Ordering::Relaxed);
                    Ok(format!("Called off; {done} of {count} pictures are written."))
                }
                other => other,
            };
            *theirs.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            wake();
        };
        if let Err(e) = std::thread::Builder::new().name("export".to_owned()).spawn(run) {
            *shared.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(Err(e.to_string()));
        }
        Exporting { count, shared }
    }

    /// How many are written.
    pub fn done(&self) -> u32 {
        self.shared.done.load(Ordering::Relaxed)
    }

    /// What to say at the end, once: what was written, or why not.
    pub fn take(&self) -> Option<Result<String, String>> {
        self.shared.result.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Calls it off; frames that are written stay.
    pub fn cancel(&self) {
        self.shared.called_off.store(true, Ordering::Relaxed);
    }
}

impl Drop for Exporting {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn export(job: &Job, shared: &Shared, wake: &impl Fn()) -> Result<String, String> {
    let count = job.count();
    let Seen { settings, camera, arrangement } = &job.seen;
    let background = if job.form.background { parse_background(&settings.image.background)? } else { None };
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| e.to_string())?;
    let mut renderer = Renderer::new(gpu).map_err(|e| e.to_string())?;
    renderer.cancel = Some(Arc::clone(&shared.called_off));
    let mut scene = renderer.load(&job.scene).map_err(|e| e.to_string())?;
    renderer.arrange(&mut scene, &job.scene, arrangement).map_err(|e| e.to_string())?;
    for frame in 0..count {
        if shared.called_off.load(Ordering::Relaxed) {
            return Err(RenderError::Cancelled.to_string());
        }
        let camera = camera::spun(camera, camera.focal_point, 360.0 * f64::from(frame) / f64::from(count));
        let drawn = renderer.render(&scene, &camera, settings, job.form.size).map_err(|e| e.to_string())?;
        let png = write_png(&drawn.image, background, 8).map_err(|e| e.to_string())?;
        let file = job.file(frame);
        write(&file, &png).map_err(|e| format!("{}: {e}", file.display()))?;
        shared.done.store(frame + 1, Ordering::Relaxed);
        wake();
    }
    Ok(if job.form.turntable {
        format!("{count} frames are written, {} to {}.", name(&job.file(0)), name(&job.file(count - 1)))
    } else {
        format!("{} is written.", job.path.display())
    })
}

fn name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Arrangement, builtin};
    use crate::settings::Settings;

    fn job(turntable: bool, folder: &Path) -> Job {
        let scene = Arc::new(builtin::build("stack").unwrap());
        let camera = camera::first(&scene.bounds(), 1.5);
        let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
        let form = Form { size: [48, 32], background: false, turntable, frames: 3 };
        Job { scene, seen, form, path: folder.join("turn.png") }
    }

    #[test]
    fn frames_are_numbered_and_a_picture_is_not() {
        let folder = Path::new("/x");
        assert_eq!(job(true, folder).file(2), Path::new("/x/turn-0002.png"));
        assert_eq!((job(true, folder).count(), job(false, folder).count()), (3, 1));
        assert_eq!(job(false, folder).file(0), Path::new("/x/turn.png"));
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error_not_a_panic() {
        let exporting = Exporting::begin(job(false, Path::new("/no/such/folder")), || {});
        let result = loop {
            if let Some(result) = exporting.take() {
                break result;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        };
        assert!(result.is_err(), "{result:?}");
        assert_eq!(exporting.done(), 0);
    }
}
