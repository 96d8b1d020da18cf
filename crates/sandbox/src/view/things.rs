//! Things: what a person selects, in any world of its scene, and how it moves.

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::{Method, Push, SoftBody, Transform, each_force};
use scene::FileIndex;

use crate::view::forces::{synchronized, synchronized_points};
use crate::view::soft::{center_of_mass, kinetic_energy, together};
use crate::view::stage::Stage;

/// A body or a soft body, in every world of its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Body(u32),
    Soft(FileIndex),
}

impl Thing {
    /// What it is in `simulation`, unless it is gone.
    pub fn entity(self, simulation: &mut Simulation) -> Option<Entity> {
        match self {
            Self::Body(id) => simulation.body(id),
            Self::Soft(index) => {
                let world = &mut simulation.world;
                let mut softs = world.query_filtered::<(Entity, &FileIndex), With<SoftBody>>();
                softs.iter(world).find(|(_, other)| **other == index).map(|(soft, _)| soft)
            }
        }
    }
}

/// How a thing moves at one time; a soft body as its center of mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub position: DVec3,
    /// At the time of the position.
    pub velocity: DVec3,
    /// Acceleration, m/s², and force, N; unknown of a soft body, which pins may hold.
    pub forced: Option<[DVec3; 2]>,
    pub kinetic_energy: f64,
    /// The method that moves it.
    pub method: Method,
}

impl Motion {
    /// The motion of `thing` after `pushes` in the last tick; scenery has none.
    pub fn of(simulation: &mut Simulation, pushes: &[Push], thing: Entity) -> Option<Self> {
        let scene_method = simulation.method();
        let world = &mut simulation.world;
        if let Some(soft) = world.get::<SoftBody>(thing) {
            let own = |point: &Entity| motion::own_method(world.get_entity(*point).ok()?);
            let method = soft.points.iter().find_map(own).unwrap_or(scene_method);
            let position =
                center_of_mass(world, soft, |point| Some(world.get::<Transform>(point)?.position))?;
            let (kinetic_energy, sum) = (kinetic_energy(world, soft), together(world, soft));
            let velocity = synchronized_points(world, pushes, thing, sum).velocity;
            return Some(Self { position, velocity, forced: None, kinetic_energy, method });
        }
        let position = world.get::<Transform>(thing)?.position;
        let mut forces = Vec::new();
        each_force(world, pushes, &[thing], |_, cause, newtons| forces.push((cause, newtons)));
        let body = synchronized(world, thing, &forces)?;
        let force: DVec3 = forces.iter().map(|(_, newtons)| *newtons).sum();
        Some(Self {
            position,
            velocity: body.velocity,
            forced: Some([force * body.inverse_mass, force]),
            kinetic_energy: body.kinetic_energy(),
            method: motion::own_method(world.entity(thing)).unwrap_or(scene_method),
        })
    }
}

impl Stage {
    /// The thing that `entity` is, if it is one.
    pub(crate) fn thing(&self, entity: Entity) -> Option<Thing> {
        let soft = || {
            self.sim.world.get::<SoftBody>(entity)?;
            self.sim.world.get::<FileIndex>(entity).copied().map(Thing::Soft)
        };
        self.seen.ids.get(&entity).copied().map(Thing::Body).or_else(soft)
    }

    /// The thing of that name, if there is one.
    pub(crate) fn thing_named(&mut self, name: &str) -> Option<Thing> {
        let soft = |stage: &mut Self| {
            let world = &mut stage.sim.world;
            let softs: Vec<_> = world.query_filtered::<Entity, With<SoftBody>>().iter(world).collect();
            softs.into_iter().find(|soft| stage.name(*soft) == name)
        };
        let entity = self.sim.named(name).or_else(|| soft(self))?;
        self.thing(entity)
    }
}
