//! The open lesson, and progress in it.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use lab::lesson::{Quantities, measured};
use scene::lesson::{
    Begin, Formula, Goal, Lesson, LessonStep, Measure, ScreenMeasure, beside, is_same_scene,
};
use scene::{Action, Source};

use crate::panels::Panel;
use crate::stage::Stage;
use crate::tools::ghosts::Ghosts;
use crate::tools::learn::missing::{Measures, in_words, missing};
use crate::tools::learn::panel_of;
use crate::tools::ledger::Ledger;
use crate::tools::number::read_number;
use crate::tools::thumbnails::Thumbnails;
use crate::view::View;

/// The lesson that is open, and the lessons that were done.
#[derive(Default)]
pub struct Learn {
    running: Option<Running>,
    /// The files in the person's folder of lessons, and the titles of the lessons.
    pub own: Vec<(PathBuf, String)>,
    /// Names of the lessons that were done to their end.
    pub done: BTreeSet<String>,
    /// How many steps were done of lessons that were left, by their names.
    pub left: BTreeMap<String, usize>,
    /// The pictures of the lessons.
    pub(super) pictures: Thumbnails,
    /// Whether the welcome card is shown.
    pub welcome: bool,
    /// Which of the two things on the welcome card were done.
    pub tried: [bool; 2],
    /// Why no lesson could be opened.
    pub fault: Option<String>,
    /// The text typed as an answer.
    pub typed: String,
    /// Whether the panel of lessons is open.
    pub shown: bool,
    /// Whether it is open in this frame, with the scene of the lesson.
    pub(super) measures: bool,
}

/// A lesson in progress.
struct Running {
    lesson: Arc<Lesson>,
    step: usize,
    /// What the runs of the lesson measured.
    of_runs: Quantities,
    /// What was measured of the screen since the step began or the person changed the run.
    of_screen: Quantities,
    /// The sentence at the end of the step before.
    verdict: Option<String>,
    /// Whether the claim of that step was true.
    claim_held: bool,
    /// The steps that were skipped or shown.
    helped: BTreeSet<usize>,
    /// The sentence about the last answer, if it was not right.
    rejection: Option<String>,
    /// What the step begins with, until that is done.
    begin: Vec<Begin>,
    /// Number of interventions in the run that were seen.
    interventions: u64,
    /// When the step began, s of frame time.
    since: Option<f64>,
    /// Whether the person has changed the run since then.
    acted: bool,
    /// When that was first seen, s of frame time.
    acted_at: Option<f64>,
    /// Number of wrong answers to the question of the step.
    tries: u32,
    /// Whether the solution of the step is played as soon as nothing is left in `begin`.
    shows: bool,
    /// Whether the solution of the step was shown since it began.
    is_shown: bool,
    /// Why nothing moves, if nothing does.
    stopped: Option<&'static str>,
}

/// Time after which a step says what is missing even if nothing was done, s.
const MISSING_S: f64 = 10.0;
/// Time after the first change of the run after which a step gives its hint, s: what was done may need a while.
const HINT_S: f64 = 3.0;
/// Time after which a step offers to show its solution, s.
const SHOW_S: f64 = 30.0;
/// Time after which a question takes a click, s.
const READY_S: f64 = 0.4;
/// Number of wrong answers after which a question does.
const MOST_TRIES: u32 = 2;

/// Time for which the end of a step can be seen before the next one begins, if that changes the run, s.
const LINGER_S: f64 = 1.5;

/// The parts of the screen that a lesson measures.
pub(crate) struct Screen<'a> {
    pub view: &'a View,
    /// The panels that are open.
    pub opened: &'a [Panel],
    pub ghosts: &'a Ghosts,
    pub ledger: &'a Ledger,
}

/// Progress in the open lesson.
#[derive(Clone, Debug, PartialEq)]
pub struct LessonState {
    /// Its name.
    pub name: String,
    /// Number of the current step, from 0; the number of steps at the end of the lesson.
    pub step: usize,
    /// The sentence at the end of the step before.
    pub said: Option<String>,
    /// Whether the claim of that step was true; a claim that is not true is not said.
    pub holds: bool,
}

