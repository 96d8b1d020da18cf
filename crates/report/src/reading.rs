//! What can be read from a study: which errors count, which methods compare at equal cost, what becomes of energy.

use lab::cost::{Accuracy, Cell, Cost, Drift, Failure, Outcome, Precision, Setting, Study};
use motion::Method;

use super::numbers::share;

/// Errors in words are those of positions, which is what one sees.
pub(crate) const SEEN: Accuracy = Accuracy::Position;

/// Costs that differ by less than this part are equal: rungs are a factor of two apart, and a start-up evaluation or two
/// is not what a comparison hangs on.
const EQUAL: f64 = 0.15;

/// Steps at which an error exceeds this part of the motion are too coarse for anything.
const USABLE: f64 = 0.1;

/// Methods that have cells of that precision, in the order of the table.
pub(crate) fn methods(study: &Study, precision: Precision) -> Vec<Method> {
    Method::ALL.into_iter().filter(|method| study.curve(*method, precision).next().is_some()).collect()
}

/// Whether methods can be ranked at all.
pub(crate) fn ranks(study: &Study) -> bool {
    moves(study) && finished(study) && !reference_uncertain(study)
}

/// Whether any run in double precision went through.
pub(crate) fn finished(study: &Study) -> bool {
    study.in_double().any(|cell| cell.errors().is_some())
}

/// Whether the truth itself is too uncertain to tell usable runs apart.
pub(crate) fn reference_uncertain(study: &Study) -> bool {
    let (_, own_m) = study.truth.own_error();
    own_m.is_nan() || 10.0 * own_m > USABLE * study.position_scale_m
}

/// Whether any body moves at all.
pub(crate) fn moves(study: &Study) -> bool {
    let is_off = |cell: &Cell| cell.errors().is_none_or(|errors| errors.relative > 0.0);
    study.velocity_scale_m_s > 0.0 || study.cells.iter().any(is_off)
}

/// Whether an error is above the noise floor: round-off and the truth's own error.
fn above_noise(study: &Study, cell: &Cell, error: f64) -> bool {
    error > study.trusted(cell, SEEN)
}

/// Whether the positions of a run that went through are near enough to the truth to be of use.
pub(crate) fn usable(study: &Study, cell: &Cell) -> bool {
    cell.errors().is_some_and(|errors| errors.position_m <= USABLE * study.position_scale_m)
}

/// Two methods at one cost.
pub(crate) struct Round<'a> {
    /// Evaluations of one body per simulated second.
    pub evaluations: f64,
    /// Cell of the one method.
    pub first: &'a Cell,
    /// Cell of the other.
    pub second: &'a Cell,
}

impl Round<'_> {
    /// The error of the second over that of the first, where both went through and either is above the noise floor.
    pub(crate) fn factor(&self, study: &Study) -> Option<f64> {
        let (first, second) = (study.error(self.first, SEEN)?, study.error(self.second, SEEN)?);
        if !above_noise(study, self.first, first) && !above_noise(study, self.second, second) {
            return None;
        }
        let factor = second / first;
        (factor.is_finite() && factor > 0.0).then_some(factor)
    }
}

/// Every rung of `first` beside the rung of `second` that takes as many evaluations.
pub(crate) fn rounds(study: &Study, first: Method, second: Method) -> Vec<Round<'_>> {
    let evaluations = |cell| place(study, cell, Cost::Evaluations).filter(|cost| *cost > 0.0);
    let near = |at: f64| {
        study
            .curve(second, Precision::F64)
            .filter_map(|cell| Some((cell, (evaluations(cell)? / at).ln().abs())))
            .filter(|(_, distance)| *distance < EQUAL)
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    study
        .curve(first, Precision::F64)
        .filter_map(|cell| {
            let evaluations = evaluations(cell)?;
            Some(Round { evaluations, first: cell, second: near(evaluations)?.0 })
        })
        .collect()
}

/// Whether no step of a method can be told from the truth.
pub(crate) fn exact(study: &Study, method: Method) -> bool {
    let mut cells = study.curve(method, Precision::F64).peekable();
    cells.peek().is_some()
        && cells.all(|cell| study.error(cell, SEEN).is_some_and(|error| !above_noise(study, cell, error)))
}

/// What the table claims of the order of positions. Methods that take more evaluations under laws of velocity show by
/// that whether the scene has such laws; where none of them was run, it is not known.
pub(crate) fn claimed_orders(study: &Study, method: Method) -> Vec<u32> {
    let claims = method.claims();
    let (plain, with_velocity) = (claims.position_order, claims.order_with_velocity_laws);
    match velocity_laws(study) {
        Some(true) => vec![with_velocity],
        Some(false) => vec![plain],
        None if plain == with_velocity => vec![plain],
        None => vec![plain, with_velocity],
    }
}

