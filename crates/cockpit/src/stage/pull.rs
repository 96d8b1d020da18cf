//! The pull of the pointer on a body: a damped spring from the grabbed point to the pointer.
//!
//! The force is a push in every tick, so it is recorded, repeated and entered into the ledger like any push.

use bevy_ecs::entity::Entity;
use glam::DVec3;
use motion::{BodyOscillator, PhysicsBody, SoftBody};

use crate::stage::Stage;
use crate::stage::soft::mass;
use crate::stage::things::Picked;

/// Angular frequency of the spring, 1/s: the pulled body follows within half a second.
const FREQUENCY: f64 = 8.0;

/// Maximum phase of the spring per tick for the pulled body alone, rad, so that every method stays stable.
const PER_TICK: f64 = 0.4;

/// Phase of a body's own oscillation per tick, rad, from which on forces that are constant over a tick do not damp it.
const OWN_PER_TICK: f64 = 2.6;

/// Maximum force, in units of the pulled mass's weight on Earth.
const WEIGHTS: f64 = 30.0;

/// Gravitational acceleration on Earth, m/s².
const EARTH: f64 = 9.8;

/// A pull of the pointer on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pull {
    /// The body, or a point of a soft body.
    pub body: Entity,
    /// Mass of the body, or of all movable points of its soft body, kg.
    pub mass: f64,
    /// From the body's center to the grabbed point, m.
    pub offset: DVec3,
    /// Depth of the grabbed point in front of the camera, m.
    pub depth: f64,
    /// Target of the grabbed point, at the pointer, m.
    pub toward: DVec3,
    /// The force of the last tick, N.
    pub newtons: f64,
    /// Whether the maximum force limited it.
    pub limited: bool,
}

impl Pull {
    /// A pull of the body that a push at `hit` acts on, if forces move the body. The grabbed point is `place`, m, at `depth`, m,
    /// in front of the camera.
    pub fn of(stage: &Stage, hit: &Picked, place: DVec3, depth: f64) -> Option<Self> {
        let (body, world) = (hit.pushed?, &stage.sim.world);
        let state = world.get::<PhysicsBody>(body).filter(|state| state.inverse_mass > 0.0)?;
        let soft = world.get::<SoftBody>(hit.entity).map(|soft| mass(world, soft));
        let (mass, offset) = (soft.unwrap_or(state.mass()), place - stage.drawn_position(body)?);
        Some(Self { body, mass, offset, depth, toward: place, newtons: 0.0, limited: false })
    }

    /// The force on the body at `position`, m, in a tick of `tick` seconds, N. `own` is the body without the pull.
    pub fn force(
        &mut self,
        position: DVec3,
        body: &PhysicsBody,
        own: &BodyOscillator,
        tick: f64,
    ) -> DVec3 {
        let mass = body.mass();
        // Stiffness for the whole mass, limited to the stable range of this body; critically damped for this body.
        let stiffness = (self.mass * FREQUENCY.powi(2))
            .min(mass * (self.per_tick(own, mass, tick) / tick).powi(2));
        let damping = 2.0 * (stiffness * mass).sqrt();
        let force = (self.toward - (position + self.offset)) * stiffness - body.velocity * damping;
        let newtons = force.clamp_length_max(WEIGHTS * self.mass * EARTH);
        (self.newtons, self.limited) = (newtons.length(), newtons != force);
        newtons
    }

