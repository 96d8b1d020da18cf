//! Clouds: particles at random in a box or a ball.

use glam::DVec3;

use super::entry::{GeneratedEntry, count, shared};
use crate::check::{MASS, RADIUS, SPEED, Scope, not_negative, shown_vector};
use crate::random::{direction, in_ball, symmetric};
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// Resolves cloud `index` of the list.
pub(super) fn cloud(raw: &raw::Cloud, index: usize, faults: &mut Faults) -> GeneratedEntry {
    let scope = Scope::item("clouds", index);
    if raw.half_extents_m.is_some() && raw.radius_m.is_some() {
        let what = "a cloud fills either a box or a ball";
        faults.refuse(scope, "radius_m", what, "leave out `radius_m` or `half_extents_m`");
    }
    let radius = faults.optional(scope, "radius_m", raw.radius_m, RADIUS);
    let half_extents =
        raw.half_extents_m.map_or(DVec3::splat(radius.unwrap_or(0.0)), DVec3::from_array);
    let center = faults.vector(scope, "center_m", raw.center_m, DVec3::ZERO);
    let is_extent = half_extents.to_array().into_iter().all(not_negative);
    if !(is_extent && (center + half_extents).is_finite() && (center - half_extents).is_finite()) {
        let what = format!("{} is not half a size", shown_vector(half_extents));
        faults.refuse(scope, "half_extents_m", what, "give three numbers of meters from 0 up");
    }
    let count = count(raw.count, scope, "count", faults);
    let speed = faults.number(scope, "speed_m_s", raw.speed_m_s, 0.0, SPEED);
    let (body, own) = shared(&raw.shared(), scope, 1.0, 1.0, MASS, faults);
    GeneratedEntry::new(
        scope,
        own,
        count.into(),
        Numbering::Line,
        body,
        move |_, bodies, random| {
            for _ in 0..count {
                let place = match radius {
                    Some(_) => in_ball(random),
                    None => DVec3::new(symmetric(random), symmetric(random), symmetric(random)),
                };
                let position = center + half_extents * place;
                let velocity = if speed > 0.0 { speed * direction(random) } else { DVec3::ZERO };
                bodies.bodies.push(BodySpec { position, velocity, ..body });
            }
        },
    )
}
