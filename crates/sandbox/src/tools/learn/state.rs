//! How far a lesson has come.

use std::collections::BTreeSet;
use std::sync::Arc;

use lab::lesson::{Quantities, measured};
use report::numbers::digits;
use scene::Source;
use scene::lesson::{Formula, Goal, Lesson, LessonStep, Measure, beside, is_same_scene};

use crate::panels::Panel;
use crate::stage::Stage;
use crate::tools::learn::panel_of;
use crate::view::View;

/// The lesson that is open, and the lessons that were done.
#[derive(Default)]
pub(crate) struct Learn {
    running: Option<Running>,
    /// Names of the lessons that were done to their end.
    pub done: BTreeSet<String>,
    /// Whether the card of the first start is shown, and which of its two things were done.
    pub welcome: bool,
    pub tried: [bool; 2],
    /// Why no lesson could be opened.
    pub fault: Option<String>,
    /// What was typed as an answer.
    pub typed: String,
    /// Whether its panel is open.
    pub shown: bool,
}

/// A lesson in progress.
struct Running {
    lesson: Arc<Lesson>,
    step: usize,
    /// What its runs measured.
    of_runs: Quantities,
    /// What is measured of the screen, since the step began.
    of_screen: Quantities,
    /// What was said at the end of the step before.
    said: Option<String>,
    /// Whether what that step claims was true.
    held: bool,
    /// Whether a step was skipped.
    skipped: bool,
    /// The last answer, if it was not right.
    refused: Option<String>,
}

/// Progress in the open lesson.
#[derive(Clone, Debug, PartialEq)]
pub struct LessonState {
    /// Its name.
    pub name: String,
    /// The number of its present step, from 0; that of its steps at its end.
    pub step: usize,
    /// What was said at the end of the step before.
    pub said: Option<String>,
    /// Whether what that step claims was true; what is not true is not said.
    pub holds: bool,
}

