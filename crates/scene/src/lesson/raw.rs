//! A lesson as a teacher writes it, and what is wrong with it.

use std::collections::{HashMap, HashSet};
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};

use super::{
    Begin, Choice, Formula, Goal, LESSON_VERSION, Lesson, LessonRun, LessonStep, Measure, Quantity,
    RunMeasure, SUFFIXES, Sentence, WrongAnswer,
};
use crate::action::{Action, ChangeAction, InputAction};
use crate::check::{Rule, STEP_RATE, Scope, positive, rule};
use crate::resolve::springs::unsolvable;
use crate::scene::Scene;
use crate::script::undeclared;
use crate::shipped;
use crate::substepping::Substepping;
use crate::text::faults::{Faults, SceneError};
use crate::text::locate::lines;
use crate::text::nearest::suggest;
use crate::text::syntax::{self, Name, Word, keys_of};

/// Longest run of a lesson, s: a person waits for it.
const LONGEST_RUN: f64 = 120.0;

const DURATION: Rule = rule(
    |v| positive(v) && v <= LONGEST_RUN,
    "a length of a run",
    "give seconds above 0, at most 120",
);

/// Longest time for holding a key or waiting, s.
const LONGEST_HOLD: f64 = 20.0;

/// Largest relative error of an answer, if the question does not say.
const WITHIN: f64 = 0.05;

#[derive(Debug, Deserialize)]
#[serde(rename = "Lesson")]
struct RawLesson {
    version: Option<u32>,
    title: Option<String>,
    about: Option<String>,
    page: Option<String>,
    minutes: Option<u32>,
    scene: Option<String>,
    #[serde(default)]
    measure: Named<Measure>,
    #[serde(default)]
    runs: Vec<RawRun>,
    #[serde(default)]
    steps: Vec<RawStep>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Run")]
struct RawRun {
    scene: Option<String>,
    method: Option<Word>,
    substeps: Option<Substepping>,
    step_hz: Option<f64>,
    seconds: Option<f64>,
    #[serde(default)]
    start: Vec<Action>,
    #[serde(default)]
    measure: Named<Measure>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Step")]
struct RawStep {
    task: Option<String>,
    watch: Option<String>,
    point_at: Option<String>,
    #[serde(default)]
    begin: Vec<Begin>,
    hint: Option<String>,
    missing: Option<String>,
    done: Option<String>,
    solution: Option<Vec<Action>>,
    #[serde(default)]
    also: Vec<Vec<Action>>,
    #[serde(default)]
    wrong: Vec<Vec<Action>>,
    number: Option<String>,
    unit: Option<String>,
    within: Option<f64>,
    choices: Option<Vec<RawChoice>>,
    answer: Option<String>,
    #[serde(default)]
    wrong_answers: Vec<RawWrong>,
    then: Option<String>,
    holds: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Choice")]
struct RawChoice {
    say: Option<String>,
    right: Option<String>,
    why: Option<String>,
}

/// A wrong answer, alone or with what is said about it.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "an answer in quotes, or (answer: \"3\", why: \"...\")")]
enum RawWrong {
    Alone(String),
    Explained { answer: String, why: String },
}

impl From<RawWrong> for WrongAnswer {
    fn from(raw: RawWrong) -> Self {
        let (answer, why) = match raw {
            RawWrong::Alone(answer) => (answer, String::new()),
            RawWrong::Explained { answer, why } => (answer, why),
        };
        Self { answer, why }
    }
}

/// A group with names of the writer's own: `(speed_of_ball: speed("ball"))`.
#[derive(Debug)]
struct Named<T>(Vec<(String, T)>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NamedVisitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for NamedVisitor<T> {
            type Value = Named<T>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("names and values")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Named<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(Name(name)) = map.next_key()? {
                    entries.push((name, map.next_value()?));
                }
                Ok(Named(entries))
            }
        }

