//! Detects bodies that escape from what holds them although nothing else can have freed them.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion::units::Vector;
use motion::{AxisLocks, Drag, Gravity, Laws, TimeStep, Totals, totals};
use scene::{BodySpec, OwnLawsSpec, Scene};

use super::{SMALL, most_energetic};
use crate::bonds::{Attraction, Attractions, Bond, Holder, State};
use crate::simulation::Simulation;
use crate::timeline::Fault;

/// Ticks between two checks: a check takes about as long as an evaluation of the attractions. An odd number, so that a swing of two
/// or four ticks is not seen in one phase alone.
const EVERY: u64 = 7;

/// Ticks after which an escape is a fault even if it was for less than half a turn, so that a timeline still has the tick of
/// the escape.
const LONGEST_DOUBT: u64 = 512;

/// Part of kinetic energy and magnitude of potential energy that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Most bodies whose bonds are checked.
const MOST_BODIES: usize = 4096;

/// Part of the holder's attraction that the tides of all others may have where the body is farthest from it. So much is at 0.31 of
/// the radius of the Hill sphere; orbits are stable up to 0.49 of it (Domingos, Winter and Yokoyama 2006).
const DISTURBED: f64 = 0.02;

/// A bound state.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// A body and what holds it; `None` for the scene as a whole.
    pair: Option<(u32, Holder)>,
    /// Energy when it was last bound, J.
    bound_j: f64,
    /// Tick at which it was last bound.
    bound_tick: u64,
    /// Half of its longest turn, s.
    half_turn_s: f64,
    /// Its largest distance from the holder, m.
    reach: f64,
    /// The tick from which on a free state is a fault; `None` while it is bound.
    fault_from: Option<u64>,
}

impl Held {
    /// Whether a free state is a fault now, after ticks of `length` seconds. A method that keeps a body bound may show it as free
    /// around the closest approach, for part of a turn.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count of ticks"
    )]
    fn is_fault(&mut self, tick: u64, length: f64) -> bool {
        let doubt = self.half_turn_s / length;
        let doubt = if doubt < LONGEST_DOUBT as f64 { doubt.ceil() as u64 } else { LONGEST_DOUBT };
        tick >= *self.fault_from.get_or_insert(tick.saturating_add(doubt.max(1)))
    }
}

/// A body and the body that holds it, by stable id, or a well; `None` for the scene as a whole.
type Key = Option<(u32, Option<u32>)>;

/// The bodies that are held, and the scene as a whole if its energy is negative.
#[derive(Debug, Default)]
pub(super) struct Escapes(BTreeMap<Key, Held>);

impl Escapes {
    pub fn of(simulation: &Simulation) -> Self {
        let mut escapes = Self::default();
        escapes.look_at(simulation);
        escapes
    }

    /// Forgets all bonds, after a change from outside.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// Checks the bonds after a tick, once every [`EVERY`] ticks.
    pub fn look(&mut self, simulation: &Simulation) -> Option<Fault> {
        if simulation.ticks().is_multiple_of(EVERY) { self.look_at(simulation) } else { None }
    }

    fn look_at(&mut self, simulation: &Simulation) -> Option<Fault> {
        let before = std::mem::take(&mut self.0);
        let scene = Arc::clone(&simulation.scene);
        let has_wells = |own: &OwnLawsSpec| !own.wells.is_empty() || !own.riding_wells.is_empty();
        let attracts = scene.mutual_gravity.is_some()
            || scene.laws.wells.is_some()
            || scene.own_laws.values().any(has_wells);
        let most = if scene.mutual_gravity.is_some() { SMALL } else { MOST_BODIES };
        let has_laws =
            simulation.world.get_resource::<Laws>().is_some_and(|laws| !laws.0.is_empty());
        if !attracts || has_laws || simulation.bodies.len() > most {
            return None;
        }
        let tick = simulation.ticks();
        let length = simulation.world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        let pairs = Pairs::of(&scene, simulation, EVERY as f64 * length);
        let whole = pairs.whole(simulation);
        let mut fault = None;
        for (key, held) in &before {
            let (key, mut held) = (*key, *held);
            let about = held.pair.and_then(|(body, holder)| pairs.about(body, holder));
            let energy = match held.pair {
                Some(_) => about.as_ref().map(About::energy),
                None => whole,
            };
            let Some(energy) = energy else { continue };
            let Energy { joules, rounding } = energy;
            if energy.is_bound() {
                // It may have left a calm orbit for one that is not.
                held.fault_from = None;
                if about.is_some_and(|about| pairs.is_calm(&about, held.reach)) {
                    self.0.insert(key, held);
                }
            } else if joules > rounding && fault.is_none() && held.is_fault(tick, length) {
                let (body, what) = match held.pair {
                    Some((body, _)) => {
                        (Some(body), "the orbit becomes free here although only attraction acts")
                    }
                    None => (
                        most_energetic(&simulation.world),
                        "the bodies become free here although no force can add energy",
                    ),
                };
                let rises =
                    format!("its energy rose from {:.3e} J to {joules:.3e} J", held.bound_j);
                fault = Some(Fault {
                    tick: held.bound_tick.saturating_add(1),
                    found: tick,
                    body,
                    quarantined: false,
                    what: format!("{what}: {rises}"),
                });
            } else {
                self.0.insert(key, held);
            }
        }
        let bonds = pairs.attractions.bonds();
        let slowest = bonds.iter().map(|bond| bond.turn_s).reduce(f64::max);
        let whole = whole
            .filter(Energy::is_bound)
            .map(|energy| (None, None, energy, (slowest.unwrap_or(f64::INFINITY), f64::NAN)));
        let secure = bonds.iter().filter_map(|bond| {
            let by = if let Holder::Body(id) = bond.holder { Some(id) } else { None };
            let pair = Some((bond.body, bond.holder));
            Some((Some((bond.body, by)), pair, pairs.secure(bond)?, (bond.turn_s, bond.reach)))
        });
        for (key, pair, energy, (turn_s, reach)) in secure.chain(whole) {
            let known = before.get(&key).map_or(0.0, |held| held.half_turn_s);
            let half_turn_s = known.max(0.5 * turn_s);
            let (bound_j, bound_tick) = (energy.joules, tick);
            let held = Held { pair, bound_j, bound_tick, half_turn_s, reach, fault_from: None };
            self.0.insert(key, held);
        }
        fault
    }
}

