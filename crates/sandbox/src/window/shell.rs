//! The window's events, its clock and its frames.

use std::collections::HashMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::ImeEvent;
use egui_winit::accesskit_winit::{self, Event};
use winit::application::ApplicationHandler;
use winit::event::{
    DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, Touch, WindowEvent,
};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key as Logical, ModifiersState, PhysicalKey};
use winit::window::WindowId;

use super::drafts::Drafts;
use super::pinch::{self, Pinch};
use super::pointer::Pointer;
use super::program::WindowProgram;
use super::recorder::Recorder;
use super::remembered;
use super::screen::Screen;
use super::wheel::Wheel;
use crate::failure::Failure;
use crate::output::bundle::write_bundle;
use crate::output::command_files::CommandFiles;
use crate::output::on_device::check;
use crate::output::orders::{BUNDLE, Program as _, carry_out};
use crate::output::tell;
use cockpit::actions::{Act, Binding, binding};
use cockpit::app::frame_loop::{FrameLoop, Record, SHORTEST_FRAME_S};
use cockpit::app::session::Session;
use cockpit::input::keyboard::{Keyboard, Modifiers};
use cockpit::input::{Button, Input, Key};
use cockpit::stage::Order;
use cockpit::stage::notices::Topic;
use cockpit::view::on_device::slow_words;

/// Time between two frames of a window that is not seen, s: it continues to simulate, and draws nothing.
const HIDDEN_FRAME_S: f64 = 0.1;

