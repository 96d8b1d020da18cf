//! The forecast of single bodies: damping, drag, wells and your own laws.

use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3};

use super::cure::LinearSystem;
use super::lanczos::largest;
use super::modes::{Modes, Stepping};
use super::{Forecast, LimitingPart, Margin};
use crate::laws::damping::Damping;
use crate::laws::{Drag, EvaluationTime, Gravity, Jacobians, SharedLaws};
use crate::state::clock::StepClock;
use crate::state::components::Quarantined;
use crate::tick::columns::{ObservedColumns, ObservedColumnsItem};
use crate::units::Scalar;

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

/// What may limit the step of a body.
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
}

/// Largest number of wells that are listed for the bodies of a class: the fastest.
const MOST_WELLS: usize = 64;

impl Forecast {
    pub(super) fn add_single_bodies(&mut self, world: &mut World, scenes: Stepping) {
        let damping = world.get_resource::<Damping>().copied();
        let gravity = world.get_resource::<Gravity>().and_then(Gravity::active_acceleration);
        let gravity = gravity.is_some_and(|acceleration| acceleration != DVec3::ZERO);
        let time = world.get_resource::<StepClock>().map_or(0.0, StepClock::scene_seconds);
        let mut query = world.query_filtered::<ObservedColumns, Without<Quarantined>>();
        let world = &*world;
        let laws = SharedLaws::of(world);
        let others = SharedLaws { drag: None, wells: None, ..laws };
        let wells = laws.wells.map_or(&[][..], |wells| &wells.0);
        let at = EvaluationTime { time, within_step: time };
        let mut classes: Vec<StepClass> = Vec::new();
        for row in query.iter(world) {
            let ObservedColumnsItem { entity, grouped, dormant, .. } = row;
            let mut state = row.state();
            if state.inverse_mass <= 0.0 {
                continue;
            }
            if dormant {
                // The velocity of a particle that is not born yet is unknown.
                state.velocity = DVec3::ZERO;
            }
            let options = row.options.options();
            let stepping = Stepping {
                method: row.method(world).unwrap_or(scenes.method),
                substeps: options.substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            // Without a driving force, k |u| u reverses and grows from k |u| h = 2 on. A falling body approaches its
            // terminal speed, where the slope is twice as steep.
            let slope = if gravity && !options.gravity_off { 2.0 } else { 1.0 };
            let of_drag =
                |drag: &Drag| drag.linear + slope * drag.quadratic * drag.against(time, state).length();
            let oscillator = Oscillator {
                body: entity,
                stiffness: 0.0,
                drag: laws.drag.map_or(0.0, of_drag),
                damping: options.damping(damping).map_or(0.0, |damping| damping.rate),
            };
            let class = classes.iter().position(|class| class.stepping == stepping).unwrap_or_else(|| {
                classes.push(StepClass { stepping, bodies: 0, fastest: Vec::new(), wells: Vec::new() });
                classes.len() - 1
            });
            let class = &mut classes[class];
            class.bodies += 1;
            if !grouped {
                class.keep(Limit::Damping, oscillator);
            }
            if dormant {
                continue;
            }
            for (number, well) in wells.iter().enumerate() {
                let stiffness = well.squared_frequency(state.position);
                class.keep(Limit::Well(number), Oscillator { stiffness, ..oscillator });
            }
            for law in others.all().chain(options.laws.iter().map(|law| &**law)) {
                let Jacobians { position, velocity } = law.jacobians(at, state);
                if position != DMat3::ZERO || velocity != DMat3::ZERO {
                    let drag = oscillator.drag + restoring_rate(velocity);
                    let oscillator = Oscillator { stiffness: restoring_rate(position), drag, ..oscillator };
                    class.keep(Limit::Law(law.name()), oscillator);
                }
            }
        }
        for mut class in classes {
            class.list_wells();
            class.fastest.sort_by_key(|(limit, _)| limit.rank());
            let fastest =
                class.fastest.iter().filter_map(|(limit, oscillator)| Some((*limit, (*oscillator)?)));
            self.margins.extend(fastest.map(|(limit, oscillator)| class.margin(limit, oscillator, damping)));
        }
    }
}

impl Limit {
    /// Place in the list of margins: in this order, laws as they came.
    fn rank(self) -> usize {
        match self {
            Self::Damping => 0,
            Self::Well(number) => number + 1,
            Self::Law(_) => usize::MAX,
        }
    }

    /// By how much a body is limited, to compare it with others.
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
            let place = self.fastest.iter().position(|(known, _)| *known == limit).unwrap_or_else(|| {
                self.fastest.push((limit, None));
                self.fastest.len() - 1
            });
            &mut self.fastest[place].1
        };
        if limit.speed(&oscillator) > fastest.as_ref().map_or(0.0, |fastest| limit.speed(fastest)) {
            *fastest = Some(oscillator);
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

    /// The margin of these bodies at a limit, of which the oscillator is the fastest.
    fn margin(&self, limit: Limit, oscillator: Oscillator, damping: Option<Damping>) -> Margin {
        let h = self.stepping.tick / f64::from(self.stepping.substeps);
        let Oscillator { body, stiffness, drag, damping: rate } = oscillator;
        let (part, value) = match limit {
            Limit::Damping if drag >= rate => (LimitingPart::Drag(body), h * (drag + rate)),
            Limit::Damping => (LimitingPart::Damping(body), h * (drag + rate)),
            Limit::Well(number) => (LimitingPart::Well(number, body), h * stiffness.sqrt()),
            Limit::Law(name) => (LimitingPart::Law(name, body), h * stiffness.sqrt().max(drag)),
        };
        let damping = damping.map(|scenes| Damping { rate, ..scenes });
        let system = LinearSystem::one(Modes::one(stiffness, drag, damping));
        system.margin(part, self.bodies, [value; 2], self.stepping)
    }
}

/// Largest restoring rate of a derivative in any direction.
fn restoring_rate(derivative: DMat3) -> Scalar {
    let symmetric = (derivative + derivative.transpose()) * -0.5;
    let found = largest(3, 1, Scalar::INFINITY, None, |x, out| {
        (symmetric * DVec3::from_slice(x)).write_to_slice(out);
    });
    found.pairs.first().map_or(0.0, |(value, _)| *value)
}
