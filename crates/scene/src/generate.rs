//! Every body of a scene in the order of the stable id: the written ones, then those of grids, clouds, rings, emitters
//! and soft bodies.

mod body;
mod chain;
mod cloth;
mod cloud;
mod emitter;
mod entry;
mod form;
mod grid;
mod lattice;
pub(crate) mod on_device;
mod ring;
mod soft;

use std::collections::HashMap;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::check::Scope;
use crate::memory::{Census, byte_words, shortage, there_are};
use crate::raw;
use crate::scene::Reading;
use crate::scene::names::Names;
use crate::text::faults::Faults;
pub(crate) use body::Defaults;
pub(crate) use entry::{Bodies, Section};
use entry::{GeneratedEntry, Own};
pub(crate) use soft::elastic;

/// Most bodies of a scene: four times the number that the documentation promises to show.
pub const BODY_LIMIT: u64 = 4_000_000;

/// The lists that make bodies, in the order of the stable id. Each has the function that resolves an entry, the
/// default name of an entry's bodies, the name of an entry, and whether its bodies may become entries of `bodies`.
macro_rules! generators {
    ($($list:ident: $resolve:path, $raw:ident => ($kind:expr, $name:expr, $apart:literal);)*) => {
        fn resolve_entries(raw: &raw::Scene, faults: &mut Faults) -> Vec<GeneratedEntry> {
            let mut entries = Vec::<GeneratedEntry>::new();
            $(for (i, raw) in raw.$list.iter().enumerate() {
                entries.extend(Option::from($resolve(raw, i, faults)));
            })*
            entries
        }

        /// The default name of an entry's bodies, and the name of the entry; `None` if there is no such entry.
        pub(crate) fn kind_and_name<'a>(
            raw: &'a raw::Scene,
            list: &str,
            index: usize,
        ) -> Option<(&'a str, Option<&'a str>)> {
            Some(match list {
                "bodies" => ("body", raw.bodies.get(index)?.name.as_deref()),
                $(stringify!($list) => {
                    let $raw = raw.$list.get(index)?;
                    ($kind, $name.as_deref())
                })*
                _ => return None,
            })
        }

        /// Whether the bodies of an entry of `list` may become entries of `bodies`.
        pub(crate) fn may_be_taken_apart(list: &str) -> bool {
            match list {
                $(stringify!($list) => $apart,)*
                _ => false,
            }
        }

        const LISTS: &[&str] = &[$(stringify!($list)),*];
    };
}

generators! {
    grids: grid::grid, raw => ("grid", raw.name, true);
    clouds: cloud::cloud, raw => ("cloud", raw.name, true);
    rings: ring::ring, raw => ("ring", raw.name, true);
    emitters: emitter::emitter, raw => ("emitter", raw.name, false);
    soft_bodies: soft::soft, raw => (&raw.word, raw.keys.name, false);
}

/// Resolves all bodies. Generators draw their random numbers from one stream, in the order of the stable id.
pub(crate) fn bodies(
    raw: &raw::Scene,
    reading: Reading,
    scenes: Defaults,
    seed: u64,
    faults: &mut Faults,
) -> Bodies {
    let mut names = Names::default();
    let mut made = Bodies::default();
    for (i, raw) in raw.bodies.iter().enumerate() {
        let body = body::body(raw, i, scenes, faults);
        let (scope, id) = (Scope::item("bodies", i), i as u32);
        let own = Own { method: raw.method.is_some(), substeps: raw.substeps.is_some() };
        made.sections.push(Section::new(scope, id..id + 1, own, &body, scenes));
        made.bodies.push(body);
        made.labels.extend(body::label(raw, scope, faults).map(|label| (id, label)));
        // The dot tells generated names from written ones.
        let name = raw.name.clone().unwrap_or_else(|| format!("body.{i}"));
        if raw.name.is_some() {
            check_name(&name, scope, faults);
        }
        check_fresh(names.add(name.clone()), &name, scope, faults);
    }
    let entries = resolve_entries(raw, faults);
    let Some(total) = check_size(raw, reading, &entries, faults) else { return made };

    let mut random = Pcg64::seed_from_u64(seed);
    let mut of_kind: HashMap<&str, usize> = HashMap::new();
    made.bodies.reserve_exact(total as usize - made.bodies.len());
    for entry in entries {
        let GeneratedEntry { scope, own, count, numbering, .. } = entry;
        let Some((kind, name)) = kind_and_name(raw, scope.section, scope.index.unwrap_or_default())
        else {
            continue;
        };
        let (first, count) = (names.len() as u32, count as u32);
        made.sections.push(Section::new(scope, first..first + count, own, &entry.body, scenes));
        let number = of_kind.entry(kind).or_default();
        *number += 1;
        let prefix = match name {
            Some(name) => {
                check_name(name, scope, faults);
                name.to_owned()
            }
            None if *number == 1 => kind.to_owned(),
            None => format!("{kind}{number}"),
        };
        let fresh = names.add_run(scope.section, prefix.clone(), count, numbering);
        check_fresh(fresh, &prefix, scope, faults);
        // The bodies are made even if there are faults: later checks need to know which bodies are immovable.
        (entry.make)(prefix, &mut made, &mut random);
        let these = &made.bodies[first as usize..];
        if !these.is_empty() && these.iter().all(|body| body.inverse_mass == Some(0.0)) {
            let cure = "leave at least one point free";
            faults.refuse(scope, "pinned", "every point is pinned, so none can move", cure);
        }
    }
    made.names = Some(names);
    made
}

