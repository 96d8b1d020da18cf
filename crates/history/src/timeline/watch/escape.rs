//! Detects bodies that escape from what holds them although nothing else can have freed them.

use std::collections::HashMap;
use std::sync::Arc;

use motion::units::Vector;
use motion::{AxisLocks, Drag, Gravity, Laws, TimeStep, Totals, totals};
use scene::{BodySpec, Scene};

use super::{SMALL, most_energetic};
use crate::bonds::{Attraction, Attractions, Bond, Holder, State};
use crate::simulation::Simulation;
use crate::timeline::Fault;

/// Ticks between two checks: a check takes about as long as an evaluation of the attractions.
const EVERY: u64 = 8;

/// Ticks after which an escape is a fault even if the body has not turned far, so that a timeline still has the tick
/// of the escape.
const LONGEST_DOUBT: u64 = 512;

/// Part of kinetic energy and magnitude of potential energy that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Most bodies whose bonds are checked.
const MOST_BODIES: usize = 4096;

/// Part of the holder's attraction that all others may have where the body is farthest from it: what holds a body at half
/// the radius of the Hill sphere.
const DISTURBED: f64 = 0.125;

/// A bound state.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// Energy when it was last bound, J.
    bound_j: f64,
    /// Tick at which it was last bound.
    bound_tick: u64,
    /// Half a turn then, s.
    half_turn_s: f64,
    /// The tick from which on a free state is a fault; `None` while it is bound.
    fault_from: Option<u64>,
    reported: bool,
}

impl Held {
    const fn at(tick: u64, bound_j: f64, half_turn_s: f64) -> Self {
        Self { bound_j, bound_tick: tick, half_turn_s, fault_from: None, reported: false }
    }

    /// Whether a free state is a fault now, after ticks of `length` seconds. A method that keeps a body bound may show it as free
    /// around the closest approach, for part of a turn; half a turn takes `half_turn_s` at the present distance.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count of ticks"
    )]
    fn is_fault(&mut self, tick: u64, length: f64, half_turn_s: f64) -> bool {
        let doubt = self.half_turn_s.min(half_turn_s) / length;
        let doubt = if doubt < LONGEST_DOUBT as f64 { doubt.ceil() as u64 } else { LONGEST_DOUBT };
        let from = *self.fault_from.get_or_insert(tick.saturating_add(doubt.max(1)));
        let is_fault = tick >= from && !self.reported;
        self.reported |= is_fault;
        is_fault
    }

    fn fault(&self, tick: u64, body: Option<u32>, what: &str, energy_j: f64) -> Fault {
        Fault {
            tick: self.bound_tick.saturating_add(1),
            found: tick,
            body,
            quarantined: false,
            what: format!(
                "{what}: its energy rose from {:.3e} J to {energy_j:.3e} J",
                self.bound_j
            ),
        }
    }
}

/// The bodies that are held, and the scene as a whole if its energy is negative.
#[derive(Debug, Default)]
pub(super) struct Escapes {
    /// By stable id.
    bodies: HashMap<u32, (Holder, Held)>,
    whole: Option<Held>,
}

impl Escapes {
    pub fn of(simulation: &mut Simulation) -> Self {
        let mut escapes = Self::default();
        escapes.look_at(simulation);
        escapes
    }

    /// Forgets all bonds, after a change from outside.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Checks the bonds after a tick, once every [`EVERY`] ticks.
    pub fn look(&mut self, simulation: &mut Simulation) -> Option<Fault> {
        if simulation.ticks().is_multiple_of(EVERY) { self.look_at(simulation) } else { None }
    }

