//! The page around a session: its events, its frames, and what it keeps.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use bevy_ecs::prelude::{Entity, World};
use cockpit::Control;
use cockpit::actions::{Act, Binding, binding};
use cockpit::app::arrangement::{FIRST_START, with_changes};
use cockpit::app::frame_loop::{FrameLoop, SHORTEST_FRAME_S};
use cockpit::app::session::{DEFAULT_FPS, Session};
use cockpit::input::keyboard::{Keyboard, Modifiers};
use cockpit::input::{Button, Input, Key};
use cockpit::stage::Order;
use cockpit::stage::notices::Topic;
use cockpit::stage::options::Options;
use cockpit::view::on_device::words;
use history::{Bundle, Rerun, TIMELINE_BYTES};
use lab::lesson::LessonRuns;
use motion::{Gravity, PhysicsBody};
use render::{RenderError, Screen};
use scene::lesson::{Lesson, beside};
use scene::{Scene, SceneError};
use serde_json::{Value, json};
use web_time::Instant;

use crate::host::{After, Host, Shared};
use crate::shots::{Counts, Shot};

/// Name under which the arrangement of the panels and the finished lessons are kept.
const ARRANGEMENT: &str = "window";

/// Frames in which fonts are read and the panels are laid out for the first time.
const FRAMES_OF_START: u64 = 3;

/// Name of the scene of a link that carries its text.
const LINKED: &str = "link";

/// Time of a frame in which the runs of a lesson are simulated, s.
const WORK_OF_FRAME_S: f64 = 0.03;

/// What a link names.
pub(crate) struct Link {
    pub name: Option<String>,
    pub text: Option<String>,
    pub lesson: Option<String>,
    pub bare: bool,
}

/// What opens once it has been simulated.
enum Opening {
    /// A lesson with its runs.
    Lesson(Box<(Lesson, LessonRuns)>),
    /// A bundle with its name and its scene.
    Bundle(Box<(String, Bundle, Scene, Rerun)>),
}

pub(crate) struct Shell {
    pub host: Host,
    pub session: Session,
    pub frames: FrameLoop,
    keyboard: Keyboard,
    /// The meaning of each key when it went down, by its code: shift may be released before the key.
    down: HashMap<String, Key>,
    /// Number of mouse buttons that are down: what a drag changes is kept at its end.
    buttons: u32,
    /// Whether a key that changes the mode waits for its frame: until then, motion could belong to either mode.
    mode_changes: bool,
    pub screen: Option<Screen>,
    /// A screen whose device is lost.
    lost: Option<Screen>,
    size_px: [u32; 2],
    start: Instant,
    frame: u64,
    /// The controls of the last layout; `None` before [`Self::state`] is asked for them.
    controls: Option<Vec<Control>>,
    /// Longest time that a frame took besides its picture, s, but for those of the start.
    longest_s: f64,
    /// The arrangement that was kept last; `None` if none is kept.
    arranged: Option<String>,
    /// Name of the draft of this page, and the text that it has.
    draft: (String, Option<Arc<str>>),
    opening: Option<Opening>,
    pub shots: Vec<Shot>,
    pub counts: Counts,
    /// The texts of files that were given, by name.
    given: HashMap<String, String>,
}

impl Shell {
    pub fn new(
        host: Host,
        link: Link,
        narrow: bool,
        draft: String,
        left_behind: Option<String>,
    ) -> Self {
        let begin = |scene| {
            let mut session = Session::new(scene, Options::default());
            session.stage.keep_timeline();
            session
        };
        let (session, said) = match scene_of(&link) {
            Ok(scene) => (begin(scene), None),
            Err(error) => {
                let tutorial = scene::load("tutorial").expect("it is part of the program");
                (begin(tutorial), Some(error.to_string()))
            }
        };
        let mut shell = Self {
            session,
            frames: FrameLoop::default(),
            keyboard: Keyboard::new(host.is_mac()),
            host,
            down: HashMap::new(),
            buttons: 0,
            mode_changes: false,
            screen: None,
            lost: None,
            size_px: Options::default().size_px,
            start: Instant::now(),
            frame: 0,
            controls: None,
            longest_s: 0.0,
            arranged: None,
            draft: (draft, None),
            opening: None,
            shots: Vec::new(),
            counts: Counts::default(),
            given: HashMap::new(),
        };
        shell.session.view.by_finger = narrow;
        // A page that draws late is taken for one that hangs.
        shell.frames.patience_s = 0.05;
        if let Some(said) = said {
            shell.session.stage.notices.say(Topic::File, said);
        }
        if !link.bare {
            let is_of_link = link.name.is_some() || link.text.is_some() || link.lesson.is_some();
            shell.arrange(!is_of_link);
        }
        if let Some(lesson) = &link.lesson {
            if let Err(why) = shell.begin_lesson(lesson) {
                shell.session.stage.notices.say(Topic::FileError, why);
            }
        }
        if let Some(draft) = left_behind.filter(|_| !link.bare) {
            shell.session.offer(PathBuf::from(draft));
        }
        shell.opened();
        shell
    }

