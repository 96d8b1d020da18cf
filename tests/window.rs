//! The real program in a real window on an X server of its own, with real keys and a real pointer.
//!
//! What the program has done is seen in the files that it writes; a time passes only where nothing is to happen meanwhile. The deadlines only end a
//! test that would never end.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::Duration;

use glam::{DVec2, DVec3};
use motion::{Method, PhysicsBody};
use render::Image;
use sandbox::clock::FrameClock;
use sandbox::input::{Button, InputFrame};
use sandbox::player::Player;
use sandbox::report::state_hash;
use sandbox::{Mode, Options, Order, Session};
use scene::{Action, InputAction, MouseButton, Recording, Script};
use tempfile::TempDir;

use crate::rigs::{
    Cockpit, Difference, FILM_SIZE, Film, Studio, json, output, program, sandbox, wait_for,
};

/// A screen and the size that the window asks for.
const USUAL: [[u32; 2]; 2] = [[1280, 720], FILM_SIZE];

/// How long nothing happens where that is what is looked at.
const REST: Duration = Duration::from_secs(2);

fn by([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

/// Starts a tool of the tests.
fn tool(command: &mut Command) -> Child {
    command.spawn().unwrap_or_else(|error| {
        let name = command.get_program().display();
        assert!(error.kind() != ErrorKind::NotFound, "{name} is missing; apt install xvfb xdotool");
        panic!("{name}: {error}")
    })
}

/// An X server that nobody sees.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn start(size: [u32; 2]) -> Self {
        // It takes a free number itself and writes it when it is ready. Without -noreset it would restart, and
        // refuse connections meanwhile, whenever its last client leaves, as xdotool does.
        let mut command = Command::new("Xvfb");
        let screen = format!("{}x24", by(size));
        command.args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-noreset"]);
        let mut display = Self {
            server: tool(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null())),
            name: String::new(),
        };
        let mut number = String::new();
        BufReader::new(display.server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb ended without a display");
        display.name = format!(":{}", number.trim());
        display
    }

    /// What xdotool prints; `None` if it fails.
    fn xdotool(&self, arguments: &[&str]) -> Option<String> {
        let mut command = Command::new("xdotool");
        let output = output(command.args(arguments).env("DISPLAY", &self.name));
        (output.code == 0).then_some(output.out)
    }

    #[track_caller]
    fn input(&self, arguments: &[&str]) {
        assert!(self.xdotool(arguments).is_some(), "xdotool {arguments:?} failed");
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program, recording, with the keyboard; its screenshots lie in a folder of its own.
struct Window {
    // Dropped before the display that it is on.
    program: Child,
    display: Display,
    folder: TempDir,
    id: String,
    screenshots: usize,
}

impl Window {
    fn open(environment: &[(&str, &str)]) -> Self {
        Self::open_in(
            tempfile::tempdir().unwrap(),
            &["--bare", "--record", "recording.ron"],
            environment,
            USUAL,
        )
    }

    fn open_in(
        folder: TempDir,
        arguments: &[&str],
        environment: &[(&str, &str)],
        [screen, size]: [[u32; 2]; 2],
    ) -> Self {
        let display = Display::start(screen);
        let program = Command::new(program())
            .args(arguments)
            .args(["--size", &by(size)])
            .current_dir(folder.path())
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("DISPLAY", &display.name)
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env("XDG_STATE_HOME", folder.path())
            // Not the settings of whoever runs the tests.
            .env("XDG_CONFIG_HOME", folder.path().join("settings"))
            .envs(environment.iter().copied())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(File::create(folder.path().join("messages")).unwrap())
            .spawn()
            .unwrap();
        let mut window = Self { program, display, folder, id: String::new(), screenshots: 0 };
        window.id = window.wait_for("a window named Inertia", |window| {
            let found =
                window.display.xdotool(&["search", "--onlyvisible", "--name", "^Inertia$"])?;
            found.lines().next().map(str::to_owned)
        });
        window.take_focus();
        let _ = window.screenshot();
        window
    }

    /// [`wait_for`], but no longer than the program runs.
    #[track_caller]
    fn wait_for<T>(&mut self, what: &str, mut look: impl FnMut(&Self) -> Option<T>) -> T {
        wait_for(what, || {
            if let Some(status) = self.program.try_wait().unwrap() {
                panic!("the program ended ({status}) before {what}: {}", self.messages());
            }
            look(self)
        })
    }

    fn messages(&self) -> String {
        fs::read_to_string(self.folder.path().join("messages")).unwrap_or_default()
    }

    /// There is no window manager that would give it the keyboard.
    fn take_focus(&mut self) {
        self.wait_for("the keyboard", |window| {
            window.display.xdotool(&["windowfocus", &window.id])?;
            (window.display.xdotool(&["getwindowfocus", "-f"])?.trim() == window.id).then_some(())
        });
    }

    fn input(&self, arguments: &[&str]) {
        self.display.input(arguments);
    }

    /// Takes a screenshot. When it is there, the program has handled every input before it, and the pointer is
    /// held or free as it should be.
    fn screenshot(&mut self) -> Screenshot {
        self.input(&["key", "F12"]);
        self.screenshots += 1;
        let path = self.folder.path().join(format!("screenshot_{:03}.png", self.screenshots));
        self.wait_for("a screenshot", |_| path.exists().then_some(()));
        Screenshot::read(path)
    }

    /// Quits, waits for the end, and fails unless that is a good one.
    #[track_caller]
    fn quit(&mut self) {
        self.input(&["key", "ctrl+q"]);
        let status = wait_for("the program to end", || self.program.try_wait().unwrap());
        assert_eq!(status.code(), Some(0), "{}", self.messages());
    }

    fn recording(&self) -> (Script, Recording) {
        let text = fs::read_to_string(self.folder.path().join("recording.ron")).unwrap();
        let script =
            Script::parse("recording.ron", &text).unwrap_or_else(|error| panic!("{error}"));
        let recording = script.recording.clone().unwrap();
        (script, recording)
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
        if std::thread::panicking() {
            eprintln!("the program said: {}", self.messages());
        }
    }
}

/// A picture and what the program wrote into it.
struct Screenshot {
    image: Image,
    tick: u64,
    state_hash: String,
}

impl Screenshot {
    fn read(path: PathBuf) -> Self {
        let text = Image::read_png_text(&path).unwrap();
        let value = |name: &str| {
            text.iter()
                .find(|(keyword, _)| keyword == name)
                .unwrap_or_else(|| panic!("no {name}"))
                .1
                .clone()
        };
        Self {
            image: Image::read_png(&path).unwrap(),
            tick: value("Tick").parse().unwrap(),
            state_hash: value("StateHash"),
        }
    }
}

/// Plays a recording in this process; `look` sees every frame with its orders.
fn replay(
    script: &Script,
    recording: &Recording,
    mut look: impl FnMut(&mut Session, &[Order]),
) -> Session {
    let scene = scene::load(&recording.scene).unwrap();
    let options = Options { size_px: recording.size_px.into(), ..Options::default() };
    let mut session = Session::new(scene, options);
    let mut clock = FrameClock::default();
    session.play(Player::new(script.clone()).unwrap());
    for end in &recording.frame_ends_s {
        let time = clock.advance_to(*end).unwrap();
        session.advance(&InputFrame::NOTHING, time);
        let orders = session.stage.take_orders();
        look(&mut session, &orders);
    }
    assert!(session.player().is_some_and(Player::finished));
    session
}

/// Paints over what only the window writes: how fast it is, in the top right corner, and that it wrote a
/// screenshot, above the middle.
fn without_the_shells_words(image: &Image) -> Image {
    let mut masked = image.clone();
    let [width, height] = image.size_px;
    for (at, pixel) in (0..).zip(masked.rgba.chunks_exact_mut(4)) {
        let (x, y) = (at % width * 100 / width, at / width * 100 / height);
        if (x >= 50 && y < 30) || ((25..75).contains(&x) && (25..45).contains(&y)) {
            pixel.fill(0);
        }
    }
    masked
}

#[test]
fn a_person_selects_pushes_and_pauses_in_the_window_and_the_recording_repeats_it() {
    let mut window = Window::open(&[]);
    // A look around; F2 takes it back.
    window.input(&["mousemove_relative", "20", "12", "key", "F2", "q"]);
    // Until then the pointer is not free.
    let _ = window.screenshot();
    let aim = Film::shipped("tutorial").pixel_of(DVec3::new(14.0, 10.0, 14.0)).round();
    window.input(&["mousemove", &aim.x.to_string(), &aim.y.to_string()]);
    window.input(&["click", "1", "click", "4", "click", "3", "key", "g"]);
    let pushed = window.screenshot();
    let shot = window.screenshots - 1;
    // A tenth of a second of motion, however long that takes.
    while window.screenshot().tick < pushed.tick + 12 {}
    window.input(&["key", "p"]);
    let paused = window.screenshot();
    window.input(&["key", "i", "i", "shift+i", "Escape", "Escape"]);
    // It is still there.
    let _ = window.screenshot();
    window.quit();
    assert_ne!(pushed.state_hash, paused.state_hash, "nothing moved");

    let (script, recording) = window.recording();
    let recorded: Vec<_> = script.steps.iter().map(|step| &step.action).collect();
    for key in ["F2", "Q", "G", "P", "I", "Shift+I", "F12", "Escape"] {
        assert!(
            recorded.contains(&&Action::Input(InputAction::KeyDown(key.to_owned()))),
            "{key} is not recorded"
        );
        assert!(
            recorded.contains(&&Action::Input(InputAction::KeyUp(key.to_owned()))),
            "{key} is not let go in the recording"
        );
    }
    for button in [MouseButton::Left, MouseButton::Right] {
        assert!(recorded.contains(&&Action::Input(InputAction::MouseDown(button))));
        assert!(recorded.contains(&&Action::Input(InputAction::MouseUp(button))));
    }
    assert!(recorded.contains(&&Action::Input(InputAction::MoveMouse(aim.x, aim.y))));
    let notches = |action: &&&Action| matches!(action, Action::Input(InputAction::Wheel(_)));
    assert_eq!(
        recorded.iter().filter(notches).collect::<Vec<_>>(),
        [&&Action::Input(InputAction::Wheel(1.0))]
    );

    let mut studio = Studio::like_the_window(FILM_SIZE);
    let (mut seen, mut replayed) = (Vec::new(), None);
    let end = replay(&script, &recording, |session, orders| {
        if orders.contains(&Order::Screenshot(None)) {
            if seen.len() == shot {
                replayed = Some(studio.draw(session));
                let selected = session.stage.selection().expect("the click selects");
                assert_eq!(session.stage.name(selected), "grid.x4.z4");
                assert_eq!(session.view.click_force(), 110.0);
                assert_eq!(session.view.mode(), Mode::Selection);
            }
            seen.push((
                session.stage.sim().ticks(),
                format!("{:016x}", state_hash(&session.stage)),
            ));
        }
    });
    assert_eq!(seen.len(), window.screenshots);
    assert_eq!(seen[shot], (pushed.tick, pushed.state_hash));
    assert_eq!(seen.last(), Some(&(paused.tick, paused.state_hash.clone())));
    let body = end.stage.sim().named("grid.x4.z4").unwrap();
    let velocity = end.stage.sim().world.get::<PhysicsBody>(body).unwrap().velocity;
    assert!(
        velocity.x > 1.0 && velocity.y < 0.0 && velocity.z < -1.0,
        "pushed and falling: {velocity}\n{}",
        script.to_ron()
    );
    assert_eq!(end.stage.sim().stepper.method(), Method::default().next());
    assert_eq!(end.stage.selection(), None, "Escape clears the selection");

    let [in_window, in_replay] = [&pushed.image, &replayed.unwrap()].map(without_the_shells_words);
    let difference = Difference::between(&in_window, &in_replay);
    assert!(difference.accepted(), "the window's picture and the replay's: {difference}");

    let line = "run tutorial --script recording.ron --summary summary.json";
    sandbox(&window.folder, line).fine();
    let summary = json(window.folder.path().join("summary.json"));
    assert_eq!(summary["state_hash"], paused.state_hash.as_str());
    assert_eq!(summary["ticks"], paused.tick);
}

/// The summary of the recording, replayed by the program in the window's folder.
fn replayed_by_program(window: &Window, scene: &str) -> serde_json::Value {
    sandbox(&window.folder, &format!("run {scene} --script recording.ron --summary summary.json"))
        .fine();
    json(window.folder.path().join("summary.json"))
}

#[test]
fn a_person_with_a_mouse_alone_goes_the_first_time_path_and_the_recording_repeats_it() {
    let size = [1280, 720];
    let mut here = Cockpit::of("empty", size);
    let arguments = ["empty", "--record", "recording.ron"];
    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &arguments, &[], [size, size]);
    let moves = |window: &Window, at: DVec2| {
        window.input(&["mousemove", &at.x.round().to_string(), &at.y.round().to_string()]);
    };
    let clicks = |window: &mut Window, here: &mut Cockpit, name: &str| {
        moves(window, here.middle_of(name));
        window.input(&["click", "1"]);
        here.click(name);
        for order in here.drive.session.stage.take_orders() {
            match order {
                Order::Open(name) => {
                    let saved = window.folder.path().join(&name);
                    let name = if saved.exists() { saved.display().to_string() } else { name };
                    here.drive.session.open(scene::load(&name).unwrap());
                    here.drive.ticks(3);
                    if here.session().view.should_be_framed(&here.session().stage) {
                        here.press("F");
                    }
                }
                Order::Scene(file) => {
                    here.drive.session.tools.saved_scene(&mut here.drive.session.stage, &file);
                }
                _ => {}
            }
            here.drive.ticks(3);
        }
        // A click may move what is clicked next: it is laid out in its new place one frame later.
        let _ = [window.screenshot(), window.screenshot()];
    };
    // A scene by its picture, which has the scene's description as its name.
    clicks(&mut window, &mut here, &scene::load("tutorial").unwrap().description);
    let _ = window.screenshot();

    // Dragged and pushed.
    let player = here.seen("player");
    moves(&window, player);
    window.input(&["mousedown", "1"]);
    for step in 1..=5 {
        moves(&window, player + DVec2::new(12.0, -6.0) * f64::from(step));
    }
    let pulled = window.screenshot();
    while window.screenshot().tick < pulled.tick + 12 {}
    window.input(&["mouseup", "1"]);
    let grid = here.seen("grid.x4.z4");
    for (at, button) in [(grid, "1"), (grid, "3")] {
        moves(&window, at);
        window.input(&["click", button]);
    }
    // As here, so that the same sections are open.
    here.drive.click(Button::Left, grid).ticks(2);
    let method = Method::RungeKutta4.claims().title;
    clicks(&mut window, &mut here, "method of integration (I and Shift+I)");
    clicks(&mut window, &mut here, method);
    clicks(&mut window, &mut here, "Measure");
    clicks(&mut window, &mut here, "Ghosts");
    let _ = window.screenshot();
    clicks(&mut window, &mut here, "Ghosts");

    clicks(&mut window, &mut here, "Build");
    clicks(&mut window, &mut here, "Sphere");
    clicks(&mut window, &mut here, "Box");
    clicks(&mut window, &mut here, "Undo");
    clicks(&mut window, &mut here, "Save");
    let saved = window.screenshot();
    let text = fs::read_to_string(window.folder.path().join("tutorial.ron")).unwrap();
    assert!(text.contains("name: \"sphere\"") && !text.contains("name: \"box\""), "{text}");
    assert!(text.contains("method: runge_kutta_4"), "{text}");
    clicks(&mut window, &mut here, "empty");
    clicks(&mut window, &mut here, "tutorial.ron");
    let reopened = window.screenshot();
    window.quit();
    assert_eq!(reopened.state_hash, saved.state_hash, "nothing moves in it by itself");

    let (script, _) = window.recording();
    let by_mouse = |action: &Action| match action {
        Action::Input(InputAction::KeyDown(key)) | Action::Input(InputAction::KeyUp(key)) => {
            // The window frames a scene without a camera of its own.
            ["F12", "F10", "F", "Q", "Ctrl", "Ctrl+Q"].contains(&key.as_str())
        }
        _ => true,
    };
    assert!(script.steps.iter().all(|step| by_mouse(&step.action)), "{}", script.to_ron());
    assert_eq!(replayed_by_program(&window, "empty")["state_hash"], reopened.state_hash.as_str());
}

#[test]
fn a_person_with_keys_alone_goes_the_first_time_path_and_the_recording_repeats_it() {
    let size = [1280, 720];
    let arguments = ["empty", "--record", "recording.ron"];
    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &arguments, &[], [size, size]);
    let opens = |window: &mut Window, name: &str| {
        window.input(&["key", "ctrl+o"]);
        // The field has the keyboard one frame later.
        let _ = window.screenshot();
        window.input(&["type", name]);
        window.input(&["key", "Return"]);
        let _ = window.screenshot();
    };
    opens(&mut window, "tutorial");
    window.input(&["key", "k"]);
    let selected = window.screenshot();
    window.input(&["keydown", "Right"]);
    while window.screenshot().tick < selected.tick + 12 {}
    window.input(&["keyup", "Right"]);
    window.input(&["key", "i", "t"]);
    let _ = window.screenshot();
    window.input(&["key", "t", "m"]);
    let _ = window.screenshot();
    window.input(&["key", "ctrl+d", "ctrl+d", "ctrl+z", "ctrl+shift+s"]);
    let saved = window.screenshot();
    let text = fs::read_to_string(window.folder.path().join("tutorial.ron")).unwrap();
    assert!(text.contains("name: \"player2\"") && !text.contains("name: \"player3\""), "{text}");
    opens(&mut window, "empty");
    opens(&mut window, "tutorial.ron");
    let reopened = window.screenshot();
    window.quit();
    assert_eq!(reopened.state_hash, saved.state_hash, "nothing moves in it by itself");

    let (script, _) = window.recording();
    let of_mouse = |action: &Action| {
        matches!(
            action,
            Action::Input(InputAction::MouseDown(_)) | Action::Input(InputAction::Wheel(_))
        )
    };
    assert!(!script.steps.iter().any(|step| of_mouse(&step.action)), "{}", script.to_ron());
    assert_eq!(replayed_by_program(&window, "empty")["state_hash"], reopened.state_hash.as_str());
}

