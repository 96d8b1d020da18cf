//! A running scene: input and a frame time in, ticks simulated, a plain frame for the renderer out.
//!
//! The window, headless runs and tests all use it, so a headless picture is the same as the window's.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use history::{Change, Fault};
use lab::cost::Setting;
use lab::lesson::Quantities;
use motion::clock::StepClock;
use motion::{Gravity, Method, MutualGravity, Request, TimeStep};
use report::numbers::pace_words;
use scene::lesson::{Begin, Lesson};
use scene::{ChangeAction, Scene, unsolvable};

use crate::actions::Act;
use crate::app::arrangement;
use crate::app::hands::{Hands, Reach};
use crate::app::layout::lay_out;
use crate::app::player::Player;
use crate::app::script;
use crate::app::ui::{Control, Ui};
use crate::clock::{FrameClock, FrameTime};
use crate::input::{Input, InputFrame, SwitchedBy};
use crate::intent::{Answer, Intent, Question};
use crate::methods;
use crate::panels::Panel;
use crate::stage::notices::Topic;
use crate::stage::options::Options;
use crate::stage::playback::FrameTicks;
use crate::stage::things::neighbor;
use crate::stage::ticks::Look;
use crate::stage::{Order, Simulated, Stage};
use crate::tools::Tools;
use crate::tools::editor::Editor;
use crate::tools::editor::selected::{entity_at, offset_in_entry};
use crate::view::{Measured, Mode, View};

/// Frames per second of a run that specifies none.
pub const DEFAULT_FPS: f64 = 60.0;

/// Slowest and fastest pace that the keys reach, as multiples of the pace of the scene.
const PACES: [f64; 2] = [1.0 / 64.0, 16.0];

/// A running scene: the stage, the view and the tools.
pub struct Session {
    /// The run.
    pub stage: Stage,
    /// Camera, pointer, and what is drawn.
    pub view: View,
    /// The tools, which have the panels.
    pub tools: Tools,
    pub(crate) hands: Hands,
    pub(crate) ui: Ui,
    pub(crate) player: Option<Player>,
    /// The solution of a step of a lesson that is being shown: players, and when they begin, s of frame time.
    shown: Vec<(f64, Player)>,
    /// The settings that were chosen in the panels of the last frame, as inputs: a recording has them in the next one.
    pub chosen: Vec<Input>,
    /// Whether a scene was opened whose bodies are to be framed, and to which the camera comes, once the view has its place.
    pub opened: bool,
    /// Whether no picture of the next frame will be seen: its panels are then not laid out.
    unseen: bool,
    /// Number of the world that tools, view and hands last heard of.
    world: u64,
}

impl Session {
    /// Starts `scene`.
    #[must_use]
    pub fn new(scene: Scene, options: Options) -> Self {
        let stage = Stage::new(scene, options);
        Self {
            view: View::new(&stage, options.size_px),
            stage,
            tools: Tools::default(),
            hands: Hands::default(),
            ui: Ui::new(options.size_px),
            player: None,
            shown: Vec::new(),
            chosen: Vec::new(),
            opened: false,
            unseen: false,
            world: 0,
        }
    }

    /// Does one frame: everything but pixels.
    pub fn frame(&mut self, input: &InputFrame, time: FrameTime) -> render::Frame {
        self.advance(input, time);
        self.picture()
    }

    /// Does one frame without the picture: input, ticks, camera, panels.
    pub fn advance(&mut self, input: &InputFrame, time: FrameTime) {
        self.advance_watched(input, time, &mut |_, _| ControlFlow::Continue(()));
    }