    /// Arranges the panels as they were left. The card of the first visit waits until a page can show it.
    fn arrange(&mut self, can_show_card: bool) {
        let kept = self.host.get(ARRANGEMENT);
        let is_first = kept.as_ref().is_none_or(|kept| kept.contains(FIRST_START));
        let left = kept.unwrap_or_default().replace(FIRST_START, "");
        let shows_card = is_first && can_show_card;
        if is_first {
            let text = if shows_card { left.clone() } else { left.clone() + FIRST_START };
            self.host.set(ARRANGEMENT, Some(&text));
        }
        let card = if shows_card { FIRST_START } else { "" };
        self.frames.events.push(Input::Arrange(format!("{card}{left}")));
        self.arranged = Some(left);
        self.session.opened = true;
    }

    pub fn take_screen(&mut self, mut screen: Screen) {
        if let Some(lost) = self.lost.take() {
            screen.replace(lost);
        }
        screen.target.resize(&screen.gpu, self.size_px);
        self.screen = Some(screen);
        self.tell_of_device();
        self.frames.wake();
    }

    pub fn lose_device(&mut self) {
        self.shots.clear();
        if let Some(screen) = self.screen.take() {
            self.lost = Some(screen);
        }
    }

    /// Called after another scene was opened.
    pub fn opened(&mut self) {
        self.session.tools.forecast_begin(&mut self.session.stage, 1.0 / DEFAULT_FPS);
        self.tell_of_device();
    }

    /// Tells the person what of the scene the device cannot do.
    fn tell_of_device(&mut self) {
        let Some(screen) = &self.screen else { return };
        let words = words(&screen.gpu, &self.session.stage.sim().scene);
        words.into_iter().for_each(|words| self.session.stage.notices.say(Topic::Other, words));
    }

    pub fn input(&mut self, input: Input) {
        self.frames.wake();
        self.frames.events.push(input);
    }

    pub fn resize(&mut self, size_px: [u32; 2], scale: f64) {
        self.size_px = size_px;
        if let Some(screen) = &mut self.screen {
            screen.target.resize(&screen.gpu, size_px);
        }
        if size_px[0] > 0 && size_px[1] > 0 {
            self.input(Input::Resized(size_px));
        }
        self.input(Input::Scaled(scale));
    }

    pub fn key_down(&mut self, key: &str, code: &str, modifiers: Modifiers, repeats: bool) -> bool {
        let Some(key) = self.keyboard.named(key, code, modifiers) else { return false };
        let row = binding(&key);
        if !repeats || self.session.takes_text() || row.is_some_and(Binding::repeats) {
            self.mode_changes |= row.is_some_and(|row| row.act == Act::ToggleMode);
            self.take_key(key.clone(), true);
            self.down.insert(code.to_owned(), key.clone());
        }
        let is_named = key.name().chars().count() > 1;
        match self.session.takes_text() {
            // The browser types and pastes.
            true => (is_named && key.name() != "Space") || (key.ctrl() && key.name() != "V"),
            false => is_named || row.is_some(),
        }
    }

    pub fn key_up(&mut self, code: &str) -> bool {
        let Some(key) = self.down.remove(code) else { return false };
        self.take_key(key, false);
        true
    }

    fn take_key(&mut self, key: Key, down: bool) {
        self.frames.wake();
        self.frames.key(key, down, self.start.elapsed().as_secs_f64());
    }

