//! The forecast of single bodies: damping, drag, wells and your own laws.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3};
use smallvec::SmallVec;

use super::cure::LinearSystem;
use super::flight::Subject;
use super::judged::{Attracted as _, Orbit, Pair, Slowed};
use super::lanczos::largest;
use super::modes::{Modes, Stepping};
use super::{Forecast, LimitingPart, Margin, Occasion};
use crate::kernels::BodyOptions;
use crate::laws::{BodyState, Drag, EvaluationTime, Jacobians, Law, SharedLaws, Well};
use crate::schedule::emission::carrier_state;
use crate::state::clock::StepClock;
use crate::state::components::Quarantined;
use crate::state::emitter::{Emitter, RidesOn};
use crate::tick::columns::{ObservedColumns, ObservedColumnsItem, options_of};
use crate::tick::environment::Environment;
use crate::units::Scalar;

/// One body as an oscillator.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    body: Entity,
    state: BodyState,
    /// Square of the frequency, 1/s².
    stiffness: Scalar,
    /// Largest rate of drag to come, 1/s.
    drag: Scalar,
    /// Rate of drag in the present state, 1/s.
    drag_now: Scalar,
    /// The state that has the largest rate.
    occasion: Occasion,
    /// Rate of the scene's damping, 1/s.
    damping: Scalar,
}

/// A cause that may limit the step of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limit {
    /// Drag and damping.
    Damping,
    /// A well, by its number.
    Well(usize),
    /// Another law, by its name.
    Law(&'static str),
}

/// Bodies with the same method and substeps: the fastest of them for each limit.
struct StepClass {
    stepping: Stepping,
    bodies: usize,
    fastest: Vec<(Limit, Option<Oscillator>)>,
    /// The fastest for each well, by its number.
    wells: Vec<Option<Oscillator>>,
    /// The bodies that come nearest to the limit, each with the well that attracts it most: they are tried.
    tried: Vec<(LimitingPart, Well, Oscillator)>,
}

/// Number of bodies of a class whose orbits are tried: the fastest one may only pass by.
const MOST_TRIED: usize = 4;

/// Largest number of wells that are listed for the bodies of a class: the fastest.
const MOST_WELLS: usize = 64;

