//! The forecast of a session: which steps are too long, by the names of the scene.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use history::RunSettings;
use motion::forecast::{LimitingPart, Margin};
use motion::groups::Groups;
use motion::{Method, Substeps, TimeStep, forecast};
use report::numbers::{digits, number};
use scene::StepKind;

use crate::stage::Stage;
use crate::stage::notices::Topic;

/// How long a forecast is shown before it is computed again, s: speeds and distances change all the time.
pub(super) const FRESH_S: f64 = 0.25;

/// The same for large nets, of which a forecast takes a frame.
pub(super) const FRESH_LARGE_S: f64 = 2.0;
pub(super) const LARGE_NET: usize = 20_000;

/// What grows by less than this factor in a second, and in a tick, is listed and not told: Runge-Kutta 2 is never quite
/// stable.
const TOLD_GROWTH: f64 = 1.01;

/// Growth in a second that is said as a number, %.
const LEAST_PERCENT: f64 = 0.001;

/// How far from instability something is, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastRow {
    /// What it is.
    pub margin: Margin,
    /// Its name.
    pub element: String,
    /// What would help; empty where nothing has to.
    pub cure: String,
}

impl ForecastRow {
    /// What its value is.
    #[must_use]
    pub const fn symbol(&self) -> &'static str {
        match self.margin.part {
            LimitingPart::Spring(_)
            | LimitingPart::Well(..)
            | LimitingPart::Law(..)
            | LimitingPart::MutualGravity(_) => "w h",
            LimitingPart::Damper(_) | LimitingPart::Drag(_) | LimitingPart::Damping(_) => "c h",
        }
    }

    /// The value, or the interval that is known of it.
    #[must_use]
    pub(crate) fn value(&self) -> String {
        let Margin { value, at_most, .. } = self.margin;
        if self.margin.is_known() && !self.margin.may_be_unstable() {
            digits(value)
        } else {
            format!("{} to {}", digits(value), digits(at_most))
        }
    }

    /// What is said of a row that is unstable, or may be.
    #[must_use]
    pub const fn verdict(&self) -> &'static str {
        if self.margin.is_unstable { "unstable" } else { "at its limit" }
    }

    /// One line for it.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { margin, element, cure } = self;
        let (symbol, value, method) = (self.symbol(), self.value(), margin.method.name());
        let limit = match margin.limit {
            limit if margin.may_be_unstable() => {
                let apart = (limit / margin.value).max(margin.at_most / limit) - 1.0;
                // Rounded up: the interval is not narrower than it says.
                let percent = format!("{:.1} %", (1000.0 * apart).ceil() / 10.0);
                format!("within {percent} of the limit of {method}, {}", digits(limit))
            }
            0.0 => format!("{method} is never stable here"),
            limit if limit.is_infinite() => format!("{method} has no limit here"),
            limit => format!("the limit of {method} is {}", digits(limit)),
        };
        let grows = if !margin.is_unstable || margin.limit > 0.0 {
            String::new()
        } else {
            format!(", {}", growth(margin.growth_per_s))
        };
        let cure = if cure.is_empty() { String::new() } else { format!("; {cure}") };
        format!("{element}: {symbol} = {value}, {limit}{grows}{cure}")
    }
}

/// How fast something grows that grows by this factor in a second: slowly, by a share, which does not round to a factor of 1.
pub(super) fn growth(factor: f64) -> String {
    let percent = 100.0 * (factor - 1.0);
    if factor.is_infinite() {
        "grows without end".to_owned()
    } else if factor >= 2.0 {
        format!("grows {} times a second", digits(factor))
    } else if percent >= LEAST_PERCENT {
        format!("grows by {} % a second", number(percent, 2))
    } else {
        format!("grows by less than {LEAST_PERCENT} % a second")
    }
}

fn cure_in_words(margin: &Margin) -> String {
    if !(margin.is_unstable || margin.may_be_unstable()) {
        return String::new();
    }
    match (margin.cure.substeps, margin.cure.method.map(Method::name)) {
        (Some(substeps), Some(method)) => format!("needs {substeps} substeps, or {method}"),
        (Some(substeps), None) => format!("needs {substeps} substeps"),
        (None, Some(method)) => format!("needs {method}"),
        (None, None) => format!("nothing up to {} substeps helps", Substeps::MOST),
    }
}

/// What a forecast would come out differently with.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Circumstances {
    settings: RunSettings,
    /// Groups, springs in them, bodies in them, and quarantined bodies.
    pub structure: [usize; 4],
}

/// The forecast that is shown.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub of: Circumstances,
    /// Time since it was made, s.
    pub age: f64,
    rows: Vec<ForecastRow>,
    springs: HashMap<[Entity; 2], f64>,
}

