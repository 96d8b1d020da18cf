//! Plays a lesson without a window, as a person would who has its solution.

use std::fmt;

use history::Overrides;
use lab::lesson::{Quantities, RunLimit, run_lesson};
use report::numbers::digits;
use scene::lesson::{Goal, Lesson, Measure, Quantity, RunMeasure, ScreenMeasure, beside};
use scene::{Action, InputAction, SceneError, Script, Step, StepKind, When, did_you_mean, nearest};

use crate::actions::{Act, key_of_word};
use crate::app::focus::pointable;
use crate::app::player::Player;
use crate::app::script;
use crate::app::session::Session;
use crate::clock::FrameClock;
#[cfg(test)]
use crate::input::Input;
use crate::input::InputFrame;
use crate::intent::Intent;
use crate::stage::Order;
use crate::stage::options::Options;
use crate::tools::learn::panel_of;

/// Why a lesson was not played to its end.
#[derive(Debug)]
pub enum Unplayed {
    /// A scene cannot be read, or the lesson names something that there is not.
    Unreadable(String),
    /// Something that the lesson claims, accepts or refuses does not hold.
    Wrong(String),
}

impl fmt::Display for Unplayed {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Unreadable(what) | Self::Wrong(what)) = self;
        out.write_str(what)
    }
}

impl From<SceneError> for Unplayed {
    fn from(error: SceneError) -> Self {
        Self::Unreadable(error.to_string())
    }
}

/// Frames per second.
const FPS: f64 = 60.0;

/// Simulated seconds in which a solution has to do its step.
const PATIENCE_S: f64 = 20.0;

/// Least time after which a wrong way counts as refused, simulated s.
const WRONG_S: f64 = 3.0;
/// Time after which a wrong way counts as refused, as a multiple of the time that the solution took.
const LONGER: f64 = 1.2;

/// Longest wait for a step to begin, s.
const MOST_WAIT_S: f64 = 3.0;

/// What the runs of a lesson measured, with `times` as many ticks per second as the runs specify.
pub struct Runs {
    times: f64,
    measured: Quantities,
}

impl Runs {
    /// Makes the runs of `lesson`.
    pub fn new(lesson: &Lesson, times: f64) -> Result<Self, Unplayed> {
        Ok(Self { times, measured: run_lesson(lesson, times, RunLimit::USUAL)? })
    }
}

/// A session that plays a lesson.
pub struct Pupil {
    /// The session.
    pub session: Session,
    clock: FrameClock,
    /// Frames per second.
    pub fps: f64,
}

impl Pupil {
    /// Begins `lesson`, with `times` as many ticks per second as its scenes have.
    pub fn begin(lesson: &Lesson, runs: &Runs, options: Options) -> Result<Self, Unplayed> {
        let Runs { times, measured } = runs;
        let scene = scene::load(&beside(&lesson.name, &lesson.scene))?;
        // A scene of one tick per frame has more ticks by more frames.
        let fps = if scene.step == StepKind::Fixed { FPS } else { FPS * times };
        let overrides = Overrides { step_hz: Some(scene.step_hz * times), ..Overrides::default() };
        let mut session = Session::new(scene, Options { overrides, ..options });
        session.stage.keep_timeline();
        session.set_unseen(!options.pictures);
        // The window with bars begins with a free pointer, too.
        session.free_pointer();
        session.begin_lesson(lesson.clone(), measured.clone());
        let mut pupil = Self { session, clock: FrameClock::default(), fps };
        pupil.frames(2);
        Ok(pupil)
    }

    /// The number of the present step.
    pub fn step(&self) -> usize {
        self.session.tools.lesson().map_or(0, |state| state.step)
    }

    fn frames(&mut self, frames: u32) {
        for _ in 0..frames {
            let Ok(time) = self.clock.advance_by(1.0 / self.fps) else { return };
            self.session.advance(&InputFrame::NOTHING, time);
        }
    }