    /// Maximum phase of the spring per tick, rad, beside what already acts on the body of `mass` kg. The spring is a force from the
    /// state before each tick, so that it is stable only within the part of the method's limit that the body leaves.
    fn per_tick(&self, own: &BodyOscillator, mass: f64, tick: f64) -> f64 {
        // Methods without a limit grow in every oscillation; a limit of 2 keeps the spring from adding to it.
        let limit = match own.method.claims().stability_limit {
            0.0 => 2.0,
            limit if limit.is_infinite() => return PER_TICK,
            limit => limit,
        };
        let (squared, rate) = (own.stiffness * tick * tick, own.rate * tick);
        let part = own.step / (tick * limit);
        let of_step = 1.0 - squared * part * part - rate * part;
        // Of the oscillations that are too fast for ticks, the slowest is damped least. One of a uniform soft body moves a point
        // with at most four times its share of the mass.
        let too_fast = squared / OWN_PER_TICK.powi(2);
        let damped = 0.25 * rate / too_fast.max(1.0) * (0.25 * self.mass / mass).max(1.0);
        let of_tick = (1.0 - too_fast).max(damped);
        PER_TICK.min(2.0 * of_step.min(of_tick).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use motion::{Method, Transform};
    use scene::Scene;

    use super::*;
    use crate::stage::options::Options;

    const HZ: f64 = 60.0;

    fn pull(body: Entity) -> Pull {
        let (offset, toward) = (DVec3::ZERO, DVec3::X);
        Pull { body, mass: 1.0, offset, depth: 1.0, toward, newtons: 0.0, limited: false }
    }

    /// The largest distance from rest, m, of a ball of 1 kg on a spring of frequency `w`, rad/s, that is pulled by 1 m along half a
    /// circle for five seconds and let go for five.
    fn farthest(method: Method, substeps: u32, w: f64) -> f64 {
        let text = format!(
            "(version: 1, step_hz: {HZ}, method: {}, substeps: {substeps},
              bodies: [(name: \"post\", immovable: true), (name: \"ball\", mass_kg: 1)],
              springs: [(between: (\"post\", \"ball\"), stiffness_n_m: {}, rest_length_m: 0)])",
            method.name(),
            w * w
        );
        let mut stage = Stage::new(Scene::parse("t", &text).expect("a scene"), Options::default());
        let body = stage.sim().named("ball").expect("the ball");
        stage.set_pull(Some(pull(body)));
        let mut farthest = 0.0_f64;
        for tick in 0..600_u32 {
            if tick == 300 {
                stage.set_pull(None);
            }
            if let Some(pull) = stage.pull_mut() {
                let (sin, cos) = (std::f64::consts::PI * f64::from(tick) / 300.0).sin_cos();
                pull.toward = DVec3::new(cos, sin, 0.0);
            }
            stage.before_first_tick(None);
            stage.begin_tick(false);
            stage.tick(false, None);
            let place = stage.sim().world.get::<Transform>(body).expect("it is there").position;
            farthest = farthest.max(place.length());
        }
        farthest
    }

    #[test]
    fn a_pull_on_a_stable_spring_moves_it_at_most_twice_as_far_as_at_rest() {
        for method in Method::ALL {
            // Where nothing or all is stable: what the method alone bears for ten seconds, and what is stiff.
            let limit = match method.claims().stability_limit {
                0.0 if method == Method::ExplicitEuler => 0.02,
                0.0 => 0.2,
                limit => limit.min(20.0),
            };
            for (part, substeps) in [0.5_f64, 0.75, 0.9, 0.99, 0.999]
                .into_iter()
                .flat_map(|part| [1, 2, 5].map(|n| (part, n)))
            {
                let w = part * limit * HZ * f64::from(substeps);
                let at_rest = FREQUENCY.powi(2) / (FREQUENCY.powi(2) + w * w);
                // A force that begins suddenly swings it as far beyond its place at rest; a first step of semi-implicit Euler is
                // twice as long as of the others, as if it began with a velocity.
                let beyond = match method {
                    Method::SemiImplicitEuler => (1.0 - part * part).sqrt().recip(),
                    _ => 1.0,
                };
                let most = 1.05 * (1.0 + beyond) * at_rest;
                let found = farthest(method, substeps, w);
                assert!(
                    found <= most,
                    "{} {part} {substeps}: {found} m of {most} m",
                    method.name()
                );
            }
        }
    }

    #[test]
    fn what_hangs_softly_is_pulled_as_stiffly_as_what_is_free() {
        for method in Method::ALL {
            let body = |stiffness| BodyOscillator { method, step: 1.0 / HZ, stiffness, rate: 1.0 };
            let pull = pull(Entity::PLACEHOLDER);
            for w in [0.0, 1.0, 10.0, 50.0] {
                let most = pull.per_tick(&body(w * w), 1.0, 1.0 / HZ);
                assert_eq!(most, PER_TICK, "{} {w}", method.name());
            }
        }
    }
}
