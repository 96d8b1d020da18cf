//! The window shell: winit events in, the wall clock, a swap chain out. Everything between is the session's.

mod display;
mod drafts;
mod keys;
mod pointer;
mod recorder;
mod remembered;
mod speed;
mod wheel;

use std::collections::HashMap;
use std::ops;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use history::Overrides;
use render::{Gpu, Image, Offscreen, Quality, Renderer, WindowTarget};
use scene::{Scene, Source};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, DeviceEvents};
use winit::keyboard::{ModifiersState, PhysicalKey};
use winit::window::{Window, WindowId};

use self::drafts::Drafts;
use self::pointer::Pointer;
use self::recorder::Recorder;
use self::speed::{Speed, SpeedSetting};
use self::wheel::Wheel;
use crate::actions::{Act, Binding, binding};
use crate::app::script::{load_script, player_of};
use crate::app::session::{DEFAULT_FPS, Session};
use crate::args::{StepArgs, size};
use crate::clock::FrameClock;
use crate::failure::Failure;
use crate::input::{Button, Input, InputFrame, Key};
use crate::output::bundle::{self, write_bundle};
use crate::output::files::write;
use crate::output::pictures::write_picture;
use crate::output::progress::Loading;
use crate::output::scenes::save_scene;
use crate::output::tell;
use crate::stage::Order;
use crate::stage::notices::Topic;
use crate::stage::options::{Options, check};

/// Shortest time between two frames: vertical sync does not pace every display.
const SHORTEST_FRAME: Duration = Duration::from_micros(4_000);

/// Longest time that the ticks of a frame may take; the others are dropped, and reported like those of a hitch. Scenes of more
/// ticks a second than there is time for run slower, and never stop the window.
const PATIENCE: Duration = Duration::from_millis(250);

/// Time between two frames of a window that is not seen: it simulates on and draws nothing.
const HIDDEN_FRAME: Duration = Duration::from_millis(100);

/// Frames that are drawn after something happened: panels may take their place one layout later.
const SETTLING_FRAMES: u32 = 3;

/// Opens the window.
#[derive(Args, Debug)]
pub(crate) struct WindowArgs {
    /// A shipped scene, a file or a bundle [default: tutorial]
    pub scene: Option<String>,
    /// Start paused
    #[arg(long)]
    pub paused: bool,
    /// Play a script
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Show the tutorial's picture alone, in camera mode; F10 shows the bars and the dock around it
    #[arg(long)]
    pub bare: bool,
    /// Size of the window, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    #[command(flatten)]
    pub step: StepArgs,
    /// Record inputs and frame times, for `run --script`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["script", "paused", "substeps"])]
    pub record: Option<PathBuf>,
}

/// Opens the window and runs until it is closed.
pub(crate) fn open(args: &WindowArgs) -> Result<(), Failure> {
    let name = args.scene.as_deref().unwrap_or("tutorial");
    let mut session = session(args, name)?;
    if let Some(path) = &args.script {
        let script = load_script(path, session.stage.scene())?;
        session.play(player_of(script));
    }
    let recorder = args.record.as_ref().map(|path| Recorder::new(path, name, args.step.method, args.size));
    let recorder = recorder.transpose()?;
    let event_loop = display::event_loop(name)?;
    display::end_with(&event_loop);
    let mut shell = Shell {
        session,
        recorder,
        screen: None,
        drafts: Drafts::begin(),
        pointer: Pointer::default(),
        events: Vec::new(),
        down: HashMap::new(),
        modifiers: ModifiersState::empty(),
        focused: true,
        mode_changes: false,
        clock: FrameClock::default(),
        start: Instant::now(),
        last_frame: None,
        unsettled: SETTLING_FRAMES,
        rested: false,
        occluded: false,
        wheel: Wheel::default(),
        speed: Speed::default(),
        failure: None,
        arrangement: None,
        files: None,
    };
    forecast_start(&mut shell.session);
    let remembers = !args.bare && args.script.is_none();
    if remembers {
        shell.arrangement = Some(remembered::read(remembered::ARRANGEMENT));
        let left = shell.drafts.left_behind().into_iter().next();
        // A recording keeps its scene, and shows no list that another machine does not have.
        if shell.recorder.is_none() {
            shell.session.stage.remember_files(remembered::files());
            shell.files = Some(shell.session.stage.files().to_owned());
            if let Source::File(path) = shell.session.stage.scene().source.clone() {
                shell.session.stage.run.note_file(&path);
            }
            if let Some(draft) = left {
                shell.session.offer(draft);
            }
        }
    }
    // Also while another window has the keyboard: the wheel turns here as well.
    event_loop.listen_device_events(DeviceEvents::Always);
    let ended = event_loop.run_app(&mut shell).map_err(|error| {
        Failure::NoDisplay(format!(
            "the window system failed: {}",
            display::without_place(&error.to_string())
        ))
    });
    let ended = ended.and(shell.failure.map_or(Ok(()), Err));
    shell.drafts.end();
    if remembers && ended.is_ok() {
        remembered::keep(remembered::ARRANGEMENT, &shell.session.arrangement());
    }
    let recorded = shell
        .recorder
        .map_or(Ok(()), |recorder| recorder.finish(shell.session.stage.frames(), &shell.session.chosen));
    if let (Err(_), Err(failure)) = (&ended, &recorded) {
        tell(&failure.to_string());
    }
    ended.and(recorded)
}

