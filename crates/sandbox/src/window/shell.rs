//! The window's events, its clock and its frames.

use std::collections::HashMap;
use std::ops::ControlFlow as Look;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::ImeEvent;
use egui_winit::accesskit_winit::{self, Event};
use winit::application::ApplicationHandler;
use winit::event::{
    DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, Touch, WindowEvent,
};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{ModifiersState, PhysicalKey};
use winit::window::WindowId;

use super::drafts::Drafts;
use super::pointer::Pointer;
use super::program::WindowProgram;
use super::recorder::Recorder;
use super::screen::Screen;
use super::speed::{self, Speed, SpeedSetting};
use super::wheel::Wheel;
use super::{keys, remembered};
use crate::failure::Failure;
use crate::output::bundle::write_bundle;
use crate::output::command_files::CommandFiles;
use crate::output::on_device::{check, slow_words};
use crate::output::orders::{BUNDLE, Program as _, carry_out};
use crate::output::tell;
use cockpit::actions::{Act, Binding, Hold, Lasts, binding};
use cockpit::app::session::Session;
use cockpit::clock::FrameClock;
use cockpit::input::{Button, Input, InputFrame, Key, TouchPhase};
use cockpit::stage::notices::Topic;
use cockpit::stage::{Order, Stage};

/// Shortest time between two frames: vertical sync does not pace every display.
const SHORTEST_FRAME: Duration = Duration::from_micros(4_000);

/// Longest time that the ticks of a frame may take; the others are dropped, and reported like those of a hitch. Scenes of more
/// ticks per second than there is time for run slower, and never stop the window.
const PATIENCE: Duration = Duration::from_millis(250);

/// Time between two frames of a window that is not seen: it continues to simulate, and draws nothing.
const HIDDEN_FRAME: Duration = Duration::from_millis(100);

/// Frames that are drawn after something happened: panels may take their place one layout later.
const SETTLING_FRAMES: u32 = 3;

/// The window and its session.
pub(super) struct Shell {
    pub session: Session,
    pub recorder: Option<Recorder>,
    screen: Option<Screen>,
    pub drafts: Drafts,
    pointer: Pointer,
    events: Vec<Input>,
    /// The meaning of each key when it went down: shift may be released before the key.
    down: HashMap<PhysicalKey, Key>,
    modifiers: ModifiersState,
    /// Whether the last letter was Latin.
    latin: bool,
    focused: bool,
    /// Whether a key that changes the mode waits for its frame: until then, motion could belong to either mode.
    mode_changes: bool,
    clock: FrameClock,
    start: Instant,
    last_frame: Option<Instant>,
    /// Frames to be drawn before the window may rest.
    unsettled: u32,
    /// Whether the window has waited since the last frame, because nothing changed.
    rested: bool,
    occluded: bool,
    /// Whether a scene was opened whose bodies are to be framed once the view has its place.
    pub opened: bool,
    wheel: Wheel,
    speed: Speed,
    pub failure: Option<Failure>,
    /// How the panels are to be arranged when the window is there.
    pub arrangement: Option<String>,
    /// The arrangement that was remembered last; `None` if none is remembered.
    pub arranged: Option<String>,
    /// Number of mouse buttons that are down: what a drag changes is remembered at its end.
    buttons: u32,
    /// The scene files that were remembered last; `None` if none are remembered.
    pub remembered: Option<Vec<PathBuf>>,
    files: CommandFiles,
    proxy: EventLoopProxy<Event>,
}

