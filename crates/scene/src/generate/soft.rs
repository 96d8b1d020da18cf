//! Soft bodies: what chains, cloths and lattices have in common, and the making of their points and springs.

use glam::DVec3;
use motion::Elastic;
use pick::Blades;

use super::entry::{Bodies, GeneratedEntry, shared};
use super::form::Form;
use super::{chain, cloth, lattice};
use crate::check::{DAMPING_RATE, Rule, STIFFNESS, Scope, not_negative, rule};
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::coupled::SoftBodySpec;
use crate::text::faults::Faults;
use crate::text::nearest::one_of;

/// Resolves soft body `index` of the list; `None` if its kind is unknown.
pub(super) fn soft(
    raw: &raw::SoftBody,
    index: usize,
    faults: &mut Faults,
) -> Option<GeneratedEntry> {
    let scope = Scope::item("soft_bodies", index);
    for key in raw.keys_of_other_kinds() {
        faults.refuse(scope, key, format!("a {} has no `{key}`", raw.word), "remove it");
    }
    let keys = &raw.keys;
    let elastic = elastic(link_stiffness(raw, scope, faults), keys.damping_n_s_m, scope, faults);
    let elastic = Elastic { pull_only: keys.pull_only == Some(true), ..elastic };
    let form = match raw.word.as_str() {
        "chain" => Some(chain::form(keys, scope, faults)),
        "cloth" => Some(cloth::form(keys, scope, faults)),
        "lattice" => Some(lattice::form(keys, scope, faults)),
        word => {
            let cure = format!("give {}", one_of(&raw::KINDS.map(|(kind, _)| kind)));
            faults.add(scope.path(), format!("unknown soft body `{word}`"), cure);
            None
        }
    };
    let points = form.as_ref().map_or(1, |form| form.shape.count().max(1)) as f64;
    let mass = "give a positive number of kilograms for all points together";
    let (body, own) = shared(&keys.shared(), scope, 1.0, points, mass, faults);
    let body = BodySpec {
        damping_rate: faults.optional(scope, "damping_per_s", keys.damping_per_s, DAMPING_RATE),
        gravity_off: keys.gravity_off == Some(true),
        ..body
    };
    let velocity = faults.vector(scope, "velocity_m_s", keys.velocity_m_s, DVec3::ZERO);
    let form = form?;
    let (count, springs, numbering, is_sheet) =
        (form.shape.count(), form.shape.springs(), form.numbering, form.shape.is_sheet());
    let entry = GeneratedEntry::new(scope, own, count, numbering, body, move |name, bodies, _| {
        make(name, &form, elastic, body, velocity, bodies);
    });
    // At most two triangles per cell.
    Some(GeneratedEntry { springs, triangles: if is_sheet { 2 * count } else { 0 }, ..entry })
}

/// Stiffness of a link, N/m. Springs in series share the elongation: each of n is n times as stiff as all of them
/// together.
fn link_stiffness(raw: &raw::SoftBody, scope: Scope, faults: &mut Faults) -> Option<f64> {
    let keys = &raw.keys;
    let Some(whole) = keys.stiffness_of_whole_n_m else { return keys.stiffness_n_m };
    if keys.stiffness_n_m.is_some() && raw.word == "chain" {
        let what = "the stiffness of the chain is given twice";
        faults.refuse(scope, "stiffness_of_whole_n_m", what, "keep it or `stiffness_n_m`");
    }
    let whole = faults.number(scope, "stiffness_of_whole_n_m", Some(whole), 0.0, STIFFNESS);
    Some(whole * f64::from(keys.points.unwrap_or(2).saturating_sub(1)))
}

/// Stiffness, N/m, and damping, N s/m, of springs, without a length yet.
pub(crate) fn elastic(
    stiffness: Option<f64>,
    damping: Option<f64>,
    scope: Scope,
    faults: &mut Faults,
) -> Elastic {
    const DAMPING: Rule = rule(not_negative, "a damping", "give a number of N s/m from 0 up");
    let cure = "add one such as `stiffness_n_m: 100.0`";
    faults.require(stiffness.is_some(), scope, "stiffness_n_m", cure);
    Elastic::new(faults.number(scope, "stiffness_n_m", stiffness, 0.0, STIFFNESS), 0.0)
        .damped(faults.number(scope, "damping_n_s_m", damping, 0.0, DAMPING))
}

/// Adds the points, which are `body` with `velocity` unless they are pinned, and the links between them.
fn make(
    name: String,
    held: &Form,
    elastic: Elastic,
    body: BodySpec,
    velocity: DVec3,
    Bodies { bodies, soft_bodies, .. }: &mut Bodies,
) {
    let form = &held.shape;
    let first = bodies.len();
    bodies.extend((0..form.count() as u32).map(|point| {
        let position = form.position(point);
        if held.is_pinned(point) {
            BodySpec { position, inverse_mass: Some(0.0), ..body }
        } else {
            BodySpec { position, velocity, ..body }
        }
    }));
    let points = &bodies[first..];
    soft_bodies.push(SoftBodySpec {
        name,
        sheet: form.is_sheet(),
        links: form.links(elastic, |point| points[point as usize].position).into(),
        triangles: form.triangles(),
        points: first as u32..bodies.len() as u32,
        blades: held.width.map(|width| Blades { points: form.points().y, width }),
        color: body.color,
    });
}

#[cfg(test)]
mod tests;