    /// A frame in which the window gets another size.
    #[cfg(test)]
    pub(crate) fn resize(&mut self, size_px: [u32; 2]) {
        let time = self.clock.advance_by(1.0 / self.fps).expect("a time");
        self.session.advance(&InputFrame::from_iter([Input::Resized(size_px)]), time);
    }

    /// Waits until the present step has begun.
    fn wait_for_step(&mut self) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred frames"
        )]
        let most = (MOST_WAIT_S * self.fps).ceil() as u32;
        for _ in 0..most {
            if self.session.tools.lessons().has_begun() {
                return;
            }
            self.frames(1);
        }
    }

    /// Does `actions`, each in its own frames, and waits until the step is done, but no longer than `patience` seconds of
    /// simulated time after them. Returns whether the lesson continued.
    fn act(&mut self, actions: &[Action], patience: f64) -> Result<bool, Unplayed> {
        self.wait_for_step();
        let before = self.step();
        let (player, frame) = player(actions, self.session.stage.playback().frames(), self.fps)?;
        self.session.play(player);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand frames"
        )]
        let last = frame + (patience * self.fps).ceil() as u64;
        while self.session.stage.playback().frames() < last && self.step() == before {
            self.frames(1);
            open_scenes(&mut self.session)?;
        }
        Ok(self.step() > before)
    }

    /// Does the current step by its solution. Returns whether the lesson continued.
    pub fn solve(&mut self, lesson: &Lesson) -> Result<bool, Unplayed> {
        match lesson.steps.get(self.step()).map(|step| &step.goal) {
            None => Ok(false),
            Some(Goal::Done { solution, .. }) => self.act(solution, PATIENCE_S),
            Some(Goal::Number { solution, .. } | Goal::Choice { solution, .. }) => {
                let right = self.session.tools.lessons().answer(solution);
                self.frames(2);
                Ok(right)
            }
        }
    }
}

/// Frames the bodies if the scene leaves the camera to the program.
pub fn frame_bodies(session: &mut Session) {
    if session.view.should_be_framed(&session.stage) {
        session.carry_out(Intent::Act(Act::Frame));
    }
}

/// Makes a player that carries out `actions` from frame number `frame` on, each in its own frames. Also returns the frame after
/// them.
pub fn player(actions: &[Action], mut frame: u64, fps: f64) -> Result<(Player, u64), Unplayed> {
    let steps = actions.iter().filter_map(|action| {
        let when = When::Frame(frame);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a thousand frames"
        )]
        let lasts = (script::length_s(action) * fps).ceil() as u64;
        frame = frame.saturating_add(lasts.saturating_add(2));
        (!matches!(action, Action::Input(InputAction::Wait(_))))
            .then(|| Step { when, action: action.clone() })
    });
    let script = Script { steps: steps.collect(), recording: None };
    let player = Player::new(script).map_err(|unknown| {
        let words: Vec<_> = unknown.iter().map(|(_, key)| key.to_string()).collect();
        Unplayed::Unreadable(words.join("; "))
    })?;
    Ok((player, frame))
}

/// Opens the scenes that a solution opens; nothing else that is ordered matters to a lesson.
fn open_scenes(session: &mut Session) -> Result<(), Unplayed> {
    for order in session.stage.take_orders() {
        if let Order::Open(name) = order {
            session.open(scene::load(&name)?);
        }
    }
    Ok(())
}