impl Forecast {
    pub(super) fn add_single_bodies(&mut self, world: &mut World, scenes: Stepping) {
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let time = clock.scene_seconds();
        let launches = launches(world);
        let mut query = world.query_filtered::<ObservedColumns, Without<Quarantined>>();
        let world = &*world;
        let environment = Environment::of(world, clock, scenes.tick);
        let (laws, damping) = (environment.laws, environment.damping);
        let others = SharedLaws { drag: None, wells: None, ..laws };
        let wells = laws.wells.map_or(&[][..], |wells| &wells.0);
        let at = EvaluationTime { time, within_step: time };
        let mut classes: Vec<StepClass> = Vec::new();
        for row in query.iter(world) {
            let ObservedColumnsItem { entity, grouped, dormant, .. } = row;
            let mut state = row.state();
            if dormant && let Some((position, velocity)) = launches.get(&entity) {
                (state.position, state.velocity) = (*position, *velocity);
            }
            if state.inverse_mass <= 0.0 {
                continue;
            }
            let options = row.options.options();
            let last = row.last_step.map_or(0.0, |last| last.0);
            if last != 0.0 && !grouped {
                // Position Verlet's velocity is half a step behind.
                let acting = environment.on_body(&options, false);
                state.velocity +=
                    acting.map(|law| law.acceleration(at, state)).sum::<DVec3>() * (0.5 * last);
            }
            let stepping = Stepping {
                method: row.method(world).unwrap_or(scenes.method),
                substeps: options.substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            let mut oscillator = Oscillator {
                body: entity,
                state,
                stiffness: 0.0,
                drag: 0.0,
                drag_now: 0.0,
                occasion: if dormant { Occasion::Birth } else { Occasion::Now },
                damping: options.damping(damping).map_or(0.0, |damping| damping.rate),
            };
            if let Some(drag) = air(laws.drag, options.laws, state.inverse_mass) {
                let driven = environment.gravity.filter(|_| !options.gravity_off);
                let driven = driven.and_then(Law::affine).map_or(DVec3::ZERO, |law| law.constant);
                let own = options.laws.iter().filter(|law| law.drag(state.inverse_mass).is_none());
                let own = own.map(|law| law.acceleration(at, state)).sum::<DVec3>();
                oscillator.slow(&drag, time, (driven + own).length());
            }
            let class =
                classes.iter().position(|class| class.stepping == stepping).unwrap_or_else(|| {
                    classes.push(StepClass {
                        stepping,
                        bodies: 0,
                        fastest: Vec::new(),
                        wells: Vec::new(),
                        tried: Vec::new(),
                    });
                    classes.len() - 1
                });
            let class = &mut classes[class];
            class.bodies += 1;
            if !grouped {
                class.keep(Limit::Damping, oscillator);
            }
            let own = options.laws.iter().flat_map(|law| {
                law.wells().iter().map(|well| (LimitingPart::Law(law.name(), entity), *well))
            });
            let shared = wells.iter().enumerate();
            let shared = shared.map(|(number, well)| (LimitingPart::Well(number, entity), *well));
            let pull = |(_, well): &(LimitingPart, Well)| well.squared_frequency(state.position);
            let strongest = shared.chain(own).max_by(|a, b| pull(a).total_cmp(&pull(b)));
            if let Some((part, well)) = strongest.filter(|_| !grouped) {
                let r = well.apsides(state).nearest;
                let stiffness = well.squared_frequency(well.position + DVec3::X * r);
                class.try_orbit(part, well, Oscillator { stiffness, ..oscillator });
            }
            // For bodies joined by springs, wells are part of the margin of their group.
            let joined = grouped && environment.attraction.is_none();
            for (number, well) in wells.iter().enumerate().filter(|_| !joined) {
                let stiffness = well.squared_frequency(state.position);
                class.keep(Limit::Well(number), Oscillator { stiffness, ..oscillator });
            }
            // Own wells and own drag of a body that moves alone are tried as orbits and as drag.
            let own = options.laws.iter().map(|law| &**law);
            let is_tried =
                |law: &&dyn Law| !law.wells().is_empty() || law.drag(state.inverse_mass).is_some();
            let own = own.filter(|law| grouped || !is_tried(law));
            for law in others.all().chain(own) {
                let Jacobians { position, velocity } = law.jacobians(at, state);
                if position != DMat3::ZERO || velocity != DMat3::ZERO {
                    let drag = oscillator.drag + restoring_rate(velocity);
                    let oscillator =
                        Oscillator { stiffness: restoring_rate(position), drag, ..oscillator };
                    class.keep(Limit::Law(law.name()), oscillator);
                }
            }
        }
        let judge = Judge { world, environment, wells };
        for mut class in classes {
            class.list_wells();
            class.fastest.sort_by_key(|(limit, _)| limit.rank());
            let fastest = class
                .fastest
                .iter()
                .filter_map(|(limit, oscillator)| Some((*limit, (*oscillator)?)));
            let orbit = judge.orbit(&class);
            let judged = orbit.map(|margin| margin.part);
            let is_other = |(limit, _): &(Limit, Oscillator)| match (limit, judged) {
                (Limit::Well(number), Some(LimitingPart::Well(judged, _))) => *number != judged,
                _ => true,
            };
            let others = fastest.filter(is_other);
            self.margins
                .extend(others.map(|(limit, oscillator)| judge.margin(&class, limit, oscillator)));
            self.margins.extend(orbit);
        }
    }
}

/// Position, m, and velocity, m/s, at birth of every body of an emitter.
fn launches(world: &mut World) -> EntityHashMap<(DVec3, DVec3)> {
    let mut emitters = world.query::<(&Emitter, Option<&RidesOn>)>();
    let mut launches = EntityHashMap::default();
    let world = &*world;
    for (Emitter { position, pool, launches: velocities, .. }, carrier) in emitters.iter(world) {
        let (x, v) = carrier.and_then(|carrier| carrier_state(world, *carrier)).unwrap_or_default();
        let births = pool.iter().zip(velocities);
        launches.extend(births.map(|(body, velocity)| (*body, (*position + x, *velocity + v))));
    }
    launches
}

impl Oscillator {
    /// Sets the rates of drag of a body; `acceleration`, m/s², is that by everything else.
    fn slow(&mut self, drag: &Drag, time: Scalar, acceleration: Scalar) {
        self.drag_now = drag.linear + drag.quadratic * drag.against(time, self.state).length();
        let wind = drag.wind.unwrap_or_default();
        let fastest = (self.state.velocity - wind.velocity).length()
            + if wind.is_steady() { 0.0 } else { wind.gust };
        let in_gusts = drag.linear + drag.quadratic * fastest;
        // At the terminal speed v, c v + k v² = a, the slope is c + 2 k v.
        let terminal = (drag.linear * drag.linear + 4.0 * drag.quadratic * acceleration).sqrt();
        self.drag = self.drag_now;
        for (rate, occasion) in [(in_gusts, Occasion::Gust), (terminal, Occasion::TerminalSpeed)] {
            if rate > self.drag * (1.0 + 1e-9) {
                (self.drag, self.occasion) = (rate, occasion);
            }
        }
    }
}

impl Limit {
    /// Rank in the list of margins: damping, wells by number, then laws in the order in which they were found.
    fn rank(self) -> usize {
        match self {
            Self::Damping => 0,
            Self::Well(number) => number + 1,
            Self::Law(_) => usize::MAX,
        }
    }

