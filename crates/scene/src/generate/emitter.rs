//! Emitters: the pool of each, and the velocities with which its particles are born.

use glam::DVec3;
use rand_pcg::Pcg64;

use super::count;
use crate::check::{Scope, not_negative, positive, shown_vector};
use crate::random::in_cone;
use crate::raw::coupled::RawEmitter;
use crate::scene::BodySpec;
use crate::scene::coupled::EmitterSpec;
use crate::text::faults::Faults;

/// A checked emitter.
pub(super) struct Emitter {
    /// Bodies of the pool.
    pub capacity: u64,
    rate: f64,
    life: f64,
    /// A unit vector.
    direction: DVec3,
    /// Half angle of the cone, degrees, 0 to 180.
    spread_deg: f64,
    speed: f64,
    pub body: BodySpec,
}

/// Checks emitter `index` of the list.
pub(super) fn emitter(raw: &RawEmitter, index: usize, faults: &mut Faults) -> Emitter {
    let scope = Scope::item("emitters", index);
    for (key, given, example) in [
        ("rate_per_s", raw.rate_per_s.is_some(), "add one such as `rate_per_s: 100.0`"),
        ("speed_m_s", raw.speed_m_s.is_some(), "add one such as `speed_m_s: 10.0`"),
        ("life_s", raw.life_s.is_some(), "add one such as `life_s: 3.0`"),
    ] {
        if !given {
            faults.missing(scope.path(), key, example);
        }
    }
    let rate = ("a rate", "give a positive number of particles a second");
    let rate = faults.number((scope, "rate_per_s"), raw.rate_per_s, 1.0, positive, rate);
    let life = ("a time to live", "give a positive number of seconds");
    let life = faults.number((scope, "life_s"), raw.life_s, 1.0, positive, life);
    let speed = ("a speed", "give meters per second from 0 up");
    let spread = ("an angle of spread", "give degrees from 0 to 180, from the middle to the edge");
    let mass = "give a positive number of kilograms";
    Emitter {
        capacity: match raw.capacity {
            // As many as live at once.
            None => (rate * life).ceil() as u64,
            Some(_) => u64::from(count(raw.capacity, (scope, "capacity"), faults)),
        },
        rate,
        life,
        direction: direction(raw, scope, faults),
        spread_deg: faults.number(
            (scope, "spread_deg"),
            raw.spread_deg,
            0.0,
            |v| (0.0..=180.0).contains(&v),
            spread,
        ),
        speed: faults.number((scope, "speed_m_s"), raw.speed_m_s, 0.0, not_negative, speed),
        body: BodySpec {
            position: faults.vector((scope, "position_m"), raw.position_m, DVec3::ZERO),
            inverse_mass: Some(faults.inverse_mass(scope, raw.mass_kg, 1.0, mass)),
            color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
            method: faults.method(scope, raw.method.as_ref()),
            substeps: faults.substeps(scope, raw.substeps),
            ..BodySpec::DEFAULT
        },
    }
}

/// Where it points, as a unit vector; up if it does not say.
fn direction(raw: &RawEmitter, scope: Scope, faults: &mut Faults) -> DVec3 {
    let given = faults.vector((scope, "direction"), raw.direction, DVec3::Y);
    given.try_normalize().unwrap_or_else(|| {
        let what = format!("{} is not a direction", shown_vector(given));
        faults.add(
            scope.key("direction"),
            what,
            "give a vector that is not zero; its length does not matter",
        );
        DVec3::Y
    })
}

impl Emitter {
    /// Adds the pool to `bodies`, all of it at rest at the emitter.
    pub fn generate(&self, name: String, random: &mut Pcg64, bodies: &mut Vec<BodySpec>) -> EmitterSpec {
        let (right, up) = self.direction.any_orthonormal_pair();
        let sine_of_half = libm::sin((0.5 * self.spread_deg).to_radians());
        let launch = |_| {
            let [x, y, z] = in_cone(random, sine_of_half).to_array();
            self.speed * (x * right + y * up + z * self.direction)
        };
        let launches: Vec<DVec3> = (0..self.capacity).map(launch).collect();
        let first = bodies.len() as u32;
        bodies.extend(launches.iter().map(|_| self.body));
        EmitterSpec {
            name,
            rate: self.rate,
            life: self.life,
            position: self.body.position,
            pool: first..bodies.len() as u32,
            launches,
            inverse_mass: self.body.inverse_mass.unwrap_or_default(),
            color: self.body.color,
        }
    }
}

#[cfg(test)]
mod tests;