impl ApplicationHandler<Event> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        let (size_px, egui) = (self.session.view.size_px(), self.session.egui());
        match pollster::block_on(Screen::open(event_loop, size_px, egui, self.proxy.clone())) {
            Ok(screen) => {
                if let Err(failure) = check(&screen.gpu, &self.session.stage.sim().scene) {
                    return self.fail(event_loop, failure);
                }
                let slow = slow_words(&screen.gpu, &self.session.stage.sim().scene);
                slow.into_iter()
                    .for_each(|words| self.session.stage.notices.say(Topic::Other, words));
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

    #[expect(clippy::wildcard_enum_match_arm, reason = "events that the window does not use")]
    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.unsettled = SETTLING_FRAMES;
        }
        self.hear(&event);
        match event {
            // As a key, so that a recording has it and unsaved changes are asked about.
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
                let known =
                    !self.mode_changes && self.pointer.holds() == self.session.view.grabs_pointer();
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
                self.buttons =
                    if pressed { self.buttons + 1 } else { self.buttons.saturating_sub(1) };
                self.events.push(if pressed {
                    Input::ButtonDown(button)
                } else {
                    Input::ButtonUp(button)
                });
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let scale = self.screen.as_ref().map_or(1.0, |screen| screen.window.scale_factor());
                self.events.extend(self.wheel.notches(delta, scale).map(Input::Wheel));
            }
            WindowEvent::Touch(Touch { phase, location, id, .. }) => {
                let phase = match phase {
                    winit::event::TouchPhase::Started => TouchPhase::Down,
                    winit::event::TouchPhase::Moved => TouchPhase::Move,
                    winit::event::TouchPhase::Ended => TouchPhase::Up,
                    winit::event::TouchPhase::Cancelled => TouchPhase::Cancel,
                };
                self.events.push(Input::Touch(id, phase, location.x, location.y));
            }
            WindowEvent::DroppedFile(path) => match &self.recorder {
                None => self.session.leave(Order::Open(path.to_string_lossy().into_owned())),
                Some(_) => {
                    let what =
                        "a recording keeps its scene; drop files on a window that does not record";
                    self.session.stage.notices.say(Topic::File, what.to_owned());
                }
            },
            WindowEvent::Occluded(occluded) => self.occluded = occluded,
            WindowEvent::RedrawRequested => self.frame(event_loop),
            _ => {}
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: Event) {
        self.unsettled = SETTLING_FRAMES;
        match event.window_event {
            accesskit_winit::WindowEvent::InitialTreeRequested => {
                self.session.egui().enable_accesskit();
            }
            accesskit_winit::WindowEvent::AccessibilityDeactivated => {
                self.session.egui().disable_accesskit();
            }
            accesskit_winit::WindowEvent::ActionRequested(request) => {
                self.events.extend(serde_json::to_string(&request).map(Input::Assist));
            }
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
        // If the time is longer than a clock can count, nothing changes: the window waits for an event.
        let waits = Duration::try_from_secs_f64(changes_in).ok().map(|waits| waits.max(shortest));
        let due = self.last_frame.map_or(Some(now), |last| last.checked_add(waits?));
        match due {
            Some(due) if due > now => {
                self.rested |= changes_in > 0.0;
                event_loop.set_control_flow(ControlFlow::WaitUntil(due));
            }
            // Some systems request no frame of a window that is not seen.
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
    pub fn new(
        session: Session,
        recorder: Option<Recorder>,
        drafts: Drafts,
        files: CommandFiles,
        proxy: EventLoopProxy<Event>,
    ) -> Self {
        Self {
            proxy,
            session,
            recorder,
            screen: None,
            drafts,
            pointer: Pointer::default(),
            events: Vec::new(),
            down: HashMap::new(),
            modifiers: ModifiersState::empty(),
            latin: true,
            focused: true,
            mode_changes: false,
            clock: FrameClock::default(),
            start: Instant::now(),
            last_frame: None,
            unsettled: SETTLING_FRAMES,
            rested: false,
            occluded: false,
            opened: false,
            wheel: Wheel::default(),
            speed: Speed::default(),
            failure: None,
            arrangement: None,
            arranged: None,
            buttons: 0,
            remembered: None,
            files,
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        self.failure = Some(failure);
        event_loop.exit();
    }

    /// Does an action as its key does, in the next frame.
    fn press(&mut self, act: Act) {
        let key = act.key();
        self.events.extend([Input::KeyDown(key.clone()), Input::KeyUp(key)]);
    }

    fn focus(&mut self, focused: bool) {
        self.focused = focused;
        if !focused {
            self.down.clear();
            self.buttons = 0;
            self.events.push(Input::FocusLost);
        }
    }

    /// Takes the text that an event types, pastes or composes into a field. Keys, pointer and fingers are not egui's alone: they
    /// reach it by way of the session, under names that scripts and recordings have.
    #[expect(clippy::wildcard_enum_match_arm, reason = "events that the sandbox does not use")]
    fn hear(&mut self, event: &WindowEvent) {
        let takes_text = self.session.takes_text();
        // For these egui-winit reads a clipboard, which may take seconds.
        let reads =
            matches!(event, WindowEvent::KeyboardInput { .. } | WindowEvent::MouseInput { .. });
        let Some(screen) = self.screen.as_mut().filter(|_| takes_text || !reads) else { return };
        let _ = screen.platform.on_window_event(&screen.window, event);
        let heard = std::mem::take(&mut screen.platform.egui_input_mut().events);
        for event in heard.into_iter().filter(|_| takes_text) {
            match event {
                egui::Event::Text(text) => self.events.push(Input::Text(text)),
                // All fields have one line.
                egui::Event::Paste(text) => {
                    self.events.push(Input::Text(text.lines().collect::<Vec<_>>().join(" ")));
                }
                egui::Event::Ime(ImeEvent::Preedit { text, .. }) => {
                    self.events.push(Input::Compose(text));
                }
                egui::Event::Ime(ImeEvent::Commit(text)) => {
                    self.events.extend([Input::Compose(String::new()), Input::Text(text)]);
                }
                _ => {}
            }
        }
    }

    fn key(&mut self, event: &KeyEvent) {
        match event.state {
            ElementState::Pressed => {
                let (logical, physical) = (&event.logical_key, event.physical_key);
                let is_mac = cfg!(target_os = "macos");
                let latin = &mut self.latin;
                let key = keys::named(logical, physical, self.modifiers, is_mac, latin);
                let Some(key) = key else { return };
                let repeats = || binding(&key).is_some_and(Binding::repeats);
                if !event.repeat || self.session.takes_text() || repeats() {
                    self.mode_changes |=
                        binding(&key).is_some_and(|row| row.act == Act::ToggleMode);
                    self.note_time(&key);
                    self.events.push(Input::KeyDown(key.clone()));
                    self.down.insert(event.physical_key, key);
                }
            }
            ElementState::Released => {
                if let Some(key) = self.down.remove(&event.physical_key) {
                    self.note_time(&key);
                    self.events.push(Input::KeyUp(key));
                }
            }
        }
    }

    /// Records when a key that pushes goes down or up, between two frames.
    fn note_time(&mut self, key: &Key) {
        if binding(key).is_some_and(|row| matches!(row.lasts, Lasts::While(Hold::Push(_)))) {
            self.events.push(Input::At(self.start.elapsed().as_secs_f64()));
        }
    }

    /// Whether the next frame may differ even if the session does not change by itself.
    fn is_unsettled(&self) -> bool {
        self.unsettled > 0 || !self.events.is_empty()
    }

    /// Whether the window is not seen. A window with the keyboard is not minimized, which saves asking the system.
    fn is_hidden(&self) -> bool {
        let minimized = |screen: &Screen| screen.window.is_minimized() == Some(true);
        self.occluded || (!self.focused && self.screen.as_ref().is_some_and(minimized))
    }

    /// Does one frame: the events since the last one, ticks, and a picture if the window is seen.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let now = Instant::now();
        let hidden = self.is_hidden();
        // A recording needs panels in every frame, because its replay has them.
        self.session.set_unseen(hidden && self.recorder.is_none());
        self.unsettled = self.unsettled.saturating_sub(1);
        if std::mem::take(&mut self.rested) {
            // The event that ended the rest happened now, not when the rest began.
            self.advance(now.checked_sub(SHORTEST_FRAME).unwrap_or(now), Vec::new());
        }
        let events = std::mem::take(&mut self.events);
        self.advance(now, events);
        self.last_frame = Some(now);
        self.mode_changes = false;
        // As a key, so that a recording has it; an open question would take the key.
        if self.session.view.has_bars()
            && !self.session.asks()
            && std::mem::take(&mut self.opened)
            && self.session.view.should_be_framed(&self.session.stage)
        {
            self.press(Act::Frame);
        }
        if let Some(screen) = &mut self.screen {
            let holds = self.focused && self.session.view.grabs_pointer();
            let [corner, size] = self.session.view.view_area();
            self.pointer.follow(&screen.window, holds, corner + size / 2.0);
            screen.carry_out(&mut self.session, holds);
        }
        let drawn = match &mut self.screen {
            Some(screen) if !hidden => screen.draw(&mut self.session),
            _ => Ok(false),
        };
        if !hidden && matches!(drawn, Ok(false)) {
            self.unsettled = self.unsettled.max(1);
        }
        if hidden && self.session.asks() {
            self.show();
        }
        match drawn.and_then(|drawn| self.carry_out_orders(drawn)) {
            Ok(false) => {}
            Ok(true) => event_loop.exit(),
            Err(failure) => {
                if matches!(failure, Failure::NoAdapter(_)) {
                    self.save_last_minute();
                }
                self.fail(event_loop, failure);
            }
        }
        self.drafts.keep(&mut self.session);
        self.keep_files();
        self.keep_arrangement();
    }

    /// Carries out the orders of the frame. Returns whether the window is to close. Orders with a picture wait for a frame that
    /// was drawn.
    fn carry_out_orders(&mut self, drawn: bool) -> Result<bool, Failure> {
        let has_picture = |order: &Order| matches!(order, Order::Screenshot(_) | Order::Bundle);
        let orders = self.session.stage.take_orders();
        let (now, later) = orders.into_iter().partition(|order| drawn || !has_picture(order));
        self.session.stage.orders = later;
        self.opened |=
            now.iter().any(|order: &Order| matches!(order, Order::Open(_) | Order::Restore(_)));
        let mut program = WindowProgram {
            screen: self.screen.as_mut(),
            drafts: &mut self.drafts,
            files: &mut self.files,
        };
        carry_out(now, &mut self.session, &mut program)
    }

    /// Writes the run into a bundle without a picture: the device is lost.
    fn save_last_minute(&mut self) {
        let mut program =
            WindowProgram { screen: None, drafts: &mut self.drafts, files: &mut self.files };
        let path = PathBuf::from(program.name(BUNDLE, &self.session));
        let written = program
            .files()
            .unread(&path)
            .and_then(|path| write_bundle(&path, &self.session.stage, None));
        match written {
            Ok(()) => tell(&format!("wrote {}", path.display())),
            Err(failure) => tell(&failure.to_string()),
        }
    }

    /// Remembers which files were opened and saved, at once, so that a crash loses none.
    fn keep_files(&mut self) {
        let files = self.session.stage.files.all();
        if let Some(before) = self.remembered.as_deref().filter(|before| *before != files) {
            remembered::keep_files(before, files);
            self.remembered = Some(files.to_owned());
        }
    }

    /// Remembers how the panels are arranged and which lessons were done, at once, so that neither a crash nor another window
    /// loses it.
    fn keep_arrangement(&mut self) {
        if self.buttons > 0 || self.arrangement.is_some() {
            return;
        }
        let Some(before) = &mut self.arranged else { return };
        let now = self.session.arrangement();
        if now != *before {
            remembered::keep_arrangement(before, &now);
            *before = now;
        }
    }

    /// Brings back a window that has a question.
    fn show(&self) {
        if let Some(screen) = &self.screen {
            screen.window.set_minimized(false);
            screen.window.focus_window();
        }
    }

    /// Advances the session to `now`.
    fn advance(&mut self, now: Instant, events: Vec<Input>) {
        // Wall time only goes forward, and so does this.
        let Ok(time) = self.clock.advance_to((now - self.start).as_secs_f64()) else {
            self.events.splice(0..0, events);
            return;
        };
        if let Some(recorder) = &mut self.recorder {
            let inputs = self.session.chosen.iter().chain(&events);
            if let Err(failure) =
                recorder.record(self.session.stage.playback().frames(), time.total(), inputs)
            {
                self.session
                    .stage
                    .notices
                    .say(Topic::File, format!("the recording is written at the end: {failure}"));
            }
        }
        let (before, ticks_before) = (Instant::now(), self.session.stage.sim().ticks());
        let progress = |stage: &Stage| stage.playback().progress(stage.sim());
        let progress_before = progress(&self.session.stage);
        // Measured to the end of the last tick: the panels, which come after it, take longer than all ticks.
        let mut after = before;
        // A recording is played back without a wall clock.
        let patience = if self.recorder.is_some() { Duration::MAX } else { PATIENCE };
        let was_seeking = self.session.stage.recorder().is_seeking();
        self.session.advance_watched(&InputFrame { events }, time, &mut |_, _| {
            after = Instant::now();
            if after - before > patience { Look::Break(()) } else { Look::Continue(()) }
        });
        // Panels are laid out before a seek ends.
        if was_seeking && !self.session.stage.recorder().is_seeking() {
            self.unsettled = SETTLING_FRAMES;
        }
        self.speed.frame(speed::Sample {
            length_s: time.length(),
            // A run that went back simulated nothing.
            simulated_s: (progress(&self.session.stage) - progress_before).max(0.0),
            ticks: self.session.stage.sim().ticks().saturating_sub(ticks_before),
            ticking: after - before,
            setting: SpeedSetting::of(&self.session),
        });
        self.session.set_measured(self.speed.measured());
    }
}
