//! The field of a group: everything that acts on its rows.

mod arrays;
mod cached;
mod classes;
mod forces;
mod records;
mod solving;

pub(crate) use cached::GroupCache;
use classes::{Class, Classes};
use solving::Workspace;

use std::sync::atomic::{AtomicBool, Ordering};

use super::combination::{APPLIED, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use super::coupling::Coupling;
use super::pull::Share;
use super::rows::{Row, RowArray};
use super::solver::Solver;
use crate::kernels::{Kernel, RowOptions, StepStatistics, Terms, TickField, drive};
use crate::laws::damping::Decay;
use crate::laws::tick_times::Segment;
use crate::laws::{Declared, Law};
use crate::methods::{Field, Integrator, MethodStateKind, StepState, Traits};
use crate::real::Real;
use crate::state::range::Bounds;
use crate::state::threads::Threads;
use crate::tick::environment::Environment;

/// The environment of groups.
#[derive(Clone, Copy)]
pub(crate) struct GroupEnvironment<'a, T: Real> {
    /// The environment of every body.
    pub shared: Environment<'a, T>,
    /// Its terms without gravity and drag, which do not act on all rows.
    pub terms: Terms<'a, T>,
    /// How implicit steps are solved.
    pub solver: Solver,
    /// Names of the laws that are summed before a tick, with exact damping, without gravity.
    pub summed: &'a [&'static str],
    /// The threads that share the rows of a large group.
    pub threads: Option<&'a Threads>,
}

impl<'a, T: Real> GroupEnvironment<'a, T> {
    /// The environment of ticks of `method`; `called` are all called laws, drag included.
    pub fn new(
        method: Traits,
        shared: Environment<'a, T>,
        called: &'a [&'a dyn Law<T>],
        solver: Solver,
        summed: &'a [&'static str],
        threads: Option<&'a Threads>,
    ) -> Self {
        let laws = Declared { drag: None, ..shared.laws };
        Self { shared, terms: Environment { laws, ..shared }.terms(method, called), solver, summed, threads }
    }
}

/// The rows of a group.
pub(crate) struct GroupRows<'a, T: Real> {
    /// Positions, m; after the tick, those of its end.
    pub x: &'a mut [Row<T>],
    /// Velocities, m/s.
    pub v: &'a mut [Row<T>],
    /// Rounding errors of both, m and m/s, where sums are compensated.
    pub residues: Option<[&'a mut [Row<T>]; 2]>,
    /// Inverse masses, 1/kg.
    pub w: &'a [T],
    /// Lengths of the last steps of the movable rows, s, for a method that keeps them.
    pub last: &'a mut [T],
    /// Rows whose options change them, ascending.
    pub with_options: &'a [u32],
    /// Rows with own laws, ascending.
    pub with_laws: &'a [u32],
    /// The cached accelerations, if the tick may use them.
    pub cache: Option<&'a mut GroupCache<T>>,
    /// The parts of threads in the forces of springs, if it is worth it.
    pub shares: &'a [Share],
}

/// Arrays of a step, reused for all groups and ticks.
#[derive(Debug, Default)]
pub(crate) struct Scratch<T: Real> {
    slots: [RowArray<T>; SLOTS],
    stage: [RowArray<T>; 2],
    classes: Classes<T>,
    workspace: Workspace<T>,
    /// Masses of all rows as sources of gravity, kg, if they attract each other.
    masses: Vec<T>,
    /// Pushed rows and their forces, N.
    pub pushes: Vec<(usize, Row<T>)>,
}

impl<T: Real> Scratch<T> {
    /// Bytes of the arrays of rows.
    pub fn bytes(&self) -> usize {
        self.slots.iter().chain(&self.stage).map(|array| size_of_val(&**array)).sum()
    }
}

/// The field of one group in one tick.
pub(crate) struct GroupField<'a, T: Real> {
    coupling: &'a Coupling<T>,
    environment: &'a GroupEnvironment<'a, T>,
    rows: GroupRows<'a, T>,
    options: &'a dyn RowOptions<T>,
    scratch: &'a mut Scratch<T>,
    statistics: &'a mut StepStatistics,
    segment: Segment<T>,
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
#[derive(Clone, Copy)]
pub(crate) struct GroupKernel<T: Real> {
    /// The method for a body that is left alone.
    pub single: Kernel<T>,
    /// Integrates a tick. Fails if a row is not finite or not in range, with those rows that were first, ascending, if
    /// they were searched for.
    pub tick: fn(GroupField<'_, T>, Watch) -> Result<(), Vec<usize>>,
}

impl<T: Real> GroupKernel<T> {
    /// The kernel of `M`.
    pub const fn of<M: Integrator>() -> Self {
        Self { single: Kernel::of::<M>(), tick: |field, watch| field.tick::<M>(watch) }
    }
}

impl<'a, T: Real> GroupField<'a, T> {
    pub fn new(
        coupling: &'a Coupling<T>,
        environment: &'a GroupEnvironment<'a, T>,
        rows: GroupRows<'a, T>,
        options: &'a dyn RowOptions<T>,
        scratch: &'a mut Scratch<T>,
        statistics: &'a mut StepStatistics,
    ) -> Self {
        let GroupEnvironment { terms, .. } = environment;
        let [start, end] = terms.times.ends().map(T::of);
        let segment = Segment { start, end, length: terms.times.substep(), jump: false };
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
        let ((x, v), terms, segments) = (start(), &self.environment.terms, self.segments());
        drive::<M, _>(&mut self, terms, &segments, x, v, &mut step_state);
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
        let Bounds { position, speed } = self.environment.terms.bounds;
        let within = |row: &Row<T>, bound: T| {
            row[0].abs().is_at_most(bound) & row[1].abs().is_at_most(bound) & row[2].abs().is_at_most(bound)
        };
        // An inverse mass of NaN is not above 0, so nothing would act on the row: it is checked here.
        let holds = |x: &Row<T>, v: &Row<T>, w: T| {
            within(x, position) & within(v, speed) & w.abs().is_at_most(T::MAX)
        };
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
    pub(super) fn broken<'r>(&self, rows: &'r [Row<T>]) -> impl Iterator<Item = usize> + use<'r, T> {
        let movable = rows[..self.coupling.movable].iter().enumerate();
        movable.filter(|(_, row)| !row[..3].iter().all(|part| part.is_finite())).map(|(row, _)| row)
    }
}

