//! The systems that integrate bodies, over the tables of the world.

use std::ops::Range;

use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use bytemuck::TransparentWrapper as _;

use crate::kernels::record::TickRecords;
use crate::kernels::{self, Account, Applied, Asks, MemoryRows, Table, Terms};
use crate::laws::BodyState;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::methods::Integrator;
use crate::methods::euler::{Drift, Kick};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::state::components::{
    AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, SpeedLimit, Transform,
};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::range::Breach;
use crate::state::rest::Static;
use crate::state::substeps::OwnSubsteps;
use crate::state::threads::Threads;
use crate::tick::diagnosis::{Evidence, Exposure, Suspect};
use crate::tick::environment::{Birth, Environment, EnvironmentParam, TickOutput};
use crate::tick::quarantine::Refused;
use crate::units::{Scalar, Vector};

/// Bodies that are integrated with the world's method.
pub type Unmarked = Without<OwnMethod>;

/// The columns of a body that the integration may need; most bodies have the first four.
type Columns = (
    Entity,
    &'static mut Transform,
    &'static mut PhysicsBody,
    &'static Force,
    Has<GravityOff>,
    Option<&'static DampingRate>,
    Option<&'static SpeedLimit>,
    Option<&'static AxisLocks>,
    Option<&'static OwnLaws>,
    Option<&'static OwnSubsteps>,
    Option<&'static mut LastStep>,
    Option<&'static mut LastAcceleration>,
);

/// The bodies of a system.
pub type Bodies<'w, 's, Who> =
    Query<'w, 's, Columns, (Who, Without<Quarantined>, Without<Static>, Without<Dormant>, Without<Grouped>)>;

/// The rows of a table, or a part of them.
struct Chunk<'a> {
    entities: &'a [Entity],
    transforms: &'a mut [Transform],
    bodies: &'a mut [PhysicsBody],
    forces: &'a [Force],
    rates: Option<&'a [DampingRate]>,
    limits: Option<&'a [SpeedLimit]>,
    locks: Option<&'a [AxisLocks]>,
    own: Option<&'a [OwnLaws]>,
    parts: Option<&'a [OwnSubsteps]>,
    steps: Option<&'a mut [LastStep]>,
    known: Option<&'a mut [LastAcceleration]>,
}

/// A row that was not updated.
struct Missed {
    body: Entity,
    /// The state to freeze it at.
    transform: Transform,
    state: PhysicsBody,
    system: &'static str,
    breach: Breach,
    /// What is at fault, if it is of this body alone.
    evidence: Option<Evidence>,
    own_rate: bool,
}

/// What became of a chunk.
#[derive(Default)]
struct Done {
    account: Account,
    missed: Vec<Missed>,
}

impl<'a> Chunk<'a> {
    /// Splits the first `rows` off.
    fn split_at(self, rows: usize) -> (Self, Self) {
        macro_rules! split {
            ($($name:ident),*; $($maybe:ident),*; $($own:ident),*; $($maybe_own:ident),*) => {{
                $(let $name = self.$name.split_at(rows);)*
                $(let $own = self.$own.split_at_mut(rows);)*
                $(let $maybe = self.$maybe.map(|column| column.split_at(rows)).unzip();)*
                $(let $maybe_own = self.$maybe_own.map(|column| column.split_at_mut(rows)).unzip();)*
                (
                    Self { $($name: $name.0,)* $($own: $own.0,)* $($maybe: $maybe.0,)* $($maybe_own: $maybe_own.0),* },
                    Self { $($name: $name.1,)* $($own: $own.1,)* $($maybe: $maybe.1,)* $($maybe_own: $maybe_own.1),* },
                )
            }};
        }
        split!(entities, forces; rates, limits, locks, own, parts; transforms, bodies; steps, known)
    }

