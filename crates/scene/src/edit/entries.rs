//! Removes, copies, moves, names and splits entries of a scene, with everything that names their bodies.

use std::borrow::Cow;

use glam::DVec3;
use pick::Shape;

use super::fields::{Field, Value};
use super::rewrite::{TextEdit, rewrite};
use crate::action::Action;
use crate::entries::Entry;
use crate::generate::{kind_and_name, may_be_taken_apart};
use crate::raw;
use crate::scene::{BodySpec, Scene};
use crate::text::{locate, syntax};

/// Keys that give the position of an entry, m.
const PLACES: [&str; 6] = ["position_m", "origin_m", "center_m", "corner_m", "from_m", "to_m"];

/// A position that moves along only if it is written.
const PREVIOUS: &str = "verlet_previous_position_m";

/// Most bodies of an entry that can be split.
const MOST_APART: usize = 1000;

impl Scene {
    /// The entry that made the body with that stable id.
    #[must_use]
    pub fn entry_of(&self, id: u32) -> Option<Entry> {
        let written = self.names.written();
        if id < written {
            return Some(Entry { list: "bodies", index: id as usize, bodies: id..id + 1 });
        }
        self.generated().find(|entry| entry.bodies.contains(&id))
    }

    /// The entry at `path`, as in `bodies[3]`, if it makes bodies.
    #[must_use]
    pub fn entry_at(&self, path: &str) -> Option<Entry> {
        let (list, index) = entry(path)?;
        match list {
            "bodies" => {
                self.entry_of(u32::try_from(index).ok()?).filter(|entry| entry.list == list)
            }
            _ => self.generated().find(|entry| (entry.list, entry.index) == (list, index)),
        }
    }

    /// Removes the entry at `path`, as in `bodies[3]`, and every spring, thrust and step of a survival script that
    /// names one of its bodies. Wells lose these names; a well goes if it names no other body or rides on one of
    /// them. An emitter that rides on such a body stays where the body begins. The names of other bodies are updated.
    #[must_use]
    pub fn without(&self, path: &str) -> Vec<TextEdit> {
        let Some((list, index)) = entry(path) else { return Vec::new() };
        let mut edits = vec![TextEdit::Remove { list: list.to_owned(), index }];
        if let Some(raw) = self.raw().filter(|raw| kind_and_name(raw, list, index).is_some()) {
            edits.extend(
                self.renamed(&raw, |name| {
                    Vec::from_iter(self.name_without(&raw, list, index, name))
                }),
            );
        }
        edits
    }

