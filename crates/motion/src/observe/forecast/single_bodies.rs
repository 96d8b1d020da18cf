//! ForecastQuery that nothing joins: damping, drag and wells.

use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3};

use super::cure::LinearSystem;
use super::lanczos::largest;
use super::modes::{Modes, Pace};
use super::{Forecast, LimitingPart};
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::laws::{BodyState, Drag, EvaluationTime, Gravity, Jacobians, Law, Laws, Wells};
use crate::methods::markers::{OwnMethod, own_method};
use crate::methods::table::Method;
use crate::state::clock::StepClock;
use crate::state::components::{GravityOff, PhysicsBody, Quarantined, Transform};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::substeps::OwnSubsteps;
use crate::units::Scalar;

type ForecastQuery = (
    Entity,
    &'static Transform,
    &'static PhysicsBody,
    Option<&'static DampingRate>,
    Option<&'static OwnSubsteps>,
    Option<&'static OwnLaws>,
    Has<OwnMethod>,
    Has<Grouped>,
    Has<Dormant>,
    Has<GravityOff>,
);

/// One body as an oscillator.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    body: Entity,
    /// Square of the frequency, 1/s².
    stiffness: Scalar,
    /// Rates of drag and of the scene's damping, 1/s.
    drag: Scalar,
    damping: Scalar,
}

/// The fastest of the bodies that are stepped alike.
struct StepClass {
    pace: Pace,
    bodies: usize,
    /// By drag and damping.
    damped: Option<Oscillator>,
    /// At each well.
    wells: Vec<Option<Oscillator>>,
    /// By other laws, by name.
    laws: Vec<(&'static str, Option<Oscillator>)>,
}

impl Forecast {
    pub(super) fn look_at_single_bodies(
        &mut self,
        world: &mut World,
        scenes: Pace,
        solvable: &dyn Fn(Method) -> bool,
    ) {
        let (drag, wells) = (world.get_resource::<Drag>().copied(), world.get_resource::<Wells>().cloned());
        let damping = world.get_resource::<Damping>().copied();
        let gravity = world.get_resource::<Gravity>().and_then(Gravity::acting);
        let gravity = gravity.is_some_and(|acceleration| acceleration != DVec3::ZERO);
        let time = world.get_resource::<StepClock>().map_or(0.0, StepClock::scene_seconds);
        let wells = wells.unwrap_or_default().0;
        let mut query = world.query_filtered::<ForecastQuery, Without<Quarantined>>();
        let world = &*world;
        let more = world.get_resource::<Laws>().map_or(&[][..], |laws| &laws.0);
        let at = EvaluationTime { time, within_step: time };
        let mut kinds: Vec<StepClass> = Vec::new();
        for (entity, transform, body, rate, substeps, own, marked, grouped, dormant, floats) in
            query.iter(world)
        {
            if body.inverse_mass <= 0.0 {
                continue;
            }
            let method = if marked { own_method(world.entity(entity)) } else { None };
            let pace = Pace {
                method: method.unwrap_or(scenes.method),
                substeps: substeps.map_or(scenes.substeps, |substeps| substeps.0.max(1)),
                ..scenes
            };
            let state = BodyState::<Scalar> {
                position: transform.position,
                // Nobody knows that of a particle that will be born.
                velocity: if dormant { DVec3::ZERO } else { body.velocity },
                inverse_mass: body.inverse_mass,
            };
            // k |u| u slows a body down that nothing drives, and drives it beyond where it came from from k |u| h = 2 on.
            // One that falls has a speed to come to, around which its slope is twice as steep.
            let slope = if gravity && !floats { 2.0 } else { 1.0 };
            let of_drag =
                |drag: &Drag| drag.linear + slope * drag.quadratic * drag.against(time, state).length();
            let one = Oscillator {
                body: entity,
                stiffness: 0.0,
                drag: drag.as_ref().map_or(0.0, of_drag),
                damping: damping.map_or(0.0, |scenes| rate.map_or(scenes.rate, DampingRate::rate)),
            };
            let kind = kinds.iter().position(|kind| kind.pace == pace).unwrap_or_else(|| {
                kinds.push(StepClass {
                    pace,
                    bodies: 0,
                    damped: None,
                    wells: vec![None; wells.len()],
                    laws: Vec::new(),
                });
                kinds.len() - 1
            });
            kinds[kind].bodies += 1;
            if !grouped {
                keep_faster(&mut kinds[kind].damped, one, |one| one.drag + one.damping);
            }
            if dormant {
                continue;
            }
            for (well, fastest) in wells.iter().zip(&mut kinds[kind].wells) {
                let one = Oscillator { stiffness: well.squared_frequency(transform.position), ..one };
                keep_faster(fastest, one, |one| one.stiffness);
            }
            for law in more.iter().chain(own.into_iter().flat_map(OwnLaws::laws)) {
                kinds[kind].look_at_law(&**law, at, state, one);
            }
        }
        let fastest = kinds.iter().flat_map(|kind| kind.fastest(damping));
        let margin = |(part, value, kind, system): (LimitingPart, Scalar, &StepClass, LinearSystem)| {
            system.margin(part, kind.bodies, [value; 2], kind.pace, solvable)
        };
        self.margins.extend(fastest.map(margin));
    }
}

impl StepClass {
    /// What limits the step of its bodies, with its value.
    fn fastest(
        &self,
        damping: Option<Damping>,
    ) -> impl Iterator<Item = (LimitingPart, Scalar, &Self, LinearSystem)> {
        let h = self.pace.tick / f64::from(self.pace.substeps);
        let damped = self.damped.map(|one| {
            let part = if one.drag >= one.damping {
                LimitingPart::Drag(one.body)
            } else {
                LimitingPart::Damping(one.body)
            };
            (part, h * (one.drag + one.damping), one)
        });
        let wells = self.wells.iter().enumerate();
        let wells = wells.filter_map(move |(number, one)| {
            one.map(|one| (LimitingPart::Well(number, one.body), h * one.stiffness.sqrt(), one))
        });
        let laws = self.laws.iter().filter_map(move |(name, one)| {
            one.map(|one| (LimitingPart::Law(name, one.body), h * one.stiffness.sqrt().max(one.drag), one))
        });
        damped.into_iter().chain(wells).chain(laws).map(move |(part, value, one)| {
            let damping = damping.map(|scenes| Damping { rate: one.damping, ..scenes });
            (part, value, self, LinearSystem::one(Modes::one(one.stiffness, one.drag, damping)))
        })
    }