/// Ends a window that records, by `end`: how the program ended.
fn ended_while_recording(end: impl FnOnce(&mut Window)) -> ExitStatus {
    let mut window = Window::open(&[]);
    window.input(&["key", "g"]);
    let before = window.screenshot();
    while window.screenshot().tick < before.tick + 12 {}
    let last = window.screenshot();
    // Frames after it.
    let _ = window.screenshot();
    end(&mut window);
    let status = wait_for("the program to end", || window.program.try_wait().unwrap());
    let (script, recording) = window.recording();
    let mut seen = Vec::new();
    replay(&script, &recording, |session, orders| {
        if orders.contains(&Order::Screenshot(None)) {
            seen.push((
                session.stage.sim().ticks(),
                format!("{:016x}", state_hash(&session.stage)),
            ));
        }
    });
    assert!(seen.contains(&(last.tick, last.state_hash)), "{seen:?}");
    let names = fs::read_dir(window.folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(!names.into_iter().any(|name| name.to_string_lossy().starts_with(".sandbox-")));
    status
}

#[test]
fn what_was_recorded_is_a_recording_however_the_window_ends() {
    let signal = |signal: &'static str| {
        ended_while_recording(|window| {
            let id = window.program.id().to_string();
            output(Command::new("kill").args([signal, &id])).fine();
        })
    };
    assert_eq!(signal("-TERM").code(), Some(143));
    assert_eq!(signal("-KILL").code(), None);
    let status = ended_while_recording(|window| {
        let _ = window.display.server.kill();
    });
    assert_eq!(status.code(), Some(5), "an X server that ends is a missing display");
}

