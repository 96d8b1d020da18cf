//! Resolves the rows of the survival matrix.

use glam::DVec3;
use motion::{Damping, DampingModel};

use crate::action::{ChangeAction, Step, When};
use crate::check::{DAMPING_RATE, Rule, STEP_RATE, Scope, not_negative, positive, rule};
use crate::raw;
use crate::scene::Scene;
use crate::scene::names::Names;
use crate::scene::survival::{Bounds, Measure, SurvivalRow, TickLengths};
use crate::script::{Removed, undeclared};
use crate::text::faults::Faults;

/// Default magnitude of the measured number above which a run has exploded.
pub const EXPLODES: f64 = 1e3;

/// Default substeps of a reference run.
const REFERENCE_SUBSTEPS: u32 = 64;

/// Most ticks of a row: an hour of processor time.
const TICK_LIMIT: u64 = 1_000_000_000;

const ENERGY: Rule = rule(positive, "an energy", "give a positive number of joules");
const SECONDS: Rule = rule(positive, "a length of time", "give a positive number of seconds");
const BOUND: Rule = rule(not_negative, "a bound", "give a number from 0 up, such as 1e-9");
const SPREAD: Rule = rule(
    |v| v > 0.0 && v < 1.0,
    "a spread",
    "give one above 0 and below 1, such as `jittered(spread: 0.5)`",
);
const HITCH: &str = "give seconds, such as `hitch(at_s: 1.0, length_s: 1.0)`";

/// The rows of `scene`, in the order of the file. `names` are those of its bodies, unless they are too many.
pub(crate) fn survival(
    file: &raw::Scene,
    scene: &Scene,
    names: Option<&Names>,
    faults: &mut Faults,
) -> Option<Vec<SurvivalRow>> {
    let common = file.expect.as_ref()?.survival.as_ref()?;
    let row = |own, scope| Row { own, common, scope, file, scene, names };
    if common.rows.is_empty() {
        return Some(vec![row(common, Scope::section("expect.survival")).resolve(faults)]);
    }
    if common.label.is_some() {
        let cure = "move it into a row, or remove it";
        faults.add(
            "expect.survival.label",
            "a label is that of one row, and here are several",
            cure,
        );
    }
    let mut all = Vec::new();
    for (i, own) in common.rows.iter().enumerate() {
        let scope = Scope::item("expect.survival.rows", i);
        if own.label.iter().flat_map(|label| label.chars()).any(|c| c.is_control() || c == '|') {
            faults.refuse(
                scope,
                "label",
                "it breaks the table that it stands in",
                "give words of one line",
            );
        } else if own.label.as_deref().is_none_or(str::is_empty) {
            faults.missing(scope.path(), "label", "say what tells this row from the others");
        } else if common.rows[..i].iter().any(|other| other.label == own.label) {
            let what = "a row before this one has the same label";
            faults.refuse(scope, "label", what, "say what tells this row from the others");
        }
        if !own.rows.is_empty() {
            faults.refuse(scope, "rows", "a row has no rows", "write them beside it");
        }
        all.push(row(own, scope).resolve(faults));
    }
    Some(all)
}

/// A row, the keys that are common to all rows, and the scene of the row.
#[derive(Clone, Copy)]
struct Row<'a> {
    own: &'a raw::Survival,
    common: &'a raw::Survival,
    scope: Scope,
    file: &'a raw::Scene,
    scene: &'a Scene,
    names: Option<&'a Names>,
}

