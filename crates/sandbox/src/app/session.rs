//! A running scene: input and a frame time in, ticks simulated, a plain frame for the renderer out.
//!
//! The window, headless runs and tests all come through here, which is why a headless picture is the window's.

use crate::app::past;
pub(crate) use crate::app::past::Within;
pub use crate::app::rerun::Repetition;
pub(crate) use crate::app::rest::SpeedSetting;
use crate::app::worlds::{build, ids_of};
pub(crate) use crate::tools::cost::state::SHARE as COST_SHARE;
pub(crate) use crate::tools::effects::state::ENERGY_WATCH;
pub use crate::tools::effects::state::SwitchedBy;
pub use crate::tools::forecast::state::ForecastRow;
pub(crate) use crate::tools::forecast::state::digits;
pub(crate) use crate::tools::ghosts::state::{GhostLabel, Track, place};
pub use crate::tools::ghosts::state::{GhostRow, GhostState};
pub(crate) use crate::tools::ledger::state::Point;
use crate::tools::{cost, effects, forecast, ghosts, ledger};
pub(crate) use crate::view::labels::Label;
pub use crate::view::options::{Options, Overrides};
pub(crate) use crate::view::pose::drawn;
pub(crate) use crate::view::soft::SoftSum;

use std::collections::HashMap;
use std::ops::ControlFlow;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::{Intervention, Simulation};
use motion::clock::{FrameTime, TickClock};
use motion::{
    Method, MutualGravity, OwnMethod, Particle, Push, PushQueue, Request, Requests, TimeStep,
    remember_positions,
};
use pick::{SoftTargets, Targets};
use scene::{PushSpec, Scene, StepKind, unsolvable};

use crate::app::control::Control;
use crate::app::player::Player;
use crate::app::ui::{Topic, Ui};
use crate::view::camera::Camera;
use crate::view::trails::Trails;

/// Simulated time that one frame may catch up with, s; what a longer frame owes is dropped and reported.
pub(crate) const CATCH_UP: f64 = 0.25;

/// Frames a second of a run that does not say.
pub(crate) const DEFAULT_FPS: f64 = 60.0;

/// Refusals that wait to be told.
const MOST_REFUSALS: usize = 16;

/// Newtons of a held push key.
pub(crate) const KEY_PUSH: f64 = 10.0;

/// What the window shell measured; a headless run has none, so that its pictures depend on nothing but input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Frames a second.
    pub frames_per_second: f64,
    /// Time of a tick, s.
    pub tick: f64,
    /// Simulated seconds a second.
    pub simulated_over_real: f64,
}

/// A body that was quarantined, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct QuarantinedBody {
    /// Name in the scene.
    pub body: String,
    /// The tick that it did not survive.
    pub tick: u64,
    /// What happened, as a sentence.
    pub what: String,
    /// The system that noticed.
    pub system: &'static str,
    /// The component or resource at fault.
    pub component: &'static str,
    /// What had happened to it: a word, with the name of the law or of the body at the other end of the spring.
    pub cause: String,
}

/// A tick that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulated {
    /// One of the run; the session is at its end.
    Anew,
    /// One on the way to a past tick; the session does not show it.
    Again,
}

/// What the program outside has to do after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Write the picture of this frame; a name if a script gave one.
    Screenshot(Option<String>),
    /// Write the run into a file: a black box.
    Bundle,
    /// Load the scene of that name and go on with it.
    Open(String),
    /// Leave.
    Quit,
}

