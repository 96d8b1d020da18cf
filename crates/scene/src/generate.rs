//! Every body of a scene in the order of the stable id: the written ones, then those of grids, clouds, emitters and
//! soft bodies.

mod chain;
mod cloth;
mod cloud;
mod emitter;
mod grid;
mod lattice;
mod soft;

use std::ops::Range;

use motion::Method;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::body::{self, Defaults};
use crate::check::Scope;
use crate::memory::{Census, gib, too_little_for};
use crate::raw::RawScene;
use crate::scene::BodySpec;
use crate::scene::coupled::{EmitterSpec, SoftBodySpec};
use crate::scene::names::{Names, Numbering};
use crate::text::faults::Faults;
use crate::text::syntax::Word;
pub(crate) use soft::elastic;

/// Most bodies that a scene may have; four times what the documentation promises to be able to watch.
pub const BODY_LIMIT: u64 = 4_000_000;

/// Every body of a scene and what belongs to it by stable id.
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
    list: &'static str,
    index: usize,
    /// What its bodies are called where it has no name.
    kind: &'static str,
    /// How many of its kind come before it.
    nth: usize,
    name: Option<&'a str>,
    method: Option<&'a Word>,
    substeps: Option<u32>,
    count: u64,
    /// Between its bodies.
    springs: u64,
    numbering: Numbering,
    body: BodySpec,
}

/// Resolves all bodies and draws what the generators draw, from one stream in the order of the stable id.
pub(crate) fn bodies(raw: &RawScene, scenes: Defaults, seed: u64, faults: &mut Faults) -> Bodies {
    let mut names = Names::default();
    let mut labels = Vec::new();
    let mut sections = Vec::new();
    let mut bodies: Vec<BodySpec> = Vec::new();
    for (i, raw) in raw.bodies.iter().enumerate() {
        let body = body::body(raw, i, scenes, faults);
        let scope = Scope::item("bodies", i);
        sections.push(Section::new(scope, i as u32, 1, (raw.method.as_ref(), raw.substeps), &body, scenes));
        bodies.push(body);
        labels.extend(body::label(raw, scope, faults).map(|label| (i as u32, label)));
        // The dot keeps names that nobody wrote apart from those that somebody did.
        let name = raw.name.clone().unwrap_or_else(|| format!("body.{i}"));
        if raw.name.is_some() {
            check_name(&name, scope, faults);
        }
        add_name(|name| names.add(name), name, scope, faults);
    }
    let grids: Vec<_> = raw.grids.iter().enumerate().map(|(i, raw)| grid::grid(raw, i, faults)).collect();
    let clouds: Vec<_> = raw.clouds.iter().enumerate().map(|(i, raw)| cloud::cloud(raw, i, faults)).collect();
    let emitters: Vec<_> =
        raw.emitters.iter().enumerate().map(|(i, raw)| emitter::emitter(raw, i, faults)).collect();
    let softs: Vec<_> =
        raw.soft_bodies.iter().enumerate().map(|(i, raw)| soft::soft(raw, i, faults)).collect();

    let mut entries: Vec<Entry<'_>> = Vec::new();
    for (i, (grid, raw)) in grids.iter().zip(&raw.grids).enumerate() {
        entries.push(Entry {
            list: "grids",
            index: i,
            kind: "grid",
            nth: i,
            name: raw.name.as_deref(),
            method: raw.method.as_ref(),
            substeps: raw.substeps,
            count: u64::from(grid.rows) * u64::from(grid.columns),
            springs: 0,
            numbering: Numbering::Grid { rows: grid.rows },
            body: grid.body,
        });
    }
    for (i, (cloud, raw)) in clouds.iter().zip(&raw.clouds).enumerate() {
        entries.push(Entry {
            list: "clouds",
            index: i,
            kind: "cloud",
            nth: i,
            name: raw.name.as_deref(),
            method: raw.method.as_ref(),
            substeps: raw.substeps,
            count: cloud.count.into(),
            springs: 0,
            numbering: Numbering::Line,
            body: cloud.body,
        });
    }
    for (i, (emitter, raw)) in emitters.iter().zip(&raw.emitters).enumerate() {
        entries.push(Entry {
            list: "emitters",
            index: i,
            kind: "emitter",
            nth: i,
            name: raw.name.as_deref(),
            method: raw.method.as_ref(),
            substeps: raw.substeps,
            count: emitter.capacity,
            springs: 0,
            numbering: Numbering::Line,
            body: emitter.body,
        });
    }
    for (i, (soft, raw)) in softs.iter().zip(&raw.soft_bodies).enumerate() {
        let Some(soft) = soft else { continue };
        let kind = soft.form.kind().name();
        entries.push(Entry {
            list: "soft_bodies",
            index: i,
            kind,
            nth: entries.iter().filter(|entry| entry.kind == kind).count(),
            name: raw.keys.name.as_deref(),
            method: raw.keys.method.as_ref(),
            substeps: raw.keys.substeps,
            count: soft.form.count(),
            springs: soft.form.springs(),
            numbering: soft.form.numbering(),
            body: soft.body,
        });
    }

    let total = entries.iter().fold(bodies.len() as u64, |sum, entry| sum.saturating_add(entry.count));
    let attracts = raw.mutual_gravity.is_some();
    let written = bodies.len() as u64;
    let grouped = if attracts { written } else { 0 };
    let springs = raw.springs.len() as u64;
    let written = Census { bodies: written, moved: grouped, grouped, springs };
    let census = entries.iter().fold(written, |sum, entry| sum.and(entry.census(attracts)));
    let needed = census.bytes();
    let too_little = too_little_for(needed);
    if total > BODY_LIMIT {
        let cure = format!("give at most {BODY_LIMIT} in all");
        faults.add(largest(bodies.len(), &entries), format!("{total} bodies are too many"), cure);
    } else if let Some((least, by_person)) = too_little {
        let needs = entries.iter().max_by_key(|entry| entry.census(attracts).bytes());
        let path = needs.map_or_else(|| "bodies".to_owned(), |entry| entry.scope().path());
        let so_many = match census.springs {
            0 => format!("{total} bodies"),
            springs => format!("{total} bodies and {springs} springs"),
        };
        let have = if by_person { "are allowed" } else { "are free" };
        let what = format!("{so_many} take some {}, and {} {have}", gib(needed), gib(least));
        faults.add(path, what, "give fewer, or more with `--memory GIB`");
    }
    if total > BODY_LIMIT || too_little.is_some() {
        return Bodies {
            bodies,
            names: None,
            labels,
            emitters: Vec::new(),
            soft_bodies: Vec::new(),
            sections,
        };
    }
    let mut prefixes = Vec::new();
    for entry in &entries {
        let scope = entry.scope();
        let (first, count) = (names.len() as u32, entry.count as u32);
        let own = (entry.method, entry.substeps);
        sections.push(Section::new(scope, first, count, own, &entry.body, scenes));
        let prefix = entry.prefix(faults);
        prefixes.push(prefix.clone());
        add_name(|prefix| names.add_run(prefix, count, entry.numbering), prefix, scope, faults);
    }
    // A scene with faults is never spawned, but its generated bodies are asked about: which of them are immovable.
    let mut prefixes = prefixes.into_iter().skip(grids.len() + clouds.len());
    let mut prefix = || prefixes.next().unwrap_or_default();
    let mut random = Pcg64::seed_from_u64(seed);
    bodies.reserve_exact(total as usize - bodies.len());
    grids.iter().for_each(|grid| grid.generate(&mut random, &mut bodies));
    clouds.iter().for_each(|cloud| cloud.generate(&mut random, &mut bodies));
    let emitters =
        emitters.iter().map(|emitter| emitter.generate(prefix(), &mut random, &mut bodies)).collect();
    let mut soft_bodies = Vec::new();
    for (i, soft) in softs.iter().enumerate() {
        if let Some(soft) = soft {
            soft.check_movable(i, faults);
            soft_bodies.push(soft.generate(prefix(), &mut bodies));
        }
    }
    Bodies { bodies, names: Some(names), labels, emitters, soft_bodies, sections }
}

