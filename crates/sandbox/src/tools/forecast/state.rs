//! What is foretold of a session: which steps are too long, by the names of the scene.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use motion::clock::FrameTime;
use motion::forecast::{Forecast, LimitingPart, Margin};
use motion::groups::Groups;
use motion::{Damping, Method, Substeps, TimeStep};
use scene::StepKind;

use crate::app::session::Session;
use crate::app::ui::{Panel, Topic};

/// How long a forecast is shown before it is made anew, s: speeds and distances change all the time.
const FRESH_S: f64 = 0.25;

/// The same for large nets, of which a forecast takes a frame.
const FRESH_LARGE_S: f64 = 2.0;
const LARGE_NET: usize = 20_000;

/// What grows by less than this factor in a second, and in a tick, is listed and not told: Runge-Kutta 2 is never quite
/// stable.
const TOLD_GROWTH: f64 = 1.01;

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
            LimitingPart::Spring(_) | LimitingPart::Well(..) | LimitingPart::Law(..) => "w h",
            LimitingPart::Damper(_) | LimitingPart::Drag(_) | LimitingPart::Damping(_) => "c h",
        }
    }

    /// The value, or the interval that is known of it.
    #[must_use]
    pub(crate) fn value(&self) -> String {
        let Margin { value, at_most, .. } = self.margin;
        if self.margin.is_known() {
            digits(value)
        } else {
            format!("{} to {}", digits(value), digits(at_most))
        }
    }

    /// One line for it.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { margin, element, cure } = self;
        let (symbol, value, method) = (self.symbol(), self.value(), margin.method.name());
        let limit = match margin.limit {
            0.0 => format!("{method} is never stable here"),
            limit if limit.is_infinite() => format!("{method} has no limit here"),
            limit => format!("the limit of {method} is {}", digits(limit)),
        };
        let grows = match margin.growth_per_s {
            _ if !margin.is_unstable || margin.limit > 0.0 => String::new(),
            growth if growth.is_infinite() => ", grows without end".to_owned(),
            growth => format!(", grows {} times a second", digits(growth)),
        };
        let cure = if cure.is_empty() { String::new() } else { format!("; {cure}") };
        format!("{element}: {symbol} = {value}, {limit}{grows}{cure}")
    }
}

/// Four digits.
pub(crate) fn digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e4).contains(&size) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a power of ten from -3 to 3"
        )]
        let decimals = (3.0 - size.log10().floor()) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else if size.is_infinite() {
        "infinite".to_owned()
    } else {
        format!("{value:.3e}")
    }
}

