//! Emitters whose particles are on a graphics device: their keys, and the forces and laws on them.

use glam::DVec3;
use motion::{Method, WorldLaws};
use swarm::{Swarm, SwarmLaws};

use super::entry::Bodies;
use crate::check::Scope;
use crate::raw;
use crate::text::faults::Faults;

/// The particles of an emitter that are on a graphics device, without their velocities at birth; `None` if they are bodies. Limits
/// `capacity`, their number.
pub(super) fn on_device(
    raw: &raw::Emitter,
    scope: Scope,
    capacity: &mut u64,
    method: Option<Method>,
    faults: &mut Faults,
) -> Option<Swarm> {
    let is_on_device =
        faults.word(scope, "on", raw.on.as_ref(), false, &[("cpu", false), ("gpu", true)]);
    let layouts = [("positions", false), ("velocity", true)];
    let keeps_velocity = faults.word(scope, "layout", raw.layout.as_ref(), false, &layouts);
    if !is_on_device {
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
    if *capacity > Swarm::MOST {
        let key = if raw.capacity.is_some() { "capacity" } else { "rate_per_s" };
        let what = format!("{capacity} particles are too many for a graphics device");
        faults.refuse(scope, key, what, format!("give at most {} at once", Swarm::MOST));
        *capacity = Swarm::MOST;
    }
    Some(Swarm { method, substeps: raw.substeps, anchor: DVec3::ZERO, launches: [].into() })
}

/// Most ticks for which a particle on a graphics device lives: going back simulates as many ticks again.
const MOST_TICKS: f64 = 36_000.0;

/// Most times per second that a particle on a graphics device is replaced: more would exhaust its numbers within a run.
const MOST_REUSE: f64 = 1_000.0;

/// Checks the forces and laws on the particles of emitters on a graphics device.
pub(crate) fn check(
    raw: &raw::Scene,
    step_hz: f64,
    laws: &WorldLaws,
    bodies: &Bodies,
    faults: &mut Faults,
) {
    for (i, emitter) in (0..).zip(&bodies.emitters) {
        let Some(swarm) = &emitter.on_device else { continue };
        let scope = Scope::item("emitters", i);
        if emitter.life * step_hz > MOST_TICKS {
            let most = (MOST_TICKS / step_hz).floor();
            let what =
                format!("on a graphics device a particle lives for at most {MOST_TICKS} ticks");
            faults.refuse(scope, "life_s", what, format!("give at most {most} s, or on: cpu"));
        }
        let slots = swarm.slots();
        if emitter.rate > MOST_REUSE * slots as f64 {
            let what = format!(
                "each of {slots} particles is replaced more than {MOST_REUSE} times per second"
            );
            faults.refuse(scope, "rate_per_s", what, "give more `capacity`, or on: cpu");
        }
        if raw.range.is_some() {
            let what = "particles on a graphics device know nothing of range";
            faults.refuse(scope, "on", what, "give on: cpu, or remove `range`");
        }
        if raw.mutual_gravity.is_some() {
            let what = "particles on a graphics device know nothing of mutual_gravity";
            faults.refuse(scope, "on", what, "give on: cpu, or wells in place of mutual_gravity");
        }
        if let Some(law) = laws.without_device_form() {
            let what = format!("no graphics device evaluates the law `{law}`");
            faults.refuse(scope, "on", what, format!("give on: cpu, or remove `{law}`"));
        }
        let wells = raw.wells.iter().filter(|well| well.bodies.is_none()).count();
        if wells > SwarmLaws::WELLS {
            let what = format!("{wells} wells are too many for particles on a graphics device");
            faults.refuse(
                scope,
                "on",
                what,
                format!("give at most {} wells, or on: cpu", SwarmLaws::WELLS),
            );
        }
    }
}
