//! Formats that are not read, by a program that the user names.
//!
//! CAD and animation formats (STEP, IGES, FBX, USD) need libraries many times this program's size; whoever has such files
//! often has a program that converts them. [`ImportOptions::converters`](super::ImportOptions::converters) names a command
//! line for an extension:
//!
//! ```text
//! step = "gmsh {in} -2 -clcurv 20 -format stl -o {out.stl}"
//! fbx = "assimp export {in} {out}"
//! ```
//!
//! - `{in}` is the file, with its absolute path; bytes without a file are written to one first.
//! - `{out}` is where the program writes, a file in a new folder that only this user can enter and that is gone afterwards.
//!   `{out}` ends in `.glb`; `{out.stl}`, `{out.obj}`, `{out.ply}` and `{out.gltf}` in what they say. Files that the result
//!   refers to may lie beside it.
//! - The line is split into words as a shell does, with quotes and backslashes, but no shell runs: `$HOME`, `|` and `>` mean
//!   nothing, so a file's name cannot become a command.
//! - The program has [`Limits::converter_seconds`](super::Limits), no standard input, and its standard output is thrown away.
//!   When it takes too long, writes too much or the import is called off, it and what it started are ended.
//!
//! The command comes from the user's configuration, never from a model.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::{Fallible, Fault, ImportOptions, Phase};

/// What a program may write: its extensions.
const OUTPUTS: &[&str] = &["glb", "gltf", "obj", "stl", "ply"];
/// Between two looks at whether it is done.
const PAUSE: Duration = Duration::from_millis(10);
/// So much of what it says at last is kept.
const MOST_SAID: usize = 1 << 14;

/// What a converter wrote; the folder goes when this does.
#[derive(Debug)]
pub(super) struct Converted {
    pub(super) path: PathBuf,
    _folder: TempDir,
}

/// What to put into the configuration for files of an extension.
pub(super) fn advice(extension: &str) -> String {
    let key = if extension.is_empty() { "step" } else { extension };
    let (line, package) = match key {
        "step" | "stp" | "iges" | "igs" | "brep" => {
            ("gmsh {in} -2 -clcurv 20 -format stl -o {out.stl}", ", with Debian's package gmsh")
        }
        "fbx" | "dae" | "3ds" | "blend" | "x3d" | "3mf" | "lwo" | "ac" | "ase" | "x" | "off" | "dxf" | "ifc" => {
            ("assimp export {in} {out}", ", with Debian's package assimp-utils")
        }
        _ => ("PROGRAM {in} {out}", ", where PROGRAM writes {out}, a GLB ({out.stl}, {out.obj}, {out.ply} for others)"),
    };
    // A key of TOML that is not plain needs quotes.
    let plain = key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    let key = if plain { key.to_owned() } else { format!("{key:?}") };
    format!("anything else needs a converter in the configuration, under [converters]: {key} = \"{line}\"{package}")
}

/// Runs the command line `command` on the file at `path`, or on `bytes` where there is none.
pub(super) fn convert(
    command: &str,
    path: Option<&Path>,
    bytes: &[u8],
    extension: &str,
    options: &ImportOptions,
) -> Fallible<Converted> {
    let fault = |cause: String| Fault::Converter { command: command.to_owned(), cause };
    let io = |what: &str, e: std::io::Error| fault(format!("{what}: {e}"));
    let folder = tempfile::Builder::new().prefix("pellucid-").tempdir();
    let folder = folder.map_err(|e| io("no folder for what it writes", e))?;
    let input = match path {
        Some(path) => std::path::absolute(path).map_err(|e| io("the file's path", e))?,
        None => {
            let input = folder.path().join(format!("in.{extension}"));
            std::fs::write(&input, bytes).map_err(|e| io("the file cannot be written for it", e))?;
            input
        }
    };
    let (words, output) = words(command, &input, folder.path()).map_err(&fault)?;
    let (program, arguments) = words.split_first().ok_or_else(|| fault("is empty".to_owned()))?;
    let mut order = Command::new(program);
    order.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // So that all that it starts can be ended with it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut order, 0);
    let child = order.spawn().map_err(|e| {
        let program = program.to_string_lossy();
        match e.kind() {
            std::io::ErrorKind::NotFound => fault(format!("there is no program '{program}'")),
            _ => io(&format!("'{program}' cannot be started"), e),
        }
    })?;
    let (status, said) = watch(child, &output, folder.path(), options).map_err(|stop| match stop {
        Stop::Cancelled => Fault::Cancelled,
        Stop::Because(cause) => fault(cause),
    })?;
    let said = if said.is_empty() { String::new() } else { format!(": {said}") };
    if !status.success() {
        return Err(fault(match status.code() {
            Some(code) => format!("ended with code {code}{said}"),
            None => format!("was ended by the system ({status}){said}"),
        }));
    }
    if !output.is_file() {
        let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
        return Err(fault(format!("ended well and wrote no {name}{said}")));
    }
    Ok(Converted { path: output, _folder: folder })
}

