//! The forecast of a session: which steps are too long, by the names of the scene.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use history::RunSettings;
use motion::margin::{Deviation, Fate, LASTING_TURNS, LimitingPart, Margin, Occasion};
use motion::groups::Groups;
use motion::{Method, Substeps, TimeStep, margin};
use report::numbers::{digits, number};
use scene::StepKind;

use crate::stage::Stage;
use crate::stage::notices::Topic;

/// How long a forecast is shown before it is computed again, s: speeds and distances change all the time.
pub(super) const FRESH_S: f64 = 0.25;

/// How long a forecast of a large net is shown before it is computed again, s: computing it takes a frame.
pub(super) const FRESH_LARGE_S: f64 = 2.0;
/// Number of springs above which a net is large.
pub(super) const LARGE_NET: usize = 20_000;

/// Least growth per second that is given as a number, %.
const LEAST_PERCENT: f64 = 0.001;

/// How far a part of the scene is from instability, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastRow {
    /// The part, its value and its limit.
    pub margin: Margin,
    /// Name of the part.
    pub element: String,
    /// What would help; empty if no help is needed.
    pub cure: String,
}

impl ForecastRow {
    /// The symbol of its value.
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

    /// The value, or the interval in which it is known to be.
    #[must_use]
    pub(crate) fn value(&self) -> String {
        let Margin { value, at_most, .. } = self.margin;
        if self.margin.is_known() && !self.margin.may_be_unstable() {
            digits(value)
        } else {
            format!("{} to {}", digits(value), digits(at_most))
        }
    }

    /// The verdict, in short.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        match self.margin.fate {
            Fate::Grows => "unstable",
            Fate::Drifts(turns) if turns > 1.0 => "unstable in the long run",
            Fate::Drifts(_) => "unstable",
            Fate::Wrong(_) => "stable, but wrong",
            Fate::Holds if self.margin.may_be_unstable() => "at its limit",
            Fate::Holds => "stable",
        }
    }

    /// Whether the row is reported before the run, and not only listed.
    fn is_reported(&self) -> bool {
        let is_wrong = matches!(self.margin.fate, Fate::Wrong(_));
        self.margin.is_reported() || is_wrong || self.margin.may_be_unstable()
    }

    /// The state that has the value, and the current value; empty if the value is the current one.
    pub(super) fn occasion(&self) -> String {
        let when = match self.margin.occasion {
            Occasion::Now => return String::new(),
            Occasion::ClosestApproach => "at its closest approach",
            Occasion::Met => "at its largest in the run",
            Occasion::TerminalSpeed => "at the terminal speed",
            Occasion::Gust => "in the fastest gust",
            Occasion::Birth => return " at birth".to_owned(),
        };
        format!(" {when}, {} now", digits(self.margin.now))
    }

    /// The row in one line.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { margin, element, cure } = self;
        let (symbol, value, method) = (self.symbol(), self.value(), margin.method.name());
        let limit = match (margin.limit, margin.lasts) {
            (limit, None) if margin.may_be_unstable() => {
                let apart = (limit / margin.value).max(margin.at_most / limit) - 1.0;
                // Rounded up: the interval is not narrower than it says.
                let percent = format!("{:.1} %", (1000.0 * apart).ceil() / 10.0);
                format!("within {percent} of the limit of {method}, {}", digits(limit))
            }
            (0.0, None) => format!("{method} is never stable here"),
            (_, Some(0.0)) => format!("{method} keeps no orbit"),
            (limit, None) if limit.is_infinite() => format!("{method} has no limit here"),
            (limit, None) => format!("the limit of {method} is {}", digits(limit)),
            (limit, Some(lasts)) => {
                let grows = if limit > lasts {
                    format!(" and grows from {}", digits(limit))
                } else {
                    String::new()
                };
                format!(
                    "{method} keeps a circle for {LASTING_TURNS} turns up to {}{grows}",
                    digits(lasts)
                )
            }
        };
        let fate = match margin.fate {
            Fate::Drifts(turns) => format!(", leaves its orbit {}", turns_in_words(turns)),
            Fate::Wrong(deviation) => format!(", {}", wrong(deviation)),
            Fate::Grows if margin.limit == 0.0 => format!(", {}", growth(margin.growth_per_s)),
            Fate::Grows | Fate::Holds => String::new(),
        };
        let cure = if cure.is_empty() { String::new() } else { format!("; {cure}") };
        format!("{element}: {symbol} = {value}{}, {limit}{fate}{cure}", self.occasion())
    }
}

pub(super) fn turns_in_words(turns: f64) -> String {
    if turns <= 1.0 {
        "in its first turn".to_owned()
    } else {
        format!("within {} turns", number(turns.ceil(), 3))
    }
}

/// How a method deviates from the true motion, in words.
pub(super) fn wrong(deviation: Deviation) -> String {
    match deviation {
        Deviation::Reverses => "turns the body back".to_owned(),
        Deviation::Settles(multiple) => {
            format!("settles at {} of the true velocity", number(multiple, 2))
        }
        Deviation::Alternates([least, most]) => {
            format!(
                "alternates between {} and {} of the true velocity",
                number(least, 2),
                number(most, 2)
            )
        }
    }
}

