//! Lessons: what a person does and watches, step by step, and questions whose answers are measured.

mod formula;
mod raw;

use std::path::Path;

use motion::Method;
use serde::Deserialize;

pub use self::formula::{Comparison, Formula, Sentence};
pub use self::raw::{beside, is_same_scene};
use crate::Scene;
use crate::action::{Action, ChangeAction, method};
use crate::shipped::{self, read_text};
use crate::substepping::Substepping;
use crate::text::faults::SceneError;
use crate::text::nearest::{did_you_mean, nearest};
use crate::text::syntax::enum_of_enums;

/// Version of lessons that this program reads.
pub const LESSON_VERSION: u32 = 1;

/// A lesson.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// Name of a lesson in the program, or path of its file.
    pub name: String,
    /// Its title.
    pub title: String,
    /// What it is about, in a sentence.
    pub about: String,
    /// The page of the tutorial that it belongs to.
    pub page: String,
    /// Its duration, minutes.
    pub minutes: u32,
    /// Name or path of its scene.
    pub scene: String,
    /// What is measured of the scene on the screen.
    pub measure: Vec<Quantity>,
    /// Runs that are made for it, beside the one on the screen.
    pub runs: Vec<LessonRun>,
    /// Its steps, at least one.
    pub steps: Vec<LessonStep>,
}

/// A measured quantity and its name in formulas. Formulas can also use `name_before`, its value when the step or run
/// began, or just before the person last changed the run, and `name_most` and `name_least`, its extremes since then.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// What is measured.
    pub measure: Measure,
}

/// A measure of a run, alone or on the screen. In a file it is written as its name in snake case: `speed("ball")`.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// Of any run.
    Run(RunMeasure),
    /// Of the run on the screen only.
    Screen(ScreenMeasure),
}

enum_of_enums!(Measure: Run(RunMeasure), Screen(ScreenMeasure));

/// A measure of any run.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunMeasure {
    /// Simulated time of the scene, s.
    Time,
    /// A coordinate of a body, m.
    Position(String, Axis),
    /// A component of the velocity of a body, m/s.
    Velocity(String, Axis),
    /// Speed of a body, m/s.
    Speed(String),
    /// Mass of a body, kg; infinite if it cannot be moved.
    Mass(String),
    /// Distance between two bodies, m.
    Distance(String, String),
    /// Sum of kinetic and potential energy, J.
    Energy,
    /// Kinetic energy, J.
    KineticEnergy,
    /// A component of the momentum of all bodies, kg m/s.
    Momentum(Axis),
    /// Acceleration of gravity, m/s²; 0 while it is off.
    Gravity,
    /// Damping rate, 1/s; 0 while it is off.
    Damping,
    /// Ticks per second.
    StepHz,
    /// Substeps per tick.
    Substeps,
    /// 1 if this is the method of the scene, else 0.
    Method(#[serde(with = "method")] Method),
    /// Evaluations of the acceleration of a body so far, in all bodies.
    Evaluations,
    /// Bodies that were quarantined because their state was no longer finite.
    Quarantined,
    /// Largest distance of a body from the same run by a fine reference, m, up to now. Measured in runs only.
    Error,
}

/// A measure of what is on the screen.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScreenMeasure {
    /// Largest distance of a body from the reference of the ghosts, by that method, m, after any tick since the ghosts began.
    /// While ghosts are shown.
    GhostError(#[serde(with = "method")] Method),
    /// Work of pushes and drags, J, since the ledger began. While a ledger is kept.
    PushWork,
    /// 1 if the body is selected, else 0.
    Selected(String),
    /// The force of a click, N.
    ClickForce,
    /// 1 while the panel with that name in scripts is open.
    Shows(String),
    /// 1 while the run is paused.
    Paused,
    /// 1 while the camera follows a body.
    Follows,
    /// 1 after something went wrong: a body was quarantined, or energy came from nowhere.
    Fault,
}

/// A coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the coordinates")]
pub enum Axis {
    X,
    Y,
    Z,
}

impl Measure {
    /// The bodies that it names.
    pub fn bodies(&self) -> impl Iterator<Item = &str> {
        let [one, other] = match self {
            Self::Run(measure) => measure.bodies(),
            Self::Screen(ScreenMeasure::Selected(body)) => [Some(body), None],
            Self::Screen(_) => [None, None],
        };
        one.into_iter().chain(other).map(String::as_str)
    }
}