    /// The name of the body or entry `name` after entry `index` of `list` is removed; `None` if it is removed, too.
    /// Default names contain the number of the entry.
    fn name_without<'a>(
        &self,
        raw: &raw::Scene,
        list: &str,
        index: usize,
        name: &'a str,
    ) -> Option<Cow<'a, str>> {
        let Some(entry) = self.first_of(name).and_then(|id| self.entry_of(id)) else {
            return Some(Cow::Borrowed(name));
        };
        if (entry.list, entry.index) == (list, index) {
            return None;
        }
        let counts = entry.list == list && entry.index > index;
        if !counts || written_name(raw, list, entry.index).is_some() {
            return Some(Cow::Borrowed(name));
        }
        let same_kind = kind(raw, list, entry.index) == kind(raw, list, index);
        let [before, after] =
            [0, usize::from(same_kind)].map(|gone| unwritten_prefix(raw, list, entry.index, gone));
        Some(Cow::Owned(name.replacen(&before, &after, 1)))
    }

    /// Adds a copy of the entry at `path`, moved by `by`, m, with a name of its own.
    #[must_use]
    pub fn copied(&self, path: &str, by: DVec3) -> Vec<TextEdit> {
        let (Some((list, _)), Some(text)) = (entry(path), self.written(path)) else {
            return Vec::new();
        };
        let fields = self.fields(path);
        let mut keys = moved(&fields, by);
        if let Some(Field { value: Some(Value::Text(name)), .. }) =
            fields.iter().find(|field| field.key == "name")
        {
            keys.push(("name", Value::Text(self.fresh_name(name))));
        }
        let edits: Vec<_> = keys
            .into_iter()
            .map(|(key, value)| TextEdit::set("", key, value.to_string()))
            .collect();
        rewrite(&self.name, text, &edits)
            .map_or_else(|_| Vec::new(), |copy| vec![TextEdit::add(list, copy)])
    }

    /// Moves the entry at `path` by `by`, m.
    #[must_use]
    pub fn shifted(&self, path: &str, by: DVec3) -> Vec<TextEdit> {
        let keys = moved(&self.fields(path), by).into_iter();
        keys.map(|(key, value)| TextEdit::set(path, key, value.to_string())).collect()
    }

    /// Names the entry at `path`, and updates the springs, wells, thrusts, emitters and survival scripts that name
    /// its bodies.
    #[must_use]
    pub fn named(&self, path: &str, name: &str) -> Vec<TextEdit> {
        let mut edits = vec![TextEdit::set(path, "name", Value::Text(name.to_owned()).to_string())];
        let present = self.entry_at(path);
        if let Some((raw, present)) = self.raw().zip(present) {
            let written = written_name(&raw, present.list, present.index);
            let unwritten = || unwritten_prefix(&raw, present.list, present.index, 0);
            let before = written.map_or_else(unwritten, str::to_owned);
            edits.extend(self.renamed(&raw, |other| {
                let of_it = self.first_of(other).is_some_and(|id| present.bodies.contains(&id));
                vec![if of_it {
                    Cow::Owned(other.replacen(&before, name, 1))
                } else {
                    Cow::Borrowed(other)
                }]
            }));
        }
        edits
    }

    /// Splits an entry of independent bodies, such as a grid, into one entry per body. Empty for other entries and
    /// for entries of more than 1000 bodies.
    #[must_use]
    pub fn apart(&self, path: &str) -> Vec<TextEdit> {
        let present = self.entry_at(path);
        let Some((Entry { list, index, bodies }, raw)) = present.zip(self.raw()) else {
            return Vec::new();
        };
        if !may_be_taken_apart(list) || bodies.len() > MOST_APART {
            return Vec::new();
        }
        let name = |id| self.names.get(id).unwrap_or_default().replace('.', "-");
        let mut edits = vec![TextEdit::Remove { list: list.to_owned(), index }];
        edits.extend(
            bodies.clone().map(|id| {
                TextEdit::add("bodies", written_body(&name(id), &self.bodies[id as usize]))
            }),
        );
        edits.extend(self.renamed(&raw, |other| match self.names.find(other) {
            Some(id) if bodies.contains(&id) => vec![Cow::Owned(name(id))],
            // A well that names the whole entry gets the name of each body.
            None if self.names.group(other) == Some(bodies.clone()) => {
                bodies.clone().map(|id| Cow::Owned(name(id))).collect()
            }
            _ => Vec::from_iter(self.name_without(&raw, list, index, other)),
        }));
        edits
    }

    /// `wanted`, with a number if a body or an entry has that name already.
    #[must_use]
    pub fn fresh_name(&self, wanted: &str) -> String {
        let base = wanted.trim_end_matches(|c: char| c.is_ascii_digit());
        let raw = self.raw();
        let taken = |name: &str| {
            let of_entry = |entry: &Entry| {
                raw.as_ref().is_some_and(|raw| match written_name(raw, entry.list, entry.index) {
                    Some(written) => written == name,
                    None => unwritten_prefix(raw, entry.list, entry.index, 0) == name,
                })
            };
            self.names.find(name).is_some() || self.entries().iter().any(of_entry)
        };
        let numbered = (2_u32..).map(|number| format!("{base}{number}"));
        let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
        names.find(|name| !taken(name)).unwrap_or_default()
    }

    /// The scene as it is written in its file.
    fn raw(&self) -> Option<raw::Scene> {
        syntax::read(&locate::spell_nan(&self.text), "").ok().map(|(raw, _)| raw)
    }

    /// Leaves an emitter where the body that carries it begins.
    fn left_behind(&self, index: usize) -> Vec<TextEdit> {
        let group = format!("emitters[{index}]");
        let Some(emitter) = self.emitters.get(index) else { return Vec::new() };
        let body = emitter.rides_on.and_then(|id| self.bodies.get(id as usize));
        let [x, y, z] =
            (emitter.position + body.map_or(DVec3::ZERO, |body| body.position)).to_array();
        let stays = TextEdit::Set { group: group.clone(), key: "rides_on".to_owned(), value: None };
        vec![stays, TextEdit::set(group, "position_m", format!("({x:?}, {y:?}, {z:?})"))]
    }

    /// The body of that name, or the first body of the entry of that name.
    fn first_of(&self, name: &str) -> Option<u32> {
        self.names.find(name).or_else(|| self.names.group(name).map(|bodies| bodies.start))
    }

    /// Replaces the name of every body or entry by its new names. Removes whatever names one without a new name.
    fn renamed<'a>(
        &self,
        raw: &'a raw::Scene,
        new: impl Fn(&'a str) -> Vec<Cow<'a, str>>,
    ) -> Vec<TextEdit> {
        let (mut edits, mut left) = (Vec::new(), Vec::new());
        let mut change =
            |list: &str, index: usize, key: &str, names: &'a [String], least: usize| {
                let renamed: Vec<_> = names.iter().flat_map(|name| new(name)).collect();
                if renamed.len() < least {
                    edits.push(TextEdit::Remove { list: list.to_owned(), index });
                } else if renamed != names {
                    let quoted: Vec<_> = renamed.iter().map(|name| format!("{name:?}")).collect();
                    let value = match key {
                        "between" => format!("({})", quoted.join(", ")),
                        "body" | "rides_on" => quoted.concat(),
                        _ => format!("[{}]", quoted.join(", ")),
                    };
                    edits.push(TextEdit::set(format!("{list}[{index}]"), key, value));
                }
            };
        for (i, spring) in raw.springs.iter().enumerate() {
            spring.between.iter().for_each(|between| change("springs", i, "between", between, 2));
        }
        for (list, drives) in [("thrusts", &raw.thrusts), ("moves", &raw.moves)] {
            for (i, drive) in drives.iter().enumerate() {
                let body = drive.body.as_slice();
                body.iter().for_each(|_| change(list, i, "body", body, 1));
            }
        }
        for (i, well) in raw.wells.iter().enumerate() {
            // A well is removed with the body that carries it, whatever it attracts.
            let goes = well.rides_on.as_ref().is_some_and(|body| new(body).is_empty());
            well.rides_on
                .iter()
                .for_each(|body| change("wells", i, "rides_on", std::slice::from_ref(body), 1));
            let bodies = well.bodies.iter().filter(|_| !goes);
            bodies.for_each(|bodies| change("wells", i, "bodies", bodies, 1));
        }
        for (i, emitter) in raw.emitters.iter().enumerate() {
            let Some(body) = &emitter.rides_on else { continue };
            if new(body).is_empty() {
                left.push(i);
            } else {
                change("emitters", i, "rides_on", std::slice::from_ref(body), 1);
            }
        }
        for i in left {
            edits.extend(self.left_behind(i));
        }
        for (list, script) in survival_scripts(raw) {
            for (index, step) in script.iter().enumerate() {
                let Some(name) = step.action.as_ref().and_then(Action::body) else { continue };
                let group = format!("{list}[{index}]");
                let action = self.written(&format!("{group}.do")).unwrap_or_default();
                match new(name).into_iter().next() {
                    None => edits.push(TextEdit::Remove { list: list.clone(), index }),
                    Some(renamed) if renamed != name => {
                        let action =
                            action.replacen(&format!("{name:?}"), &format!("{renamed:?}"), 1);
                        edits.push(TextEdit::set(group, "do", action));
                    }
                    Some(_) => {}
                }
            }
        }
        edits
    }
}