#[test]
fn a_scene_that_could_not_be_saved_is_not_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.ron");
    fs::write(&path, "(version: 1, bodies: [(name: \"ball\", shape: sphere(radius_m: 1))])")
        .unwrap();
    let size = [1280, 720];
    let mut window = Window::open_in(folder, &["mine.ron"], &[], [size, size]);
    window.input(&["key", "m"]);
    let _ = window.screenshot();
    window.input(&["key", "k", "ctrl+d"]);
    let _ = window.screenshot();
    let other = "(version: 1)";
    fs::write(&path, other).unwrap();
    window.input(&["key", "ctrl+q"]);
    // The first answer, which saves, has the keyboard one frame later.
    let _ = [window.screenshot(), window.screenshot()];
    window.input(&["key", "Return"]);
    let _ = [window.screenshot(), window.screenshot()];
    assert_eq!(fs::read_to_string(&path).unwrap(), other);
    // It can be saved once there is a place for it.
    fs::remove_file(&path).unwrap();
    window.input(&["key", "ctrl+q"]);
    let _ = [window.screenshot(), window.screenshot()];
    window.input(&["key", "Return"]);
    let status = wait_for("the program to end", || window.program.try_wait().unwrap());
    assert_eq!(status.code(), Some(0), "{}", window.messages());
    assert!(fs::read_to_string(&path).unwrap().contains("ball2"));
}

