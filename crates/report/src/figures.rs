//! The figures of a study.

mod cost;
mod curves;
mod drift;
mod growth;
mod step;

use lab::cost::{Accuracy, Cost, Machine, Study};

use self::curves::run_cells;
use super::chart::Drawing;

/// The kind of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Error against step.
    Step(Accuracy),
    /// Error against cost.
    Cost(Accuracy, Cost),
    /// Energy over time; `true` for the long runs.
    Drift(bool),
    /// Time of a step per body against the number of bodies.
    Growth,
}

impl Kind {
    /// Name of the file without the subject and the ending.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Step(accuracy) => format!("error-step-{}", accuracy_name(accuracy)),
            Self::Cost(accuracy, cost) => {
                format!("error-cost-{}-{}", cost_name(cost), accuracy_name(accuracy))
            }
            Self::Growth => "growth".to_owned(),
            Self::Drift(long) => format!("energy-{}", if long { "long" } else { "short" }),
        }
    }
}

/// The errors that are drawn: that of positions, which one sees, and the one by which methods are usually compared.
pub(crate) const ACCURACIES: [Accuracy; 2] = [Accuracy::Position, Accuracy::Relative];

/// Costs that were measured for any cell of a study.
pub(crate) fn costs(study: &Study) -> Vec<Cost> {
    let measured = |cost: &Cost| run_cells(study).any(|cell| study.cost(cell, *cost).is_some());
    Cost::ALL.into_iter().filter(measured).collect()
}

/// All figures of a study that have anything to show.
pub(crate) fn figures(study: &Study, machine: &Machine) -> Vec<(Kind, Drawing)> {
    let mut kinds = Vec::new();
    if run_cells(study).next().is_some() {
        kinds.extend(ACCURACIES.map(Kind::Step));
        for cost in costs(study) {
            kinds.extend(ACCURACIES.map(|accuracy| Kind::Cost(accuracy, cost)));
        }
    }
    kinds.extend([Kind::Growth, Kind::Drift(false), Kind::Drift(true)]);
    let drawing = |kind| match kind {
        Kind::Step(accuracy) => Some(step::figure(study, accuracy)),
        Kind::Cost(accuracy, cost) => Some(cost::figure(study, accuracy, cost)),
        Kind::Growth => growth::figure(study, machine),
        Kind::Drift(long) => drift::figure(study, long),
    };
    kinds.into_iter().filter_map(|kind| Some((kind, drawing(kind)?))).collect()
}

/// Part of the name of a file, and class of a figure on a page.
pub(crate) const fn accuracy_name(accuracy: Accuracy) -> &'static str {
    match accuracy {
        Accuracy::Relative => "relative",
        Accuracy::Position => "position",
        Accuracy::Velocity => "velocity",
    }
}

/// Part of the name of a file, and class of a figure on a page.
pub(crate) const fn cost_name(cost: Cost) -> &'static str {
    match cost {
        Cost::Evaluations => "evaluations",
        Cost::Time => "time",
        Cost::Arithmetic => "arithmetic",
        Cost::RealTime => "real-time",
    }
}