    pub fn pointer(&mut self, place: [f64; 2], by: [f64; 2]) {
        if !self.mode_changes {
            let [x, y] = if self.session.view.grabs_pointer() { by } else { place };
            self.input(Input::Mouse(x, y));
        }
    }

    pub fn button(&mut self, button: Button, down: bool) {
        self.buttons = if down { self.buttons + 1 } else { self.buttons.saturating_sub(1) };
        self.input(if down { Input::ButtonDown(button) } else { Input::ButtonUp(button) });
    }

    pub fn blur(&mut self) {
        self.down.clear();
        self.buttons = 0;
        self.input(Input::FocusLost);
    }

    /// Reads a scene by its name: a file that was given, or a shipped scene.
    pub fn load(&self, name: &str) -> Result<Scene, SceneError> {
        match self.given.get(name) {
            Some(text) => Scene::parse(name, text),
            None => scene::load(name),
        }
    }

    /// Opens what a link names, in place of what is open.
    pub fn open_link(&mut self, link: Link) {
        let order = match (link.lesson, link.text) {
            (Some(lesson), _) => Order::Lesson(lesson),
            (None, Some(text)) => {
                self.given.insert(LINKED.to_owned(), text);
                Order::Open(LINKED.to_owned())
            }
            (None, None) => Order::Open(link.name.unwrap_or_else(|| "tutorial".to_owned())),
        };
        self.session.leave(order);
        self.frames.wake();
    }

    fn tell(&mut self, done: Result<(), String>) {
        if let Err(why) = done {
            self.session.stage.notices.say(Topic::FileError, why);
        }
        self.frames.wake();
    }

    pub fn open_files(&mut self, files: Vec<(String, Vec<u8>)>) {
        let opened = self.open_given(files);
        self.tell(opened);
    }

    fn open_given(&mut self, files: Vec<(String, Vec<u8>)>) -> Result<(), String> {
        let mut names = Vec::new();
        for (name, bytes) in files {
            if Bundle::begins_with(&bytes) {
                return self.open_bundle(&name, &bytes);
            }
            let text =
                String::from_utf8(bytes).map_err(|_| format!("{name}: it is not UTF-8 text"))?;
            self.given.insert(name.clone(), text);
            names.push(name);
        }
        let is_lesson =
            |name: &&String| self.given.get(*name).is_some_and(|text| scene::lesson::is_text(text));
        if let Some(lesson) = names.iter().find(is_lesson) {
            self.session.leave(Order::Lesson(lesson.clone()));
        } else if let Some(name) = names.pop() {
            self.session.leave(Order::Open(name));
        }
        Ok(())
    }

    /// Checks that nothing is lost if a bundle replaces the scene.
    fn may_leave(&self, name: &str) -> Result<(), String> {
        let what = "this scene has unsaved changes; save or undo them first";
        if self.session.has_unsaved_changes() { Err(format!("{name}: {what}")) } else { Ok(()) }
    }

    fn open_bundle(&mut self, name: &str, bytes: &[u8]) -> Result<(), String> {
        self.may_leave(name)?;
        let failed = |error: &dyn ToString| format!("{name}: {}", error.to_string());
        let bundle = Bundle::read(bytes).map_err(|error| failed(&error))?;
        let scene =
            bundle.scene(&format!("{name}: scene.ron")).map_err(|error| error.to_string())?;
        let rerun = Rerun::begin(scene.clone(), &bundle, TIMELINE_BYTES);
        let rerun = rerun.map_err(|error| failed(&error))?;
        let opening = Opening::Bundle(Box::new((name.to_owned(), bundle, scene, rerun)));
        self.opening = Some(opening);
        Ok(())
    }

    /// Begins to simulate the runs of a lesson: one that was given, or a shipped one. Its scene opens when they are done.
    pub fn begin_lesson(&mut self, name: &str) -> Result<(), String> {
        let lesson = match self.given.get(name) {
            Some(text) => Lesson::parse_with(name, text, &|name| self.load(name)),
            None => scene::lesson::load(name),
        };
        let lesson = lesson.map_err(|error| error.to_string())?;
        let runs = LessonRuns::new(&lesson, 1.0, |name| self.load(name));
        let runs = runs.map_err(|error| error.to_string())?;
        self.opening = Some(Opening::Lesson(Box::new((lesson, runs))));
        Ok(())
    }

