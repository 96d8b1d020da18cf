//! Comparisons of the methods of a study: at equal evaluations, and by the order that they show.

use motion::Method;
use scene::Substepping;

use super::front::{Accuracy, Cost};
use super::record::{Cell, Failure, Outcome, Phase, Setting, Study};

/// The kind of error by which methods are compared: that of positions, which a person sees.
pub const SEEN: Accuracy = Accuracy::Position;

/// Costs that differ by less than this part are equal: rungs are a factor of two apart, and one or two start-up
/// evaluations do not decide a comparison.
const EQUAL: f64 = 0.15;

/// Largest difference between a fitted and a claimed order that counts as agreement.
const OTHER_ORDER: f64 = 0.25;

/// Two methods at one cost.
#[derive(Clone, Copy, Debug)]
pub struct Round<'a> {
    /// Evaluations of one body per simulated second.
    pub evaluations: f64,
    /// The cell with the smaller error.
    pub better: &'a Cell,
    /// The cell with the larger error.
    pub worse: &'a Cell,
    /// Ratio of the larger error to the smaller one.
    pub times: f64,
}

/// Two methods at equal evaluations, over all useful steps.
#[derive(Clone, Copy, Debug)]
pub struct Contest<'a> {
    /// The round with the coarsest steps.
    pub coarse: Round<'a>,
    /// The round with the finest steps, if there is more than one.
    pub fine: Option<Round<'a>>,
    /// Whether one method is the better one in every round.
    pub one_wins: bool,
}

/// The order that the errors of a method show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownOrder {
    /// The slope of its errors against the step, in logarithms.
    pub shows: f64,
    /// The order that the table of methods claims, if it differs.
    pub claimed: Option<u32>,
}

/// The errors of all methods at equal evaluations.
#[derive(Clone, Debug, PartialEq)]
pub struct EqualCost {
    /// Evaluations per body per simulated second.
    pub evaluations: f64,
    /// The error of each of [`Study::methods`], m.
    pub errors_m: Vec<Option<f64>>,
    /// The smallest of these errors, m.
    pub least_m: f64,
}

/// Failed runs of one method, for one kind of reason.
#[derive(Clone, Debug)]
pub struct FailedRuns<'a> {
    /// The method.
    pub method: Method,
    /// The substeps of each run, and why it failed.
    pub runs: Vec<(Substepping, &'a Failure)>,
}

impl Phase {
    /// How late the run is, s; `None` if its distance from the path of the closed form exceeds the size of the
    /// motion.
    pub fn known_late_s(&self) -> Option<f64> {
        (self.off_path < 1.0).then_some(self.late_s)
    }
}

impl Study {
    /// Methods that have cells, in the order of the table.
    pub fn methods(&self) -> Vec<Method> {
        Method::ALL.into_iter().filter(|method| self.curve(*method).next().is_some()).collect()
    }

    /// Whether methods can be ranked at all.
    pub fn ranks(&self) -> bool {
        self.moves() && self.has_finished() && !self.is_uncertain()
    }

    /// Whether any run finished.
    pub fn has_finished(&self) -> bool {
        self.cells.iter().any(|cell| cell.errors().is_some())
    }

    /// Whether any body moves at all.
    pub fn moves(&self) -> bool {
        let is_off = |cell: &Cell| cell.errors().is_none_or(|errors| errors.relative > 0.0);
        self.velocity_scale_m_s > 0.0 || self.cells.iter().any(is_off)
    }

    /// Whether an error is above the noise floor: round-off and the truth's own error.
    fn above_noise(&self, cell: &Cell, error: f64) -> bool {
        error > self.trusted(cell, SEEN)
    }

    /// Whether the errors of a method are below the noise floor at every step.
    pub fn is_exact(&self, method: Method) -> bool {
        let mut cells = self.curve(method).peekable();
        cells.peek().is_some()
            && cells.all(|cell| {
                self.error(cell, SEEN).is_some_and(|error| !self.above_noise(cell, error))
            })
    }

