//! From written rows of the survival matrix to those that are run.

use glam::DVec3;
use motion::effects::Effect;
use motion::{Damping, DampingModel};

use crate::action::{Action, Step, When};
use crate::check::DAMPING_RATE;
use crate::check::{Scope, not_negative, positive};
use crate::raw::survival::{RawMoment, RawSteps, RawSurvival};
use crate::scene::names::Names;
use crate::scene::survival::{Bounds, Measure, Steps, SurvivalRow};
use crate::script::{Removed, undeclared};
use crate::text::faults::Faults;
use crate::text::syntax::Word;

/// From which magnitude on nothing is left of a run, unless the scene says otherwise.
pub const EXPLODES: f64 = 1e3;

/// How much finer a reference is, unless the scene says otherwise.
const REFERENCE_SUBSTEPS: u32 = 64;

/// Most ticks of a row: an hour of a processor.
const TICK_LIMIT: u64 = 1_000_000_000;

/// What the scene itself has.
pub(crate) struct Around<'a> {
    pub step_hz: f64,
    pub substeps: u32,
    pub damping: Option<Damping>,
    pub falls: bool,
    /// Whether bodies have damping of their own, or no gravity.
    pub differ: bool,
    pub stretches: bool,
    pub names: Option<&'a Names>,
    /// The effects with the keys that call for them.
    pub declared: &'a [(Effect, String)],
}

/// The rows of a scene, in the order of the file; of one in both precisions, f64 comes first.
pub(crate) fn survival(raw: &RawSurvival, around: &Around<'_>, faults: &mut Faults) -> Vec<SurvivalRow> {
    if raw.rows.is_empty() {
        return rows(
            Pair { row: raw, common: raw, scope: Scope::section("expect.survival") },
            around,
            faults,
        );
    }
    if raw.label.is_some() {
        let cure = "move it into a row, or remove it";
        faults.add("expect.survival.label", "a label is that of one row, and here are several", cure);
    }
    let mut all = Vec::new();
    for (i, row) in raw.rows.iter().enumerate() {
        let scope = Scope::item("expect.survival.rows", i);
        if row.label.iter().flat_map(|label| label.chars()).any(|c| c.is_control() || c == '|') {
            faults.add(scope.key("label"), "it breaks the table that it stands in", "give words of one line");
        } else if row.label.as_deref().is_none_or(str::is_empty) {
            faults.missing(scope.path(), "label", "say what tells this row from the others");
        } else if raw.rows[..i].iter().any(|other| other.label == row.label) {
            let what = "a row before this one has the same label";
            faults.add(scope.key("label"), what, "say what tells this row from the others");
        }
        if !row.rows.is_empty() {
            faults.add(scope.key("rows"), "a row has no rows", "write them beside it");
        }
        all.extend(rows(Pair { row, common: raw, scope }, around, faults));
    }
    all
}

/// A row, and what it leaves to all rows.
#[derive(Clone, Copy)]
struct Pair<'a> {
    row: &'a RawSurvival,
    common: &'a RawSurvival,
    scope: Scope,
}

