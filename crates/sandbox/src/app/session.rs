//! A running scene: input and a frame time in, ticks simulated, a plain frame for the renderer out.
//!
//! The window, headless runs and tests all come through here, which is why a headless picture is the window's.

use std::ops::{ControlFlow, Deref, DerefMut};
use std::sync::Arc;

use lab::ReceiptLine;
use lab::cost::Study;
use motion::clock::FrameTime;
use motion::ledger::Ledger;
use motion::snapshot::Effects;
use motion::{TimeStep, remember_positions};
use scene::{Scene, Source, StepKind};

use crate::app::held::Hands;
use crate::app::player::Player;
use crate::app::ui::{Control, Ui};
pub(crate) use crate::input::SwitchedBy;
use crate::input::{Input, InputFrame};
use crate::tools::editor::Editor;
use crate::tools::forecast::ForecastRow;
use crate::tools::ghosts::GhostRow;
use crate::tools::{Panel, Tools, forecast};
use crate::view::notices::Topic;
use crate::view::options::Options;
use crate::view::stage::{Measured, Order, Run, Stage, View, hand_over, start};

/// Frames per second of a run that does not say.
pub(crate) const DEFAULT_FPS: f64 = 60.0;

/// A tick that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulated {
    /// One of the run; the session is at its end.
    New,
    /// One that a seek simulates; the session does not show it.
    Again,
}

/// What a session does when something goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnFault {
    /// It goes back to the last good tick, pauses and selects the body.
    Pause,
    /// It simulates no further.
    Stop,
}

/// What was asked of a session for every scene that it opens.
#[derive(Default)]
pub(crate) struct Settings {
    /// Whether the last minute is recorded, and what a fault does.
    pub recording: Option<OnFault>,
    /// Whether the next fault of this scene orders a bundle.
    pub saves_faults: bool,
    /// Whether a ledger is kept while its panel is closed, too.
    pub keeps_ledger: bool,
}

/// What a person sets that changes how long a frame or a tick takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedSetting {
    pub pace: f64,
    pub paused: bool,
    pub ghosts: bool,
}

/// A running scene: the simulation with its view, and the tools. Both are replaced as a whole with the scene; what lasts is in
/// the run, the settings and the panels.
pub struct Session {
    pub(crate) stage: Stage,
    pub(crate) tools: Tools,
    pub(crate) hands: Hands,
    pub(crate) ui: Ui,
    pub(crate) settings: Settings,
    pub(crate) player: Option<Player>,
    /// The settings that were chosen in the panels of the last frame, as inputs: a recording has them in the next one.
    pub(crate) chosen: Vec<Input>,
    /// Ticks left to simulate, if they are limited.
    pub(crate) ticks_left: Option<u64>,
}

impl Deref for Session {
    type Target = Stage;

    fn deref(&self) -> &Stage {
        &self.stage
    }
}

impl DerefMut for Session {
    fn deref_mut(&mut self) -> &mut Stage {
        &mut self.stage
    }
}

impl Session {
    /// Starts `scene`.
    #[must_use]
    pub fn new(scene: Scene, options: Options) -> Self {
        Self {
            stage: Stage::new(scene, Run { options, ..Run::default() }),
            tools: Tools::default(),
            hands: Hands::default(),
            ui: Ui::new(options.size_px),
            settings: Settings::default(),
            player: None,
            chosen: Vec::new(),
            ticks_left: None,
        }
    }

    /// Goes on with another scene; window size and panels stay.
    pub fn open(&mut self, scene: Scene) {
        self.go_on_with(scene, Editor::default(), |view, before| {
            (view.mode, view.pointer) = (before.mode, before.pointer);
        });
        if let Source::File(path) = &self.stage.sim.scene.source {
            self.stage.run.note_file(path);
        }
    }

