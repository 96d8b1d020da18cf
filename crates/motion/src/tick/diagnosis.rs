//! Finds out why a body was refused: afterwards, its state is inspected and the forces and laws on it are evaluated
//! again.

use crate::laws::{BodyState, EvaluationTime, Law};
use crate::state::components::PhysicsBody;
use crate::state::range::{Breach, Quantity};
use crate::tick::environment::Environment;
use crate::tick::quarantine::{Cause, Fault, place};
use crate::units::{Scalar, Vector};

/// The component or resource at fault, and its fault.
pub(crate) type Evidence = (&'static str, Fault);

/// The components of a refused body at the time of the check.
pub(crate) struct Suspect<'a> {
    pub position: Vector,
    pub body: PhysicsBody,
    pub force: Vector,
    pub damping_rate: Option<Scalar>,
    pub limit: Option<Scalar>,
    pub last_step: Option<Scalar>,
    pub laws: &'a [Box<dyn Law>],
}

/// Which resources acted on a refused body.
#[derive(Clone, Copy)]
pub(crate) struct Exposure {
    /// Whether its velocity was updated, by forces and laws.
    pub kicks: bool,
    pub gravity_off: bool,
    /// Whether it has its own damping rate in place of the world's.
    pub own_rate: bool,
}

impl Suspect<'_> {
    /// The first component that is not finite.
    pub fn found(&self) -> Option<Evidence> {
        let Self { position, body, force, damping_rate, limit, last_step, .. } = self;
        let broken = |number: &Option<Scalar>| number.is_some_and(|number| !number.is_finite());
        let places = [
            (!position.is_finite(), place::POSITION),
            (!body.velocity.is_finite(), place::VELOCITY),
            (!body.inverse_mass.is_finite(), place::INVERSE_MASS),
            (!force.is_finite(), place::FORCE),
            (broken(damping_rate), place::DAMPING_RATE),
            // An infinite limit is valid: it limits nothing.
            (limit.is_some_and(Scalar::is_nan), place::SPEED_LIMIT),
            (broken(last_step), place::LAST_STEP),
        ];
        places.into_iter().find(|(broken, _)| *broken).map(|(_, place)| (place, Fault::Found))
    }

    /// The first of its own laws whose acceleration is not finite at one of the times.
    pub fn own_law(&self, times: [Scalar; 2]) -> Option<Evidence> {
        law_at_fault(self.laws.iter().map(|law| (place::OWN_LAWS, &**law)), self.state(), times)
    }

    pub fn state(&self) -> BodyState {
        let PhysicsBody { velocity, inverse_mass } = self.body;
        BodyState { position: self.position, velocity, inverse_mass }
    }
}

/// The first of these laws, each with the component or resource that it is in, whose acceleration is not finite.
fn law_at_fault<'a>(
    laws: impl Iterator<Item = (&'static str, &'a dyn Law)>,
    state: BodyState,
    times: [Scalar; 2],
) -> Option<Evidence> {
    let is_finite = |law: &dyn Law| {
        times.iter().all(|time| {
            law.acceleration(EvaluationTime { time: *time, within_step: *time }, state).is_finite()
        })
    };
    let mut law_at_fault = laws.filter(|(_, law)| !is_finite(*law));
    law_at_fault.next().map(|(place, law)| (place, Fault::Law(law.name())))
}

impl Environment<'_> {
    /// The first resource acting on a body that is not finite.
    pub(crate) fn found(&self, exposure: Exposure) -> Option<Evidence> {
        let Exposure { kicks, gravity_off, own_rate } = exposure;
        let falls = kicks && !gravity_off;
        let Self { laws, gravity, .. } = self;
        let places = [
            (
                self.range.is_some_and(|range| range.position.is_nan() || range.speed.is_nan()),
                place::RANGE,
            ),
            (
                falls && gravity.is_some_and(|gravity| !gravity.acceleration.is_finite()),
                place::GRAVITY,
            ),
            (
                !own_rate && self.damping.is_some_and(|damping| !damping.rate.is_finite()),
                place::DAMPING,
            ),
        ];
        let place = places.into_iter().find(|(broken, _)| *broken).map(|(_, place)| place);
        let law = || if kicks { laws.not_finite() } else { None };
        place.or_else(law).map(|place| (place, Fault::Found))
    }

    /// The first of the laws of every body that gives this body an acceleration that is not finite.
    pub(crate) fn law_at_fault(&self, state: BodyState) -> Option<Evidence> {
        let more = self.laws.more.iter().map(|law| (place::LAWS, &**law));
        law_at_fault(self.laws.resources().chain(more), state, self.times.ends())
    }

    /// The cause of a refusal: the evidence, or else the bound that was exceeded.
    pub(crate) fn cause(
        &self,
        system: &'static str,
        breach: Breach,
        evidence: Option<Evidence>,
    ) -> Cause {
        let component = match breach.of {
            Quantity::Position => place::POSITION,
            Quantity::Velocity => place::VELOCITY,
        };
        let range = self.range.copied().unwrap_or_default();
        let outside = match breach.of {
            Quantity::Position => Fault::Range(range.position),
            Quantity::Velocity => Fault::Range(range.speed),
        };
        let (component, fault) = match evidence {
            Some(evidence) => evidence,
            None if breach.finite => (component, outside),
            None => (component, Fault::Overflow),
        };
        Cause { system, component, fault }
    }
}
