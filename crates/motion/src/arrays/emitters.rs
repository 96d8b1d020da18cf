//! Emitters of a world in plain arrays.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use super::Bare;
use crate::kernels::record::vector;
use crate::schedule::emission::{carrier_state, ride};
use crate::state::components::Quarantined;
use crate::state::emitter::{Emission, Emitter, RidesOn, Tick};
use crate::state::method_state::CachedAcceleration;
use crate::state::switched_off::Off;
use crate::units::Vector;

/// An emitter and the rows of its pool.
#[derive(Debug)]
pub(super) struct Source {
    emitter: Emitter,
    pub emission: Emission,
    is_on: bool,
    /// The row of the carrier, if the emitter rides on a body; the inner `None` is a body that cannot carry it.
    carrier: Option<Option<usize>>,
    /// The row of every slot; `None` if its body was removed or quarantined.
    rows: Vec<Option<usize>>,
}

impl Bare {
    /// Copies the emitters of a world, whose bodies have these `rows`.
    pub(super) fn add_sources(&mut self, world: &mut World, rows: &EntityHashMap<usize>) {
        let mut emitters =
            world.query::<(Option<&Emitter>, Option<&Off<Emitter>>, Option<&RidesOn>, &Emission)>();
        let world = &*world;
        for (on, off, carrier, emission) in emitters.iter(world) {
            let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) else { continue };
            let mut emission = emission.clone();
            emission.fit(emitter);
            let is_sound = |body: &Entity| world.get::<Quarantined>(*body).is_none();
            let row = |body: &Entity| rows.get(body).copied().filter(|_| is_sound(body));
            let carrier =
                carrier.map(|carrier| carrier_state(world, *carrier).and_then(|_| row(&carrier.0)));
            let rows = emitter.pool.iter().map(row).collect();
            let emitter = emitter.clone();
            self.sources.push(Source { emitter, emission, is_on: on.is_some(), carrier, rows });
        }
    }

    /// Applies the births and deaths of the coming tick.
    pub(super) fn emit(&mut self) {
        let tick = Tick::next(self.clock, self.step);
        let Self { sources, individuals, positions, bodies, last_steps, cached, .. } = self;
        for Source { emitter, emission, is_on, carrier, rows } in sources {
            emission.advance(emitter, *is_on, tick, |slot, born| {
                let Some(row) = rows[slot] else { return };
                let mut position = emitter.position;
                let mut birth = born.map(|time| (time, emitter.launches[slot]));
                if let Some(carrier) = carrier {
                    let state =
                        |row: usize| (Vector::from_array(positions[row]), vector(&bodies[row]));
                    (position, birth) = ride(carrier.map(state), position, birth, tick.start);
                }
                let born = birth.map(|(time, _)| time);
                let [x, y, z] = birth.map_or(Vector::ZERO, |(_, launch)| launch).to_array();
                positions[row] = position.to_array();
                bodies[row] = [x, y, z, emitter.inverse_mass];
                // Clear the method state of the earlier particle in this slot.
                last_steps.get_mut(row).into_iter().for_each(|step| *step = 0.0);
                cached
                    .get_mut(row)
                    .into_iter()
                    .for_each(|cached| *cached = CachedAcceleration::default());
                let kind = &mut individuals.kinds[row];
                (kind.born, kind.apart) = (born, born.is_none());
                individuals.outdated = true;
            });
        }
    }

    /// Updates which particles are alive, from the emissions.
    pub(super) fn update_living(&mut self) {
        for Source { emission, rows, .. } in &self.sources {
            for (slot, row) in rows.iter().enumerate() {
                if let Some(row) = row {
                    self.individuals.kinds[*row].apart = !emission.lives(slot);
                }
            }
        }
    }
}