    /// Does the same as [`Session::advance`], and calls `after_tick` after every tick. If that breaks, the frame's other ticks
    /// are dropped and counted as dropped time: a run that waits too long for them would never catch up. The ticks of a seek are
    /// left to the next frame instead, and nothing else is simulated until the seek ends.
    pub fn advance_watched(
        &mut self,
        input: &InputFrame,
        time: FrameTime,
        after_tick: &mut dyn FnMut(&Stage, Simulated) -> ControlFlow<()>,
    ) {
        self.chosen.clear();
        let pushing = self.hands.held.pushing();
        input.events.iter().for_each(|event| self.handle(event));
        self.play_frame(time);
        self.play_tick();
        let intents = self.with_hands(|hands, reach| hands.steer(time.length(), reach));
        intents.into_iter().for_each(|intent| self.carry_out(intent));
        if self.hands.held.pushing() > pushing && self.stage.selection().is_some() {
            self.stage.give_up_seek();
        }
        self.simulate(time, after_tick);
        self.view.follow_locked(&self.stage);
        self.tools.after_ticks(&mut self.stage, &self.view, self.ui.opened(), time);
        let begins = self.tools.learn.take_begin(&self.stage, time.total());
        begins.into_iter().for_each(|begin| self.begin_step(begin));
        if let Some(solution) = self.tools.learn.take_solution() {
            self.shown = script::shown(&solution, time.total());
        }
        self.show_panels(time);
        self.stage.continue_seek(after_tick);
        self.follow();
        self.stage.playback_mut().count_frame();
    }

    fn simulate(&mut self, time: FrameTime, look: Look<'_>) {
        self.begin_tools();
        let ticks = self.stage.begin_ticks(time, look);
        self.follow();
        let Some(FrameTicks { number: ticks, step }) = ticks else { return };
        let (mut undone, mut late) = (0, false);
        for tick in 1..=ticks {
            let played = tick > 1 && self.play_tick();
            let [due, nearly] =
                self.stage.playback().end_of_tick(ticks - tick, self.stage.sim().scene.step);
            self.with_hands(|hands, reach| hands.push(due, nearly, reach));
            match tick {
                1 => self.stage.before_first_tick(step),
                _ => self.stage.between_ticks(played),
            }
            let last = tick == ticks && self.stage.options().interpolate;
            let repeated = self.stage.begin_tick(last || self.view.follows_ticks(&self.stage));
            self.follow();
            self.tools.before_tick(&self.stage, &self.view, self.ui.opened(), last);
            self.stage.tick(repeated, self.tools.ledger.kept_mut());
            self.tools.ledger.note(&self.stage);
            self.view.after_tick(&self.stage);
            late = look(&self.stage, Simulated::New).is_break();
            if self.stage.record_after_tick(repeated) || late {
                undone = ticks - tick;
                break;
            }
        }
        self.stage.end_ticks(undone, late);
        self.stage.continue_seek(look);
        self.follow();
    }

    /// Tells tools, view and hands what happened to the stage since the last call: the changes that it got, and whether it has
    /// another world.
    fn follow(&mut self) {
        for change in self.stage.take_changes() {
            self.tools.each().for_each(|(_, tool)| tool.after_change(&change));
        }
        if std::mem::replace(&mut self.world, self.stage.here().number) != self.world {
            self.view.forget_world();
            self.hands.forget_world();
            self.tools.each().for_each(|(_, tool)| tool.restart(&self.stage));
        }
    }

    fn begin_tools(&mut self) {
        self.follow();
        for (panel, tool) in self.tools.each() {
            tool.begin_frame(&self.stage, self.ui.shows(panel));
        }
    }

    /// Lays out the panels if any are open, or if pictures with words are drawn.
    fn show_panels(&mut self, time: FrameTime) {
        let has_panels = self.stage.options().pictures || self.ui.any_open() || self.ui.closing();
        // In unseen frames, keys and clicks wait for the layout that shows their effect.
        if has_panels && !self.unseen {
            self.lay_out_panels(time);
        } else if !has_panels {
            self.ui.forget();
            self.stage.notices.clear();
        }
    }

