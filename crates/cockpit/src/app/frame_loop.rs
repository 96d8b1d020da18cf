//! Frames in real time: what a shell does around a session on every system. The shell has the clock.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, DVec3};
use scene::Scene;

use crate::actions::{Act, Hold, Lasts, binding};
use crate::app::session::Session;
use crate::app::speed::{Sample, Speed, SpeedSetting};
use crate::clock::FrameClock;
use crate::input::{Input, InputFrame, Key};
use crate::stage::Stage;
use crate::view::camera::Camera;
use crate::view::{Mode, View};

/// Shortest time between two frames, s: vertical sync does not pace every display.
pub const SHORTEST_FRAME_S: f64 = 0.004;

/// Frames that are drawn after something happened: panels may take their place one layout later.
const SETTLING_FRAMES: u32 = 3;

/// Records a frame before it is done: its session, its end, s, and its input.
pub type Record<'a> = dyn FnMut(&mut Session, f64, &[Input]) + 'a;

/// Time in which the camera comes to a scene that was opened, s.
const EASE_S: f64 = 1.2;

/// Degrees that it turns meanwhile.
const EASE_DEGREES: DVec2 = DVec2::new(14.0, 4.0);

/// The way of the camera to its place in a scene, which the first input ends.
struct Ease {
    scene: Arc<Scene>,
    to: Camera,
    pivot: DVec3,
    left_s: f64,
}

impl Ease {
    /// Whether the session still has the scene that was opened.
    fn is_of(&self, session: &Session) -> bool {
        Arc::ptr_eq(&self.scene, &session.stage.sim().scene)
    }
}

/// Input that waits for the next frame, and when that is due. Times are in seconds since the start of the shell's clock.
pub struct FrameLoop {
    /// Input that came since the last frame.
    pub events: Vec<Input>,
    /// Longest time that the ticks of a frame may take, s; the others are dropped, and reported like those of a hitch. Scenes of
    /// more ticks per second than there is time for run slower, and never stop the shell.
    pub patience_s: f64,
    clock: FrameClock,
    last: Option<f64>,
    /// Frames to be drawn before the shell may rest.
    unsettled: u32,
    /// Whether the shell has waited since the last frame, because nothing changed.
    rested: bool,
    /// Whether the camera is still to turn to the place of a scene that was opened.
    comes: bool,
    ease: Option<Ease>,
    speed: Speed,
}

impl Default for FrameLoop {
    fn default() -> Self {
        Self {
            events: Vec::new(),
            patience_s: 0.25,
            clock: FrameClock::default(),
            last: None,
            unsettled: SETTLING_FRAMES,
            rested: false,
            comes: false,
            ease: None,
            speed: Speed::default(),
        }
    }
}

impl FrameLoop {
    /// Does an action as its key does, in the next frame.
    pub fn press(&mut self, act: Act) {
        let key = act.key();
        self.events.extend([Input::KeyDown(key.clone()), Input::KeyUp(key)]);
    }

    /// Takes a key that went down or up at `now`. Of one that pushes, the time counts, which is between two frames.
    pub fn key(&mut self, key: Key, down: bool, now: f64) {
        if binding(&key).is_some_and(|row| matches!(row.lasts, Lasts::While(Hold::Push(_)))) {
            self.events.push(Input::At(now));
        }
        self.events.push(if down { Input::KeyDown(key) } else { Input::KeyUp(key) });
    }

    /// Lets the next frames be drawn, because something happened.
    pub const fn wake(&mut self) {
        self.unsettled = SETTLING_FRAMES;
    }

    /// Lets the next frame be drawn, because this one was not.
    pub fn draw_again(&mut self) {
        self.unsettled = self.unsettled.max(1);
    }

    /// When the next frame is due; infinite if nothing changes before there is input. Two frames are at least `shortest` apart, s.
    pub fn due(&mut self, session: &mut Session, now: f64, shortest: f64) -> f64 {
        let is_unsettled = self.unsettled > 0 || !self.events.is_empty() || self.ease.is_some();
        let changes_in = if is_unsettled { 0.0 } else { session.changes_in_s() };
        let due = self.last.map_or(now, |last| last + changes_in.max(shortest));
        self.rested |= due > now && changes_in > 0.0;
        due
    }

