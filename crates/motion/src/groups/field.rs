//! The field of a group, or of several groups of one shape: everything that acts on their rows.

mod arrays;
mod cached;
mod classes;
mod cords;
mod defect;
mod driven;
mod forces;
mod lane_solver;
mod layout;
mod linear_step;
mod solving;

pub(crate) use cached::GroupCache;
pub(crate) use layout::Layout;
use std::sync::atomic::{AtomicBool, Ordering};

use classes::{Class, Classes};
use cords::Cords;
pub(crate) use cords::{bisect_end, equal_parts};
use defect::Defect;

use super::combination::{APPLIED, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use super::coupling::Coupling;
use super::rows::{Array, Row, numbers};
use super::solver::Solver;
use crate::kernels::evaluations::Iterations;
use crate::kernels::{Kernel, RowOptions, StepStatistics, TickField, TickParameters, drive};
use crate::laws::tick_times::Segment;
use crate::laws::{Axes, Law, SharedLaws};
use crate::methods::{Field, Integrator, MethodStateKind, StepState, Traits};
use crate::simd::vectorize_many;
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
    /// Names of the laws that are summed before a tick, including exact damping but not gravity.
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

    /// Whether implicit steps of groups without own laws are one linear solve each, so that groups can be solved side by side.
    pub fn is_linearized(&self) -> bool {
        self.solver.newton_iterations == 0 && self.parameters.laws.is_empty()
    }
}

/// The rows of a group, or of several groups of one shape.
pub(crate) struct GroupRows<'a, E: Layout = Row> {
    /// Positions, m; after the tick, those of its end.
    pub x: &'a mut [E],
    /// Velocities, m/s.
    pub v: &'a mut [E],
    /// Inverse masses, 1/kg, of every lane of every element.
    pub w: &'a [f64],
    /// The number of groups: lanes beyond it are fillers.
    pub groups: usize,
    /// Groups whose results are not used, ascending; their evaluations are not counted.
    pub apart: &'a [usize],
    /// Lengths of the last steps of the movable rows, s, for a method with [`MethodStateKind::LastStep`].
    pub last: &'a mut [f64],
    /// Rows with options other than own laws and substeps, ascending.
    pub with_options: &'a [u32],
    /// Rows with own laws, ascending.
    pub with_laws: &'a [u32],
    /// The cached accelerations, if the tick may use them.
    pub cache: Option<&'a mut GroupCache<E>>,
    /// Whether the anchors are at rest: they stay, and all velocities may be multiplied by the same factor.
    pub anchors_rest: bool,
    /// How the forces of springs are computed.
    pub springs: E::Springs<'a>,
}

/// Arrays of a step, reused for all groups and ticks.
#[derive(Debug, Default)]
pub(crate) struct Scratch<E: Layout = Row> {
    slots: [Array<E>; SLOTS],
    stage: [Array<E>; 2],
    classes: Classes,
    cords: Cords,
    workspace: E::Workspace,
    /// Iterations of the implicit steps of each group in a tick.
    iterations: Vec<Iterations>,
    /// Masses of all rows as sources of gravity, kg, if they attract each other.
    masses: Vec<f64>,
    /// The applied forces.
    pub pushes: Vec<Push>,
    /// The error of the tick, if it is measured.
    pub defect: Defect<E>,
    /// Groups without cached start accelerations in a tick where other groups have them; each costs one more evaluation.
    not_cached: Vec<usize>,
}

/// A force on a row of a group, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Push {
    /// The number of the group, among several of one shape.
    pub lane: usize,
    pub row: usize,
    pub force: Row,
}

impl<E: Layout> Scratch<E> {
    /// Bytes of the arrays of rows.
    pub fn bytes(&self) -> usize {
        self.slots.iter().chain(&self.stage).map(|array| size_of_val(&**array)).sum()
    }
}

/// The field of one group, or of several of one shape, in one tick.
pub(crate) struct GroupField<'a, E: Layout = Row> {
    coupling: &'a Coupling,
    environment: &'a GroupEnvironment<'a>,
    rows: GroupRows<'a, E>,
    /// Elements per row: above 1 if there are more groups than lanes in an element.
    width: usize,
    /// Evaluations of all laws so far.
    evaluations: u64,
    options: &'a dyn RowOptions,
    scratch: &'a mut Scratch<E>,
    statistics: &'a mut StepStatistics,
    segment: Segment,
    /// The next free array.
    next: usize,
    pushed: bool,
    /// Number of rows of a group that gravity acts on.
    with_gravity: u64,
    watch: Watch,
    /// The rows that turned non-finite first, ascending, if they are searched for.
    found: Vec<usize>,
    /// The threads that share the rows, if they are many.
    threads: Option<&'a Threads>,
}

