//! Soft bodies as a whole: sums over their points, and the distribution of a push over the points.

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::{Dormant, PhysicsBody, Push, Quarantined, SoftBody, Transform};
use scene::SoftBodyName;

/// Sums over the points and springs of a soft body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SoftSum {
    /// Center of mass, m.
    pub position: DVec3,
    /// Displacement of the center of mass from its place in the scene, m.
    pub displacement: DVec3,
    /// All movable points as one body.
    pub body: PhysicsBody,
    pub points: usize,
    pub pinned: usize,
    pub quarantined: usize,
    pub springs: usize,
    /// Kinetic energy of the movable points, J.
    pub kinetic_energy: f64,
    /// `k (L - L0)² / 2` summed over the springs, J.
    pub spring_energy: f64,
}

/// The pushes for a force of `newtons` on `thing`. On a soft body the force is distributed by mass, so that all movable points
/// gain the same speed; immovable points get no push.
pub(crate) fn pushes_on(world: &World, thing: Entity, newtons: DVec3) -> Vec<Push> {
    let Some(body) = world.get::<SoftBody>(thing) else {
        return vec![Push { body: thing, newtons }];
    };
    let mass = mass(world, body);
    let share = |(body, point): (Entity, &PhysicsBody)| Push {
        body,
        newtons: newtons * (point.mass() / mass),
    };
    movable_points(world, body).map(share).collect()
}

impl SoftSum {
    /// The sums of `thing`, if it is a soft body with points.
    pub fn of(simulation: &Simulation, thing: Entity) -> Option<Self> {
        let world = &simulation.world;
        let body = world.get::<SoftBody>(thing)?;
        let place = |point| Some(world.get::<Transform>(point)?.position);
        let at_start = |point| match simulation.id(point) {
            Some(id) => Some(simulation.scene.bodies.get(id as usize)?.position),
            None => place(point),
        };
        let position = center_of_mass(world, body, place)?;
        let displacement = position - center_of_mass(world, body, at_start)?;
        let count = |with: &dyn Fn(EntityRef<'_>) -> bool| {
            body.points.iter().filter(|point| world.get_entity(**point).is_ok_and(with)).count()
        };
        let energies = body.springs.iter().filter_map(|spring| {
            let [a, b] =
                spring.ends.map(|end| body.points.get(end as usize).copied().and_then(place));
            Some(spring.elastic.energy(a?.distance(b?)))
        });
        Some(Self {
            position,
            displacement,
            body: together(world, body),
            points: count(&|_| true),
            pinned: count(&|point| {
                point.get::<PhysicsBody>().is_some_and(|state| state.inverse_mass <= 0.0)
            }),
            quarantined: count(&|point| point.contains::<Quarantined>()),
            springs: body.springs.len(),
            kinetic_energy: kinetic_energy(world, body),
            spring_energy: energies.sum(),
        })
    }
}

/// Name of a soft body: its own name, or the name of its first point up to the first dot.
pub(crate) fn soft_name(simulation: &Simulation, thing: Entity) -> Option<String> {
    if let Some(name) = simulation.world.get::<SoftBodyName>(thing) {
        return Some(name.0.clone());
    }
    let first = simulation.world.get::<SoftBody>(thing)?.points.first()?;
    let name = simulation.scene.names.get(simulation.id(*first)?)?;
    Some(name.split('.').next().unwrap_or_default().to_owned())
}

/// The points of a soft body that forces move.
fn movable_points<'a>(
    world: &'a World,
    body: &'a SoftBody,
) -> impl Iterator<Item = (Entity, &'a PhysicsBody)> + 'a {
    body.points.iter().filter_map(|point| Some((*point, moved_by_forces(world, *point)?)))
}

/// The state of a body, if forces move it now.
pub(crate) fn moved_by_forces(world: &World, body: Entity) -> Option<&PhysicsBody> {
    let thing = world.get_entity(body).ok()?;
    let free = !thing.contains::<Quarantined>() && !thing.contains::<Dormant>();
    thing.get::<PhysicsBody>().filter(|state| free && state.inverse_mass > 0.0)
}

/// Mass of the points that forces move, kg.
pub(crate) fn mass(world: &World, body: &SoftBody) -> f64 {
    movable_points(world, body).map(|(_, point)| point.mass()).sum()
}

/// The movable points as one body.
pub(crate) fn together(world: &World, body: &SoftBody) -> PhysicsBody {
    let mass = mass(world, body);
    let momentum: DVec3 = movable_points(world, body).map(|(_, point)| point.momentum()).sum();
    if mass > 0.0 {
        PhysicsBody::with_mass(mass).moving_at(momentum / mass)
    } else {
        PhysicsBody::IMMOVABLE
    }
}

/// Kinetic energy of the movable points, J.
pub(crate) fn kinetic_energy(world: &World, body: &SoftBody) -> f64 {
    movable_points(world, body).map(|(_, point)| point.kinetic_energy()).sum()
}

/// The center of mass of the movable points, each at its `place`, m; without movable points, the mean place of all points.
pub(crate) fn center_of_mass(
    world: &World,
    body: &SoftBody,
    place: impl Fn(Entity) -> Option<DVec3>,
) -> Option<DVec3> {
    let mean = |points: &mut dyn Iterator<Item = (Entity, f64)>| {
        let placed = points.filter_map(|(point, mass)| Some((place(point)?, mass)));
        let (moment, mass) =
            placed.fold((DVec3::ZERO, 0.0), |(sum, all), (at, mass)| (sum + at * mass, all + mass));
        (mass > 0.0).then(|| moment / mass)
    };
    mean(&mut movable_points(world, body).map(|(point, state)| (point, state.mass())))
        .or_else(|| mean(&mut body.points.iter().map(|point| (*point, 1.0))))
}