/// Kinetic and potential energy, and the part of it that counts as rounding, J.
#[derive(Clone, Copy)]
struct Energy {
    joules: f64,
    rounding: f64,
}

impl Energy {
    fn of(kinetic: f64, potential: f64) -> Self {
        let rounding = ROUNDING * (kinetic + potential.abs());
        Self { joules: kinetic + potential, rounding }
    }

    fn is_bound(&self) -> bool {
        self.joules < -self.rounding
    }
}

/// A body, its attraction by what holds it, and all of its attractions.
struct About {
    body: State,
    by_holder: Attraction,
    all: Vec<Attraction>,
}

impl About {
    fn energy(&self) -> Energy {
        let Self { body, by_holder, all } = self;
        // About a fixed holder, the potential of all that is fixed stays.
        let counts = |other: &&Attraction| {
            other.holder == by_holder.holder || by_holder.is_fixed && other.is_fixed
        };
        let potential: f64 =
            all.iter().filter(counts).map(|other| -other.strength / other.distance()).sum();
        let kinetic = 0.5 * by_holder.v.length_squared();
        Energy::of(body.mass * kinetic, body.mass * potential)
    }
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
    fn of(scene: &'a Scene, simulation: &Simulation, ahead_s: f64) -> Self {
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

    /// A body about what holds it.
    fn about(&self, body: u32, holder: Holder) -> Option<About> {
        let body = self.attractions.states[body as usize]?;
        let all: Vec<_> = self.attractions.on(&body).collect();
        let by_holder = *all.iter().find(|attraction| attraction.holder == holder)?;
        Some(About { body, by_holder, all })
    }

    /// The energy of all bodies together; `None` if a force may add to it, or if they are many.
    fn whole(&self, simulation: &Simulation) -> Option<Energy> {
        let drives = |own: &OwnLawsSpec| {
            !own.thrusts.is_empty() || !own.riding_wells.is_empty() || !own.wells.is_empty()
        };
        let is_fed = self.falls
            || self.blows
            || !self.scene.emitters.is_empty()
            || !self.scene.motions.is_empty()
            || self.scene.own_laws.values().any(drives);
        if is_fed || simulation.bodies.len() > SMALL {
            return None;
        }
        let Totals { kinetic_energy, potential_energy, .. } = totals(&simulation.world);
        Some(Energy::of(kinetic_energy, potential_energy))
    }

    /// The energy of a bound body that nothing but its holder can free until the next check.
    fn secure(&self, bond: &Bond) -> Option<Energy> {
        let about = self.about(bond.body, bond.holder)?;
        let energy = Some(about.energy()).filter(Energy::is_bound)?;
        self.is_calm(&about, bond.reach).then_some(energy)
    }

    /// Whether nothing but its holder can free a body that is at most `reach` meters from it, until the next check.
    fn is_calm(&self, About { body, by_holder, all }: &About, reach: f64) -> bool {
        let (body, holder) = (body.id, by_holder.holder);
        if matches!(holder, Holder::Body(id) if self.scene.motions.contains_key(&id)) {
            return false;
        }
        // Each body of a race of methods has a well of its own, to show whether it stays.
        let own_wells = self.scene.own_laws.get(&body).into_iter().flat_map(|own| &own.wells);
        if { own_wells }.any(|well| Holder::Well(well.position) == holder) {
            return false;
        }
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
        let mover = match holder {
            Holder::Body(holder) if !by_holder.is_fixed => Some(holder),
            Holder::Body(_) | Holder::Well(_) => None,
        };
        let falls = |id: u32| self.falls && !self.scene.bodies[id as usize].gravity_off;
        let may_part = match mover {
            Some(holder) => {
                self.drags
                    || is_slowed(body)
                    || is_slowed(holder)
                    || falls(body) != falls(holder)
                    || !is_left_alone(holder)
            }
            None => self.falls || self.blows,
        };
        // Now and until the next check, while the two go on straight together.
        let is_calm = |part: f64| {
            let ahead_s = part * self.ahead_s;
            let of_body =
                |other: &Attraction| other.acceleration((other.v - by_holder.v) * ahead_s);
            let others = all
                .iter()
                .filter(|other| other.holder != holder && (mover.is_some() || !other.is_fixed));
            let own: Vector = others.map(of_body).sum();
            let state = mover.and_then(|holder| self.attractions.states[holder as usize]);
            let of_holder = state.iter().flat_map(|state| self.attractions.on(state));
            let of_holder = of_holder.filter(|other| other.holder != Holder::Body(body));
            let other: Vector = of_holder.map(|other| other.acceleration(other.v * ahead_s)).sum();
            // A tide grows in proportion to the distance.
            let most = (own - other).length() * reach / by_holder.distance();
            most <= DISTURBED * by_holder.strength / (reach * reach)
        };
        is_left_alone(body) && !may_part && [0.0, 0.5, 1.0].into_iter().all(is_calm)
    }
}
