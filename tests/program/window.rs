//! The real window on a virtual display: what is seen in it is what the command line draws.
//!
//! Needs Xvfb, xdotool and ImageMagick's `import`; without them the tests say so and are skipped, except where `CI` is set.

use std::process::Command;
use std::time::{Duration, Instant};

use glam::DVec3;
use pellucid::export::glb::write_glb;
use pellucid::render::Renderer;
use pellucid::scene::{Presence, Scene, builtin};
use pellucid::session::{Session, camera_in_scene};

use super::desk::{Desk, tools_are_there, window_program};
use super::support::{full, gpu, repository};

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

fn text(desk: &Desk, step: &str) -> String {
    std::fs::read_to_string(desk.path(&format!("{step}.toml"))).unwrap()
}

/// Saves what is seen as a session, through the line that stands in for the dialog.
fn save(desk: &Desk, step: &str) {
    let session = desk.path(&format!("{step}.toml"));
    desk.type_path("ctrl+s", &session);
    desk.wait("the session", |desk| desk.log().contains(&format!("{} is written", session.display())));
    desk.dismiss();
}

/// What is seen, saved as a session and rendered by the command line, is the screenshot of the viewport bit for bit.
fn compare(desk: &Desk, step: &str) {
    // What lies under a resting cursor would be listed over the picture.
    desk.xdotool("mousemove 640 796");
    desk.settle();
    save(desk, step);
    let rendered = desk.path(&format!("{step}.png"));
    let session = desk.path(&format!("{step}.toml"));
    let output = Command::new(window_program())
        .arg("render")
        .arg("--session")
        .arg(&session)
        .arg("-o")
        .arg(&rendered)
        .output()
        .unwrap();
    assert!(output.status.success(), "{step}: {}", String::from_utf8_lossy(&output.stderr));
    let expected = image::open(&rendered).unwrap().into_rgb8();
    desk.settle();
    let (_, [x, y, w, h]) = desk.last_order().unwrap();
    assert_eq!((w, h), expected.dimensions(), "{step}");
    // A frame that is presented is on the screen a moment later.
    let different = desk.until(Duration::from_secs(10), || {
        let seen = image::imageops::crop_imm(&desk.screenshot(step), x, y, w, h).to_image();
        seen.pixels().zip(expected.pixels()).filter(|(a, b)| a != b).count()
    });
    assert_eq!(different, 0, "{step}: pixels differ");
    let background = expected.get_pixel(0, 0);
    assert!(expected.pixels().any(|p| p != background), "{step}: nothing is seen");
}

/// A pixel of the viewport whose third layer is of another part than the two before it, that part, which is what is behind a
/// wall, and how many parts are in front of it.
fn third_part(desk: &Desk, step: &str, scene: &Scene) -> ([u32; 2], u32, usize) {
    let session = Session::from_toml(&text(desk, step)).unwrap().resolve(scene).unwrap();
    let mut renderer = Renderer::new(gpu("what lies under a pixel").unwrap()).unwrap();
    let uploaded = renderer.load(scene).unwrap();
    let camera = camera_in_scene(&session.camera, scene);
    let [w, h] = session.size;
    for i in 0..64 {
        let pixel = [w / 4 + (i % 8) * w / 16, h / 4 + (i / 8) * h / 16];
        let layers = renderer.pick(&uploaded, &camera, &session.settings, session.size, pixel).unwrap();
        let parts: Vec<u32> = layers.iter().take(3).map(|l| l.part).collect();
        if let [a, b, c] = parts[..]
            && c != a
            && c != b
        {
            return (pixel, c, if a == b { 1 } else { 2 });
        }
    }
    panic!("no pixel with another part behind a wall");
}

