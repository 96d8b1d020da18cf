//! Bonds: what holds each body of a simulation.

use bevy_ecs::prelude::*;
use motion::effects::Effect;
use motion::snapshot::Effects;
use motion::units::Vector;
use motion::{MutualGravity, PhysicsBody, Transform};
use scene::Scene;

use crate::simulation::Simulation;

/// What holds a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Holder {
    /// A body, by its stable id.
    Body(u32),
    /// A well that does not move, at this position, m.
    Well(Vector),
}

/// A body and what holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// Stable id of the body.
    pub body: u32,
    /// Its holder.
    pub holder: Holder,
    /// Time of a turn of the two alone, s.
    pub turn_s: f64,
    /// Angular frequency of a circle at their closest approach, rad/s.
    pub fastest: f64,
    /// Whether it is a spring; else an attraction.
    pub is_spring: bool,
}

impl Bond {
    /// Position of the body relative to its holder, m; `None` if one of them is away.
    #[must_use]
    pub fn arm(&self, simulation: &Simulation) -> Option<Vector> {
        let position = |id: u32| Some(simulation.present(id)?.get::<Transform>()?.position);
        let holder = match self.holder {
            Holder::Body(id) => position(id)?,
            Holder::Well(position) => position,
        };
        Some(position(self.body)? - holder)
    }
}

/// Position, m, velocity, m/s, and mass, kg, of a body; the mass is infinite if it cannot move.
#[derive(Clone, Copy, Debug)]
struct State {
    id: u32,
    x: Vector,
    v: Vector,
    mass: f64,
}

/// What may hold a body by attraction: its motion relative to the body, and the strength of the attraction, m³/s².
struct Attraction {
    holder: Holder,
    x: Vector,
    v: Vector,
    strength: f64,
    softening: f64,
}

impl Attraction {
    fn bond(&self, body: u32) -> Option<Bond> {
        let Self { x, v, strength, softening, .. } = *self;
        let r = libm::hypot(x.length(), softening);
        let energy = 0.5 * v.length_squared() - strength / r;
        if strength <= 0.0 || energy >= 0.0 {
            return None;
        }
        let axis = -strength / (2.0 * energy);
        let momentum = x.cross(v).length_squared() / strength;
        let eccentricity = (1.0 - momentum / axis).max(0.0).sqrt();
        let nearest = libm::hypot(momentum / (1.0 + eccentricity), softening);
        Some(Bond {
            body,
            holder: self.holder,
            turn_s: std::f64::consts::TAU * (axis * axis * axis / strength).sqrt(),
            fastest: (strength / (nearest * nearest * nearest)).sqrt(),
            is_spring: false,
        })
    }
}

/// Most bodies that attract each other for which Hill spheres count: they take all triples.
const MOST_IN_HILL_SPHERES: usize = 256;

/// The bonds of the movable bodies of `simulation`, which is mutable only for queries. A body has up to two: to the nearest of the
/// wells and of the bodies that are not lighter, if its energy about it is negative and it is within the holder's Hill sphere; and to
/// the other end of one of its springs.
#[must_use]
pub fn bonds(simulation: &mut Simulation) -> Vec<Bond> {
    let off = Effects::of(&mut simulation.world).off;
    let is_on = |effect: Effect| !off.contains(&effect);
    let simulation = &*simulation;
    let scene = &*simulation.scene;
    let states: Vec<Option<State>> =
        (0..).take(simulation.bodies.len()).map(|id| state(simulation, id)).collect();
    let mut bonds = Vec::new();
    if is_on(Effect::Wells) {
        let movable = states.iter().flatten().filter(|state| state.mass.is_finite());
        bonds.extend(movable.filter_map(|body| bond_to_wells(scene, &states, *body)));
    }
    if let Some(law) = scene.mutual_gravity.filter(|_| is_on(Effect::MutualGravity)) {
        bonds.extend(bonds_to_bodies(scene, &states, law));
    }
    if is_on(Effect::Springs) {
        bonds.extend(bonds_by_springs(scene, &states));
    }
    bonds
}