    /// Integrates a tick of every row; `pushed` and `births` are those of the table, in which the chunk begins at
    /// row `start`; `records` tells whether it is written down.
    fn integrate<M: Integrator>(
        mut self,
        terms: &Terms<'_, Scalar>,
        pushed: &[(usize, usize)],
        births: &[Birth],
        start: usize,
        records: &TickRecords,
    ) -> Done {
        let mut done = Done::default();
        done.account.record = records.recorder(self.bodies.len());
        let rows = self.bodies.len();
        let row = |row: usize| births.partition_point(|birth| birth.place.1 < start + row);
        let mut next = 0;
        for Birth { place, time } in &births[row(0)..row(rows)] {
            let born = place.1 - start;
            self.integrate_rows::<M>(next..born, terms, pushed, start, &mut done);
            self.integrate_rows::<M>(born..born + 1, &terms.since::<M>(*time), pushed, start, &mut done);
            next = born + 1;
        }
        self.integrate_rows::<M>(next..rows, terms, pushed, start, &mut done);
        done
    }

    /// The same for some of the rows, all of which have the same tick.
    fn integrate_rows<M: Integrator>(
        &mut self,
        rows: Range<usize>,
        terms: &Terms<'_, Scalar>,
        pushed: &[(usize, usize)],
        start: usize,
        done: &mut Done,
    ) {
        if rows.is_empty() {
            return;
        }
        let mut refused: Vec<(usize, Breach)> = Vec::new();
        let asks = self.limits.is_some()
            || self.locks.is_some()
            || self.own.is_some()
            || self.parts.is_some()
            || self.rates.is_some();
        if asks {
            for row in rows {
                if let Err(breach) = self.integrate_row::<M>(terms, row, &mut done.account) {
                    refused.push((row, breach));
                }
            }
        } else {
            let applied = Applied::of(&self.forces[rows.clone()], pushed, start + rows.start);
            let table = self.table(rows.clone());
            let refuse = &mut |row, breach| refused.push((rows.start + row, breach));
            if let Some(record) = &mut done.account.record {
                record.first = rows.start;
            }
            kernels::integrate::<_, M>(terms, table, applied, &mut done.account, refuse);
        }
        for (row, breach) in refused {
            let missed = self.diagnose::<M>(terms, row, breach);
            done.missed.push(missed);
        }
    }

    /// One row with everything that it asks for, or why it was refused.
    fn integrate_row<M: Integrator>(
        &mut self,
        terms: &Terms<'_, Scalar>,
        row: usize,
        account: &mut Account,
    ) -> Result<(), Breach> {
        if let Some(record) = &mut account.record {
            record.first = row;
        }
        let own = self.own.map(|own| &own[row]);
        let rate = self.rates.as_ref().map(|rates| rates[row].rate());
        let asks = Asks {
            damping: rate.zip(terms.damping).map(|(rate, damping)| Damping { rate, ..damping }),
            limit: self.limits.map(|limits| limits[row].0),
            locks: self.locks.map(|locks| locks[row]),
            laws: own.map_or(&[], OwnLaws::laws),
            version: own.map_or(0, OwnLaws::version),
            substeps: self.parts.map(|parts| parts[row].0.max(1)),
        };
        let force = self.forces[row].0.to_array();
        kernels::integrate_one::<_, M>(terms, &asks, self.table(row..row + 1), force, account)
    }