fn in_order([a, b]: [Entity; 2]) -> [Entity; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The forecast of an open panel, and that of the start of the scene.
#[derive(Default)]
pub(crate) struct Forecast {
    pub(super) shown: Option<Shown>,
    at_start: Vec<ForecastRow>,
}

impl Forecast {
    /// The rows at the start of the scene that are unstable, or may be.
    pub fn at_start(&self) -> &[ForecastRow] {
        &self.at_start
    }

    /// The forecast of the open panel, the worst first.
    pub fn shown(&self) -> Option<&[ForecastRow]> {
        self.shown.as_ref().map(|shown| &shown.rows[..])
    }

    /// How much of its limit a spring between two bodies takes, while the panel is open: 0 for one that is in no group.
    pub fn spring_ratio(&self, ends: [Entity; 2]) -> Option<f64> {
        self.shown.as_ref().map(|shown| shown.springs.get(&in_order(ends)).copied().unwrap_or(0.0))
    }

    /// Computes the forecast at the start of a scene with frames of that length, s. Keeps the rows that are unstable, or may be, for the
    /// summary; tells and returns those whose growth would soon be seen.
    pub fn begin(&mut self, stage: &mut Stage, frame: f64) -> Vec<ForecastRow> {
        if stage.sim.scene.step == StepKind::Frame {
            stage.sim.world.insert_resource(TimeStep(frame));
        }
        let tick = stage.sim.world.resource::<TimeStep>().0;
        let grows = |row: &ForecastRow| row.margin.is_unstable || row.margin.may_be_unstable();
        self.at_start = rows(stage).into_iter().filter(grows).collect();
        let is_seen = |row: &&ForecastRow| {
            let a_second = row.margin.growth_per_s;
            a_second.max(a_second.powf(tick)) >= TOLD_GROWTH || row.margin.may_be_unstable()
        };
        let told: Vec<_> = self.at_start.iter().filter(is_seen).cloned().collect();
        if let Some(worst) = told.first() {
            stage.notices.say(Topic::Forecast, format!("{}: {}", worst.verdict(), worst.line()));
        }
        told
    }

    pub(super) fn refresh(&mut self, stage: &mut Stage, of: Circumstances) {
        let method = stage.sim.method();
        let forecast = forecast::Forecast::with_springs(&mut stage.sim.world, method);
        let mut springs = HashMap::new();
        for spring in forecast.springs() {
            let ratio: &mut f64 = springs.entry(in_order(spring.ends)).or_default();
            *ratio = ratio.max(spring.ratio);
        }
        self.shown = Some(Shown { of, age: 0.0, rows: rows_of(stage, &forecast), springs });
    }
}

/// How far everything is from instability as it is now, the worst first.
pub(crate) fn rows(stage: &mut Stage) -> Vec<ForecastRow> {
    let forecast = forecast::Forecast::of(&mut stage.sim.world, stage.sim.stepper.method());
    rows_of(stage, &forecast)
}

fn rows_of(stage: &Stage, forecast: &forecast::Forecast) -> Vec<ForecastRow> {
    let row = |margin: &Margin| ForecastRow {
        margin: *margin,
        element: part_name(stage, margin.part),
        cure: cure_in_words(margin),
    };
    forecast.margins().iter().map(row).collect()
}

fn part_name(stage: &Stage, part: LimitingPart) -> String {
    let name = |body: Entity| stage.name(body);
    match part {
        LimitingPart::Spring([a, b]) => format!("spring {} - {}", name(a), name(b)),
        LimitingPart::Damper([a, b]) => format!("damper {} - {}", name(a), name(b)),
        LimitingPart::Drag(body) => format!("drag on {}", name(body)),
        LimitingPart::Damping(body) => format!("damping of {}", name(body)),
        LimitingPart::MutualGravity([a, b]) => format!("mutual gravity {} - {}", name(a), name(b)),
        LimitingPart::Well(number, body) => format!("well {number} at {}", name(body)),
        LimitingPart::Law(law, body) => format!("{} at {}", law.replace('_', " "), name(body)),
    }
}

pub(super) fn circumstances(stage: &mut Stage) -> Circumstances {
    let settings = RunSettings::of(&mut stage.sim);
    let groups = stage.sim.world.get_resource::<Groups>();
    let structure = groups.map_or([0; 4], |groups| {
        [groups.len(), groups.springs(), groups.bodies(), stage.quarantined_here().len()]
    });
    Circumstances { settings, structure }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_grows_slowly_is_said_to_grow_by_a_share() {
        for (factor, words) in [
            (49.2, "grows 49.2 times a second"),
            (2.0, "grows 2 times a second"),
            (1.153, "grows by 15 % a second"),
            (1.000_021, "grows by 0.0021 % a second"),
            (1.0 + f64::EPSILON, "grows by less than 0.001 % a second"),
            (f64::INFINITY, "grows without end"),
        ] {
            assert_eq!(growth(factor), words);
        }
    }
}
