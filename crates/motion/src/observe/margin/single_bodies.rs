//! The margins of single bodies: damping, drag, wells and your own laws.

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3};

use super::cure::LinearSystem;
use super::lanczos::largest;
use super::modes::{Oscillators, Stepping};
use super::{LimitingPart, Margin, Margins};
use crate::groups::{Coupled, members};
use crate::laws::damping::Damping;
use crate::laws::{BodyState, EvaluationTime, Jacobians, Law, SharedLaws};
use crate::schedule::emission::carrier_state;
use crate::state::archetypes::collect;
use crate::state::clock::StepClock;
use crate::state::components::Quarantined;
use crate::state::emitter::{Emitter, RidesOn};
use crate::tick::columns::{ObservedColumnsItem, observed};
use crate::tick::environment::Environment;
use crate::units::Scalar;

/// A body as an oscillator under one of the causes that may limit its step.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    part: LimitingPart,
    /// Square of the frequency, 1/s².
    stiffness: Scalar,
    /// Rate of drag, 1/s.
    drag: Scalar,
    damping: Option<Damping>,
    is_linear: bool,
}

/// Bodies with the same method and substeps: the fastest of them for each cause.
struct StepClass {
    stepping: Stepping,
    bodies: usize,
    fastest: Vec<Oscillator>,
}

impl Margins {
    pub(super) fn add_single_bodies(
        &mut self,
        world: &World,
        scenes: Stepping,
        coming: Option<&[Coupled]>,
    ) {
        let coming: Option<EntityHashSet> = coming.map(|coming| members(coming).collect());
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let time = clock.scene_seconds();
        let launches = launches(world);
        let mut query = observed::<Without<Quarantined>>(world);
        let environment = Environment::of(world, clock, scenes.tick);
        let wells = environment.laws.wells.map_or(&[][..], |wells| &wells.0);
        let at = EvaluationTime { time, within_step: time };
        let mut classes: Vec<StepClass> = Vec::new();
        for row in query.iter(world) {
            let ObservedColumnsItem { entity, dormant, .. } = row;
            // The mark is that of the last tick.
            let grouped = coming.as_ref().map_or(row.grouped, |coming| coming.contains(&entity));
            let mut state = row.state();
            if dormant && let Some((position, velocity)) = launches.get(&entity) {
                (state.position, state.velocity) = (*position, *velocity);
            }
            if state.inverse_mass <= 0.0 {
                continue;
            }
            let options = row.options.options();
            let stepping = Stepping {
                method: row.method(world).unwrap_or(scenes.method),
                substeps: options.substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            let class = StepClass::find(&mut classes, stepping);
            class.bodies += 1;
            let damping = options.damping(environment.damping);
            // The group has the drag of all bodies, the damping and the wells of its members.
            let shared_drag = environment.laws.drag.filter(|_| !grouped);
            let others = SharedLaws { drag: shared_drag, wells: None, ..environment.laws };
            let (mut drag, mut is_linear, mut others_of) = (0.0, !grouped, Vec::new());
            for law in others.on_body(None, false, options.laws) {
                let Jacobians { position, velocity } = law.jacobians(at, state);
                let rates = [restoring_rate(position), restoring_rate(velocity)];
                if law.name() == "drag" {
                    drag += rates[1];
                    is_linear &= self::is_linear(law, at, state);
                } else if position != DMat3::ZERO || velocity != DMat3::ZERO {
                    others_of.push((law.name(), rates));
                }
            }
            let damping_rate = damping.filter(|_| !grouped).map_or(0.0, |damping| damping.rate);
            let part = if drag >= damping_rate {
                LimitingPart::Drag(entity)
            } else {
                LimitingPart::Damping(entity)
            };
            let damped = Oscillator {
                part,
                stiffness: 0.0,
                drag,
                damping: damping.filter(|_| !grouped),
                is_linear,
            };
            class.keep(damped);
            let nonlinear = Oscillator { damping, is_linear: false, ..damped };
            let joined = grouped && environment.attraction.is_none();
            for (number, well) in wells.iter().enumerate().filter(|_| !joined) {
                let stiffness = well.squared_frequency(state.position);
                let part = LimitingPart::Well(number, entity);
                class.keep(Oscillator { part, stiffness, ..nonlinear });
            }
            for (name, [stiffness, rate]) in others_of {
                let part = LimitingPart::Law(name, entity);
                class.keep(Oscillator { part, stiffness, drag: drag + rate, ..nonlinear });
            }
        }
        self.list.extend(classes.into_iter().flat_map(StepClass::margins));
    }
}

/// Position, m, and velocity, m/s, at birth of every body of an emitter.
fn launches(world: &World) -> EntityHashMap<(DVec3, DVec3)> {
    let mut launches = EntityHashMap::default();
    for (entity, emitter) in collect::<Emitter, _>(world, Some) {
        let Emitter { position, pool, launches: velocities, .. } = emitter;
        let carrier = world.get::<RidesOn>(entity);
        let (x, v) = carrier.and_then(|carrier| carrier_state(world, *carrier)).unwrap_or_default();
        let births = pool.iter().zip(velocities);
        launches.extend(births.map(|(body, velocity)| (*body, (*position + x, *velocity + v))));
    }
    launches
}

/// Whether a law has the same derivatives at another position and velocity.
pub(super) fn is_linear(law: &dyn Law, at: EvaluationTime, state: BodyState) -> bool {
    let (position, velocity) = (state.position + DVec3::ONE, state.velocity * 2.0 + DVec3::ONE);
    law.jacobians(at, BodyState { position, velocity, ..state }) == law.jacobians(at, state)
}

impl Oscillator {
    /// Whether both are of the same cause: wells, the same law, or drag and damping.
    fn is_alike(&self, other: &Self) -> bool {
        match (self.part, other.part) {
            (LimitingPart::Well(..), LimitingPart::Well(..)) => true,
            (LimitingPart::Law(a, _), LimitingPart::Law(b, _)) => a == b,
            (
                LimitingPart::Drag(_) | LimitingPart::Damping(_),
                LimitingPart::Drag(_) | LimitingPart::Damping(_),
            ) => self.is_linear == other.is_linear,
            _ => false,
        }
    }