    fn look_at(&mut self, simulation: &mut Simulation) -> Option<Fault> {
        let scene = Arc::clone(&simulation.scene);
        let attracts = scene.mutual_gravity.is_some()
            || scene.laws.wells.is_some()
            || scene
                .own_laws
                .values()
                .any(|own| !own.wells.is_empty() || !own.riding_wells.is_empty());
        let most = if scene.mutual_gravity.is_some() { SMALL } else { MOST_BODIES };
        let has_laws =
            simulation.world.get_resource::<Laws>().is_some_and(|laws| !laws.0.is_empty());
        if !attracts || has_laws || simulation.bodies.len() > most {
            self.forget();
            return None;
        }
        let tick = simulation.ticks();
        let length = simulation.world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        let pairs = Pairs::of(&scene, simulation, EVERY as f64 * length);
        let bonds = pairs.attractions.bonds();
        let mut fault = None;
        self.bodies.retain(|body, (holder, held)| {
            let Some(pair) = pairs.pair(*body, *holder) else { return false };
            let is_free = pair.energy_j > pair.rounding_j;
            if is_free && fault.is_none() && held.is_fault(tick, length, pair.half_turn_s) {
                let what = "the orbit becomes free here although only attraction acts";
                fault = Some(held.fault(tick, Some(*body), what, pair.energy_j));
            }
            // A bound one is added again below, if it is still secure.
            pair.energy_j >= -pair.rounding_j
        });
        for bond in &bonds {
            let pair = pairs.pair(bond.body, bond.holder);
            if let Some(pair) =
                pair.filter(|pair| pair.energy_j < -pair.rounding_j && pairs.is_secure(bond))
            {
                // What is free of its holder may have found another.
                let held = Held::at(tick, pair.energy_j, 0.5 * bond.turn_s);
                self.bodies.entry(bond.body).or_insert((bond.holder, held));
            }
        }
        let turn = bonds.iter().map(|bond| bond.turn_s).fold(0.0, f64::max);
        let whole = if pairs.falls || pairs.blows {
            None
        } else {
            self.look_at_whole(simulation, length, 0.5 * turn)
        };
        fault.or(whole)
    }

    /// Checks the energy of all bodies together, half of whose slowest turn takes `half_turn_s`.
    fn look_at_whole(
        &mut self,
        simulation: &mut Simulation,
        length: f64,
        half_turn_s: f64,
    ) -> Option<Fault> {
        let scene = &simulation.scene;
        let is_fed = !scene.emitters.is_empty()
            || scene
                .own_laws
                .values()
                .any(|own| !own.thrusts.is_empty() || !own.riding_wells.is_empty());
        if simulation.bodies.len() > SMALL || is_fed {
            self.whole = None;
            return None;
        }
        let tick = simulation.ticks();
        let Totals { kinetic_energy, potential_energy, .. } = totals(&mut simulation.world);
        let energy = kinetic_energy + potential_energy;
        let rounding = ROUNDING * (kinetic_energy + potential_energy.abs());
        if energy < -rounding {
            self.whole = Some(Held::at(tick, energy, half_turn_s));
        } else if let Some(held) = &mut self.whole
            && energy > rounding
            && held.is_fault(tick, length, half_turn_s)
        {
            let body = most_energetic(&mut simulation.world);
            return Some(held.fault(
                tick,
                body,
                "the bodies become free here although no force can add energy",
                energy,
            ));
        }
        None
    }
}

/// A body about its holder.
struct Pair {
    energy_j: f64,
    rounding_j: f64,
    /// Half a turn of a circle at the present distance, s.
    half_turn_s: f64,
}

/// The attractions of a scene between two checks.
struct Pairs<'a> {
    scene: &'a Scene,
    attractions: Attractions,
    /// Whether springs hold a body, by stable id.
    joined: Vec<bool>,
    /// Whether gravity, drag and wind act on every body.
    falls: bool,
    drags: bool,
    blows: bool,
    /// Time until the next check, s.
    ahead_s: f64,
}

impl<'a> Pairs<'a> {
    fn of(scene: &'a Scene, simulation: &mut Simulation, ahead_s: f64) -> Self {
        let mut joined = vec![false; scene.bodies.len()];
        for end in scene.all_springs().flat_map(|(ends, _)| ends) {
            joined[end as usize] = true;
        }
        let attractions = Attractions::of(simulation);
        let world = &simulation.world;
        let gravity = world.get_resource::<Gravity>().and_then(Gravity::active_acceleration);
        let drag = world.get_resource::<Drag>();
        Self {
            scene,
            attractions,
            joined,
            falls: gravity.is_some_and(|acceleration| acceleration != Vector::ZERO),
            drags: drag.is_some(),
            blows: drag.is_some_and(|drag| drag.wind.is_some()),
            ahead_s,
        }
    }

