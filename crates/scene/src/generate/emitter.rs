//! Emitters: the pool of each, and the velocities with which its particles are born.

use glam::DVec3;

use super::entry::{GeneratedEntry, count, direction, shared};
use super::on_device::on_device;
use crate::check::{MASS, RADIUS, Rule, SPEED, Scope, positive, rule};
use crate::random::in_cone;
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::coupled::EmitterSpec;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

const RATE: Rule = rule(positive, "a rate", "give a positive number of particles a second");
const LIFE: Rule = rule(positive, "a time to live", "give a positive number of seconds");
/// The radius of a particle if the scene names none, m.
const DROP_M: f64 = 0.04;
/// Half the angle of the cone.
const SPREAD: Rule = rule(
    |v| (0.0..=180.0).contains(&v),
    "an angle of spread",
    "give degrees from 0 to 180, from the middle to the edge",
);

/// Resolves emitter `index` of the list.
pub(super) fn emitter(raw: &raw::Emitter, index: usize, faults: &mut Faults) -> GeneratedEntry {
    let scope = Scope::item("emitters", index);
    faults.require(
        raw.rate_per_s.is_some(),
        scope,
        "rate_per_s",
        "add one such as `rate_per_s: 100.0`",
    );
    faults.require(
        raw.speed_m_s.is_some(),
        scope,
        "speed_m_s",
        "add one such as `speed_m_s: 10.0`",
    );
    faults.require(raw.life_s.is_some(), scope, "life_s", "add one such as `life_s: 3.0`");
    let rate = faults.number(scope, "rate_per_s", raw.rate_per_s, 1.0, RATE);
    let life = faults.number(scope, "life_s", raw.life_s, 1.0, LIFE);
    let mut capacity = match raw.capacity {
        // As many particles as live at once.
        None => (rate * life).ceil() as u64,
        Some(_) => u64::from(count(raw.capacity, scope, "capacity", faults)),
    };
    let direction = direction(scope, "direction", raw.direction, faults);
    let spread_deg = faults.number(scope, "spread_deg", raw.spread_deg, 0.0, SPREAD);
    let speed = faults.number(scope, "speed_m_s", raw.speed_m_s, 0.0, SPEED);
    let radius = faults.number(scope, "radius_m", raw.radius_m, DROP_M, RADIUS) as f32;
    // The whole pool is at rest at the emitter.
    let (body, own) = shared(&raw.shared(), scope, 1.0, 1.0, MASS, faults);
    let position = faults.vector(scope, "position_m", raw.position_m, DVec3::ZERO);
    let body = BodySpec { position, ..body };
    let particles = on_device(raw, scope, &mut capacity, body.method, faults);
    let [count, on_device] = if particles.is_some() { [0, capacity] } else { [capacity, 0] };
    let entry = GeneratedEntry::new(
        scope,
        own,
        count,
        Numbering::Line,
        body,
        move |name, bodies, random| {
            let (right, up) = direction.any_orthonormal_pair();
            let sine_of_half = libm::sin((0.5 * spread_deg).to_radians());
            let launch = |_| {
                let [x, y, z] = in_cone(random, sine_of_half).to_array();
                speed * (x * right + y * up + z * direction)
            };
            let launches = (0..capacity).map(launch);
            let first = bodies.bodies.len() as u32;
            let (launches, on_device) = match &particles {
                None => (launches.collect(), None),
                Some(particles) => (Vec::new(), Some(particles.born_with(launches))),
            };
            bodies.bodies.extend(launches.iter().map(|_| body));
            bodies.emitters.push(EmitterSpec {
                name,
                rate,
                life,
                rides_on: None,
                position: body.position,
                pool: first..bodies.bodies.len() as u32,
                launches,
                on_device,
                inverse_mass: body.inverse_mass.unwrap_or_default(),
                radius,
                color: body.color,
            });
        },
    );
    GeneratedEntry { on_device, ..entry }
}

#[cfg(test)]
mod tests;
