//! The cheapest method and step below an error, or the most accurate within a time, from what was measured.
//!
//! A choice is one point of the measured front for each part of a scene; nothing is interpolated.

use scene::Substepping;
use serde::{Deserialize, Serialize};

use crate::cost::{Accuracy, Cell, Cost, Errors, Setting, Study};

/// The requirement on a choice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// Largest distance of any body from the truth after any tick, m, above 0. The distance from the reference may be at most
    /// this minus the reference's own error.
    Error(f64),
    /// Most thread CPU time, ms, for 1/60 s of the scene; above 0.
    Budget(f64),
}

/// Unit of prices, each for 1/60 s of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Thread CPU time, ms.
    Milliseconds,
    /// Evaluations of all bodies together, including those of solvers; for studies without times.
    Evaluations,
}

/// A measured setting of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Method and substeps.
    pub setting: Setting,
    /// Largest distance of any of its bodies from the reference after any tick, m.
    pub error_m: f64,
    /// Root of the mean square of all these distances, m.
    pub rms_m: f64,
    /// What it costs.
    pub price: f64,
}

/// The choice for one part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartChoice {
    /// Name of the part.
    pub part: String,
    /// Bodies of it that can move.
    pub bodies: usize,
    /// The choice, a point of the measured front.
    pub pick: Point,
    /// Points of other methods whose cost is the same within the noise.
    pub ties: Vec<Point>,
    /// Error of the reference itself, m: smaller errors cannot be measured.
    pub reference_error_m: f64,
    /// Its part of the total, 0 to 1.
    pub share: f64,
    /// How many times longer the ticks could be with the error still below the goal, by the order of the method; at least 2. Only
    /// where one substep is more accurate than asked for: longer ticks are then the only way to save.
    pub longer_ticks: Option<f64>,
}

/// The next more accurate choice, and what it costs.
#[derive(Clone, Debug, PartialEq)]
pub struct NextChoice {
    /// The error that it stays below or reaches, m.
    pub error_m: f64,
    /// Its price, all parts together.
    pub total: f64,
    /// The rows that change, each with its new point.
    pub picks: Vec<(usize, Point)>,
}

/// A choice for every part of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// One row per part, in their order; at least one.
    pub rows: Vec<PartChoice>,
    /// Unit of all prices.
    pub unit: Unit,
    /// What all parts cost together.
    pub total: f64,
    /// Index of the row that costs most.
    pub dearest: usize,
    /// Index of the row with the largest upper bound on its error.
    pub limiting: usize,
    /// For an error, the cheapest choice for a tenth of it; for a budget, the cheapest one with a smaller largest
    /// error. `None` if none was measured, or its error is below that of the reference.
    pub next: Option<NextChoice>,
}

/// Why there is no choice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The scene has no part.
    #[error("no body of the scene can move, so there is no method to choose")]
    NothingMoves,
    /// Every setting of a part failed.
    #[error("{part}: no method finished at any step that was tried; raise step_hz")]
    NothingFinished {
        /// The name of the part.
        part: String,
    },
    /// No time was measured.
    #[error("no time was measured, so none can be promised; ask for an error")]
    NoTimes,
    /// The reference of a part is too uncertain to show that a setting reaches the error that is asked for.
    #[error(
        "{part}: the reference itself may be off by {reference_error_m:.1e} m, so that an error of {error_m:e} m cannot \
         be measured; give a larger error, or fewer seconds"
    )]
    Uncertain {
        /// The name of the part.
        part: String,
        /// The error asked for, m.
        error_m: f64,
        /// That of the reference, m.
        reference_error_m: f64,
    },
    /// No setting of a part is as accurate.
    #[error(
        "{part}: nothing reaches an error of {error_m:e} m: the best is {} at {} m; give a larger error",
        best.setting,
        above(best.error_m, *error_m)
    )]
    ErrorOutOfReach {
        /// The name of the part.
        part: String,
        /// The error asked for, m.
        error_m: f64,
        /// Its most accurate setting.
        best: Point,
    },
    /// No choice is as cheap.
    #[error(
        "nothing runs in {budget_ms:e} ms: the cheapest takes {least_ms:.2e} ms; give a larger budget"
    )]
    BudgetTooSmall {
        /// The time asked for, ms.
        budget_ms: f64,
        /// The time of the cheapest choice, ms.
        least_ms: f64,
    },
}

/// How many times longer ticks are proposed to be, at most: more than that would be a guess.
const MOST_TICK_STRETCH: f64 = 8.0;