/// Plays `lesson` at its step size and at half of it. The solution and the other ways have to be accepted, and their claims have
/// to hold; every wrong way has to be refused. Returns a report of what was measured.
pub fn check(lesson: &Lesson) -> Result<String, Unplayed> {
    let mut lines = format!("{}: {}\n", lesson.name, lesson.title);
    check_names(lesson)?;
    check_claims(lesson)?;
    let mut refused = 0;
    for times in [1.0, 2.0] {
        let runs = Runs::new(lesson, times)?;
        let mut pupil = Pupil::begin(lesson, &runs, quiet())?;
        lines += &format!("at {} Hz\n", digits(pupil.session.stage.playback().step_hz()));
        for (number, step) in lesson.steps.iter().enumerate() {
            let fail = |what: String| {
                let place = place(lesson, number);
                Err(Unplayed::Wrong(format!("{place}, at {times} times the rate: {what}")))
            };
            pupil.frames(2);
            if pupil.step() != number {
                return fail("it is done before anything was done".to_owned());
            }
            pupil.wait_for_step();
            let began = pupil.session.stage.sim().seconds();
            if !pupil.solve(lesson)? {
                let judged_by = pupil.session.tools.lessons().judged_by();
                let given = match &step.goal {
                    Goal::Number { solution, .. } | Goal::Choice { solution, .. } => {
                        format!("the answer \"{solution}\"")
                    }
                    Goal::Done { .. } => "the solution".to_owned(),
                };
                return fail(format!("{given} is not accepted: {judged_by}"));
            }
            let Some(state) = pupil.session.tools.lesson() else {
                return fail("it was left".to_owned());
            };
            let untrue = |by: &str| {
                let holds = step.holds.as_ref().map_or("", |holds| holds.text());
                format!("`{holds}` is not true{by}")
            };
            if !state.holds {
                return fail(untrue(""));
            }
            let took = pupil.session.stage.sim().seconds() - began;
            for (way, held) in other_ways(lesson, number, &runs)? {
                match held {
                    None => return fail(format!("{way} is not accepted")),
                    Some(false) => return fail(untrue(&format!(" by {way}"))),
                    Some(true) => {}
                }
            }
            for (way, went_on) in wrong_ways(lesson, number, &runs, WRONG_S.max(LONGER * took))? {
                if went_on {
                    return fail(format!("{way} is accepted, and is wrong"));
                }
                refused += 1;
            }
            let said = state.said.unwrap_or_default();
            lines += &format!("  {} done after {} s. {said}\n", number + 1, digits(took));
        }
    }
    // Each was tried at two step sizes.
    refused /= 2;
    if refused < 2 {
        return Err(Unplayed::Wrong(format!(
            "{}: fewer than two wrong ways are refused",
            lesson.name
        )));
    }
    lines += &format!("{refused} wrong ways were refused\n");
    Ok(lines)
}

/// The name of a lesson, the number of a step of it and its line.
fn place(lesson: &Lesson, number: usize) -> String {
    let line = lesson.steps[number].line.map(|line| format!(", line {line}")).unwrap_or_default();
    format!("{}: step {}{line}", lesson.name, number + 1)
}

/// Checks the names of keys and panels, which the reader of lessons does not know.
fn check_names(lesson: &Lesson) -> Result<(), Unplayed> {
    let wrong = |place: String, what: String| Err(Unplayed::Unreadable(format!("{place}: {what}")));
    for Quantity { name, measure } in &lesson.measure {
        if let Measure::Screen(ScreenMeasure::Shows(panel)) = measure
            && panel_of(panel).is_none()
        {
            let cure = "`sandbox list keys` names the panels";
            return wrong(
                format!("{}: measure.{name}", lesson.name),
                format!("there is no panel `{panel}`; {cure}"),
            );
        }
    }
    let scene = scene::load(&beside(&lesson.name, &lesson.scene))?;
    for (i, step) in lesson.steps.iter().enumerate() {
        if let Some(name) = step.point_at.as_deref().filter(|name| scene.names.find(name).is_none())
            && !pointable().any(|control| control == name)
        {
            let guess = did_you_mean(nearest(name, pointable()).map(|near| format!("\"{near}\"")));
            let cure = format!("{guess}name a body, or a control as it is written on the screen");
            return wrong(
                format!("{}: point_at", place(lesson, i)),
                format!("there is no \"{name}\"; {cure}"),
            );
        }
        for (path, action) in step.goal.actions() {
            if let Some(error) = action.key().and_then(|key| key_of_word(key).err()) {
                return wrong(format!("{}: {path}", place(lesson, i)), error.to_string());
            }
        }
    }
    Ok(())
}