#[test]
fn a_resized_window_goes_on_in_its_new_size_and_records_it() {
    let mut window = Window::open(&[]);
    let wanted = [500, 300];
    window.input(&["windowsize", &window.id, "500", "300"]);
    let resized = loop {
        let screenshot = window.screenshot();
        if screenshot.image.size_px == wanted {
            break screenshot;
        }
    };
    window.quit();
    let (script, recording) = window.recording();
    assert!(
        script.steps.iter().any(|step| step.action == Action::Input(InputAction::Resize(500, 300)))
    );
    assert_eq!(recording.size_px, FILM_SIZE.into());
    let end = replay(&script, &recording, |_, _| {});
    assert_eq!(end.view.size_px(), wanted);
    assert!(end.stage.sim().ticks() >= resized.tick);
}

#[test]
fn a_key_that_is_let_go_while_another_window_has_the_keyboard_does_not_fly_on() {
    let mut window = Window::open(&[]);
    window.input(&["keydown", "w"]);
    // In the frame of a screenshot the key is held already.
    let _ = window.screenshot();
    // Window 0 is none at all.
    window.input(&["windowfocus", "0"]);
    window.input(&["keyup", "w"]);
    window.take_focus();
    let _ = window.screenshot();
    window.quit();

    let (script, recording) = window.recording();
    let mut steps = script.steps.iter().map(|step| &step.action);
    assert!(steps.any(|action| *action == Action::Input(InputAction::KeyDown("W".to_owned()))));
    assert!(
        steps.any(|action| *action == Action::Input(InputAction::FocusLost)),
        "the loss is recorded"
    );
    let up = Action::Input(InputAction::KeyUp("W".to_owned()));
    assert!(script.steps.iter().all(|step| step.action != up), "the window never hears of it");
    let mut at_screenshots = Vec::new();
    let end = replay(&script, &recording, |session, orders| {
        if orders.contains(&Order::Screenshot(None)) {
            at_screenshots.push(session.view.camera().position);
        }
    });
    // The first was before W.
    assert_ne!(at_screenshots[1], scene::load("tutorial").unwrap().camera.position, "W flies");
    assert_eq!(at_screenshots[2], end.view.camera().position, "nothing is held any more");
}