impl RunMeasure {
    fn bodies(&self) -> [Option<&String>; 2] {
        match self {
            Self::Position(body, _)
            | Self::Velocity(body, _)
            | Self::Speed(body)
            | Self::Mass(body) => [Some(body), None],
            Self::Distance(one, other) => [Some(one), Some(other)],
            Self::Time
            | Self::Energy
            | Self::KineticEnergy
            | Self::Momentum(_)
            | Self::Gravity
            | Self::Damping
            | Self::StepHz
            | Self::Substeps
            | Self::Method(_)
            | Self::Evaluations
            | Self::Quarantined
            | Self::Error => [None, None],
        }
    }
}

/// A run that is made for a lesson.
#[derive(Clone, Debug)]
pub struct LessonRun {
    /// Its scene; that of the lesson if `None`.
    pub scene: Option<String>,
    /// Its method, if not the scene's.
    pub method: Option<Method>,
    /// Its substeps, if not those of the scene.
    pub substeps: Option<Substepping>,

    /// Its ticks per second, if not the scene's.
    pub step_hz: Option<f64>,
    /// Its length, s.
    pub seconds: f64,
    /// Changes before its first tick.
    pub start: Vec<ChangeAction>,
    /// What is measured.
    pub measure: Vec<Quantity>,
}

/// A step of a lesson.
#[derive(Clone, Debug)]
pub struct LessonStep {
    /// What to do, or the question.
    pub task: String,
    /// What to watch.
    pub watch: String,
    /// The control or the body that the step points at.
    pub point_at: Option<String>,
    /// What is done before the step.
    pub begin: Vec<Begin>,
    /// Hint for a person who makes no progress; may be empty.
    pub hint: String,
    /// What is said while the goal is not reached; if it is empty, what a formula of one quantity waits for.
    pub missing: String,
    /// What ends the step.
    pub goal: Goal,
    /// Text after the step, with measured numbers.
    pub then: Sentence,
    /// Condition that these numbers satisfy.
    pub holds: Option<Formula>,
    /// Its line in the file, from 1.
    pub line: Option<usize>,
}

/// A start action of a step of a lesson.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Begin {
    /// Resets the scene.
    Reset,
    /// Pauses the run.
    Pause,
    /// Continues the run.
    Play,
    /// Puts the camera where the scene has it, or frames all bodies.
    Frame,
}

/// The goal that ends a step.
#[derive(Clone, Debug)]
pub enum Goal {
    /// The person does something.
    Done {
        /// True when it is done.
        when: Formula,
        /// Actions that reach the goal: `sandbox lessons` plays them to check the lesson and to print its pages.
        solution: Vec<Action>,
        /// Other ways to reach it, each checked.
        also: Vec<Vec<Action>>,
        /// Mistakes that must not reach it, each checked.
        wrong: Vec<Vec<Action>>,
    },
    /// The person answers with a number.
    Number {
        /// The formula of the right number.
        right: Formula,
        /// Largest relative error of an accepted answer.
        within: f64,
        /// Its unit.
        unit: String,
        /// A typed answer that must be accepted.
        solution: String,
        /// Typed answers that must be refused.
        wrong: Vec<WrongAnswer>,
    },
    /// The person chooses one of several answers.
    Choice {
        /// The choices.
        choices: Vec<Choice>,
        /// The answer.
        solution: String,
    },
}

/// A choice of a question.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The answer.
    pub say: String,
    /// The condition for which it is right.
    pub right: Formula,
    /// What is said about it if it is wrong; may be empty.
    pub why: String,
}

/// A wrong answer that a person is expected to type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrongAnswer {
    /// The answer.
    pub answer: String,
    /// What is said about it; may be empty.
    pub why: String,
}

impl Goal {
    /// The actions of its solution and of its other and wrong ways, with their places in the step: `wrong[0][1]`.
    pub fn actions(&self) -> impl Iterator<Item = (String, &Action)> {
        let (solution, also, wrong) = match self {
            Self::Done { solution, also, wrong, .. } => {
                (solution.as_slice(), also.as_slice(), wrong.as_slice())
            }
            Self::Number { .. } | Self::Choice { .. } => (&[][..], &[][..], &[][..]),
        };
        let others = also.iter().enumerate().map(|(n, way)| (format!("also[{n}]"), way.as_slice()));
        let wrong =
            wrong.iter().enumerate().map(|(n, way)| (format!("wrong[{n}]"), way.as_slice()));
        let ways = std::iter::once(("solution".to_owned(), solution)).chain(others).chain(wrong);
        ways.flat_map(|(key, way)| {
            way.iter().enumerate().map(move |(n, action)| (format!("{key}[{n}]"), action))
        })
    }
}