impl<'a> Pair<'a> {
    /// What the row has at a key, or else all rows.
    fn get<T>(self, key: impl Fn(&'a RawSurvival) -> Option<T>) -> Option<T> {
        key(self.row).or_else(|| key(self.common))
    }
}

/// One row a precision.
fn rows(raw: Pair<'_>, around: &Around<'_>, faults: &mut Faults) -> Vec<SurvivalRow> {
    let scope = raw.scope;
    let precisions = raw.get(|raw| raw.precisions.as_ref()).map_or(vec![false], |words| {
        let known = [("f64", false), ("f32", true)];
        if let Some(Word(word)) = (1..words.len()).find_map(|i| words[..i].iter().find(|w| **w == words[i])) {
            let what = format!("{word} is there twice");
            faults.add(scope.key("precisions"), what, "give [f64], [f32] or [f64, f32]");
        }
        words.iter().map(|word| faults.word((scope, "precisions"), Some(word), false, &known)).collect()
    });
    if precisions.is_empty() {
        faults.add(scope.key("precisions"), "there is no precision", "give [f64], [f32] or [f64, f32]");
    }
    let step_hz = faults.number(
        (scope, "step_hz"),
        raw.get(|raw| raw.step_hz),
        around.step_hz,
        |v| positive(v) && (1.0 / v).is_finite(),
        ("a step rate", "give a positive number of steps a second"),
    );
    let measure = measure(raw, around, faults);
    let row = SurvivalRow {
        label: raw.row.label.clone().unwrap_or_default(),
        measure,
        ticks: ticks(raw, step_hz, faults),
        single: false,
        bounds: bounds(raw, faults),
        scale: scale(raw, measure, faults),
        reference_substeps: faults
            .parts((scope, "reference_substeps"), raw.get(|raw| raw.reference_substeps))
            .unwrap_or(REFERENCE_SUBSTEPS),
        steps: raw
            .get(|raw| raw.steps.as_ref())
            .map_or(Steps::Constant, |steps| self::steps(steps, scope, faults)),
        step_hz,
        substeps: faults.substeps(scope, raw.get(|raw| raw.substeps)).unwrap_or(around.substeps),
        damping: damping(raw, around, faults),
        offset: faults.vector((scope, "offset_m"), raw.get(|raw| raw.offset_m), DVec3::ZERO),
        script: script(raw, around, faults),
    };
    if precisions.contains(&true) {
        single_precision(&row, scope, faults);
    }
    precisions.into_iter().map(|single| SurvivalRow { single, ..row.clone() }).collect()
}

/// What plain arrays cannot do.
fn single_precision(row: &SurvivalRow, scope: Scope, faults: &mut Faults) {
    let why = if row.measure == Measure::Energy {
        "books of energy are kept in f64 alone"
    } else if row.script.iter().any(|step| only_of_worlds(&step.action)) {
        "positions are set, bodies removed and effects switched in f64 alone"
    } else {
        return;
    };
    faults.add(scope.key("precisions"), why, "give [f64]");
}

const fn only_of_worlds(action: &Action) -> bool {
    matches!(action, Action::SetPosition(..) | Action::Remove(_) | Action::SwitchEffect(..))
}

fn measure(raw: Pair<'_>, around: &Around<'_>, faults: &mut Faults) -> Measure {
    let scope = raw.scope;
    let word = raw.get(|raw| raw.measure.as_ref());
    let known = Measure::ALL.map(|measure| (measure.name(), measure));
    let measure = faults.word((scope, "measure"), word, Measure::Energy, &known);
    let names = Measure::ALL.map(Measure::name).join(", ");
    let damped = raw.get(|raw| raw.damping_per_s).or(around.damping.map(|damping| damping.rate));
    let damped = damped.is_some_and(|rate| rate > 0.0);
    match measure {
        _ if word.is_none() => faults.missing(scope.path(), "measure", &format!("give one of {names}")),
        Measure::TerminalSpeed if !(around.falls && damped) => {
            let what = "there is no terminal speed without gravity and damping";
            faults.add(scope.key("measure"), what, "declare both, or measure something else");
        }
        Measure::TerminalSpeed if around.differ => {
            let what =
                "bodies with a damping_per_s of their own, or without gravity, have no speed in common";
            faults.add(scope.key("measure"), what, "remove both, or measure something else");
        }
        Measure::Stretch if !around.stretches => {
            let what = "there is no spring with a length to stretch from";
            faults.add(scope.key("measure"), what, "add one with a rest_length_m, or measure something else");
        }
        _ => {}
    }
    measure
}

fn scale(raw: Pair<'_>, measure: Measure, faults: &mut Faults) -> Option<f64> {
    let scale = raw.get(|raw| raw.scale_j);
    if measure == Measure::Rest && scale.is_none() {
        faults.missing(raw.scope.path(), "scale_j", "add an energy such as m g L, in joules");
    }
    let words = ("an energy", "give a positive number of joules");
    let value = faults.number((raw.scope, "scale_j"), scale, 1.0, positive, words);
    scale.map(|_| value)
}

fn ticks(raw: Pair<'_>, step_hz: f64, faults: &mut Faults) -> u64 {
    let scope = raw.scope;
    // What the row says wins over both of all rows.
    let own = raw.row.ticks.is_some() || raw.row.seconds.is_some();
    let from = if own { raw.row } else { raw.common };
    let ticks = match (from.ticks, from.seconds) {
        (Some(ticks), None) => ticks,
        (None, Some(seconds)) => {
            let words = ("a length of time", "give a positive number of seconds");
            let seconds = faults.number((scope, "seconds"), Some(seconds), 1.0 / step_hz, positive, words);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "positive, and saturating"
            )]
            let ticks = (seconds * step_hz - 1e-9).ceil().max(1.0) as u64;
            ticks
        }
        (None, None) => {
            faults.missing(scope.path(), "seconds", "add it, or `ticks`");
            1
        }
        (Some(_), Some(_)) => {
            faults.add(scope.path(), "the length is given twice", "keep one of `seconds` and `ticks`");
            1
        }
    };
    if (1..=TICK_LIMIT).contains(&ticks) {
        return ticks;
    }
    faults.add(
        scope.key("ticks"),
        format!("{ticks} ticks are too few or too many"),
        format!("give 1 to {TICK_LIMIT}"),
    );
    1
}