    /// How strongly the step of the body is limited, to compare it with other bodies.
    fn speed(&self) -> Scalar {
        let damping = self.damping.map_or(0.0, |damping| damping.rate);
        match self.part {
            LimitingPart::Drag(_) | LimitingPart::Damping(_) => self.drag + damping,
            LimitingPart::Well(..) => self.stiffness,
            LimitingPart::Spring(_)
            | LimitingPart::Damper(_)
            | LimitingPart::Law(..)
            | LimitingPart::MutualGravity(_) => self.stiffness.sqrt() + self.drag,
        }
    }
}

impl StepClass {
    fn find(classes: &mut Vec<Self>, stepping: Stepping) -> &mut Self {
        let place =
            classes.iter().position(|class| class.stepping == stepping).unwrap_or_else(|| {
                classes.push(Self { stepping, bodies: 0, fastest: Vec::new() });
                classes.len() - 1
            });
        &mut classes[place]
    }

    /// Keeps an oscillator if it is the fastest of its cause so far.
    fn keep(&mut self, oscillator: Oscillator) {
        if oscillator.speed() <= 0.0 {
            return;
        }
        match self.fastest.iter_mut().find(|known| known.is_alike(&oscillator)) {
            Some(known) if oscillator.speed() > known.speed() => *known = oscillator,
            Some(_) => {}
            None => self.fastest.push(oscillator),
        }
    }

    /// The margins of the causes.
    fn margins(self) -> impl Iterator<Item = Margin> {
        let Self { stepping, bodies, fastest } = self;
        let h = stepping.substep();
        fastest.into_iter().map(move |oscillator| {
            let Oscillator { part, stiffness, drag, damping, is_linear } = oscillator;
            let value = match part {
                LimitingPart::Drag(_) | LimitingPart::Damping(_) => h * oscillator.speed(),
                LimitingPart::Spring(_)
                | LimitingPart::Damper(_)
                | LimitingPart::Well(..)
                | LimitingPart::Law(..)
                | LimitingPart::MutualGravity(_) => h * stiffness.sqrt().max(drag),
            };
            let system = LinearSystem::one(Oscillators::one(stiffness, drag, damping));
            system.margin(part, bodies, value, value, stepping, is_linear)
        })
    }
}

/// Largest restoring rate of a derivative in any direction.
pub(crate) fn restoring_rate(derivative: DMat3) -> Scalar {
    let symmetric = (derivative + derivative.transpose()) * -0.5;
    let found = largest(3, 1, Scalar::INFINITY, None, |x, out| {
        (symmetric * DVec3::from_slice(x)).write_to_slice(out);
    });
    found.pairs.first().map_or(0.0, |(value, _)| *value)
}