/// Checks that each claim of a step that is done, not answered, has a quantity that the step can change: a claim about a run or
/// about masses alone would be the same whatever the person did.
fn check_claims(lesson: &Lesson) -> Result<(), Unplayed> {
    let changes = |name: &String| {
        let quantity = lesson.of_screen(name);
        quantity
            .is_some_and(|quantity| !matches!(quantity.measure, Measure::Run(RunMeasure::Mass(_))))
    };
    for (i, step) in lesson.steps.iter().enumerate() {
        let fail = |what: String| Err(Unplayed::Wrong(format!("{}: {what}", place(lesson, i))));
        let claims = step.then.claims();
        if claims.is_empty() && step.holds.is_some() {
            return fail(
                "`holds` has no `then` with numbers, so nothing says when it is not true"
                    .to_owned(),
            );
        }
        let is_done = matches!(step.goal, Goal::Done { .. });
        let fixed = claims
            .iter()
            .find(|claim| !claim.iter().flat_map(|formula| formula.names()).any(changes));
        if let Some(claim) = fixed.filter(|_| is_done) {
            let formula = claim.first().map_or("", |formula| formula.text());
            let cure = "name a quantity of the screen that the step changes";
            return fail(format!("`then` says {{{formula}}} whatever the person does; {cure}"));
        }
    }
    Ok(())
}

/// A session that is at step `number`.
fn at_step(lesson: &Lesson, number: usize, runs: &Runs) -> Result<Pupil, Unplayed> {
    let mut pupil = Pupil::begin(lesson, runs, quiet())?;
    while pupil.step() < number && pupil.solve(lesson)? {}
    Ok(pupil)
}

/// Every other way of step `number`, and whether the claims hold after it; `None` if it is not accepted.
fn other_ways(
    lesson: &Lesson,
    number: usize,
    runs: &Runs,
) -> Result<Vec<(String, Option<bool>)>, Unplayed> {
    let Goal::Done { also, .. } = &lesson.steps[number].goal else { return Ok(Vec::new()) };
    let play = |(way, actions): (usize, &Vec<Action>)| {
        let mut pupil = at_step(lesson, number, runs)?;
        let held = pupil.act(actions, PATIENCE_S)?.then(|| pupil.session.tools.lesson()).flatten();
        Ok((format!("way {} of `also`", way + 1), held.map(|state| state.holds)))
    };
    also.iter().enumerate().map(play).collect()
}

/// Every wrong way of step `number`, and whether the lesson accepts it within `patience` simulated seconds.
fn wrong_ways(
    lesson: &Lesson,
    number: usize,
    runs: &Runs,
    patience: f64,
) -> Result<Vec<(String, bool)>, Unplayed> {
    let judged = |answers: Vec<&String>| {
        let mut pupil = at_step(lesson, number, runs)?;
        let judge = |answer: &String| {
            let learn = pupil.session.tools.lessons();
            (format!("the answer {answer:?} ({})", learn.judged_by()), learn.accepts(answer))
        };
        Ok::<Vec<_>, Unplayed>(answers.into_iter().map(judge).collect())
    };
    match &lesson.steps[number].goal {
        Goal::Done { wrong, .. } => {
            let play = |(way, actions): (usize, &Vec<Action>)| {
                Ok((
                    format!("way {} of `wrong`", way + 1),
                    at_step(lesson, number, runs)?.act(actions, patience)?,
                ))
            };
            wrong.iter().enumerate().map(play).collect()
        }
        Goal::Number { wrong, .. } => judged(wrong.iter().map(|wrong| &wrong.answer).collect()),
        Goal::Choice { choices, .. } => {
            // Several may be right, but not all.
            let all = judged(choices.iter().map(|choice| &choice.say).collect())?;
            let none_is_wrong = all.iter().all(|(_, right)| *right);
            Ok(all.into_iter().filter(|(_, right)| none_is_wrong || !right).collect())
        }
    }
}

fn quiet() -> Options {
    Options { pictures: false, ..Options::default() }
}
