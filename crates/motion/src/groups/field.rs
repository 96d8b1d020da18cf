//! The field of a group: everything that acts on its rows.

mod arrays;
mod cached;
mod classes;
mod forces;
mod records;
mod solving;

pub(crate) use cached::GroupCache;
use std::sync::atomic::{AtomicBool, Ordering};

use classes::{Class, Classes};
use solving::Workspace;

use super::combination::{APPLIED, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use super::coupling::Coupling;
use super::pull::Share;
use super::rows::{Row, RowArray};
use super::solver::Solver;
use crate::kernels::{Kernel, RowOptions, StepStatistics, TickField, TickParameters, drive};
use crate::laws::damping::Decay;
use crate::laws::tick_times::Segment;
use crate::laws::{Law, SharedLaws};
use crate::methods::{Field, Integrator, MethodStateKind, StepState, Traits};
use crate::state::range::Bounds;
use crate::state::threads::Threads;
use crate::tick::environment::Environment;

/// The environment of groups.
#[derive(Clone, Copy)]
pub(crate) struct GroupEnvironment<'a> {
    /// The environment of every body.
    pub shared: Environment<'a>,
    /// Its parameters without gravity and drag, which do not act on all rows.
    pub parameters: TickParameters<'a>,
    /// How implicit steps are solved.
    pub solver: Solver,
    /// Names of the laws that are summed before a tick, with exact damping, without gravity.
    pub summed: &'a [&'static str],
    /// The threads that share the rows of a large group.
    pub threads: Option<&'a Threads>,
}

impl<'a> GroupEnvironment<'a> {
    /// The environment of ticks of `method`; `called` are all called laws, drag included.
    pub fn new(
        method: Traits,
        shared: Environment<'a>,
        called: &'a [&'a dyn Law],
        solver: Solver,
        summed: &'a [&'static str],
        threads: Option<&'a Threads>,
    ) -> Self {
        let laws = SharedLaws { drag: None, ..shared.laws };
        Self {
            shared,
            parameters: Environment { laws, ..shared }.parameters(method, called),
            solver,
            summed,
            threads,
        }
    }
}

/// The rows of a group.
pub(crate) struct GroupRows<'a> {
    /// Positions, m; after the tick, those of its end.
    pub x: &'a mut [Row],
    /// Velocities, m/s.
    pub v: &'a mut [Row],
    /// Inverse masses, 1/kg.
    pub w: &'a [f64],
    /// Lengths of the last steps of the movable rows, s, for a method that keeps them.
    pub last: &'a mut [f64],
    /// Rows whose options change them, ascending.
    pub with_options: &'a [u32],
    /// Rows with own laws, ascending.
    pub with_laws: &'a [u32],
    /// The cached accelerations, if the tick may use them.
    pub cache: Option<&'a mut GroupCache>,
    /// The parts of threads in the forces of springs, if it is worth it.
    pub shares: &'a [Share],
}

/// Arrays of a step, reused for all groups and ticks.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    slots: [RowArray; SLOTS],
    stage: [RowArray; 2],
    classes: Classes,
    workspace: Workspace,
    /// Masses of all rows as sources of gravity, kg, if they attract each other.
    masses: Vec<f64>,
    /// Pushed rows and their forces, N.
    pub pushes: Vec<(usize, Row)>,
}

impl Scratch {
    /// Bytes of the arrays of rows.
    pub fn bytes(&self) -> usize {
        self.slots.iter().chain(&self.stage).map(|array| size_of_val(&**array)).sum()
    }
}

/// The field of one group in one tick.
pub(crate) struct GroupField<'a> {
    coupling: &'a Coupling,
    environment: &'a GroupEnvironment<'a>,
    rows: GroupRows<'a>,
    options: &'a dyn RowOptions,
    scratch: &'a mut Scratch,
    statistics: &'a mut StepStatistics,
    segment: Segment,
    /// The next free array.
    next: usize,
    pushed: bool,
    /// Number of rows that gravity acts on.
    with_gravity: u64,
    /// Whether the anchors are at rest: then all velocities may be multiplied by the same factor.
    anchors_rest: bool,
    watch: Watch,
    /// The rows that turned non-finite first, ascending, if they are searched for.
    found: Vec<usize>,
    /// The threads that share the rows, if they are many.
    threads: Option<&'a Threads>,
}

/// Whether to search for the rows that turn non-finite first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Watch {
    /// No: the end of the tick tells whether there are any.
    Off,
    /// Yes.
    On,
}