/// What the window begins with: a scene, or a bundle just before what went wrong in it.
fn session(args: &WindowArgs, name: &str) -> Result<Session, Failure> {
    let StepArgs { method, substeps, threads } = args.step;
    let options = Options { size_px: args.size, paused: args.paused, threads, ..Options::default() };
    if let Some(bundle) = bundle::named(name)? {
        if method.is_some() || substeps.is_some() || args.record.is_some() {
            let what = "a bundle repeats its own run; leave --method, --substeps and --record out";
            return Err(Failure::Usage(format!("{name}: {what}")));
        }
        return bundle::opened(&bundle, name, options);
    }
    let loading = Loading::begin();
    let scene = scene::load(name)?;
    let overrides = Overrides { method, substeps, ..Overrides::default() };
    check(overrides, &scene)?;
    loading.next();
    let mut session = Session::new(scene, Options { overrides, ..options });
    session.stage.keep_timeline();
    session.stage.save_faults();
    Ok(session)
}

/// The window and what draws into it.
struct Screen {
    window: Arc<Window>,
    gpu: Gpu,
    target: WindowTarget,
    renderer: Renderer,
}

impl Screen {
    fn new(event_loop: &ActiveEventLoop, [width, height]: [u32; 2]) -> Result<Self, Failure> {
        let monitor = event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next());
        let most = monitor.map(|monitor| monitor.size()).filter(|most| most.width > 0 && most.height > 0);
        let most = most.unwrap_or(PhysicalSize::new(width, height));
        let attributes = Window::default_attributes()
            .with_title("Inertia")
            .with_inner_size(PhysicalSize::new(width.min(most.width), height.min(most.height)));
        let window = event_loop.create_window(attributes).map_err(|error| {
            let error = display::without_place(&error.to_string());
            Failure::NoDisplay(format!("cannot open a window: {error}; `sandbox run` needs none"))
        })?;
        let window = Arc::new(window);
        let display = Box::new(event_loop.owned_display_handle());
        let (gpu, surface) = Gpu::for_window(Arc::clone(&window), display)?;
        eprintln!("drawing with {}", gpu.info);
        let size = window.inner_size();
        let target = WindowTarget::new(surface, &gpu, [size.width, size.height])?;
        let renderer = Renderer::new(&gpu, target.format(), Quality::for_adapter(&gpu.info));
        Ok(Self { window, gpu, target, renderer })
    }
}

struct Shell {
    session: Session,
    recorder: Option<Recorder>,
    screen: Option<Screen>,
    drafts: Drafts,
    pointer: Pointer,
    events: Vec<Input>,
    /// What each key meant when it went down: shift may be let go before it.
    down: HashMap<PhysicalKey, Key>,
    modifiers: ModifiersState,
    focused: bool,
    /// A key that changes the mode waits for its frame: until then motion could mean either.
    mode_changes: bool,
    clock: FrameClock,
    start: Instant,
    last_frame: Option<Instant>,
    /// Frames to be drawn before it may rest.
    unsettled: u32,
    /// Whether it waited since the last frame, because nothing changed.
    rested: bool,
    occluded: bool,
    wheel: Wheel,
    speed: Speed,
    failure: Option<Failure>,
    /// How the panels are to be arranged when the window is there.
    arrangement: Option<String>,
    /// The scene files that were remembered last, if they are.
    files: Option<Vec<PathBuf>>,
}

