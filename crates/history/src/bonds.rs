//! Bonds: what holds each body of a simulation.

use std::sync::Arc;

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
    /// Their largest distance, m, if nothing else acts; NaN of a spring.
    pub reach: f64,
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
pub(crate) struct State {
    pub id: u32,
    pub x: Vector,
    pub v: Vector,
    pub mass: f64,
}

/// The attraction of a body by what may hold it, whose motion is relative to the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attraction {
    pub holder: Holder,
    pub x: Vector,
    pub v: Vector,
    /// Strength, m³/s².
    pub strength: f64,
    pub softening: f64,
    /// Mass of the holder as a source, kg; 0 of a well.
    source_mass: f64,
    /// Whether the holder does not move.
    pub is_fixed: bool,
}

impl Attraction {
    /// Softened distance, m.
    pub fn distance(&self) -> f64 {
        libm::hypot(self.x.length(), self.softening)
    }

    /// Acceleration of the body, m/s², once it has moved by `way`, m, past what attracts it.
    pub fn acceleration(&self, way: Vector) -> Vector {
        let ahead = Self { x: self.x + way, ..*self };
        let r = ahead.distance();
        ahead.x * (-self.strength / (r * r * r))
    }

    fn bond(&self, body: u32) -> Option<Bond> {
        let Self { x, v, strength, softening, .. } = *self;
        let energy = 0.5 * v.length_squared() - strength / self.distance();
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
            reach: axis * (1.0 + eccentricity),
            fastest: (strength / (nearest * nearest * nearest)).sqrt(),
            is_spring: false,
        })
    }
}

/// Most bodies that attract each other for which Hill spheres count: they take all triples.
const MOST_IN_HILL_SPHERES: usize = 256;

/// The bonds of the movable bodies of `simulation`. A body has up to two: to the nearest of the
/// wells and of the bodies that are not lighter, if its energy about it is negative and it is within the holder's Hill sphere; and to
/// the other end of one of its springs.
#[must_use]
pub fn bonds(simulation: &Simulation) -> Vec<Bond> {
    let attractions = Attractions::of(simulation);
    let mut bonds = attractions.bonds();
    if attractions.springs_are_on {
        bonds.extend(bonds_by_springs(&simulation.scene, &attractions.states));
    }
    bonds
}

/// All attractions of a simulation in its present state.
pub(crate) struct Attractions {
    scene: Arc<Scene>,
    /// By stable id.
    pub states: Vec<Option<State>>,
    wells_are_on: bool,
    springs_are_on: bool,
    mutual: Option<MutualGravity>,
    /// The bodies that attract others, with their masses as sources.
    masses: Vec<State>,
}

impl Attractions {
    /// The attractions in `simulation`.
    pub fn of(simulation: &Simulation) -> Self {
        let off = Effects::of(&simulation.world).off;
        let scene = Arc::clone(&simulation.scene);
        let states: Vec<Option<State>> =
            (0..).take(simulation.bodies.len()).map(|id| state(simulation, id)).collect();
        let mutual = scene.mutual_gravity.filter(|_| !off.contains(&Effect::MutualGravity));
        let attracting = states.iter().flatten().filter(|state| !scene.is_particle(state.id));
        let source = |state: &State| {
            let source = scene.bodies[state.id as usize].source_mass.unwrap_or(0.0);
            let mass = if state.mass.is_finite() { state.mass } else { source };
            (mass > 0.0).then_some(State { mass, ..*state })
        };
        let masses =
            if mutual.is_some() { attracting.filter_map(source).collect() } else { Vec::new() };
        let [wells_are_on, springs_are_on] =
            [Effect::Wells, Effect::Springs].map(|effect| !off.contains(&effect));
        Self { scene, states, wells_are_on, springs_are_on, mutual, masses }
    }