#[test]
fn a_key_that_is_kept_down_steps_again_and_again_and_changes_gravity_once() {
    let mut window = Window::open(&[]);
    for key in ["period", "comma", "g"] {
        window.input(&["keydown", key]);
        sleep(REST);
        window.input(&["keyup", key]);
    }
    window.quit();
    let (script, _) = window.recording();
    let times = |key: &str| {
        let down = Action::Input(InputAction::KeyDown(key.to_owned()));
        script.steps.iter().filter(|step| step.action == down).count()
    };
    assert!(times(".") > 3 && times(",") > 3, "{script:?}");
    assert_eq!(times("G"), 1);
}

#[test]
fn the_window_remembers_how_its_panels_were_arranged_and_a_recording_has_it() {
    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &[], &[], USUAL);
    window.input(&["key", "F7", "F9", "b"]);
    let _ = window.screenshot();
    window.quit();
    let path = window.folder.path().join("settings/inertia/window");
    let left = fs::read_to_string(&path).unwrap();
    for line in
        ["toggle_cockpit on", "toggle_theme on", "toggle_dock off", "toggle_ledger_panel on"]
    {
        assert!(left.lines().any(|other| other == line), "{line}: {left}");
    }

    let folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
    let mut window = Window::open_in(folder, &["--record", "recording.ron"], &[], USUAL);
    window.quit();
    assert_eq!(fs::read_to_string(&path).unwrap(), left);
    let (script, recording) = window.recording();
    assert!(
        script
            .steps
            .iter()
            .any(|step| step.action == Action::Input(InputAction::Arrange(left.clone()))),
        "{script:?}"
    );
    assert_eq!(replay(&script, &recording, |_, _| {}).arrangement(), left);

    // The tutorial's window neither reads nor writes it, and one that finds no text begins as if there were none.
    let folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
    fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    let mut window = Window::open_in(folder, &["--bare"], &[], USUAL);
    window.quit();
    assert_eq!(fs::read(&path).unwrap(), [0xff, 0xfe, 0x00]);
    let folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
    let mut window = Window::open_in(folder, &[], &[], USUAL);
    window.quit();
    let left = fs::read_to_string(&path).unwrap();
    assert!(left.lines().any(|line| line == "toggle_theme off"), "{left}");
}