impl Learn {
    /// Opens `lesson`, whose runs measured `of_runs`. Its scene has to be opened, too.
    pub fn open(&mut self, lesson: Arc<Lesson>, of_runs: Quantities) {
        let mut running = Running {
            lesson,
            step: 0,
            of_runs,
            of_screen: Quantities::default(),
            verdict: None,
            claim_held: true,
            helped: BTreeSet::new(),
            rejection: None,
            begin: Vec::new(),
            interventions: 0,
            since: None,
            acted: false,
            acted_at: None,
            tries: 0,
            shows: false,
            is_shown: false,
            stopped: None,
        };
        // It continues where it was left.
        let done = self.left.get(&running.lesson.name).copied().unwrap_or(0);
        running.go_to(if done < running.lesson.steps.len() { done } else { 0 });
        self.running = Some(running);
        (self.welcome, self.fault) = (false, None);
        self.typed.clear();
    }

    /// Leaves the lesson.
    pub fn leave(&mut self) {
        self.running = None;
    }

    /// The open lesson, the number of its step, and the step, which is `None` at the end.
    pub fn lesson(&self) -> Option<(&Arc<Lesson>, usize, Option<&LessonStep>)> {
        let Running { lesson, step, .. } = self.running.as_ref()?;
        Some((lesson, *step, lesson.steps.get(*step)))
    }

    /// The steps that were skipped or shown, from 0: with any the lesson is not done.
    pub fn helped(&self) -> impl Iterator<Item = usize> {
        self.running.iter().flat_map(|running| running.helped.iter().copied())
    }

    /// Whether the last step came out as it claims.
    pub fn claim_held(&self) -> bool {
        self.running.as_ref().is_none_or(|running| running.claim_held)
    }

    /// The sentence at the end of the last step.
    pub fn verdict(&self) -> Option<&str> {
        self.running.as_ref()?.verdict.as_deref()
    }

    /// The sentence about the last answer, if it was not right.
    pub fn rejection(&self) -> Option<&str> {
        self.running.as_ref()?.rejection.as_deref()
    }

    /// The last sentence and the current task, as a caption.
    pub fn caption(&self) -> Option<String> {
        let (.., step) = self.lesson()?;
        let task = step.map(|step| step.task.as_str());
        Some(self.verdict().into_iter().chain(task).collect::<Vec<_>>().join(" "))
    }

    /// Progress in the open lesson.
    pub fn state(&self) -> Option<LessonState> {
        let running = self.running.as_ref()?;
        let (name, said) = (running.lesson.name.clone(), running.verdict.clone());
        Some(LessonState { name, step: running.step, said, holds: running.claim_held })
    }

    /// The control or body at which the present step points.
    pub fn points_at(&self) -> Option<&str> {
        self.lesson()?.2?.point_at.as_deref()
    }

    /// Name or path of the scene of the lesson.
    pub fn home(&self) -> Option<String> {
        self.lesson().map(|(lesson, ..)| beside(&lesson.name, &lesson.scene))
    }

    /// Whether the stage has the scene of the lesson.
    pub fn is_at_home(&self, stage: &Stage) -> bool {
        self.home().is_some_and(|home| match &stage.sim().scene.source {
            Source::Shipped(name) => *name == home,
            Source::File(path) => is_same_scene(&path.to_string_lossy(), &home),
            Source::Text => false,
        })
    }

    /// Forgets what was measured: another world is measured from now on.
    pub fn forget_world(&mut self) {
        if let Some(running) = &mut self.running {
            running.of_screen.forget();
            running.interventions = 0;
        }
    }

    /// Measures the start of another world, before its first tick.
    pub fn begin_world(&mut self, stage: &Stage) {
        if !self.is_at_home(stage) {
            return;
        }
        let Some(running) = &mut self.running else { return };
        for quantity in &running.lesson.measure {
            if let Measure::Run(measure) = &quantity.measure {
                running.of_screen.note(&quantity.name, measured(stage.sim(), measure));
            }
        }
    }

    /// Says at the end of a frame, at `now`, s of frame time, whether anything moves, and measures the current state.
    pub(crate) fn end_frame(&mut self, stage: &Stage, screen: &Screen<'_>, now: f64) {
        if !self.measures {
            return;
        }
        let Some(running) = &mut self.running else { return };
        running.since.get_or_insert(now);
        if running.acted {
            running.acted_at.get_or_insert(now);
        }
        running.stopped = match (stage.playback().paused(), stage.recorder().fault()) {
            (true, Some(_)) => {
                Some("the run stopped where something went wrong: Reset and Play begin again")
            }
            (true, None) => Some("the run is paused: Play continues it"),
            _ => None,
        };
        self.look(stage, screen);
    }

