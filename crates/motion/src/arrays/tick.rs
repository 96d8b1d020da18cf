//! A tick of bodies in plain arrays.

use super::Bare;
use super::bodies::{Kind, Run};
use crate::kernels::{AppliedForces, Batch, Kernel, MethodStateRows, RowOptions, StepStatistics};
use crate::laws::tick_times::TickTimes;
use crate::methods::table::Method;
use crate::methods::{Integrator, MethodStateKind};
use crate::state::method_state::CachedAcceleration;

impl Bare {
    /// Integrates a tick of every body by any method, such as one of your own. Does nothing if the tick has no
    /// length.
    ///
    /// # Panics
    /// If bodies act on each other: that is for the methods of the table only.
    pub fn tick_with<M: Integrator>(&mut self) {
        assert!(self.groups.is_empty(), "groups are for the methods of the table only");
        if self.begin_tick() {
            for run in 0..self.individuals.runs.len() {
                self.tick_rows(run, Kernel::of::<M>());
            }
            self.end_tick();
        }
    }

    /// Prepares a tick; `false` if it has no length.
    pub(super) fn begin_tick(&mut self) -> bool {
        self.refused.clear();
        if self.step != 0.0 {
            self.emit();
        }
        self.individuals.plan(&self.bodies);
        self.forces.resize(self.bodies.len(), [0.0; 3]);
        self.step != 0.0
    }

    pub(super) fn end_tick(&mut self) {
        self.clock.count(self.step);
        self.individuals.end_births();
        for (_, row) in self.pushed.drain(..) {
            self.forces[row] = [0.0; 3];
        }
        self.has_failed |= !self.refused.is_empty();
    }

    pub(super) fn method_of_run(&self, run: usize) -> Method {
        self.individuals.runs[run].kind.method.unwrap_or(self.method)
    }

    /// Whether the velocity of one of these rows is half a step behind.
    pub(super) fn is_half_a_step_behind(&self, rows: impl IntoIterator<Item = usize>) -> bool {
        rows.into_iter().any(|row| self.last_steps.get(row).is_some_and(|step| *step != 0.0))
    }

    pub(super) fn times(&self, substeps: u32) -> TickTimes {
        TickTimes::new(self.clock, self.step, substeps)
    }

    /// Integrates a tick of `kernel` for the rows of a run.
    pub(super) fn tick_rows(&mut self, run: usize, kernel: Kernel) {
        let mut times = self.times(self.substeps);
        let Self {
            positions,
            bodies,
            forces,
            pushed,
            resources,
            individuals,
            statistics,
            refused,
            ..
        } = self;
        let Run { rows, kind: Kind { gravity_off, own, born, .. } } = individuals.runs[run].clone();
        if let Some(time) = born {
            times = times.since(time);
        }
        let environment = resources.environment(times);
        let called = environment.called();
        let mut parameters = environment.parameters(kernel.traits, &called);
        if !gravity_off {
            parameters.gravity += environment.free_fall();
        }
        forces.resize(bodies.len(), [0.0; 3]);
        let calls = !called.is_empty() || own.is_some();
        let mut method_state = method_state(
            kernel.traits.state,
            &mut self.last_steps,
            &mut self.cached,
            bodies.len(),
            calls,
        );
        let applied = AppliedForces { forces, rows: pushed, offset: 0 }.part(rows.clone());
        let mut batch = Batch {
            positions: &mut positions[rows.clone()],
            bodies: &mut bodies[rows.clone()],
            applied: (!applied.rows.is_empty()).then_some(applied),
            method_state: method_state.part(rows.clone()),
        };
        let options = own.map(|first| &individuals.own_options[first..]);
        let options = options.as_ref().map(|options| options as &dyn RowOptions);
        let mut counted = StepStatistics::default();
        let refuse = &mut |row, _| refused.push(rows.start + row);
        let all = 0..rows.len();
        (kernel.integrate)(&parameters, &mut batch, all, options, &mut counted, refuse);
        statistics.add(&counted);
    }
}

/// The method state of all rows; `calls` tells whether laws are called.
fn method_state<'a>(
    state: MethodStateKind,
    last_steps: &'a mut Vec<f64>,
    cached: &'a mut Vec<CachedAcceleration>,
    rows: usize,
    calls: bool,
) -> MethodStateRows<'a> {
    match state {
        MethodStateKind::LastStep => {
            last_steps.resize(rows, 0.0);
            MethodStateRows::LastStep(last_steps)
        }
        MethodStateKind::LastAcceleration if calls => {
            cached.resize(rows, CachedAcceleration::default());
            MethodStateRows::LastAcceleration(cached)
        }
        MethodStateKind::LastAcceleration | MethodStateKind::None => MethodStateRows::None,
    }
}