    /// The attraction of `body` by `holder`, and all attractions of it.
    fn attraction(
        &self,
        body: u32,
        holder: Holder,
    ) -> Option<(State, Attraction, Vec<Attraction>)> {
        let state = self.attractions.states[body as usize]?;
        let all: Vec<_> = self.attractions.on(&state).collect();
        let by_holder = *all.iter().find(|attraction| attraction.holder == holder)?;
        Some((state, by_holder, all))
    }

    fn pair(&self, body: u32, holder: Holder) -> Option<Pair> {
        let (state, by_holder, all) = self.attraction(body, holder)?;
        // About a fixed holder, the potential of all that is fixed stays.
        let counts =
            |other: &&Attraction| other.holder == holder || by_holder.is_fixed && other.is_fixed;
        let potential: f64 =
            all.iter().filter(counts).map(|other| -other.strength / other.distance()).sum();
        let kinetic = 0.5 * by_holder.v.length_squared();
        let distance = by_holder.distance();
        Some(Pair {
            energy_j: state.mass * (kinetic + potential),
            rounding_j: ROUNDING * state.mass * (kinetic + potential.abs()),
            half_turn_s: std::f64::consts::PI
                * (distance * distance * distance / by_holder.strength).sqrt(),
        })
    }

    /// Whether nothing but its holder can free a body until the next check.
    fn is_secure(&self, bond: &Bond) -> bool {
        let Some((_, by_holder, all)) = self.attraction(bond.body, bond.holder) else {
            return false;
        };
        let is_left_alone = |id: u32| {
            let own = self.scene.own_laws.get(&id);
            !self.joined[id as usize]
                && !self.scene.is_particle(id)
                && own.is_none_or(|own| own.thrusts.is_empty())
        };
        // What slows one of two bodies may part them.
        let is_slowed = |id: u32| {
            let BodySpec { damping_rate, max_speed, locks, .. } = self.scene.bodies[id as usize];
            let own = self.scene.own_laws.get(&id);
            damping_rate.is_some()
                || max_speed.is_some()
                || locks != AxisLocks::default()
                || own.is_some_and(|own| own.drag.is_some())
        };
        let mover = match bond.holder {
            Holder::Body(holder) if !by_holder.is_fixed => Some(holder),
            _ => None,
        };
        let falls = |id: u32| self.falls && !self.scene.bodies[id as usize].gravity_off;
        let may_part = match mover {
            Some(holder) => {
                self.drags
                    || is_slowed(bond.body)
                    || is_slowed(holder)
                    || falls(bond.body) != falls(holder)
                    || !is_left_alone(holder)
            }
            None => self.falls || self.blows,
        };
        // Now and until the next check, on straight lines.
        let is_calm = |part: f64| {
            let ahead_s = part * self.ahead_s;
            let others = all.iter().filter(|other| {
                other.holder != bond.holder && (mover.is_some() || !other.is_fixed)
            });
            let own: Vector = others.map(|other| other.acceleration(ahead_s)).sum();
            let state = mover.and_then(|holder| self.attractions.states[holder as usize]);
            let of_holder = state.iter().flat_map(|state| self.attractions.on(state));
            let of_holder = of_holder.filter(|other| other.holder != Holder::Body(bond.body));
            let other: Vector = of_holder.map(|other| other.acceleration(ahead_s)).sum();
            // A tide grows in proportion to the distance.
            let most = (own - other).length() * bond.reach / by_holder.distance();
            most <= DISTURBED * by_holder.strength / (bond.reach * bond.reach)
        };
        is_left_alone(bond.body) && !may_part && [0.0, 0.5, 1.0].into_iter().all(is_calm)
    }
}