    /// Lays out the panels for this frame and carries out the intents of the person.
    pub(crate) fn lay_out_panels(&mut self, time: FrameTime) {
        self.stage.notices.expire(time.total(), self.view.has_bars());
        self.view.expire_flash(time.total());
        let Self { stage, view, tools, ui, .. } = self;
        let (mut intents, text) = (Vec::new(), Arc::clone(&stage.sim().scene.text));
        ui.fit_hand(view.by_finger);
        ui.run(time, |ui, root| intents.extend(lay_out(ui, root, stage, view, tools)));
        intents.extend(ui.refusal().map(Intent::Refuse));
        for intent in intents {
            // If an earlier intent changed the text, the places of this one are stale.
            let stale = matches!(intent, Intent::Rewrite(..))
                && !Arc::ptr_eq(&text, &self.stage.sim().scene.text);
            if !stale {
                self.carry_out(intent);
            }
        }
        let postponed = std::mem::take(&mut self.ui.postponed);
        postponed.into_iter().for_each(|act| self.carry_out(Intent::Act(act)));
    }

    /// Lays out the panels for a picture of the current state, between two frames.
    pub fn lay_out_still(&mut self) {
        if let Ok(now) = FrameClock::default().advance_to(self.stage.playback().now()) {
            // A new card gets to its place only in a layout after those that measure it.
            (0..2).for_each(|_| self.lay_out_panels(now));
        }
    }

    /// What layouts since the last call ask of the system: a text for the clipboard, a place for an input method, a shape of the
    /// pointer.
    pub fn take_requests(&mut self) -> Option<egui::PlatformOutput> {
        self.ui.take_requests()
    }

    /// The egui of the panels.
    #[must_use]
    pub const fn egui(&self) -> &egui::Context {
        self.ui.context()
    }

    /// Pixels per point of the panels.
    #[must_use]
    pub fn pixels_per_point(&self) -> f32 {
        self.ui.pixels_per_point()
    }

    /// The picture of the present state.
    pub fn picture(&mut self) -> render::Frame {
        self.follow();
        let Self { stage, view, tools, hands, ui, .. } = self;
        let immovable = hands.selects_immovable(stage, ui);
        let ratio = tools.spring_ratio();
        let mut frame =
            view.begin_picture(stage, ratio.as_ref().map(|ratio| ratio as _), immovable);
        drop(ratio);
        tools.each().for_each(|(_, tool)| tool.draw(stage, view, &mut frame));
        view.finish_picture(stage, &mut frame);
        frame.panels = ui.panels();
        frame
    }

