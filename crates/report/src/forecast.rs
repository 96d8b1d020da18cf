//! Forecasts in words: a row for each margin, and for each part that was tried.

use history::Simulation;
use lab::trial::{Excess, Settled, Trial, Tried, Verdict};
use motion::bevy_ecs::entity::Entity;
use motion::margin::{Cure, LimitingPart, Margin, Margins};
use motion::{Method, Substeps};
use scene::Substepping;
use serde_json::{Value, json};

use crate::numbers::{digits, json_number, number};

/// Least growth per second that is given as a number, %.
const LEAST_PERCENT: f64 = 0.001;

/// How a row of a forecast was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Instrument {
    /// By the margin of a part, linearized in the present state.
    Margin(Margin),
    /// By running a part ahead, beside far finer runs.
    Trial(Tried),
}

/// A row of a forecast.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastRow {
    /// The part of the scene.
    pub element: String,
    /// How it was found, with all numbers.
    pub instrument: Instrument,
    /// The changes that would help, if help is needed.
    pub cure: Cure,
    /// The same in words; empty if no help is needed.
    pub cure_words: String,
    /// Whether they were tried.
    pub is_cure_tried: bool,
    /// Whether it is the margin of a part of which a trial has found a fault, too.
    pub is_of_trial: bool,
    /// Name of what holds the body of a trial.
    holder: Option<String>,
    /// Stable ids of the bodies that limit a margin.
    limiting: Vec<u32>,
}

impl ForecastRow {
    /// The rows of a forecast of `simulation`, in the order of [`ForecastRow::arrange`].
    #[must_use]
    pub fn of(simulation: &Simulation, margins: &Margins, trial: &Trial) -> Vec<Self> {
        let mut rows = Self::of_trial(simulation, trial);
        rows.extend(Self::of_margins(simulation, margins));
        Self::arrange(&mut rows);
        rows
    }

    /// Sorts rows: faults first, those that grow before those that settle wrongly, those of margins before those of the trial. The cure of a margin becomes that of the trial, if the
    /// trial of its part has found a fault, too.
    pub fn arrange(rows: &mut [Self]) {
        let tried = rows.iter().filter_map(Self::tried);
        let tried: Vec<_> = tried.filter(|tried| tried.verdict.is_fault()).cloned().collect();
        for row in rows.iter_mut().filter(|row| row.is_fault() && row.margin().is_some()) {
            let is_of_row = |tried: &&Tried| {
                let mut limiting = row.limiting.iter();
                !row.limiting.is_empty()
                    && row.setting() == (tried.method, tried.substeps)
                    && limiting.all(|id| tried.ids.binary_search(id).is_ok())
            };
            let Some(tried) = tried.iter().find(is_of_row) else { continue };
            row.is_of_trial = true;
            if tried.is_done && (tried.is_searched || tried.cure != Cure::default()) {
                (row.cure, row.is_cure_tried) = (tried.cure, true);
                row.cure_words = tried_cure_in_words(tried);
            }
        }
        let is_trial = |row: &Self| row.is_fault() && row.tried().is_some();
        rows.sort_by_key(|row| (!row.is_fault(), row.settles_wrongly(), is_trial(row)));
    }

    /// The rows of margins.
    pub fn of_margins(simulation: &Simulation, margins: &Margins) -> Vec<Self> {
        let name =
            |body: Entity| simulation.id(body).map_or_else(String::new, |id| name(simulation, id));
        let row = |margin: &Margin| Self {
            limiting: margin.part.bodies().iter().filter_map(|body| simulation.id(*body)).collect(),
            ..Self::of_margin(*margin, name)
        };
        margins.list().iter().map(row).collect()
    }

    /// The rows of a trial.
    pub fn of_trial(simulation: &Simulation, trial: &Trial) -> Vec<Self> {
        let row = |tried| Self::of_tried(tried, |id| name(simulation, id));
        trial.found().into_iter().map(row).collect()
    }

