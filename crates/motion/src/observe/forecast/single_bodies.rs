//! The forecast of single bodies: damping, drag, wells and your own laws.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use glam::{DMat3, DVec3};

use super::cure::LinearSystem;
use super::lanczos::largest;
use super::modes::{Modes, Stepping};
use super::{Forecast, LimitingPart};
use crate::laws::damping::Damping;
use crate::laws::{BodyState, Drag, EvaluationTime, Gravity, Jacobians, Law, Laws, Wells};
use crate::methods::markers::{OwnMethod, own_method};
use crate::methods::table::Method;
use crate::state::clock::StepClock;
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::tick::columns::OptionColumns;
use crate::units::Scalar;

#[derive(QueryData)]
struct ForecastColumns {
    entity: Entity,
    transform: &'static Transform,
    body: &'static PhysicsBody,
    options: OptionColumns,
    marked: Has<OwnMethod>,
    grouped: Has<Grouped>,
    dormant: Has<Dormant>,
}

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

/// Bodies with the same method and substeps: the fastest of them for each limiting part.
struct StepClass {
    stepping: Stepping,
    bodies: usize,
    /// Fastest by drag and damping.
    damped: Option<Oscillator>,
    /// Fastest at each well.
    wells: Vec<Option<Oscillator>>,
    /// Fastest by each other law, by name.
    laws: Vec<(&'static str, Option<Oscillator>)>,
}

impl Forecast {
    pub(super) fn add_single_bodies(
        &mut self,
        world: &mut World,
        scenes: Stepping,
        is_solvable: &dyn Fn(Method) -> bool,
    ) {
        let (drag, wells) = (world.get_resource::<Drag>().copied(), world.get_resource::<Wells>().cloned());
        let damping = world.get_resource::<Damping>().copied();
        let gravity = world.get_resource::<Gravity>().and_then(Gravity::active_acceleration);
        let gravity = gravity.is_some_and(|acceleration| acceleration != DVec3::ZERO);
        let time = world.get_resource::<StepClock>().map_or(0.0, StepClock::scene_seconds);
        let wells = wells.unwrap_or_default().0;
        let mut query = world.query_filtered::<ForecastColumns, Without<Quarantined>>();
        let world = &*world;
        let more = world.get_resource::<Laws>().map_or(&[][..], |laws| &laws.0);
        let at = EvaluationTime { time, within_step: time };
        let mut classes: Vec<StepClass> = Vec::new();
        for row in query.iter(world) {
            let ForecastColumnsItem { entity, transform, body, marked, grouped, dormant, .. } = row;
            if body.inverse_mass <= 0.0 {
                continue;
            }
            let options = row.options.options();
            let method = if marked { own_method(world.entity(entity)) } else { None };
            let stepping = Stepping {
                method: method.unwrap_or(scenes.method),
                substeps: options.substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            let state = BodyState::<Scalar> {
                position: transform.position,
                // The velocity of a particle that is not born yet is unknown.
                velocity: if dormant { DVec3::ZERO } else { body.velocity },
                inverse_mass: body.inverse_mass,
            };
            // Without a driving force, k |u| u reverses and grows from k |u| h = 2 on. A falling body approaches its
            // terminal speed, where the slope is twice as steep.
            let slope = if gravity && !options.gravity_off { 2.0 } else { 1.0 };
            let of_drag =
                |drag: &Drag| drag.linear + slope * drag.quadratic * drag.against(time, state).length();
            let oscillator = Oscillator {
                body: entity,
                stiffness: 0.0,
                drag: drag.as_ref().map_or(0.0, of_drag),
                damping: options.damping(damping).map_or(0.0, |damping| damping.rate),
            };
            let class = classes.iter().position(|class| class.stepping == stepping).unwrap_or_else(|| {
                classes.push(StepClass {
                    stepping,
                    bodies: 0,
                    damped: None,
                    wells: vec![None; wells.len()],
                    laws: Vec::new(),
                });
                classes.len() - 1
            });
            classes[class].bodies += 1;
            if !grouped {
                keep_faster(&mut classes[class].damped, oscillator, |oscillator| {
                    oscillator.drag + oscillator.damping
                });
            }
            if dormant {
                continue;
            }
            for (well, fastest) in wells.iter().zip(&mut classes[class].wells) {
                let oscillator =
                    Oscillator { stiffness: well.squared_frequency(transform.position), ..oscillator };
                keep_faster(fastest, oscillator, |oscillator| oscillator.stiffness);
            }
            for law in more.iter().chain(options.laws) {
                classes[class].add_law(&**law, at, state, oscillator);
            }
        }
        let fastest = classes.iter().flat_map(|class| class.fastest(damping));
        let margin = |(part, value, class, system): (LimitingPart, Scalar, &StepClass, LinearSystem)| {
            system.margin(part, class.bodies, [value; 2], class.stepping, is_solvable)
        };
        self.margins.extend(fastest.map(margin));
    }
}

impl StepClass {
    /// The parts that limit the step of these bodies, with their values.
    fn fastest(
        &self,
        damping: Option<Damping>,
    ) -> impl Iterator<Item = (LimitingPart, Scalar, &Self, LinearSystem)> {
        let h = self.stepping.tick / f64::from(self.stepping.substeps);
        let damped = self.damped.map(|oscillator| {
            let part = if oscillator.drag >= oscillator.damping {
                LimitingPart::Drag(oscillator.body)
            } else {
                LimitingPart::Damping(oscillator.body)
            };
            (part, h * (oscillator.drag + oscillator.damping), oscillator)
        });
        let wells = self.wells.iter().enumerate();
        let wells = wells.filter_map(move |(number, oscillator)| {
            oscillator.map(|oscillator| {
                (LimitingPart::Well(number, oscillator.body), h * oscillator.stiffness.sqrt(), oscillator)
            })
        });
        let laws = self.laws.iter().filter_map(move |(name, oscillator)| {
            oscillator.map(|oscillator| {
                (
                    LimitingPart::Law(name, oscillator.body),
                    h * oscillator.stiffness.sqrt().max(oscillator.drag),
                    oscillator,
                )
            })
        });
        damped.into_iter().chain(wells).chain(laws).map(move |(part, value, oscillator)| {
            let damping = damping.map(|scenes| Damping { rate: oscillator.damping, ..scenes });
            (part, value, self, LinearSystem::one(Modes::one(oscillator.stiffness, oscillator.drag, damping)))
        })
    }