/// A running scene.
pub struct Session {
    pub(crate) sim: Simulation,
    pub(crate) clock: TickClock,
    pub(crate) ids: HashMap<Entity, u32>,
    pub(crate) options: Options,
    pub(crate) camera: Camera,
    pub(crate) control: Control,
    pub(crate) ui: Ui,
    pub(crate) trails: Trails,
    pub(crate) measured: Option<Measured>,
    pub(crate) orders: Vec<Order>,
    pub(crate) player: Option<Player>,
    pub(crate) effects: effects::state::Effects,
    /// Twins of this world, while they are shown.
    pub(crate) ghosts: Option<ghosts::state::Ghosts>,
    pub(crate) cost: Option<cost::state::LiveCost>,
    /// Books of energy and momentum, while somebody wants them.
    pub(crate) ledger: Option<Box<ledger::state::Kept>>,
    /// Whether they are kept while their panel is closed, too.
    pub(crate) ledger_asked: bool,
    pub(crate) refusals: Vec<String>,
    /// The forecast, while its panel is open.
    pub(crate) shown_forecast: Option<forecast::state::Shown>,
    /// What would grow, as it was at the start of the scene.
    pub(crate) foretold: Vec<ForecastRow>,
    /// The last minute, if it is to be gone back to.
    pub(crate) recorded: Option<Box<past::Recorded>>,
    /// Whether it is, in this scene and the next, and what a fault does.
    pub(crate) recording: Option<past::OnFault>,
    /// Whether the next fault of this scene orders a bundle.
    pub(crate) saves_faults: bool,
    pub(crate) targets: Targets,
    pub(crate) soft: SoftTargets,
    pub(crate) targets_current: bool,
    /// Where between the last two ticks bodies are drawn, in [0, 1].
    pub(crate) alpha: f64,
    pub(crate) ticks_left: Option<u64>,
    pub(crate) frames: u64,
    pub(crate) dropped: f64,
    pub(crate) dropped_lately: f64,
    pub(crate) quarantined: Vec<QuarantinedBody>,
    /// How many of them are of other worlds.
    pub(crate) quarantined_before: usize,
    pub(crate) records_seen: usize,
    /// Implicit steps that had not converged when the scene began; none once the person was told of one in it.
    pub(crate) unconverged_before: Option<u64>,
    pub(crate) acting: HashMap<Entity, DVec3>,
    /// Newtons of a force arrow of one meter, while these are drawn.
    pub(crate) force_scale: Option<f64>,
    /// Words beside bodies, by stable id.
    pub(crate) labels: Vec<(u32, String)>,
}

impl Session {
    /// Starts `scene`.
    #[must_use]
    pub fn new(mut scene: Scene, options: Options) -> Self {
        options.overrides.apply(&mut scene);
        let catch_up = options.catch_up.unwrap_or(CATCH_UP);
        let clock =
            TickClock::new(scene.step_hz, catch_up).expect("a resolved scene has a positive, finite rate");
        let push = scene.push.unwrap_or(PushSpec::TUTORIAL);
        let sim = build(scene, options);
        let scene = &sim.scene;
        Self {
            camera: Camera::new(scene.camera),
            control: Control { trails: scene.trails, ..Control::new(push, options.paused) },
            ui: Ui::new(options.size_px),
            trails: Trails::default(),
            measured: None,
            orders: Vec::new(),
            player: None,
            effects: effects::state::Effects::default(),
            ghosts: None,
            cost: None,
            ledger: None,
            ledger_asked: false,
            refusals: Vec::new(),
            shown_forecast: None,
            foretold: Vec::new(),
            recorded: None,
            recording: None,
            saves_faults: false,
            targets: Targets::default(),
            soft: SoftTargets::default(),
            targets_current: false,
            ids: ids_of(&sim.bodies),
            alpha: 1.0,
            ticks_left: None,
            frames: 0,
            dropped: 0.0,
            dropped_lately: 0.0,
            quarantined: Vec::new(),
            quarantined_before: 0,
            records_seen: 0,
            unconverged_before: Some(0),
            acting: HashMap::new(),
            force_scale: None,
            labels: scene.labels.clone(),
            sim,
            clock,
            options,
        }
    }

    /// Simulates at most `ticks` more ticks; after that, frames change nothing but the camera.
    pub const fn limit_ticks(&mut self, ticks: u64) {
        self.ticks_left = Some(ticks);
    }

    /// Tells the HUD what the shell measured.
    pub const fn set_measured(&mut self, measured: Measured) {
        self.measured = Some(measured);
    }

    /// What is to be done outside after this frame; takes it.
    pub fn take_orders(&mut self) -> Vec<Order> {
        std::mem::take(&mut self.orders)
    }

    /// What is to be done outside after this frame, left in place.
    #[must_use]
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// Leaves an order for the next frame, because this one could not carry it out.
    pub fn postpone(&mut self, order: Order) {
        self.orders.push(order);
    }

    /// Whether a text field takes what is typed.
    #[must_use]
    pub fn takes_text(&self) -> bool {
        self.ui.takes_keys()
    }

