//! Clouds: particles at random in a box.

use glam::DVec3;
use rand_pcg::Pcg64;

use super::count;
use crate::check::is_extent;
use crate::check::{Scope, not_negative, shown_vector};
use crate::random::{direction, symmetric};
use crate::raw::RawCloud;
use crate::scene::BodySpec;
use crate::text::faults::Faults;

/// A checked cloud.
pub(super) struct Cloud {
    pub count: u32,
    center: DVec3,
    half_extents: DVec3,
    speed: f64,
    pub body: BodySpec,
}

/// Checks cloud `index` of the list.
pub(super) fn cloud(raw: &RawCloud, index: usize, faults: &mut Faults) -> Cloud {
    let scope = Scope::item("clouds", index);
    let half_extents = raw.half_extents_m.map_or(DVec3::ZERO, DVec3::from_array);
    let center = faults.vector((scope, "center_m"), raw.center_m, DVec3::ZERO);
    let in_range =
        is_extent(half_extents) && (center + half_extents).is_finite() && (center - half_extents).is_finite();
    if !in_range {
        let what = format!("{} is not half a size", shown_vector(half_extents));
        faults.add(scope.key("half_extents_m"), what, "give three numbers of meters from 0 up");
    }
    let words = ("a speed", "give meters per second from 0 up");
    Cloud {
        count: count(raw.count, (scope, "count"), faults),
        center,
        half_extents,
        speed: faults.number((scope, "speed_m_s"), raw.speed_m_s, 0.0, not_negative, words),
        body: BodySpec {
            inverse_mass: Some(faults.inverse_mass(
                scope,
                raw.mass_kg,
                1.0,
                "give a positive number of kilograms",
            )),
            color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
            method: faults.method(scope, raw.method.as_ref()),
            substeps: faults.substeps(scope, raw.substeps),
            ..BodySpec::DEFAULT
        },
    }
}

impl Cloud {
    pub fn generate(&self, random: &mut Pcg64, bodies: &mut Vec<BodySpec>) {
        for _ in 0..self.count {
            let place = DVec3::new(symmetric(random), symmetric(random), symmetric(random));
            let position = self.center + self.half_extents * place;
            let velocity = if self.speed > 0.0 { self.speed * direction(random) } else { DVec3::ZERO };
            bodies.push(BodySpec { position, velocity, ..self.body });
        }
    }
}