impl<'a> Row<'a> {
    /// The value of a key in the row, or else the common value.
    fn get<T>(self, key: impl Fn(&'a raw::Survival) -> Option<T>) -> Option<T> {
        key(self.own).or_else(|| key(self.common))
    }

    fn resolve(self, faults: &mut Faults) -> SurvivalRow {
        let scope = self.scope;
        let step_hz = self.get(|raw| raw.step_hz);
        let step_hz = faults.number(scope, "step_hz", step_hz, self.scene.step_hz, STEP_RATE);
        let measure = self.measure(faults);
        let reference_substeps = self.get(|raw| raw.reference_substeps);
        SurvivalRow {
            label: self.own.label.clone().unwrap_or_default(),
            measure,
            ticks: self.ticks(step_hz, faults),
            bounds: self.bounds(faults),
            scale: self.scale(measure, faults),
            reference_substeps: faults
                .count_of_substeps(scope, "reference_substeps", reference_substeps)
                .unwrap_or(REFERENCE_SUBSTEPS),
            steps: self.steps(faults),
            step_hz,
            substeps: faults
                .substeps(scope, self.get(|raw| raw.substeps))
                .unwrap_or(self.scene.substeps),
            damping: self.damping(faults),
            offset: faults.vector(scope, "offset_m", self.get(|raw| raw.offset_m), DVec3::ZERO),
            script: self.script(faults),
        }
    }

    /// What the row measures. The arms of a measure that suits the scene return; the others give a fault.
    fn measure(self, faults: &mut Faults) -> Measure {
        let Self { scope, scene, .. } = self;
        let word = self.get(|raw| raw.measure.as_ref());
        let known = Measure::ALL.map(|measure| (measure.name(), measure));
        let measure = faults.word(scope, "measure", word, Measure::Energy, &known);
        let (what, cure) = match measure {
            _ if word.is_none() => {
                let names = Measure::ALL.map(Measure::name).join(", ");
                faults.missing(scope.path(), "measure", &format!("give one of {names}"));
                return measure;
            }
            Measure::TerminalSpeed if !(self.falls() && self.damped()) => (
                "there is no terminal speed without gravity and damping",
                "declare both, or measure something else",
            ),
            Measure::TerminalSpeed
                if scene
                    .bodies
                    .iter()
                    .any(|body| body.gravity_off || body.damping_rate.is_some()) =>
            {
                (
                    "bodies with a damping_per_s of their own, or without gravity, have no speed in common",
                    "remove both, or measure something else",
                )
            }
            Measure::Stretch if !self.stretches() => (
                "there is no spring with a length to stretch from",
                "add one with a rest_length_m, or measure something else",
            ),
            Measure::TerminalSpeed
            | Measure::Stretch
            | Measure::Energy
            | Measure::Reference
            | Measure::Origin
            | Measure::Rest => return measure,
        };
        faults.refuse(scope, "measure", what, cure);
        measure
    }

    fn falls(self) -> bool {
        self.scene.gravity.is_some_and(|gravity| gravity.acceleration != DVec3::ZERO)
    }

    fn damped(self) -> bool {
        let rate =
            self.get(|raw| raw.damping_per_s).or(self.scene.damping.map(|damping| damping.rate));
        rate.is_some_and(|rate| rate > 0.0)
    }

    fn stretches(self) -> bool {
        // The scene lacks soft bodies with certain faults, so the file is asked for them.
        let mut springs = self.scene.springs.iter();
        !self.file.soft_bodies.is_empty() || springs.any(|spring| spring.elastic.rest_length > 0.0)
    }

    fn scale(self, measure: Measure, faults: &mut Faults) -> Option<f64> {
        let (scope, key) = (self.scope, "scale_j");
        let scale = self.get(|raw| raw.scale_j);
        let is_complete = measure != Measure::Rest || scale.is_some();
        faults.require(is_complete, scope, key, "add an energy such as m g L, in joules");
        faults.optional(scope, key, scale, ENERGY)
    }

    fn ticks(self, step_hz: f64, faults: &mut Faults) -> u64 {
        let scope = self.scope;
        // A length in the row overrides both common keys.
        let own = self.own.ticks.is_some() || self.own.seconds.is_some();
        let from = if own { self.own } else { self.common };
        let ticks = match (from.ticks, from.seconds) {
            (Some(ticks), None) => ticks,
            (None, Some(_)) => {
                let seconds = faults.number(scope, "seconds", from.seconds, 1.0 / step_hz, SECONDS);
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
                faults.add(
                    scope.path(),
                    "the length is given twice",
                    "keep one of `seconds` and `ticks`",
                );
                1
            }
        };
        if (1..=TICK_LIMIT).contains(&ticks) {
            return ticks;
        }
        let what = format!("{ticks} ticks are too few or too many");
        faults.refuse(scope, "ticks", what, format!("give 1 to {TICK_LIMIT}"));
        1
    }

    fn bounds(self, faults: &mut Faults) -> Bounds {
        let scope = self.scope;
        let mut bound = |key, value, default| faults.number(scope, key, value, default, BOUND);
        let given = self.get(|raw| raw.bounded_below);
        let exact = bound("exact_below", self.get(|raw| raw.exact_below), 0.0);
        let bounded = bound("bounded_below", given, 1.0);
        let explodes = bound("explodes_above", self.get(|raw| raw.explodes_above), EXPLODES);
        faults.require(
            given.is_some(),
            scope,
            "bounded_below",
            "add the bound that a useful run stays below",
        );
        if given.is_some() && !(exact <= bounded && bounded < explodes) {
            let what = format!("the bounds {exact}, {bounded} and {explodes} do not rise");
            let cure = "give exact_below <= bounded_below < explodes_above";
            faults.refuse(scope, "bounded_below", what, cure);
        }
        Bounds { exact, bounded, explodes }
    }

    fn damping(self, faults: &mut Faults) -> Option<Damping> {
        let scope = self.scope;
        let (model, rate) =
            (self.get(|raw| raw.damping_model.as_ref()), self.get(|raw| raw.damping_per_s));
        if model.is_none() && rate.is_none() {
            return self.scene.damping;
        }
        let models = DampingModel::ALL.map(|model| (model.name(), model));
        let of_scene =
            self.scene.damping.unwrap_or(Damping { model: DampingModel::Exact, rate: 0.0 });
        let model = faults.word(scope, "damping_model", model, of_scene.model, &models);
        let rate = faults.number(scope, "damping_per_s", rate, of_scene.rate, DAMPING_RATE);
        Some(Damping { model, rate })
    }

    fn steps(self, faults: &mut Faults) -> TickLengths {
        let (scope, key) = (self.scope, "steps");
        let mut number = |name: &str, value: Option<f64>, default, rule: Rule| {
            if value.is_none() {
                faults.missing(scope.key(key), name, rule.cure);
            }
            faults.number(scope, key, value, default, rule)
        };
        match *self.get(|raw| raw.steps.as_ref()).unwrap_or(&raw::Steps::Constant) {
            raw::Steps::Constant => TickLengths::Constant,
            raw::Steps::Jittered { spread, seed } => TickLengths::Jittered {
                spread: number("spread", spread, 0.5, SPREAD),
                seed: seed.unwrap_or(0),
            },
            raw::Steps::Hitch { at_s, length_s } => TickLengths::Hitch {
                at: number("at_s", at_s, 0.0, rule(not_negative, "a time", HITCH)),
                length: number("length_s", length_s, 1.0, rule(positive, "a time", HITCH)),
            },
        }
    }

    fn script(self, faults: &mut Faults) -> Vec<Step> {
        let key = self.scope.key("script");
        let moments = self.get(|raw| raw.script.as_deref()).unwrap_or_default();
        let mut steps: Vec<Step> = Vec::with_capacity(moments.len());
        for moment in moments {
            match self.step(moment) {
                Ok(step) => {
                    // `None`, for a second after a tick or a tick after a second, is a fault, too.
                    if steps.last().is_some_and(|last| step.when.precedes(last.when) != Some(false))
                    {
                        let cure = "give times of one kind that never go backwards";
                        faults.add(key.as_str(), "a step comes before the one above it", cure);
                    }
                    steps.push(step);
                }
                Err((what, cure)) => faults.add(key.as_str(), what, cure),
            }
        }
        // `check` finds steps for bodies that an earlier step has removed.
        let mut removed = Removed::default();
        for (what, cure) in steps.iter().enumerate().filter_map(|(i, step)| removed.check(i, step))
        {
            faults.add(key.as_str(), what, cure);
        }
        steps
    }

    fn step(self, moment: &raw::Step) -> Result<Step, (String, String)> {
        let fail = |what: &str, cure: &str| Err((what.to_owned(), cure.to_owned()));
        let when = match (moment.at_s, moment.at_tick) {
            (Some(at), None) if not_negative(at) => When::Seconds(at),
            (None, Some(at)) => When::Tick(at),
            _ => {
                return fail(
                    "a step has no time, or several",
                    "give each one of at_s and at_tick, from 0 up",
                );
            }
        };
        let Some(action) = moment.action.clone() else {
            return fail("a step does nothing", "add one such as `do: set_gravity((0, 0, 0))`");
        };
        // The matrix runs a row with every method, a column each, at the substeps of the row: no step changes either.
        let is_of_methods = |change: &ChangeAction| {
            change.method().is_some() || matches!(change, ChangeAction::SetSubsteps(_))
        };
        if action.change().is_none_or(is_of_methods) {
            let cure = "give push, impulse, set_gravity, set_damping, set_velocity, set_position, reverse_velocities, \
                        remove or switch_effect";
            return fail("a step is no experiment", cure);
        }
        let strange = |names: &Names| {
            let body = action.body().filter(|body| names.find(body).is_none())?;
            Some(names.stranger(body))
        };
        let fault = action.fault().or_else(|| self.names.and_then(strange));
        match fault.or_else(|| undeclared(&action, self.scene)) {
            Some(fault) => Err(fault),
            None => Ok(Step { when, action }),
        }
    }
}
