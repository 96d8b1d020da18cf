//! The environment of a tick: the laws, forces and settings of all bodies, and the output of the systems.

use std::ops::Range;

use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use smallvec::SmallVec;

use crate::kernels::evaluations::Evaluations;
use crate::kernels::record::TickRecords;
use crate::kernels::{BodyOptions, TickParameters};
use crate::laws::damping::Damping;
use crate::laws::epoch::Epoch;
use crate::laws::tick_times::TickTimes;
use crate::laws::{Affine, Gravity, Law, MutualGravity, SharedLaws, SharedLawsParam};
use crate::methods::Traits;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::emitter::Emissions;
use crate::state::forces::PushedBodies;
use crate::state::range::{self, Bounds};
use crate::state::substeps::Substeps;
use crate::state::threads::Threads;
use crate::tick::quarantine::Quarantine;
use crate::units::Scalar;
use crate::units::Vector;

/// Everything that acts on all bodies in a tick, borrowed from a world or the parameters of a system.
/// The options of single bodies are separate ([`BodyOptions`](crate::kernels::BodyOptions)).
#[derive(Clone, Copy)]
pub(crate) struct Environment<'a> {
    /// Gravity, if it is on.
    pub gravity: Option<&'a Gravity>,
    /// All other laws of single bodies.
    pub laws: SharedLaws<'a>,
    /// Gravity between the bodies of a group.
    pub attraction: Option<&'a MutualGravity>,
    pub damping: Option<Damping>,
    pub range: Option<&'a range::Range>,
    pub times: TickTimes,
    /// Changes whenever the laws do.
    pub epoch: u64,
}

impl<'a> Environment<'a> {
    /// The environment of `world` in a tick of `tick` seconds that begins at the time of `clock`. For observers: its
    /// epoch is not that of cached accelerations.
    pub fn of(world: &'a World, clock: StepClock, tick: Scalar) -> Self {
        Self {
            gravity: world.get_resource::<Gravity>().filter(|gravity| gravity.on),
            laws: SharedLaws::of(world),
            attraction: world.get_resource(),
            damping: world.get_resource().copied(),
            range: world.get_resource(),
            times: TickTimes::new(clock, tick, Substeps::count(world.get_resource())),
            epoch: 0,
        }
    }

    /// The laws that act on a body with these options. Drag acts on the triangles of a sheet, not on its bodies.
    pub fn on_body(
        &self,
        options: &BodyOptions<'a>,
        in_sheet: bool,
    ) -> impl Iterator<Item = &'a dyn Law> + use<'a> {
        self.laws.on_body(self.gravity.filter(|_| !options.gravity_off), in_sheet, options.laws)
    }

    /// Names of the laws that are summed before a tick.
    pub fn summed(&self, gravity_off: bool) -> impl Iterator<Item = &'static str> {
        let gravity = self.gravity.filter(|_| !gravity_off).map(|_| "gravity");
        let exact = self.damping.is_some_and(|damping| damping.is_exact()).then_some("damping");
        gravity.into_iter().chain(exact).chain(self.laws.affine().map(|law| law.name()))
    }
}

impl<'a> Environment<'a> {
    /// The laws that are called for every body: those that are not affine.
    pub fn called(&self) -> Called<'a> {
        let mut called = Called::new();
        called.extend(self.laws.called());
        called
    }

    /// The parameters of a tick of `method`, without gravity; `called` are the [called laws](Self::called).
    pub fn parameters<'c>(&self, method: Traits, called: &'c [&'c dyn Law]) -> TickParameters<'c> {
        TickParameters::new(
            method,
            Affine::sum(self.laws.all()),
            self.damping,
            called,
            self.epoch,
            self.times,
        )
        .within(self.bounds())
    }

    /// Acceleration of free fall, m/s²; zero where gravity is off.
    pub fn free_fall(&self) -> Vector {
        self.gravity.and_then(Law::affine).map_or(Vector::ZERO, |law| law.constant)
    }

    /// The bounds of states that are stored.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.range)
    }
}

/// A list of called laws that allocates nothing.
pub(crate) type Called<'a> = SmallVec<[&'a dyn Law; 8]>;