/// The state at the start of a step.
fn start<T: Real>() -> (Combination<T>, Combination<T>) {
    (Combination::of(POSITION), Combination::of(VELOCITY))
}

impl<T: Real> TickField for GroupField<'_, T> {
    /// By class, because bodies may have their own damping.
    fn enter<M: Integrator>(&mut self, segment: Segment<T>, _: Decay<T>) {
        self.segment = segment;
        if M::DAMPS_INSIDE {
            for class in &mut self.scratch.classes.list {
                let none = Decay::none(segment.length);
                class.decay = class.damping.map_or(none, |damping| damping.factors(segment.length));
            }
        }
    }

    fn before_tick(&mut self, x: Combination<T>, v: Combination<T>) -> (Combination<T>, Combination<T>) {
        let v = self.before_move(v);
        self.record_change(v, v, &|record, _, v, _| record.begin(v));
        self.finish_if_changed(x, v);
        start()
    }

    fn after_step<M: Integrator>(
        &mut self,
        x: Combination<T>,
        v: Combination<T>,
        step_state: &mut StepState<Self>,
    ) -> (Combination<T>, Combination<T>) {
        self.finish(x, v);
        step_state.start = step_state.start.and_then(|start| self.keep(start));
        start()
    }

    fn after_tick(&mut self, x: Combination<T>, v: Combination<T>) -> (Combination<T>, Combination<T>) {
        self.record_change(v, v, &|record, _, v, _| record.end(v));
        let decayed = self.after_move(v);
        let v = self.limited(decayed);
        self.finish_if_changed(x, v);
        start()
    }
}

impl<T: Real> Field for GroupField<'_, T> {
    type Real = T;
    type Space = Combination<T>;

    fn step(&self) -> T {
        self.segment.length
    }

    fn laws(&mut self, part: T, x: Combination<T>, v: Combination<T>) -> Combination<T> {
        Combination::of(self.accelerate(self.segment.evaluation_time(part), x, v))
    }

    fn applied(&self) -> Combination<T> {
        if self.pushed { Combination::of(APPLIED) } else { Combination::ZERO }
    }

    fn depends_on_velocity(&self) -> bool {
        let own =
            |row: &u32| self.options.row(*row as usize).laws.iter().any(|law| law.depends_on_velocity());
        self.coupling.depends_on_velocity(self.environment.shared.laws.drag.is_some())
            || self.scratch.classes.list.iter().any(|class| class.rate != T::ZERO)
            || self.environment.terms.laws.iter().any(|law| law.depends_on_velocity())
            || self.rows.with_laws.iter().any(own)
    }

    fn kick(&mut self, v: Combination<T>, a: Combination<T>) -> Combination<T> {
        let kicked = match self.scratch.classes.uniform() {
            Some(Class { decay, .. }) if self.anchors_rest || decay.keep.is_none() => {
                self.times(v, decay.keep) + a * decay.gain
            }
            _ => {
                // Both by class: own damping also changes the gain.
                let kept = self.each_velocity(v, |class| class.decay.keep);
                let gained = self.each_row(a, |class| Some(class.decay.gain));
                kept + gained
            }
        };
        self.record_kick(v, a, kicked);
        kicked
    }

    fn before_move(&mut self, v: Combination<T>) -> Combination<T> {
        let decayed = self.decayed(v, |decay| decay.before_move);
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        self.limited(decayed)
    }

    fn after_move(&mut self, v: Combination<T>) -> Combination<T> {
        let decayed = self.decayed(v, |decay| decay.after_move);
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        decayed
    }

    fn laws_before_jump(&mut self, x: Combination<T>, v: Combination<T>) -> Option<Combination<T>> {
        let segment = self.segment;
        segment.jump.then(|| Combination::of(self.accelerate(segment.before(), x, v)))
    }

    fn implicit_velocity(&mut self, x: Combination<T>, v: Combination<T>) -> Combination<T> {
        debug_assert!(x.slot() == Some(POSITION), "an implicit step begins where the step does");
        let solved = self.solve(v);
        let h = self.step().to_f64();
        self.record_change(v, solved, &|record, _, from, to| record.kick(h, from, to));
        solved
    }
}