    /// Goes on with another scene, or another text of it; `keep` keeps of the view before what stays.
    pub(crate) fn go_on_with(&mut self, scene: Scene, editor: Editor, keep: impl FnOnce(&mut View, View)) {
        self.forget_ahead();
        let mut run = std::mem::take(&mut self.stage.run);
        run.options.paused = false;
        run.quarantined_before = run.quarantined.len();
        let mut next = Stage::new(scene, run);
        self.stage.hand_over(&mut next);
        next.clock.start_at(self.clock.now());
        next.notices = std::mem::take(&mut self.stage.notices);
        next.notices.retract_run();
        next.orders = std::mem::take(&mut self.stage.orders);
        let before = std::mem::replace(&mut self.stage, next);
        keep(&mut self.stage.view, before.view);
        self.tools = Tools { editor, ..Tools::default() };
        self.hands = Hands::default();
        self.ui.close(Panel::Ghosts);
        self.restart_tools();
        self.keep_or_close_ledger();
        self.restart_recording();
    }

    /// Builds the world again; camera, gravity, damping, what is switched off and click force stay, the selection does
    /// not.
    pub(crate) fn reset_world(&mut self) {
        // Gravity and damping may have been asked for in this very frame.
        self.carry_out_requests();
        self.forget_ahead();
        self.run.quarantined_before = self.run.quarantined.len();
        let stage = &mut self.stage;
        let method = stage.sim.method();
        let step = *stage.sim.world.resource::<TimeStep>();
        let mut next = start(Arc::clone(&stage.sim.scene), stage.run.options);
        hand_over(&mut stage.sim.world, &mut next.world);
        next.world.insert_resource(step);
        Effects::of(&mut stage.sim.world).put(&mut next.world);
        next.stepper.recompile(&mut next.world);
        if method != next.method() {
            next.set_method(method);
        }
        stage.replace(next);
        stage.notices.retract_run();
        stage.clock.set_pace(1.0).expect("1 is positive and finite");
        self.restart_tools();
        self.restart_recording();
    }

    /// Lets the tools go on with another world.
    pub(crate) fn restart_tools(&mut self) {
        for (_, tool) in self.tools.each() {
            tool.restart(&mut self.stage);
        }
    }

    /// One frame: everything but pixels.
    pub fn frame(&mut self, input: &InputFrame, time: FrameTime) -> render::Frame {
        self.advance(input, time);
        self.picture()
    }

    /// One frame without the picture: input, ticks, camera, panels.
    pub fn advance(&mut self, input: &InputFrame, time: FrameTime) {
        self.advance_watched(input, time, &mut |_, _| ControlFlow::Continue(()));
    }

    /// [`Session::advance`] with a look at the state after every tick. A look that breaks drops the frame's other ticks,
    /// which are counted as dropped time: a run that waits for them too long would never catch up. Those on the way to a past
    /// tick are left to the next frame instead, and nothing else is simulated until it is there.
    pub fn advance_watched(
        &mut self,
        input: &InputFrame,
        time: FrameTime,
        after_tick: &mut dyn FnMut(&Self, Simulated) -> ControlFlow<()>,
    ) {
        self.chosen.clear();
        let pushes = self.pushes_while_seeking();
        for event in &input.events {
            self.handle(event);
        }
        self.play_frame(time);
        self.play_tick();
        self.steer(time.length());
        if pushes.is_some_and(|before| self.pushes_while_seeking() > Some(before)) {
            self.give_up_seek();
        }
        self.simulate(time, after_tick);
        self.follow_locked();
        for (panel, tool) in self.tools.each() {
            tool.after_ticks(&mut self.stage, self.ui.shows(panel), time);
        }
        let Tools { graphs, ghosts, .. } = &mut self.tools;
        graphs.sample(&mut self.stage, ghosts, self.ui.shows(Panel::Graphs));
        let has_panels = self.run.options.pictures || self.ui.any_open() || self.ui.closing();
        // Unseen, what is typed and clicked waits for the layout that shows what it does.
        if has_panels && !self.run.unseen {
            self.lay_out_panels(time);
        } else if !has_panels {
            self.ui.forget();
            self.notices.clear();
        }
        self.go_on_seeking(after_tick);
        self.run.frames += 1;
    }

