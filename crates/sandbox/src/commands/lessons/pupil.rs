//! Plays a lesson without a window, as a person would who has its solution.

use std::path::Path;

use history::Overrides;
use lab::lesson::{Quantities, RunLimit, run_lesson};
use render::Image;
use report::numbers::digits;
use scene::lesson::{Goal, Lesson, Measure, Quantity, RunMeasure, ScreenMeasure, beside};
use scene::{Action, InputAction, Script, Step, StepKind, When, did_you_mean, nearest};

use crate::args::cores;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::orders::{Kind, Program, carry_out};
use crate::output::progress::Waiting;
use cockpit::actions::{Act, key_of_word};
use cockpit::app::focus::pointable;
use cockpit::app::player::Player;
use cockpit::app::session::Session;
use cockpit::clock::FrameClock;
use cockpit::input::InputFrame;
use cockpit::intent::Intent;
use cockpit::stage::SceneFile;
use cockpit::stage::options::Options;
use cockpit::tools::learn::panel_of;

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
pub(super) struct Runs {
    times: f64,
    measured: Quantities,
}

impl Runs {
    pub fn new(lesson: &Lesson, times: f64) -> Result<Self, Failure> {
        Ok(Self { times, measured: run_lesson(lesson, times, RunLimit::USUAL)? })
    }
}

/// A session that plays a lesson.
pub(super) struct Pupil {
    pub session: Session,
    clock: FrameClock,
    fps: f64,
    alone: Alone,
}

impl Pupil {
    /// Begins `lesson`, with `times` as many ticks per second as its scenes have.
    pub fn begin(lesson: &Lesson, runs: &Runs, options: Options) -> Result<Self, Failure> {
        let Runs { times, measured } = runs;
        let mut alone = Alone::default();
        let scene = alone.files.scene(&beside(&lesson.name, &lesson.scene))?;
        // A scene of one tick per frame has more ticks by more frames.
        let fps = if scene.step == StepKind::Fixed { FPS } else { FPS * times };
        let overrides = Overrides { step_hz: Some(scene.step_hz * times), ..Overrides::default() };
        let mut session = Session::new(scene, Options { overrides, ..options });
        session.stage.keep_timeline();
        session.set_unseen(!options.pictures);
        // The window with bars begins with a free pointer, too.
        session.free_pointer();
        session.begin_lesson(lesson.clone(), measured.clone());
        let mut pupil = Self { session, clock: FrameClock::default(), fps, alone };
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
    fn act(&mut self, actions: &[Action], patience: f64) -> Result<bool, Failure> {
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
            carry_out(self.session.stage.take_orders(), &mut self.session, &mut self.alone)?;
        }
        Ok(self.step() > before)
    }

    /// Does the current step by its solution. Returns whether the lesson continued.
    pub fn solve(&mut self, lesson: &Lesson) -> Result<bool, Failure> {
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
pub(super) fn frame_bodies(session: &mut Session) {
    if session.view.should_be_framed(&session.stage) {
        session.carry_out(Intent::Act(Act::Frame));
    }
}

/// Makes a player that carries out `actions` from frame number `frame` on, each in its own frames. Also returns the frame after
/// them.
fn player(actions: &[Action], mut frame: u64, fps: f64) -> Result<(Player, u64), Failure> {
    let steps = actions.iter().filter_map(|action| {
        let when = When::Frame(frame);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a thousand frames"
        )]
        let lasts =
            if let Action::Input(InputAction::Hold(_, seconds) | InputAction::Wait(seconds)) =
                action
            {
                (seconds * fps).ceil() as u64
            } else {
                0
            };
        frame = frame.saturating_add(lasts.saturating_add(2));
        (!matches!(action, Action::Input(InputAction::Wait(_))))
            .then(|| Step { when, action: action.clone() })
    });
    let script = Script { steps: steps.collect(), recording: None };
    let player = Player::new(script).map_err(|unknown| {
        let words: Vec<_> = unknown.iter().map(|(_, key)| key.to_string()).collect();
        Failure::Usage(words.join("; "))
    })?;
    Ok((player, frame))
}

/// Seconds for which a step of a demonstration is read before it is done.
const READ_S: f64 = 3.0;

/// A lesson that is shown in a run: each step is read, then done by its solution.
pub(crate) struct Demonstration {
    lesson: Lesson,
    fps: f64,
    /// The step that is being done, and the frame in which its question is answered.
    step: Option<(usize, u64)>,
}

impl Demonstration {
    /// Shows `lesson` at `fps` frames per second.
    pub fn new(lesson: Lesson, fps: f64) -> Self {
        Self { lesson, fps, step: None }
    }

