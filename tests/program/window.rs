//! The real window on a virtual display: what is seen in it is what the command line draws.
//!
//! Needs Xvfb, xdotool and ImageMagick's `import`; without them the test says so and is skipped, except where `CI` is set.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::support::{full, gpu, repository};

const PROGRAM: &str = env!("CARGO_BIN_EXE_pellucid");

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display with a window on it.
struct Desk {
    folder: tempfile::TempDir,
    display: String,
    window: Running,
    _server: Running,
}

fn tools_are_there() -> bool {
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
    fn open(files: &[&str]) -> Desk {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let log = std::fs::File::create(folder.path().join("log")).unwrap();
        let window = Command::new(PROGRAM)
            .args(files)
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", folder.path())
            // No desktop: dialogs are lines in the window.
            .env("PATH", "")
            .env("DBUS_SESSION_BUS_ADDRESS", "disabled:")
            .env("RUST_LOG", "warn,pellucid=debug,rfd=off")
            .env("NO_COLOR", "1")
            .stderr(log)
            .spawn()
            .unwrap();
        Desk { folder, display, window: Running(window), _server: Running(server) }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.path("log")).unwrap()
    }

    /// Waits for something, with what has been logged if it never comes.
    fn wait(&self, what: &str, done: impl Fn(&Desk) -> bool) {
        let begin = Instant::now();
        while !done(self) {
            assert!(begin.elapsed() < Duration::from_secs(90), "{what} never came:\n{}", self.log());
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn xdotool(&self, words: &str) {
        let status = Command::new("xdotool").args(words.split(' ')).env("DISPLAY", &self.display).status().unwrap();
        assert!(status.success(), "xdotool {words}");
        std::thread::sleep(Duration::from_millis(60));
    }

    /// The number of the last order, and the viewport: left, top, width, height.
    fn last_order(&self) -> Option<(u64, [u32; 4])> {
        let log = self.log();
        let line = log.lines().rfind(|l| l.contains("order ") && l.contains("viewport"))?;
        let rest = &line[line.rfind("order ")?..];
        let numbers: Vec<u64> = rest.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
        match numbers[..] {
            [number, x, y, w, h] => Some((number, [x, y, w, h].map(|n| n as u32))),
            _ => None,
        }
    }

    /// Waits until nothing moves and the exact picture of what is seen is on screen.
    fn settle(&self) {
        std::thread::sleep(Duration::from_millis(400));
        self.wait("the exact picture", |desk| {
            let log = desk.log();
            let Some((number, _)) = desk.last_order() else {
                return false;
            };
            let drawn = log.find(&format!("exact {number}:"));
            drawn.is_some_and(|at| log[at..].contains("shell: frame "))
        });
        std::thread::sleep(Duration::from_millis(300));
    }

    fn frames(&self) -> usize {
        self.log().matches("shell: frame ").count()
    }
}

fn rgb(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

/// A generator of numbers that is the same everywhere.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n.max(1))) as u32
    }

    fn of<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len() as u32) as usize]
    }
}