/// Growth by `factor` per second, in words. Slow growth is given in percent, because the factor would round to 1.
pub(super) fn growth(factor: f64) -> String {
    let percent = 100.0 * (factor - 1.0);
    if factor.is_infinite() {
        "grows without bound".to_owned()
    } else if factor >= 2.0 {
        format!("grows {} times per second", digits(factor))
    } else if percent >= LEAST_PERCENT {
        format!("grows by {} % per second", number(percent, 2))
    } else {
        format!("grows by less than {LEAST_PERCENT} % per second")
    }
}

fn cure_in_words(margin: &Margin) -> String {
    if margin.fate == Fate::Holds && !margin.may_be_unstable() {
        return String::new();
    }
    match (margin.cure.substeps, margin.cure.method.map(Method::name)) {
        (Some(substeps), Some(method)) => format!("needs {substeps} substeps, or {method}"),
        (Some(substeps), None) => format!("needs {substeps} substeps"),
        (None, Some(method)) => format!("needs {method}"),
        (None, None) => {
            format!(
                "found no cure: no other method, and no number up to {} substeps",
                Substeps::MOST
            )
        }
    }
}

/// The settings and the structure on which a forecast depends.
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
    /// The rows at the start of the scene that are unstable, or may be, or are wrong.
    pub fn at_start(&self) -> &[ForecastRow] {
        &self.at_start
    }

    /// The forecast of the open panel, the worst first.
    pub fn shown(&self) -> Option<&[ForecastRow]> {
        self.shown.as_ref().map(|shown| &shown.rows[..])
    }

    /// How much of its limit a spring between two bodies uses, while the panel is open; 0 for a spring that is in no group.
    pub fn spring_ratio(&self, ends: [Entity; 2]) -> Option<f64> {
        self.shown.as_ref().map(|shown| shown.springs.get(&in_order(ends)).copied().unwrap_or(0.0))
    }

    /// Computes the forecast at the start of a scene with frames of that length, s. Keeps the rows that are unstable, or may
    /// be, or are wrong, for the summary; tells and returns those that would be seen.
    pub fn begin(&mut self, stage: &mut Stage, frame: f64) -> Vec<ForecastRow> {
        let is_listed =
            |row: &ForecastRow| row.margin.fate != Fate::Holds || row.margin.may_be_unstable();
        self.at_start = rows_at_start(stage, frame).into_iter().filter(is_listed).collect();
        let told: Vec<_> = self.at_start.iter().filter(|row| row.is_reported()).cloned().collect();
        if let Some(worst) = told.first() {
            stage.notices.say(Topic::Forecast, format!("{}: {}", worst.verdict(), worst.line()));
        }
        told
    }

    pub(super) fn refresh(&mut self, stage: &mut Stage, of: Circumstances) {
        let method = stage.sim().method();
        let forecast = margin::Forecast::with_springs(&mut stage.sim_mut().world, method);
        let mut springs = HashMap::new();
        for spring in forecast.springs() {
            let ratio: &mut f64 = springs.entry(in_order(spring.ends)).or_default();
            *ratio = ratio.max(spring.ratio);
        }
        self.shown = Some(Shown { of, age: 0.0, rows: rows_of(stage, &forecast), springs });
    }
}

/// How far everything is from instability at the start of a scene with frames of that length, s, the worst first.
pub(crate) fn rows_at_start(stage: &mut Stage, frame: f64) -> Vec<ForecastRow> {
    if stage.sim().scene.step == StepKind::Frame {
        stage.sim_mut().world.insert_resource(TimeStep(frame));
    }
    rows(stage)
}

/// How far everything is from instability now, the worst first.
pub(crate) fn rows(stage: &mut Stage) -> Vec<ForecastRow> {
    let method = stage.sim().method();
    let forecast = margin::Forecast::of(&mut stage.sim_mut().world, method);
    rows_of(stage, &forecast)
}

fn rows_of(stage: &Stage, forecast: &margin::Forecast) -> Vec<ForecastRow> {
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
    let settings = RunSettings::of(stage.sim_mut());
    let groups = stage.sim().world.get_resource::<Groups>();
    let structure = groups.map_or([0; 4], |groups| {
        [groups.len(), groups.springs(), groups.bodies(), stage.quarantines().here().len()]
    });
    Circumstances { settings, structure }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_grows_slowly_is_said_to_grow_by_a_share() {
        for (factor, words) in [
            (49.2, "grows 49.2 times per second"),
            (2.0, "grows 2 times per second"),
            (1.153, "grows by 15 % per second"),
            (1.000_021, "grows by 0.0021 % per second"),
            (1.0 + f64::EPSILON, "grows by less than 0.001 % per second"),
            (f64::INFINITY, "grows without bound"),
        ] {
            assert_eq!(growth(factor), words);
        }
    }
}