    /// Measures the current state, and begins the next step if the goal of the current one is reached. Called before every tick,
    /// so that what is told does not depend on the frames.
    pub(crate) fn look(&mut self, stage: &Stage, screen: &Screen<'_>) {
        if !self.measures {
            return;
        }
        let Some(running) = &mut self.running else { return };
        if running.interventions != stage.here().interventions {
            running.interventions = stage.here().interventions;
            running.acted = true;
            // The last measurement was before the intervention.
            running.of_screen.begin();
        }
        for quantity in &running.lesson.measure {
            let value = match &quantity.measure {
                Measure::Run(measure) => measured(stage.sim(), measure),
                Measure::Screen(measure) => seen(measure, stage, screen),
            };
            running.of_screen.note(&quantity.name, value);
        }
        let step = running.lesson.steps.get(running.step);
        if let Some(LessonStep { goal: Goal::Done { when, .. }, .. }) = step
            && running.begin.is_empty()
            && running.holds(when)
        {
            self.finish_step();
        }
    }

    /// Takes what the current step begins with, once, at `now`, s of frame time. Empty until it may begin.
    pub fn take_begin(&mut self, stage: &Stage, now: f64) -> Vec<Begin> {
        let begins = self.shown && self.is_at_home(stage);
        let lingers = |running: &Running| {
            running.verdict.is_some() && running.since.is_none_or(|since| now - since < LINGER_S)
        };
        let running = self.running.as_mut().filter(|running| begins && !lingers(running));
        running.map(|running| std::mem::take(&mut running.begin)).unwrap_or_default()
    }

    /// Whether the present step has begun.
    pub fn has_begun(&self) -> bool {
        self.running.as_ref().is_none_or(|running| running.begin.is_empty())
    }

    /// What is missing for the current step at `now`, s of frame time; `None` until there is a reason to say so.
    pub fn missing(&self, now: f64) -> Option<String> {
        let running = self.running.as_ref()?;
        let Goal::Done { when, .. } = &running.step()?.goal else { return None };
        let said = running.acted || now - running.since? >= MISSING_S;
        said.then(|| running.waits_for(when)).filter(|missing| !missing.is_empty())
    }

    /// The hint of the current step at `now`, s of frame time, for a person who waits or did something else.
    pub fn hint(&self, now: f64) -> Option<&str> {
        let running = self.running.as_ref()?;
        let is_late = running.tries > 0
            || now - running.since? >= MISSING_S
            || running.acted_at.is_some_and(|acted| now - acted >= HINT_S);
        Some(running.step()?.hint.as_str()).filter(|hint| is_late && !hint.is_empty())
    }

    /// Whether the question of the current step takes a click at `now`, s of frame time.
    pub fn is_ready(&self, now: f64) -> bool {
        let since = self.running.as_ref().and_then(|running| running.since);
        since.is_some_and(|since| now - since >= READY_S)
    }

    /// Whether the current step offers at `now`, s of frame time, to show its solution.
    pub fn offers_solution(&self, now: f64) -> bool {
        let Some(running) = &self.running else { return false };
        match running.step().map(|step| &step.goal) {
            Some(Goal::Done { .. }) => {
                !running.shows && running.since.is_some_and(|since| now - since >= SHOW_S)
            }
            Some(Goal::Number { .. } | Goal::Choice { .. }) => running.tries >= MOST_TRIES,
            None => false,
        }
    }

    /// Answers the question of the current step, or begins the step again, to show its solution. The lesson is then not done.
    pub fn show_solution(&mut self) {
        let Some(running) = &mut self.running else { return };
        match running.step().map(|step| &step.goal) {
            Some(Goal::Number { solution, .. } | Goal::Choice { solution, .. }) => {
                let solution = solution.clone();
                running.is_shown = true;
                self.answer(&solution);
            }
            Some(Goal::Done { .. }) => {
                running.go_to(running.step);
                (running.shows, running.is_shown) = (true, true);
            }
            None => {}
        }
    }

    /// Takes the solution that is to be played now, once.
    pub fn take_solution(&mut self) -> Option<Vec<Action>> {
        let running = self.running.as_mut().filter(|running| running.begin.is_empty())?;
        let Goal::Done { solution, .. } = &running.lesson.steps.get(running.step)?.goal else {
            return None;
        };
        std::mem::take(&mut running.shows).then(|| solution.clone())
    }

    /// When the current step says more by itself, s of frame time; infinite if it does not.
    pub fn says_more_at(&self, now: f64) -> f64 {
        let running = self.running.iter().filter(|_| self.shown);
        let times = running.flat_map(|running| {
            let since = running.since.into_iter();
            let since =
                since.flat_map(|since| [READY_S, LINGER_S, MISSING_S, SHOW_S].map(|s| since + s));
            since.chain(running.acted_at.map(|acted| acted + HINT_S))
        });
        times.filter(|time| *time > now).fold(f64::INFINITY, f64::min)
    }