    fn add_law(
        &mut self,
        law: &dyn Law<Scalar>,
        at: EvaluationTime<Scalar>,
        state: BodyState<Scalar>,
        oscillator: Oscillator,
    ) {
        let Jacobians { position, velocity } = law.jacobians(at, state);
        if position == DMat3::ZERO && velocity == DMat3::ZERO {
            return;
        }
        let oscillator = Oscillator {
            stiffness: restoring_rate(position),
            drag: oscillator.drag + restoring_rate(velocity),
            ..oscillator
        };
        let slot = self.laws.iter().position(|(name, _)| *name == law.name()).unwrap_or_else(|| {
            self.laws.push((law.name(), None));
            self.laws.len() - 1
        });
        keep_faster(&mut self.laws[slot].1, oscillator, |oscillator| {
            oscillator.stiffness.sqrt() + oscillator.drag
        });
    }
}

/// Largest restoring rate of a derivative in any direction.
fn restoring_rate(derivative: DMat3) -> Scalar {
    let symmetric = (derivative + derivative.transpose()) * -0.5;
    let found =
        largest(3, 1, Scalar::INFINITY, |x, out| (symmetric * DVec3::from_slice(x)).write_to_slice(out));
    found.pairs.first().map_or(0.0, |(value, _)| *value)
}

/// Keeps the oscillator with the larger number, if that is above 0.
fn keep_faster(
    fastest: &mut Option<Oscillator>,
    oscillator: Oscillator,
    number: impl Fn(&Oscillator) -> Scalar,
) {
    if number(&oscillator) > fastest.as_ref().map_or(0.0, number) {
        *fastest = Some(oscillator);
    }
}