/// Whether to search for the rows that turn non-finite first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Watch {
    /// Do not search: the end of the tick tells whether there are any.
    Off,
    /// Search within the tick.
    On,
    /// Do not search: the end of the tick tells which groups have any.
    Groups,
}

/// A method compiled for groups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupKernel {
    /// The kernel for a body that is left alone.
    pub single: Kernel,
    /// Whether the method solves implicit steps. Groups are then integrated side by side only if each step is linear.
    pub solves: bool,
    /// Integrates a tick. Fails if a row is not finite or out of range; returns the rows that failed first, ascending, if
    /// [`Watch`] searches for them.
    pub tick: fn(GroupField<'_>, Watch) -> Result<(), Vec<usize>>,
    /// Integrates a tick of several groups of one shape. Fails with the groups that have a row that is not finite or out of
    /// range.
    pub tick_lanes: fn(GroupField<'_, Axes>) -> Result<(), Vec<usize>>,
}

impl GroupKernel {
    /// The kernel of `M`.
    pub const fn of<M: Integrator>() -> Self {
        Self {
            single: Kernel::of::<M>(),
            solves: M::SOLVES,
            tick: |field, watch| {
                field
                    .tick::<M>(watch)
                    .map_err(|broken| broken.into_iter().map(|(row, _)| row).collect())
            },
            tick_lanes: |field| {
                field.tick::<M>(Watch::Groups).map_err(|broken| {
                    let mut lanes: Vec<_> = broken.into_iter().map(|(_, lane)| lane).collect();
                    lanes.dedup();
                    lanes
                })
            },
        }
    }
}

impl<'a, E: Layout> GroupField<'a, E> {
    /// The field of the groups whose coupling is `coupling`, or of the same shape.
    pub fn new(
        coupling: &'a Coupling,
        environment: &'a GroupEnvironment<'a>,
        rows: GroupRows<'a, E>,
        options: &'a dyn RowOptions,
        scratch: &'a mut Scratch<E>,
        statistics: &'a mut StepStatistics,
    ) -> Self {
        let GroupEnvironment { parameters, .. } = environment;
        let [start, end] = parameters.times.ends();
        let length = parameters.times.substep();
        let segment = Segment { start, end, length, preceding: length, jump: false };
        Self {
            coupling,
            environment,
            width: rows.x.len() / coupling.rows,
            rows,
            options,
            scratch,
            statistics,
            segment,
            next: FIRST,
            evaluations: 0,
            pushed: false,
            with_gravity: 0,
            watch: Watch::Off,
            found: Vec::new(),
            threads: Threads::for_rows(environment.threads, coupling.rows),
        }
    }

    fn tick<M: Integrator>(mut self, watch: Watch) -> Result<(), Vec<(usize, usize)>> {
        self.watch = watch;
        self.follow_motions_to(self.segment.evaluation_time(0.0));
        self.sort_into_classes();
        self.weigh_sources();
        self.begin_cords();
        self.apply_pushes();
        let mut step_state = StepState::default();
        self.scratch.not_cached.clear();
        self.scratch.iterations.clear();
        let keeps_last_step = M::STATE == MethodStateKind::LastStep;
        if keeps_last_step {
            step_state.last_step = self.synchronize_last_steps();
        }
        let caches = M::STATE == MethodStateKind::LastAcceleration && !self.depends_on_velocity();
        let mut cache = self.rows.cache.take().filter(|_| caches);
        let ((x, v), parameters) = (start(), &self.environment.parameters);
        let motions = self.coupling.motions.iter().flat_map(|(_, motion)| motion.discontinuities());
        let segments = parameters.segments(self.own_laws(), motions);
        if let (Some(cache), Some(first)) = (&mut cache, segments.iter().next()) {
            self.segment = first;
            step_state.start = self.recall(cache);
        }
        drive::<M, _>(&mut self, parameters, &segments, x, v, &mut step_state);
        self.snap();
        if keeps_last_step {
            self.rows.last.fill(step_state.last_step);
        }
        if let Some(cache) = cache {
            self.store_or_clear(cache, step_state.start.is_some());
        }
        let outcome = self.outcome();
        self.count(outcome.as_ref().err().map_or(&[], Vec::as_slice));
        outcome
    }

    fn weigh_sources(&mut self) {
        let Self { coupling, rows, scratch: Scratch { masses, .. }, .. } = self;
        masses.clear();
        if coupling.attracts {
            masses.extend((0..coupling.rows).map(|row| coupling.mass(row, rows.w)));
        }
    }

    /// Number of elements of the movable rows, which come first.
    const fn movable(&self) -> usize {
        self.coupling.movable * self.width
    }

    /// Element and lane of a row of a group.
    fn place(&self, row: usize, group: usize) -> (usize, usize) {
        E::place(self.width, row, group)
    }

    /// Checks the new states. `Err` lists the rows that failed, each with the number of its group, group by group.
    fn outcome(&mut self) -> Result<(), Vec<(usize, usize)>> {
        let (movable, groups) = (self.coupling.movable, self.rows.groups);
        let bounds = self.environment.parameters.bounds;
        let Bounds { position, speed } = bounds;
        let within = |number: f64, bound: f64| number.abs() <= bound;
        // Inverse masses are checked too: NaN is not above 0, so nothing would act on the row.
        let holds = |x: &E, v: &E, w: &[f64]| {
            // Not `all`: a loop without an exit is vectorized.
            let mut holds = true;
            for axis in 0..3 {
                for (x, v) in x.axis(axis).iter().zip(v.axis(axis)) {
                    holds &= within(*x, position) & within(*v, speed);
                }
            }
            w.iter().fold(holds, |holds, w| holds & (w.abs() <= f64::MAX))
        };
        let elements = self.movable();
        let GroupRows { x, v, w, .. } = &mut self.rows;
        let all = AtomicBool::new(true);
        Threads::share_two(self.threads, &mut x[..elements], &mut v[..elements], |first, x, v| {
            let part = vectorize_many(
                numbers(x).len(),
                #[inline(always)]
                || {
                    let mut part = true;
                    for ((x, v), w) in
                        x.iter().zip(v).zip(w[first * E::LANES..].chunks_exact(E::LANES))
                    {
                        part &= holds(x, v, w);
                    }
                    part
                },
            );
            all.fetch_and(part, Ordering::Relaxed);
        });
        if all.into_inner() {
            return Ok(());
        }
        let breaks = |row: usize, group: usize| {
            let (element, lane) = self.place(row, group);
            let GroupRows { x, v, w, .. } = &self.rows;
            let ([a, b, c, _], [d, e, f, _]) = (x[element].row(lane), v[element].row(lane));
            bounds.breach(&[a, b, c], &[d, e, f, w[element * E::LANES + lane]]).is_some()
        };
        Err(match self.watch {
            Watch::Off => Vec::new(),
            _ if !self.found.is_empty() => self.found.iter().map(|row| (*row, 0)).collect(),
            Watch::On | Watch::Groups => (0..groups)
                .flat_map(|group| (0..movable).map(move |row| (row, group)))
                .filter(|(row, group)| breaks(*row, *group))
                .collect(),
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
    pub(super) fn broken<'r>(&self, rows: &'r [E]) -> impl Iterator<Item = usize> + use<'r, E> {
        let movable = rows[..self.movable()].iter().enumerate();
        let is_finite =
            |row: &E| (0..3).all(|axis| row.axis(axis).iter().all(|part| part.is_finite()));
        movable.filter(move |(_, row)| !is_finite(row)).map(|(row, _)| row)
    }
}

/// The state at the start of a step.
fn start() -> (Combination, Combination) {
    (Combination::of(POSITION), Combination::of(VELOCITY))
}

impl<E: Layout> Field for GroupField<'_, E> {
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
        self.coupling.depends_on_velocity(self.environment.shared.laws.drag.is_some())
            || self.scratch.classes.list.iter().any(|class| class.rate != 0.0)
            || self.environment.parameters.calls_with_velocity(self.own_laws())
    }

    fn kick(&mut self, v: Combination, a: Combination) -> Combination {
        let kicked = match self.scratch.classes.uniform() {
            Some(Class { decay, .. }) if self.rows.anchors_rest || decay.keep.is_none() => {
                decay.keep.map_or(v, |keep| v * keep) + a * decay.gain
            }
            _ => {
                // Both by class: own damping also changes the gain.
                let kept = self.each_row(v, |class| class.decay.keep);
                let gained = self.each_row(a, |class| Some(class.decay.gain));
                kept + gained
            }
        };
        if self.statistics.record.is_some() {
            self.record_kick(v, a, kicked);
        }
        kicked
    }

    fn before_move(&mut self, v: Combination) -> Combination {
        self.damp_and_limit(v)
    }

    fn after_move(&mut self, v: Combination) -> Combination {
        self.damp(v, |decay| decay.after_move)
    }

    fn laws_before_jump(&mut self, x: Combination, v: Combination) -> Option<Combination> {
        let segment = self.segment;
        let before = |field: &mut Self| Combination::of(field.accelerate(segment.before(), x, v));
        segment.jump.then(|| self.before_change_of_cords(before))
    }

    fn implicit_velocity(&mut self, x: Combination, v: Combination) -> Combination {
        debug_assert!(x.slot() == Some(POSITION), "an implicit step begins where the step does");
        let solved = self.solve(v);
        self.record_solved(v, solved);
        solved
    }
}