    fn table(&mut self, rows: Range<usize>) -> Table<'_, Scalar> {
        let memory = match (&mut self.steps, &mut self.known) {
            (Some(steps), _) => MemoryRows::LastStep(bytemuck::cast_slice_mut(&mut steps[rows.clone()])),
            (None, Some(known)) => {
                MemoryRows::Known(LastAcceleration::peel_slice_mut(&mut known[rows.clone()]))
            }
            (None, None) => MemoryRows::None,
        };
        Table {
            positions: bytemuck::cast_slice_mut(&mut self.transforms[rows.clone()]),
            bodies: bytemuck::cast_slice_mut(&mut self.bodies[rows]),
            memory,
        }
    }

    /// What went wrong in a row. Of a step that no number comes out of the first of the two updates of Euler stands if
    /// it can, as it does where the two are systems of their own; in a tick of several steps, and at the border of a
    /// range, none does.
    #[cold]
    fn diagnose<M: Integrator>(&mut self, terms: &Terms<'_, Scalar>, row: usize, breach: Breach) -> Missed {
        const KICK: &str = "integrate_acceleration";
        const DRIFT: &str = "integrate_velocity";
        let account = &mut Account::default();
        let before = (self.transforms[row], self.bodies[row]);
        let (system, breach) = match M::METHOD {
            _ if !M::DAMPS_INSIDE => ("integrate", breach),
            _ if !M::MOVES => (KICK, breach),
            _ if !M::KICKS => (DRIFT, breach),
            Method::SemiImplicitEuler => match self.integrate_row::<Kick>(terms, row, account) {
                Ok(()) => (DRIFT, breach),
                Err(breach) => (KICK, breach),
            },
            _ => match self.integrate_row::<Drift>(terms, row, account) {
                Ok(()) => (KICK, breach),
                Err(breach) => (DRIFT, breach),
            },
        };
        let substeps = self.parts.map_or(terms.course.substeps, |parts| parts[row].0);
        if breach.finite || substeps > 1 {
            (self.transforms[row], self.bodies[row]) = before;
        }
        let damping_rate = self.rates.map(|rates| rates[row].rate()).filter(|_| terms.damping.is_some());
        let suspect = Suspect {
            position: self.transforms[row].position,
            body: self.bodies[row],
            force: if M::KICKS { self.forces[row].0 } else { Vector::ZERO },
            damping_rate,
            limit: self.limits.map(|limits| limits[row].0),
            last_step: self.steps.as_ref().map(|steps| steps[row].0),
            laws: self.own.filter(|_| M::KICKS).map_or(&[], |own| own[row].laws()),
        };
        let times = terms.course.ends();
        Missed {
            body: self.entities[row],
            transform: self.transforms[row],
            state: self.bodies[row],
            system,
            breach,
            evidence: suspect.found().or_else(|| suspect.own_law(times)),
            own_rate: damping_rate.is_some(),
        }
    }
}

impl Environment<'_> {
    /// Names the cause, from what was found in the row and what acts on every body.
    #[cold]
    fn judge(&self, missed: Missed, kicks: bool, gravity_off: bool) -> Refused {
        let Missed { body, transform, state, system, breach, evidence, own_rate } = missed;
        let PhysicsBody { velocity, inverse_mass } = state;
        let at = BodyState { position: transform.position, velocity, inverse_mass };
        let evidence = evidence
            .or_else(|| self.found(Exposure { kicks, gravity_off, own_rate }))
            .or_else(|| if kicks { self.law_at_fault(at) } else { None });
        Refused { body, transform, state, cause: self.cause(system, breach, evidence) }
    }
}

