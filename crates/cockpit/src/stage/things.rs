//! Things, which a person selects: their identity in any world of the scene, their motion and their drawn position.

use std::borrow::Cow;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::{
    AutoSubsteps, Dormant, Method, OwnSubsteps, PhysicsBody, PreviousPosition, Push, Quarantined,
    SoftBody, Transform, each_force,
};
use scene::FileIndex;

use crate::stage::Stage;
use crate::stage::forces::{synchronized, synchronized_points};
use crate::stage::query;
use crate::stage::soft::{center_of_mass, kinetic_energy, moved_by_forces, soft_name, together};

/// A body or a soft body, in every world of its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thing {
    Body(u32),
    Soft(FileIndex),
}

impl Thing {
    /// The thing with this name, if any.
    pub fn named(sim: &Simulation, called: &str) -> Option<Self> {
        let soft = || {
            let mut softs = query::<Entity, With<SoftBody>>(&sim.world);
            softs.iter(&sim.world).find(|soft| name(sim, *soft) == called)
        };
        Self::of(sim, sim.named(called).or_else(soft)?)
    }

    /// The thing with this `entity`, if any.
    pub fn of(simulation: &Simulation, entity: Entity) -> Option<Self> {
        let soft = || {
            simulation.world.get::<SoftBody>(entity)?;
            simulation.world.get::<FileIndex>(entity).copied().map(Self::Soft)
        };
        simulation.id(entity).map(Self::Body).or_else(soft)
    }

    /// The entity of the thing in `simulation`, unless it was removed.
    pub fn entity(self, simulation: &Simulation) -> Option<Entity> {
        match self {
            Self::Body(id) => simulation.body(id),
            Self::Soft(index) => {
                let world = &simulation.world;
                let mut softs =
                    world.try_query_filtered::<(Entity, &FileIndex), With<SoftBody>>()?;
                softs.iter(world).find(|(_, other)| **other == index).map(|(soft, _)| soft)
            }
        }
    }
}

/// A hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Picked {
    /// The closest thing, as a whole.
    pub entity: Entity,
    /// Distance from the ray's origin, m.
    pub distance: f64,
    /// The body that a push at the hit acts on, if any.
    pub pushed: Option<Entity>,
}

/// The motion of a thing at one time; of a soft body, the motion of its center of mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub position: DVec3,
    /// Velocity at the time of the position.
    pub velocity: DVec3,
    /// Acceleration, m/s², and force, N; `None` for a soft body, which pins may hold.
    pub forced: Option<[DVec3; 2]>,
    pub kinetic_energy: f64,
    /// Method of the thing.
    pub method: Method,
    /// Substeps of its last tick.
    pub substeps: u32,
}

impl Motion {
    /// The motion of `thing` after `pushes` in the last tick; `None` for scenery.
    pub fn of(simulation: &Simulation, pushes: &[Push], thing: Entity) -> Option<Self> {
        let scene_method = simulation.method();
        let world = &simulation.world;
        if let Some(soft) = world.get::<SoftBody>(thing) {
            let own = |point: &Entity| motion::own_method(world.get_entity(*point).ok()?);
            let method = soft.points.iter().find_map(own).unwrap_or(scene_method);
            let substeps = substeps(simulation, &soft.points);
            let position =
                center_of_mass(world, soft, |point| Some(world.get::<Transform>(point)?.position))?;
            let (kinetic_energy, sum) = (kinetic_energy(world, soft), together(world, soft));
            let velocity = synchronized_points(world, pushes, thing, sum).velocity;
            return Some(Self {
                position,
                velocity,
                forced: None,
                kinetic_energy,
                method,
                substeps,
            });
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
            substeps: substeps(simulation, &[thing]),
        })
    }
}

/// Substeps of the last tick of bodies that are integrated together.
fn substeps(simulation: &Simulation, bodies: &[Entity]) -> u32 {
    let world = &simulation.world;
    let chosen = bodies.iter().find_map(|body| Some(world.get::<AutoSubsteps>(*body)?.last));
    let own = || bodies.iter().find_map(|body| Some(world.get::<OwnSubsteps>(*body)?.0));
    chosen.or_else(own).unwrap_or_else(|| simulation.substeps().least())
}