    /// The row of a margin, with the names of bodies.
    #[must_use]
    pub fn of_margin(margin: Margin, name: impl Fn(Entity) -> String) -> Self {
        let pair = |[a, b]: [Entity; 2]| format!("{} - {}", name(a), name(b));
        let element = match margin.part {
            LimitingPart::Spring(ends) => format!("spring {}", pair(ends)),
            LimitingPart::Damper(ends) => format!("damper {}", pair(ends)),
            LimitingPart::Drag(body) => format!("drag on {}", name(body)),
            LimitingPart::Damping(body) => format!("damping of {}", name(body)),
            LimitingPart::MutualGravity(ends) => format!("mutual gravity {}", pair(ends)),
            LimitingPart::Well(number, body) => format!("well {number} at {}", name(body)),
            LimitingPart::Law(law, body) => format!("{} at {}", law.replace('_', " "), name(body)),
        };
        let needs_cure = margin.is_unstable() || margin.may_be_unstable();
        let cure = if needs_cure { cure_in_words(margin.cure) } else { String::new() };
        Self::new(element, Instrument::Margin(margin), cure)
    }

    fn of_tried(tried: Tried, name: impl Fn(u32) -> String) -> Self {
        let tells_cure = tried.verdict.is_fault() && tried.is_done;
        let cure = if tells_cure { tried_cure_in_words(&tried) } else { String::new() };
        let element = tried.body.map_or_else(|| tried.part.clone(), &name);
        let holder = tried.holder.map(name);
        Self { holder, ..Self::new(element, Instrument::Trial(tried), cure) }
    }

    /// The row of what one instrument found, before [`Self::arrange`] has seen the others.
    const fn new(element: String, instrument: Instrument, cure_words: String) -> Self {
        let (cure, is_cure_tried) = match &instrument {
            Instrument::Margin(margin) => (margin.cure, false),
            Instrument::Trial(tried) => (tried.cure, true),
        };
        Self {
            element,
            instrument,
            cure,
            cure_words,
            is_cure_tried,
            is_of_trial: false,
            holder: None,
            limiting: Vec::new(),
        }
    }

