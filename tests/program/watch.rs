//! `render --watch` through the real binary: files are really changed, and every wait has an end.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use super::place::Place;
use super::support::{boxes, glb, gpu, program};

/// The longest that a picture of a few boxes may take, on a machine that is busy with everything else.
const PATIENCE: Duration = Duration::from_secs(120);

struct Watching {
    child: Child,
    lines: Receiver<String>,
}

impl Watching {
    fn begin(place: &Place, line: &str) -> Watching {
        let mut child = program()
            .current_dir(place.folder.path())
            .args(line.split_whitespace())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = channel();
        let pipe = BufReader::new(child.stderr.take().unwrap());
        std::thread::spawn(move || pipe.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Watching { child, lines }
    }

    fn line(&self) -> String {
        self.lines.recv_timeout(PATIENCE).expect("a line in time")
    }

    /// A line with these words, and all that come before it.
    fn until(&self, words: &str) -> String {
        loop {
            let line = self.line();
            if line.contains(words) {
                return line;
            }
        }
    }

    fn quiet(&self) {
        let more = self.lines.recv_timeout(Duration::from_millis(900));
        assert!(more.is_err(), "nothing has changed: {more:?}");
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

#[test]
fn a_picture_follows_its_files_and_ends_when_told() {
    if gpu("render --watch").is_none() {
        return;
    }
    let place = Place::new();
    let transfer = |opacity: &str| {
        let text = format!(
            "[color]\npoints = [{{ kappa = 0, color = 0.5 }}]\n[opacity]\ncurves = [{{ depth = 0, points = [[0, {opacity}]] }}]\n"
        );
        // As many editors do: another file in its place.
        place.write("look.tmp", text.as_bytes());
        std::fs::rename(place.path("look.tmp"), place.path("look.toml")).unwrap();
    };
    transfer("0.2");
    let mut watching = Watching::begin(&place, "render boxes.glb -o a.png --size 32x32 --transfer look.toml --watch");
    watching.until("boxes.glb: 32×32");
    let first = read(&place.path("a.png"));
    // The picture that it wrote itself, and a file that has nothing to do with it, are no reason for another one.
    place.write("other.txt", b"something");
    watching.quiet();
    transfer("0.8");
    assert!(watching.until("32×32").contains("boxes.glb"));
    let second = read(&place.path("a.png"));
    assert_ne!(first, second);
    // A broken one is said and keeps the picture.
    let (json, binary) = boxes(2);
    let whole = glb(&json, &binary);
    place.write("boxes.glb", &whole[..whole.len() / 2]);
    let said = watching.until("the last picture stays");
    assert!(said.starts_with("pellucid: boxes.glb: "), "{said}");
    assert_eq!(read(&place.path("a.png")), second);
    place.write("boxes.glb", &whole);
    watching.until("32×32");
    assert_ne!(read(&place.path("a.png")), second);
    assert_eq!(std::fs::read_dir(place.folder.path()).unwrap().count(), 4, "nothing unfinished is left");
    #[cfg(unix)]
    {
        let id = watching.child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert_eq!(watching.child.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn what_can_never_work_is_refused_at_once() {
    let place = Place::new();
    place.fails(2, "render boxes.glb --watch --stats -", &["--watch", "-o picture.png"]);
    place.fails(2, "render boxes.glb -o - --watch", &["--watch", "-o picture.png"]);
    place.fails(2, "render - -o a.png --watch", &["standard input"]);
    place.fails(2, "render boxes.glb -o a.png --watch --reference b.png", &["--reference"]);
    place.fails(2, "render boxes.glb -o a.png --watch --preset glass", &["glass"]);
    place.fails(2, "render builtin:nothing -o a.png --watch", &["nothing"]);
}