    /// How strongly the step of a body is limited, to compare it with other bodies.
    fn speed(self, oscillator: &Oscillator) -> Scalar {
        let Oscillator { stiffness, drag, damping, .. } = oscillator;
        match self {
            Self::Damping => drag + damping,
            Self::Well(_) => *stiffness,
            Self::Law(_) => stiffness.sqrt() + drag,
        }
    }
}

impl StepClass {
    /// Keeps an oscillator if it is the fastest so far.
    fn keep(&mut self, limit: Limit, oscillator: Oscillator) {
        let fastest = if let Limit::Well(number) = limit {
            self.wells.resize(self.wells.len().max(number + 1), None);
            &mut self.wells[number]
        } else {
            let place =
                self.fastest.iter().position(|(known, _)| *known == limit).unwrap_or_else(|| {
                    self.fastest.push((limit, None));
                    self.fastest.len() - 1
                });
            &mut self.fastest[place].1
        };
        if limit.speed(&oscillator) > fastest.as_ref().map_or(0.0, |fastest| limit.speed(fastest)) {
            *fastest = Some(oscillator);
        }
    }

    /// Keeps an orbit to be tried if it is among the fastest.
    fn try_orbit(&mut self, part: LimitingPart, well: Well, oscillator: Oscillator) {
        let faster = |(_, _, other): &(LimitingPart, Well, Oscillator)| {
            other.stiffness >= oscillator.stiffness
        };
        let place = self.tried.partition_point(faster);
        if place < MOST_TRIED && oscillator.stiffness > 0.0 {
            self.tried.insert(place, (part, well, oscillator));
            self.tried.truncate(MOST_TRIED);
        }
    }

    /// Moves the fastest wells into the list.
    fn list_wells(&mut self) {
        let wells = self.wells.drain(..).enumerate();
        let mut wells: Vec<_> = wells.map(|(number, well)| (Limit::Well(number), well)).collect();
        let speed = |well: &(Limit, Option<Oscillator>)| well.1.map_or(0.0, |well| well.stiffness);
        wells.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
        self.fastest.extend(wells.into_iter().take(MOST_WELLS));
    }
}

/// Computes the margins of bodies of a world.
struct Judge<'w> {
    world: &'w World,
    environment: Environment<'w>,
    wells: &'w [Well],
}

