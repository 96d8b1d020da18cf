//! The systems that integrate single bodies, table by table.

use std::ops::Range;

use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use bevy_ecs::system::{BoxedSystem, ParamBuilder, SystemState};
use bytemuck::TransparentWrapper as _;

use crate::kernels::record::TickRecords;
use crate::kernels::{
    self, AppliedForces, Batch, BodyOptions, Kernel, MethodStateRows, RowOptions, StepStatistics,
    TickParameters,
};
use crate::laws::PrescribedMotion;
use crate::methods::euler::{Drift, Kick};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::methods::{Integrator, Traits};
use crate::state::components::{Force, PhysicsBody, Quarantined, Transform};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::method_state::LastAcceleration;
use crate::state::range::Breach;
use crate::state::static_bodies::Static;
use crate::state::threads::{Job, Threads};
use crate::tick::body_filter::BodyFilter;
use crate::tick::columns::{BodyColumns, BodyColumnsContiguousItem};
use crate::tick::diagnosis::{Exposure, Suspect};
use crate::tick::environment::{Birth, Environment, EnvironmentParam, TickOutput};
use crate::tick::quarantine::Refused;
use crate::units::Vector;

/// The filter of bodies that use the world's method.
pub type Unmarked = Without<OwnMethod>;

/// The bodies of a system that moves single bodies.
pub type Bodies<'w, 's, Who> = Query<
    'w,
    's,
    BodyColumns,
    (
        Who,
        Without<Quarantined>,
        Without<Static>,
        Without<PrescribedMotion>,
        Without<Dormant>,
        Without<Grouped>,
    ),
>;

/// The data of a table that a tick reads.
struct TableTick<'a> {
    kernel: Kernel,
    entities: &'a [Entity],
    forces: &'a [Force],
    /// The options of its bodies, if they have any.
    options: Option<&'a (dyn RowOptions + Sync)>,
    gravity_off: bool,
    environment: &'a Environment<'a>,
    parameters: &'a TickParameters<'a>,
    /// The births in the table, by row.
    births: &'a [Birth],
    /// The records of the tick, if it has a ledger.
    records: &'a TickRecords,
}

/// The rows of a table that one thread integrates.
#[derive(Clone, Copy)]
struct TablePart<'a> {
    table: &'a TableTick<'a>,
    /// The first of these rows.
    start: usize,
}

/// The result of a part.
#[derive(Default)]
struct Done {
    statistics: StepStatistics,
    refused: Vec<Refused>,
}

impl RowOptions for TablePart<'_> {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        self.table.options.map_or(BodyOptions::NONE, |options| options.row(self.start + row))
    }
}