    fn simulate(&mut self, time: FrameTime, after_tick: &mut dyn FnMut(&Self, Simulated) -> ControlFlow<()>) {
        // Before the requests: what they change is an intervention.
        self.keep_or_close_ledger();
        self.carry_out_requests();
        self.run.dropped_lately = 0.0;
        if self.go_on_seeking(after_tick) {
            self.clock.pause(time);
            return;
        }
        // Taken in any case: a step that was asked for before going on is not one of the next pause.
        let steps_asked = std::mem::take(&mut self.hands.steps_asked);
        let stage = &mut self.stage;
        let (mut ticks, step) = if stage.view.paused {
            stage.clock.pause(time);
            (steps_asked, None)
        } else if stage.sim.scene.step == StepKind::Frame {
            let length = time.length() * stage.clock.pace();
            stage.clock.pause(time);
            (u64::from(length > 0.0), Some(length))
        } else {
            let due = stage.clock.due(time);
            stage.run.dropped_lately = due.dropped;
            stage.run.dropped += due.dropped;
            (due.ticks, None)
        };
        if let Some(left) = &mut self.ticks_left {
            ticks = ticks.min(*left);
            *left -= ticks;
        }
        if ticks > 0 {
            // What is pulled leaves a run that would be repeated.
            self.stage.pull();
        }
        if let Some(length) = step.filter(|length| *length > 0.0)
            && !self.repeats()
        {
            self.sim.world.insert_resource(TimeStep(length));
        }
        if ticks > 0 {
            self.notices.retract(Topic::Place);
            self.hands.held.begin_tick();
            self.note_pushes();
        }
        let (mut undone, mut late) = (0, false);
        for tick in 1..=ticks {
            if tick > 1 {
                self.play_between_ticks();
                if self.seen.pull.is_some() {
                    self.stage.pull();
                    self.note_pushes();
                }
            }
            let last = tick == ticks && self.run.options.interpolate;
            // A trail has to know of every tick where its bodies were before it.
            if last || (self.view.trails && self.run.options.interpolate) {
                self.sim.world.run_system_cached(remember_positions).expect("a query and nothing else");
            }
            let repeated = self.repeat_before_tick();
            for (_, tool) in self.tools.each() {
                tool.before_tick(&self.stage, last);
            }
            if !repeated {
                self.record_before_tick();
            }
            self.tools.ledger.tick(&mut self.stage);
            if self.view.trails {
                let time = self.simulated();
                let Stage { seen, sim, .. } = &mut self.stage;
                seen.trails.after_tick(&mut sim.world, time);
            }
            late = after_tick(self, Simulated::New).is_break();
            if self.record_after_tick(repeated) || late {
                undone = ticks - tick;
                break;
            }
        }
        if let Some(left) = &mut self.ticks_left {
            *left += undone;
        }
        if late {
            #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
            let dropped = undone as f64 / self.clock.rate();
            self.run.dropped_lately += dropped;
            self.run.dropped += dropped;
        }
        let between = self.run.options.interpolate
            && !self.view.paused
            && self.sim.scene.step == StepKind::Fixed
            // Positions are remembered before the last tick, which was not reached.
            && undone == 0;
        self.seen.alpha = if between { self.clock.fraction() } else { 1.0 };
        self.seen.targets_current = false;
        self.note_quarantined();
        self.note_unconverged();
        self.meet_fault();
        self.go_on_seeking(after_tick);
    }

    /// The picture of the present state.
    pub fn picture(&mut self) -> render::Frame {
        let forecast = &self.tools.forecast;
        let ratio = |ends| forecast.spring_ratio(ends).unwrap_or(0.0);
        let immovable = self.selects_immovable();
        let mut frame =
            self.stage.begin_picture(forecast.shown().is_some().then_some(&ratio as _), immovable);
        for (_, tool) in self.tools.each() {
            tool.draw(&self.stage, &mut frame);
        }
        self.stage.finish_picture(&mut frame);
        frame.panels = self.ui.panels();
        frame
    }

    /// Simulates at most `ticks` more ticks; after that, frames change nothing but the camera.
    pub const fn limit_ticks(&mut self, ticks: u64) {
        self.ticks_left = Some(ticks);
    }

