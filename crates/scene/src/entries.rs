//! The entries of a scene's file, each with the bodies that it makes.

use std::ops::Range;

use crate::generate::may_be_taken_apart;
use crate::scene::Scene;

/// An entry of a scene file that makes bodies. They have one method and one number of substeps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The name of its list, as in `soft_bodies`.
    pub list: &'static str,
    /// Its index in the list, from 0.
    pub index: usize,
    /// Stable ids of its bodies.
    pub bodies: Range<u32>,
}

impl Entry {
    /// The key path of the entry, as in `soft_bodies[0]`.
    #[must_use]
    pub fn path(&self) -> String {
        format!("{}[{}]", self.list, self.index)
    }

    /// Whether its bodies may become entries of `bodies`.
    #[must_use]
    pub fn may_be_taken_apart(&self) -> bool {
        may_be_taken_apart(self.list)
    }
}

impl Scene {
    /// The entries of the scene's file that make bodies, in the order of the stable id.
    #[must_use]
    pub fn entries(&self) -> Vec<Entry> {
        let written = (0..self.names.written()).map(|id| Entry {
            list: "bodies",
            index: id as usize,
            bodies: id..id + 1,
        });
        written.chain(self.generated()).collect()
    }

    /// The entries that generate bodies: all but those of the list `bodies`.
    pub(crate) fn generated(&self) -> impl Iterator<Item = Entry> {
        let mut before: Option<(&str, usize)> = None;
        self.names.runs().map(move |(list, bodies)| {
            let index =
                before.filter(|(other, _)| *other == list).map_or(0, |(_, index)| index + 1);
            before = Some((list, index));
            Entry { list, index, bodies }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_body_belongs_to_the_entry_that_made_it() {
        let text = "(version: 1, bodies: [(), (name: \"a\")],
            grids: [(rows: 2, columns: 2), (rows: 1, columns: 3)], clouds: [(count: 4)],
            emitters: [(rate_per_s: 2, speed_m_s: 1, life_s: 1), (rate_per_s: 3, speed_m_s: 1, life_s: 1)],
            soft_bodies: [chain(points: 3, to_m: (1, 0, 0), stiffness_n_m: 1)])";
        let scene = Scene::parse("t", text).unwrap();
        let entries: Vec<_> =
            scene.entries().iter().map(|entry| (entry.path(), entry.bodies.clone())).collect();
        let expected = [
            ("bodies[0]", 0..1),
            ("bodies[1]", 1..2),
            ("grids[0]", 2..6),
            ("grids[1]", 6..9),
            ("clouds[0]", 9..13),
            ("emitters[0]", 13..15),
            ("emitters[1]", 15..18),
            ("soft_bodies[0]", 18..21),
        ];
        assert_eq!(entries, expected.map(|(path, bodies)| (path.to_owned(), bodies)));
        assert_eq!(scene.bodies.len(), 21);
        assert!(Scene::parse("t", "(version: 1)").unwrap().entries().is_empty());
    }
}