/// What is seen, saved as a session and rendered by the command line, is the screenshot of the viewport bit for bit.
fn compare(desk: &Desk, step: &str) {
    // What lies under a resting cursor would be listed over the picture.
    desk.xdotool("mousemove 640 796");
    desk.settle();
    let session = desk.path(&format!("{step}.toml"));
    desk.xdotool("key ctrl+s");
    // Where there is no dialog, a line to type the path into comes after a moment.
    std::thread::sleep(Duration::from_millis(1500));
    desk.xdotool("key ctrl+a");
    desk.xdotool(&format!("type --delay 20 {}", session.display()));
    desk.xdotool("key Return");
    desk.wait("the session", |_| session.exists());
    std::thread::sleep(Duration::from_millis(400));
    desk.xdotool("key Escape");
    std::thread::sleep(Duration::from_millis(800));
    let shot = desk.path(&format!("{step}-screen.png"));
    let taken = Command::new("import").args(["-window", "root"]).arg(&shot).env("DISPLAY", &desk.display).status();
    assert!(taken.unwrap().success());
    let rendered = desk.path(&format!("{step}.png"));
    let output =
        Command::new(PROGRAM).arg("render").arg("--session").arg(&session).arg("-o").arg(&rendered).output().unwrap();
    assert!(output.status.success(), "{step}: {}", String::from_utf8_lossy(&output.stderr));
    let [x, y, w, h] = desk.last_order().unwrap().1;
    let seen = image::imageops::crop_imm(&rgb(&shot), x, y, w, h).to_image();
    let expected = rgb(&rendered);
    assert_eq!(seen.dimensions(), expected.dimensions(), "{step}");
    let different = seen.pixels().zip(expected.pixels()).filter(|(a, b)| a != b).count();
    assert_eq!(different, 0, "{step}: pixels differ");
    let background = expected.get_pixel(0, 0);
    assert!(expected.pixels().any(|p| p != background), "{step}: nothing is seen");
}

#[test]
fn the_window_shows_what_the_command_line_draws() {
    if !tools_are_there() || gpu("the window").is_none() {
        return;
    }
    let desk = Desk::open(&["builtin:gearbox"]);
    desk.settle();
    desk.xdotool("search --name Pellucid windowfocus");
    compare(&desk, "first");

    // Turned by the mouse.
    desk.xdotool("mousemove 600 300 mousedown 1");
    for i in 1..=12 {
        desk.xdotool(&format!("mousemove {} {}", 600 + 9 * i, 300 + 4 * i));
    }
    desk.xdotool("mouseup 1");
    compare(&desk, "turned");

    // What is under the middle of the picture is selected, then what lies behind it.
    let [x, y, w, h] = desk.last_order().unwrap().1;
    desk.xdotool(&format!("mousemove {} {}", x + w / 2, y + h / 2));
    let before = desk.last_order();
    desk.xdotool("click 1");
    desk.wait("what is under the cursor", |desk| desk.last_order() != before);
    for _ in 0..4 {
        std::thread::sleep(Duration::from_millis(500));
        desk.xdotool("click 1");
    }
    // What is under the cursor is looked up while it rests, and never while a picture is drawn.
    desk.settle();
    compare(&desk, "picked");
    assert!(std::fs::read_to_string(desk.path("picked.toml")).unwrap().contains("selected = ["));

    // Undone, step by step, to the view at first.
    for _ in 0..8 {
        desk.xdotool("key ctrl+z");
    }
    compare(&desk, "undone");
    let text = |name: &str| std::fs::read_to_string(desk.path(name)).unwrap();
    assert_eq!(text("first.toml"), text("undone.toml"));

    // At rest, nothing is drawn.
    desk.settle();
    let frames = desk.frames();
    std::thread::sleep(Duration::from_secs(5));
    assert_eq!(desk.frames(), frames, "frames without input:\n{}", desk.log());

    let mut desk = desk;
    desk.xdotool("key ctrl+q");
    let status = desk.window.0.wait().unwrap();
    assert!(status.success(), "{}", desk.log());
    assert!(!desk.log().contains("ERROR"), "{}", desk.log());
}

