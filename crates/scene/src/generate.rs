//! Every body of a scene in the order of the stable id: the written ones, then those of grids, clouds, emitters and
//! soft bodies.

mod chain;
mod cloth;
mod cloud;
mod emitter;
mod form;
mod grid;
mod lattice;
mod soft;

use std::collections::HashMap;
use std::ops::Range;

use motion::Method;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::body::{self, Defaults};
use crate::check::{Key, Scope};
use crate::memory::{Census, gib, too_little_for};
use crate::raw::RawScene;
use crate::scene::BodySpec;
use crate::scene::coupled::{EmitterSpec, SoftBodySpec};
use crate::scene::names::{Names, Numbering};
use crate::text::faults::Faults;
pub(crate) use soft::elastic;

/// Most bodies that a scene may have; four times what the documentation promises to be able to watch.
pub const BODY_LIMIT: u64 = 4_000_000;

/// Every body of a scene and what belongs to it by stable id.
#[derive(Default)]
pub(crate) struct Bodies {
    /// The written ones at least; all of them where there are names.
    pub bodies: Vec<BodySpec>,
    /// `None` where there are too many bodies to be named.
    pub names: Option<Names>,
    pub labels: Vec<(u32, String)>,
    pub emitters: Vec<EmitterSpec>,
    pub soft_bodies: Vec<SoftBodySpec>,
    /// In the order of their ids.
    pub sections: Vec<Section>,
}

/// The bodies of one entry of the file, which have one method and one number of substeps.
pub(crate) struct Section {
    pub scope: Scope,
    pub ids: Range<u32>,
    /// What moves them; `None` where what is written is no method.
    pub method: Option<Method>,
    /// Whether the entry itself names the method.
    pub own_method: bool,
    /// `None` where what is written is no number of substeps.
    pub substeps: Option<u32>,
}

/// An entry that makes bodies.
struct Entry<'a> {
    scope: Scope,
    /// What its bodies are called where it has no name.
    kind: &'static str,
    name: Option<&'a str>,
    /// Whether it names a method itself, and a number of substeps.
    own_method: bool,
    own_substeps: bool,
    count: u64,
    /// Between its bodies.
    springs: u64,
    numbering: Numbering,
    /// What its bodies have in common.
    body: BodySpec,
    /// Makes its bodies, by what their names begin with.
    make: Box<dyn Fn(String, &mut Bodies, &mut Pcg64)>,
}

/// Resolves all bodies and draws what the generators draw, from one stream in the order of the stable id.
pub(crate) fn bodies(raw: &RawScene, scenes: Defaults, seed: u64, faults: &mut Faults) -> Bodies {
    let mut names = Names::default();
    let mut made = Bodies::default();
    for (i, raw) in raw.bodies.iter().enumerate() {
        let body = body::body(raw, i, scenes, faults);
        let (scope, id) = (Scope::item("bodies", i), i as u32);
        let own = (raw.method.is_some(), raw.substeps.is_some());
        made.sections.push(Section::new(scope, id..id + 1, own, &body, scenes));
        made.bodies.push(body);
        made.labels.extend(body::label(raw, scope, faults).map(|label| (id, label)));
        // The dot keeps names that nobody wrote apart from those that somebody did.
        let name = raw.name.clone().unwrap_or_else(|| format!("body.{i}"));
        if raw.name.is_some() {
            check_name(&name, scope, faults);
        }
        add_name(|name| names.add(name), name, scope, faults);
    }
    let mut entries: Vec<Entry<'_>> = Vec::new();
    entries.extend(raw.grids.iter().enumerate().map(|(i, raw)| grid::grid(raw, i, faults)));
    entries.extend(raw.clouds.iter().enumerate().map(|(i, raw)| cloud::cloud(raw, i, faults)));
    entries.extend(raw.emitters.iter().enumerate().map(|(i, raw)| emitter::emitter(raw, i, faults)));
    entries.extend(raw.soft_bodies.iter().enumerate().filter_map(|(i, raw)| soft::soft(raw, i, faults)));
    let Some(total) = check_size(raw, &entries, faults) else { return made };

    let mut random = Pcg64::seed_from_u64(seed);
    let mut of_kind: HashMap<&str, usize> = HashMap::new();
    made.bodies.reserve_exact(total as usize - made.bodies.len());
    for entry in entries {
        let Entry { scope, count, numbering, .. } = entry;
        let (first, count) = (names.len() as u32, count as u32);
        let own = (entry.own_method, entry.own_substeps);
        made.sections.push(Section::new(scope, first..first + count, own, &entry.body, scenes));
        let number = of_kind.entry(entry.kind).or_default();
        *number += 1;
        let prefix = match entry.name {
            Some(name) => {
                check_name(name, scope, faults);
                name.to_owned()
            }
            None if *number == 1 => entry.kind.to_owned(),
            None => format!("{}{number}", entry.kind),
        };
        add_name(|prefix| names.add_run(prefix, count, numbering), prefix.clone(), scope, faults);
        // Made even where there are faults: it is asked which bodies are immovable.
        (entry.make)(prefix, &mut made, &mut random);
        let these = &made.bodies[first as usize..];
        if !these.is_empty() && these.iter().all(|body| body.inverse_mass == Some(0.0)) {
            let cure = "leave at least one point free";
            faults.add(scope.key("pinned"), "every point is pinned, so none can move", cure);
        }
    }
    made.names = Some(names);
    made
}