    /// The attractions of `body` by wells.
    fn by_wells(&self, body: &State) -> impl Iterator<Item = Attraction> {
        let own = self.scene.own_laws.get(&body.id).filter(|_| self.wells_are_on);
        let shared = self.scene.laws.wells.iter().filter(|_| self.wells_are_on);
        let own_wells = own.into_iter().flat_map(|laws| &laws.wells);
        let fixed = shared.flat_map(|wells| &wells.0).chain(own_wells).map(|well| Attraction {
            holder: Holder::Well(well.position),
            x: body.x - well.position,
            v: body.v,
            strength: well.strength,
            softening: well.softening,
            source_mass: 0.0,
            is_fixed: true,
        });
        fixed.chain(own.into_iter().flat_map(|laws| &laws.riding_wells).filter_map(|well| {
            let carrier = self.states.get(well.rides_on as usize).copied().flatten()?;
            Some(Attraction {
                holder: Holder::Body(carrier.id),
                x: body.x - carrier.x,
                v: body.v - carrier.v,
                strength: well.strength,
                softening: well.softening,
                source_mass: 0.0,
                is_fixed: carrier.mass.is_infinite(),
            })
        }))
    }

    /// The attractions of `body` by other bodies.
    fn by_bodies(&self, body: &State) -> impl Iterator<Item = Attraction> {
        let others = self.masses.iter().filter(|other| other.id != body.id);
        self.mutual.into_iter().flat_map(move |law| {
            others.clone().map(move |other| {
                let is_fixed = !self.scene.bodies[other.id as usize].is_movable();
                let own = if is_fixed { 0.0 } else { body.mass };
                Attraction {
                    holder: Holder::Body(other.id),
                    x: body.x - other.x,
                    v: body.v - other.v,
                    strength: law.constant * (other.mass + own),
                    softening: law.softening,
                    source_mass: other.mass,
                    is_fixed,
                }
            })
        })
    }

    /// All attractions of `body`.
    pub fn on(&self, body: &State) -> impl Iterator<Item = Attraction> {
        let is_attracted = !self.scene.is_particle(body.id);
        self.by_wells(body).chain(self.by_bodies(body).filter(move |_| is_attracted))
    }

    /// The bonds by attraction.
    pub fn bonds(&self) -> Vec<Bond> {
        let movable = || self.states.iter().flatten().filter(|state| state.mass.is_finite());
        let to_well = |body: &State| {
            let bound =
                self.by_wells(body).filter_map(|well| Some((well.x.length(), well.bond(body.id)?)));
            bound.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, bond)| bond)
        };
        let mut bonds: Vec<_> = movable().filter_map(to_well).collect();
        let is_source =
            |body: &&State| self.masses.binary_search_by_key(&body.id, |mass| mass.id).is_ok();
        bonds.extend(movable().filter(is_source).filter_map(|body| self.bond_to_a_body(body)));
        bonds
    }

    /// The bond of `body` to the nearest of the bodies that are not lighter.
    fn bond_to_a_body(&self, body: &State) -> Option<Bond> {
        let others: Vec<_> = self.by_bodies(body).collect();
        let heavier = others.iter().filter(|other| other.source_mass >= body.mass);
        let mut near: Vec<_> =
            heavier.filter_map(|other| Some((other, other.bond(body.id)?))).collect();
        near.sort_by(|(a, _), (b, _)| a.x.length().total_cmp(&b.x.length()));
        let is_within = |(holder, _): &&(&Attraction, Bond)| {
            let is_near = |third: &Attraction| {
                let hill = libm::cbrt(holder.source_mass / (3.0 * third.source_mass));
                third.source_mass <= holder.source_mass
                    || holder.x.length() < holder.x.distance(third.x) * hill
            };
            self.masses.len() > MOST_IN_HILL_SPHERES || others.iter().all(is_near)
        };
        near.iter().find(is_within).map(|(_, bond)| *bond)
    }
}

fn state(simulation: &Simulation, id: u32) -> Option<State> {
    let body: EntityRef<'_> = simulation.present(id)?;
    let PhysicsBody { velocity: v, inverse_mass } = *body.get()?;
    let mass = if inverse_mass > 0.0 { 1.0 / inverse_mass } else { f64::INFINITY };
    Some(State { id, x: body.get::<Transform>()?.position, v, mass })
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
                bonds.push(Bond {
                    body: body.id,
                    holder,
                    turn_s,
                    reach: f64::NAN,
                    fastest,
                    is_spring: true,
                });
            }
        }
    }
    bonds
}
