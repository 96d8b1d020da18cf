//! Names of bodies by stable id; those of generated bodies are made on demand.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use crate::text::nearest::nearest;

/// The name of every body of a scene, by stable id.
///
/// Generated names are a prefix and a pattern, so that a million particles take one entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    given: Vec<String>,
    by_name: HashMap<String, u32>,
    runs: Vec<Run>,
    count: u32,
}

/// The bodies that one entry of the file generated.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    list: &'static str,
    prefix: String,
    first: u32,
    count: u32,
    numbering: Numbering,
}

/// How the bodies of a run are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbering {
    /// `cloud.17`.
    Line,
    /// `grid.x3.z1`, with `rows` bodies along z, the inner loop.
    Grid { rows: u32 },
    /// `flag.r2.c5`, with `columns` bodies in a row.
    Sheet { columns: u32 },
    /// `jelly.x0.y1.z2`, with `y` bodies along y and `z` along z, the innermost loop.
    Lattice { y: u32, z: u32 },
}

impl Numbering {
    /// The letters before the numbers, outer loop first, and the lengths of the inner loops.
    fn axes(self) -> (&'static [&'static str], [u32; 2]) {
        match self {
            Self::Line => (&[""], [1, 1]),
            Self::Grid { rows } => (&["x", "z"], [rows, 1]),
            Self::Sheet { columns } => (&["r", "c"], [columns, 1]),
            Self::Lattice { y, z } => (&["x", "y", "z"], [y, z]),
        }
    }
}

impl Names {
    /// Number of bodies.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are no bodies.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The name of the body with that stable id, if there is one.
    #[must_use]
    pub fn get(&self, id: u32) -> Option<Cow<'_, str>> {
        if let Some(name) = self.given.get(id as usize) {
            return Some(Cow::Borrowed(name));
        }
        let run = self.runs.iter().find(|run| (run.first..run.first + run.count).contains(&id))?;
        Some(Cow::Owned(run.name(id - run.first)))
    }

    /// The stable id of the body of that name, if there is one.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).copied().or_else(|| self.runs.iter().find_map(|run| run.find(name)))
    }

    /// The stable ids of the bodies that the entry of that name generated, if there is one.
    pub(crate) fn group(&self, name: &str) -> Option<Range<u32>> {
        let run = self.runs.iter().find(|run| run.prefix == name)?;
        Some(run.first..run.first + run.count)
    }

    /// Every name in the order of the stable id.
    pub fn iter(&self) -> impl Iterator<Item = Cow<'_, str>> {
        let generated =
            self.runs.iter().flat_map(|run| (0..run.count).map(|i| Cow::Owned(run.name(i))));
        self.given.iter().map(|name| Cow::Borrowed(name.as_str())).chain(generated)
    }

    /// Number of written bodies; they come before the generated ones.
    pub(crate) fn written(&self) -> u32 {
        self.given.len() as u32
    }

    /// The list of each entry that generated bodies, and their stable ids.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (&'static str, Range<u32>)> {
        self.runs.iter().map(|run| (run.list, run.first..run.first + run.count))
    }

    /// The names of some bodies, ascending and with whole runs, counted from 0 in this order.
    pub(crate) fn of(&self, ids: &[u32]) -> Self {
        let mut names = Self::default();
        let written = ids.partition_point(|id| *id < self.written());
        for id in &ids[..written] {
            names.add(self.given[*id as usize].clone());
        }
        for run in self.runs.iter().filter(|run| ids.binary_search(&run.first).is_ok()) {
            names.add_run(run.list, run.prefix.clone(), run.count, run.numbering);
        }
        names
    }

    /// What is wrong with a name that [`Self::find`] does not find, and what would be right.
    #[must_use]
    pub fn stranger(&self, name: &str) -> (String, String) {
        let run = name
            .split_once('.')
            .and_then(|(prefix, _)| self.runs.iter().find(|r| r.prefix == prefix));
        if run.is_some_and(|run| run.list == "emitters" && run.count == 0) {
            let what =
                format!("{name:?} is a particle on the graphics device, where it has no name");
            return (what, "give its emitter on: cpu".to_owned());
        }
        let cure = match (run, nearest(name, self.given.iter().map(String::as_str))) {
            (Some(run), _) if run.count > 0 => {
                let (first, last) = (run.name(0), run.name(run.count - 1));
                format!("the bodies of {:?} are {first:?} to {last:?}", run.prefix)
            }
            (_, Some(near)) => format!("did you mean {near:?}?"),
            _ => "give the name of a body of the scene".to_owned(),
        };
        (format!("there is no body {name:?}"), cure)
    }

    /// Adds the name of a written body; false if it is taken. Written bodies come before the generated ones.
    pub(crate) fn add(&mut self, name: String) -> bool {
        let fresh = self.by_name.insert(name.clone(), self.count).is_none();
        self.given.push(name);
        self.count += 1;
        fresh
    }

    /// Adds `count` names after `prefix` for an entry of `list`; false if the prefix is taken.
    pub(crate) fn add_run(
        &mut self,
        list: &'static str,
        prefix: String,
        count: u32,
        numbering: Numbering,
    ) -> bool {
        let fresh = self.runs.iter().all(|run| run.prefix != prefix);
        self.runs.push(Run { list, prefix, first: self.count, count, numbering });
        self.count += count;
        fresh
    }
}

