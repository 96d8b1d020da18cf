//! Emitters: the pool of each, and the velocities with which its particles are born.

use glam::DVec3;
use motion::{Method, Swarm};

use super::entry::{GeneratedEntry, count, direction, shared};
use crate::check::{MASS, RADIUS, Rule, SPEED, Scope, positive, rule};
use crate::random::in_cone;
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::coupled::{EmitterSpec, SwarmSpec};
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

/// Most particles of an emitter on a graphics device.
pub const SWARM_LIMIT: u64 = Swarm::MOST;

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
    let capacity = match raw.capacity {
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
    let swarm = swarm(raw, scope, capacity, body.method, faults);
    GeneratedEntry {
        scope,
        own,
        count: if swarm.is_some() { 0 } else { capacity },
        swarm_particles: if swarm.is_some() { capacity.min(SWARM_LIMIT) } else { 0 },
        springs: 0,
        triangles: 0,
        numbering: Numbering::Line,
        body,
        make: Box::new(move |name, bodies, random| {
            let (right, up) = direction.any_orthonormal_pair();
            let sine_of_half = libm::sin((0.5 * spread_deg).to_radians());
            let launch = |_| {
                let [x, y, z] = in_cone(random, sine_of_half).to_array();
                speed * (x * right + y * up + z * direction)
            };
            let launches = (0..capacity).map(launch);
            let first = bodies.bodies.len() as u32;
            let (launches, swarm) = match swarm {
                None => (launches.collect(), None),
                Some((method, substeps)) => {
                    let launches = launches
                        .take(SWARM_LIMIT as usize)
                        .map(|launch| launch.to_array().map(|part| part as f32));
                    (Vec::new(), Some(SwarmSpec { method, substeps, launches: launches.collect() }))
                }
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
                swarm,
                inverse_mass: body.inverse_mass.unwrap_or_default(),
                radius,
                color: body.color,
            });
        }),
    }
}

/// Method and own substeps of particles on a graphics device; `None` if the particles are bodies.
fn swarm(
    raw: &raw::Emitter,
    scope: Scope,
    capacity: u64,
    method: Option<Method>,
    faults: &mut Faults,
) -> Option<(Method, Option<u32>)> {
    let on_device =
        faults.word(scope, "on", raw.on.as_ref(), false, &[("cpu", false), ("gpu", true)]);
    let layouts = [("positions", false), ("velocity", true)];
    let keeps_velocity = faults.word(scope, "layout", raw.layout.as_ref(), false, &layouts);
    if !on_device {
        if raw.layout.is_some() {
            let what = "a layout is that of particles on a graphics device";
            faults.refuse(scope, "layout", what, "give on: gpu, or remove it");
        }
        return None;
    }
    let (positions, velocities) = Swarm::METHODS.split_at(1);
    let (fitting, usual, cure) = if keeps_velocity {
        (
            velocities,
            Method::VelocityVerlet,
            "give semi_implicit_euler or velocity_verlet, or remove `layout`",
        )
    } else {
        (positions, Method::PositionVerlet, "give position_verlet, or layout: velocity")
    };
    let method = match method {
        Some(method) if !fitting.contains(&method) => {
            let layout = if keeps_velocity { "a position and a velocity" } else { "two positions" };
            let what = format!(
                "the device keeps {layout} of a particle, which {} cannot use",
                method.name()
            );
            faults.refuse(scope, "method", what, cure);
            usual
        }
        method => method.unwrap_or(usual),
    };
    if capacity > SWARM_LIMIT {
        let key = if raw.capacity.is_some() { "capacity" } else { "rate_per_s" };
        let what = format!("{capacity} particles are too many for a graphics device");
        faults.refuse(scope, key, what, format!("give at most {SWARM_LIMIT} at once"));
    }
    Some((method, raw.substeps))
}

#[cfg(test)]
mod tests;