impl TablePart<'_> {
    /// Integrates a tick of every row.
    fn integrate(self, mut batch: Batch<'_>) -> Done {
        let TableTick { parameters, births, records, .. } = self.table;
        let rows = batch.bodies.len();
        let mut done = Done::default();
        done.statistics.record = records.recorder(rows);
        let births_before =
            |row: usize| births.partition_point(|birth| birth.place.1 < self.start + row);
        let mut next = 0;
        for Birth { place, time } in &births[births_before(0)..births_before(rows)] {
            let born = place.1 - self.start;
            self.integrate_rows(next..born, parameters, &mut batch, &mut done);
            self.integrate_rows(born..born + 1, &parameters.since(*time), &mut batch, &mut done);
            next = born + 1;
        }
        self.integrate_rows(next..rows, parameters, &mut batch, &mut done);
        done
    }

    /// Integrates some of the rows, all of which have the same tick.
    fn integrate_rows(
        self,
        rows: Range<usize>,
        parameters: &TickParameters<'_>,
        batch: &mut Batch<'_>,
        done: &mut Done,
    ) {
        if rows.is_empty() {
            return;
        }
        let mut refused: Vec<(usize, Breach)> = Vec::new();
        let options = self.table.options.map(|_| &self as &dyn RowOptions);
        let refuse = &mut |row, breach| refused.push((row, breach));
        (self.table.kernel.integrate)(
            parameters,
            batch,
            rows,
            options,
            &mut done.statistics,
            refuse,
        );
        for (row, breach) in refused {
            done.refused.push(self.diagnose(parameters, batch, row, breach));
        }
    }

    /// Finds which system refused a row, and why. If the step of an explicit Euler became non-finite in its second
    /// half, the first half is stored, as it is where the halves are systems of their own; not in a tick of several
    /// steps, nor at the border of a range.
    #[cold]
    fn diagnose(
        self,
        parameters: &TickParameters<'_>,
        batch: &mut Batch<'_>,
        row: usize,
        breach: Breach,
    ) -> Refused {
        const KICK: &str = "integrate_acceleration";
        const DRIFT: &str = "integrate_velocity";
        let options = self.row(row);
        let TableTick { kernel, entities, forces, environment, gravity_off, .. } = *self.table;
        let Traits { method, kicks, moves, damps_inside, .. } = kernel.traits;
        let before = (batch.positions[row], batch.bodies[row]);
        let (kick, drift) = (const { Kernel::of::<Kick>() }, const { Kernel::of::<Drift>() });
        let (system, breach) = if !damps_inside {
            ("integrate", breach)
        } else if !(kicks && moves) {
            (if kicks { KICK } else { DRIFT }, breach)
        } else {
            let halves = [(kick, KICK), (drift, DRIFT)];
            let [first, second] =
                if method == Method::SemiImplicitEuler { halves } else { [halves[1], halves[0]] };
            let statistics = &mut StepStatistics::default();
            match first.0.integrate_row(parameters, options, batch, row, statistics) {
                Ok(()) => (second.1, breach),
                Err(breach) => (first.1, breach),
            }
        };
        if breach.finite || options.substeps.unwrap_or(parameters.times.substeps) > 1 {
            (batch.positions[row], batch.bodies[row]) = before;
        }
        let transform = Transform::at(Vector::from_array(batch.positions[row]));
        let state: PhysicsBody = bytemuck::cast(batch.bodies[row]);
        let damping_rate = options.damping_rate.filter(|_| parameters.damping.is_some());
        let suspect = Suspect {
            position: transform.position,
            body: state,
            force: if kicks { forces[self.start + row].0 } else { Vector::ZERO },
            damping_rate,
            limit: options.speed_limit,
            last_step: match &batch.method_state {
                MethodStateRows::LastStep(steps) => Some(steps[row]),
                MethodStateRows::None | MethodStateRows::LastAcceleration(_) => None,
            },
            laws: if kicks { options.laws } else { &[] },
        };
        let own_rate = damping_rate.is_some();
        let evidence = suspect
            .found()
            .or_else(|| suspect.own_law(parameters.times.ends()))
            .or_else(|| environment.found(Exposure { kicks, gravity_off, own_rate }))
            .or_else(|| if kicks { environment.law_at_fault(suspect.state()) } else { None });
        let cause = environment.cause(system, breach, evidence);
        Refused { body: entities[self.start + row], transform, state, cause }
    }
}

/// Integrates a table on all threads. The bits are the same with any number of them.
fn shared(threads: &Threads, table: &TableTick<'_>, batch: Batch<'_>) -> Done {
    let share = batch.bodies.len().div_ceil(threads.count()).next_multiple_of(kernels::BLOCK);
    let mut parts: Vec<(Done, Option<Batch<'_>>, TablePart<'_>)> = Vec::new();
    let (mut rest, mut start) = (Some(batch), 0);
    while let Some(batch) = rest {
        let rows = batch.bodies.len().min(share);
        let (first, others) = batch.split_at(rows);
        parts.push((Done::default(), Some(first), TablePart { table, start }));
        start += rows;
        rest = (!others.bodies.is_empty()).then_some(others);
    }
    let jobs = parts.iter_mut().map(|(done, batch, part)| -> Job<'_> {
        Box::new(move || {
            if let Some(batch) = batch.take() {
                *done = part.integrate(batch);
            }
        })
    });
    threads.run(jobs.collect());
    let mut sum = Done::default();
    for (done, ..) in parts {
        sum.statistics.add(&done.statistics);
        if let Some(record) = done.statistics.record {
            sum.statistics.record.get_or_insert_default().append(record);
        }
        sum.refused.extend(done.refused);
    }
    sum
}