fn state(simulation: &Simulation, id: u32) -> Option<State> {
    let body: EntityRef<'_> = simulation.present(id)?;
    let PhysicsBody { velocity: v, inverse_mass } = *body.get()?;
    let mass = if inverse_mass > 0.0 { 1.0 / inverse_mass } else { f64::INFINITY };
    Some(State { id, x: body.get::<Transform>()?.position, v, mass })
}

/// The bond to the nearest of the wells to which a body is bound.
fn bond_to_wells(scene: &Scene, states: &[Option<State>], body: State) -> Option<Bond> {
    let own = scene.own_laws.get(&body.id);
    let shared = scene.laws.wells.iter().flat_map(|wells| &wells.0);
    let fixed = shared.chain(own.into_iter().flat_map(|laws| &laws.wells)).map(|well| Attraction {
        holder: Holder::Well(well.position),
        x: body.x - well.position,
        v: body.v,
        strength: well.strength,
        softening: well.softening,
    });
    let riding = own.into_iter().flat_map(|laws| &laws.riding_wells).filter_map(|well| {
        let carrier = states.get(well.rides_on as usize).copied().flatten()?;
        Some(Attraction {
            holder: Holder::Body(carrier.id),
            x: body.x - carrier.x,
            v: body.v - carrier.v,
            strength: well.strength,
            softening: well.softening,
        })
    });
    let bound = fixed.chain(riding).filter_map(|well| Some((well.x.length(), well.bond(body.id)?)));
    bound.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, bond)| bond)
}

/// The bonds of bodies that attract each other.
fn bonds_to_bodies(scene: &Scene, states: &[Option<State>], law: MutualGravity) -> Vec<Bond> {
    let spec = |state: &State| &scene.bodies[state.id as usize];
    let attracting = states.iter().flatten().filter(|state| !scene.is_particle(state.id));
    let masses: Vec<State> = attracting
        .filter_map(|state| {
            let source = spec(state).source_mass.unwrap_or(0.0);
            let mass = if state.mass.is_finite() { state.mass } else { source };
            (mass > 0.0).then_some(State { mass, ..*state })
        })
        .collect();
    let bond = |body: &State| {
        let to = |other: &State| {
            let own = if spec(other).is_movable() { body.mass } else { 0.0 };
            let attraction = Attraction {
                holder: Holder::Body(other.id),
                x: body.x - other.x,
                v: body.v - other.v,
                strength: law.constant * (other.mass + own),
                softening: law.softening,
            };
            Some((body.x.distance(other.x), *other, attraction.bond(body.id)?))
        };
        let heavier = masses.iter().filter(|other| other.id != body.id && other.mass >= body.mass);
        let mut near: Vec<_> = heavier.filter_map(to).collect();
        near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let is_within = |(r, holder, _): &&(f64, State, Bond)| {
            let is_near = |third: &State| {
                let hill = libm::cbrt(holder.mass / (3.0 * third.mass));
                third.mass <= holder.mass || *r < holder.x.distance(third.x) * hill
            };
            masses.len() > MOST_IN_HILL_SPHERES || masses.iter().all(is_near)
        };
        near.iter().find(is_within).map(|(.., bond)| *bond)
    };
    masses.iter().filter(|body| spec(body).is_movable()).filter_map(bond).collect()
}

/// A bond for each body that a spring holds: to the other end of the first one.
fn bonds_by_springs(scene: &Scene, states: &[Option<State>]) -> Vec<Bond> {
    let mut joined = vec![false; states.len()];
    let mut bonds = Vec::new();
    for (ends, elastic) in scene.all_springs() {
        let [Some(one), Some(other)] = ends.map(|id| states[id as usize]) else { continue };
        let inverse = 1.0 / one.mass + 1.0 / other.mass;
        let fastest = (elastic.stiffness * inverse).sqrt();
        for (body, holder) in [(one, other), (other, one)] {
            let is_first = !std::mem::replace(&mut joined[body.id as usize], true);
            if body.mass.is_finite() && is_first {
                let turn_s = std::f64::consts::TAU / fastest;
                let holder = Holder::Body(holder.id);
                bonds.push(Bond { body: body.id, holder, turn_s, fastest, is_spring: true });
            }
        }
    }
    bonds
}
