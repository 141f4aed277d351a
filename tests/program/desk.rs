//! A virtual display with the real window on it, and a hand that finds widgets by what a screen reader reads.
//!
//! Nothing here relies on how fast the window is. It logs what it is at (`pellucid::places`): every wait is for a line of that
//! log, and [`Desk::fence`] is a key without meaning, whose line says that everything sent before it has been dealt with.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::drop_source;

/// The program; `PELLUCID_TEST_PROGRAM` names another build of it, for figures.
pub fn window_program() -> std::ffi::OsString {
    std::env::var_os("PELLUCID_TEST_PROGRAM").unwrap_or_else(|| env!("CARGO_BIN_EXE_pellucid").into())
}

/// How long anything may take: the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(180);
/// What a frame writes into the log.
const FRAME: &str = "shell: frame ";

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// How the names of what is in the editors begin.
const EDITORS: [&str; 4] = ["Opacity point", "Colour point", "Depth curve", "Preset"];

/// Where a widget is, in pixels of the window, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub value: String,
    pub left: i32,
    pub top: i32,
    pub right: i32,
    pub bottom: i32,
}

impl Place {
    pub fn middle(&self) -> [u32; 2] {
        [(self.left + self.right) / 2, (self.top + self.bottom) / 2].map(|v| u32::try_from(v).unwrap_or(0))
    }
}

/// A display with a window on it.
pub struct Desk {
    folder: tempfile::TempDir,
    display: String,
    window: Running,
    _server: Running,
}

/// Whether the tools are there that a display needs.
pub fn tools_are_there() -> bool {
    let missing: Vec<&str> = ["Xvfb", "xdotool", "import"]
        .into_iter()
        .filter(|tool| Command::new(tool).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err())
        .collect();
    assert!(missing.is_empty() || std::env::var_os("CI").is_none(), "missing: {missing:?}");
    if !missing.is_empty() {
        println!("SKIPPED: the window: missing {}", missing.join(", "));
    }
    missing.is_empty()
}

impl Desk {
    /// A window with these files in it, which says where its widgets are.
    pub fn open(files: &[&str]) -> Desk {
        Desk::with_log(files, "warn,pellucid=debug,pellucid::places=trace,rfd=off")
    }

    /// One that does not: for events in great number.
    pub fn open_blind(files: &[&str]) -> Desk {
        Desk::with_log(files, "warn,pellucid=debug,rfd=off")
    }

    fn with_log(files: &[&str], filter: &str) -> Desk {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Command::new("Xvfb")
            // Keys that are held down for long by a busy machine are not repeated.
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-ardelay", "600000"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let server = Running(server);
        let display = format!(":{}", number.trim());
        let log = std::fs::File::create(folder.path().join("log")).unwrap();
        let window = Command::new(window_program())
            .args(files)
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", folder.path())
            .env("XDG_CONFIG_DIRS", folder.path())
            .env_remove("PELLUCID_CONFIG")
            // No desktop: dialogs are lines in the window.
            .env("PATH", "")
            .env("DBUS_SESSION_BUS_ADDRESS", "disabled:")
            .env("RUST_LOG", filter)
            .env("NO_COLOR", "1")
            .env("PELLUCID_TRIALS", "1")
            .stderr(log)
            .spawn()
            .unwrap();
        let desk = Desk { folder, display, window: Running(window), _server: server };
        desk.wait("the first frame", |desk| desk.frames() > 0);
        desk.xdotool("search --sync --name Pellucid windowfocus");
        desk
    }