        deserializer.deserialize_struct("", &[], NamedVisitor(PhantomData))
    }
}

pub(super) fn parse(name: &str, text: &str, load: &Load<'_>) -> Result<Lesson, SceneError> {
    let (raw, unknown) = syntax::read::<RawLesson>(text, "")
        .map_err(|error| syntax::error(name, text, "", &error))?;
    let mut faults = Faults::default();
    unknown.iter().for_each(|path| faults.unknown_key(path, keys_at(path)));
    let mut lesson = Reader { faults: &mut faults, name, load, scenes: HashMap::new() }.lesson(raw);
    faults.check(name, text, "")?;
    let paths: Vec<_> = (0..lesson.steps.len()).map(|i| format!("steps[{i}]")).collect();
    let lines = lines(text, &paths.iter().map(String::as_str).collect::<Vec<_>>());
    lesson.steps.iter_mut().zip(lines).for_each(|(step, line)| step.line = line);
    Ok(lesson)
}

/// Keys that distinguish a lesson from a scene.
#[derive(Debug, Deserialize)]
struct Probe {
    title: Option<IgnoredAny>,
    steps: Option<IgnoredAny>,
}

pub(super) fn is_lesson(text: &str) -> bool {
    let probe = syntax::read::<Probe>(text, "");
    probe.is_ok_and(|(Probe { title, steps }, _)| title.is_some() && steps.is_some())
}

/// The keys of the group that has the key at `path`.
fn keys_at(path: &str) -> &'static [&'static str] {
    let group = path.rsplit_once('.').map_or("", |(group, _)| group);
    let group =
        group.rsplit('.').next().and_then(|group| group.split('[').next()).unwrap_or_default();
    match group {
        "runs" => keys_of::<RawRun>(),
        "steps" => keys_of::<RawStep>(),
        "choices" => keys_of::<RawChoice>(),
        _ => keys_of::<RawLesson>(),
    }
}

/// Loads a scene by its name or its path.
type Load<'a> = dyn Fn(&str) -> Result<Scene, SceneError> + 'a;

/// Finds the faults of a lesson.
struct Reader<'a> {
    faults: &'a mut Faults,
    name: &'a str,
    load: &'a Load<'a>,
    /// The scenes that were read, by their names: many runs may share one.
    scenes: HashMap<String, Arc<Scene>>,
}

