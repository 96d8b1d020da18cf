//! Resolves the bodies that springs hold and on which emitters and wells ride, and checks emitters on a graphics
//! device.

use motion::WorldLaws;

use crate::check::Scope;
use crate::generate::Bodies;
use crate::raw;
use crate::text::faults::Faults;

/// The stable id of the body `name`, if it has physics and is no particle. `path` is that of the name in
/// faults, and `cannot` says there what cannot be done to other bodies.
pub(crate) fn physical(
    name: &str,
    bodies: &Bodies,
    path: String,
    cannot: &str,
    faults: &mut Faults,
) -> Option<u32> {
    let names = bodies.names.as_ref()?;
    let Some(id) = names.find(name) else {
        let (what, cure) = names.stranger(name);
        faults.add(path, what, cure);
        return None;
    };
    if bodies.bodies[id as usize].inverse_mass.is_none() {
        faults.add(
            path,
            format!("{name:?} is scenery, which {cannot}"),
            "name a body with physics",
        );
        return None;
    }
    if bodies.emitters.iter().any(|emitter| emitter.pool.contains(&id)) {
        let what = format!("{name:?} is an emitter's, born again and again, so {cannot} it");
        faults.add(path, what, "name another body");
        return None;
    }
    Some(id)
}

/// Puts emitters on the bodies on which they ride.
pub(crate) fn carry_emitters(raw: &[raw::Emitter], bodies: &mut Bodies, faults: &mut Faults) {
    for (i, raw) in raw.iter().enumerate() {
        let Some(name) = &raw.rides_on else { continue };
        let path = Scope::item("emitters", i).key("rides_on");
        let carrier = physical(name, bodies, path, "no emitter can ride on", faults);
        let Bodies { bodies, emitters, .. } = &mut *bodies;
        if let (Some(emitter), Some(id)) = (emitters.get_mut(i), carrier) {
            emitter.rides_on = carrier;
            // The particles of the pool wait there.
            let at = bodies[id as usize].position;
            let pool = emitter.pool.start as usize..emitter.pool.end as usize;
            bodies[pool].iter_mut().for_each(|body| body.position += at);
        }
    }
}

/// Most ticks for which a particle on a graphics device lives: going back simulates as many ticks again.
const SWARM_TICKS: f64 = 36_000.0;

/// Most times per second that a particle on a graphics device is replaced: more would exhaust its numbers within a run.
const SWARM_REUSE: f64 = 1_000.0;

/// Most wells that attract particles on a graphics device: a uniform buffer of any device has room for these.
const SWARM_WELLS: usize = 64;

/// Checks what acts on the particles of emitters on a graphics device.
pub(crate) fn check_swarms(
    raw: &raw::Scene,
    step_hz: f64,
    laws: &WorldLaws,
    bodies: &Bodies,
    faults: &mut Faults,
) {
    let swarms = (0..).zip(&bodies.emitters).filter(|(_, emitter)| emitter.swarm.is_some());
    for (i, emitter) in swarms {
        let scope = Scope::item("emitters", i);
        if emitter.life * step_hz > SWARM_TICKS {
            let most = (SWARM_TICKS / step_hz).floor();
            let what =
                format!("on a graphics device a particle lives for at most {SWARM_TICKS} ticks");
            faults.refuse(scope, "life_s", what, format!("give at most {most} s, or on: cpu"));
        }
        let slots = emitter.swarm.as_ref().map_or(0, |swarm| swarm.launches.len());
        if emitter.rate > SWARM_REUSE * slots as f64 {
            let what = format!(
                "each of {slots} particles is replaced more than {SWARM_REUSE} times per second"
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
        if wells > SWARM_WELLS {
            let what = format!("{wells} wells are too many for particles on a graphics device");
            faults.refuse(
                scope,
                "on",
                what,
                format!("give at most {SWARM_WELLS} wells, or on: cpu"),
            );
        }
    }
}
