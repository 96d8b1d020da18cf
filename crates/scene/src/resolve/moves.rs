//! Resolves the motions that immovable bodies follow.

use std::collections::BTreeMap;

use glam::DVec3;
use motion::PrescribedMotion;

use super::laws::{drive, driven};
use crate::check::Scope;
use crate::generate::Bodies;
use crate::raw;
use crate::text::faults::Faults;

/// The motions by stable id. The name of a soft body moves its pinned points.
pub(super) fn moves(
    raw: &[raw::Drive],
    bodies: &Bodies,
    faults: &mut Faults,
) -> BTreeMap<u32, PrescribedMotion> {
    let mut curves = Vec::new();
    let mut curves_of: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, raw) in raw.iter().enumerate() {
        let scope = Scope::item("moves", i);
        let curve = drive(raw, "amplitude_m", scope, faults);
        let Some((name, names)) = driven(raw, scope, faults).zip(bodies.names.as_ref()) else {
            continue;
        };
        let one = names.find(name).map(|id| id..id + 1);
        let Some(ids) = one.or_else(|| names.group(name)) else {
            let (what, cure) = names.stranger(name);
            faults.refuse(scope, "body", what, cure);
            continue;
        };
        let is_immovable = |id: &u32| bodies.bodies[*id as usize].inverse_mass == Some(0.0);
        let mut immovable = ids.filter(is_immovable).peekable();
        if immovable.peek().is_none() {
            let what = format!("{name:?} is not immovable, so forces move it");
            let cure = "give the body immovable: true, the soft body `pinned`, or use `thrusts`";
            faults.refuse(scope, "body", what, cure);
        }
        immovable.for_each(|id| curves_of.entry(id).or_default().push(curves.len()));
        curves.extend(curve.map(|(curve, from, until)| (curve, from.max(0.0), until)));
    }
    if curves.len() < raw.len() {
        return BTreeMap::new();
    }
    // Bodies with the same curves share them.
    let mut known: BTreeMap<Vec<usize>, PrescribedMotion> = BTreeMap::new();
    let motion = |(id, own): (u32, Vec<usize>)| {
        let of = |own: &[usize]| own.iter().map(|i| curves[*i].clone()).collect::<Vec<_>>();
        let new = || PrescribedMotion::new(DVec3::ZERO, of(&own));
        let motion = known.entry(own.clone()).or_insert_with(new);
        (id, motion.starting_at(bodies.bodies[id as usize].position))
    };
    curves_of.into_iter().map(motion).collect()
}