impl ApplicationHandler for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        match Screen::new(event_loop, self.session.view.size_px()) {
            Ok(screen) => {
                let size = screen.window.inner_size();
                self.events.push(Input::Resized([size.width, size.height]));
                self.events.push(Input::Scaled(screen.window.scale_factor()));
                // As input of the first frame, so that a recording has it too.
                self.events.extend(self.arrangement.take().map(Input::Arrange));
                self.screen = Some(screen);
                self.start = Instant::now();
            }
            Err(failure) => self.fail(event_loop, failure),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.unsettled = SETTLING_FRAMES;
        }
        match event {
            // As its key, so that a recording has it and unsaved changes are asked about.
            WindowEvent::CloseRequested => self.press(Act::Quit),
            WindowEvent::Resized(size) => {
                if let Some(screen) = &mut self.screen {
                    screen.target.resize(&screen.gpu, [size.width, size.height]);
                }
                // A minimized window keeps the picture's size: rays and panels need one.
                if size.width > 0 && size.height > 0 {
                    self.events.push(Input::Resized([size.width, size.height]));
                }
            }
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                self.events.push(Input::Scaled(scale_factor));
            }
            WindowEvent::Focused(focused) => self.focus(focused),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event),
            WindowEvent::CursorMoved { position, .. } => {
                let known = !self.mode_changes && self.pointer.holds() == self.session.view.grabs_pointer();
                if let (Some(screen), true) = (&self.screen, known) {
                    self.events.extend(self.pointer.moved(&screen.window, position));
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let button = match button {
                    MouseButton::Left => Button::Left,
                    MouseButton::Right => Button::Right,
                    MouseButton::Middle => Button::Middle,
                    _ => return,
                };
                let pressed = state == ElementState::Pressed;
                self.events.push(if pressed { Input::ButtonDown(button) } else { Input::ButtonUp(button) });
            }
            WindowEvent::MouseWheel { delta, .. } => {
                self.events.extend(self.wheel.notches(delta).map(Input::Wheel));
            }
            WindowEvent::DroppedFile(path) => match &self.recorder {
                None => self.session.leave(Order::Open(path.to_string_lossy().into_owned())),
                Some(_) => {
                    let what = "a recording keeps its scene; drop files on a window that does not record";
                    self.session.stage.notices.say(Topic::File, what.to_owned());
                }
            },
            WindowEvent::Occluded(occluded) => self.occluded = occluded,
            WindowEvent::RedrawRequested => self.frame(event_loop),
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        self.wheel.raw(&event);
        if let (DeviceEvent::MouseMotion { delta }, false) = (event, self.mode_changes) {
            self.events.extend(self.pointer.raw(delta));
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = Instant::now();
        let changes_in = if self.is_unsettled() { 0.0 } else { self.session.changes_in_s() };
        let hidden = self.is_hidden();
        let shortest = if hidden { HIDDEN_FRAME } else { SHORTEST_FRAME };
        // Nothing changes for a time that no clock has: it waits for an event.
        let waits = Duration::try_from_secs_f64(changes_in).ok().map(|waits| waits.max(shortest));
        let due = self.last_frame.map_or(Some(now), |last| last.checked_add(waits?));
        match due {
            Some(due) if due > now => {
                self.rested |= changes_in > 0.0;
                event_loop.set_control_flow(ControlFlow::WaitUntil(due));
            }
            // Some systems ask for no frame of a window that is not seen.
            Some(_) if hidden => {
                self.frame(event_loop);
                event_loop.set_control_flow(ControlFlow::WaitUntil(now + HIDDEN_FRAME));
            }
            Some(_) => {
                event_loop.set_control_flow(ControlFlow::Wait);
                if let Some(screen) = &self.screen {
                    screen.window.request_redraw();
                }
            }
            None => {
                self.rested = true;
                event_loop.set_control_flow(ControlFlow::Wait);
            }
        }
    }
}

impl Shell {
    fn fail(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        self.failure = Some(failure);
        event_loop.exit();
    }

    /// Does an action as its key does, in the coming frame.
    fn press(&mut self, act: Act) {
        let key = act.key();
        self.events.extend([Input::KeyDown(key.clone()), Input::KeyUp(key)]);
    }

    fn focus(&mut self, focused: bool) {
        self.focused = focused;
        if !focused {
            self.down.clear();
            self.events.push(Input::FocusLost);
        }
    }

    fn key(&mut self, event: &KeyEvent) {
        match event.state {
            ElementState::Pressed => {
                let Some(key) = keys::named(event, self.modifiers) else { return };
                let repeats = || binding(&key).is_some_and(Binding::repeats);
                if !event.repeat || self.session.takes_text() || repeats() {
                    self.mode_changes |= binding(&key).is_some_and(|row| row.act == Act::ToggleMode);
                    self.events.push(Input::KeyDown(key.clone()));
                    self.down.insert(event.physical_key, key);
                }
                let ctrl = self.modifiers.control_key();
                if let (Some(text), false, true) = (&event.text, ctrl, self.session.takes_text()) {
                    self.events.push(Input::Text(text.to_string()));
                }
            }
            ElementState::Released => {
                if let Some(key) = self.down.remove(&event.physical_key) {
                    self.events.push(Input::KeyUp(key));
                }
            }
        }
    }