/// The environment as a parameter of a system, with the rows of bodies that are pushed or born in the tick.
#[derive(SystemParam)]
pub struct EnvironmentParam<'w, 's> {
    step: Res<'w, TimeStep>,
    substeps: Option<Res<'w, Substeps>>,
    clock: Option<Res<'w, StepClock>>,
    gravity: Option<Res<'w, Gravity>>,
    damping: Option<Res<'w, Damping>>,
    range: Option<Res<'w, range::Range>>,
    laws: SharedLawsParam<'w>,
    threads: Option<Res<'w, Threads>>,
    pushed: Res<'w, PushedBodies>,
    entities: &'w Entities,
    /// Table and row of the pushed bodies, ascending; reused, so that a tick allocates nothing.
    rows: Local<'s, Vec<(usize, usize)>>,
    emissions: Option<Res<'w, Emissions>>,
    /// The births of the tick, by table and row.
    births: Local<'s, Vec<Birth>>,
    epoch: ResMut<'w, Epoch>,
}

/// The birth of a particle in the tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Birth {
    /// Table and row of the particle.
    pub place: (usize, usize),
    /// Time since the scene's start, s.
    pub time: Scalar,
}

/// What the systems of a tick write besides the bodies: counts of evaluations, refused bodies, records for a ledger.
#[derive(SystemParam)]
pub struct TickOutput<'w> {
    pub(crate) quarantine: ResMut<'w, Quarantine>,
    pub(crate) evaluations: ResMut<'w, Evaluations>,
    pub(crate) records: ResMut<'w, TickRecords>,
}

impl EnvironmentParam<'_, '_> {
    /// Looks up the rows of pushed bodies and births, and whether laws have changed.
    pub(crate) fn prepare(&mut self) {
        self.epoch.bypass_change_detection().update(self.laws.changes());
        let Self { pushed, entities, rows, emissions, births, clock, .. } = self;
        rows.clear();
        rows.extend(pushed.bodies.iter().filter_map(|body| place_in(entities, *body)));
        rows.sort_unstable();
        rows.dedup();
        births.clear();
        if let (Some(emissions), Some(clock)) = (emissions, clock) {
            let born = emissions.births_in(clock.ticks());
            births.reserve(2 * born.len());
            let birth = |(body, time): &(Entity, Scalar)| {
                Some(Birth { place: place_in(entities, *body)?, time: *time })
            };
            births.extend(born.iter().filter_map(birth));
            births.sort_unstable_by_key(|birth| birth.place);
        }
    }

    /// The environment of this tick, without mutual gravity, which groups add.
    pub(crate) fn environment(&self) -> Environment<'_> {
        let TimeStep(tick) = *self.step;
        let clock = self.clock.as_deref().copied().unwrap_or_default();
        Environment {
            gravity: self.gravity.as_deref().filter(|gravity| gravity.on),
            laws: self.laws.laws(),
            attraction: None,
            damping: self.damping.as_deref().copied(),
            range: self.range.as_deref(),
            times: TickTimes::new(clock, tick, Substeps::count(self.substeps.as_deref())),
            epoch: self.epoch.number(),
        }
    }

    /// The threads that share large worlds.
    pub(crate) fn threads(&self) -> Option<&Threads> {
        self.threads.as_deref()
    }

    /// Whether bodies are pushed.
    pub(crate) fn pushes(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Table and row of `body`.
    pub(crate) fn place_of(&self, body: Entity) -> Option<(usize, usize)> {
        place_in(self.entities, body)
    }

    /// The table of `body`.
    pub(crate) fn table_of(&self, body: Entity) -> Option<usize> {
        self.place_of(body).map(|(table, _)| table)
    }

    /// The pushed rows of a table that lie in `rows`.
    pub(crate) fn pushed_in(&self, table: usize, rows: Range<usize>) -> &[(usize, usize)] {
        let start = self.rows.partition_point(|place| *place < (table, rows.start));
        let end = self.rows.partition_point(|place| *place < (table, rows.end));
        &self.rows[start..end]
    }

    /// The pushed rows of the table that holds `body`.
    pub(super) fn pushed_of(&self, body: Entity) -> &[(usize, usize)] {
        if self.rows.is_empty() {
            return &[];
        }
        self.table_of(body).map_or(&[], |table| self.pushed_in(table, 0..usize::MAX))
    }

    /// The births in the table that holds `body`.
    pub(super) fn births_of(&self, body: Entity) -> &[Birth] {
        let of = |table: usize| self.births.partition_point(|birth| birth.place.0 < table);
        match self.table_of(body).filter(|_| !self.births.is_empty()) {
            Some(table) => &self.births[of(table)..of(table + 1)],
            None => &[],
        }
    }
}

/// Table and row of `body`.
fn place_in(entities: &Entities, body: Entity) -> Option<(usize, usize)> {
    let place = entities.get_spawned(body).ok()?;
    Some((place.table_id.as_usize(), place.table_row.index()))
}