/// The number of all bodies; `None`, with a fault, if it is too large.
fn check_size(
    raw: &raw::Scene,
    reading: Reading,
    entries: &[GeneratedEntry],
    faults: &mut Faults,
) -> Option<u64> {
    let written = raw.bodies.len() as u64;
    let total = entries.iter().fold(written, |sum, entry| sum.saturating_add(entry.count));
    if total > BODY_LIMIT {
        let cure = format!("give at most {BODY_LIMIT} in all");
        faults.add(largest(written, entries), format!("{total} bodies are too many"), cure);
        return None;
    }
    let attracts = raw.mutual_gravity.is_some();
    let grouped = if attracts { written } else { 0 };
    let drags = raw.bodies.iter().filter(|body| body.drag_key().is_some()).count() as u64;
    let curves = raw.thrusts.iter().chain(raw.moves.iter());
    let curves = curves.filter_map(|drive| drive.curve.as_ref());
    let sections = [
        ("bodies", Census { bodies: written, moved: grouped, grouped, drags, ..Census::default() }),
        ("springs", Census { springs: raw.springs.len() as u64, ..Census::default() }),
        ("wells", Census { wells: raw.wells.len() as u64, ..Census::default() }),
        (
            "thrusts",
            Census {
                thrusts: (raw.thrusts.len() + raw.moves.len()) as u64,
                points: curves.map(|curve| curve.points() as u64).sum(),
                ..Census::default()
            },
        ),
    ];
    let in_air = raw.drag.is_some() || raw.wind.is_some();
    let made = entries.iter().map(|entry| (entry.scope.path(), entry.census(attracts, in_air)));
    let all: Vec<_> =
        sections.map(|(path, census)| (path.to_owned(), census)).into_iter().chain(made).collect();
    let census = all.iter().fold(Census::default(), |sum, (_, census)| sum.and(*census));
    let needed = census.bytes(reading, 0);
    let Some((least, by_person)) = shortage(needed) else { return Some(total) };
    let largest = all.iter().max_by_key(|(_, census)| census.bytes(Reading::default(), 0));
    let path = largest.map_or_else(|| "bodies".to_owned(), |(path, _)| path.clone());
    let words = census.words();
    let take = if words == "1 body" { "takes" } else { "take" };
    let (needed, there) = (byte_words(needed), there_are(least, by_person));
    let what = format!("{words} {take} some {needed}, and {there}");
    faults.add(path, what, "give fewer, or more with `--memory GIB`");
    None
}

/// The list that makes the most bodies.
fn largest(written: u64, entries: &[GeneratedEntry]) -> &'static str {
    let of = |list: &str| {
        let counts =
            entries.iter().filter(|entry| entry.scope.section == list).map(|entry| entry.count);
        counts.fold(0, u64::saturating_add)
    };
    LISTS
        .iter()
        .rev()
        .map(|list| (of(list), *list))
        .fold((written, "bodies"), |most, list| most.max(list))
        .1
}

/// Most characters of the name of a scene or an entry.
pub(crate) const NAME_LIMIT: usize = 100;

/// Names are plain words, because scripts, tables and generated names contain them.
fn check_name(name: &str, scope: Scope, faults: &mut Faults) {
    // An umlaut may be written as a letter and a combining mark.
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '\u{300}'..='\u{36f}');
    let length = name.chars().count();
    if length > NAME_LIMIT {
        let what = format!("{length} characters are too many for a name");
        faults.refuse(scope, "name", what, format!("give at most {NAME_LIMIT}"));
    } else if name.is_empty() || !name.chars().all(is_plain) {
        let cure = "use letters, digits, `_` and `-`";
        faults.refuse(scope, "name", format!("{name:?} cannot be a name"), cure);
    }
}

fn check_fresh(fresh: bool, name: &str, scope: Scope, faults: &mut Faults) {
    if !fresh {
        let what = format!("the name `{name}` is taken");
        faults.refuse(scope, "name", what, "give every body a name of its own");
    }
}

#[cfg(test)]
mod tests;