    /// Whether the next frame may be another one without the session changing by itself.
    fn is_unsettled(&self) -> bool {
        self.unsettled > 0 || !self.events.is_empty()
    }

    /// Whether the window is not seen. One that has the keyboard is not minimized, which takes a question to the system.
    fn is_hidden(&self) -> bool {
        let minimized = |screen: &Screen| screen.window.is_minimized() == Some(true);
        self.occluded || (!self.focused && self.screen.as_ref().is_some_and(minimized))
    }

    /// One frame: what happened since the last one, ticks, a picture if it is seen.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let now = Instant::now();
        let hidden = self.is_hidden();
        // A recording is repeated with panels in every frame.
        self.session.set_unseen(hidden && self.recorder.is_none());
        self.unsettled = self.unsettled.saturating_sub(1);
        if std::mem::take(&mut self.rested) {
            // What ended the rest happened now, not ever since it began.
            self.advance(now.checked_sub(SHORTEST_FRAME).unwrap_or(now), Vec::new());
        }
        let events = std::mem::take(&mut self.events);
        self.advance(now, events);
        self.last_frame = Some(now);
        self.mode_changes = false;
        if let Some(screen) = &self.screen {
            let holds = self.focused && self.session.view.grabs_pointer();
            let [corner, size] = self.session.view.view_area();
            self.pointer.follow(&screen.window, holds, corner + size / 2.0);
        }
        let drawn = !hidden
            && self.draw().unwrap_or_else(|failure| {
                self.fail(event_loop, failure);
                false
            });
        if !drawn && !hidden {
            self.unsettled = self.unsettled.max(1);
        }
        if hidden && self.session.asks() {
            self.show();
        }
        let mut unsaved = false;
        for order in self.session.stage.take_orders() {
            match order {
                // A scene that could not be saved is not left.
                Order::Quit | Order::Open(_) if unsaved => {}
                Order::Quit => event_loop.exit(),
                Order::Restore(draft) => self.restore(&draft),
                Order::Forget(draft) => drafts::delete(&draft),
                Order::Open(name) => self.open_scene(&name),
                Order::Scene(file) => {
                    let (path, written) = (file.path.clone(), save_scene(&mut self.session, &file));
                    unsaved = written.is_err();
                    say_written(&mut self.session, &path, written);
                }
                Order::Table(text) => {
                    let path = free_name("graph", "csv");
                    let written = write(&path, text.as_bytes());
                    say_written(&mut self.session, &path, written);
                }
                // Written with the picture, in `draw`, if there was one.
                Order::Screenshot(_) | Order::Bundle if drawn => {}
                Order::Screenshot(_) | Order::Bundle => self.session.stage.orders.push(order),
            }
        }
        self.keep_draft();
        self.keep_files();
    }

    /// Remembers which files were opened and saved, at once: a crash forgets none.
    fn keep_files(&mut self) {
        let files = self.session.stage.files();
        if let Some(before) = self.files.as_deref().filter(|before| *before != files) {
            remembered::keep_files(before, files);
            self.files = Some(files.to_owned());
        }
    }

    /// Brings a window back that has something to ask.
    fn show(&self) {
        if let Some(screen) = &self.screen {
            screen.window.set_minimized(false);
            screen.window.focus_window();
        }
    }

    /// Lets the session go on to `now`.
    fn advance(&mut self, now: Instant, events: Vec<Input>) {
        // Wall time only goes forward, and so does this.
        let Ok(time) = self.clock.advance_to((now - self.start).as_secs_f64()) else {
            self.events.splice(0..0, events);
            return;
        };
        if let Some(recorder) = &mut self.recorder {
            let inputs = self.session.chosen.iter().chain(&events);
            if let Err(failure) = recorder.record(self.session.stage.frames(), time.total(), inputs) {
                self.session
                    .stage
                    .notices
                    .say(Topic::File, format!("the recording is written at the end: {failure}"));
            }
        }
        let (before, ticks_before) = (Instant::now(), self.session.stage.ticks());
        let progress_before = self.session.stage.progress();
        // To the end of the last tick: the panels, which come after it, take longer than all ticks.
        let mut after = before;
        // A recording is played back without a wall clock.
        let patience = if self.recorder.is_some() { Duration::MAX } else { PATIENCE };
        let had_arrived = self.session.stage.arrived();
        self.session.advance_watched(&InputFrame { events }, time, &mut |_, _| {
            after = Instant::now();
            if after - before > patience {
                ops::ControlFlow::Break(())
            } else {
                ops::ControlFlow::Continue(())
            }
        });
        // Panels are laid out before a way back ends.
        if !had_arrived && self.session.stage.arrived() {
            self.unsettled = SETTLING_FRAMES;
        }
        self.speed.frame(speed::Sample {
            length_s: time.length(),
            // A run that went back simulated nothing.
            simulated_s: (self.session.stage.progress() - progress_before).max(0.0),
            ticks: self.session.stage.ticks().saturating_sub(ticks_before),
            ticking: after - before,
            setting: SpeedSetting::of(&self.session),
        });
        self.session.set_measured(self.speed.measured());
    }

    /// Draws a frame and writes the screenshots that were ordered; `false`: there was nothing to draw on.
    fn draw(&mut self) -> Result<bool, Failure> {
        let Some(screen) = &mut self.screen else { return Ok(false) };
        let Some(target) = screen.target.acquire(&screen.gpu) else {
            if screen.target.lost() {
                let surface = screen.gpu.surface(Arc::clone(&screen.window))?;
                screen.target.replace_surface(&screen.gpu, surface);
            }
            return Ok(false);
        };
        let mut frame = self.session.picture();
        frame.size_px = target.size_px();
        screen.renderer.draw(&screen.gpu, &frame, target.view());
        screen.window.pre_present_notify();
        target.present(&screen.gpu);
        for order in self.session.stage.orders.clone() {
            if !matches!(order, Order::Screenshot(_) | Order::Bundle) {
                continue;
            }
            if let Some(panels) = &mut frame.panels {
                // The first drawing took the textures.
                panels.textures_delta.clear();
            }
            let copy = Offscreen::with_format(&screen.gpu, frame.size_px, screen.target.format())?;
            screen.renderer.draw(&screen.gpu, &frame, copy.view());
            let image = copy.read(&screen.gpu)?;
            let (path, written) = match order {
                Order::Screenshot(Some(name)) => save_picture(&image, PathBuf::from(name), &self.session),
                Order::Screenshot(None) => {
                    save_picture(&image, free_name("screenshot", "png"), &self.session)
                }
                _ => {
                    let path = free_name("bundle", "zip");
                    let written = write_bundle(&path, &self.session.stage, Some(&image));
                    (path, written)
                }
            };
            say_written(&mut self.session, &path, written);
        }
        Ok(true)
    }

    /// Goes on with unsaved changes that another window left behind.
    fn restore(&mut self, path: &Path) {
        let read = scene::read_text(path).and_then(|text| Scene::parse("restored", &text));
        match read {
            Ok(scene) => {
                self.session.open_unsaved(scene, drafts::file_of(path));
                if self.keep_draft() {
                    drafts::delete(path);
                }
            }
            Err(error) => self.session.stage.notices.say(Topic::File, error.to_string()),
        }
    }

    /// Keeps unsaved changes for a crash; whether there is nothing that is not kept.
    fn keep_draft(&mut self) -> bool {
        let unsaved =
            self.session.has_unsaved_changes().then(|| Arc::clone(&self.session.stage.scene().text));
        let file = unsaved.as_ref().and_then(|_| self.session.tools.own_file());
        self.drafts
            .keep(unsaved.as_ref(), file.as_ref(), |words| self.session.stage.notices.say(Topic::File, words))
    }

    fn open_scene(&mut self, name: &str) {
        match scene::load(name) {
            Ok(scene) => {
                self.session.open(scene);
                forecast_start(&mut self.session);
                self.session.stage.save_faults();
            }
            Err(error) => self.session.stage.notices.say(Topic::File, error.to_string()),
        }
    }
}

/// Tells what of the scene is unstable at its start.
fn forecast_start(session: &mut Session) {
    session.tools.forecast_start(&mut session.stage, 1.0 / DEFAULT_FPS);
}

fn say_written(session: &mut Session, path: &Path, written: Result<(), Failure>) {
    let words = match written {
        Ok(()) => format!("wrote {}", path.display()),
        Err(failure) => failure.to_string(),
    };
    session.stage.notices.say(Topic::File, words);
}

fn save_picture(image: &Image, path: PathBuf, session: &Session) -> (PathBuf, Result<(), Failure>) {
    let written = write_picture(image, &path, &session.stage);
    (path, written)
}

/// The first name of that kind that no file has.
fn free_name(what: &str, extension: &str) -> PathBuf {
    let name = |i: u32| PathBuf::from(format!("{what}_{i:03}.{extension}"));
    (1..).map(name).find(|path| !path.exists()).expect("there is always another number")
}