    /// Says something to the person for a few seconds.
    pub fn notice(&mut self, text: impl Into<String>) {
        self.ui.notice(Topic::Other, text.into());
    }

    /// Says what became of a file, in place of what was said of the last one.
    pub(crate) fn notice_of_file(&mut self, text: String) {
        self.ui.notice(Topic::File, text);
    }

    /// What is said to the person at present.
    pub fn notices(&self) -> impl Iterator<Item = &str> {
        self.ui.notices()
    }

    /// Says to the person, and to a run that nobody looks at, that something was not done.
    pub(crate) fn refuse(&mut self, what: impl Into<String>) {
        self.refuse_about(Topic::Other, what);
    }

    pub(crate) fn refuse_about(&mut self, topic: Topic, what: impl Into<String>) {
        let what = what.into();
        if self.refusals.len() < MOST_REFUSALS {
            self.refusals.push(what.clone());
        }
        self.ui.notice(topic, what);
    }

    /// What was asked for and not done, lately; takes it.
    pub fn take_refusals(&mut self) -> Vec<String> {
        std::mem::take(&mut self.refusals)
    }

    /// One frame: everything but pixels.
    pub fn frame(&mut self, input: &crate::input::InputFrame, time: FrameTime) -> render::Frame {
        self.advance(input, time);
        self.picture()
    }

    /// One frame without the picture: input, ticks, camera, panels.
    pub fn advance(&mut self, input: &crate::input::InputFrame, time: FrameTime) {
        self.advance_watched(input, time, &mut |_, _| ControlFlow::Continue(()));
    }

    /// [`Session::advance`] with a look at the state after every tick. A look that breaks drops the frame's other ticks,
    /// which are counted as dropped time: who waits for them too long would never catch up. Those on the way to a past
    /// tick are left to the next frame instead, and nothing else is simulated until it is there.
    pub fn advance_watched(
        &mut self,
        input: &crate::input::InputFrame,
        time: FrameTime,
        after_tick: &mut dyn FnMut(&Self, Simulated) -> ControlFlow<()>,
    ) {
        let pushes = self.pushes_on_the_way();
        for event in &input.events {
            self.handle(event);
        }
        self.play_frame(time);
        self.play_tick();
        self.steer(time.length());
        if pushes.is_some_and(|before| self.pushes_on_the_way() > Some(before)) {
            self.give_up_journey();
        }
        self.simulate(time, after_tick);
        self.follow_locked();
        self.work_on_cost(time);
        self.look_ahead(time);
        if self.options.pictures || self.ui.any_open() || self.ui.closing() {
            self.lay_out_panels(time);
        } else {
            self.ui.forget();
        }
        self.travel(after_tick);
        self.frames += 1;
    }

    fn simulate(&mut self, time: FrameTime, after_tick: &mut dyn FnMut(&Self, Simulated) -> ControlFlow<()>) {
        // Before the requests: what they change is an intervention.
        self.open_or_close_ledger();
        self.carry_out_requests();
        self.dropped_lately = 0.0;
        if self.travel(after_tick) {
            self.clock.pause(time);
            return;
        }
        // Taken in any case: a step that was asked for before going on is not one of the next pause.
        let steps_asked = std::mem::take(&mut self.control.steps_asked);
        let (mut ticks, step) = if self.control.paused {
            self.clock.pause(time);
            (steps_asked, None)
        } else if self.sim.scene.step == StepKind::Frame {
            let length = time.length() * self.clock.pace();
            self.clock.pause(time);
            (u64::from(length > 0.0), Some(length))
        } else {
            let due = self.clock.due(time);
            self.dropped_lately = due.dropped;
            self.dropped += due.dropped;
            (due.ticks, None)
        };
        if let Some(left) = &mut self.ticks_left {
            ticks = ticks.min(*left);
            *left -= ticks;
        }
        if let Some(length) = step.filter(|length| *length > 0.0)
            && !self.repeats()
        {
            self.sim.world.insert_resource(TimeStep(length));
        }
        if ticks > 0 {
            self.ui.retract(Topic::Place);
            self.control.held.begin_tick();
            self.note_pushes();
        }
        let (mut undone, mut late) = (0, false);
        for tick in 1..=ticks {
            if tick > 1 {
                self.play_between_ticks();
            }
            let last = tick == ticks && self.options.interpolate;
            // A trail has to know of every tick where its bodies were before it.
            if last || (self.control.trails && self.options.interpolate) {
                self.sim.world.run_system_cached(remember_positions).expect("a query and nothing else");
            }
            let repeated = self.repeat_before_tick();
            self.tick_ghosts(last);
            if !repeated {
                self.record_before_tick();
            }
            self.tick();
            if self.control.trails {
                let time = self.simulated();
                self.trails.after_tick(&mut self.sim.world, time);
            }
            late = after_tick(self, Simulated::Anew).is_break();
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
            self.dropped_lately += dropped;
            self.dropped += dropped;
        }
        let between = self.options.interpolate
            && !self.control.paused
            && self.sim.scene.step == StepKind::Fixed
            // Positions are remembered before the last tick, which was not reached.
            && undone == 0;
        self.alpha = if between { self.clock.fraction() } else { 1.0 };
        self.targets_current = false;
        self.note_quarantined();
        self.note_unconverged();
        self.meet_fault();
        self.travel(after_tick);
    }