/// The scripts of the survival rows, each with its path.
fn survival_scripts(raw: &raw::Scene) -> impl Iterator<Item = (String, &[raw::Step])> {
    let survival = raw.expect.as_ref().and_then(|expect| expect.survival.as_ref());
    survival.into_iter().flat_map(|survival| {
        let rows = survival.rows.iter().enumerate();
        let rows =
            rows.map(|(row, survival)| (format!("expect.survival.rows[{row}].script"), survival));
        let all = std::iter::once(("expect.survival.script".to_owned(), survival)).chain(rows);
        all.map(|(path, survival)| (path, survival.script.as_deref().unwrap_or_default()))
    })
}

/// Splits the path of an entry into its list and its index.
fn entry(path: &str) -> Option<(&str, usize)> {
    let (list, index) = path.strip_suffix(']')?.split_once('[')?;
    Some((list, index.parse().ok()?))
}

fn written_name<'a>(raw: &'a raw::Scene, list: &str, index: usize) -> Option<&'a str> {
    kind_and_name(raw, list, index)?.1
}

/// The word with which the default name of an entry begins, as `grid`.
fn kind<'a>(raw: &'a raw::Scene, list: &str, index: usize) -> &'a str {
    kind_and_name(raw, list, index).unwrap_or_default().0
}

