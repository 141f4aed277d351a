//! The bytes of a file: read, or mapped where they are many.
//!
//! Reading a large file costs a copy and as much memory again; a mapping costs neither and lets threads touch different
//! parts of it at once. Its price: the bytes are the file's own. Whoever changes the file while it is read changes the bytes
//! under the reader, which is harmless here, because every number is checked as it is taken and no text is believed to be
//! UTF-8 before it is looked at; the scene may be a mixture of both states. Whoever **shortens** it while it is read makes
//! the system end the program (`SIGBUS` on Unix; Windows refuses to shorten a mapped file). Exporters that write to a new
//! file and rename it are safe. Where a file is read because it has just changed, it is not mapped
//! ([`ImportOptions::map_from`](super::ImportOptions::map_from) = `u64::MAX`).

use std::fs::File;
use std::io::Read;
use std::ops::Deref;
use std::path::Path;

use memmap2::Mmap;

use super::{Fallible, Fault, ImportOptions, Phase};

/// So many bytes are read at once.
const PIECE: u64 = 1 << 20;

/// Called after each piece of a file with the number of bytes that are there; tells them, and ends the reading where the
/// import was called off.
pub(super) type Meanwhile<'a> = &'a dyn Fn(u64) -> Fallible<()>;

/// A whole file.
#[derive(Debug)]
pub(super) enum Source {
    /// In memory.
    Read(Vec<u8>),
    /// In the system's cache.
    Mapped(Mmap),
}

impl Deref for Source {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Source::Read(bytes) => bytes,
            Source::Mapped(map) => map,
        }
    }
}

/// The file at `path`, if it is a plain one and not larger than the limit. From [`ImportOptions::map_from`] bytes on it is
/// mapped; else it is read piece by piece, and told how much of it is there.
pub(super) fn open(path: &Path, options: &ImportOptions) -> Fallible<Source> {
    options.progress.tell(Phase::Reading, 0.0);
    let limit = options.limits.bytes;
    let (file, length) = open_plain(path, limit, "file")?;
    if length >= options.map_from.max(1) {
        // SAFETY: the mapping is read-only and private to this process. That others change the file meanwhile cannot be
        // excluded; the module's text says what then happens. No reader relies on two reads giving the same bytes for
        // memory safety: they slice the mapping, whose length is fixed, and check what they take.
        #[expect(unsafe_code, reason = "a mapping has no safe interface, because the file may change")]
        let map = unsafe { Mmap::map(&file) };
        if let Ok(map) = map {
            return Ok(Source::Mapped(map));
        }
        // Some file systems cannot map.
    }
    let meanwhile = |read: u64| {
        options.progress.tell(Phase::Reading, read as f32 / length.max(1) as f32);
        options.cancel.go_on()
    };
    Ok(Source::Read(read_all(file, length, limit, "file", &meanwhile)?))
}

/// The bytes of a plain file, called `place` in errors, of at most `limit` bytes.
pub(super) fn read_plain(path: &Path, limit: u64, place: &str, meanwhile: Meanwhile) -> Fallible<Vec<u8>> {
    let (file, length) = open_plain(path, limit, place)?;
    read_all(file, length, limit, place, meanwhile)
}

fn open_plain(path: &Path, limit: u64, place: &str) -> Fallible<(File, u64)> {
    let io = |source| Fault::Io { place: place.to_owned(), source };
    // Asked before opening: opening a pipe would wait.
    if !path.metadata().map_err(io)?.is_file() {
        return Err(Fault::invalid(place, "is not a plain file"));
    }
    let file = File::open(path).map_err(io)?;
    let length = file.metadata().map_err(io)?.len();
    if length > limit {
        return Err(Fault::limit(place, "bytes", length, limit));
    }
    Ok((file, length))
}

/// All bytes of `file`, which has said that it has `length`.
fn read_all(file: File, length: u64, limit: u64, place: &str, meanwhile: Meanwhile) -> Fallible<Vec<u8>> {
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // It may have grown since.
    let mut rest = file.take(limit.saturating_add(1));
    loop {
        let read = rest.by_ref().take(PIECE).read_to_end(&mut bytes);
        if read.map_err(|source| Fault::Io { place: place.to_owned(), source })? == 0 {
            break;
        }
        meanwhile(bytes.len() as u64)?;
    }
    if bytes.len() as u64 > limit {
        return Err(Fault::limit(place, "bytes", bytes.len() as u64, limit));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::import::{Cancel, Limits, Progress};

    fn options(bytes: u64, map_from: u64) -> ImportOptions {
        ImportOptions { limits: Limits { bytes, ..Limits::default() }, map_from, ..ImportOptions::default() }
    }

    #[test]
    fn read_and_mapped_files_have_the_same_bytes_and_limits_hold() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        std::fs::write(&path, b"twelve bytes").expect("written");
        let read = open(&path, &options(12, u64::MAX)).expect("read");
        let mapped = open(&path, &options(12, 12)).expect("mapped");
        assert!(matches!(read, Source::Read(_)) && matches!(mapped, Source::Mapped(_)));
        assert_eq!(*read, *mapped);
        assert!(matches!(open(&path, &options(11, 1)), Err(Fault::Limit { .. })));
        std::fs::write(&path, b"").expect("written");
        assert!(open(&path, &options(12, 0)).expect("an empty file is read, not mapped").is_empty());
        assert!(matches!(open(folder.path(), &options(12, 1)), Err(Fault::Invalid { .. })));
    }

    #[test]
    fn a_file_that_is_read_piece_by_piece_tells_how_far_and_can_be_called_off() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        let content: Vec<u8> = (0..3 * PIECE + 5).map(|i| i as u8).collect();
        std::fs::write(&path, &content).expect("written");
        let shares: Arc<Mutex<Vec<f32>>> = Arc::default();
        let heard = Arc::clone(&shares);
        let told = move |phase, share| {
            assert_eq!(phase, Phase::Reading);
            heard.lock().expect("not poisoned").push(share);
        };
        let options = ImportOptions { progress: Progress::to(told), ..options(1 << 30, u64::MAX) };
        assert_eq!(*open(&path, &options).expect("read"), content[..]);
        let shares = shares.lock().expect("not poisoned");
        assert_eq!((shares.len(), shares[0], shares[4]), (5, 0.0, 1.0));
        assert!(shares.is_sorted(), "{shares:?}");

        let cancel = Cancel::default();
        let caller = cancel.clone();
        let progress = Progress::to(move |_, share| {
            assert!(share < 0.5, "it reads on");
            if share > 0.0 {
                caller.cancel();
            }
        });
        let options = ImportOptions { progress, cancel: cancel.clone(), ..options.clone() };
        assert!(matches!(open(&path, &options), Err(Fault::Cancelled)));
        // What the model refers to is no longer read either.
        assert!(matches!(read_plain(&path, 1 << 30, "buffer", &|_| cancel.go_on()), Err(Fault::Cancelled)));
    }
}
