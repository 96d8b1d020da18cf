//! Resolves the bodies that springs hold and on which emitters and wells ride.

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
