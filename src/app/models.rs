//! Five opacity models of what is seen, beside each other (Carnecky 2013, Figure 11): exact pictures from a thread with a device
//! of its own, as small as they are shown, one after the other. What is open is drawn again when an exact picture has come.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};

use egui::{ColorImage, TextureHandle};

use super::document::Seen;
use super::workspace::Workspace;
use crate::export::image::parse_background;
use crate::export::png::rgba8;
use crate::gpu::{Gpu, GpuOptions};
use crate::render::Renderer;
use crate::scene::Scene;
use crate::settings::{OpacityModel, looks};

/// Width of a picture, pixels.
pub const WIDTH: u32 = 300;

/// A model's picture.
pub struct Picture {
    /// The model's name.
    pub name: &'static str,
    /// The model.
    pub model: OpacityModel,
    /// Its pixels.
    pub image: ColorImage,
    /// The same on the window's device, once it has been shown there.
    pub texture: Option<TextureHandle>,
}

/// The pictures that are shown.
#[derive(Default)]
pub struct Models {
    /// Of which order they are.
    pub number: u64,
    /// Those that are there.
    pub pictures: Vec<Picture>,
    /// Why there are no more.
    pub failed: Option<String>,
}

impl Models {
    /// The textures are gone, with the device.
    pub fn forget_textures(&mut self) {
        self.pictures.iter_mut().for_each(|p| p.texture = None);
    }

    /// Takes what the thread has drawn.
    pub fn take(&mut self, outcome: Result<Picture, String>) {
        match outcome {
            Ok(picture) => match self.pictures.iter_mut().find(|p| p.name == picture.name) {
                Some(old) => *old = picture,
                None => self.pictures.push(picture),
            },
            Err(reason) => self.failed = Some(reason),
        }
    }
}

/// What is to be drawn.
pub struct Job {
    scene: Arc<Scene>,
    seen: Seen,
    size: [u32; 2],
}

impl Job {
    /// What the window shows, in the proportions of its viewport.
    pub fn of(workspace: &Workspace) -> Option<Job> {
        let document = workspace.document.as_ref()?;
        let [width, height] = workspace.viewport.size.map(|n| n.max(1));
        let size = [WIDTH, (WIDTH * height / width).clamp(1, 2 * WIDTH)];
        Some(Job { scene: Arc::clone(&document.scene), seen: workspace.resolved(&document.seen), size })
    }
}

/// The thread at work; dropped, it gives up.
pub struct Drawing {
    cancel: Arc<AtomicBool>,
    pictures: Receiver<Result<Picture, String>>,
}

impl Drawing {
    /// Begins. `wake` is called, from the thread, when there is something to [`Drawing::take`].
    pub fn begin(job: Job, wake: impl Fn() + Send + 'static) -> Drawing {
        let (sender, pictures) = channel();
        let cancel = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&cancel);
        let of_thread = sender.clone();
        let run = move || {
            let give = |outcome| {
                let _ = of_thread.send(outcome);
                wake();
            };
            let drawn = catch_unwind(AssertUnwindSafe(|| draw(&job, &theirs, &mut |picture| give(Ok(picture)))))
                .unwrap_or_else(|_| Err("the renderer panicked; the log says where".to_owned()));
            if let Err(reason) = drawn
                && !theirs.load(Ordering::Relaxed)
            {
                give(Err(reason));
            }
        };
        if let Err(e) = std::thread::Builder::new().name("opacity models".to_owned()).spawn(run) {
            let _ = sender.send(Err(e.to_string()));
        }
        Drawing { cancel, pictures }
    }

    /// What was drawn since the last call.
    pub fn take(&self) -> Vec<Result<Picture, String>> {
        self.pictures.try_iter().collect()
    }
}

impl Drop for Drawing {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

fn draw(job: &Job, cancel: &Arc<AtomicBool>, give: &mut dyn FnMut(Picture)) -> Result<(), String> {
    let Seen { settings, camera, arrangement } = &job.seen;
    let background = parse_background(&settings.image.background)?;
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| e.to_string())?;
    let mut renderer = Renderer::new(gpu).map_err(|e| e.to_string())?;
    renderer.cancel = Some(Arc::clone(cancel));
    let mut scene = renderer.load(&job.scene).map_err(|e| e.to_string())?;
    renderer.arrange(&mut scene, &job.scene, arrangement).map_err(|e| e.to_string())?;
    for (name, settings) in looks::opacity_models(settings) {
        let frame = renderer.render(&scene, camera, &settings, job.size).map_err(|e| e.to_string())?;
        let size = job.size.map(|n| n as usize);
        let image = ColorImage::from_rgba_unmultiplied(size, &rgba8(&frame.image, background));
        give(Picture { name, model: settings.opacity.model, image, texture: None });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::panels::tests::workspace;

    #[test]
    fn five_models_are_drawn_and_differ() {
        let mut models = Models::default();
        let drawing = Drawing::begin(Job { size: [40, 30], ..Job::of(&workspace("stack")).unwrap() }, || {});
        for _ in 0..3000 {
            drawing.take().into_iter().for_each(|outcome| models.take(outcome));
            if models.pictures.len() == 5 || models.failed.is_some() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        if let Some(reason) = &models.failed {
            println!("skipped: {reason}");
            return;
        }
        let names: Vec<&str> = models.pictures.iter().map(|p| p.name).collect();
        assert_eq!(names, looks::opacity_models(&Default::default()).map(|(name, _)| name));
        for (i, picture) in models.pictures.iter().enumerate() {
            assert_eq!(picture.image.size, [40, 30]);
            assert!(models.pictures[..i].iter().all(|p| p.image.pixels != picture.image.pixels), "{}", picture.name);
        }
    }
}
