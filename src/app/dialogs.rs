//! Files chosen in dialogs: the desktop's, or, where there is none (no portal, a bare X server), a line to type a path into.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use winit::window::Window;

use super::editors;
use super::workspace::{Ask, Gravity, Workspace};
use crate::export::png::png_of_rgba8;
use crate::transfer::Format;

/// A dialog that is over so soon was never there.
const NEVER_THERE: Duration = Duration::from_millis(400);

/// What a file is chosen for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// To be opened.
    Open,
    /// The session is written to it.
    SaveSession,
    /// The picture is written to it.
    SavePicture,
    /// Transfer functions are read from it.
    ImportTransfer,
    /// They are written to it.
    ExportTransfer,
    /// Pictures of the export panel are written to it.
    Export,
}

impl Choice {
    /// Title of the dialog.
    pub fn title(self) -> &'static str {
        match self {
            Choice::Open => "Open a model or a session",
            Choice::SaveSession => "Save the session",
            Choice::SavePicture => "Save the picture",
            Choice::ImportTransfer => "Import transfer functions",
            Choice::ExportTransfer => "Export the transfer functions",
            Choice::Export => "Write pictures",
        }
    }

    /// Whether something is written to it.
    pub fn writes(self) -> bool {
        !matches!(self, Choice::Open | Choice::ImportTransfer)
    }

    /// What its name ends with, as proposed.
    pub fn ending(self) -> &'static str {
        match self {
            Choice::Open => "glb",
            Choice::SaveSession | Choice::ImportTransfer | Choice::ExportTransfer => "toml",
            Choice::SavePicture | Choice::Export => "png",
        }
    }
}

/// A path that is asked for in the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Prompt {
    /// What for.
    pub choice: Choice,
    /// As typed so far.
    pub path: String,
    /// A file that is there and would be replaced, of which was told.
    pub replaced: Option<String>,
}

impl Prompt {
    /// Beginning with this path.
    pub fn new(choice: Choice, path: &str) -> Prompt {
        Prompt { choice, path: path.to_owned(), replaced: None }
    }
}

/// The answer to a dialog.
#[derive(Debug)]
pub struct Chosen {
    choice: Choice,
    path: Option<PathBuf>,
    suggestion: String,
    never_there: bool,
}

/// Shows the desktop's dialog; `done` is called from another thread. `file` is the model that is open, `converted` are the
/// endings of files that converters read.
pub fn choose(
    choice: Choice,
    window: Option<&Window>,
    file: Option<&str>,
    converted: Vec<String>,
    done: impl FnOnce(Chosen) + Send + 'static,
) {
    let stem = file.map(|f| f.trim_start_matches("builtin:")).and_then(|f| Path::new(f).file_stem());
    let stem = stem.map_or_else(|| "pellucid".to_owned(), |s| s.to_string_lossy().into_owned());
    let suggestion = format!("{stem}.{}", choice.ending());
    let mut dialog = rfd::AsyncFileDialog::new().set_title(choice.title());
    if let Some(window) = window {
        dialog = dialog.set_parent(window);
    }
    let begin = Instant::now();
    let finish = move |handle: Option<rfd::FileHandle>| {
        let path = handle.map(|h| h.path().to_path_buf());
        let never_there = path.is_none() && begin.elapsed() < NEVER_THERE;
        let reads = matches!(choice, Choice::Open | Choice::ImportTransfer);
        let suggestion = if reads { String::new() } else { suggestion };
        done(Chosen { choice, path, suggestion, never_there });
    };
    let name = format!("{stem}.{}", choice.ending());
    // Made here, because some desktops want that on the window's thread; waited for elsewhere.
    let spawned = match choice {
        Choice::Open => {
            let read = ["glb", "gltf", "obj", "stl", "ply", "toml"].map(str::to_owned);
            let endings: Vec<String> = read.into_iter().chain(converted).collect();
            let answer = dialog.add_filter("Models and sessions", &endings).pick_file();
            std::thread::Builder::new().name("dialog".to_owned()).spawn(move || finish(pollster::block_on(answer)))
        }
        Choice::ImportTransfer => {
            let endings: Vec<&str> = Format::ALL.iter().map(|f| f.extension()).collect();
            let answer = dialog.add_filter("Transfer functions", &endings).pick_file();
            std::thread::Builder::new().name("dialog".to_owned()).spawn(move || finish(pollster::block_on(answer)))
        }
        Choice::SaveSession | Choice::SavePicture | Choice::ExportTransfer | Choice::Export => {
            let answer = dialog.set_file_name(name).save_file();
            std::thread::Builder::new().name("dialog".to_owned()).spawn(move || finish(pollster::block_on(answer)))
        }
    };
    if let Err(e) = spawned {
        tracing::error!("no dialog: {e}");
    }
}