    fn with_hands<T>(&mut self, does: impl FnOnce(&mut Hands, Reach<'_>) -> T) -> T {
        let Self { stage, view, tools, hands, ui, .. } = self;
        does(hands, Reach { stage, view, ui, tools })
    }

    fn handle(&mut self, input: &Input) {
        match input {
            Input::Change(action) => self.stage.carry_out(action),
            Input::Picture(action) => self.stage.show(action),
            Input::Resized(size) => {
                self.view.size_px = *size;
                self.ui.set_size(*size);
            }
            Input::Scaled(scale) => self.ui.set_scale(*scale),
            Input::DockWidth(points) => self.ui.cockpit.set_dock_width(*points),
            Input::Arrange(text) => {
                let acts = arrangement::arrange(&mut self.ui, &mut self.tools.learn, text);
                acts.into_iter().for_each(|act| self.carry_out(Intent::Act(act)));
            }
            Input::KeyDown(_)
            | Input::KeyDownUntil(..)
            | Input::KeyUp(_)
            | Input::At(_)
            | Input::Text(_)
            | Input::Compose(_)
            | Input::Assist(_)
            | Input::Mouse(..)
            | Input::ButtonDown(_)
            | Input::ButtonUp(_)
            | Input::Wheel(_)
            | Input::Touch(..)
            | Input::FocusLost => {
                let intents = self.with_hands(|hands, reach| hands.take(input, reach));
                intents.into_iter().for_each(|intent| self.carry_out(intent));
            }
        }
    }

    /// Carries out what a person wants.
    pub fn carry_out(&mut self, intent: Intent) {
        let opened = self.ui.opened();
        if let Some(intents) = self.tools.take(&intent, &mut self.stage, &self.view, opened) {
            return intents.into_iter().for_each(|intent| self.carry_out(intent));
        }
        match intent {
            Intent::Act(act) => self.act(act),
            Intent::Change(change, by) => self.stage.change(change, by),
            Intent::Refuse(why) => self.stage.notices.refuse(Topic::Other, why),
            Intent::ApplySetting(setting) => self.choose(setting),
            Intent::Pace(pace) => self.set_pace(pace),
            Intent::TurnForce(notches) => self.view.turn_force(&self.stage, notches),
            Intent::Seek(tick) => self.stage.begin_seek(tick),
            Intent::SaveBundle => self.save_bundle(),
            Intent::SaveTable(text) => self.stage.orders.push(Order::Table(text)),
            Intent::Open(scene) => self.leave(Order::Open(scene)),
            Intent::OpenLesson(name) => self.leave(Order::Lesson(name)),
            Intent::Restart(scene, select) => self.restart_with(*scene, select.as_deref()),
            Intent::Ask(question) => self.ask(question),
            Intent::Answer(answer) => self.answer(answer),
            // The editor takes these.
            Intent::Rewrite(..) | Intent::Delete(..) => {}
        }
    }

    /// Does an action at once. Actions that last while their key is held do nothing here.
    fn act(&mut self, act: Act) {
        match act {
            Act::Panel(panel) => self.toggle(panel),
            Act::ToggleMode => self.with_hands(Hands::toggle_mode),
            Act::ToggleGravity => self.toggle_gravity(),
            Act::ResetWorld => {
                self.stage.reset();
                let followed = self.view.locked.take().is_some();
                self.follow();
                // Otherwise it would stay where nothing is any more; the tutorial leaves it there.
                if followed && self.view.has_bars() {
                    self.view.reset_camera(&self.stage);
                }
            }
            Act::ResetCamera => self.view.reset_camera(&self.stage),
            Act::LockCamera => self.view.toggle_lock(&self.stage),
            Act::NextBody => self.select_neighbor(1),
            Act::PreviousBody => self.select_neighbor(-1),
            Act::Frame => self.view.frame(&self.stage),
            Act::Pause => {
                let paused = self.stage.playback().paused();
                self.stage.playback_mut().set_paused(!paused);
            }
            Act::Step => self.stage.playback_mut().step(),
            Act::StepBack => self.stage.step_back(),
            Act::Slower => self.set_pace(self.stage.playback().pace() * 0.5),
            Act::Faster => self.set_pace(self.stage.playback().pace() * 2.0),
            Act::PreviousScene => self.open_neighbor(-1),
            Act::NextScene => self.open_neighbor(1),
            Act::NextMethod => self.change_method(Method::next),
            Act::PreviousMethod => self.change_method(Method::previous),
            Act::SaveBundle => self.save_bundle(),
            Act::VelocityArrows => self.view.velocity_arrows ^= true,
            Act::ForceArrows => self.view.force_arrows ^= true,
            Act::Springs => self.view.springs ^= true,
            Act::Trails => self.view.toggle_trails(),
            Act::FocusPanels => self.ui.focus_next_part(),
            Act::Larger => self.zoom_panels(1),
            Act::Smaller => self.zoom_panels(-1),
            Act::ToggleTheme => self.ui.toggle_theme(),
            Act::ToggleBrowser => self.ui.cockpit.scenes.toggle(self.ui.width()),
            Act::ToggleDock => self.ui.cockpit.dock.toggle(self.ui.width()),
            Act::ToggleCockpit => self.toggle_cockpit(),
            Act::Screenshot => self.stage.orders.push(Order::Screenshot(None)),
            Act::Cancel => self.cancel(),
            Act::Quit => self.leave(Order::Quit),
            // Tools take these.
            Act::NextSolid
            | Act::SaveScene
            | Act::Undo
            | Act::Redo
            | Act::Duplicate
            | Act::Delete => {}
            Act::FlyForward
            | Act::FlyBack
            | Act::FlyLeft
            | Act::FlyRight
            | Act::FlyUp
            | Act::FlyDown
            | Act::PushMinusZ
            | Act::PushPlusZ
            | Act::PushMinusX
            | Act::PushPlusX
            | Act::PushPlusY
            | Act::PushMinusY
            | Act::SelectImmovable
            | Act::ChangeForce => {}
        }
    }

    /// Opens or closes a panel.
    fn toggle(&mut self, panel: Panel) {
        // A tool that follows the world has to know all changes before it opens.
        self.follow();
        if self.ui.shows(panel) && !self.ui.lays_out(panel) {
            return self.ui.open(panel);
        }
        let open = self.ui.shows(panel);
        let Some((_, tool)) = self.tools.each().find(|(other, _)| *other == panel) else { return };
        if tool.toggle(&mut self.stage, open) {
            self.ui.open(panel);
            if self.ui.cockpit.shown {
                self.free_pointer();
            }
        } else {
            self.ui.close(panel);
        }
    }

    /// Leaves the camera mode.
    pub fn free_pointer(&mut self) {
        if self.view.mode == Mode::Camera {
            self.with_hands(Hands::toggle_mode);
        }
    }

    /// Shows the bars and the dock, with a free pointer, or hides them.
    fn toggle_cockpit(&mut self) {
        self.with_hands(|hands, mut reach| hands.let_go(&mut reach));
        if self.ui.toggle_cockpit() {
            self.free_pointer();
        }
    }

    /// Orders a bundle of the whole recording.
    fn save_bundle(&mut self) {
        if self.stage.recorder().is_on() {
            self.stage.orders.push(Order::Bundle);
        } else {
            self.stage.notices.refuse(Topic::Other, "no timeline is kept that could be saved");
        }
    }

    /// Switches gravity on or off, at once. Tells the person if the scene has no gravity.
    fn toggle_gravity(&mut self) {
        if let Some(gravity) = self.stage.sim().world.get_resource::<Gravity>() {
            let request = Request::SwitchGravity(!gravity.on);
            self.stage.change(Change::request(request), SwitchedBy::Key);
        } else {
            let what = "this scene declares no gravity; the settings (Tab) can add it";
            self.stage.notices.refuse(Topic::Gravity, what);
        }
    }

    fn cancel(&mut self) {
        self.tools.each().for_each(|(_, tool)| tool.cancel());
        let asked = self.ui.question.take().is_some();
        if asked || self.ui.close_top() {
            return;
        }
        if self.stage.selection().is_none() {
            self.stage.notices.say(Topic::Other, "Ctrl+Q quits");
        }
        self.stage.select(None);
    }

    fn select_neighbor(&mut self, step: isize) {
        let next = neighbor(self.stage.sim(), self.stage.selection(), step);
        self.stage.select(next);
        self.tools.each().for_each(|(_, tool)| tool.abandon_drag());
    }

    fn zoom_panels(&mut self, steps: isize) {
        let percent = self.ui.zoom_by(steps) * 100.0;
        self.stage.notices.say(Topic::Size, format!("panels: {percent:.0} % of their usual size"));
    }

    fn set_pace(&mut self, pace: f64) {
        let [slowest, fastest] = PACES.map(|times| times * self.stage.playback().usual_pace());
        let pace = pace.clamp(slowest, fastest);
        self.stage.playback_mut().set_pace(pace);
        self.stage.notices.say(Topic::Speed, format!("{} speed", pace_words(pace)));
    }

    fn change_method(&mut self, other: fn(Method) -> Method) {
        let gravity = self.stage.sim().world.contains_resource::<MutualGravity>();
        let mut method = other(self.stage.sim().method());
        while unsolvable(method, gravity).is_some() {
            method = other(method);
        }
        self.stage.change(Change::Method(method), SwitchedBy::Key);
        self.stage.notices.say(Topic::Method, methods::line(method));
    }

    /// Applies a setting that a panel offers. In a recording steps name it, and this does nothing: what a panel offers
    /// depends on what its machine measured.
    fn choose(&mut self, setting: Setting) {
        if self
            .player
            .as_ref()
            .is_some_and(|player| player.names_settings(self.stage.playback().frames()))
        {
            return;
        }
        for chosen in
            [ChangeAction::SetMethod(setting.method), ChangeAction::SetSubsteps(setting.substeps)]
        {
            self.stage.carry_out(&chosen);
            self.chosen.push(Input::Change(chosen));
        }
    }

    fn open_neighbor(&mut self, step: isize) {
        let shipped = scene::shipped();
        let here = shipped.iter().position(|shipped| shipped.name == self.stage.sim().scene.name);
        let next = match here {
            Some(here) => {
                here.checked_add_signed(step).map_or(shipped.len() - 1, |next| next % shipped.len())
            }
            None => 0,
        };
        self.leave(Order::Open(shipped[next].name.to_owned()));
    }

    /// Opens another scene; window size and panels stay.
    pub fn open(&mut self, mut scene: Scene) {
        self.stage.options().overrides.apply(&mut scene);
        self.stage.open(scene);
        self.view.open(&self.stage);
        self.begin_scene(false);
        self.opened = true;
        let scene = Arc::clone(&self.stage.sim().scene);
        if let Some(path) = scene.source.file() {
            self.stage.files.note(path);
        }
    }

    /// Restarts, paused, with `scene`, another text of the current scene. Keeps click force and what is drawn, and
    /// the camera unless the selection leaves the view.
    fn restart_with(&mut self, scene: Scene, select: Option<&str>) {
        let offset = offset_in_entry(&self.stage, select);
        let was_seen = self.sees_selection() != Some(false);
        let (before, pace) = (Arc::clone(&self.stage.sim().scene), self.stage.playback().pace());
        self.stage.open(scene);
        self.stage.playback_mut().set_paused(true);
        self.stage.playback_mut().set_pace(pace);
        self.view.reopen(&self.stage, &before);
        self.begin_scene(true);
        self.tools.forecast_begin(&mut self.stage, 1.0 / DEFAULT_FPS);
        self.stage.select(select.and_then(|path| entity_at(&self.stage, path, offset)));
        // A typed place may be anywhere.
        let keeps = self.stage.sim().scene.camera == before.camera;
        if self.view.has_bars() && keeps && was_seen && self.sees_selection() == Some(false) {
            self.view.frame_all(&self.stage);
        }
    }

    /// Whether the middle of the selection is in the view, if there is a selection.
    fn sees_selection(&self) -> Option<bool> {
        let place = self.stage.drawn_position(self.stage.selection()?)?;
        Some(self.view.sees(place))
    }

    fn begin_scene(&mut self, rewritten: bool) {
        self.tools.next_scene(rewritten);
        self.hands = Hands::default();
        for (panel, tool) in self.tools.each() {
            if tool.closes_with_scene() {
                self.ui.close(panel);
            }
        }
        self.begin_tools();
    }

    /// Whether the scene has changes that no file has.
    #[must_use]
    pub fn has_unsaved_changes(&self) -> bool {
        self.tools.editor.is_unsaved(&self.stage.sim().scene)
    }

    /// The text of the scene, if it has changes that no file has.
    #[must_use]
    pub fn unsaved(&self) -> Option<Arc<str>> {
        self.has_unsaved_changes().then(|| Arc::clone(&self.stage.sim().scene.text))
    }

    /// The title of a window: the file or the scene, after a dot if it has unsaved changes.
    #[must_use]
    pub fn title(&self) -> String {
        let scene = &self.stage.sim().scene;
        let file = self.tools.editor.file(scene).and_then(Path::file_name);
        let name = file.map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_else(|| scene.name.replace('_', " "));
        format!("{}{name} - Inertia", if self.has_unsaved_changes() { "• " } else { "" })
    }

    /// Carries out `order`, which leaves the scene. Asks first if there are unsaved changes.
    pub fn leave(&mut self, order: Order) {
        if self.has_unsaved_changes() {
            self.ask(Question::Leaving(order));
        } else {
            self.stage.orders.push(order);
        }
    }

    /// Asks a question, with a free pointer.
    fn ask(&mut self, question: Question) {
        self.free_pointer();
        self.with_hands(|hands, mut reach| hands.let_go(&mut reach));
        self.ui.question = Some(question);
    }

    /// Whether something is asked.
    #[must_use]
    pub const fn asks(&self) -> bool {
        self.ui.question.is_some()
    }

    /// Asks whether to restore the unsaved changes in the file `draft`.
    pub fn offer(&mut self, draft: PathBuf) {
        self.ask(Question::LeftBehind(draft));
    }

    /// Carries out the answer to the open question.
    fn answer(&mut self, answer: Answer) {
        match (self.ui.question.take(), answer) {
            (None, _) | (_, Answer::Cancel) => {}
            (Some(Question::Leaving(order)), Answer::Discard) => {
                // Another scene gets another editor as soon as it is open.
                if order == Order::Quit {
                    self.tools.editor = Editor::default();
                }
                self.stage.orders.push(order);
            }
            (Some(Question::Leaving(order)), _) => {
                self.carry_out(Intent::Act(Act::SaveScene));
                self.stage.orders.push(order);
            }
            (Some(Question::Deleting { entry, .. }), Answer::All) => {
                self.carry_out(Intent::Delete(entry, None));
            }
            (Some(Question::Deleting { entry, alone, .. }), _) => {
                if let Some(body) = alone {
                    self.carry_out(Intent::Delete(entry, Some(body)));
                }
            }
            (Some(Question::LeftBehind(draft)), Answer::Discard) => {
                self.stage.orders.push(Order::Forget(draft));
            }
            (Some(Question::LeftBehind(draft)), _) => self.stage.orders.push(Order::Restore(draft)),
        }
    }

    /// Opens `scene`, which has unsaved changes, and pauses. `file` is the file that was edited, and its text.
    pub fn open_unsaved(&mut self, scene: Scene, file: Option<(PathBuf, Arc<str>)>) {
        self.open(scene);
        self.stage.playback_mut().set_paused(true);
        self.tools.editor.open_unsaved(&self.stage, file);
    }

    /// Opens the panel of lessons with `lesson`, whose scene is open in this session and whose runs measured `of_runs`.
    pub fn begin_lesson(&mut self, lesson: Lesson, of_runs: Quantities) {
        self.tools.learn.open(Arc::new(lesson), of_runs);
        self.ui.open(Panel::Learn);
    }

    /// Does what a step of a lesson begins with.
    fn begin_step(&mut self, begin: Begin) {
        match begin {
            Begin::Reset => self.act(Act::ResetWorld),
            Begin::Pause => self.stage.playback_mut().set_paused(true),
            Begin::Play => self.stage.playback_mut().set_paused(false),
            Begin::Frame => {
                self.act(Act::ResetCamera);
                // Works without the bars, too; the key does not.
                if self.view.should_be_framed(&self.stage) {
                    self.view.frame_start(&self.stage);
                }
            }
        }
    }

    /// Plays a script from the next frame on, in addition to the input of frames.
    pub fn play(&mut self, player: Player) {
        self.player = Some(player);
    }

    /// The script that is playing, if any.
    #[must_use]
    pub const fn player(&self) -> Option<&Player> {
        self.player.as_ref()
    }

    /// Carries out the steps of the script, and those of a solution, at the start of a frame.
    fn play_frame(&mut self, time: FrameTime) {
        let (frame, ticks) = (self.stage.playback().frames(), self.stage.sim().ticks());
        let start = time.total() - time.length();
        let player = self.player.iter_mut();
        let inputs = player.flat_map(|player| player.of_frame(frame, ticks, start, time.total()));
        for input in inputs.collect::<Vec<_>>() {
            self.handle(&input);
        }
        if self.tools.learn.lesson().is_none() {
            self.shown.clear();
        }
        let shown = self.shown.iter_mut().filter(|(at, _)| *at <= time.total());
        let inputs =
            shown.flat_map(|(_, player)| player.of_frame(frame, ticks, start, time.total()));
        for input in inputs.collect::<Vec<_>>() {
            // The pointer is on the button that shows the solution, where the wheel would scroll.
            if let Input::Wheel(notches) = input {
                self.view.turn_force(&self.stage, notches);
            } else {
                self.handle(&input);
            }
        }
    }

    /// Carries out the steps of the script before the next tick. Returns whether there were any.
    fn play_tick(&mut self) -> bool {
        let Some(player) = &mut self.player else { return false };
        let world = &self.stage.sim().world;
        let (clock, step) = (world.resource::<StepClock>(), world.resource::<TimeStep>());
        let inputs = player.of_tick(clock.ticks(), clock.seconds(), step.0);
        inputs.iter().for_each(|input| self.handle(input));
        !inputs.is_empty()
    }

    /// Pauses and goes to the end of tick number `tick`, or to the nearest tick of the last minute, in one call. Resuming from
    /// there drops what came after it, unless the run repeats it.
    pub fn seek(&mut self, tick: u64) {
        self.stage.begin_seek(tick);
        self.finish_seek();
    }

    /// Goes back to the last good tick before the fault, if there is one, and selects the body at fault.
    pub fn rewind_before_fault(&mut self) {
        if let Some(fault) = self.stage.recorder().fault().cloned() {
            self.rewind_before(&fault);
        }
    }

    /// Goes back to the last good tick before `fault`, in one call, and selects the body at fault.
    pub fn rewind_before(&mut self, fault: &Fault) {
        self.stage.begin_seek_before(fault);
        self.finish_seek();
    }

    fn finish_seek(&mut self) {
        self.stage.continue_seek(&mut |_, _| ControlFlow::Continue(()));
        self.follow();
    }

    /// Tells the HUD what the shell measured.
    pub const fn set_measured(&mut self, measured: Measured) {
        self.view.measured = Some(measured);
    }

    /// Sets whether no picture of the next frames is seen; unseen frames lay out no panels.
    pub const fn set_unseen(&mut self, unseen: bool) {
        self.unseen = unseen;
    }

    /// The arrangement of the panels, one line per action and its state: `on`, `off`, or how many times it was done.
    #[must_use]
    pub fn arrangement(&self) -> String {
        arrangement::of(&self.ui, &self.tools.learn)
    }

    /// Whether a text field takes what is typed.
    #[must_use]
    pub fn takes_text(&self) -> bool {
        self.ui.takes_text()
    }

    /// The open panels in the order in which they were opened.
    #[must_use]
    pub fn open_panels(&self) -> &[Panel] {
        self.ui.opened()
    }

    /// The controls on the screen after the last frame; the first call only begins to name them.
    #[must_use]
    pub fn controls(&self) -> Vec<Control> {
        self.ui.controls()
    }

    /// Seconds after the last frame until something changes without input; infinite if nothing does.
    #[must_use]
    pub fn changes_in_s(&mut self) -> f64 {
        let works = self.tools.each().any(|(panel, tool)| self.ui.shows(panel) && tool.works());
        let shown = self.shown.iter().map(|(_, player)| player);
        let plays = self.player.iter().chain(shown).any(|player| !player.finished());
        let does =
            plays || works || self.hands.act_by_themselves() || !self.stage.orders.is_empty();
        if does || !self.stage.playback().paused() || self.stage.recorder().is_seeking() {
            return 0.0;
        }
        let now = self.stage.playback().now();
        let flash = self.view.flash.as_ref().map_or(f64::INFINITY, |flash| flash.until);
        let lesson = self.tools.learn.says_more_at(now);
        let next = [self.stage.notices.next_end(now), self.ui.lays_out_at(), flash, lesson];
        (next.into_iter().fold(f64::INFINITY, f64::min) - now).max(0.0)
    }
}