    /// Begins the lesson in `session`, which has its scene.
    pub fn begin(&self, session: &mut Session) -> Result<(), Failure> {
        let _waiting = Waiting::begin("measuring the runs of the lesson");
        session.begin_lesson(self.lesson.clone(), run_lesson(&self.lesson, 1.0, RunLimit::USUAL)?);
        session.free_pointer();
        frame_bodies(session);
        Ok(())
    }

    /// A message that says how many steps were done, if the lesson in `session` is not finished.
    pub fn left(&self, session: &Session) -> Option<String> {
        let (step, all) = (session.tools.lesson()?.step, self.lesson.steps.len());
        let what = format!(
            "{}: {step} of {all} steps were done; let the run last longer",
            self.lesson.name
        );
        (step < all).then_some(what)
    }

    /// Whether it will do something in `session` by itself: a step that begins paused is read before it is done.
    pub fn waits(&self, session: &Session) -> bool {
        let now = session.stage.playback().frames();
        session.tools.lesson().is_some_and(|state| {
            let is_new = self.step.is_none_or(|(before, due)| before != state.step || due >= now);
            is_new && state.step < self.lesson.steps.len()
        })
    }

    /// Does in `session` what is due in the next frame.
    pub fn before_frame(&mut self, session: &mut Session) -> Result<(), Failure> {
        let Some(state) = session.tools.lesson() else { return Ok(()) };
        let Some(step) = self.lesson.steps.get(state.step) else { return Ok(()) };
        let now = session.stage.playback().frames();
        if self.step.is_none_or(|(before, _)| before != state.step) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a few hundred frames"
            )]
            let due = now + (READ_S * self.fps).ceil() as u64;
            self.step = Some((state.step, due));
            if let Goal::Done { solution, .. } = &step.goal {
                session.play(player(solution, due, self.fps)?.0);
            }
        }
        if let Goal::Number { solution, .. } | Goal::Choice { solution, .. } = &step.goal
            && self.step.is_some_and(|(_, due)| due == now)
        {
            session.tools.lessons().answer(solution);
        }
        Ok(())
    }
}

/// A [`Program`] that opens scenes and writes nothing.
#[derive(Default)]
struct Alone {
    files: CommandFiles,
}

impl Program for Alone {
    fn picture(&mut self, _: &mut Session) -> Result<Option<Image>, Failure> {
        Ok(None)
    }

    fn folder(&self) -> Option<&Path> {
        None
    }

    fn files(&mut self) -> &mut CommandFiles {
        &mut self.files
    }

    fn name(&self, kind: Kind, _: &Session) -> String {
        kind.join(".")
    }

    fn save_scene(&mut self, _: &mut Session, _: &SceneFile) -> Result<(), Failure> {
        Ok(())
    }

    fn report(&mut self, _: &mut Session, outcome: Result<&Path, Failure>) -> Result<(), Failure> {
        outcome.map(drop)
    }

    fn opened(&mut self, _: &mut Session) -> Result<(), Failure> {
        Ok(())
    }
}