    /// Name of the instrument.
    #[must_use]
    pub const fn instrument(&self) -> &'static str {
        match self.instrument {
            Instrument::Margin(_) => "margin",
            Instrument::Trial(_) => "trial",
        }
    }

    /// Its margin, if it has one.
    #[must_use]
    pub const fn margin(&self) -> Option<&Margin> {
        match &self.instrument {
            Instrument::Margin(margin) => Some(margin),
            Instrument::Trial(_) => None,
        }
    }

    /// Its trial, if it has one.
    #[must_use]
    pub const fn tried(&self) -> Option<&Tried> {
        match &self.instrument {
            Instrument::Margin(_) => None,
            Instrument::Trial(tried) => Some(tried),
        }
    }

    /// Method and substeps of the bodies.
    #[must_use]
    pub fn setting(&self) -> (Method, Substepping) {
        match &self.instrument {
            Instrument::Margin(margin) => (margin.method, margin.substeps.into()),
            Instrument::Trial(tried) => (tried.method, tried.substeps),
        }
    }

    /// Whether it is a fault that is seen within a hundred turns, or may be.
    #[must_use]
    pub fn is_fault(&self) -> bool {
        match &self.instrument {
            Instrument::Margin(margin) => margin.is_reported(),
            Instrument::Trial(tried) => tried.verdict.is_fault(),
        }
    }

    /// Whether it is a fault, or grows slowly.
    #[must_use]
    pub fn is_listed(&self) -> bool {
        self.is_fault() || self.margin().is_some_and(Margin::is_unstable)
    }

    /// Whether it settles elsewhere than the truth, and nothing grows.
    #[must_use]
    pub const fn settles_wrongly(&self) -> bool {
        matches!(&self.instrument, Instrument::Trial(tried) if matches!(tried.verdict, Verdict::Wrong(_)))
    }

    /// The verdict, in short. A margin says nothing of laws that are not linear.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        match &self.instrument {
            Instrument::Margin(margin) if margin.is_unstable() => "unstable",
            Instrument::Margin(margin) if margin.may_be_unstable() => "at its limit",
            Instrument::Margin(margin) if margin.is_linear => "stable",
            Instrument::Margin(_) => "linearized",
            Instrument::Trial(tried) => match tried.verdict {
                Verdict::Thrown(_, excess) if !excess.is_gain() => "wrong",
                Verdict::Thrown(..) => "unstable",
                Verdict::Wrong(_) => "wrong",
                Verdict::Holds => "holds",
                Verdict::NotTried => "not tried",
            },
        }
    }

    /// The value of a margin with its symbol, or how far a trial looked.
    #[must_use]
    pub fn value(&self) -> String {
        match &self.instrument {
            Instrument::Margin(margin) => format!("{} {}", symbol(margin), value(margin)),
            Instrument::Trial(tried) => format!("{} s", digits(tried.seconds)),
        }
    }

    /// What was found, without the cure.
    #[must_use]
    pub fn finding(&self) -> String {
        match &self.instrument {
            Instrument::Margin(margin) => limit(margin),
            Instrument::Trial(tried) => self.trial(tried),
        }
    }

    /// The row in one line.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { element, cure_words, .. } = self;
        let cure = if cure_words.is_empty() { String::new() } else { format!("; {cure_words}") };
        match &self.instrument {
            Instrument::Margin(margin) => {
                format!(
                    "{element}: {} = {}, {}{cure}",
                    symbol(margin),
                    value(margin),
                    limit(margin)
                )
            }
            Instrument::Trial(tried) => {
                format!("{element}: {}{cure}; {}", self.trial(tried), tried_in_words(tried))
            }
        }
    }

    fn trial(&self, tried: &Tried) -> String {
        let method = tried.method.name();
        let holder = self.holder.as_deref().unwrap_or("what holds it");
        match tried.verdict {
            Verdict::Holds => format!("{method} holds"),
            Verdict::NotTried => "not tried: a truth for a few ticks is too much work".to_owned(),
            Verdict::Thrown(after, excess) => {
                let after = digits(after);
                match excess {
                    Excess::Speed(by) => format!(
                        "{method} throws it out within {after} s, at {} times the true speed",
                        times(by)
                    ),
                    Excess::Distance(by) => format!(
                        "{method} throws it out within {after} s, to {} times the true distance from {holder}",
                        times(by)
                    ),
                    Excess::Energy(by) => format!(
                        "{method} {} {} times the energy of the true motion within {after} s",
                        if by < 0.0 { "loses" } else { "gains" },
                        times(by.abs())
                    ),
                    Excess::Quarantined => {
                        format!("{method} makes it leave the range of numbers within {after} s")
                    }
                }
            }
            Verdict::Wrong(Settled::Velocity([least, most])) if most - least < 0.05 => {
                format!("{method} settles at {} of the true velocity", number(most, 2))
            }
            Verdict::Wrong(Settled::Velocity([least, most])) => format!(
                "{method} alternates between {} and {} of the true velocity",
                number(least, 2),
                number(most, 2)
            ),
            // Of the two bounds the one that is nearer to the truth: it settles at least as far off.
            Verdict::Wrong(Settled::Distance([least, most])) => format!(
                "{method} settles at {} of the true distance from {holder}",
                number(if most < 1.0 { most } else { least }, 2)
            ),
            Verdict::Wrong(Settled::Swings(by)) if by > 1.0 => {
                format!("{method} swings {} times too far or too fast", times(by))
            }
            Verdict::Wrong(Settled::Swings(_)) => {
                format!("{method} swings with too much energy")
            }
            Verdict::Wrong(Settled::Moving(by)) => {
                format!(
                    "{method} does not come to rest: {} of the largest true speed",
                    number(by, 2)
                )
            }
        }
    }

    /// The row as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let (method, substeps) = self.setting();
        let mut row = json!({
            "element": self.element,
            "instrument": self.instrument(),
            "method": method.name(),
            "substeps": substeps,
            "verdict": self.verdict(),
            "finding": self.finding(),
            "cure": self.cure_words,
        });
        match &self.instrument {
            Instrument::Margin(margin) => {
                row["value"] = json_number(margin.value);
                row["at_most"] = json_number(margin.at_most);
                row["limit"] = json_number(margin.limit);
                row["is_linear"] = json!(margin.is_linear);
                row["growth_per_s"] = json_number(margin.growth_per_s);
            }
            Instrument::Trial(tried) => {
                row["tried_s"] = json_number(tried.seconds);
                row["predictable_s"] = tried.predictable_s.map_or(Value::Null, json_number);
                row["bodies"] = json!(tried.bodies);
                row["of"] = json!(tried.of);
                row["after_s"] = match tried.verdict {
                    Verdict::Thrown(after, _) => json_number(after),
                    Verdict::Holds | Verdict::Wrong(_) | Verdict::NotTried => Value::Null,
                };
            }
        }
        row
    }
}

