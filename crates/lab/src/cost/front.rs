//! Errors and costs of the cells of a study, and what follows from them: orders, the front, errors at a cost.

use motion::Method;

use super::record::{Cell, Setting, Study, Time};

/// The kind of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Accuracy {
    /// [`Errors::relative`](super::Errors::relative).
    Relative,
    /// [`Errors::position_m`](super::Errors::position_m).
    Position,
    /// [`Errors::velocity_m_s`](super::Errors::velocity_m_s).
    Velocity,
}

/// The kind of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cost {
    /// Evaluations per body per simulated second, including those of solvers.
    Evaluations,
    /// Thread CPU time per body per simulated second, ns.
    Time,
    /// The time of the arithmetic alone, without this program, per body per simulated second, ns.
    Arithmetic,
    /// Thread CPU seconds per simulated second: the reciprocal of the real-time factor.
    RealTime,
}

impl Cost {
    /// All kinds of costs.
    pub const ALL: [Self; 4] = [Self::Evaluations, Self::Time, Self::Arithmetic, Self::RealTime];
}

impl Study {
    /// Length of a substep of that setting, s.
    pub fn step_s(&self, setting: Setting) -> f64 {
        1.0 / (self.step_hz * f64::from(setting.substeps.least()))
    }

    /// Steps per tick of a cell; where they are chosen, as many as have its evaluations.
    pub fn steps(&self, cell: &Cell) -> f64 {
        let Setting { method, substeps } = cell.setting;
        let evaluations = |cell: &Cell| (cell.counts.accelerations + cell.counts.solver) as f64;
        let number = |cell: &Cell| Some(f64::from(cell.setting.substeps.fixed()?));
        let a_step = || {
            let cell = self.curve(method).find(|cell| cell.errors().is_some())?;
            Some(evaluations(cell) / number(cell)?)
        };
        let chosen = || a_step().map(|a_step| evaluations(cell) / a_step);
        number(cell).or_else(chosen).unwrap_or_else(|| f64::from(substeps.least()))
    }

    /// Mean length of a step of a cell, s.
    pub fn mean_step_s(&self, cell: &Cell) -> f64 {
        1.0 / (self.step_hz * self.steps(cell))
    }

    /// The error of a cell, unless it failed.
    pub fn error(&self, cell: &Cell, accuracy: Accuracy) -> Option<f64> {
        let errors = cell.errors()?;
        Some(match accuracy {
            Accuracy::Relative => errors.relative,
            Accuracy::Position => errors.position_m,
            Accuracy::Velocity => errors.velocity_m_s,
        })
    }

    /// The cost of a cell, failed or not; `None` if it was not measured.
    pub fn cost(&self, cell: &Cell, cost: Cost) -> Option<f64> {
        let bodies = self.bodies.max(1) as f64;
        let per_second = |time: Time| time.ns_per_body_step * self.step_hz * self.steps(cell);
        match cost {
            Cost::Evaluations => {
                let evaluations = (cell.counts.accelerations + cell.counts.solver) as f64;
                Some(evaluations / (bodies * self.simulated_s))
            }
            Cost::Time => cell.time.map(per_second),
            Cost::Arithmetic => cell.arithmetic_time.map(per_second),
            Cost::RealTime => Some(1.0 / cell.time?.real_time_factor),
        }
    }

    /// The cells of `method` in fixed numbers of substeps, ascending.
    pub fn curve(&self, method: Method) -> impl Iterator<Item = &Cell> {
        let is_fixed = |cell: &&Cell| cell.setting.substeps.fixed().is_some();
        self.cells.iter().filter(is_fixed).filter(move |cell| cell.setting.method == method)
    }

    /// The cells of `method` that choose their substeps, by the error that they choose for, descending.
    pub fn chosen(&self, method: Method) -> impl Iterator<Item = &Cell> {
        let chooses = |cell: &&Cell| cell.setting.substeps.fixed().is_none();
        self.cells.iter().filter(chooses).filter(move |cell| cell.setting.method == method)
    }

    /// The noise floor of a cell: larger errors are above round-off and above the error of the reference.
    pub fn trusted(&self, cell: &Cell, accuracy: Accuracy) -> f64 {
        let steps = self.ticks as f64 * self.steps(cell);
        let (relative, position_m) = self.truth.own_error();
        let (scale, own) = match accuracy {
            Accuracy::Relative => (1.0, relative),
            Accuracy::Position => (self.position_scale_m, position_m),
            Accuracy::Velocity => (self.velocity_scale_m_s, relative * self.velocity_scale_m_s),
        };
        (1e3 * f64::EPSILON * steps * scale).max(10.0 * own)
    }

    /// The order of a method: the slope of its error against the step, in logarithms, on the two finest rungs whose
    /// errors are above the noise floor, as in the usual convergence test (SciML, `analyticless_convergence_tests`).
    /// `None` if there are fewer than two such rungs, as for an exact method.
    pub fn order(&self, method: Method, accuracy: Accuracy) -> Option<f64> {
        let points: Vec<_> = self
            .curve(method)
            .filter_map(|cell| Some((cell, self.error(cell, accuracy)?)))
            .filter(|(cell, error)| *error > self.trusted(cell, accuracy))
            .map(|(cell, error)| (self.step_s(cell.setting), error))
            .collect();
        let [.., (coarse, large), (fine, small)] = points[..] else { return None };
        Some((large / small).ln() / (coarse / fine).ln())
    }

    /// The settings that no other one beats in both error and cost, the cheapest first.
    pub fn front(&self, accuracy: Accuracy, cost: Cost) -> Vec<&Cell> {
        let mut points: Vec<_> = self
            .cells
            .iter()
            .filter_map(|cell| Some((self.cost(cell, cost)?, self.error(cell, accuracy)?, cell)))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut least = f64::INFINITY;
        points.retain(|(_, error, _)| {
            let better = *error < least;
            least = least.min(*error);
            better
        });
        points.into_iter().map(|(.., cell)| cell).collect()
    }

    /// The error of a method at a cost, interpolated between rungs by straight lines in
    /// logarithms; `None` outside the rungs.
    pub fn error_at(&self, method: Method, accuracy: Accuracy, cost: Cost, at: f64) -> Option<f64> {
        let points = self
            .curve(method)
            .filter_map(|cell| {
                Some((self.cost(cell, cost)?.ln(), self.error(cell, accuracy)?.ln()))
            })
            .filter(|(cost, error)| cost.is_finite() && error.is_finite());
        Some(between(&points.collect::<Vec<_>>(), at.ln())?.exp())
    }
}

/// Interpolates linearly between ascending points; `None` outside of them.
fn between(line: &[(f64, f64)], at: f64) -> Option<f64> {
    line.windows(2).find_map(|pair| {
        let [(a, left), (b, right)] = *pair else { return None };
        (a <= at && at <= b)
            .then(|| if a == b { left } else { left + (right - left) * (at - a) / (b - a) })
    })
}