    /// Does a frame, all but its picture: the input since the last one, and ticks. `clock` reads the time. A run that is recorded
    /// drops no ticks, because it is repeated without a wall clock.
    pub fn frame(
        &mut self,
        session: &mut Session,
        clock: &dyn Fn() -> f64,
        mut record: Option<&mut Record<'_>>,
    ) {
        let now = clock();
        self.unsettled = self.unsettled.saturating_sub(1);
        if std::mem::take(&mut self.rested) {
            // The event that ended the rest happened now, not when the rest began.
            let before = now - SHORTEST_FRAME_S;
            self.advance(session, before, Vec::new(), clock, record.as_deref_mut());
        }
        let events = std::mem::take(&mut self.events);
        self.end_ease(session, &events);
        self.advance(session, now, events, clock, record);
        let frame_s = self.last.map_or(0.0, |last| now - last);
        self.last = Some(now);
        // As a key, so that a recording has it; an open question would take the key.
        if session.view.has_bars() && !session.asks() && std::mem::take(&mut session.opened) {
            self.comes = true;
            if session.view.should_be_framed(&session.stage) {
                self.press(Act::Frame);
            }
        }
        self.ease(session, frame_s);
    }

    /// Puts the camera to its place if a person does something, as if it had been there from the start.
    fn end_ease(&mut self, session: &mut Session, events: &[Input]) {
        let looks = session.view.mode == Mode::Camera;
        let is_harmless = |event: &Input| {
            matches!(event, Input::At(_)) || (!looks && matches!(event, Input::Mouse(..)))
        };
        let ended = self.ease.take_if(|_| !events.iter().all(is_harmless));
        if let Some(ease) = ended.filter(|ease| ease.is_of(session)) {
            session.view.camera = ease.to;
        }
    }

    /// Brings the camera nearer to its place, or begins to, once the scene is framed. A lesson may measure the camera, so there it
    /// stands.
    fn ease(&mut self, session: &mut Session, frame_s: f64) {
        if self.comes && self.events.is_empty() {
            self.comes = false;
            let stands =
                session.tools.learn.lesson().is_some() || session.view.mode == Mode::Camera;
            let pivot = View::middle(&session.stage).filter(|_| !stands);
            self.ease = pivot.map(|pivot| Ease {
                scene: Arc::clone(&session.stage.sim().scene),
                to: session.view.camera,
                pivot,
                left_s: EASE_S + frame_s,
            });
        }
        let Some(mut ease) = self.ease.take().filter(|ease| ease.is_of(session)) else { return };
        ease.left_s -= frame_s;
        session.view.camera = ease.to;
        if ease.left_s > 0.0 {
            session.view.camera.orbit(ease.pivot, EASE_DEGREES * (ease.left_s / EASE_S).powi(3));
            self.ease = Some(ease);
        }
    }

    /// Advances the session to `now`.
    fn advance(
        &mut self,
        session: &mut Session,
        now: f64,
        events: Vec<Input>,
        clock: &dyn Fn() -> f64,
        record: Option<&mut Record<'_>>,
    ) {
        // Wall time only goes forward, and so does this.
        let Ok(time) = self.clock.advance_to(now) else {
            self.events.splice(0..0, events);
            return;
        };
        let patience = if record.is_some() { f64::INFINITY } else { self.patience_s };
        if let Some(record) = record {
            record(session, time.total(), &events);
        }
        let (before, ticks_before) = (clock(), session.stage.sim().ticks());
        let progress = |stage: &Stage| stage.playback().progress(stage.sim());
        let progress_before = progress(&session.stage);
        // Measured to the end of the last tick: the panels, which come after it, take longer than all ticks.
        let mut after = before;
        let was_seeking = session.stage.recorder().is_seeking();
        session.advance_watched(&InputFrame { events }, time, &mut |_, _| {
            after = clock();
            match after - before > patience {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        // Panels are laid out before a seek ends.
        if was_seeking && !session.stage.recorder().is_seeking() {
            self.wake();
        }
        self.speed.frame(Sample {
            length_s: time.length(),
            // A run that went back simulated nothing.
            simulated_s: (progress(&session.stage) - progress_before).max(0.0),
            ticks: session.stage.sim().ticks().saturating_sub(ticks_before),
            ticking: Duration::try_from_secs_f64(after - before).unwrap_or_default(),
            setting: SpeedSetting::of(session),
        });
        session.set_measured(self.speed.measured());
    }
}