    pub fn window(&mut self) -> &mut Child {
        &mut self.window.0
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn log(&self) -> String {
        String::from_utf8_lossy(&std::fs::read(self.path("log")).unwrap()).into_owned()
    }

    /// The end of the log without what says where things are.
    fn tail(&self) -> String {
        let log = self.log();
        let lines: Vec<&str> = log.lines().filter(|l| !l.starts_with("  ")).collect();
        lines[lines.len().saturating_sub(60)..].join("\n")
    }

    /// Waits for something, with what has been logged if it never comes.
    pub fn wait(&self, what: &str, done: impl Fn(&Desk) -> bool) {
        assert!(self.comes(PATIENCE, done), "{what} never came:\n{}", self.tail());
    }

    fn comes(&self, limit: Duration, done: impl Fn(&Desk) -> bool) -> bool {
        let begin = Instant::now();
        while !done(self) {
            if begin.elapsed() > limit {
                return false;
            }
            std::thread::sleep(Duration::from_millis(40));
        }
        true
    }

    /// Waits until this is in the log.
    pub fn wait_for(&self, fact: &str) {
        self.wait(fact, |desk| desk.log().contains(fact));
    }

    /// Tries again until the number is 0 or the time is over.
    pub fn until(&self, limit: Duration, number: impl Fn() -> usize) -> usize {
        let begin = Instant::now();
        loop {
            let n = number();
            if n == 0 || begin.elapsed() > limit {
                return n;
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    pub fn xdotool(&self, words: &str) {
        let status = Command::new("xdotool").args(words.split(' ')).env("DISPLAY", &self.display).status().unwrap();
        assert!(status.success(), "xdotool {words}\n{}", self.tail());
    }

    /// Waits until everything sent so far has been dealt with, and a frame drawn after that.
    pub fn fence(&self) {
        const KEY: &str = "key Named(F12)";
        let before = self.log().matches(KEY).count();
        self.xdotool("key F12");
        self.wait("an answer to a key", |desk| {
            let log = desk.log();
            log.match_indices(KEY).nth(before).is_some_and(|(at, _)| log[at..].contains(FRAME))
        });
    }

    /// The number of the last order, and the viewport: left, top, width, height.
    pub fn last_order(&self) -> Option<(u64, [u32; 4])> {
        let log = self.log();
        let line = log.lines().rfind(|l| l.contains("order ") && l.contains("viewport"))?;
        let rest = &line[line.rfind("order ")?..];
        let numbers: Vec<u64> = rest.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
        match numbers[..] {
            [number, x, y, w, h] => Some((number, [x, y, w, h].map(|n| n as u32))),
            _ => None,
        }
    }

    /// Waits until nothing changes any more and the exact picture of what is seen is on the screen.
    pub fn settle(&self) {
        let exact = |desk: &Desk| {
            let log = desk.log();
            let shown = log.lines().rfind(|l| l.contains("places: shown "))?;
            let (number, _) = desk.last_order()?;
            shown.ends_with(&format!("exact {number} of {number}")).then_some(number)
        };
        loop {
            self.fence();
            self.wait("the exact picture", |desk| exact(desk).is_some());
            let number = exact(self);
            self.fence();
            if number.is_some() && exact(self) == number {
                return;
            }
        }
    }

    pub fn frames(&self) -> usize {
        self.log().matches(FRAME).count()
    }

    /// Holds that no frame is drawn for five seconds.
    pub fn rests(&self, when: &str) {
        let quiet = Duration::from_millis(1500);
        self.wait("rest", |desk| {
            let frames = desk.frames();
            std::thread::sleep(quiet);
            desk.frames() == frames
        });
        let frames = self.frames();
        std::thread::sleep(Duration::from_secs(5));
        assert_eq!(self.frames(), frames, "frames {when}:\n{}", self.tail());
    }

    /// All widgets of this name, as the last frame has them.
    pub fn find_all(&self, name: &str) -> Vec<Place> {
        let wanted = format!("{name:?}");
        self.find_by(|found| found == wanted)
    }

    fn find_by(&self, named: impl Fn(&str) -> bool) -> Vec<Place> {
        let log = self.log();
        let Some(end) = log.rfind("\nend of tree") else {
            return Vec::new();
        };
        let begin = log[..end].rfind("places: tree\n").unwrap_or(0);
        let line = |line: &str| {
            let words: Vec<&str> = line.split('\t').collect();
            let [_, found, value, place] = words[..] else {
                return None;
            };
            let sides: Vec<i32> = place.split(' ').filter_map(|n| n.parse().ok()).collect();
            let [left, top, right, bottom] = sides[..] else {
                return None;
            };
            let value = value.trim_matches('"').to_owned();
            named(found).then_some(Place { value, left, top, right, bottom })
        };
        log[begin..end].lines().filter_map(line).collect()
    }

    pub fn find(&self, name: &str) -> Option<Place> {
        self.find_all(name).pop()
    }

    /// The same; the name may go on with keys, as those of menus do.
    fn find_named(&self, name: &str) -> Option<Place> {
        self.find(name).or_else(|| self.find_by(|found| found.starts_with(&format!("\"{name}"))).pop())
    }

    /// Where a widget is, once it is there and scrolled into sight.
    pub fn place(&self, name: &str) -> Place {
        self.fence();
        self.wait(name, |desk| desk.find_named(name).is_some());
        for _ in 0..40 {
            let (place, picture) = (self.find_named(name).unwrap(), self.find("Viewport").unwrap());
            let x = (place.left + place.right) / 2;
            // What lies below the panels beside the picture is scrolled out of them, or in the editors.
            let in_a_panel = (x > picture.right || x < picture.left) && !EDITORS.iter().any(|n| name.starts_with(n));
            if !in_a_panel
                || place.bottom <= picture.bottom && (place.top >= picture.top || place.bottom <= picture.top)
            {
                return place;
            }
            let turn = if place.bottom > picture.bottom { 5 } else { 4 };
            self.xdotool(&format!("mousemove {x} {} click {turn}", (picture.top + picture.bottom) / 2));
            self.fence();
        }
        panic!("'{name}' cannot be scrolled into sight: {:?}\n{}", self.find(name), self.tail());
    }

    /// Where a slider is, the `nth` of this name, and how many clicks of the wheel over the panel beside the picture brought it
    /// into sight.
    pub fn slider(&self, name: &str, nth: usize) -> (Place, u32) {
        // The widest of what has a name: a label and a number are beside it.
        let find = |desk: &Desk| desk.find_all(name).into_iter().filter(|p| p.right - p.left > 80).nth(nth);
        for clicks in 0..60 {
            self.rest_a_little();
            let picture = self.find("Viewport").unwrap();
            match find(self) {
                Some(place) if place.bottom <= picture.bottom && place.top >= picture.top => return (place, clicks),
                _ => self.wheel_down(1),
            }
        }
        panic!("slider {nth} '{name}' cannot be scrolled into sight: {:?}\n{}", find(self), self.tail());
    }

    /// Turns the wheel over the panel to the right of the picture.
    pub fn wheel_down(&self, clicks: u32) {
        let (_, [x, y, w, h]) = self.last_order().unwrap();
        self.xdotool(&format!("mousemove {} {}", x + w + 60, y + h / 2));
        for _ in 0..clicks {
            self.xdotool("click 5");
            self.rest_a_little();
        }
    }

    /// Until what scrolls smoothly has come to rest.
    fn rest_a_little(&self) {
        self.fence();
        std::thread::sleep(Duration::from_millis(250));
        self.fence();
    }

    /// Clicks, and waits until that has been dealt with.
    pub fn click(&self, [x, y]: [u32; 2], button: u8) {
        self.xdotool(&format!("mousemove {x} {y}"));
        self.fence();
        self.xdotool(&format!("click {button}"));
        self.fence();
    }

    /// Clicks on a widget.
    pub fn press(&self, name: &str) {
        self.click(self.place(name).middle(), 1);
    }

    /// Drags with the left button, so slowly that every step is seen.
    pub fn drag(&self, [x, y]: [u32; 2], [right, down]: [i32; 2]) {
        self.xdotool(&format!("mousemove {x} {y}"));
        self.fence();
        self.xdotool("mousedown 1");
        self.fence();
        for i in 1..=5 {
            let at = |from: u32, by: i32| from as i32 + by * i / 5;
            self.xdotool(&format!("mousemove {} {}", at(x, right), at(y, down)));
            self.fence();
        }
        self.xdotool("mouseup 1");
        self.fence();
    }

    /// Presses a key until this is in the log once more.
    pub fn key_until(&self, key: &str, fact: &str) {
        let before = self.log().matches(fact).count();
        for _ in 0..50 {
            self.xdotool(&format!("key {key}"));
            self.fence();
            if self.log().matches(fact).count() > before {
                return;
            }
        }
        panic!("{key} never led to '{fact}':\n{}", self.tail());
    }

    /// Presses a key that asks for a path, and types it.
    pub fn type_path(&self, key: &str, path: &Path) {
        let text = path.to_str().unwrap();
        let asked = |desk: &Desk| desk.find("Path").is_some();
        let soon = Duration::from_secs(20);
        // A dialog that takes long to fail is taken for one that was closed.
        let asks = (0..5).any(|_| {
            self.xdotool(&format!("key {key}"));
            self.comes(soon, asked)
        });
        assert!(asks, "no path is asked for:\n{}", self.tail());
        let typed = (0..5).any(|_| {
            self.fence();
            self.xdotool("key ctrl+a");
            self.xdotool(&format!("type --delay 8 {text}"));
            self.comes(soon, |desk| desk.find("Path").is_some_and(|p| p.value == text))
        });
        assert!(typed, "the path cannot be typed: {:?}\n{}", self.find("Path"), self.tail());
        self.xdotool("key Return");
        self.wait("the end of the question", |desk| !asked(desk));
    }

    /// Waits for messages and dismisses them.
    pub fn dismiss(&self) {
        self.fence();
        if self.find("Dismiss").is_some() {
            self.xdotool("key Escape");
            self.wait("the end of the messages", |desk| desk.find("Dismiss").is_none());
        }
    }

    /// What is on the display.
    pub fn screenshot(&self, name: &str) -> image::RgbImage {
        let path = self.path(&format!("{name}-screen.png"));
        let taken = Command::new("import").args(["-window", "root"]).arg(&path).env("DISPLAY", &self.display).status();
        assert!(taken.unwrap().success());
        image::open(&path).unwrap().into_rgb8()
    }

    /// Drops a file on the window, as a file manager does.
    pub fn drop_file(&self, path: &Path) {
        let search = || {
            let found =
                Command::new("xdotool").args(["search", "--name", "Pellucid"]).env("DISPLAY", &self.display).output();
            let found = String::from_utf8(found.unwrap().stdout).unwrap();
            found.lines().next().and_then(|l| l.trim().parse().ok())
        };
        // A search ends with an error where a window goes while it looks, as that of an earlier drop may.
        let window =
            (0..10).find_map(|_| search()).unwrap_or_else(|| panic!("there is no window any more:\n{}", self.tail()));
        drop_source::drop_file(&self.display, window, path).unwrap();
    }

    /// Closes the window by its key: it ends well and has not said anything bad.
    pub fn quit(mut self) {
        assert!(!self.log().contains("ERROR"), "{}", self.tail());
        self.end();
    }

    /// The same after something bad.
    pub fn quit_whatever_was_said(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.xdotool("key ctrl+q");
        let status = self.window.0.wait().unwrap();
        assert!(status.success(), "{}", self.tail());
    }
}
