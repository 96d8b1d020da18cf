//! What acts in a tick, read from a world, and where its systems note what happened.

use std::ops::Range;

use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use smallvec::SmallVec;

use crate::kernels::Terms;
use crate::kernels::evaluations::Evaluations;
use crate::kernels::record::TickRecords;
use crate::laws::course::Course;
use crate::laws::damping::Damping;
use crate::laws::epoch::Epoch;
use crate::laws::{Affine, Declared, Drag, Gravity, Law, Laws, Wells};
use crate::methods::Integrator;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::emitter::Emissions;
use crate::state::forces::PushedBodies;
use crate::state::range::{self, Bounds};
use crate::state::substeps::Substeps;
use crate::state::threads::Threads;
use crate::tick::quarantine::Quarantine;
use crate::units::{Scalar, Vector};

/// What acts in a tick besides the applied forces.
#[derive(SystemParam)]
pub struct Acting<'w, 's> {
    step: Res<'w, TimeStep>,
    substeps: Option<Res<'w, Substeps>>,
    clock: Option<Res<'w, StepClock>>,
    gravity: Option<Res<'w, Gravity>>,
    damping: Option<Res<'w, Damping>>,
    range: Option<Res<'w, range::Range>>,
    drag: Option<Res<'w, Drag>>,
    wells: Option<Res<'w, Wells>>,
    laws: Option<Res<'w, Laws>>,
    pub(super) threads: Option<Res<'w, Threads>>,
    pushed: Res<'w, PushedBodies>,
    entities: &'w Entities,
    /// Table and row of the pushed bodies, ascending; kept, so that a tick allocates nothing.
    rows: Local<'s, Vec<(usize, usize)>>,
    emissions: Option<Res<'w, Emissions>>,
    /// Those of the bodies that are born in the tick, ascending.
    births: Local<'s, Vec<Birth>>,
    laws_epoch: ResMut<'w, Epoch>,
    /// That of the running tick.
    epoch: Local<'s, u64>,
}

/// A body that is born in the tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Birth {
    /// Its table and row.
    pub place: (usize, usize),
    /// s since the scene's start.
    pub time: Scalar,
}

/// Where a system notes what happened.
#[derive(SystemParam)]
pub struct Notes<'w> {
    pub(crate) quarantine: ResMut<'w, Quarantine>,
    pub(crate) evaluations: ResMut<'w, Evaluations>,
    pub(crate) records: ResMut<'w, TickRecords>,
}

impl Acting<'_, '_> {
    /// Looks up where the pushed and the newborn bodies are, and whether laws have changed.
    pub(crate) fn prepare(&mut self) {
        let changed = [
            self.drag.as_ref().map(DetectChanges::last_changed),
            self.wells.as_ref().map(DetectChanges::last_changed),
            self.laws.as_ref().map(DetectChanges::last_changed),
        ];
        *self.epoch = self.laws_epoch.bypass_change_detection().look(changed);
        let Self { pushed, entities, rows, emissions, births, clock, .. } = self;
        let place = |body: &Entity| {
            let place = entities.get_spawned(*body).ok()?;
            Some((place.table_id.as_usize(), place.table_row.index()))
        };
        rows.clear();
        rows.extend(pushed.0.iter().filter_map(place));
        rows.sort_unstable();
        rows.dedup();
        births.clear();
        if let (Some(emissions), Some(clock)) = (emissions, clock) {
            let born = emissions.births_in(clock.ticks());
            births.reserve(2 * born.len());
            births.extend(
                born.iter().filter_map(|(body, time)| Some(Birth { place: place(body)?, time: *time })),
            );
            births.sort_unstable_by_key(|birth| birth.place);
        }
    }

    /// Laws of every body, gravity aside.
    pub(crate) fn declared(&self) -> Declared<'_> {
        let more = self.laws.as_deref().map_or(&[][..], |laws| &laws.0);
        Declared { drag: self.drag.as_deref(), wells: self.wells.as_deref(), more }
    }

    fn course(&self) -> Course {
        let TimeStep(tick) = *self.step;
        let clock = self.clock.as_deref().copied().unwrap_or_default();
        let substeps = Substeps::parts(self.substeps.as_deref());
        Course { start: clock.scene_seconds(), end: clock.after(tick).scene_seconds(), tick, substeps }
    }

    /// What acts on every body, gravity aside: the affine ones of the laws `summed`, and those `called`.
    pub(crate) fn terms<'a, M: Integrator>(
        &self,
        summed: Declared<'_>,
        called: &'a [&'a dyn Law<Scalar>],
    ) -> Terms<'a, Scalar> {
        let damping = self.damping.as_deref().copied();
        Terms::new::<M>(Affine::sum(summed.all()), damping, called, *self.epoch, self.course())
            .within(self.bounds())
    }

    /// What a state that is stored may be at most.
    pub(crate) fn bounds(&self) -> Bounds<Scalar> {
        Bounds::of(self.range.as_deref())
    }

    pub(crate) fn range(&self) -> Option<&range::Range> {
        self.range.as_deref()
    }

    pub(crate) fn damping(&self) -> Option<&Damping> {
        self.damping.as_deref()
    }

    /// Start and end of the tick, s.
    pub(crate) fn times(&self) -> [Scalar; 2] {
        let Course { start, end, .. } = self.course();
        [start, end]
    }

    pub(crate) fn gravity(&self) -> Option<Vector> {
        self.gravity.as_deref().and_then(Gravity::acting)
    }

    pub(crate) fn drag(&self) -> Option<&Drag> {
        self.drag.as_deref()
    }

    /// Names of the laws that are summed up in a table's terms.
    pub(crate) fn affine(&self, gravity_off: bool) -> impl Iterator<Item = &'static str> {
        let gravity = (!gravity_off && self.gravity().is_some()).then_some("gravity");
        let exact = self.damping.as_deref().is_some_and(Damping::is_exact);
        let affine = self.declared().affine().map(|law| law.name());
        gravity.into_iter().chain(exact.then_some("damping")).chain(affine)
    }

    /// Table and row of `body`.
    pub(crate) fn place_of(&self, body: Entity) -> Option<(usize, usize)> {
        let place = self.entities.get_spawned(body).ok()?;
        Some((place.table_id.as_usize(), place.table_row.index()))
    }

    /// The table of `body`.
    pub(crate) fn table_of(&self, body: Entity) -> Option<usize> {
        self.place_of(body).map(|(table, _)| table)
    }

    /// What was pushed of those rows of a table.
    pub(crate) fn pushed_in(&self, table: usize, rows: Range<usize>) -> &[(usize, usize)] {
        let start = self.rows.partition_point(|place| *place < (table, rows.start));
        let end = self.rows.partition_point(|place| *place < (table, rows.end));
        &self.rows[start..end]
    }

    /// What was pushed of the table that holds `body`.
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

/// Laws that are called for every body, in a list that allocates nothing.
pub(crate) type Called<'a> = SmallVec<[&'a dyn Law<Scalar>; 8]>;