/// How many bodies there are in all; `None`, with a fault, where they are too many.
fn check_size(raw: &RawScene, entries: &[Entry<'_>], faults: &mut Faults) -> Option<u64> {
    let written = raw.bodies.len() as u64;
    let total = entries.iter().fold(written, |sum, entry| sum.saturating_add(entry.count));
    if total > BODY_LIMIT {
        let cure = format!("give at most {BODY_LIMIT} in all");
        faults.add(largest(written, entries), format!("{total} bodies are too many"), cure);
        return None;
    }
    let attracts = raw.mutual_gravity.is_some();
    let grouped = if attracts { written } else { 0 };
    let written = Census { bodies: written, moved: grouped, grouped, springs: raw.springs.len() as u64 };
    let census = entries.iter().fold(written, |sum, entry| sum.and(entry.census(attracts)));
    let needed = census.bytes();
    let Some((least, by_person)) = too_little_for(needed) else { return Some(total) };
    let needs = entries.iter().max_by_key(|entry| entry.census(attracts).bytes());
    let path = needs.map_or_else(|| "bodies".to_owned(), |entry| entry.scope.path());
    let so_many = match census.springs {
        0 => format!("{total} bodies"),
        springs => format!("{total} bodies and {springs} springs"),
    };
    let have = if by_person { "are allowed" } else { "are free" };
    let what = format!("{so_many} take some {}, and {} {have}", gib(needed), gib(least));
    faults.add(path, what, "give fewer, or more with `--memory GIB`");
    None
}

/// The list that makes the most bodies.
fn largest(written: u64, entries: &[Entry<'_>]) -> &'static str {
    let of = |list: &str| {
        let counts = entries.iter().filter(|entry| entry.scope.section == list).map(|entry| entry.count);
        counts.fold(0, u64::saturating_add)
    };
    let lists = ["soft_bodies", "emitters", "clouds", "grids"].map(|list| (of(list), list));
    let most = lists.into_iter().fold((written, "bodies"), |most, list| most.max(list));
    most.1
}

impl Entry<'_> {
    fn census(&self, attracts: bool) -> Census {
        let (is_pool, is_soft) = (self.scope.section == "emitters", self.scope.section == "soft_bodies");
        let those = |are: bool| if are { self.count } else { 0 };
        let is_grouped = is_soft || attracts && !is_pool;
        Census {
            bodies: self.count,
            moved: those(is_grouped || is_pool),
            grouped: those(is_grouped),
            springs: self.springs,
        }
    }
}

impl Section {
    fn new(
        scope: Scope,
        ids: Range<u32>,
        (own_method, own_substeps): (bool, bool),
        body: &BodySpec,
        scenes: Defaults,
    ) -> Self {
        Self {
            scope,
            ids,
            method: if own_method { body.method } else { scenes.method },
            own_method,
            substeps: if own_substeps { body.substeps } else { Some(scenes.substeps) },
        }
    }
}

/// Names stand in scripts, tables and generated names, so they are plain words.
fn check_name(name: &str, scope: Scope, faults: &mut Faults) {
    if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-')) {
        let cure = "use letters, digits, `_` and `-`";
        faults.add(scope.key("name"), format!("{name:?} cannot be a name"), cure);
    }
}

fn add_name(add: impl FnOnce(String) -> bool, name: String, scope: Scope, faults: &mut Faults) {
    let what = format!("the name `{name}` is taken");
    if !add(name) {
        faults.add(scope.key("name"), what, "give every body a name of its own");
    }
}

/// A number of bodies, at least 1; 0 where there is none.
fn count(value: Option<u32>, (scope, key): Key<'_>, faults: &mut Faults) -> u32 {
    const CURE: &str = "give a whole number from 1 up";
    faults.require(value.is_some(), (scope, key), CURE);
    if value == Some(0) {
        faults.add(scope.key(key), format!("{key} is 0, which makes no body"), CURE);
    }
    value.unwrap_or(0)
}

#[cfg(test)]
mod tests;