/// A number with as many digits as show that it is above `bound`, two at least.
fn above(value: f64, bound: f64) -> String {
    let text = |digits: usize| format!("{value:.digits$e}");
    let is_above = |text: &String| text.parse::<f64>().is_ok_and(|shown| shown > bound);
    (1..=16).map(text).find(is_above).unwrap_or_else(|| text(16))
}

/// Chooses a method and substeps for each part, by its name and its study.
///
/// # Errors
/// If no measured choice meets the goal, or the reference is too uncertain to show it.
pub fn recommend(parts: &[(&str, &Study)], goal: Goal) -> Result<Recommendation, Refusal> {
    if parts.is_empty() {
        return Err(Refusal::NothingMoves);
    }
    let fronts =
        |unit| parts.iter().map(|(part, study)| Front::of(part, study, unit)).collect::<Vec<_>>();
    let (timed, counted) = (fronts(Unit::Milliseconds), fronts(Unit::Evaluations));
    let (unit, fronts) = if timed.iter().all(|front| !front.bounds.is_empty()) {
        (Unit::Milliseconds, timed)
    } else {
        (Unit::Evaluations, counted)
    };
    if let Some(front) = fronts.iter().find(|front| front.bounds.is_empty()) {
        return Err(Refusal::NothingFinished { part: front.part.to_owned() });
    }
    let picks = match goal {
        Goal::Error(error) => choose_for_error(&fronts, error)?,
        Goal::Budget(_) if unit == Unit::Evaluations => return Err(Refusal::NoTimes),
        Goal::Budget(budget) => choose_for_budget(&fronts, budget)?,
    };
    let next = match goal {
        Goal::Error(error) => {
            choose_for_error(&fronts, error / 10.0).ok().map(|next| (error / 10.0, next))
        }
        Goal::Budget(_) => next_more_accurate(&fronts, &picks),
    };
    let mut found = result(&fronts, &picks, next, unit);
    if let Goal::Error(error) = goal {
        found
            .rows
            .iter_mut()
            .zip(&fronts)
            .for_each(|(row, front)| row.longer_ticks = front.longer_ticks(&row.pick, error));
    }
    Ok(found)
}

/// A point, and those that tie with it.
type Pick = (Point, Vec<Point>);

/// The measured front of a part.
struct Front<'a> {
    part: &'a str,
    study: &'a Study,
    cost: Cost,
    /// Price of a cost of 1.
    price_per_cost: f64,
    /// The reference's own error, m.
    reference_error_m: f64,
    /// The bounds of its points.
    bounds: Vec<f64>,
}

impl<'a> Front<'a> {
    fn of(part: &'a str, study: &'a Study, unit: Unit) -> Self {
        // A frame of 60 a second.
        let (cost, price_per_cost) = match unit {
            Unit::Milliseconds => (Cost::RealTime, 1e3 / 60.0),
            Unit::Evaluations => (Cost::Evaluations, study.bodies.max(1) as f64 / 60.0),
        };
        let (_, reference_error_m) = study.truth.own_error();
        let mut front =
            Self { part, study, cost, price_per_cost, reference_error_m, bounds: Vec::new() };
        let points =
            study.front(Accuracy::Position, cost).into_iter().filter_map(|cell| front.point(cell));
        front.bounds = points.map(|point| front.bound(&point)).collect();
        front
    }

    fn point(&self, cell: &Cell) -> Option<Point> {
        let (price, errors) =
            (self.study.cost(cell, self.cost)? * self.price_per_cost, cell.errors()?);
        let Errors { position_m: error_m, position_rms_m: rms_m, .. } = errors;
        Some(Point { setting: cell.setting, error_m, rms_m, price })
    }

    /// An upper bound on the error of a point, m. Unlike in [`Study::error_bound`], an error below the reference's own counts as equal
    /// to it; so the bound is never below what is promised.
    const fn bound(&self, point: &Point) -> f64 {
        point.error_m.max(self.reference_error_m) + self.reference_error_m
    }

    /// How many times longer the ticks of a point may be for an error of `error`, m.
    fn longer_ticks(&self, point: &Point, error: f64) -> Option<f64> {
        let claims = point.setting.method.claims();
        let order = f64::from(claims.position_order.min(claims.order_with_velocity_laws));
        let times = ((error - self.reference_error_m) / point.error_m).powf(1.0 / order).floor();
        // The order says nothing about far longer ticks.
        let times = times.min(MOST_TICK_STRETCH);
        // An error near the reference's own says nothing about longer ticks.
        (point.setting.substeps == Substepping::Fixed(1)
            && point.error_m > 2.0 * self.reference_error_m
            && times >= 2.0)
            .then_some(times)
    }

