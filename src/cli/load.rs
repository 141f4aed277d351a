//! From what stands on the command line to a scene: a file, or `builtin:NAME`.

use std::path::Path;

use super::failure::{Exit, Failure};
use super::output::Progress;
use crate::export::assets;
use crate::import;
use crate::scene::{Scene, builtin};

/// In front of the name of a generated scene.
const BUILTIN: &str = "builtin:";

/// Reads a file or generates a scene, and says every notice in one line on standard error.
///
/// # Errors
/// [`Exit::Usage`] for a generated scene that does not exist, [`Exit::Input`] for a file that cannot be read.
pub fn scene(file: &str, progress: &Progress) -> Result<Scene, Failure> {
    progress.stage(&format!("reading {file}"));
    let scene = match file.strip_prefix(BUILTIN) {
        Some(name) => builtin::build(name).map_err(|e| Failure::of(Exit::Usage, &e))?,
        None => import::load(Path::new(file)).map_err(|e| Failure::about(Exit::Input, file, &e))?,
    };
    for notice in &scene.notices {
        progress.say(&format!("{file}: {}: {}", notice.kind.name(), notice.message));
    }
    Ok(scene)
}

/// Writes the generated scenes as files, and names them on standard output.
///
/// # Errors
/// [`Exit::General`] if a file cannot be written.
pub fn write_assets(folder: &Path) -> Result<(), Failure> {
    let written = assets::write_assets(folder).map_err(|e| Failure::of(Exit::General, &e))?;
    let lines: String = written.iter().map(|path| format!("{}\n", path.display())).collect();
    super::output::print(lines.as_bytes())
}