    /// Tells the HUD what the shell measured.
    pub const fn set_measured(&mut self, measured: Measured) {
        self.stage.run.measured = Some(measured);
    }

    /// Lets the next frames do without panels, because no picture of them is seen, or lay them out again.
    pub const fn set_unseen(&mut self, unseen: bool) {
        self.stage.run.unseen = unseen;
    }

    /// Leaves an order for the next frame, because this one could not carry it out.
    pub fn postpone(&mut self, order: Order) {
        self.orders.push(order);
    }

    /// Whether a text field takes what is typed.
    #[must_use]
    pub fn takes_text(&self) -> bool {
        self.ui.takes_text()
    }

    /// Seconds after the last frame until something changes without input; infinite where nothing does.
    #[must_use]
    pub fn changes_in_s(&mut self) -> f64 {
        let works = self.tools.each().any(|(panel, tool)| self.ui.shows(panel) && tool.works());
        let plays = self.player.as_ref().is_some_and(|player| !player.finished());
        let does = plays || works || !self.hands.held.is_empty() || !self.orders.is_empty();
        if does || !self.view.paused || !self.arrived() {
            return 0.0;
        }
        let now = self.clock.now();
        (self.notices.next_end(now).min(self.ui.lays_out_at()) - now).max(0.0)
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

    /// Simulated time with the part of the next tick that has passed, s.
    pub(crate) fn progress(&self) -> f64 {
        self.simulated() + self.clock.fraction() / self.clock.rate()
    }

    pub(crate) fn speed_setting(&self) -> SpeedSetting {
        SpeedSetting {
            pace: self.clock.pace(),
            paused: self.view.paused,
            ghosts: self.tools.ghosts.are_shown(),
        }
    }

    /// Keeps a ledger of energy and momentum from now on, whether the panel is open or not.
    pub fn keep_ledger(&mut self) {
        self.settings.keeps_ledger = true;
        self.keep_or_close_ledger();
    }

    fn keep_or_close_ledger(&mut self) {
        let wanted = self.settings.keeps_ledger || self.ui.shows(Panel::Ledger);
        self.tools.ledger.keep(&mut self.stage, wanted);
    }

    /// The ledger, if one is kept.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger> {
        self.tools.ledger.kept()
    }

    /// What there is to say of every method and, last, of the reference; nothing while no ghosts are shown.
    #[must_use]
    pub fn ghosts(&self) -> Vec<GhostRow> {
        self.tools.ghosts.rows(&self.stage)
    }

    /// How far everything is from instability as it is now, the worst first.
    #[must_use]
    pub fn forecast(&mut self) -> Vec<ForecastRow> {
        forecast::rows(&mut self.stage)
    }

    /// Computes the forecast at the start of a scene with frames of that length, s. Keeps the unstable rows for the summary;
    /// tells and returns those whose growth would soon be seen.
    pub fn forecast_start(&mut self, frame: f64) -> Vec<ForecastRow> {
        self.tools.forecast.begin(&mut self.stage, frame)
    }

    /// The unstable rows of the forecast at the start of the scene.
    #[must_use]
    pub fn forecast_at_start(&self) -> &[ForecastRow] {
        self.tools.forecast.at_start()
    }

    /// The forecast of the open panel, the worst first.
    #[must_use]
    pub fn shown_forecast(&self) -> Option<&[ForecastRow]> {
        self.tools.forecast.shown()
    }

    /// The study of the running scene so far, while its panel is open.
    #[must_use]
    pub fn cost_study(&self) -> Option<&Study> {
        self.tools.cost.study()
    }

    /// The part of the study that is done, in [0, 1].
    #[must_use]
    pub fn cost_progress(&self) -> f64 {
        self.tools.cost.progress()
    }

    /// The receipt of the session as it is: what acts, because of what, on how many bodies; evaluations per step are
    /// those since the last look, times those of the last measurement.
    pub fn receipt(&mut self) -> Vec<ReceiptLine> {
        self.tools.effects.receipt(&mut self.stage)
    }
}
