//! Emitters of a world in plain arrays.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use super::Bare;
use crate::state::components::Quarantined;
use crate::state::emitter::{Emission, Emitter, Tick};
use crate::state::method_state::CachedAcceleration;
use crate::state::switched_off::Off;
use crate::units::Vector;

/// An emitter and the rows of its pool.
#[derive(Debug)]
pub(super) struct Source {
    emitter: Emitter,
    pub emission: Emission,
    is_on: bool,
    /// The row of every slot; `None` if its body was removed or quarantined.
    rows: Vec<Option<usize>>,
}

impl Bare {
    /// Copies the emitters of a world, whose bodies have these `rows`.
    pub(super) fn add_sources(&mut self, world: &mut World, rows: &EntityHashMap<usize>) {
        let mut emitters = world.query::<(Option<&Emitter>, Option<&Off<Emitter>>, &Emission)>();
        let world = &*world;
        for (on, off, emission) in emitters.iter(world) {
            let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) else { continue };
            let mut emission = emission.clone();
            emission.fit(emitter);
            let is_sound = |body: &Entity| world.get::<Quarantined>(*body).is_none();
            let row = |body: &Entity| rows.get(body).copied().filter(|_| is_sound(body));
            let rows = emitter.pool.iter().map(row).collect();
            self.sources.push(Source { emitter: emitter.clone(), emission, is_on: on.is_some(), rows });
        }
    }

    /// Applies the births and deaths of the coming tick.
    pub(super) fn emit(&mut self) {
        let tick = Tick::next(self.clock, self.step);
        let Self { sources, individuals, positions, bodies, last_steps, cached, .. } = self;
        for Source { emitter, emission, is_on, rows } in sources {
            emission.advance(emitter, *is_on, tick, |slot, born| {
                let Some(row) = rows[slot] else { return };
                let [x, y, z] = born.map_or(Vector::ZERO, |_| emitter.launches[slot]).to_array();
                positions[row] = emitter.position.to_array();
                bodies[row] = [x, y, z, emitter.inverse_mass];
                // Nothing is left of an earlier life.
                last_steps.get_mut(row).into_iter().for_each(|step| *step = 0.0);
                cached.get_mut(row).into_iter().for_each(|cached| *cached = CachedAcceleration::default());
                let kind = &mut individuals.kinds[row];
                (kind.born, kind.apart) = (born, born.is_none());
                individuals.outdated = true;
            });
        }
    }

    /// Takes from the emissions which particles are alive.
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