/// Takes the answer of a dialog.
pub fn answered(workspace: &mut Workspace, chosen: Chosen) {
    match chosen.path {
        Some(path) => workspace.asks.push(Ask::Use {
            choice: chosen.choice,
            path: path.to_string_lossy().into_owned(),
            typed: false,
        }),
        None if chosen.never_there => {
            workspace.layout.prompt = Some(Prompt::new(chosen.choice, &chosen.suggestion));
        }
        None => {}
    }
}

/// Does with a path what it was chosen for. One that was `typed` and could not be written to is asked for again.
pub fn fulfil(workspace: &mut Workspace, choice: Choice, path: &str, typed: bool) {
    let path = path.trim();
    if path.is_empty() {
        return;
    }
    if let Err(reason) = may_be_written(workspace, choice, path) {
        refuse(workspace, choice, path, typed, &reason);
        return;
    }
    let written = match choice {
        Choice::Open => {
            workspace.layout.typed = typed.then(|| path.to_owned());
            workspace.asks.push(Ask::Open(path.to_owned()));
            return;
        }
        Choice::ImportTransfer => {
            editors::import(workspace, path);
            return;
        }
        Choice::ExportTransfer => editors::export(workspace, path).and_then(|bytes| write(Path::new(path), &bytes)),
        Choice::Export => {
            workspace.asks.push(Ask::Export(path.to_owned()));
            return;
        }
        Choice::SaveSession => {
            let folder = Path::new(path).parent().unwrap_or(Path::new(""));
            workspace.session(folder).and_then(|text| write(Path::new(path), text.as_bytes()))
        }
        Choice::SavePicture => picture(workspace).and_then(|png| write(Path::new(path), &png)),
    };
    match written {
        Ok(()) => workspace.say(Gravity::Note, format!("{path} is written.")),
        Err(reason) => refuse(workspace, choice, path, typed, &reason),
    }
}

/// Says why nothing was written. Whoever typed the path mends it rather than types it again.
fn refuse(workspace: &mut Workspace, choice: Choice, path: &str, typed: bool, reason: &str) {
    workspace.say(Gravity::Error, format!("{path}: {reason}"));
    if typed {
        workspace.layout.prompt = Some(Prompt::new(choice, path));
    }
}

/// Whether this may become a file: not the model that is open, nor under a name that says it is something else.
fn may_be_written(workspace: &Workspace, choice: Choice, path: &str) -> Result<(), String> {
    let expected = match choice {
        Choice::SaveSession => "toml",
        Choice::SavePicture => "png",
        Choice::ExportTransfer | Choice::Export => "",
        Choice::Open | Choice::ImportTransfer => return Ok(()),
    };
    let open = workspace.document.as_ref().and_then(|d| Path::new(&d.file).canonicalize().ok());
    if open.is_some() && open == Path::new(path).canonicalize().ok() {
        return Err("this is the model that is open".to_owned());
    }
    let ending = Path::new(path).extension().unwrap_or_default();
    if !expected.is_empty() && !ending.eq_ignore_ascii_case(expected) {
        return Err(format!("the name has to end with .{expected}"));
    }
    Ok(())
}

/// The picture on screen as PNG, if it is the exact one.
fn picture(workspace: &Workspace) -> Result<Vec<u8>, String> {
    let Some(screen) = workspace.screen.as_ref().filter(|_| workspace.is_exact()) else {
        return Err("the exact picture is not there yet".to_owned());
    };
    let opaque = screen.shown.background.is_some();
    png_of_rgba8(&screen.shown.rgba, screen.shown.size, opaque).map_err(|e| e.to_string())
}

/// Writes a file, whole or not at all.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let draft = path.with_extension(format!("{}.tmp", std::process::id()));
    std::fs::write(&draft, bytes).and_then(|()| std::fs::rename(&draft, path)).map_err(|e| {
        // It may never have come to be.
        let _ = std::fs::remove_file(&draft);
        e.to_string()
    })
}