/// The number of an entry among those of its kind, from 1.
fn number(raw: &raw::Scene, list: &str, index: usize) -> usize {
    (0..=index).filter(|other| kind(raw, list, *other) == kind(raw, list, index)).count()
}

/// The beginning of the default names of an entry's bodies, after `gone` earlier entries of its kind are removed.
fn unwritten_prefix(raw: &raw::Scene, list: &str, index: usize, gone: usize) -> String {
    match (kind(raw, list, index), number(raw, list, index) - gone) {
        ("body", number) => format!("body.{}", number - 1),
        (kind, 1) => kind.to_owned(),
        (kind, number) => format!("{kind}{number}"),
    }
}

/// The keys of `fields` that give positions, moved by `by`, m.
fn moved(fields: &[Field], by: DVec3) -> Vec<(&'static str, Value)> {
    let place = |field: &Field| {
        let at = match &field.value {
            Some(Value::Numbers(at)) => DVec3::from_slice(at),
            None if field.key != PREVIOUS => DVec3::ZERO,
            _ => return None,
        };
        Some((field.key, Value::from(moved_place(at, by))))
    };
    let places = fields.iter().filter(|field| PLACES.contains(&field.key) || field.key == PREVIOUS);
    places.filter_map(place).collect()
}

/// The place `by` away from `at`, m, with no more decimals than both have: 34.7 + 0.1 is 34.8.
#[must_use]
pub fn moved_place(at: DVec3, by: DVec3) -> DVec3 {
    let decimals =
        |number: f64| number.to_string().split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let sum = |i: usize| {
        let (sum, decimals) = (at[i] + by[i], decimals(at[i]).max(decimals(by[i])));
        format!("{sum:.decimals$}").parse().unwrap_or(sum)
    };
    DVec3::new(sum(0), sum(1), sum(2))
}

/// A body as a person writes it.
fn written_body(name: &str, body: &BodySpec) -> String {
    let triple = |v: DVec3| Value::from(v).to_string();
    let shape = body.shape.map(|shape| match shape {
        Shape::Cuboid { half_extents } => {
            format!("cuboid(half_extents_m: {})", triple(half_extents))
        }
        Shape::Sphere { radius } => format!("sphere(radius_m: {radius:?})"),
    });
    let color = body.color.map(|part| format!("{part:?}")).join(", ");
    let keys = [
        ("name", Some(format!("{name:?}"))),
        ("shape", shape),
        ("position_m", Some(triple(body.position))),
        ("velocity_m_s", (body.velocity != DVec3::ZERO).then(|| triple(body.velocity))),
        ("mass_kg", body.inverse_mass.map(|inverse| format!("{:?}", mass(inverse)))),
        ("color", Some(format!("({color})"))),
        ("texture", body.checker.then(|| "checker".to_owned())),
        ("method", body.method.map(|method| method.name().to_owned())),
        ("substeps", body.substeps.map(|substeps| substeps.to_string())),
    ];
    let keys = keys.into_iter().filter_map(|(key, value)| Some(format!("{key}: {}", value?)));
    format!("({})", keys.collect::<Vec<_>>().join(", "))
}

/// A mass whose reciprocal is exactly that one, if there is one.
fn mass(inverse: f64) -> f64 {
    let near = 1.0 / inverse;
    let candidates = [near, near.next_up(), near.next_down()];
    candidates.into_iter().find(|mass| (1.0 / mass).to_bits() == inverse.to_bits()).unwrap_or(near)
}