    /// Whether `text` is a right answer to the current question.
    pub fn accepts(&self, text: &str) -> bool {
        self.running.as_ref().is_some_and(|running| running.is_right(text))
    }

    /// The values that the goal of the current step is judged by: "v = 3.2, v_before = 0".
    pub fn judged_by(&self) -> String {
        let Some(running) = &self.running else { return String::new() };
        let formulas = match running.step().map(|step| &step.goal) {
            Some(Goal::Done { when, .. }) => vec![when],
            Some(Goal::Number { right, .. }) => vec![right],
            Some(Goal::Choice { choices, .. }) => {
                choices.iter().map(|choice| &choice.right).collect()
            }
            None => Vec::new(),
        };
        let names: BTreeSet<_> = formulas.iter().flat_map(|formula| formula.names()).collect();
        let value = |name: &String| running.value(name).map_or("none".to_owned(), in_words);
        let mut words: Vec<_> =
            names.into_iter().map(|name| format!("{name} = {}", value(name))).collect();
        if let Some(Goal::Number { right, .. }) = running.step().map(|step| &step.goal) {
            let right = right.value(|name| running.value(name));
            words.insert(0, format!("measured {}", in_words(right)));
        }
        words.join(", ")
    }

    /// Judges an answer to the present question, and begins the next step if it is right. Returns whether it is.
    pub fn answer(&mut self, text: &str) -> bool {
        let right = self.accepts(text);
        if right {
            self.finish_step();
        } else if let Some(running) = &mut self.running {
            running.rejection = Some(running.refusal(text.trim()));
            running.tries += 1;
        }
        right
    }

    /// Continues with the next step, and says what was measured.
    fn finish_step(&mut self) {
        self.end_step(false);
    }

    fn end_step(&mut self, skips: bool) {
        let Some(running) = &mut self.running else { return };
        let Some(step) = running.lesson.steps.get(running.step) else { return };
        let said = step.then.filled(|name| running.value(name), in_words);
        running.claim_held = skips || step.holds.as_ref().is_none_or(|holds| running.holds(holds));
        // A claim that is not true is not said; the sentence says instead that it did not come true. A skipped step measured
        // nothing.
        let unlike = || {
            let missing =
                step.holds.as_ref().map(|holds| running.missing(holds)).unwrap_or_default();
            let why = if missing.is_empty() { missing } else { format!(" ({missing})") };
            format!("It did not come out as usual this time{why}. Previous lets you try again.")
        };
        running.verdict = match running.claim_held {
            true => Some(said).filter(|said| !said.is_empty() && !skips),
            false => Some(unlike()),
        };
        // What ends by itself, because it was done before, is not done again.
        let is_own = running.acted || !matches!(step.goal, Goal::Done { .. });
        if skips || running.is_shown {
            running.helped.insert(running.step);
        } else if is_own {
            running.helped.remove(&running.step);
        }
        running.go_to(running.step + 1);
        if running.step == running.lesson.steps.len() && running.helped.is_empty() {
            self.done.insert(running.lesson.name.clone());
        }
        self.typed.clear();
        self.note_place();
    }

    /// Notes where the lesson would continue.
    fn note_place(&mut self) {
        let Some(Running { lesson, step, .. }) = &self.running else { return };
        if (1..lesson.steps.len()).contains(step) {
            self.left.insert(lesson.name.clone(), *step);
        } else {
            self.left.remove(&lesson.name);
        }
    }

    /// Skips the step.
    pub fn skip(&mut self) {
        self.end_step(true);
    }

    /// Goes back to the step before. A step that did not come out as usual begins with a reset, so that it can be tried again.
    pub fn go_back(&mut self) {
        if let Some(running) = &mut self.running {
            let again = !running.claim_held;
            (running.verdict, running.claim_held) = (None, true);
            running.go_to(running.step.saturating_sub(1));
            if again && running.begin.is_empty() {
                running.begin = vec![Begin::Reset, Begin::Play];
            }
        }
        self.note_place();
    }
}

impl Running {
    fn go_to(&mut self, number: usize) {
        (self.step, self.rejection, self.since, self.acted) = (number, None, None, false);
        (self.acted_at, self.tries, self.shows, self.is_shown) = (None, 0, false, false);
        // At the end the last sentence keeps its numbers.
        if let Some(step) = self.lesson.steps.get(number) {
            self.begin.clone_from(&step.begin);
            self.of_screen.begin();
        }
    }

    fn step(&self) -> Option<&LessonStep> {
        self.lesson.steps.get(self.step)
    }