/// A method compiled for groups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupKernel {
    /// The method for a body that is left alone.
    pub single: Kernel,
    /// Integrates a tick. Fails if a row is not finite or not in range, with those rows that were first, ascending, if
    /// they were searched for.
    pub tick: fn(GroupField<'_>, Watch) -> Result<(), Vec<usize>>,
}

impl GroupKernel {
    /// The kernel of `M`.
    pub const fn of<M: Integrator>() -> Self {
        Self { single: Kernel::of::<M>(), tick: |field, watch| field.tick::<M>(watch) }
    }
}

impl<'a> GroupField<'a> {
    pub fn new(
        coupling: &'a Coupling,
        environment: &'a GroupEnvironment<'a>,
        rows: GroupRows<'a>,
        options: &'a dyn RowOptions,
        scratch: &'a mut Scratch,
        statistics: &'a mut StepStatistics,
    ) -> Self {
        let GroupEnvironment { parameters, .. } = environment;
        let [start, end] = parameters.times.ends();
        let segment = Segment { start, end, length: parameters.times.substep(), jump: false };
        Self {
            coupling,
            environment,
            rows,
            options,
            scratch,
            statistics,
            segment,
            next: FIRST,
            pushed: false,
            with_gravity: 0,
            anchors_rest: true,
            watch: Watch::Off,
            found: Vec::new(),
            threads: Threads::for_rows(environment.threads, coupling.rows),
        }
    }

    fn tick<M: Integrator>(mut self, watch: Watch) -> Result<(), Vec<usize>> {
        self.watch = watch;
        self.sort_into_classes();
        self.weigh_sources();
        self.apply_pushes();
        let mut step_state = StepState::default();
        let keeps_last_step = M::STATE == MethodStateKind::LastStep;
        if keeps_last_step {
            step_state.last_step = self.common_last_step();
        }
        let caches = M::STATE == MethodStateKind::LastAcceleration && !self.depends_on_velocity();
        let mut cache = self.rows.cache.take().filter(|_| caches);
        if let Some(cache) = &mut cache {
            step_state.start = self.recall(cache);
        }
        let ((x, v), parameters, segments) = (start(), &self.environment.parameters, self.segments());
        drive::<M, _>(&mut self, parameters, &segments, x, v, &mut step_state);
        self.snap();
        if keeps_last_step {
            self.rows.last.fill(step_state.last_step);
        }
        if let Some(cache) = cache {
            self.note(cache, step_state.start.is_some());
        }
        self.outcome()
    }

    fn weigh_sources(&mut self) {
        let Self { coupling, rows, scratch: Scratch { masses, .. }, .. } = self;
        masses.clear();
        if coupling.attracts {
            masses.extend((0..coupling.rows).map(|row| coupling.mass(row, rows.w)));
        }
    }

    fn outcome(self) -> Result<(), Vec<usize>> {
        let movable = self.coupling.movable;
        let Bounds { position, speed } = self.environment.parameters.bounds;
        let within = |row: &Row, bound: f64| {
            (row[0].abs() <= bound) & (row[1].abs() <= bound) & (row[2].abs() <= bound)
        };
        // An inverse mass of NaN is not above 0, so nothing would act on the row: it is checked here.
        let holds = |x: &Row, v: &Row, w: f64| within(x, position) & within(v, speed) & (w.abs() <= f64::MAX);
        let GroupRows { x, v, w, .. } = self.rows;
        let all = AtomicBool::new(true);
        Threads::share_two(self.threads, &mut x[..movable], &mut v[..movable], |first, x, v| {
            // Not `any`: a loop without an exit is vectorized.
            let mut part = true;
            for ((x, v), w) in x.iter().zip(v).zip(&w[first..]) {
                part &= holds(x, v, *w);
            }
            all.fetch_and(part, Ordering::Relaxed);
        });
        if all.into_inner() {
            return Ok(());
        }
        let broken = |row: &usize| !holds(&x[*row], &v[*row], w[*row]);
        Err(match self.watch {
            Watch::On if self.found.is_empty() => (0..movable).filter(broken).collect(),
            _ => self.found,
        })
    }

    /// Whether non-finite rows are searched for, and none is found yet.
    pub(super) fn looks(&self) -> bool {
        self.watch == Watch::On && self.found.is_empty()
    }