/// Real events, as they come: 100 by default, 2 000 in all with `PELLUCID_TEST_FULL`.
#[test]
fn random_events_break_nothing() {
    if !tools_are_there() || gpu("random events in the window").is_none() {
        return;
    }
    let (seed, count) = (11, if full() { 2000 } else { 100 });
    let mut desk = Desk::open(&["builtin:stack"]);
    desk.settle();
    desk.xdotool("search --name Pellucid windowfocus");
    let broken = desk.path("broken.glb");
    std::fs::write(&broken, b"glTF and nothing else").unwrap();
    let mut numbers = Numbers(seed);
    let mut done = Vec::new();
    for n in 0..count {
        let (x, y) = (numbers.below(1280), numbers.below(800));
        let (x1, y1) = (numbers.below(1280), numbers.below(800));
        let words = match numbers.below(12) {
            0..=2 => format!("mousemove {x} {y} click {}", 1 + numbers.below(3)),
            3..=4 => {
                let button = 1 + numbers.below(3);
                format!("mousemove {x} {y} mousedown {button} mousemove {x1} {y1} mouseup {button}")
            }
            5 => format!("mousemove {x} {y} click --repeat 3 {}", 4 + numbers.below(2)),
            // No quitting, and no text that a dialog would write files under.
            6..=8 => {
                let keys = ["f", "c", "i", "g", "h", "H", "m", "v", "l", "1", "3", "5", "7", "9", "F1", "Home", "Tab"];
                format!("key {}", numbers.of(&keys))
            }
            9 => {
                format!("key {}", numbers.of(&["ctrl+z", "ctrl+shift+z", "ctrl+d", "ctrl+shift+p", "Escape", "Return"]))
            }
            10 => {
                // Without a window manager the window takes any size it is given.
                let size = numbers.of(&["1 1", "320 240", "1280 800", "700 799", "900 20", "3000 200"]);
                format!("search --name Pellucid windowsize {size}")
            }
            _ => {
                // A file that is not one, through the line that stands in for the dialog.
                desk.xdotool("key ctrl+o");
                std::thread::sleep(Duration::from_millis(900));
                desk.xdotool("key ctrl+a");
                desk.xdotool(&format!("type --delay 5 {}", broken.display()));
                "key Return".to_owned()
            }
        };
        desk.xdotool(&words);
        done.push(words);
        let tail = || done[done.len().saturating_sub(8)..].join("\n");
        let ended = desk.window.0.try_wait().unwrap();
        assert!(ended.is_none(), "seed {seed}, event {n}: {ended:?} after\n{}\n{}", tail(), desk.log());
    }
    desk.xdotool("search --name Pellucid windowsize 1280 800");
    desk.xdotool("key Escape");
    std::thread::sleep(Duration::from_secs(2));
    let log = desk.log();
    let faults = ["panicked", "Validation", "the window's device", "the device failed", "validation error"];
    let found: Vec<&str> = log.lines().filter(|l| faults.iter().any(|f| l.contains(f))).collect();
    assert!(found.is_empty(), "seed {seed}: {found:?}\nafter\n{}", done.join("\n"));
    // It still answers: a frame is drawn for what is asked of it.
    let frames = desk.frames();
    desk.xdotool("key F1");
    desk.wait("a frame", |desk| desk.frames() > frames);
}

/// What a desktop is given says what the program takes, and the icon is one.
#[test]
fn the_desktop_files_fit_the_program() {
    let folder = repository().join("assets/desktop");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let (entry, types) = (read("pellucid.desktop"), read("pellucid.xml"));
    let line = |key: &str| entry.lines().find_map(|l| l.strip_prefix(key)).unwrap_or_else(|| panic!("{key}"));
    assert_eq!((line("Exec="), line("Icon=")), ("pellucid %F", "pellucid"));
    let document = roxmltree::Document::parse(&types).unwrap();
    let types = document.descendants().filter(|n| n.tag_name().name() == "mime-type");
    let declared: Vec<&str> = types.filter_map(|n| n.attribute("type")).collect();
    let named: Vec<&str> = line("MimeType=").split(';').filter(|t| !t.is_empty()).collect();
    assert_eq!(declared, named);
    let icon = image::open(folder.join("pellucid.png")).unwrap().into_rgba8();
    assert_eq!(icon.dimensions(), (256, 256));
    assert!(icon.get_pixel(0, 0)[3] == 0 && icon.pixels().any(|p| p[3] == 255));
}

#[test]
fn without_a_display_there_is_one_line_and_a_code() {
    let output = Command::new(PROGRAM)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("pellucid: no window can be opened: ") && said.lines().count() == 1, "{said}");
    let output = Command::new(PROGRAM).arg("paint").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