fn bounds(raw: Pair<'_>, faults: &mut Faults) -> Bounds {
    let scope = raw.scope;
    let words = ("a bound", "give a number from 0 up, such as 1e-9");
    let [exact, bounded, explodes] = [
        ("exact_below", raw.get(|raw| raw.exact_below), 0.0),
        ("bounded_below", raw.get(|raw| raw.bounded_below), 1.0),
        ("explodes_above", raw.get(|raw| raw.explodes_above), EXPLODES),
    ]
    .map(|(key, value, default)| faults.number((scope, key), value, default, not_negative, words));
    if raw.get(|raw| raw.bounded_below).is_none() {
        faults.missing(scope.path(), "bounded_below", "add the bound that a run of use keeps");
    } else if !(exact <= bounded && bounded < explodes) {
        let what = format!("the bounds {exact}, {bounded} and {explodes} do not rise");
        faults.add(scope.key("bounded_below"), what, "give exact_below <= bounded_below < explodes_above");
    }
    Bounds { exact, bounded, explodes }
}

fn damping(raw: Pair<'_>, around: &Around<'_>, faults: &mut Faults) -> Option<Damping> {
    let scope = raw.scope;
    let (model, rate) = (raw.get(|raw| raw.damping_model.as_ref()), raw.get(|raw| raw.damping_per_s));
    if model.is_none() && rate.is_none() {
        return around.damping;
    }
    let models = DampingModel::ALL.map(|model| (model.name(), model));
    let own = around.damping.unwrap_or(Damping { model: DampingModel::Exact, rate: 0.0 });
    let model = faults.word((scope, "damping_model"), model, own.model, &models);
    let rate = faults.number((scope, "damping_per_s"), rate, own.rate, not_negative, DAMPING_RATE);
    Some(Damping { model, rate })
}

fn steps(raw: &RawSteps, scope: Scope, faults: &mut Faults) -> Steps {
    let key = (scope, "steps");
    match *raw {
        RawSteps::Constant => Steps::Constant,
        RawSteps::Jittered { spread, seed } => {
            let words = ("a spread", "give one above 0 and below 1, such as `jittered(spread: 0.5)`");
            let spread = spread.unwrap_or(f64::NAN);
            let spread = faults.number(key, Some(spread), 0.5, |v| v > 0.0 && v < 1.0, words);
            Steps::Jittered { spread, seed: seed.unwrap_or(0) }
        }
        RawSteps::Hitch { at_s, length_s } => {
            let words = ("a time", "give seconds, such as `hitch(at_s: 1.0, length_s: 1.0)`");
            let [at, length] = [at_s, length_s].map(|time| time.unwrap_or(f64::NAN));
            let at = faults.number(key, Some(at), 0.0, not_negative, words);
            let length = faults.number(key, Some(length), 1.0, positive, words);
            Steps::Hitch { at, length }
        }
    }
}

fn script(raw: Pair<'_>, around: &Around<'_>, faults: &mut Faults) -> Vec<Step> {
    let moments = raw.get(|raw| raw.script.as_deref()).unwrap_or_default();
    let mut steps: Vec<Step> = Vec::with_capacity(moments.len());
    for moment in moments {
        match step(moment, around) {
            Ok(step) => {
                let backwards = steps.last().is_some_and(|last| match (last.when, step.when) {
                    (When::Seconds(a), When::Seconds(b)) => b < a,
                    (When::Tick(a), When::Tick(b)) => b < a,
                    _ => true,
                });
                if backwards {
                    let cure = "give times of one kind that never go backwards";
                    faults.add(raw.scope.key("script"), "a step comes before the one above it", cure);
                }
                steps.push(step);
            }
            Err((what, cure)) => faults.add(raw.scope.key("script"), what, cure),
        }
    }
    let mut removed = Removed::default();
    for (what, cure) in steps.iter().enumerate().filter_map(|(i, step)| removed.look(i, step)) {
        faults.add(raw.scope.key("script"), what, cure);
    }
    steps
}

fn step(moment: &RawMoment, around: &Around<'_>) -> Result<Step, (String, String)> {
    let fail = |what: &str, cure: &str| Err((what.to_owned(), cure.to_owned()));
    let when = match (moment.at_s, moment.at_tick) {
        (Some(at), None) if not_negative(at) => When::Seconds(at),
        (None, Some(at)) => When::Tick(at),
        _ => return fail("a step has no time, or several", "give each one of at_s and at_tick, from 0 up"),
    };
    let Some(action) = moment.action.clone() else {
        return fail("a step does nothing", "add one such as `do: set_gravity((0, 0, 0))`");
    };
    // A row has the methods of its columns.
    if !action.is_experiment() || matches!(action, Action::SetMethod(_) | Action::SetBodyMethod(..)) {
        let cure = "give push, impulse, set_gravity, set_damping, set_velocity, set_position, reverse_velocities, remove \
                    or switch_effect";
        return fail("a step is no experiment", cure);
    }
    if let Some(fault) = action.fault() {
        return Err(fault);
    }
    let strange = |names: &Names| {
        let body = action.body().filter(|body| names.find(body).is_none())?;
        Some(names.stranger(body))
    };
    let declares = |effect| around.declared.iter().any(|(declared, _)| *declared == effect);
    match around.names.and_then(strange).or_else(|| undeclared(&action, declares)) {
        Some(fault) => Err(fault),
        None => Ok(Step { when, action }),
    }
}