impl Run {
    fn name(&self, i: u32) -> String {
        let (letters, [middle, inner]) = self.numbering.axes();
        let numbers = [i / (middle * inner), i / inner % middle, i % inner];
        let mut name = self.prefix.clone();
        for (letter, number) in letters.iter().zip(numbers) {
            name.push_str(&format!(".{letter}{number}"));
        }
        name
    }

    fn find(&self, name: &str) -> Option<u32> {
        let mut rest = name.strip_prefix(&self.prefix)?;
        let (letters, lengths) = self.numbering.axes();
        let mut i = 0_u32;
        for (letter, length) in letters.iter().zip([1].into_iter().chain(lengths)) {
            rest = rest.strip_prefix('.')?.strip_prefix(letter)?;
            let end = rest.find('.').unwrap_or(rest.len());
            let number: u32 = rest[..end].parse().ok()?;
            rest = &rest[end..];
            i = i.checked_mul(length)?.checked_add(number)?;
        }
        // Compared in full, so that `x03` and an index past the edge are not taken for another body.
        (i < self.count && self.name(i) == name).then_some(self.first + i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_back_to_its_id() {
        let mut names = Names::default();
        assert!(names.add("floor".to_owned()));
        assert!(names.add_run("grids", "grid".to_owned(), 6, Numbering::Grid { rows: 3 }));
        assert!(names.add_run("clouds", "cloud".to_owned(), 2, Numbering::Line));
        assert!(names.add_run(
            "soft_bodies",
            "flag".to_owned(),
            4,
            Numbering::Sheet { columns: 2 }
        ));
        assert!(names.add_run(
            "soft_bodies",
            "jelly".to_owned(),
            12,
            Numbering::Lattice { y: 2, z: 3 }
        ));
        let all: Vec<_> = names.iter().map(Cow::into_owned).collect();
        let expected = "floor grid.x0.z0 grid.x0.z1 grid.x0.z2 grid.x1.z0 grid.x1.z1 grid.x1.z2 cloud.0 cloud.1 \
            flag.r0.c0 flag.r0.c1 flag.r1.c0 flag.r1.c1";
        let lattice = (0..2).flat_map(|x| (0..2).flat_map(move |y| (0..3).map(move |z| (x, y, z))));
        let lattice: Vec<_> = lattice.map(|(x, y, z)| format!("jelly.x{x}.y{y}.z{z}")).collect();
        let expected: Vec<_> =
            expected.split(' ').chain(lattice.iter().map(String::as_str)).collect();
        assert_eq!(all, expected);
        for (id, name) in (0..).zip(expected) {
            assert_eq!(names.get(id).as_deref(), Some(name));
            assert_eq!(names.find(name), Some(id));
        }
        assert_eq!(names.get(25), None);
        let strangers = "grid.x0.z3 grid.x00.z1 grid.x2.z0 grid.x0 grid.r0.c0 cloud.2 cloud.+1 grid cloud. x \
            flag.r0.c2 flag.r0.c0. jelly.x0.y2.z0 jelly.x0.y0 jelly.x0.y0.z0.w0";
        for stranger in strangers.split(' ') {
            assert_eq!(names.find(stranger), None, "{stranger}");
        }
    }

    #[test]
    fn a_taken_name_is_seen() {
        let mut names = Names::default();
        assert!(names.add("a".to_owned()) && !names.add("a".to_owned()));
        assert!(names.add_run("grids", "g".to_owned(), 1, Numbering::Line));
        assert!(!names.add_run("grids", "g".to_owned(), 1, Numbering::Grid { rows: 1 }));
    }
}