/// The list that makes the most bodies.
fn largest(written: usize, entries: &[Entry<'_>]) -> &'static str {
    let of = |list: &str| {
        let counts = entries.iter().filter(|entry| entry.list == list).map(|entry| entry.count);
        counts.fold(0, u64::saturating_add)
    };
    let lists = ["soft_bodies", "emitters", "clouds", "grids"].map(|list| (of(list), list));
    let most = lists.into_iter().fold((written as u64, "bodies"), |most, list| most.max(list));
    most.1
}

impl Entry<'_> {
    const fn scope(&self) -> Scope {
        Scope::item(self.list, self.index)
    }

    fn census(&self, attracts: bool) -> Census {
        let (is_pool, is_soft) = (self.list == "emitters", self.list == "soft_bodies");
        let those = |are: bool| if are { self.count } else { 0 };
        let is_grouped = is_soft || attracts && !is_pool;
        Census {
            bodies: self.count,
            moved: those(is_grouped || is_pool),
            grouped: those(is_grouped),
            springs: self.springs,
        }
    }

    /// What the names of its bodies begin with: `grid` for the first grid, `grid2` for the second, unless it has a
    /// name of its own.
    fn prefix(&self, faults: &mut Faults) -> String {
        match (self.name, self.nth) {
            (Some(name), _) => {
                check_name(name, self.scope(), faults);
                name.to_owned()
            }
            (None, 0) => self.kind.to_owned(),
            (None, nth) => format!("{}{}", self.kind, nth + 1),
        }
    }
}

impl Section {
    fn new(
        scope: Scope,
        first: u32,
        count: u32,
        (method, substeps): (Option<&Word>, Option<u32>),
        body: &BodySpec,
        scenes: Defaults,
    ) -> Self {
        Self {
            scope,
            ids: first..first + count,
            method: if method.is_some() { body.method } else { scenes.method },
            own_method: method.is_some(),
            substeps: if substeps.is_some() { body.substeps } else { Some(scenes.substeps) },
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
    let shown = name.clone();
    if !add(name) {
        faults.add(
            scope.key("name"),
            format!("the name `{shown}` is taken"),
            "give every body a name of its own",
        );
    }
}

/// A number of bodies, at least 1; 0 where there is none.
fn count(value: Option<u32>, (scope, key): (Scope, &str), faults: &mut Faults) -> u32 {
    match value {
        Some(0) => {
            faults.add(
                scope.key(key),
                format!("{key} is 0, which makes no body"),
                "give a whole number from 1 up",
            );
        }
        None => faults.missing(scope.path(), key, "give a whole number from 1 up"),
        Some(_) => {}
    }
    value.unwrap_or(0)
}

#[cfg(test)]
mod tests;