#[test]
fn the_card_of_the_first_start_comes_once_and_to_every_guest() {
    let record = ["--record", "recording.ron"];
    let mut folder = tempfile::tempdir().unwrap();
    for (more, welcomed) in
        [("orbit", false), ("", true), ("", false), ("--guest", true), ("", false)]
    {
        let guest = more == "--guest";
        let arguments: Vec<_> =
            record.into_iter().chain((!more.is_empty()).then_some(more)).collect();
        let before = fs::read_to_string(folder.path().join("settings/inertia/window"));
        let mut window = Window::open_in(folder, &arguments, &[], USUAL);
        window.quit();
        let (script, recording) = window.recording();
        let is_welcome = |action: &Action| matches!(action, Action::Input(InputAction::Arrange(text)) if text.contains("welcome on"));
        assert_eq!(
            script.steps.iter().any(|step| is_welcome(&step.action)),
            welcomed,
            "{script:?}"
        );
        assert!(!replay(&script, &recording, |_, _| {}).arrangement().contains("welcome"));
        folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
        let after = fs::read_to_string(folder.path().join("settings/inertia/window"));
        assert!(!guest || before.unwrap() == after.unwrap(), "a guest leaves nothing");
        fs::remove_file(folder.path().join("recording.ron")).unwrap();
        let _ = fs::remove_file(folder.path().join("screenshot_001.png"));
    }
}

