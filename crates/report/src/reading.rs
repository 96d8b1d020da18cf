//! What can be read from a study: which errors count, which methods compare at equal cost, what becomes of energy.

use lab::cost::{Accuracy, Cell, Cost, Drift, EnergyScale, Failure, Outcome, Precision, Setting, Study};
use motion::Method;

use super::numbers::{fold, share};

/// Errors in words are those of positions, which is what one sees.
pub(crate) const SEEN: Accuracy = Accuracy::Position;

/// Costs that differ by less than this part are equal: rungs are a factor of two apart, and a start-up evaluation or two
/// is not what a comparison hangs on.
const EQUAL: f64 = 0.15;

/// Methods that have cells of that precision, in the order of the table.
pub(crate) fn methods(study: &Study, precision: Precision) -> Vec<Method> {
    Method::ALL.into_iter().filter(|method| study.curve(*method, precision).next().is_some()).collect()
}

/// Whether methods can be ranked at all.
pub(crate) fn ranks(study: &Study) -> bool {
    moves(study) && finished(study) && !study.is_uncertain()
}

/// Whether any run in double precision went through.
pub(crate) fn finished(study: &Study) -> bool {
    study.in_double().any(|cell| cell.errors().is_some())
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

/// What became of energy, in words, and of what the numbers are parts.
pub(crate) fn fate(drift: &Drift) -> String {
    let (words, whole) = fate_and_whole(drift);
    format!("{words} {whole}").trim_end().to_owned()
}

/// The same where something else says of what the numbers are parts.
pub(crate) fn short_fate(drift: &Drift) -> String {
    fate_and_whole(drift).0
}

fn fate_and_whole(drift: &Drift) -> (String, &'static str) {
    let Some(largest) = drift.largest else { return ("failed".to_owned(), "") };
    if largest < 1e-11 {
        return ("round-off".to_owned(), "");
    }
    let Some((_, residual)) = drift.series.last().copied() else { return ("failed".to_owned(), "") };
    let of = match drift.scale {
        EnergyScale::Start => "of the energy at the start",
        EnergyScale::PeakKinetic => "of the peak kinetic energy",
    };
    let part = share(largest, 2);
    let words = match growth(drift, largest) {
        _ if residual < -0.5 => format!("loses {part}"),
        Some(Growth::Exponential) => {
            let times = fold(1.0 + residual / drift.start);
            return (format!("grows exponentially to {times} times"), "the energy at the start");
        }
        Some(Growth::Power(power)) => format!("grows as t^{power:.1} to {part}"),
        Some(Growth::Other) => format!("grows to {part}"),
        None if largest > 0.1 => format!("varies by up to {part}"),
        None => format!("within {part}"),
    };
    (words, of)
}

/// How a residual of energy grows.
enum Growth {
    /// The energy is the exponential of the time.
    Exponential,
    /// The residual is a power of the time.
    Power(f64),
    /// Neither fits.
    Other,
}

/// Mean deviation of the logarithm of a residual up to which a curve fits it.
const FITS: f64 = 0.3;

/// Part of the energy at the start from which on an exponential differs from a line.
const BENDS: f64 = 0.3;

/// How the largest residual so far grows; `None` if it does not.
fn growth(drift: &Drift, largest: f64) -> Option<Growth> {
    let (end, _) = drift.series.last()?;
    let mut so_far = 0.0_f64;
    let envelope = drift.series.iter().map(|(time, residual)| {
        so_far = so_far.max(residual.abs());
        (*time, so_far)
    });
    // A run settles before it grows.
    let points: Vec<_> = envelope.filter(|(time, so_far)| *time > 0.1 * end && *so_far > 0.0).collect();
    let (_, early) = points.iter().rfind(|(time, _)| *time <= 0.5 * end)?;
    // Samples that keep step with the motion miss its peaks, and then say nothing about growth.
    if so_far <= 0.5 * largest || so_far <= 1.3 * early {
        return None;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|(time, _)| time.ln()), mean(&|(_, size)| size.ln()));
    let power =
        mean(&|(time, size)| (time.ln() - x) * (size.ln() - y)) / mean(&|(time, _)| (time.ln() - x).powi(2));
    let off_power = mean(&|(time, size)| (size.ln() - y - power * (time.ln() - x)).abs());
    let start = drift.start;
    let off_exponential = if start > 0.0 && so_far > BENDS * start {
        let rate = mean(&|(time, size)| time * (size / start).ln_1p()) / mean(&|(time, _)| time * time);
        mean(&|(time, size)| (size.ln() - (start * (rate * time).exp_m1()).ln()).abs())
    } else {
        f64::INFINITY
    };
    Some(match off_power.min(off_exponential) {
        off if off > FITS => Growth::Other,
        off if off < off_power => Growth::Exponential,
        _ => Growth::Power(power),
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn drift(scale: EnergyScale, start: f64, residual: impl Fn(f64) -> f64) -> Drift {
        let series: Vec<_> = (1..=200).map(|i| f64::from(i) / 20.0).map(|t| (t, residual(t))).collect();
        Drift {
            setting: Setting { method: Method::ExplicitEuler, substeps: 1, precision: Precision::F64 },
            long: false,
            simulated_s: 10.0,
            scale,
            start,
            largest: series.iter().map(|(_, residual)| residual.abs()).reduce(f64::max),
            series,
        }
    }

    #[test]
    fn an_exponential_growth_is_called_one_and_shares_say_of_what() {
        // The energy grows by 162 %, to which the peak kinetic energy comes near.
        let rate = 2.62_f64.ln() / 10.0;
        let grown = drift(EnergyScale::PeakKinetic, 0.4, |t| 0.4 * (rate * t).exp_m1());
        assert_eq!(fate(&grown), "grows exponentially to 2.6 times the energy at the start");
        assert_eq!(short_fate(&grown), "grows exponentially to 2.6 times");
        // An energy of 0 at the start is no measure.
        let from_nothing = Drift { start: 0.0, ..grown };
        assert!(fate(&from_nothing).ends_with("% of the peak kinetic energy"), "{}", fate(&from_nothing));
        let line = drift(EnergyScale::Start, 1.0, |t| 1e-3 * t);
        assert_eq!(fate(&line), "grows as t^1.0 to 1 % of the energy at the start");
        let root = drift(EnergyScale::PeakKinetic, -0.5, |t| 1e-3 * t.sqrt());
        assert_eq!(fate(&root), "grows as t^0.5 to 0.32 % of the peak kinetic energy");
        let swing = drift(EnergyScale::Start, -1.0, |t| 1e-3 * (7.0 * t).sin());
        assert_eq!(fate(&swing), "within 0.1 % of the energy at the start");
        assert_eq!(short_fate(&swing), "within 0.1 %");
        let jump = drift(EnergyScale::Start, 1.0, |t| if t > 8.0 { 0.2 } else { 1e-6 });
        assert_eq!(fate(&jump), "grows to 20 % of the energy at the start");
        let lost = drift(EnergyScale::Start, 1.0, |t| (-t).exp_m1());
        assert_eq!(fate(&lost), "loses 100 % of the energy at the start");
    }
}