    /// Notes the pushes of the coming tick. They are shown until the next one: a frame without a tick changes nothing.
    pub(crate) fn note_pushes(&mut self) {
        self.acting.clear();
        for Push { body, newtons } in self.sim.world.resource::<PushQueue>().pending() {
            *self.acting.entry(body).or_default() += newtons;
        }
    }

    fn follow_locked(&mut self) {
        if let Some(body) = self.control.locked {
            match self.drawn_position(body) {
                Some(position) => self.camera.follow(position),
                None => self.control.locked = None,
            }
        }
    }

    /// Asks for a change at the start of the next tick.
    pub(crate) fn ask(&mut self, request: Request) {
        self.sim.request(request);
    }

    /// Gives `body` a method of its own, or the scene's.
    pub(crate) fn set_body_method(&mut self, body: Entity, method: Option<Method>) {
        let gravity = self.sim.world.contains_resource::<MutualGravity>();
        if self.refuses([method.unwrap_or(self.sim.method())], gravity) {
            return;
        }
        self.ask(Request::SetBodyMethod(body, method));
    }

    /// Says so where one of `methods` cannot solve what is declared.
    fn refuses(&mut self, methods: impl IntoIterator<Item = Method>, mutual_gravity: bool) -> bool {
        let why = methods.into_iter().find_map(|method| unsolvable(method, mutual_gravity));
        if let Some(why) = why {
            self.refuse(format!("{why}; take another method"));
        }
        why.is_some()
    }

    /// Whether mutual gravity cannot come back, because a method was chosen meanwhile that cannot solve it.
    pub(crate) fn refuses_mutual_gravity(&mut self) -> bool {
        // Also of bodies that nothing moves now, and where every body has one of its own; particles are not attracted.
        let mut bodies = self.sim.world.query_filtered::<EntityRef, (With<OwnMethod>, Without<Particle>)>();
        let own = bodies.iter(&self.sim.world).filter_map(motion::own_method);
        let methods: Vec<_> = own.chain([self.sim.method()]).collect();
        self.refuses(methods, true)
    }

    /// Goes on with another method of the scene.
    pub(crate) fn set_method(&mut self, method: Method) {
        let gravity = self.sim.world.contains_resource::<MutualGravity>();
        if self.refuses([method], gravity) {
            return;
        }
        if method != self.sim.method() {
            self.record(Intervention::Method(method));
            self.ui.retract(Topic::Method);
            self.ui.retract(Topic::Forecast);
        }
        self.sim.set_method(method);
    }

    /// Carries out at once what was asked for; what is gone after that is not selected, followed or hit.
    pub(crate) fn carry_out_requests(&mut self) {
        self.record_requests();
        self.carry_out_unrecorded();
    }

    pub(crate) fn carry_out_unrecorded(&mut self) {
        self.carry_out_in_ghosts();
        if !self.sim.world.resource::<Requests>().is_empty() {
            self.outdate_forecast();
        }
        self.sim.carry_out_requests();
        self.targets_current = false;
        for thing in [&mut self.control.selection, &mut self.control.locked] {
            thing.take_if(|thing| self.sim.world.get_entity(*thing).is_err());
        }
    }
}