/// The words of a command line with its files in their places, and the file that it writes.
fn words(command: &str, input: &Path, folder: &Path) -> Result<(Vec<std::ffi::OsString>, PathBuf), String> {
    let split = shlex::split(command).ok_or("has a quote that does not end")?;
    let mut output: Option<PathBuf> = None;
    let mut has_input = false;
    let mut words = Vec::new();
    for word in split {
        // Paths need not be text, so a word is put together of pieces.
        let mut made = std::ffi::OsString::new();
        let mut rest = word.as_str();
        while let Some(at) = rest.find('{') {
            let Some(end) = rest[at..].find('}').map(|e| at + e) else { break };
            let name = &rest[at + 1..end];
            let kind = match name {
                "out" => Some("glb"),
                _ => name.strip_prefix("out.").or(name.strip_prefix("out:")),
            };
            made.push(&rest[..at]);
            if name == "in" {
                has_input = true;
                made.push(input);
            } else if let Some(kind) = kind {
                if !OUTPUTS.contains(&kind) {
                    return Err(format!("{{{name}}}: what it writes is one of {}", OUTPUTS.join(", ")));
                }
                let path = folder.join(format!("out.{kind}"));
                if output.as_ref().is_some_and(|other| *other != path) {
                    return Err("writes two files of different kinds".to_owned());
                }
                made.push(&path);
                output = Some(path);
            } else {
                // Braces of the program's own.
                made.push(&rest[at..=end]);
            }
            rest = &rest[end + 1..];
        }
        made.push(rest);
        words.push(made);
    }
    match output {
        _ if !has_input => Err("has no {in}".to_owned()),
        None => Err("has no {out}".to_owned()),
        Some(output) => Ok((words, output)),
    }
}

enum Stop {
    Cancelled,
    Because(String),
}

/// Waits for the program; gives how it ended and the last line that it said.
fn watch(
    mut child: Child,
    output: &Path,
    folder: &Path,
    options: &ImportOptions,
) -> Result<(ExitStatus, String), Stop> {
    // Some programs say on standard output why they fail: that counts where standard error says nothing.
    let said = [listen(child.stderr.take()), listen(child.stdout.take())];
    let begin = Instant::now();
    let limit = Duration::from_secs(options.limits.converter_seconds);
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => {}
            Err(e) => {
                end(&mut child);
                return Err(Stop::Because(format!("cannot be waited for: {e}")));
            }
        }
        let written = output.metadata().map_or(0, |m| m.len());
        let stop = if options.cancel.is_cancelled() {
            Some(Stop::Cancelled)
        } else if begin.elapsed() >= limit {
            Some(Stop::Because(format!("took longer than {} s and was ended", options.limits.converter_seconds)))
        } else if written > options.limits.bytes {
            Some(Stop::Because(format!("wrote more than {} bytes and was ended", options.limits.bytes)))
        } else {
            None
        };
        if let Some(stop) = stop {
            end(&mut child);
            return Err(stop);
        }
        options.progress.tell(Phase::Converting, (begin.elapsed().as_secs_f32() / limit.as_secs_f32()).min(0.99));
        std::thread::sleep(PAUSE);
    };
    // What it started may still hold its outputs; that is not waited for.
    let line = said
        .iter()
        .map(|s| last_line(&s.recv_timeout(Duration::from_millis(500)).unwrap_or_default()))
        .find(|line| !line.is_empty())
        .unwrap_or_default();
    // Paths into the folder mean nothing to anybody.
    Ok((status, line.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")))
}

/// The end of what comes through a pipe, once it is closed.
fn listen(pipe: Option<impl Read + Send + 'static>) -> mpsc::Receiver<Vec<u8>> {
    let (sender, said) = mpsc::channel();
    if let Some(mut pipe) = pipe {
        std::thread::spawn(move || {
            let mut last: Vec<u8> = Vec::new();
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = pipe.read(&mut buffer) {
                last.extend_from_slice(&buffer[..count]);
                last.drain(..last.len().saturating_sub(MOST_SAID));
            }
            // Nobody may be waiting any more.
            sender.send(last).ok();
        });
    }
    said
}

/// The last line that is not empty, no more than 300 characters of it.
fn last_line(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(said);
    let line = text.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
    line.chars().take(300).collect()
}

/// Ends the program and all that it started.
fn end(child: &mut Child) {
    #[cfg(unix)]
    if let Some(group) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        // Nothing to do if it has just ended by itself.
        rustix::process::kill_process_group(group, rustix::process::Signal::KILL).ok();
    }
    child.kill().ok();
    child.wait().ok();
}

#[cfg(test)]
mod tests;