#[test]
fn a_window_that_is_killed_has_remembered_and_a_guest_leaves_no_draft() {
    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &[], &[], USUAL);
    let path = window.folder.path().join("settings/inertia/window");
    window.input(&["key", "F9"]);
    wait_for("the arrangement", || {
        let left = fs::read_to_string(&path).unwrap_or_default();
        left.lines().any(|line| line == "toggle_dock off").then_some(())
    });
    window.program.kill().unwrap();
    window.program.wait().unwrap();
    assert!(fs::read_to_string(&path).unwrap().contains("toggle_dock off\n"));

    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &["--guest"], &[], USUAL);
    window.input(&["key", "k", "m"]);
    let _ = window.screenshot();
    window.input(&["key", "ctrl+d"]);
    sleep(REST);
    window.program.kill().unwrap();
    window.program.wait().unwrap();
    assert!(!window.folder.path().join("inertia").exists(), "no drafts");
    assert!(!window.folder.path().join("settings/inertia").exists(), "no arrangement");
}

#[test]
fn of_two_windows_at_once_each_remembers_its_scene_files() {
    let mut first = Window::open_in(tempfile::tempdir().unwrap(), &[], &[], USUAL);
    let settings = first.folder.path().join("settings");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.ron"), "(version: 1)").unwrap();
    let same = [("XDG_CONFIG_HOME", settings.to_str().unwrap())];
    let mut second = Window::open_in(folder, &["mine.ron"], &same, USUAL);
    first.input(&["key", "k", "m"]);
    let _ = first.screenshot();
    first.input(&["key", "ctrl+d", "ctrl+shift+s"]);
    first.wait_for("the saved scene", |window| {
        window.folder.path().join("tutorial.ron").exists().then_some(())
    });
    first.quit();
    second.quit();
    let files = fs::read_to_string(settings.join("inertia/files")).unwrap();
    let names: Vec<_> = files.lines().map(|line| line.rsplit('/').next().unwrap()).collect();
    assert_eq!(names, ["mine.ron", "tutorial.ron"]);
}

#[test]
fn after_a_crash_the_window_is_arranged_as_before_and_the_mouse_brings_the_changes_back() {
    let size = [1280, 720];
    let mut window = Window::open_in(tempfile::tempdir().unwrap(), &[], &[], [size, size]);
    window.input(&["key", "F7", "ctrl+q"]);
    wait_for("the program to end", || window.program.try_wait().unwrap());
    let arranged = window.folder.path().join("settings/inertia/window");
    assert!(fs::read_to_string(&arranged).unwrap().contains("toggle_editor off"));
    let again = |window: &mut Window| {
        let folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
        fs::remove_file(folder.path().join("screenshot_001.png")).unwrap();
        Window::open_in(folder, &[], &[], [size, size])
    };

    let mut window = again(&mut window);
    window.input(&["key", "k", "m"]);
    let _ = window.screenshot();
    window.input(&["key", "ctrl+d"]);
    let drafts = window.folder.path().join("inertia/drafts");
    window.wait_for("a draft", |_| {
        let files = fs::read_dir(&drafts).ok()?;
        let mut paths = files.flatten().map(|file| file.path());
        paths.any(|path| path.extension().is_some_and(|end| end == "ron")).then_some(())
    });
    window.program.kill().unwrap();
    window.program.wait().unwrap();

    let before = fs::read_to_string(&arranged).unwrap();

    let _ = fs::remove_file(window.folder.path().join("screenshot_002.png"));
    let mut window = again(&mut window);
    let mut here = Cockpit::of("tutorial", size);
    here.drive.session.offer("draft".into());
    here.drive.ticks(3);
    let DVec2 { x, y } = here.middle_of("Open them").round();
    window.input(&["mousemove", &x.to_string(), &y.to_string(), "click", "1"]);
    let _ = window.screenshot();
    window.input(&["key", "ctrl+shift+s"]);
    let _ = window.screenshot();
    let saved = window.folder.path().join("tutorial.ron");
    let text = window.wait_for("the saved scene", |_| fs::read_to_string(&saved).ok());
    assert!(text.contains("name: \"player2\""), "{text}");
    window.quit();
    assert_eq!(fs::read_to_string(&arranged).unwrap(), before);
    for line in ["toggle_cockpit on", "toggle_theme on", "toggle_editor on"] {
        assert!(before.contains(line), "{before}");
    }
}