impl Judge<'_> {
    /// The margin of the bodies of a class at a limit; `oscillator` is the fastest of them.
    fn margin(&self, class: &StepClass, limit: Limit, oscillator: Oscillator) -> Margin {
        let (stepping, bodies) = (class.stepping, class.bodies);
        let h = stepping.tick / f64::from(stepping.substeps);
        let Oscillator { body, state, stiffness, drag, drag_now, occasion, damping: rate } =
            oscillator;
        let options = options_of(self.world.entity(body));
        let laws: SmallVec<[&dyn Law; 8]> = self.environment.on_body(&options, false).collect();
        let subject = self.subject(&laws, &options, state);
        let linear = |part: LimitingPart, stiffness: Scalar, value: Scalar| {
            let system = LinearSystem::one(Modes::one(stiffness, drag, subject.damping));
            system.margin(part, bodies, [value; 2], stepping)
        };
        match limit {
            Limit::Damping => {
                let part = if drag >= rate {
                    LimitingPart::Drag(body)
                } else {
                    LimitingPart::Damping(body)
                };
                let air = air(self.environment.laws.drag, options.laws, state.inverse_mass);
                let is_quadratic = air.is_some_and(|drag| drag.quadratic != 0.0);
                let slowed = Slowed {
                    subject,
                    rate: drag + rate,
                    now: drag_now + rate,
                    occasion,
                    is_quadratic,
                };
                let alone = air.map_or(0.0, |drag| drag.linear);
                let least = LinearSystem::one(Modes::one(0.0, alone, subject.damping));
                slowed.margin(linear(part, 0.0, h * (drag + rate)), &least, stepping)
            }
            Limit::Well(number) => {
                let well = self.wells[number];
                let is_lesser = !class.tried.is_empty() && self.wells.len() <= MOST_WELLS;
                let pair =
                    Pair { well, distance: state.position.distance(well.position), is_lesser };
                pair.margin(LimitingPart::Well(number, body), bodies, stepping)
            }
            Limit::Law(name) => {
                linear(LimitingPart::Law(name, body), stiffness, h * stiffness.sqrt().max(drag))
            }
        }
    }

    /// The worst margin among the orbits of a class that are tried.
    fn orbit(&self, class: &StepClass) -> Option<Margin> {
        if self.wells.len() > MOST_WELLS {
            return None;
        }
        let margins = class.tried.iter().map(|(part, well, Oscillator { body, state, .. })| {
            let options = options_of(self.world.entity(*body));
            let laws: SmallVec<[&dyn Law; 8]> = self.environment.on_body(&options, false).collect();
            let subject = self.subject(&laws, &options, *state);
            let wells = || self.wells.iter().chain(options.laws.iter().flat_map(|law| law.wells()));
            let pull = |x: DVec3| wells().map(|well| well.squared_frequency(x).max(0.0)).sum();
            let is_alone = wells().count() == 1
                && laws.len() == 1
                && subject.damping.is_none_or(|damping| damping.rate == 0.0)
                && subject.locks.is_none()
                && subject.speed_limit.is_none();
            let orbit = Orbit { subject, well: *well, is_alone, pull: &pull };
            orbit.margin(*part, class.bodies, class.stepping)
        });
        margins.max_by(|a, b| {
            a.is_unstable().cmp(&b.is_unstable()).then(a.ratio().total_cmp(&b.ratio()))
        })
    }

    fn subject<'l>(
        &self,
        laws: &'l [&'l dyn Law],
        options: &BodyOptions<'_>,
        start: BodyState,
    ) -> Subject<'l> {
        Subject {
            laws,
            damping: options.damping(self.environment.damping),
            locks: options.locks,
            speed_limit: options.speed_limit,
            start,
            time: self.environment.times.start,
        }
    }
}

/// The drag of all bodies and that of a body with its `own` laws and that inverse mass, 1/kg, together.
fn air(of_all: Option<&Drag>, own: &[Box<dyn Law>], inverse_mass: Scalar) -> Option<Drag> {
    let own = own.iter().filter_map(|law| law.drag(inverse_mass));
    let sum = |a: Drag, b: Drag| Drag {
        linear: a.linear + b.linear,
        quadratic: a.quadratic + b.quadratic,
        wind: a.wind.or(b.wind),
    };
    of_all.copied().into_iter().chain(own).reduce(sum)
}

/// Largest restoring rate of a derivative in any direction.
pub(crate) fn restoring_rate(derivative: DMat3) -> Scalar {
    let symmetric = (derivative + derivative.transpose()) * -0.5;
    let found = largest(3, 1, Scalar::INFINITY, None, |x, out| {
        (symmetric * DVec3::from_slice(x)).write_to_slice(out);
    });
    found.pairs.first().map_or(0.0, |(value, _)| *value)
}
