//! Where output goes: data to standard output or into files, progress to a terminal.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::failure::{Exit, Failure};
use crate::import::Phase;

/// Writes data to standard output. A reader that has gone away is no failure.
///
/// # Errors
/// [`Exit::General`] if standard output cannot be written.
pub fn print(data: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(data).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::about(Exit::General, "standard output", &e))
        }
        _ => Ok(()),
    }
}

/// Writes a value as indented JSON and a line's end.
///
/// # Errors
/// [`Exit::General`] if the value has no JSON form; none does today.
pub fn json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map(|text| text + "\n").map_err(|e| Failure::of(Exit::General, &e))
}

/// Says before the work that a file could not be written for want of its folder.
///
/// # Errors
/// [`Exit::General`] with the path and the cause.
pub fn check(target: &Path) -> Result<(), Failure> {
    let folder = target.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let cause = match std::fs::metadata(folder) {
        _ if target.file_name().is_none() => "not a file name".to_owned(),
        Ok(m) if m.is_dir() && !target.is_dir() => return Ok(()),
        Ok(m) if m.is_dir() => "is a folder".to_owned(),
        Ok(_) => format!("{} is not a folder", folder.display()),
        Err(e) => e.to_string(),
    };
    Err(Failure::new(Exit::General, format!("{}: {cause}", target.display())))
}

/// Writes `data` to standard output for `-`, else to a file, whole or not at all.
///
/// # Errors
/// [`Exit::General`] with the path and the cause.
pub fn write(target: &Path, data: &[u8]) -> Result<(), Failure> {
    if target == Path::new("-") {
        return print(data);
    }
    write_file(target, data).map_err(|e| Failure::about(Exit::General, target.display(), &e))
}

fn write_file(target: &Path, data: &[u8]) -> std::io::Result<()> {
    // Through a link to what it names; a pipe or a device is written to, not replaced.
    let real = std::fs::canonicalize(target).unwrap_or_else(|_| target.to_path_buf());
    if std::fs::metadata(&real).is_ok_and(|m| !m.is_file()) {
        return std::fs::OpenOptions::new().write(true).open(&real)?.write_all(data);
    }
    let name = real.file_name().ok_or_else(|| std::io::Error::other("not a file name"))?;
    let unfinished: PathBuf = real.with_file_name(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
    let written = std::fs::File::create(&unfinished)
        .and_then(|mut file| file.write_all(data).and_then(|()| file.sync_data()))
        .and_then(|()| std::fs::rename(&unfinished, &real));
    if written.is_err() {
        let _ = std::fs::remove_file(&unfinished);
    }
    written
}

/// Writes a line to standard error. Nobody may be listening there; that is no reason to lose a picture.
pub fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Steps of the bar of an import.
const STEPS: u64 = 1000;

fn spinner() -> ProgressStyle {
    ProgressStyle::with_template("{spinner} {msg} {elapsed}").unwrap_or_else(|_| ProgressStyle::default_spinner())
}

/// Shows what the program is busy with, if standard error is a terminal.
pub struct Progress(Option<ProgressBar>);

impl Progress {
    /// Nothing is shown yet.
    pub fn new() -> Progress {
        Progress(std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner();
            bar.set_style(spinner());
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        }))
    }

    /// Says what is being done now.
    pub fn stage(&self, what: &str) {
        if let Some(bar) = &self.0 {
            if bar.length().is_some() {
                bar.unset_length();
                bar.set_style(spinner());
            }
            bar.set_message(what.to_owned());
        }
    }

    /// Says which of how many things is being done, with a bar.
    pub fn count(&self, done: usize, of: usize, what: &str) {
        if let Some(bar) = &self.0 {
            if bar.length() != Some(of as u64) {
                bar.set_length(of as u64);
                if let Ok(style) = ProgressStyle::with_template("{spinner} {bar:24} {pos}/{len} {msg} {elapsed}") {
                    bar.set_style(style);
                }
            }
            bar.set_position(done as u64);
            bar.set_message(what.to_owned());
        }
    }

    /// What shows the phases of an import, as they are told from its threads.
    pub fn importing(&self, file: &str) -> impl Fn(Phase, f32) + Send + Sync + 'static {
        let (bar, file) = (self.0.clone(), file.to_owned());
        move |phase, done| {
            let Some(bar) = &bar else { return };
            if bar.length() != Some(STEPS) {
                bar.set_length(STEPS);
                if let Ok(style) = ProgressStyle::with_template("{spinner} {bar:24} {percent:>3} % {msg} {elapsed}") {
                    bar.set_style(style);
                }
            }
            bar.set_position((f64::from(done) * STEPS as f64) as u64);
            bar.set_message(format!("{file}: {}", phase.name()));
        }
    }

    /// Writes a line to standard error above the spinner.
    pub fn say(&self, line: &str) {
        let line = super::failure::printable(line);
        match &self.0 {
            Some(bar) => bar.suspend(|| complain(&line)),
            None => complain(&line),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// 1234567 as `1 234 567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole_and_links_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.png");
        write(&file, b"one").unwrap();
        write(&file, b"two").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"two");
        #[cfg(unix)]
        {
            let link = folder.path().join("link.png");
            std::os::unix::fs::symlink(&file, &link).unwrap();
            write(&link, b"three").unwrap();
            assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(std::fs::read(&file).unwrap(), b"three");
            write(Path::new("/dev/null"), b"four").unwrap();
            std::fs::remove_file(&link).unwrap();
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
        assert!(check(&file).is_ok() && check(Path::new("-")).is_ok() && check(Path::new("new.png")).is_ok());
        for bad in [folder.path().to_path_buf(), file.join("x"), folder.path().join("no/a.png"), PathBuf::from("..")] {
            assert!(check(&bad).is_err(), "{bad:?}");
        }
        let missing = folder.path().join("no/such/a.png");
        let failure = write(&missing, b"x").unwrap_err();
        assert_eq!(failure.exit, Exit::General);
        assert!(failure.message.contains("no/such/a.png"), "{failure:?}");
    }

    #[test]
    fn numbers_are_grouped() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1 000", "1 234 567"]);
    }
}
