//! Names of bodies by stable id; those of grids and clouds are made on demand.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::nearest::nearest;

/// The name of every body of a scene, by stable id.
///
/// A million particles cost one entry: generated names are a prefix and a pattern.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    given: Vec<String>,
    by_name: HashMap<String, u32>,
    runs: Vec<Run>,
    count: u32,
}

/// The bodies that one grid or cloud generated.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    prefix: String,
    first: u32,
    count: u32,
    /// Bodies along z, the inner loop, of a grid; `None` for a cloud.
    rows: Option<u32>,
}

impl Names {
    /// How many bodies there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are none.
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

    /// Every name in the order of the stable id.
    pub fn iter(&self) -> impl Iterator<Item = Cow<'_, str>> {
        let generated = self.runs.iter().flat_map(|run| (0..run.count).map(|i| Cow::Owned(run.name(i))));
        self.given.iter().map(|name| Cow::Borrowed(name.as_str())).chain(generated)
    }

    /// What is wrong with a name that [`Self::find`] does not find, and what would be right.
    pub(crate) fn stranger(&self, name: &str) -> (String, String) {
        let cure = match nearest(name, self.given.iter().map(String::as_str)) {
            Some(near) => format!("did you mean {near:?}?"),
            None => "give the name of a body of the scene".to_owned(),
        };
        (format!("there is no body {name:?}"), cure)
    }

    /// Adds a name of its own; false if it is taken. All of these come before the generated ones.
    pub(crate) fn add(&mut self, name: String) -> bool {
        let fresh = self.by_name.insert(name.clone(), self.count).is_none();
        self.given.push(name);
        self.count += 1;
        fresh
    }

    /// Adds `count` names `prefix.17`, or `prefix.x3.z1` with `rows` bodies along z; false if the prefix is taken.
    pub(crate) fn add_run(&mut self, prefix: String, count: u32, rows: Option<u32>) -> bool {
        let fresh = self.runs.iter().all(|run| run.prefix != prefix);
        self.runs.push(Run { prefix, first: self.count, count, rows });
        self.count += count;
        fresh
    }
}

impl Run {
    fn name(&self, i: u32) -> String {
        let prefix = &self.prefix;
        match self.rows {
            Some(rows) => format!("{prefix}.x{}.z{}", i / rows, i % rows),
            None => format!("{prefix}.{i}"),
        }
    }

    fn find(&self, name: &str) -> Option<u32> {
        let rest = name.strip_prefix(&self.prefix)?.strip_prefix('.')?;
        let i = match self.rows {
            Some(rows) => {
                let (x, z) = rest.strip_prefix('x')?.split_once(".z")?;
                x.parse::<u32>().ok()?.checked_mul(rows)?.checked_add(z.parse().ok()?)?
            }
            None => rest.parse().ok()?,
        };
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
        assert!(names.add_run("grid".to_owned(), 6, Some(3)));
        assert!(names.add_run("cloud".to_owned(), 2, None));
        let all: Vec<_> = names.iter().map(Cow::into_owned).collect();
        let expected = [
            "floor",
            "grid.x0.z0",
            "grid.x0.z1",
            "grid.x0.z2",
            "grid.x1.z0",
            "grid.x1.z1",
            "grid.x1.z2",
            "cloud.0",
            "cloud.1",
        ];
        assert_eq!(all, expected);
        for (id, name) in (0..).zip(expected) {
            assert_eq!(names.get(id).as_deref(), Some(name));
            assert_eq!(names.find(name), Some(id));
        }
        assert_eq!(names.get(9), None);
        for stranger in
            ["grid.x0.z3", "grid.x00.z1", "grid.x2.z0", "cloud.2", "cloud.+1", "grid", "cloud.", "x"]
        {
            assert_eq!(names.find(stranger), None, "{stranger}");
        }
    }

    #[test]
    fn a_taken_name_is_seen() {
        let mut names = Names::default();
        assert!(names.add("a".to_owned()) && !names.add("a".to_owned()));
        assert!(names.add_run("g".to_owned(), 1, None) && !names.add_run("g".to_owned(), 1, Some(1)));
    }
}