fn velocity_laws(study: &Study) -> Option<bool> {
    let telling =
        |method: &Method| method.claims().evaluations_with_velocity_laws > method.claims().evaluations;
    let method = Method::ALL
        .into_iter()
        .find(|method| telling(method) && methods(study, Precision::F64).contains(method))?;
    let cell = study.curve(method, Precision::F64).filter(|cell| cell.errors().is_some()).last()?;
    let steps = study.step_hz * f64::from(cell.setting.substeps);
    let a_step = study.cost(cell, Cost::Evaluations)? / steps;
    let claims = method.claims();
    Some(a_step > 0.5 * f64::from(claims.evaluations + claims.evaluations_with_velocity_laws))
}

/// Where a cell stands on an axis of costs. A run that failed stopped counting when it did: it would have cost what its
/// method claims.
pub(crate) fn place(study: &Study, cell: &Cell, cost: Cost) -> Option<f64> {
    let counted = study.cost(cell, cost);
    if cost != Cost::Evaluations || cell.errors().is_some() {
        return counted;
    }
    let claims = cell.setting.method.claims();
    let a_step = if velocity_laws(study) == Some(true) {
        claims.evaluations_with_velocity_laws
    } else {
        claims.evaluations
    };
    let claimed = f64::from(a_step) / study.step_s(cell.setting);
    counted.map(|counted| counted.max(claimed))
}

/// The setting of a curve with the least error, and whether finer steps were run that are worse by a fifth or more.
pub(crate) fn floor(study: &Study, method: Method, precision: Precision) -> Option<(&Cell, f64, bool)> {
    let points: Vec<_> =
        study.curve(method, precision).filter_map(|cell| Some((cell, study.error(cell, SEEN)?))).collect();
    let (best, least) = points.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let worse = points
        .iter()
        .any(|(cell, error)| cell.setting.substeps > best.setting.substeps && *error > 1.2 * least);
    Some((best, least, worse))
}

/// What became of energy, in words.
pub(crate) fn fate(drift: &Drift) -> String {
    let Some(largest) = drift.largest else { return "failed".to_owned() };
    if largest < 1e-11 {
        return "round-off".to_owned();
    }
    let Some((end, residual)) = drift.series.last().copied() else { return "failed".to_owned() };
    if residual < -0.5 {
        return "most of it lost".to_owned();
    }
    let peak = |later: bool| {
        let part = drift.series.iter().filter(|(time, _)| (*time > 0.5 * end) == later);
        part.map(|(_, residual)| residual.abs()).fold(0.0, f64::max)
    };
    let (early, late) = (peak(false), peak(true));
    // Samples that keep step with the motion miss its peaks, and then say nothing about growth.
    let seen = late > 0.5 * largest;
    if seen && early > 0.0 && late > 1.3 * early {
        format!("grows as t^{:.1} to {}", (late / early).log2(), share(largest, 2))
    } else if largest > 0.5 {
        // Relative to what it became: it cannot grow much beyond.
        "most of it invented".to_owned()
    } else {
        format!("within {}", share(largest, 2))
    }
}

/// Failed runs of one method in one precision, for one kind of reason.
pub(crate) struct FailedRuns<'a> {
    /// The method.
    pub method: Method,
    /// Its precision.
    pub precision: Precision,
    /// The substeps of each, and its reason.
    pub runs: Vec<(u32, &'a Failure)>,
}

impl FailedRuns<'_> {
    /// The substeps of all.
    pub(crate) fn substeps(&self) -> Vec<String> {
        self.runs.iter().map(|(substeps, _)| format!("x {substeps}")).collect()
    }

    /// The reason of all.
    pub(crate) fn why(&self) -> String {
        let of = |failure: &&Failure| match failure {
            Failure::Quarantined { tick, .. } => *tick,
            Failure::Unconverged { steps } => *steps,
            _ => 0,
        };
        let failures = || self.runs.iter().map(|(_, failure)| *failure);
        match (failures().min_by_key(of), failures().max_by_key(of)) {
            (Some(Failure::Unconverged { steps: least }), Some(Failure::Unconverged { steps: most }))
                if least < most =>
            {
                format!("{least} to {most} steps did not converge")
            }
            (Some(first @ Failure::Quarantined { .. }), _) if self.runs.len() > 1 => {
                format!("bodies were quarantined; the first: {first}")
            }
            (Some(first), _) => first.to_string(),
            (None, _) => String::new(),
        }
    }
}

/// Failed runs by method, precision and kind of reason, in the order of the cells.
pub(crate) fn failures(study: &Study) -> Vec<FailedRuns<'_>> {
    let mut groups: Vec<FailedRuns<'_>> = Vec::new();
    for cell in study.cells.iter().filter(|cell| cell.is_run()) {
        let Outcome::Failed(failure) = &cell.outcome else { continue };
        let Setting { method, precision, substeps } = cell.setting;
        let alike = |group: &&mut FailedRuns<'_>| {
            let kind = |failure: &Failure| std::mem::discriminant(failure);
            (group.method, group.precision) == (method, precision)
                && group.runs.iter().all(|(_, other)| kind(other) == kind(failure))
        };
        match groups.iter_mut().find(alike) {
            Some(group) => group.runs.push((substeps, failure)),
            None => groups.push(FailedRuns { method, precision, runs: vec![(substeps, failure)] }),
        }
    }
    groups
}