    /// Notes the non-finite rows, if they are searched for.
    pub(super) fn look(&mut self, rows: impl FnOnce(&Self) -> Vec<usize>) {
        if self.looks() {
            self.found = rows(self);
        }
    }

    /// The movable rows that are not finite.
    pub(super) fn broken<'r>(&self, rows: &'r [Row]) -> impl Iterator<Item = usize> + use<'r> {
        let movable = rows[..self.coupling.movable].iter().enumerate();
        movable.filter(|(_, row)| !row[..3].iter().all(|part| part.is_finite())).map(|(row, _)| row)
    }
}

/// The state at the start of a step.
fn start() -> (Combination, Combination) {
    (Combination::of(POSITION), Combination::of(VELOCITY))
}

impl TickField for GroupField<'_> {
    /// By class, because bodies may have their own damping.
    fn enter<M: Integrator>(&mut self, segment: Segment, _: Decay) {
        self.segment = segment;
        if M::DAMPS_INSIDE {
            for class in &mut self.scratch.classes.list {
                let none = Decay::none(segment.length);
                class.decay = class.damping.map_or(none, |damping| damping.factors(segment.length));
            }
        }
    }

    fn before_tick(&mut self, x: Combination, v: Combination) -> (Combination, Combination) {
        let v = self.before_move(v);
        self.record_change(v, v, &|record, _, v, _| record.begin(v));
        self.finish_if_changed(x, v);
        start()
    }

    fn after_step<M: Integrator>(
        &mut self,
        x: Combination,
        v: Combination,
        step_state: &mut StepState<Self>,
    ) -> (Combination, Combination) {
        self.finish(x, v);
        step_state.start = step_state.start.and_then(|start| self.keep(start));
        start()
    }

    fn after_tick(&mut self, x: Combination, v: Combination) -> (Combination, Combination) {
        self.record_change(v, v, &|record, _, v, _| record.end(v));
        let decayed = self.after_move(v);
        let v = self.limited(decayed);
        self.finish_if_changed(x, v);
        start()
    }
}

impl Field for GroupField<'_> {
    type Space = Combination;

    fn step(&self) -> f64 {
        self.segment.length
    }

    fn laws(&mut self, part: f64, x: Combination, v: Combination) -> Combination {
        Combination::of(self.accelerate(self.segment.evaluation_time(part), x, v))
    }

    fn applied(&self) -> Combination {
        if self.pushed { Combination::of(APPLIED) } else { Combination::ZERO }
    }

    fn depends_on_velocity(&self) -> bool {
        let own =
            |row: &u32| self.options.row(*row as usize).laws.iter().any(|law| law.depends_on_velocity());
        self.coupling.depends_on_velocity(self.environment.shared.laws.drag.is_some())
            || self.scratch.classes.list.iter().any(|class| class.rate != 0.0)
            || self.environment.parameters.laws.iter().any(|law| law.depends_on_velocity())
            || self.rows.with_laws.iter().any(own)
    }

    fn kick(&mut self, v: Combination, a: Combination) -> Combination {
        let kicked = match self.scratch.classes.uniform() {
            Some(Class { decay, .. }) if self.anchors_rest || decay.keep.is_none() => {
                decay.keep.map_or(v, |keep| v * keep) + a * decay.gain
            }
            _ => {
                // Both by class: own damping also changes the gain.
                let kept = self.each_row(v, |class| class.decay.keep);
                let gained = self.each_row(a, |class| Some(class.decay.gain));
                kept + gained
            }
        };
        self.record_kick(v, a, kicked);
        kicked
    }

    fn before_move(&mut self, v: Combination) -> Combination {
        let decayed = self.decayed(v, |decay| decay.before_move);
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        self.limited(decayed)
    }

    fn after_move(&mut self, v: Combination) -> Combination {
        let decayed = self.decayed(v, |decay| decay.after_move);
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        decayed
    }

    fn laws_before_jump(&mut self, x: Combination, v: Combination) -> Option<Combination> {
        let segment = self.segment;
        segment.jump.then(|| Combination::of(self.accelerate(segment.before(), x, v)))
    }

    fn implicit_velocity(&mut self, x: Combination, v: Combination) -> Combination {
        debug_assert!(x.slot() == Some(POSITION), "an implicit step begins where the step does");
        let solved = self.solve(v);
        let h = self.step();
        self.record_change(v, solved, &|record, _, from, to| record.kick(h, from, to));
        solved
    }
}