#[test]
fn a_bundle_opens_just_before_its_fault_and_meets_it_again() {
    let (bundle, hashes) = crate::black_box::with_a_fault();
    let fault = bundle.manifest.fault.clone().unwrap();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("box"), bundle.write().unwrap()).unwrap();
    let mut window = Window::open_in(folder, &["--bare", "box"], &[], USUAL);
    let hash = |tick: u64| format!("{:016x}", hashes[tick as usize - 1]);
    let good = fault.tick - 1;
    let first = window.screenshot();
    assert_eq!((first.tick, &first.state_hash), (good, &hash(good)));
    window.input(&["key", "comma", "comma"]);
    let back = window.screenshot();
    assert_eq!((back.tick, &back.state_hash), (good - 2, &hash(good - 2)));
    // It runs up to the fault, meets it and stands where it began.
    window.input(&["key", "p"]);
    let mut before = back.tick;
    let met = loop {
        let screenshot = window.screenshot();
        // Twice in a row: it stands.
        if screenshot.tick != back.tick && screenshot.tick == before {
            break screenshot;
        }
        before = screenshot.tick;
    };
    assert_eq!((met.tick, &met.state_hash), (good, &hash(good)));
    // Then it goes through it.
    window.input(&["key", "p"]);
    while window.screenshot().tick <= fault.tick {}
    window.quit();
}

#[test]
fn a_window_is_no_larger_than_its_screen() {
    let (folder, screen) = (tempfile::tempdir().unwrap(), [1024, 600]);
    let mut window = Window::open_in(folder, &["--bare"], &[], [screen, [1280, 720]]);
    assert_eq!(window.screenshot().image.size_px, screen);
    window.quit();
}

#[test]
fn a_paused_window_draws_when_something_happens_and_owes_nothing_for_the_rest() {
    let mut window = Window::open(&[]);
    window.input(&["key", "p"]);
    let paused = window.screenshot();
    sleep(REST);
    window.input(&["key", "w"]);
    let flown = window.screenshot();
    assert_eq!((flown.tick, &flown.state_hash), (paused.tick, &paused.state_hash));
    sleep(REST);
    window.input(&["key", "p"]);
    while window.screenshot().tick == paused.tick {}
    window.quit();

    let (script, recording) = window.recording();
    let rest = REST.as_secs_f64();
    let (mut cameras, mut dropped, mut paused) = (Vec::new(), Vec::new(), Vec::new());
    replay(&script, &recording, |session, _| {
        cameras.push(session.view.camera().position);
        dropped.push(session.stage.playback().dropped());
        paused.push(session.stage.playback().paused());
    });
    let lengths = recording.frame_ends_s.windows(2).map(|ends| ends[1] - ends[0]);
    // The other frames are as long as the machine is busy.
    let is_rest = |(i, length): &(usize, f64)| paused[*i] && *length > 0.8 * rest;
    let rests: Vec<usize> = (0..).zip(lengths).filter(is_rest).map(|(i, _)| i).collect();
    assert_eq!(rests.len(), 2, "no frame while nothing happens");
    let flown = cameras[0].distance(*cameras.last().unwrap());
    assert!(flown > 0.0 && flown < 50.0 * rest, "a tap of W flies {flown} m");
    assert!(rests.iter().all(|i| dropped[i + 1] - dropped[*i] < 0.5 * rest));
}

#[test]
fn a_window_that_is_not_seen_simulates_on_with_few_frames() {
    let mut window = Window::open(&[]);
    let before = window.screenshot();
    window.input(&["windowmove", &window.id, "5000", "5000"]);
    sleep(REST);
    window.input(&["windowmove", &window.id, "0", "0"]);
    let after = window.screenshot();
    assert!(after.tick > before.tick + 100);
    window.quit();
    let (_, recording) = window.recording();
    let few = |ends: &&[f64]| (0.09..0.2).contains(&(ends[1] - ends[0]));
    assert!(
        recording.frame_ends_s.windows(2).filter(few).count() >= 8,
        "{:?}",
        recording.frame_ends_s
    );
}

#[test]
fn a_wayland_display_that_is_gone_falls_back_to_x11() {
    let mut window = Window::open(&[("WAYLAND_DISPLAY", "/nonexistent/wayland-9")]);
    assert_eq!(window.screenshot().image.size_px, FILM_SIZE);
    window.quit();
}

#[test]
fn without_a_display_the_program_ends_with_5_and_one_line_that_names_the_run_without_one() {
    // None named, and one named that is not there.
    for display in [None, Some(":65534")] {
        let mut command = Command::new(program());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let said = output(command.envs(display.map(|name| ("DISPLAY", name))));
        said.fails(5, "sandbox run");
        assert_eq!(said.err.lines().count(), 1, "{}", said.err);
        assert!(!said.err.contains(".rs:"), "it names a path into a library: {}", said.err);
    }
}
