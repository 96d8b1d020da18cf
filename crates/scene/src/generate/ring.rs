//! Rings: particles at equal distances on a circle, each moving along it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::entry::{GeneratedEntry, count, direction, shared};
use crate::check::{MASS, RADIUS, SPEED, Scope, shown};
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// Resolves ring `index` of the list.
pub(super) fn ring(raw: &raw::Ring, index: usize, faults: &mut Faults) -> GeneratedEntry {
    let scope = Scope::item("rings", index);
    let count = count(raw.count, scope, "count", faults);
    let center = faults.vector(scope, "center_m", raw.center_m, DVec3::ZERO);
    faults.require(raw.radius_m.is_some(), scope, "radius_m", "add one such as `radius_m: 10.0`");
    let radius = faults.number(scope, "radius_m", raw.radius_m, 1.0, RADIUS);
    if !((center + radius).is_finite() && (center - radius).is_finite()) {
        let what = format!("a ring of {} m reaches beyond all numbers", shown(radius));
        faults.refuse(scope, "radius_m", what, "give a smaller radius");
    }
    let axis = direction(scope, "axis", raw.axis, faults);
    let speed = faults.number(scope, "speed_m_s", raw.speed_m_s, 0.0, SPEED);
    // The mass is that of one body, 1 kg by default.
    let (body, own) = shared(&raw.shared(), scope, 1.0, 1.0, MASS, faults);
    GeneratedEntry::new(scope, own, count.into(), Numbering::Line, body, move |_, bodies, _| {
        // `right`, `up` and `axis` are right-handed: counterclockwise, seen from where the axis points.
        let (right, up) = axis.any_orthonormal_pair();
        bodies.bodies.extend((0..count).map(|number| {
            let (sin, cos) = libm::sincos(TAU * f64::from(number) / f64::from(count));
            let position = center + radius * (cos * right + sin * up);
            BodySpec { position, velocity: speed * (cos * up - sin * right), ..body }
        }));
    })
}