impl Stage {
    /// Drawn position of a thing, m; for a soft body, of its center of mass.
    pub(crate) fn drawn_position(&self, thing: Entity) -> Option<DVec3> {
        let world = &self.sim.world;
        let drawn_body = |body: Entity| {
            let (now, before) =
                (world.get::<Transform>(body)?, world.get::<PreviousPosition>(body));
            Some(drawn(now, before, self.here.alpha))
        };
        match world.get::<SoftBody>(thing) {
            Some(body) => center_of_mass(world, body, drawn_body),
            None => drawn_body(thing),
        }
    }
}

/// Name of a thing of the scene.
pub fn name(sim: &Simulation, thing: Entity) -> String {
    let own = sim.id(thing).and_then(|id| sim.scene.names.get(id)).map(Cow::into_owned);
    own.or_else(|| soft_name(sim, thing)).unwrap_or_else(|| format!("{thing}"))
}

/// The bodies that a push on `body` moves, and what share of its force each gets: the body itself, and in scenes whose pushes have
/// a radius all movable bodies around `hit`, m.
pub(crate) fn pushed(sim: &Simulation, body: Entity, hit: DVec3) -> Vec<(u32, f64)> {
    let around = sim.scene.push_spec().radius.into_iter().flat_map(|radius| {
        sim.remaining_bodies().filter_map(move |other| {
            moved_by_forces(&sim.world, other).filter(|_| other != body)?;
            let at = sim.world.get::<Transform>(other)?.position;
            let inside = 1.0 - at.distance_squared(hit) / radius.powi(2);
            (inside > 0.0).then_some((sim.id(other)?, inside.powi(2)))
        })
    });
    sim.id(body).map(|id| (id, 1.0)).into_iter().chain(around).collect()
}

/// The movable thing after (`step` 1) or before (`step` -1) the `selection`, cyclically.
pub(crate) fn neighbor(sim: &Simulation, selection: Option<Entity>, step: isize) -> Option<Entity> {
    let world = &sim.world;
    let points = points_of_soft_bodies(world);
    let softs: Vec<_> = query::<Entity, With<SoftBody>>(world).iter(world).collect();
    let awake = |thing: &Entity| world.get::<Dormant>(*thing).is_none();
    let bodies = sim.remaining_bodies().filter(|thing| !points.contains(*thing)).chain(softs);
    let movable: Vec<_> =
        bodies.filter(|thing| awake(thing) && is_movable(world, *thing)).collect();
    let here = movable.iter().position(|thing| Some(*thing) == selection);
    let next = here.and_then(|here| movable.get(here.checked_add_signed(step)?));
    let end = if step > 0 { movable.first() } else { movable.last() };
    next.or(end).copied()
}

/// Whether forces move a thing, or did until it was quarantined; for a soft body, whether they move any of its points.
pub(crate) fn is_movable(world: &World, thing: Entity) -> bool {
    let moves = |body: Entity| {
        let state = world.get::<PhysicsBody>(body);
        state.is_some_and(|state| state.inverse_mass > 0.0)
            || world.get::<Quarantined>(body).is_some()
    };
    match world.get::<SoftBody>(thing) {
        Some(soft) => soft.points.iter().any(|point| moves(*point)),
        None => moves(thing),
    }
}

/// The points of soft bodies, which are never drawn as particles.
pub(crate) fn points_of_soft_bodies(world: &World) -> SoftPoints {
    let mut points = SoftPoints::default();
    let mut bodies = query::<&SoftBody, ()>(world);
    bodies.iter(world).flat_map(|body| &body.points).for_each(|point| points.insert(*point));
    points
}

/// Drawn position of a body, m, interpolated by `alpha` from the last tick to this one.
pub(crate) fn drawn(now: &Transform, before: Option<&PreviousPosition>, alpha: f64) -> DVec3 {
    before.map_or(now.position, |before| before.0 + (now.position - before.0) * alpha)
}

/// A set of points of soft bodies, by entity index. With a hundred thousand particles, hashing each would take longest.
#[derive(Default)]
pub(crate) struct SoftPoints(Vec<Option<Entity>>);

impl SoftPoints {
    fn insert(&mut self, point: Entity) {
        let index = point.index_u32() as usize;
        if index >= self.0.len() {
            self.0.resize(index + 1, None);
        }
        self.0[index] = Some(point);
    }

    pub fn contains(&self, thing: Entity) -> bool {
        self.0.get(thing.index_u32() as usize) == Some(&Some(thing))
    }
}
