//! Orbits: the energy of bodies that only attraction moves, negative if they are bound.

use bevy_ecs::prelude::*;

use crate::groups::{Group, Groups, row_of, states_of};
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::laws::{Drag, Gravity, Laws, MutualGravity, SourceMass, Well, Wells};
use crate::state::archetypes::may_exist;
use crate::state::components::{PhysicsBody, Quarantined, StableId, Transform};
use crate::state::coupling::Grouped;
use crate::state::emitter::Particle;
use crate::units::{Scalar, Vector};

/// Bodies that only attraction moves: a single body in wells, or all bodies that attract each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Stable id of the body, or of the first of several.
    pub body: u32,
    /// Kinetic energy about the common center of mass, J.
    pub kinetic: Scalar,
    /// Potential energy, J, 0 at infinity: it is bound while the sum of both is below 0.
    pub potential: Scalar,
    /// Angular frequency of the fastest circle at the present distances, rad/s.
    pub frequency: Scalar,
}

impl Orbit {
    /// Kinetic and potential energy, J.
    #[must_use]
    pub fn energy(&self) -> Scalar {
        self.kinetic + self.potential
    }
}

/// Largest number of bodies whose orbits are computed.
const MOST_ORBITS: usize = 4096;

/// The largest number of bodies that attract each other: their energy takes all pairs.
const MOST_ATTRACTING: usize = 256;

/// Whether attraction is all that can add energy: energy is then conserved, or lost to damping and drag in still air.
fn only_attracts(world: &World) -> bool {
    let falls = world.get_resource::<Gravity>().and_then(Gravity::active_acceleration);
    let falls = falls.is_some_and(|acceleration| acceleration != Vector::ZERO);
    let wind = world.get_resource::<Drag>().is_some_and(|drag| drag.wind.is_some());
    let laws = world.get_resource::<Laws>().is_some_and(|laws| !laws.0.is_empty());
    let attracts = world.contains_resource::<Wells>() != world.contains_resource::<MutualGravity>();
    attracts && !falls && !wind && !laws && !may_exist::<OwnLaws>(world)
}

/// Computes the orbits of `world`, in the order of ids; empty if something but attraction may add energy, or if bodies are too
/// many.
pub fn orbits(world: &mut World) -> Vec<Orbit> {
    if !only_attracts(world) {
        return Vec::new();
    }
    if world.contains_resource::<MutualGravity>() {
        return orbits_of_groups(world);
    }
    let mut query = world
        .query_filtered::<(&StableId, &Transform, &PhysicsBody), (Without<Particle>, Without<Quarantined>, Without<Grouped>)>();
    let world = &*world;
    let Some(Wells(wells)) = world.get_resource() else { return Vec::new() };
    if query.iter(world).count() > MOST_ORBITS {
        return Vec::new();
    }
    let movable = query.iter(world).filter(|(_, _, body)| body.inverse_mass > 0.0);
    let mut orbits: Vec<_> = movable
        .map(|(id, Transform { position, .. }, body)| {
            let potential = |well: &Well| {
                let r = position.distance_squared(well.position) + well.softening * well.softening;
                -well.strength / (body.inverse_mass * r.sqrt())
            };
            let fastest =
                wells.iter().map(|well| well.squared_frequency(*position)).fold(0.0, Scalar::max);
            Orbit {
                body: id.0,
                kinetic: body.kinetic_energy(),
                potential: wells.iter().map(potential).sum(),
                frequency: fastest.sqrt(),
            }
        })
        .collect();
    orbits.sort_by_key(|orbit| orbit.body);
    orbits
}

fn orbits_of_groups(world: &World) -> Vec<Orbit> {
    let (Some(groups), Some(law)) =
        (world.get_resource::<Groups>(), world.get_resource::<MutualGravity>())
    else {
        return Vec::new();
    };
    let alone = groups.list.iter().filter(|group| {
        let coupling = &group.coupling;
        coupling.attracts
            && coupling.springs.is_empty()
            && coupling.sheets.is_empty()
            && coupling.rows <= MOST_ATTRACTING
    });
    let orbit = |group: &Group| {
        // Bodies that are damped at different rates drift apart without gaining energy.
        if group.bodies.iter().any(|body| world.get::<DampingRate>(*body).is_some()) {
            return None;
        }
        let states = states_of(world, &group.bodies);
        let movable = &states[..group.coupling.movable];
        let anchors =
            group.bodies[group.coupling.movable..].iter().zip(&states[group.coupling.movable..]);
        let mut sources =
            anchors.filter(|(body, _)| world.get::<SourceMass>(**body).is_some()).peekable();
        // With an immovable source the frame is that of the scene.
        let is_free = sources.peek().is_none();
        if sources.any(|(_, source)| source.velocity != Vector::ZERO) {
            return None;
        }
        let mass = |w: Scalar| if w > 0.0 { 1.0 / w } else { 0.0 };
        let total: Scalar = movable.iter().map(|state| mass(state.inverse_mass)).sum();
        let momentum: Vector =
            movable.iter().map(|state| state.velocity * mass(state.inverse_mass)).sum();
        let drift = if is_free { momentum.length_squared() / (2.0 * total) } else { 0.0 };
        let kinetic: Scalar = movable
            .iter()
            .map(|state| 0.5 * state.velocity.length_squared() * mass(state.inverse_mass))
            .sum();
        let (x, w): (Vec<_>, Vec<_>) =
            states.iter().map(|state| (row_of(state.position), state.inverse_mass)).unzip();
        let pairs = (0..movable.len()).flat_map(|a| (a + 1..states.len()).map(move |b| [a, b]));
        let fastest = pairs.map(|[a, b]| {
            let strength = group.coupling.pair_strength(law, [a, b], &w);
            let r = states[a].position.distance_squared(states[b].position)
                + law.softening * law.softening;
            strength / (r * r.sqrt())
        });
        Some(Orbit {
            body: world.get::<StableId>(*group.bodies.first()?)?.0,
            kinetic: kinetic - drift,
            potential: group.coupling.potential_energy(Some(law), &x, &w),
            frequency: fastest.fold(0.0, Scalar::max).sqrt(),
        })
    };
    alone.filter_map(orbit).collect()
}