    /// Two methods at equal evaluations, over all rounds in which their errors can be compared; `None` if there is no
    /// such round.
    pub fn contest(&self, first: Method, second: Method) -> Option<Contest<'_>> {
        let rounds = self.rounds(first, second);
        let (coarse, fine) = (*rounds.first()?, *rounds.last()?);
        let winner = |round: &Round<'_>| round.better.setting.method;
        Some(Contest {
            coarse,
            fine: (rounds.len() > 1).then_some(fine),
            one_wins: rounds.iter().all(|round| winner(round) == winner(&coarse)),
        })
    }

    /// Pairs every rung of `first` with the rung of `second` that takes as many evaluations.
    fn rounds(&self, first: Method, second: Method) -> Vec<Round<'_>> {
        let evaluations =
            |cell| self.cost_or_claim(cell, Cost::Evaluations).filter(|cost| *cost > 0.0);
        let near = |at: f64| {
            self.curve(second)
                .filter_map(|cell| Some((cell, (evaluations(cell)? / at).ln().abs())))
                .filter(|(_, distance)| *distance < EQUAL)
                .min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let round = |cell| {
            let evaluations = evaluations(cell)?;
            self.round(evaluations, cell, near(evaluations)?.0)
        };
        self.curve(first).filter_map(round).collect()
    }

    /// Compares two cells at one cost, if both finished, one of them is usable and one is above the noise floor.
    fn round<'a>(&self, evaluations: f64, first: &'a Cell, second: &'a Cell) -> Option<Round<'a>> {
        let errors = (self.error(first, SEEN)?, self.error(second, SEEN)?);
        let is_useful = self.is_usable(first) || self.is_usable(second);
        if !is_useful || !self.above_noise(first, errors.0) && !self.above_noise(second, errors.1) {
            return None;
        }
        let factor = errors.1 / errors.0;
        let (better, worse) = if factor > 1.0 { (first, second) } else { (second, first) };
        let times = factor.max(factor.recip());
        (factor.is_finite() && factor > 0.0).then_some(Round { evaluations, better, worse, times })
    }

    /// The order that the errors of a method show, if its finest run is usable.
    pub fn shown_order(&self, method: Method) -> Option<ShownOrder> {
        let finest = self.curve(method).filter(|cell| cell.errors().is_some()).last()?;
        let shows = self.order(method, SEEN).filter(|_| self.is_usable(finest))?;
        let off = |order: &u32| (shows - f64::from(*order)).abs();
        let claimed =
            self.claimed_orders(method).into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        Some(ShownOrder { shows, claimed: claimed.filter(|claimed| off(claimed) > OTHER_ORDER) })
    }

    /// The order of positions that the table of methods claims: two orders if it is not known whether the laws depend
    /// on the velocity.
    fn claimed_orders(&self, method: Method) -> Vec<u32> {
        let claims = method.claims();
        let (plain, with_velocity) = (claims.position_order, claims.order_with_velocity_laws);
        match self.velocity_laws() {
            Some(true) => vec![with_velocity],
            Some(false) => vec![plain],
            None if plain == with_velocity => vec![plain],
            None => vec![plain, with_velocity],
        }
    }

    fn velocity_laws(&self) -> Option<bool> {
        let telling = |method: &Method| {
            method.claims().evaluations_with_velocity_laws > method.claims().evaluations
        };
        let methods = self.methods();
        let method = methods.into_iter().find(telling)?;
        let cell = self.curve(method).filter(|cell| cell.errors().is_some()).last()?;
        let steps = self.step_hz * self.steps(cell);
        let a_step = self.cost(cell, Cost::Evaluations)? / steps;
        let claims = method.claims();
        Some(a_step > 0.5 * f64::from(claims.evaluations + claims.evaluations_with_velocity_laws))
    }

    /// The cost of a cell, failed or not. A failed run counts evaluations only until it fails, so at least the cost
    /// that its method claims is assumed.
    pub fn cost_or_claim(&self, cell: &Cell, cost: Cost) -> Option<f64> {
        let counted = self.cost(cell, cost);
        if cost != Cost::Evaluations || cell.errors().is_some() {
            return counted;
        }
        let claims = cell.setting.method.claims();
        let a_step = if self.velocity_laws() == Some(true) {
            claims.evaluations_with_velocity_laws
        } else {
            claims.evaluations
        };
        let claimed = f64::from(a_step) / self.step_s(cell.setting);
        counted.map(|counted| counted.max(claimed))
    }

    /// The cost that fills a frame at 60 frames per second.
    pub fn budget(&self, cost: Cost) -> Option<f64> {
        match cost {
            Cost::RealTime => Some(1.0),
            Cost::Time => Some(1e9 / self.size() as f64),
            Cost::Arithmetic | Cost::Evaluations => None,
        }
    }

    /// Errors of phase and amplitude at the end of the run, for every method at the middle one of the steps that were
    /// run.
    pub fn phases(&self) -> Vec<(&Cell, Phase)> {
        let with_phase = self.cells.iter().filter_map(|cell| Some((cell, cell.errors()?.phase?)));
        let mut found: Vec<_> = with_phase.collect();
        let mut rungs: Vec<_> = found.iter().map(|(cell, _)| cell.setting.substeps).collect();
        rungs.sort_unstable();
        rungs.dedup();
        let middle = rungs.get(rungs.len() / 2).copied();
        found.retain(|(cell, _)| Some(cell.setting.substeps) == middle);
        found.sort_by_key(|(cell, _)| cell.setting.method);
        found
    }

    /// Errors of positions of all methods at equal evaluations, where methods can be ranked.
    pub fn at_equal_costs(&self) -> Vec<EqualCost> {
        let methods = if self.ranks() { self.methods() } else { Vec::new() };
        let base =
            methods.iter().find(|method| **method == Method::SemiImplicitEuler).or(methods.first());
        let mut costs: Vec<f64> = Vec::new();
        for cell in base.into_iter().flat_map(|base| self.curve(*base)) {
            let cost = self.cost(cell, Cost::Evaluations).filter(|cost| *cost > 0.0);
            costs.extend(cost.filter(|cost| costs.last().is_none_or(|last| *cost > 1.9 * last)));
        }
        let at = |evaluations: f64| {
            let error =
                |method: &Method| self.error_at(*method, SEEN, Cost::Evaluations, evaluations);
            let errors_m: Vec<_> = methods.iter().map(error).collect();
            let least_m = errors_m.iter().flatten().copied().fold(f64::INFINITY, f64::min);
            EqualCost { evaluations, errors_m, least_m }
        };
        costs.into_iter().map(at).collect()
    }

    /// Failed runs by method and kind of reason, in the order of the cells.
    pub fn failed_runs(&self) -> Vec<FailedRuns<'_>> {
        let mut groups: Vec<FailedRuns<'_>> = Vec::new();
        for cell in self.cells.iter().filter(|cell| cell.is_run()) {
            let Outcome::Failed(failure) = &cell.outcome else { continue };
            let Setting { method, substeps } = cell.setting;
            let alike = |group: &&mut FailedRuns<'_>| {
                let kind = |failure: &Failure| std::mem::discriminant(failure);
                group.method == method
                    && group.runs.iter().all(|(_, other)| kind(other) == kind(failure))
            };
            match groups.iter_mut().find(alike) {
                Some(group) => group.runs.push((substeps, failure)),
                None => groups.push(FailedRuns { method, runs: vec![(substeps, failure)] }),
            }
        }
        groups
    }
}