impl Reader<'_> {
    fn lesson(&mut self, raw: RawLesson) -> Lesson {
        let cure = format!("add `version: {LESSON_VERSION}`");
        match raw.version {
            None => self.faults.missing(String::new(), "version", &cure),
            Some(LESSON_VERSION) => {}
            Some(other) => self.faults.add(
                "version",
                format!("version {other} of lessons is not one that this program reads"),
                format!("write it as version {LESSON_VERSION}"),
            ),
        }
        let title = self.text("title", raw.title);
        let about = self.text("about", raw.about);
        let page = self.text("page", raw.page);
        let file = self.text("scene", raw.scene);
        let scene = self.scene("scene", &file);
        let measure = self.quantities("measure", raw.measure, scene.as_deref(), false);
        let runs: Vec<_> =
            raw.runs.into_iter().enumerate().map(|(i, run)| self.run(i, run, &file)).collect();
        let mut names = HashSet::new();
        for (i, quantity) in
            measure.iter().chain(runs.iter().flat_map(|run| &run.measure)).enumerate()
        {
            let name = quantity.name.as_str();
            let is_word = name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
            let ends = SUFFIXES.iter().any(|end| name.ends_with(end));
            if !is_word || ends || ["abs", "sqrt", "min", "max"].contains(&name) {
                let what = format!("`{name}` means something else in formulas");
                self.faults.add("measure", what, "give it another name, of letters, digits and _");
            }
            if !names.insert(quantity.name.clone()) {
                let path = if i < measure.len() { "measure" } else { "runs" };
                self.faults.add(
                    path,
                    format!("`{}` is measured twice", quantity.name),
                    "give one another name",
                );
            }
        }
        if raw.steps.is_empty() {
            self.faults.missing(String::new(), "steps", "add at least one step");
        }
        let steps = raw.steps.into_iter().enumerate();
        let steps: Vec<_> =
            steps.map(|(i, step)| self.step(i, step, &names, scene.as_deref())).collect();
        let lesson = Lesson {
            name: self.name.to_owned(),
            title,
            about,
            page,
            minutes: raw.minutes.unwrap_or(5),
            scene: file,
            measure,
            runs,
            steps,
        };
        if lesson.wrong_ways() < 2 && !lesson.steps.is_empty() {
            let cure =
                "add `wrong` or `wrong_answers`, which the check plays and expects to be refused";
            self.faults.add("steps", "the lesson has fewer than two wrong ways", cure);
        }
        lesson
    }

    fn text(&mut self, key: &str, value: Option<String>) -> String {
        let value = value.unwrap_or_default();
        if value.trim().is_empty() {
            self.faults.missing(String::new(), key, &format!("add `{key}: \"...\"`"));
        }
        value
    }

    /// The scene of that name or path; paths are relative to the folder of the lesson.
    fn scene(&mut self, path: &str, file: &str) -> Option<Arc<Scene>> {
        if file.is_empty() {
            return None;
        }
        if let Some(known) = self.scenes.get(file) {
            return Some(Arc::clone(known));
        }
        let scene = Arc::new(self.read_scene(path, file)?);
        self.scenes.insert(file.to_owned(), Arc::clone(&scene));
        Some(scene)
    }

    fn read_scene(&mut self, path: &str, file: &str) -> Option<Scene> {
        match (self.load)(&beside(self.name, file)) {
            Ok(scene) => Some(scene),
            Err(error) => {
                // Its first fault, with its own cure.
                let (what, cure) = error
                    .faults
                    .first()
                    .map(|fault| (fault.what.clone(), fault.cure.clone()))
                    .unwrap_or_default();
                self.faults.add(path, format!("the scene {file} cannot be read: {what}"), cure);
                None
            }
        }
    }

    fn quantities(
        &mut self,
        path: &str,
        raw: Named<Measure>,
        scene: Option<&Scene>,
        of_run: bool,
    ) -> Vec<Quantity> {
        for (name, measure) in &raw.0 {
            let path = format!("{path}.{name}");
            for body in measure.bodies() {
                self.body(&path, body, scene);
            }
            if of_run && matches!(measure, Measure::Screen(_)) {
                self.faults.add(
                    path,
                    "a run has no screen",
                    "measure it in the `measure` of the lesson",
                );
            } else if !of_run && *measure == Measure::Run(RunMeasure::Error) {
                let cure = "measure it in the `measure` of a run";
                self.faults.add(path, "only runs are compared with a reference", cure);
            }
        }
        raw.0.into_iter().map(|(name, measure)| Quantity { name, measure }).collect()
    }

    fn body(&mut self, path: &str, body: &str, scene: Option<&Scene>) {
        if let Some(scene) = scene.filter(|scene| scene.names.find(body).is_none()) {
            let (what, cure) = scene.names.stranger(body);
            self.faults.add(path, what, cure);
        }
    }

    fn run(&mut self, i: usize, raw: RawRun, lesson: &str) -> LessonRun {
        let scope = Scope::item("runs", i);
        let file = raw.scene.as_deref().unwrap_or(lesson);
        let scene = self.scene(&scope.key("scene"), file);
        self.faults.require(raw.seconds.is_some(), scope, "seconds", "add `seconds: 10`");
        for (n, action) in raw.start.iter().enumerate() {
            let path = format!("runs[{i}].start[{n}]");
            if action.change().is_none() {
                let cure = "give a change, such as `push` or `switch_effect`";
                self.faults.add(&*path, "a run takes only changes", cure);
            }
            self.action(&path, action, scene.as_deref());
        }
        let start: Vec<_> = raw.start.iter().filter_map(Action::change).cloned().collect();
        let method = self.faults.method(scope, raw.method.as_ref());
        let substeps = self.faults.substeps(scope, raw.substeps);
        let step_hz = self.faults.optional(scope, "step_hz", raw.step_hz, STEP_RATE);
        let seconds = self.faults.number(scope, "seconds", raw.seconds, 1.0, DURATION);
        if let Some(scene) = &scene {
            let set = start.iter().filter_map(ChangeAction::method);
            let attracts = scene.mutual_gravity.is_some();
            if let Some(why) =
                method.into_iter().chain(set).find_map(|method| unsolvable(method, attracts))
            {
                self.faults.refuse(scope, "method", why, "take another method");
            }
        }
        LessonRun {
            scene: raw.scene,
            method,
            substeps,
            step_hz,
            seconds,
            start,
            measure: self.quantities(&scope.key("measure"), raw.measure, scene.as_deref(), true),
        }
    }

    fn action(&mut self, path: &str, action: &Action, scene: Option<&Scene>) {
        if let Some((what, cure)) = action.fault().or_else(|| undeclared(action, scene?)) {
            self.faults.add(path, what, cure);
        }
        if matches!(action, Action::Input(InputAction::Hold(_, seconds)) if *seconds > LONGEST_HOLD)
        {
            self.faults.add(path, "the key is held too long", "hold it for at most 20 s");
        }
        if matches!(action, Action::Input(InputAction::Wait(seconds)) if *seconds > LONGEST_HOLD) {
            self.faults.add(path, "this waits too long", "wait for at most 20 s");
        }
        if let Some(body) = action.body() {
            self.body(path, body, scene);
        }
    }

    fn step(
        &mut self,
        i: usize,
        raw: RawStep,
        names: &HashSet<String>,
        scene: Option<&Scene>,
    ) -> LessonStep {
        let scope = Scope::item("steps", i);
        self.faults.require(raw.task.is_some(), scope, "task", "say what to do");
        let then = self.sentence(scope, raw.then.as_deref(), names);
        let holds = raw.holds.as_deref().map(|text| self.formula(scope.key("holds"), text, names));
        if then.formulas().next().is_some() && holds.is_none() {
            let cure = "say what is true of its numbers, such as `holds: \"ratio > 2\"`";
            self.faults.missing(scope.path(), "holds", cure);
        }
        let goals = [raw.done.is_some(), raw.number.is_some(), raw.choices.is_some()];
        if goals.into_iter().filter(|given| *given).count() != 1 {
            let cure = "give one of `done`, `number` and `choices`";
            self.faults.add(scope.path(), "a step ends in one way", cure);
        }
        let is_done = raw.done.is_some();
        let of_others = [
            ("solution", !is_done && raw.solution.is_some()),
            ("also", !is_done && !raw.also.is_empty()),
            ("wrong", !is_done && !raw.wrong.is_empty()),
            ("missing", !is_done && raw.missing.is_some()),
            ("answer", is_done && raw.answer.is_some()),
            ("wrong_answers", raw.number.is_none() && !raw.wrong_answers.is_empty()),
            ("unit", raw.number.is_none() && raw.unit.is_some()),
            ("within", raw.number.is_none() && raw.within.is_some()),
        ];
        for (key, _) in of_others.into_iter().filter(|(_, given)| *given) {
            self.faults.refuse(scope, key, "this key belongs to another kind of step", "remove it");
        }
        let goal = if let Some(when) = &raw.done {
            self.faults.require(
                raw.solution.is_some(),
                scope,
                "solution",
                "list the actions that do it",
            );
            let when = self.formula(scope.key("done"), when, names);
            let (solution, also) = (raw.solution.unwrap_or_default(), raw.also);
            let goal = Goal::Done { when, solution, also, wrong: raw.wrong };
            for (path, action) in goal.actions() {
                self.action(&scope.key(&path), action, scene);
            }
            goal
        } else {
            self.faults.require(
                raw.answer.is_some(),
                scope,
                "answer",
                "add the answer that is right",
            );
            let solution = raw.answer.unwrap_or_default();
            match (raw.choices, raw.number) {
                (Some(choices), _) => {
                    let choices: Vec<_> = choices
                        .into_iter()
                        .enumerate()
                        .map(|(n, choice)| self.choice(i, n, choice, names))
                        .collect();
                    if !choices.iter().any(|choice| choice.say == solution) {
                        self.faults.refuse(
                            scope,
                            "answer",
                            "the answer is not among the choices",
                            "repeat one of them",
                        );
                    }
                    Goal::Choice { choices, solution }
                }
                (None, right) => Goal::Number {
                    right: self.formula(
                        scope.key("number"),
                        right.as_deref().unwrap_or("0"),
                        names,
                    ),
                    within: self.faults.number(
                        scope,
                        "within",
                        raw.within,
                        WITHIN,
                        rule(
                            |v| v > 0.0 && v < 1.0,
                            "a part of the right answer",
                            "give a number between 0 and 1",
                        ),
                    ),
                    unit: raw.unit.unwrap_or_default(),
                    solution,
                    wrong: raw.wrong_answers.into_iter().map(WrongAnswer::from).collect(),
                },
            }
        };
        LessonStep {
            task: raw.task.unwrap_or_default(),
            watch: raw.watch.unwrap_or_default(),
            point_at: raw.point_at,
            begin: raw.begin,
            hint: raw.hint.unwrap_or_default(),
            missing: raw.missing.unwrap_or_default(),
            goal,
            then,
            holds,
            line: None,
        }
    }

    fn choice(&mut self, i: usize, n: usize, raw: RawChoice, names: &HashSet<String>) -> Choice {
        let path = format!("steps[{i}].choices[{n}]");
        for (key, given) in [("say", raw.say.is_some()), ("right", raw.right.is_some())] {
            if !given {
                self.faults.missing(path.clone(), key, &format!("add `{key}: \"...\"`"));
            }
        }
        let right =
            self.formula(format!("{path}.right"), raw.right.as_deref().unwrap_or("0"), names);
        Choice { say: raw.say.unwrap_or_default(), right, why: raw.why.unwrap_or_default() }
    }

    fn sentence(&mut self, scope: Scope, text: Option<&str>, names: &HashSet<String>) -> Sentence {
        match Sentence::parse(text.unwrap_or_default()) {
            Ok(sentence) => {
                sentence
                    .formulas()
                    .for_each(|formula| self.known(scope.key("then"), formula, names));
                sentence
            }
            Err(what) => {
                self.faults.refuse(
                    scope,
                    "then",
                    what,
                    "write numbers as formulas in braces, as in `{v / 2} m/s`",
                );
                Sentence::default()
            }
        }
    }

    fn formula(&mut self, path: String, text: &str, names: &HashSet<String>) -> Formula {
        match Formula::parse(text) {
            Ok(formula) => {
                self.known(path, &formula, names);
                formula
            }
            Err(what) => {
                self.faults.add(path, what, "write one such as `v > 0.5 && v < 2`");
                Formula::parse("0").expect("a number is a formula")
            }
        }
    }

    fn known(&mut self, path: String, formula: &Formula, names: &HashSet<String>) {
        let is_known = |name: &str| {
            let mut stems = SUFFIXES.iter().filter_map(|suffix| name.strip_suffix(suffix));
            names.contains(name) || stems.any(|name| names.contains(name))
        };
        for name in formula.names().iter().filter(|name| !is_known(name)) {
            let mut known: Vec<_> = names.iter().map(String::as_str).collect();
            known.sort_unstable();
            self.faults.add(
                path.clone(),
                format!("nothing measures `{name}`"),
                suggest(name, &known),
            );
        }
    }
}

/// Whether both are the name of one scene, or paths of one file.
#[must_use]
pub fn is_same_scene(one: &str, other: &str) -> bool {
    let path = |name: &str| std::fs::canonicalize(name).ok();
    one == other || path(one).is_some_and(|one| path(other) == Some(one))
}

/// The scene name `file`, or the path of `file` as seen from the folder of the lesson.
#[must_use]
pub fn beside(lesson: &str, file: &str) -> String {
    if shipped::embedded(file).is_some() {
        return file.to_owned();
    }
    let folder = Path::new(lesson).parent().unwrap_or(Path::new(""));
    folder.join(file).to_string_lossy().into_owned()
}