/// The window and its session.
pub(super) struct Shell {
    pub session: Session,
    pub recorder: Option<Recorder>,
    screen: Option<Screen>,
    pub drafts: Drafts,
    pointer: Pointer,
    pub frames: FrameLoop,
    /// The meaning of each key when it went down: shift may be released before the key.
    down: HashMap<PhysicalKey, Key>,
    modifiers: ModifiersState,
    keyboard: Keyboard,
    focused: bool,
    /// Whether a key that changes the mode waits for its frame: until then, motion could belong to either mode.
    mode_changes: bool,
    start: Instant,
    occluded: bool,
    wheel: Wheel,
    pinch: Pinch,
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
        match Screen::open(event_loop, size_px, egui, self.proxy.clone()) {
            Ok(screen) => {
                if let Err(failure) = check(&screen.surface.gpu, &self.session.stage.sim().scene) {
                    return self.fail(event_loop, failure);
                }
                let slow = slow_words(&screen.surface.gpu, &self.session.stage.sim().scene);
                slow.into_iter()
                    .for_each(|words| self.session.stage.notices.say(Topic::Other, words));
                let size = screen.window.inner_size();
                self.frames.events.push(Input::Resized([size.width, size.height]));
                self.frames.events.push(Input::Scaled(screen.window.scale_factor()));
                // As input of the first frame, so that a recording has it too.
                self.frames.events.extend(self.arrangement.take().map(Input::Arrange));
                self.screen = Some(screen);
                self.start = Instant::now();
            }
            Err(failure) => self.fail(event_loop, failure),
        }
    }

    #[expect(clippy::wildcard_enum_match_arm, reason = "events that the window does not use")]
    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.frames.wake();
        }
        self.hear(&event);
        match event {
            // As a key, so that a recording has it and unsaved changes are asked about.
            WindowEvent::CloseRequested => self.frames.press(Act::Quit),
            WindowEvent::Resized(size) => {
                if let Some(screen) = &mut self.screen {
                    screen.surface.target.resize(&screen.surface.gpu, [size.width, size.height]);
                }
                // A minimized window keeps the picture's size: rays and panels need one.
                if size.width > 0 && size.height > 0 {
                    self.frames.events.push(Input::Resized([size.width, size.height]));
                }
            }
            WindowEvent::ScaleFactorChanged { scale_factor, .. } => {
                self.frames.events.push(Input::Scaled(scale_factor));
            }
            WindowEvent::Focused(focused) => self.focus(focused),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event),
            WindowEvent::CursorMoved { position, .. } => {
                self.pinch.pointer = position;
                let known =
                    !self.mode_changes && self.pointer.holds() == self.session.view.grabs_pointer();
                if let (Some(screen), true) = (&self.screen, known) {
                    self.frames.events.extend(self.pointer.moved(&screen.window, position));
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
                self.frames.events.push(if pressed {
                    Input::ButtonDown(button)
                } else {
                    Input::ButtonUp(button)
                });
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let scale = self.screen.as_ref().map_or(1.0, |screen| screen.window.scale_factor());
                self.frames.events.extend(self.wheel.notches(delta, scale).map(Input::Wheel));
            }
            WindowEvent::PinchGesture { delta, phase, .. } => {
                self.frames.events.extend(self.pinch.magnified(delta, phase));
            }
            WindowEvent::Touch(Touch { phase, location, id, .. }) => {
                let phase = pinch::named(phase);
                self.frames.events.push(Input::Touch(id, phase, location.x, location.y));
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
        self.frames.wake();
        match event.window_event {
            accesskit_winit::WindowEvent::InitialTreeRequested => {
                self.session.egui().enable_accesskit();
            }
            accesskit_winit::WindowEvent::AccessibilityDeactivated => {
                self.session.egui().disable_accesskit();
            }
            accesskit_winit::WindowEvent::ActionRequested(request) => {
                self.frames.events.extend(serde_json::to_string(&request).map(Input::Assist));
            }
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        self.wheel.raw(&event);
        if let (DeviceEvent::MouseMotion { delta }, false) = (event, self.mode_changes) {
            self.frames.events.extend(self.pointer.raw(delta));
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = self.seconds();
        let hidden = self.is_hidden();
        let shortest = if hidden { HIDDEN_FRAME_S } else { SHORTEST_FRAME_S };
        let due = self.frames.due(&mut self.session, now, shortest);
        let wait_until = |due| {
            // If the time is longer than a clock can count, nothing changes: the window waits for an event.
            let due = Duration::try_from_secs_f64(due).ok();
            let due = due.and_then(|due| self.start.checked_add(due));
            event_loop.set_control_flow(due.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        };
        if due > now {
            wait_until(due);
        } else if hidden {
            // Some systems request no frame of a window that is not seen.
            wait_until(now + HIDDEN_FRAME_S);
            self.frame(event_loop);
        } else {
            event_loop.set_control_flow(ControlFlow::Wait);
            if let Some(screen) = &self.screen {
                screen.window.request_redraw();
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
            frames: FrameLoop::default(),
            proxy,
            session,
            recorder,
            screen: None,
            drafts,
            pointer: Pointer::default(),
            down: HashMap::new(),
            modifiers: ModifiersState::empty(),
            keyboard: Keyboard::new(cfg!(target_os = "macos")),
            focused: true,
            mode_changes: false,
            start: Instant::now(),
            occluded: false,
            wheel: Wheel::default(),
            pinch: Pinch::default(),
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

    /// Time since the start, s.
    fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn focus(&mut self, focused: bool) {
        self.focused = focused;
        if !focused {
            self.down.clear();
            self.buttons = 0;
            self.frames.events.push(Input::FocusLost);
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
                egui::Event::Text(text) => self.frames.events.push(Input::Text(text)),
                // All fields have one line.
                egui::Event::Paste(text) => {
                    self.frames
                        .events
                        .push(Input::Text(text.lines().collect::<Vec<_>>().join(" ")));
                }
                egui::Event::Ime(ImeEvent::Preedit { text, .. }) => {
                    self.frames.events.push(Input::Compose(text));
                }
                egui::Event::Ime(ImeEvent::Commit(text)) => {
                    self.frames.events.extend([Input::Compose(String::new()), Input::Text(text)]);
                }
                _ => {}
            }
        }
    }

    fn key(&mut self, event: &KeyEvent) {
        match event.state {
            ElementState::Pressed => {
                let Some(key) = self.named(event) else { return };
                let repeats = || binding(&key).is_some_and(Binding::repeats);
                if !event.repeat || self.session.takes_text() || repeats() {
                    self.mode_changes |=
                        binding(&key).is_some_and(|row| row.act == Act::ToggleMode);
                    self.frames.key(key.clone(), true, self.seconds());
                    self.down.insert(event.physical_key, key);
                }
            }
            ElementState::Released => {
                if let Some(key) = self.down.remove(&event.physical_key) {
                    self.frames.key(key, false, self.seconds());
                }
            }
        }
    }

    /// The key of the program that went down.
    fn named(&mut self, event: &KeyEvent) -> Option<Key> {
        let key = match &event.logical_key {
            Logical::Character(text) => text.to_string(),
            // winit's names are W3C's.
            Logical::Named(named) => format!("{named:?}"),
            Logical::Dead(_) | Logical::Unidentified(_) => return None,
        };
        let code = match event.physical_key {
            PhysicalKey::Code(code) => format!("{code:?}"),
            PhysicalKey::Unidentified(_) => String::new(),
        };
        let modifiers = Modifiers {
            ctrl: self.modifiers.control_key(),
            shift: self.modifiers.shift_key(),
            alt: self.modifiers.alt_key(),
            logo: self.modifiers.super_key(),
        };
        self.keyboard.named(&key, &code, modifiers)
    }

    /// Whether the window is not seen. A window with the keyboard is not minimized, which saves asking the system.
    fn is_hidden(&self) -> bool {
        let minimized = |screen: &Screen| screen.window.is_minimized() == Some(true);
        self.occluded || (!self.focused && self.screen.as_ref().is_some_and(minimized))
    }

    /// Does one frame: the events since the last one, ticks, and a picture if the window is seen.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let hidden = self.is_hidden();
        // A recording needs panels in every frame, because its replay has them.
        self.session.set_unseen(hidden && self.recorder.is_none());
        let Self { session, frames, recorder, start, .. } = self;
        let clock = || start.elapsed().as_secs_f64();
        let mut record = recorder.as_mut().map(|recorder| {
            |session: &mut Session, end: f64, events: &[Input]| {
                let (frame, chosen) = (session.stage.playback().frames(), &session.chosen);
                if let Err(failure) = recorder.record(frame, end, chosen.iter().chain(events)) {
                    let what = format!("the recording is written at the end: {failure}");
                    session.stage.notices.say(Topic::FileError, what);
                }
            }
        });
        let record = record.as_mut().map(|record| record as &mut Record<'_>);
        frames.frame(session, &clock, record);
        self.mode_changes = false;
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
            self.frames.draw_again();
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
}