/// Integrates a chunk on all threads.
fn shared<M: Integrator>(
    threads: &Threads,
    chunk: Chunk<'_>,
    terms: &Terms<'_, Scalar>,
    pushed: &[(usize, usize)],
    births: &[Birth],
    records: &TickRecords,
) -> Done {
    let share = chunk.bodies.len().div_ceil(threads.count()).next_multiple_of(kernels::BLOCK);
    let mut parts: Vec<(Done, Option<Chunk<'_>>, usize)> = Vec::new();
    let (mut rest, mut start) = (Some(chunk), 0);
    while let Some(chunk) = rest {
        let rows = chunk.bodies.len().min(share);
        let (first, others) = chunk.split_at(rows);
        parts.push((Done::default(), Some(first), start));
        start += rows;
        rest = (!others.bodies.is_empty()).then_some(others);
    }
    let jobs = parts.iter_mut().map(|(done, chunk, start)| {
        move || {
            if let Some(chunk) = chunk.take() {
                *done = chunk.integrate::<M>(terms, pushed, births, *start, records);
            }
        }
    });
    threads.run(jobs.collect());
    let mut sum = Done::default();
    for (done, ..) in parts {
        sum.account.add(&done.account);
        if let Some(record) = done.account.record {
            sum.account.record.get_or_insert_default().append(record);
        }
        sum.missed.extend(done.missed);
    }
    sum
}

/// One system's share of a tick: `M` over all bodies.
fn advance<M: Integrator, Who: ArchetypeFilter>(
    mut param: EnvironmentParam,
    mut output: TickOutput,
    mut bodies: Bodies<Who>,
) {
    param.prepare();
    let environment = param.environment();
    let called = environment.called();
    let weightless = environment.terms::<M>(&called);
    let mut falling = weightless;
    falling.gravity += environment.free_fall();
    for columns in bodies.contiguous_iter_mut().expect("every component of a body is stored in tables") {
        let (
            entities,
            mut transforms,
            mut bodies,
            forces,
            gravity_off,
            rates,
            limits,
            locks,
            own,
            parts,
            mut steps,
            mut known,
        ) = columns;
        let terms = if gravity_off { &weightless } else { &falling };
        let chunk = Chunk {
            entities,
            // A kick moves nothing, so nothing is marked as moved.
            transforms: if M::MOVES { &mut transforms } else { transforms.bypass_change_detection() },
            bodies: bodies.bypass_change_detection(),
            forces,
            rates,
            limits,
            locks,
            own,
            parts,
            steps: steps.as_mut().map(|steps| steps.bypass_change_detection()),
            known: known.as_mut().map(|known| known.bypass_change_detection()),
        };
        let (pushed, births) = (param.pushed_of(entities[0]), param.births_of(entities[0]));
        let done = match param.threads.as_deref() {
            Some(threads) if threads.count() > 1 && entities.len() >= Threads::FROM => {
                shared::<M>(threads, chunk, terms, pushed, births, &output.records)
            }
            _ => chunk.integrate::<M>(terms, pushed, births, 0, &output.records),
        };
        output.evaluations.add(&done.account, &called, environment.summed(gravity_off));
        output.records.add(entities, done.account.record);
        for missed in done.missed {
            output.quarantine.refuse(environment.judge(missed, M::KICKS, gravity_off));
        }
    }
}

/// `v += (F w + g) h`: forces and laws become acceleration, acceleration becomes velocity.
///
/// A body of inverse mass 0 is passed by whatever acts on it. With
/// [`DampingModel::Exact`](crate::DampingModel::Exact) the decay is part of this update. Laws of the position or
/// the velocity are not for this system and [`integrate_velocity`], but for [`integrate_in_one_pass`], which
/// reads them before either half.
pub fn integrate_acceleration(param: EnvironmentParam, output: TickOutput, bodies: Bodies<Unmarked>) {
    advance::<Kick, _>(param, output, bodies);
}

/// `x += v h`, with the damping, speed limit and axis locks that have their place around the move.
pub fn integrate_velocity(param: EnvironmentParam, output: TickOutput, bodies: Bodies<Unmarked>) {
    advance::<Drift, _>(param, output, bodies);
}

/// Both halves of a step of `M`, one of the two explicit Eulers, in one pass over memory: the same bits as
/// [`integrate_acceleration`] and [`integrate_velocity`] one after the other, in that order or the other.
pub fn integrate_in_one_pass<M: Integrator>(
    param: EnvironmentParam,
    output: TickOutput,
    bodies: Bodies<Unmarked>,
) {
    advance::<M, _>(param, output, bodies);
}

/// A tick of `M` for the bodies `Who`.
pub fn integrate<M: Integrator, Who: ArchetypeFilter>(
    param: EnvironmentParam,
    output: TickOutput,
    bodies: Bodies<Who>,
) {
    advance::<M, _>(param, output, bodies);
}