    /// Continues to simulate what is opened next, and opens it at its end.
    fn work_on_opening(&mut self) {
        let Some(mut opening) = self.opening.take() else { return };
        let is_over = match &mut opening {
            Opening::Lesson(lesson) => lesson.1.work(WORK_OF_FRAME_S),
            Opening::Bundle(bundle) => {
                let (_, bundle, _, rerun) = &mut **bundle;
                let start = Instant::now();
                loop {
                    if !rerun.tick(bundle) {
                        break true;
                    }
                    if start.elapsed().as_secs_f64() >= WORK_OF_FRAME_S {
                        break false;
                    }
                }
            }
        };
        if !is_over {
            let words = match &opening {
                Opening::Lesson(_) => "measuring the runs of the lesson",
                Opening::Bundle(_) => "repeating the run of the bundle",
            };
            self.session.stage.notices.say(Topic::File, words);
            self.opening = Some(opening);
            return;
        }
        let opened = self.open_simulated(opening);
        self.tell(opened);
    }

    fn open_simulated(&mut self, opening: Opening) -> Result<(), String> {
        match opening {
            Opening::Lesson(lesson) => {
                let (lesson, runs) = *lesson;
                let scene = self.load(&beside(&lesson.name, &lesson.scene));
                self.session.open(scene.map_err(|error| error.to_string())?);
                self.opened();
                self.session.begin_lesson(lesson, runs.measured());
            }
            Opening::Bundle(bundle) => {
                let (name, Bundle { manifest, .. }, scene, rerun) = *bundle;
                self.may_leave(&name)?;
                let options = Options { size_px: self.size_px, ..Options::default() };
                let (mut session, repetition) = Session::of_rerun(rerun, scene, &manifest, options);
                session.show_repetition(&name, &repetition, &manifest);
                let arrangement = self.session.arrangement();
                self.session = session;
                self.frames.events.push(Input::Arrange(arrangement));
            }
        }
        Ok(())
    }

    pub fn shared(&self) -> Shared {
        let scene = &self.session.stage.sim().scene;
        let shipped =
            scene::embedded(&scene.name).is_some_and(|shipped| *shipped.text == *scene.text);
        match shipped {
            true => Shared { name: Some(scene.name.clone()), text: None },
            false => Shared { name: None, text: Some(scene.text.to_string()) },
        }
    }

    pub fn frame(&mut self) -> After {
        self.frame += 1;
        let start = self.start;
        let clock = || start.elapsed().as_secs_f64();
        let before = clock();
        self.work_on_opening();
        self.frames.frame(&mut self.session, &clock, None);
        if self.frame > FRAMES_OF_START {
            self.longest_s = self.longest_s.max(clock() - before);
        }
        self.mode_changes = false;
        let drawn = match &mut self.screen {
            Some(screen) => screen.draw(|| self.session.picture(), || {}),
            None => Ok(false),
        };
        let lost = matches!(drawn, Err(RenderError::Lost { .. }));
        if !matches!(drawn, Ok(true)) {
            self.frames.draw_again();
        }
        self.carry_out_orders();
        self.finish_shots();
        self.keep_draft();
        self.keep_arrangement();
        let mut after = self.after();
        after.lost = lost;
        after
    }

    /// What the script does after the frame.
    fn after(&mut self) -> After {
        let mut after = After {
            holds_pointer: self.session.view.grabs_pointer(),
            takes_text: self.session.takes_text(),
            ..After::default()
        };
        if let Some(controls) = &mut self.controls {
            *controls = self.session.controls();
        }
        if let Some(requests) = self.session.take_requests() {
            after.cursor = cursor(requests.cursor_icon).to_owned();
            for command in requests.commands {
                match command {
                    egui::OutputCommand::CopyText(text) => after.copied = Some(text),
                    egui::OutputCommand::OpenUrl(link) => after.opens = Some(link.url),
                    egui::OutputCommand::CopyImage(_)
                    | egui::OutputCommand::TextSelectionSettled(_) => {}
                }
            }
        }
        let now = self.start.elapsed().as_secs_f64();
        let works = self.opening.is_some() || !self.shots.is_empty();
        let due = self.frames.due(&mut self.session, now, SHORTEST_FRAME_S);
        after.due_s = if works { 0.0 } else { (due - now).max(0.0) };
        after
    }