/// Plays `lesson` at its step size and at half of it. The solution and the other ways have to be accepted, and their claims have
/// to hold; every wrong way has to be refused. Returns a report of what was measured.
pub(super) fn check(lesson: &Lesson) -> Result<String, Failure> {
    let mut lines = format!("{}: {}\n", lesson.name, lesson.title);
    check_names(lesson)?;
    check_claims(lesson)?;
    let _waiting = Waiting::begin("playing the lesson");
    let mut refused = 0;
    for times in [1.0, 2.0] {
        let runs = Runs::new(lesson, times)?;
        let mut pupil = Pupil::begin(lesson, &runs, quiet())?;
        lines += &format!("at {} Hz\n", digits(pupil.session.stage.playback().step_hz()));
        for (number, step) in lesson.steps.iter().enumerate() {
            let fail = |what: String| {
                Err(Failure::Expectation(format!(
                    "{}: steps[{number}] at {times} times the rate: {what}",
                    lesson.name
                )))
            };
            pupil.frames(2);
            if pupil.step() != number {
                return fail("it is done before anything was done".to_owned());
            }
            pupil.wait_for_step();
            let began = pupil.session.stage.sim().seconds();
            if !pupil.solve(lesson)? {
                return fail("the solution is not accepted".to_owned());
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
                    return fail(format!("the wrong way {way} is accepted"));
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
        return Err(Failure::Expectation(format!(
            "{}: fewer than two wrong ways are refused",
            lesson.name
        )));
    }
    lines += &format!("{refused} wrong ways were refused\n");
    Ok(lines)
}

/// Checks the names of keys and panels, which the reader of lessons does not know.
fn check_names(lesson: &Lesson) -> Result<(), Failure> {
    let wrong = |place: String, what: String| {
        Err(Failure::Usage(format!("{}: {place}: {what}", lesson.name)))
    };
    for Quantity { name, measure } in &lesson.measure {
        if let Measure::Screen(ScreenMeasure::Shows(panel)) = measure
            && panel_of(panel).is_none()
        {
            let cure = "`sandbox list keys` names the panels";
            return wrong(
                format!("measure.{name}"),
                format!("there is no panel `{panel}`; {cure}"),
            );
        }
    }
    let scene = CommandFiles::default().scene(&beside(&lesson.name, &lesson.scene))?;
    for (i, step) in lesson.steps.iter().enumerate() {
        if let Some(name) = step.point_at.as_deref().filter(|name| scene.names.find(name).is_none())
            && !pointable().any(|control| control == name)
        {
            let guess = did_you_mean(nearest(name, pointable()).map(|near| format!("\"{near}\"")));
            let cure = format!("{guess}name a body, or a control as it is written on the screen");
            return wrong(
                format!("steps[{i}].point_at"),
                format!("there is no \"{name}\"; {cure}"),
            );
        }
        for (path, action) in step.goal.actions() {
            if let Some(error) = action.key().and_then(|key| key_of_word(key).err()) {
                return wrong(format!("steps[{i}].{path}"), error.to_string());
            }
        }
    }
    Ok(())
}

/// Checks that each claim of a step that is done, not answered, has a quantity that the step can change: a claim about a run or
/// about masses alone would be the same whatever the person did.
fn check_claims(lesson: &Lesson) -> Result<(), Failure> {
    let changes = |name: &String| {
        let quantity = lesson.of_screen(name);
        quantity
            .is_some_and(|quantity| !matches!(quantity.measure, Measure::Run(RunMeasure::Mass(_))))
    };
    for (i, step) in lesson.steps.iter().enumerate() {
        let fail = |what: String| {
            Err(Failure::Expectation(format!("{}: steps[{i}]: {what}", lesson.name)))
        };
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
fn at_step(lesson: &Lesson, number: usize, runs: &Runs) -> Result<Pupil, Failure> {
    let mut pupil = Pupil::begin(lesson, runs, quiet())?;
    while pupil.step() < number && pupil.solve(lesson)? {}
    Ok(pupil)
}

/// Every other way of step `number`, and whether the claims hold after it; `None` if it is not accepted.
fn other_ways(
    lesson: &Lesson,
    number: usize,
    runs: &Runs,
) -> Result<Vec<(String, Option<bool>)>, Failure> {
    let Goal::Done { also, .. } = &lesson.steps[number].goal else { return Ok(Vec::new()) };
    let play = |(way, actions): (usize, &Vec<Action>)| {
        let mut pupil = at_step(lesson, number, runs)?;
        let held = pupil.act(actions, PATIENCE_S)?.then(|| pupil.session.tools.lesson()).flatten();
        Ok((format!("also[{way}]"), held.map(|state| state.holds)))
    };
    also.iter().enumerate().map(play).collect()
}

/// Every wrong way of step `number`, and whether the lesson accepts it within `patience` simulated seconds.
fn wrong_ways(
    lesson: &Lesson,
    number: usize,
    runs: &Runs,
    patience: f64,
) -> Result<Vec<(String, bool)>, Failure> {
    let judged = |answers: Vec<&String>| {
        let mut pupil = at_step(lesson, number, runs)?;
        let judge = |answer: &String| {
            (format!("{answer:?}"), pupil.session.tools.lessons().accepts(answer))
        };
        Ok::<Vec<_>, Failure>(answers.into_iter().map(judge).collect())
    };
    match &lesson.steps[number].goal {
        Goal::Done { wrong, .. } => {
            let play = |(way, actions): (usize, &Vec<Action>)| {
                Ok((
                    format!("wrong[{way}]"),
                    at_step(lesson, number, runs)?.act(actions, patience)?,
                ))
            };
            wrong.iter().enumerate().map(play).collect()
        }
        Goal::Number { wrong, .. } => judged(wrong.iter().collect()),
        Goal::Choice { choices, .. } => {
            // Several may be right, but not all.
            let all = judged(choices.iter().map(|(say, _)| say).collect())?;
            let none_is_wrong = all.iter().all(|(_, right)| *right);
            Ok(all.into_iter().filter(|(_, right)| none_is_wrong || !right).collect())
        }
    }
}

fn quiet() -> Options {
    Options { pictures: false, threads: cores(), ..Options::default() }
}