#[test]
fn the_window_shows_what_the_command_line_draws() {
    if !tools_are_there() || gpu("the window").is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let file = |name: &str| {
        let path = place.path().join(format!("{name}.glb"));
        std::fs::write(&path, write_glb(&builtin::build(name).unwrap()).unwrap()).unwrap();
        path
    };
    let (first, second) = (file("stack"), file("gearbox"));
    let desk = Desk::open(&[first.to_str().unwrap()]);
    desk.wait_for(&format!("opened {}", first.display()));
    compare(&desk, "argument");

    // Another file, by the line to type a path into.
    desk.type_path("ctrl+o", &second);
    desk.wait_for(&format!("opened {}", second.display()));
    compare(&desk, "opened");

    // Turned by the mouse.
    let (_, [x, y, w, h]) = desk.last_order().unwrap();
    desk.drag([x + w / 2, y + h / 2], [110, 50]);
    compare(&desk, "turned");
    assert_ne!(text(&desk, "turned"), text(&desk, "opened"));

    // A point of the opacity curve is dragged upwards, in the editor.
    let point = desk.place("Opacity point 2").middle();
    desk.drag(point, [6, -50]);
    compare(&desk, "edited");
    assert!(text(&desk, "edited").contains("points = [") && !text(&desk, "turned").contains("points = ["));

    // Clicks on one pixel go through the parts there: that of the third layer is chosen. What is in the file is asked
    // without the window.
    let scene = pellucid::import::load(&second).unwrap();
    let (pixel, third, before) = third_part(&desk, "edited", &scene);
    let at = [x + pixel[0], y + pixel[1]];
    desk.click(at, 1);
    desk.wait_for(&format!("layers found at {pixel:?} for Select"));
    for _ in 0..before {
        // Not as fast as a double-click.
        std::thread::sleep(Duration::from_millis(500));
        desk.click(at, 1);
    }
    compare(&desk, "picked");
    let arrangement = |step: &str| {
        let session = Session::from_toml(&text(&desk, step)).unwrap().resolve(&scene).unwrap();
        session.arrangement
    };
    assert_eq!(arrangement("picked").selected, [third].into());

    // The list under the right button isolates it.
    desk.click(at, 3);
    desk.wait_for(&format!("layers found at {pixel:?} for List"));
    desk.press("Isolate the selection");
    compare(&desk, "isolated");
    for part in 0..scene.parts.len() as u32 {
        let expected = if part == third { Presence::Shown } else { Presence::Ghosted };
        assert_eq!(arrangement("isolated").look(part).presence, expected, "{part}");
    }

    // A section, added and moved.
    for heading in ["1  Capture", "3  Opacity", "Sections"] {
        desk.press(heading);
    }
    desk.press("Add a section across x");
    // Its handles come with it: one is pulled, and they are put away, because they are no part of the picture.
    let handle = desk.place("Pull section 1").middle();
    desk.xdotool("key x");
    compare(&desk, "cut");
    desk.xdotool("key x");
    desk.fence();
    desk.drag(handle, [40, 10]);
    desk.xdotool("key x");
    compare(&desk, "pulled");
    let place = desk.place("Position of section 1");
    desk.drag(place.middle(), [30, 0]);
    compare(&desk, "moved");
    let [cut, pulled, moved] = ["cut", "pulled", "moved"].map(|step| arrangement(step).sections);
    assert!([&cut, &pulled, &moved].iter().all(|s| s[0].normal == DVec3::X));
    assert!(pulled[0].offset != cut[0].offset && moved[0].offset > pulled[0].offset);

    // Undone step by step to what was opened, and done again.
    desk.key_until("ctrl+z", "undone");
    compare(&desk, "back");
    assert_eq!(text(&desk, "back"), text(&desk, "pulled"));
    desk.key_until("ctrl+z", "nothing to undo");
    compare(&desk, "undone");
    assert_eq!(text(&desk, "undone"), text(&desk, "opened"));
    desk.key_until("ctrl+shift+z", "nothing to redo");
    compare(&desk, "redone");
    assert_eq!(text(&desk, "redone"), text(&desk, "moved"));
    desk.quit();
}

/// Nothing moves by itself: no frame is drawn in five seconds, whatever is open and wherever the cursor rests.
#[test]
fn at_rest_nothing_is_drawn() {
    if !tools_are_there() || gpu("the window at rest").is_none() {
        return;
    }
    let desk = Desk::open(&["builtin:stack"]);
    desk.settle();
    desk.rests("after the exact picture");
    let (_, [x, y, w, h]) = desk.last_order().unwrap();
    let middle = [x + w / 2, y + h / 2];
    desk.xdotool(&format!("mousemove {} {}", middle[0], middle[1]));
    desk.wait_for("for Hover");
    desk.rests("with the cursor over the picture");
    desk.click(middle, 1);
    desk.wait_for("for Select");
    desk.settle();
    desk.rests("with a part selected and the cursor over it");
    // Every heading of the stages, then everything that floats.
    for heading in ["2  Features", "Light", "Outline of the selection", "Picture", "Sections", "Plan"] {
        desk.press(heading);
    }
    for (key, what) in [
        ("F1", "Keyboard and mouse"),
        ("m", "Measure"),
        ("ctrl+shift+p", "Write pictures"),
        ("ctrl+d", "Name of the view"),
    ] {
        desk.xdotool(&format!("key {key}"));
        desk.wait(what, |desk| desk.find(what).is_some());
    }
    desk.settle();
    desk.rests("with every panel open");
    // In a field, where other programs let a cursor blink, and on a button, until its help has come.
    desk.press("Search parts");
    desk.rests("with a cursor in a text");
    desk.press("File");
    let save = desk.place("Save session…").middle();
    desk.xdotool(&format!("mousemove {} {}", save[0], save[1]));
    desk.rests("with a menu open");
    desk.quit();
}