    /// Keeps the unsaved changes in case the page is closed, instead of earlier ones.
    pub fn keep_draft(&mut self) {
        let unsaved = self.session.unsaved();
        if self.draft.1.as_ref().map(Arc::as_ptr) != unsaved.as_ref().map(Arc::as_ptr) {
            self.host.set(&self.draft.0, unsaved.as_deref());
            self.draft.1 = unsaved;
        }
    }

    /// Keeps how the panels are arranged and which lessons were done; another page may have kept other lines.
    fn keep_arrangement(&mut self) {
        let Some(before) = self.arranged.as_mut().filter(|_| self.buttons == 0 && self.frame > 1)
        else {
            return;
        };
        let now = self.session.arrangement();
        if now != *before {
            let there = self.host.get(ARRANGEMENT).unwrap_or_default();
            self.host.set(ARRANGEMENT, Some(&with_changes(&there, before, &now)));
            *before = now;
        }
    }

    /// The present state, for tests of the page.
    pub fn state(&mut self) -> Value {
        self.controls.get_or_insert_with(|| {
            // From here on they are named.
            let _ = self.session.controls();
            self.frames.wake();
            Vec::new()
        });
        let stage = &self.session.stage;
        let sim = stage.sim();
        let lesson = self.session.tools.lesson();
        let controls = self.controls.iter().flatten().map(|control| {
            json!({ "role": control.role, "name": control.name, "rect_px": control.rect_px })
        });
        json!({
            "frames": self.frame,
            "longest_ms": 1e3 * self.longest_s,
            "scene": sim.scene.name,
            "ticks": sim.ticks(),
            "step_hz": stage.playback().step_hz(),
            "hash": format!("{:016x}", sim.hash()),
            "method": sim.method().name(),
            "bodies": sim.scene.bodies.len(),
            "gravity": sim.world.get_resource::<Gravity>().is_some_and(|gravity| gravity.on),
            "click_force": self.session.view.click_force(),
            "speed": stage.selection().and_then(|body| speed(&sim.world, body)),
            "device": self.screen.as_ref().map(|screen| screen.gpu.info.to_string()),
            "takes_text": self.session.takes_text(),
            "paused": stage.playback().paused(),
            "camera_mode": self.session.view.grabs_pointer(),
            "selection": stage.selection().map(|thing| stage.name(thing)),
            "lesson": lesson.as_ref().map(|lesson| json!([lesson.name, lesson.step])),
            "asks": self.session.asks(),
            "unsaved": self.session.has_unsaved_changes(),
            "notices": stage.notices.texts().collect::<Vec<_>>(),
            "controls": controls.collect::<Vec<_>>(),
        })
    }
}

/// The speed of a body, m/s.
fn speed(world: &World, body: Entity) -> Option<f64> {
    Some(world.get::<PhysicsBody>(body)?.velocity.length())
}

/// The scene that a link names: the tutorial if it names none.
fn scene_of(link: &Link) -> Result<Scene, SceneError> {
    match (&link.text, &link.name) {
        (Some(text), _) => Scene::parse(LINKED, text),
        (None, name) => scene::load(name.as_deref().unwrap_or("tutorial")),
    }
}

/// The name of a shape of the pointer in CSS.
#[expect(clippy::wildcard_enum_match_arm, reason = "shapes that the panels do not use")]
fn cursor(icon: egui::CursorIcon) -> &'static str {
    use egui::CursorIcon as Icon;
    match icon {
        Icon::None => "none",
        Icon::PointingHand => "pointer",
        Icon::Text => "text",
        Icon::Grab => "grab",
        Icon::Grabbing => "grabbing",
        Icon::ResizeHorizontal | Icon::ResizeColumn => "ew-resize",
        Icon::ResizeVertical | Icon::ResizeRow => "ns-resize",
        Icon::NotAllowed => "not-allowed",
        _ => "default",
    }
}