    fn look_at_law(
        &mut self,
        law: &dyn Law<Scalar>,
        at: EvaluationTime<Scalar>,
        state: BodyState<Scalar>,
        one: Oscillator,
    ) {
        let Jacobians { position, velocity } = law.jacobians(at, state);
        if position == DMat3::ZERO && velocity == DMat3::ZERO {
            return;
        }
        let one = Oscillator { stiffness: pull(position), drag: one.drag + pull(velocity), ..one };
        let slot = self.laws.iter().position(|(name, _)| *name == law.name()).unwrap_or_else(|| {
            self.laws.push((law.name(), None));
            self.laws.len() - 1
        });
        keep_faster(&mut self.laws[slot].1, one, |one| one.stiffness.sqrt() + one.drag);
    }
}

/// How much a derivative pulls back at most, in any direction.
fn pull(derivative: DMat3) -> Scalar {
    let symmetric = (derivative + derivative.transpose()) * -0.5;
    let found =
        largest(3, 1, Scalar::INFINITY, |x, out| (symmetric * DVec3::from_slice(x)).write_to_slice(out));
    found.pairs.first().map_or(0.0, |(value, _)| *value)
}

/// Keeps the one with the larger number, if it is above 0.
fn keep_faster(kept: &mut Option<Oscillator>, one: Oscillator, number: impl Fn(&Oscillator) -> Scalar) {
    if number(&one) > kept.as_ref().map_or(0.0, number) {
        *kept = Some(one);
    }
}