/// Integrates a tick of all bodies of a system.
fn advance<Who: ArchetypeFilter>(
    kernel: Kernel,
    mut param: EnvironmentParam,
    mut output: TickOutput,
    mut bodies: Bodies<Who>,
) {
    param.prepare();
    let environment = param.environment();
    let called = environment.called();
    let without_gravity = environment.parameters(kernel.traits, &called);
    let mut with_gravity = without_gravity;
    with_gravity.gravity += environment.free_fall();
    for columns in
        bodies.contiguous_iter_mut().expect("every component of a body is stored in tables")
    {
        let BodyColumnsContiguousItem {
            entity: entities,
            transform: mut transforms,
            body: mut bodies,
            force: forces,
            options,
            mut last_step,
            mut last_acceleration,
        } = columns;
        let gravity_off = options.gravity_off();
        let (pushed, births) = (param.pushed_of(entities[0]), param.births_of(entities[0]));
        // A kick moves nothing, so no position is marked as changed.
        let transforms = if kernel.traits.moves {
            &mut *transforms
        } else {
            transforms.bypass_change_detection()
        };
        let method_state = match (&mut last_step, &mut last_acceleration) {
            (Some(steps), _) => {
                MethodStateRows::LastStep(bytemuck::cast_slice_mut(steps.bypass_change_detection()))
            }
            (None, Some(cached)) => MethodStateRows::LastAcceleration(
                LastAcceleration::peel_slice_mut(cached.bypass_change_detection()),
            ),
            (None, None) => MethodStateRows::None,
        };
        let applied =
            AppliedForces { forces: bytemuck::cast_slice(forces), rows: pushed, offset: 0 };
        let batch = Batch {
            positions: bytemuck::cast_slice_mut(transforms),
            bodies: bytemuck::cast_slice_mut(bodies.bypass_change_detection()),
            applied: (!pushed.is_empty()).then_some(applied),
            method_state,
        };
        let table = TableTick {
            kernel,
            entities,
            forces,
            options: options.is_more().then_some(&options as _),
            gravity_off,
            environment: &environment,
            parameters: if gravity_off { &without_gravity } else { &with_gravity },
            births,
            records: &output.records,
        };
        let done = match Threads::for_rows(param.threads(), entities.len()) {
            Some(threads) => shared(threads, &table, batch),
            None => TablePart { table: &table, start: 0 }.integrate(batch),
        };
        output.evaluations.add(&done.statistics, environment.summed(gravity_off));
        output.records.add(entities, done.statistics.record.as_ref(), 0);
        done.refused.into_iter().for_each(|refused| output.quarantine.refuse(refused));
    }
}

/// `v += (F w + g) h`: forces and laws become acceleration, acceleration becomes velocity.
///
/// A body of inverse mass 0 is not accelerated. With [`DampingModel::Exact`](crate::DampingModel::Exact) the decay is
/// part of this update. Laws of position or velocity need [`integrate_in_one_pass`], which evaluates them before
/// either half of the step.
pub fn integrate_acceleration(
    param: EnvironmentParam,
    output: TickOutput,
    bodies: Bodies<Unmarked>,
) {
    advance(const { Kernel::of::<Kick>() }, param, output, bodies);
}

/// `x += v h`, with the damping, speed limit and axis locks that apply before and after the move.
pub fn integrate_velocity(param: EnvironmentParam, output: TickOutput, bodies: Bodies<Unmarked>) {
    advance(const { Kernel::of::<Drift>() }, param, output, bodies);
}

/// Both halves of a step of `M`, one of the two explicit Eulers, in one pass over memory, with the bits of
/// [`integrate_acceleration`] and [`integrate_velocity`] in the order of `M`.
pub fn integrate_in_one_pass<M: Integrator>(
    param: EnvironmentParam,
    output: TickOutput,
    bodies: Bodies<Unmarked>,
) {
    advance(const { Kernel::of::<M>() }, param, output, bodies);
}

/// Makes the system that integrates a tick of `kernel` for the bodies that `which` selects.
pub(crate) fn integrate(
    world: &mut World,
    kernel: Kernel,
    which: &BodyFilter,
    name: String,
) -> BoxedSystem {
    let state: SystemState<(EnvironmentParam, TickOutput, Bodies<()>)> =
        (ParamBuilder, ParamBuilder, which.query()).build_state(world);
    let system =
        state.build_system(move |param, output, bodies| advance(kernel, param, output, bodies));
    Box::new(system.with_name(name))
}