/// A lost surface and a lost device are made anew, and the window looks as before: letters, thumbnails and picture.
#[test]
fn what_is_lost_is_opened_again() {
    if !tools_are_there() || gpu("a lost device").is_none() {
        return;
    }
    if !cfg!(debug_assertions) {
        return println!("SKIPPED: a lost device: the keys that lose it are in no release build");
    }
    let desk = Desk::open(&["builtin:gearbox"]);
    desk.xdotool("mousemove 640 796");
    desk.settle();
    let before = desk.screenshot("before");
    let again = "workspace: The graphics device was lost and has been opened again.";
    // Twice the device: what was mended once has to be mended the next time too.
    for (n, (key, fact)) in
        [("F9", "surface was lost and is made anew"), ("F8", again), ("F8", again)].into_iter().enumerate()
    {
        desk.xdotool(&format!("key {key}"));
        let times = 1 + usize::from(n == 2);
        desk.wait(fact, |desk| desk.log().matches(fact).count() >= times);
        desk.settle();
        if key == "F8" {
            let said = desk.find_all("Dismiss").len();
            assert_eq!(said, 1, "one message at most\n{}", desk.log());
            desk.dismiss();
        }
        let different = desk.until(Duration::from_secs(10), || {
            let after = desk.screenshot("after");
            after.pixels().zip(before.pixels()).filter(|(a, b)| a != b).count()
        });
        assert_eq!(different, 0, "after loss {n}");
    }
    // Sizes at the ends of what is possible, and back.
    for size in ["1 1", "20000 40", "1280 1", "1280 800"] {
        desk.xdotool(&format!("search --name Pellucid windowsize {size}"));
        desk.fence();
    }
    desk.settle();
    desk.dismiss();
    compare(&desk, "resized");
    let log = desk.log();
    assert!(!log.contains("panicked") && !log.to_lowercase().contains("validation"), "{log}");
    desk.quit_whatever_was_said();
}

/// Real events, as they come: 100 by default, 2 000 in all with `PELLUCID_TEST_FULL`.
#[test]
fn random_events_break_nothing() {
    if !tools_are_there() || gpu("random events in the window").is_none() {
        return;
    }
    let (seed, count) = (11, if full() { 2000 } else { 100 });
    let begin = Instant::now();
    let mut desk = Desk::open_blind(&["builtin:stack"]);
    desk.settle();
    let files = ["good.glb", "half.glb", "broken.glb", "broken.toml"].map(|name| desk.path(name));
    let good = write_glb(&builtin::build("stack").unwrap()).unwrap();
    for (path, bytes) in
        files.iter().zip([&good[..], &good[..good.len() / 2], b"glTF and nothing else", b"file = 'good.glb'"])
    {
        std::fs::write(path, bytes).unwrap();
    }
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
                let file = &files[numbers.below(files.len() as u32) as usize];
                desk.drop_file(file);
                format!("drop of {}", file.display())
            }
        };
        if !words.starts_with("drop") {
            desk.xdotool(&words);
        }
        done.push(words);
        let tail = || done[done.len().saturating_sub(8)..].join("\n");
        let ended = desk.window().try_wait().unwrap();
        assert!(ended.is_none(), "seed {seed}, event {n}: {ended:?} after\n{}\n{}", tail(), desk.log());
        if n % 50 == 49 {
            // No faster than the window: else most events would find it in the same state.
            desk.fence();
        }
    }
    desk.xdotool("search --name Pellucid windowsize 1280 800");
    desk.xdotool("key Escape");
    desk.fence();
    let log = desk.log();
    let faults = ["panicked", "Validation", "the window's device", "the device failed", "validation error"];
    let found: Vec<&str> = log.lines().filter(|l| faults.iter().any(|f| l.contains(f))).collect();
    assert!(found.is_empty(), "seed {seed}: {found:?}\nafter\n{}", done.join("\n"));
    // After all that a file still opens.
    let opened = || desk.log().matches("opened ").count();
    let before = opened();
    desk.drop_file(&files[0]);
    desk.wait("a file", |_| opened() > before);
    let opened = opened();
    println!("{count} random events in {:.0} s, {opened} files opened", begin.elapsed().as_secs_f64());
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
    let output = Command::new(window_program())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("pellucid: no window can be opened: ") && said.lines().count() == 1, "{said}");
    let output = Command::new(window_program()).arg("paint").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