/// Suffixes of the name of a quantity in formulas.
const SUFFIXES: [&str; 3] = ["_before", "_most", "_least"];

/// The quantity that `name` means, and the suffix of the name: empty, `_before`, `_most` or `_least`.
#[must_use]
pub fn quantity_of<'a, 'b>(
    quantities: &'a [Quantity],
    name: &'b str,
) -> Option<(&'a Quantity, &'b str)> {
    let find = |name: &str| quantities.iter().find(|quantity| quantity.name == name);
    let stem = || SUFFIXES.iter().find_map(|suffix| name.strip_suffix(suffix));
    let quantity = find(name).or_else(|| find(stem()?))?;
    Some((quantity, &name[quantity.name.len()..]))
}

impl Lesson {
    /// The quantity of the screen with that name, which may end in `_before`, `_most` or `_least`.
    #[must_use]
    pub fn of_screen(&self, name: &str) -> Option<&Quantity> {
        Some(quantity_of(&self.measure, name)?.0)
    }

    /// Reads a lesson and its scene, whose bodies it names.
    ///
    /// # Errors
    /// Every fault of the text; those of the scene if that cannot be read.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        raw::parse(name, text, &shipped::load)
    }

    /// [`Self::parse`] with scenes from `load`, by name or by path.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_with(
        name: &str,
        text: &str,
        load: &dyn Fn(&str) -> Result<Scene, SceneError>,
    ) -> Result<Self, SceneError> {
        raw::parse(name, text, load)
    }

    /// Number of wrong ways of the lesson.
    #[must_use]
    pub fn wrong_ways(&self) -> usize {
        let count = |step: &LessonStep| match &step.goal {
            Goal::Done { wrong, .. } => wrong.len(),
            Goal::Number { wrong, .. } => wrong.len(),
            Goal::Choice { choices, .. } => choices.len().saturating_sub(1),
        };
        self.steps.iter().map(count).sum()
    }
}

/// Names and texts of the lessons in the program, in their order.
#[must_use]
pub const fn shipped() -> &'static [(&'static str, &'static str)] {
    macro_rules! lessons {
        ($($name:literal),+ $(,)?) => {
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/lessons/", $name, ".ron")))),+]
        };
    }
    lessons![
        "force",
        "mass",
        "gravity",
        "feather",
        "eulers",
        "verlet",
        "runge_kutta",
        "frame_time",
        "springs",
        "momentum",
        "energy",
        "resonance",
        "further_work",
    ]
}

/// Loads a lesson by its name, or a file by its path.
///
/// # Errors
/// As [`Lesson::parse`]; if there is no such lesson or file.
pub fn load(name_or_path: &str) -> Result<Lesson, SceneError> {
    if let Some((name, text)) = embedded(name_or_path) {
        return Lesson::parse(name, text);
    }
    let path = Path::new(name_or_path);
    if path.extension().is_none() && !path.exists() {
        let names: Vec<_> = shipped().iter().map(|(name, _)| *name).collect();
        let guess = did_you_mean(nearest(name_or_path, names.iter().copied()));
        let cure = format!("{guess}the lessons are {}; a file needs its path", names.join(", "));
        return Err(SceneError::of_file(name_or_path, "there is no such lesson", cure));
    }
    Lesson::parse(name_or_path, &read_text(path)?)
}

/// Whether `text` is that of a lesson and not of a scene: it has steps and a title, whatever else is wrong with it.
#[must_use]
pub fn is_text(text: &str) -> bool {
    raw::is_lesson(text)
}

/// Whether the file at `path` is a [lesson](is_text).
#[must_use]
pub fn is_file(path: &Path) -> bool {
    read_text(path).is_ok_and(|text| is_text(&text))
}

/// Whether that is the name of a lesson in the program, and not the path of a file.
#[must_use]
pub fn is_shipped(name_or_path: &str) -> bool {
    embedded(name_or_path).is_some()
}

fn embedded(name: &str) -> Option<&'static (&'static str, &'static str)> {
    shipped().iter().find(|(shipped, _)| *shipped == name)
}