    /// The cheapest point with an error of at most `error`.
    fn cheapest(&self, error: f64) -> Option<Pick> {
        let found = self.study.cheapest(Accuracy::Position, self.cost, error)?;
        let ties = found.ties.into_iter().filter_map(|cell| self.point(cell)).collect();
        Some((self.point(found.cell)?, ties))
    }

    /// The most accurate point.
    fn best(&self) -> Option<Point> {
        let front = self.study.front(Accuracy::Position, self.cost);
        front.last().and_then(|cell| self.point(cell))
    }
}

/// The cheapest choice with no error above `error`, m.
fn choose_for_error(fronts: &[Front<'_>], error: f64) -> Result<Vec<Pick>, Refusal> {
    let pick = |front: &Front<'_>| {
        let part = || front.part.to_owned();
        let best = front.best().ok_or_else(|| Refusal::NothingFinished { part: part() })?;
        front.cheapest(error).ok_or_else(|| {
            // A reference whose own error is NaN gives no bound.
            if best.error_m <= error
                || front.reference_error_m > error
                || front.reference_error_m.is_nan()
            {
                Refusal::Uncertain {
                    part: part(),
                    error_m: error,
                    reference_error_m: front.reference_error_m,
                }
            } else {
                Refusal::ErrorOutOfReach { part: part(), error_m: error, best }
            }
        })
    };
    fronts.iter().map(pick).collect()
}

/// The choice with the smallest largest error that costs at most `budget`, and the cheapest of those.
fn choose_for_budget(fronts: &[Front<'_>], budget: f64) -> Result<Vec<Pick>, Refusal> {
    let mut least = f64::INFINITY;
    for error in bounds(fronts) {
        let Some(choice) = choice(fronts, error) else { continue };
        least = total(&choice);
        if least <= budget {
            return Ok(choice);
        }
    }
    Err(Refusal::BudgetTooSmall { budget_ms: budget, least_ms: least })
}

/// The cheapest choice with a smaller largest error than `picks` have, and that error, m.
fn next_more_accurate(fronts: &[Front<'_>], picks: &[Pick]) -> Option<(f64, Vec<Pick>)> {
    let bound = |picks: &[Pick]| {
        let bounds = fronts.iter().zip(picks).map(|(front, (point, _))| front.bound(point));
        bounds.fold(0.0, f64::max)
    };
    let now = bound(picks);
    let next = choice(fronts, bounds(fronts).into_iter().rfind(|error| *error < now)?)?;
    Some((bound(&next), next))
}

/// The bounds of all points, ascending. The largest error of a choice is one of them, and they are few enough to try
/// each.
fn bounds(fronts: &[Front<'_>]) -> Vec<f64> {
    let mut bounds: Vec<f64> =
        fronts.iter().flat_map(|front| front.bounds.iter().copied()).collect();
    bounds.sort_by(f64::total_cmp);
    bounds.dedup();
    bounds
}

/// The cheapest point of each part with an error of at most `error`.
fn choice(fronts: &[Front<'_>], error: f64) -> Option<Vec<Pick>> {
    fronts.iter().map(|front| front.cheapest(error)).collect()
}

fn total(picks: &[Pick]) -> f64 {
    picks.iter().map(|(point, _)| point.price).sum()
}

fn result(
    fronts: &[Front<'_>],
    picks: &[Pick],
    next: Option<(f64, Vec<Pick>)>,
    unit: Unit,
) -> Recommendation {
    let sum = total(picks);
    let row = |(front, (pick, ties)): (&Front<'_>, &Pick)| PartChoice {
        part: front.part.to_owned(),
        bodies: front.study.bodies,
        pick: *pick,
        ties: ties.clone(),
        reference_error_m: front.reference_error_m,
        share: if sum > 0.0 { pick.price / sum } else { 0.0 },
        longer_ticks: None,
    };
    let rows: Vec<_> = fronts.iter().zip(picks).map(row).collect();
    let first_largest = |of: &dyn Fn(usize) -> f64| {
        (0..rows.len()).fold(0, |largest, i| if of(i) > of(largest) { i } else { largest })
    };
    let dearest = first_largest(&|i| rows[i].pick.price);
    let limiting = first_largest(&|i| fronts[i].bound(&rows[i].pick));
    let next_choice = |(error_m, next): (f64, Vec<Pick>)| {
        let total = total(&next);
        let points = next.into_iter().map(|(point, _)| point).enumerate();
        let changed = points.filter(|(i, point)| *point != rows[*i].pick);
        NextChoice { error_m, total, picks: changed.collect() }
    };
    let next = next.map(next_choice);
    Recommendation { unit, total: sum, dearest, limiting, next, rows }
}

#[cfg(test)]
mod tests;