fn cure_in_words(margin: &Margin) -> String {
    if !margin.is_unstable {
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
struct Settings {
    method: Method,
    step: f64,
    substeps: u32,
    damping: Option<Damping>,
    /// Groups, springs in them and bodies.
    structure: [usize; 4],
}

/// The forecast that is shown.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    of: Settings,
    /// Time since it was made, s.
    age: f64,
    rows: Vec<ForecastRow>,
    springs: HashMap<[Entity; 2], f64>,
}

fn in_order([a, b]: [Entity; 2]) -> [Entity; 2] {
    if a < b { [a, b] } else { [b, a] }
}

impl Session {
    /// How far everything is from instability as it is now, the worst first.
    #[must_use]
    pub fn forecast(&mut self) -> Vec<ForecastRow> {
        let forecast = Forecast::of(&mut self.sim.world, self.sim.stepper.method());
        self.rows_of(&forecast)
    }

    fn rows_of(&self, forecast: &Forecast) -> Vec<ForecastRow> {
        let row = |margin: &Margin| ForecastRow {
            margin: *margin,
            element: self.part_name(margin.part),
            cure: cure_in_words(margin),
        };
        forecast.margins().iter().map(row).collect()
    }

    fn part_name(&self, part: LimitingPart) -> String {
        let name = |body: Entity| self.name(body);
        match part {
            LimitingPart::Spring([a, b]) => format!("spring {} - {}", name(a), name(b)),
            LimitingPart::Damper([a, b]) => format!("damper {} - {}", name(a), name(b)),
            LimitingPart::Drag(body) => format!("drag on {}", name(body)),
            LimitingPart::Damping(body) => format!("damping of {}", name(body)),
            LimitingPart::Well(number, body) => format!("well {number} at {}", name(body)),
            LimitingPart::Law(law, body) => format!("{} at {}", law.replace('_', " "), name(body)),
        }
    }

    /// Looks ahead at the start of a scene, whose frames are to have that length, s: what would grow is kept for the
    /// summary; what would soon be seen is told, and given here.
    pub fn foretell(&mut self, frame: f64) -> Vec<ForecastRow> {
        if self.sim.scene.step == StepKind::Frame {
            self.sim.world.insert_resource(TimeStep(frame));
        }
        let tick = self.sim.world.resource::<TimeStep>().0;
        let grows = |row: &ForecastRow| row.margin.is_unstable;
        self.foretold = self.forecast().into_iter().filter(grows).collect();
        let is_seen = |row: &&ForecastRow| {
            let a_second = row.margin.growth_per_s;
            a_second.max(a_second.powf(tick)) >= TOLD_GROWTH
        };
        let told: Vec<_> = self.foretold.iter().filter(is_seen).cloned().collect();
        if let Some(worst) = told.first() {
            self.ui.notice(Topic::Forecast, format!("unstable: {}", worst.line()));
        }
        told
    }

    /// What would grow when it was looked at last, at the start of the scene.
    #[must_use]
    pub fn foretold(&self) -> &[ForecastRow] {
        &self.foretold
    }

    /// Keeps the forecast of an open panel fresh.
    pub(crate) fn look_ahead(&mut self, time: FrameTime) {
        if !self.ui.shows(Panel::Forecast) {
            self.shown_forecast = None;
            return;
        }
        let of = self.forecast_settings();
        let fresh = if of.structure[1] > LARGE_NET { FRESH_LARGE_S } else { FRESH_S };
        if let Some(shown) = &mut self.shown_forecast {
            shown.age += time.length();
            if shown.of == of && shown.age < fresh {
                return;
            }
        }
        let forecast = Forecast::with_springs(&mut self.sim.world, self.sim.stepper.method());
        let mut springs = HashMap::new();
        for spring in forecast.springs() {
            let ratio: &mut f64 = springs.entry(in_order(spring.ends)).or_default();
            *ratio = ratio.max(spring.ratio);
        }
        let rows = self.rows_of(&forecast);
        self.shown_forecast = Some(Shown { of, age: 0.0, rows, springs });
    }

    fn forecast_settings(&self) -> Settings {
        let groups = self.sim.world.get_resource::<Groups>();
        Settings {
            method: self.sim.method(),
            step: self.sim.world.resource::<TimeStep>().0,
            substeps: self.sim.world.get_resource::<Substeps>().map_or(1, |substeps| substeps.0),
            damping: self.sim.world.get_resource::<Damping>().copied(),
            structure: groups.map_or([0; 4], |groups| {
                [groups.len(), groups.springs(), groups.bodies(), self.frozen().len()]
            }),
        }
    }

    /// Lets the list be made again in the next frame.
    pub(crate) fn outdate_forecast(&mut self) {
        if let Some(shown) = &mut self.shown_forecast {
            shown.age = f64::INFINITY;
        }
    }

    /// The forecast of the open panel, the worst first.
    #[must_use]
    pub fn shown_forecast(&self) -> Option<&[ForecastRow]> {
        self.shown_forecast.as_ref().map(|shown| &shown.rows[..])
    }

    /// Of a spring between two bodies, while the panel is open, how much of its limit is taken: 0 for one that is in no
    /// group.
    pub(crate) fn spring_ratio(&self, ends: [Entity; 2]) -> Option<f64> {
        self.shown_forecast.as_ref().map(|shown| shown.springs.get(&in_order(ends)).copied().unwrap_or(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_at_most_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (2.0, "2"),
            (166.666, "166.7"),
            (0.012_345_6, "0.01235"),
            (9_999.6, "10000"),
            (12_345.6, "1.235e4"),
            (1e-5, "1.000e-5"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