impl Learn {
    /// Opens `lesson`, whose runs measured `of_runs`. Its scene has to be opened, too.
    pub fn open(&mut self, lesson: Arc<Lesson>, of_runs: Quantities) {
        let of_screen = Quantities::default();
        self.running = Some(Running {
            lesson,
            step: 0,
            of_runs,
            of_screen,
            said: None,
            held: true,
            skipped: false,
            refused: None,
        });
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

    /// What was said at the end of the last step, and which answer was refused.
    pub fn said(&self) -> [Option<&str>; 2] {
        let running = self.running.as_ref();
        [
            running.and_then(|running| running.said.as_deref()),
            running.and_then(|running| running.refused.as_deref()),
        ]
    }

    /// What was said last and what to do, in a caption.
    pub fn caption(&self) -> Option<String> {
        let (.., step) = self.lesson()?;
        let [said, _] = self.said();
        let task = step.map(|step| step.task.as_str());
        Some(said.into_iter().chain(task).collect::<Vec<_>>().join(" "))
    }

    /// Progress in it.
    pub fn state(&self) -> Option<LessonState> {
        let running = self.running.as_ref()?;
        let (name, said) = (running.lesson.name.clone(), running.said.clone());
        Some(LessonState { name, step: running.step, said, holds: running.held })
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
        self.home().is_some_and(|home| match &stage.sim.scene.source {
            Source::Shipped(name) => *name == home,
            Source::File(path) => is_same_scene(&path.to_string_lossy(), &home),
            Source::Text => false,
        })
    }

    /// Another world is measured from now on.
    pub fn forget_world(&mut self) {
        if let Some(running) = &mut self.running {
            running.of_screen.forget();
        }
    }

    /// Measures the present state, with these `opened` panels, and goes on if it is what the step is about.
    pub fn look(&mut self, stage: &mut Stage, view: &View, opened: &[Panel]) {
        if !self.shown || !self.is_at_home(stage) {
            return;
        }
        let Some(running) = &mut self.running else { return };
        for quantity in &running.lesson.measure {
            let value = match measured(&mut stage.sim, &quantity.measure) {
                Some(value) => value,
                None => seen(&quantity.measure, stage, view, opened),
            };
            running.of_screen.note(&quantity.name, value);
        }
        let step = running.lesson.steps.get(running.step);
        if let Some(LessonStep { goal: Goal::Done { when, .. }, .. }) = step
            && running.holds(when)
        {
            self.go_on();
        }
    }

    /// Whether that is a right answer to the present question.
    pub fn accepts(&self, text: &str) -> bool {
        self.running.as_ref().is_some_and(|running| running.is_right(text))
    }

    /// Judges an answer to the present question, and goes on if it is right. Returns whether it is.
    pub fn answer(&mut self, text: &str) -> bool {
        let right = self.accepts(text);
        if right {
            self.go_on();
        } else if let Some(running) = &mut self.running {
            running.refused = Some(text.trim().to_owned());
        }
        right
    }

    /// Goes on to the next step; what was measured is said.
    pub fn go_on(&mut self) {
        let Some(running) = &mut self.running else { return };
        let Some(step) = running.lesson.steps.get(running.step) else { return };
        let said = step.then.filled(|name| running.value(name), digits);
        running.held = step.holds.as_ref().is_none_or(|holds| running.holds(holds));
        // After a step that was skipped it may not be true.
        running.said = Some(said).filter(|said| running.held && !said.is_empty());
        running.step += 1;
        running.refused = None;
        if running.step == running.lesson.steps.len() && !running.skipped {
            self.done.insert(running.lesson.name.clone());
        }
        self.typed.clear();
        // At its end the sentence keeps its numbers.
        if running.step < running.lesson.steps.len() {
            running.of_screen.begin();
        }
    }

    /// Goes on without doing the step.
    pub fn skip(&mut self) {
        if let Some(running) = &mut self.running {
            running.skipped = true;
        }
        self.go_on();
    }

    /// Goes back to the step before.
    pub fn go_back(&mut self) {
        if let Some(running) = &mut self.running {
            running.step = running.step.saturating_sub(1);
            (running.said, running.held, running.refused) = (None, true, None);
            running.of_screen.begin();
        }
    }
}

impl Running {
    fn value(&self, name: &str) -> Option<f64> {
        self.of_screen.value(name).or_else(|| self.of_runs.value(name))
    }

    fn holds(&self, formula: &Formula) -> bool {
        formula.holds(|name| self.value(name))
    }

    fn is_right(&self, text: &str) -> bool {
        match self.lesson.steps.get(self.step).map(|step| &step.goal) {
            Some(Goal::Number { right, within, unit, .. }) => {
                let text = text.trim();
                let number = text.strip_suffix(unit.as_str()).unwrap_or(text).trim().replace(',', ".");
                let right = right.value(|name| self.value(name));
                let is_near = |number: f64| (number - right).abs() <= within * right.abs();
                right.is_finite() && number.parse::<f64>().is_ok_and(is_near)
            }
            Some(Goal::Choice { choices, .. }) => {
                choices.iter().any(|(say, right)| say == text && self.holds(right))
            }
            _ => false,
        }
    }
}

/// What only the screen has.
fn seen(measure: &Measure, stage: &Stage, view: &View, opened: &[Panel]) -> f64 {
    let truth = |holds: bool| f64::from(u8::from(holds));
    match measure {
        Measure::Selected(body) => {
            truth(stage.here.selection.is_some_and(|thing| stage.body(body) == Some(thing)))
        }
        Measure::ClickForce => view.click_force,
        Measure::Shows(name) => truth(panel_of(name).is_some_and(|panel| opened.contains(&panel))),
        Measure::Paused => truth(stage.paused),
        Measure::Follows => truth(view.locked.is_some()),
        Measure::Fault => truth(stage.fault().is_some() || !stage.run.quarantined.is_empty()),
        _ => f64::NAN,
    }
}
