//! Resolves springs between two bodies, and checks that the bodies of a group have one method and number of substeps.

use std::collections::HashSet;

use motion::internals::Sets;
use motion::{Elastic, Method};

use crate::check::{Rule, Scope, not_negative, rule};
use crate::generate::{self, Bodies, Section};
use crate::raw;
use crate::resolve::carriers::physical;
use crate::scene::BodySpec;
use crate::scene::coupled::SpringSpec;
use crate::text::faults::Faults;

const LENGTH: Rule = rule(not_negative, "a length", "give a number of meters from 0 up");

/// Resolves the springs whose ends are valid.
pub(crate) fn springs(
    raw: &[raw::Spring],
    bodies: &Bodies,
    faults: &mut Faults,
) -> Vec<SpringSpec> {
    let mut springs = Vec::new();
    for (i, raw) in raw.iter().enumerate() {
        let scope = Scope::item("springs", i);
        let elastic = generate::elastic(raw.stiffness_n_m, raw.damping_n_s_m, scope, faults);
        let rest = faults.optional(scope, "rest_length_m", raw.rest_length_m, LENGTH);
        let color = faults.color(scope, raw.color);
        let Some(ends) = ends(raw, bodies, scope, faults) else { continue };
        let [from, to] = ends.map(|end| bodies.bodies[end as usize].position);
        let rest_length = rest.unwrap_or_else(|| (to - from).length());
        if !rest_length.is_finite() {
            faults.add(
                scope.path(),
                "its ends are too far apart",
                "move them closer, within 1e150 m",
            );
        }
        let elastic = Elastic { rest_length, pull_only: raw.pull_only == Some(true), ..elastic };
        springs.push(SpringSpec { ends, elastic, color });
    }
    springs
}

/// The stable ids of a spring's ends.
fn ends(raw: &raw::Spring, bodies: &Bodies, scope: Scope, faults: &mut Faults) -> Option<[u32; 2]> {
    let Some(between) = &raw.between else {
        faults.missing(scope.path(), "between", "name two bodies, as in `between: (\"a\", \"b\")`");
        return None;
    };
    let mut end = |i: usize| {
        let path = scope.key(&format!("between[{i}]"));
        physical(&between[i], bodies, path, "no spring can hold", faults)
    };
    let (from, to) = (end(0), end(1));
    let ends = [from?, to?];
    if ends[0] == ends[1] {
        let what = format!("a spring from {:?} to itself pulls nothing", between[0]);
        faults.refuse(scope, "between", what, "name two bodies");
        return None;
    }
    if !ends.iter().any(|end| bodies.bodies[*end as usize].is_movable()) {
        let what = format!("{:?} and {:?} are both immovable", between[0], between[1]);
        faults.refuse(scope, "between", what, "name at least one body that can move");
        return None;
    }
    Some(ends)
}

/// Records bodies that act on each other but differ in method or substeps. If `attracting`, all movable bodies act on
/// each other.
pub(crate) fn check_groups(
    bodies: &Bodies,
    springs: &[SpringSpec],
    attracting: bool,
    faults: &mut Faults,
) {
    let Some(names) = &bodies.names else { return };
    if springs.is_empty() && bodies.soft_bodies.is_empty() && !attracting {
        return;
    }
    // Nothing joins the particles of a pool, and mutual gravity does not act on them.
    let of_groups = || bodies.sections.iter().filter(|section| !section.is_pool());
    if of_groups().zip(of_groups().skip(1)).all(|(one, next)| !next.differs(one)) {
        return;
    }
    let movable = |id: u32| bodies.bodies.get(id as usize).is_some_and(BodySpec::is_movable);
    let mut groups = Sets::new(bodies.bodies.len());
    let mut join = |[a, b]: [u32; 2]| {
        if movable(a) && movable(b) {
            groups.join(a as usize, b as usize);
        }
    };
    for soft in &bodies.soft_bodies {
        let first = soft.points.start;
        soft.links.iter().for_each(|link| join(link.ends.map(|end| first + end)));
    }
    springs.iter().for_each(|spring| join(spring.ends));

    // The first body that can move represents its group, or all bodies if they attract each other.
    let mut first: Vec<Option<(u32, &Section)>> = vec![None; bodies.bodies.len()];
    let mut told = HashSet::new();
    for (i, section) in of_groups().enumerate() {
        for id in section.ids.clone().filter(|id| movable(*id)) {
            let group = if attracting { 0 } else { groups.of(id as usize) };
            let Some((one, of)) = first[group] else {
                first[group] = Some((id, section));
                continue;
            };
            if !section.differs(of) || !told.insert((group, i)) {
                continue;
            }
            let name = |id| names.get(id).unwrap_or_default();
            let cure = "give bodies that act on each other the same method and substeps";
            if let (Some(method), Some(other)) = (section.method, of.method)
                && method != other
            {
                let (method, other) = (method.name(), other.name());
                let what = format!(
                    "{:?} is moved by {method}, but {:?} of its group by {other}",
                    name(id),
                    name(one)
                );
                faults.refuse(section.scope, "method", what, cure);
            }
            if let (Some(substeps), Some(other)) = (section.substeps, of.substeps)
                && substeps != other
            {
                let what = format!(
                    "{:?} has {substeps} substeps, but {:?} of its group {other}",
                    name(id),
                    name(one)
                );
                faults.refuse(section.scope, "substeps", what, cure);
            }
        }
    }
}

/// Why `method` cannot solve a scene with or without mutual gravity, if so.
#[must_use]
pub fn unsolvable(method: Method, mutual_gravity: bool) -> Option<&'static str> {
    (method == Method::ImplicitEuler && mutual_gravity)
        .then_some("implicit_euler cannot solve mutual gravity")
}

/// Records methods that cannot solve mutual gravity.
pub(crate) fn check_methods(scenes: Option<Method>, sections: &[Section], faults: &mut Faults) {
    let own = sections.iter().filter(|section| section.own_method && !section.is_pool());
    let asked = own.map(|section| (section.scope, section.method));
    for (scope, method) in std::iter::once((Scope::ROOT, scenes)).chain(asked) {
        if let Some(what) = method.and_then(|method| unsolvable(method, true)) {
            let cure = "choose another method, or remove mutual_gravity";
            faults.refuse(scope, "method", what, cure);
        }
    }
}

impl Section {
    /// Whether its bodies are the pool of an emitter.
    fn is_pool(&self) -> bool {
        self.scope.section == "emitters"
    }

    fn differs(&self, other: &Self) -> bool {
        self.method != other.method || self.substeps != other.substeps
    }
}