fn name(simulation: &Simulation, id: u32) -> String {
    simulation.scene.names.get(id).unwrap_or_default().into_owned()
}

/// How far a trial looked, and with which bodies.
#[must_use]
pub fn tried_in_words(tried: &Tried) -> String {
    let Tried { bodies, of, seconds, predictable_s, .. } = tried;
    let which = if bodies < of { format!(", {bodies} of {of} bodies") } else { String::new() };
    let until = match predictable_s {
        Some(until) => format!(", not predictable after {} s", digits(*until)),
        None => String::new(),
    };
    format!("tried {} s ahead{which}{until}", digits(*seconds))
}

fn times(by: f64) -> String {
    if by.is_finite() { digits(by) } else { "infinitely many".to_owned() }
}

/// The symbol of the value of a margin.
const fn symbol(margin: &Margin) -> &'static str {
    match margin.part {
        LimitingPart::Spring(_)
        | LimitingPart::Well(..)
        | LimitingPart::Law(..)
        | LimitingPart::MutualGravity(_) => "w h",
        LimitingPart::Damper(_) | LimitingPart::Drag(_) | LimitingPart::Damping(_) => "c h",
    }
}

/// The value, or the interval in which it is known to be.
fn value(margin: &Margin) -> String {
    let Margin { value, at_most, .. } = *margin;
    if margin.is_known() && !margin.may_be_unstable() {
        digits(value)
    } else {
        format!("{} to {}", digits(value), digits(at_most))
    }
}

fn limit(margin: &Margin) -> String {
    let method = margin.method.name();
    if margin.may_be_unstable() {
        let apart = (margin.limit / margin.value).max(margin.at_most / margin.limit) - 1.0;
        // Rounded up: the interval is not narrower than it says.
        let percent = format!("{:.1} %", (1000.0 * apart).ceil() / 10.0);
        return format!("within {percent} of the limit of {method}, {}", digits(margin.limit));
    }
    let linearized = if margin.is_linear { "" } else { ", linearized" };
    match margin.limit {
        0.0 if margin.is_unstable() => {
            format!("{method} is never stable here, {}", growth(margin.growth_per_s))
        }
        0.0 => format!("{method} is never stable here{linearized}"),
        limit if limit.is_infinite() => format!("{method} has no limit here{linearized}"),
        limit => format!("the limit of {method} is {}{linearized}", digits(limit)),
    }
}

/// Growth by `factor` per second, in words. Slow growth is given in percent, because the factor would round to 1.
#[must_use]
pub fn growth(factor: f64) -> String {
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

fn tried_cure_in_words(tried: &Tried) -> String {
    match tried.cure {
        Cure { substeps: None, error: None, method: None } if tried.is_searched => {
            "found no cure: no other method holds, and no number of substeps that can be tried"
                .to_owned()
        }
        Cure { substeps: None, error: None, method: None } => {
            "no cure was found in time".to_owned()
        }
        cure => cure_in_words(cure),
    }
}

fn cure_in_words(cure: Cure) -> String {
    let ways = [
        cure.substeps.map(|substeps| format!("{substeps} substeps")),
        cure.error.map(|error| format!("substeps chosen for {error:?} m")),
        cure.method.map(|method| method.name().to_owned()),
    ];
    let ways: Vec<_> = ways.into_iter().flatten().collect();
    if ways.is_empty() {
        let most = Substeps::MOST;
        return format!("found no cure: no other method, and no number up to {most} substeps");
    }
    format!("needs {}", ways.join(", or "))
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