    /// Says in words what a step that ends when `formula` holds still waits for.
    fn waits_for(&self, formula: &Formula) -> String {
        // A step about pausing or about a fault says itself why nothing moves.
        let is_about_pausing = |name: &String| {
            let quantity = self.lesson.of_screen(name).map(|quantity| &quantity.measure);
            matches!(quantity, Some(Measure::Screen(ScreenMeasure::Paused | ScreenMeasure::Fault)))
        };
        let stopped = self.stopped.filter(|_| !formula.names().iter().any(is_about_pausing));
        let by_author = self.step().map(|step| step.missing.clone()).unwrap_or_default();
        let missing = if by_author.is_empty() { self.missing(formula) } else { by_author };
        let missing = Some(missing).filter(|missing| !missing.is_empty());
        missing.into_iter().chain(stopped.map(str::to_owned)).collect::<Vec<_>>().join("; ")
    }

    /// The sentence about an answer that is not right.
    fn refusal(&self, text: &str) -> String {
        let mut what = "not what was measured";
        let why = match self.step().map(|step| &step.goal) {
            Some(Goal::Number { unit, right, wrong, within, .. }) => {
                let Some(typed) = number_in(text, unit) else {
                    return format!("\"{text}\" is not a number.");
                };
                let right = right.value(|name| self.value(name));
                what = match typed.total_cmp(&right) {
                    _ if !right.is_finite() => what,
                    Ordering::Less => "less than was measured",
                    Ordering::Equal | Ordering::Greater => "more than was measured",
                };
                let is_near = |wrong: f64| (typed - wrong).abs() <= within * wrong.abs();
                wrong
                    .iter()
                    .find(|wrong| number_in(&wrong.answer, unit).is_some_and(is_near))
                    .map(|wrong| &wrong.why)
            }
            Some(Goal::Choice { choices, .. }) => {
                choices.iter().find(|choice| choice.say == text).map(|choice| &choice.why)
            }
            Some(Goal::Done { .. }) | None => None,
        };
        why.filter(|why| !why.is_empty())
            .cloned()
            .unwrap_or_else(|| format!("\"{text}\" is {what}."))
    }

    /// The comparisons of `formula` that do not hold, in words.
    fn missing(&self, formula: &Formula) -> String {
        let pointed_at = self.step().and_then(|step| step.point_at.as_deref());
        let measures = Measures { quantities: &self.lesson.measure, pointed_at };
        missing(formula, measures, |name| self.value(name))
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.of_screen.value(name).or_else(|| self.of_runs.value(name))
    }

    fn holds(&self, formula: &Formula) -> bool {
        formula.holds(|name| self.value(name))
    }

    fn is_right(&self, text: &str) -> bool {
        match self.step().map(|step| &step.goal) {
            Some(Goal::Number { right, within, unit, .. }) => {
                let right = right.value(|name| self.value(name));
                let is_near = |number: f64| (number - right).abs() <= within * right.abs();
                right.is_finite() && number_in(text, unit).is_some_and(is_near)
            }
            Some(Goal::Choice { choices, .. }) => {
                choices.iter().any(|choice| choice.say == text && self.holds(&choice.right))
            }
            Some(Goal::Done { .. }) | None => false,
        }
    }
}

/// The number that a person typed, with its unit or without.
fn number_in(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    read_number(text.strip_suffix(unit).unwrap_or(text))
}

/// The value of a quantity that only the screen has.
fn seen(measure: &ScreenMeasure, stage: &Stage, screen: &Screen<'_>) -> f64 {
    let Screen { view, opened, ghosts, ledger } = screen;
    let truth = |holds: bool| f64::from(u8::from(holds));
    match measure {
        ScreenMeasure::Selected(body) => {
            truth(stage.selection().is_some_and(|thing| stage.sim().named(body) == Some(thing)))
        }
        ScreenMeasure::GhostError(method) => ghosts.largest(*method).unwrap_or(f64::NAN),
        ScreenMeasure::PushWork => {
            ledger.kept().map_or(f64::NAN, |ledger| ledger.since_opening().energy.pushes)
        }
        ScreenMeasure::ClickForce => view.click_force,
        ScreenMeasure::Shows(name) => {
            truth(panel_of(name).is_some_and(|panel| opened.contains(&panel)))
        }
        ScreenMeasure::Paused => truth(stage.playback().paused()),
        ScreenMeasure::Follows => truth(view.locked.is_some()),
        ScreenMeasure::Fault => {
            truth(stage.recorder().fault().is_some() || !stage.quarantines().all().is_empty())
        }
    }
}
