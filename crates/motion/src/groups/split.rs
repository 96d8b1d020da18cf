//! Connected components of couplings.

use std::collections::HashMap;

use super::coupling::{Coupling, SheetRow};
use super::pull::SpringRow;
use crate::units::Scalar;

/// Disjoint sets of numbers that are joined two by two (Galler, Fischer 1964).
#[derive(Clone, Debug)]
pub struct Sets {
    parents: Vec<usize>,
}

impl Sets {
    /// The numbers below `count`, each in a set of its own.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The representative of the set of `member`: its lowest number.
    ///
    /// # Panics
    /// If `member` is not below the count. [`Sets::join`] panics likewise.
    pub fn of(&mut self, mut member: usize) -> usize {
        while self.parents[member] != member {
            self.parents[member] = self.parents[self.parents[member]];
            member = self.parents[member];
        }
        member
    }

    /// Joins the sets of two members.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.parents[a.max(b)] = a.min(b);
    }
}

/// A connected component of a coupling.
#[derive(Default)]
pub(crate) struct Part {
    pub coupling: Coupling,
    /// Its rows, as rows of the whole.
    pub rows: Vec<usize>,
    /// Row numbers in the part of anchors, by their rows in the whole.
    held: HashMap<usize, usize>,
}

impl Coupling {
    /// The connected components, in the order of their lowest rows. If there is only one, its springs are moved and
    /// not copied: they are most of the memory of a large world.
    pub(super) fn into_parts(mut self) -> Vec<Part> {
        let none = vec![false; self.rows];
        let mut sets = self.sets(&none);
        let is_connected = self.movable > 0 && (1..self.movable).all(|row| sets.of(row) == 0);
        let moves = |rows: &[u32]| rows.iter().any(|row| (*row as usize) < self.movable);
        let all_move = self.springs.iter().all(|spring| moves(&spring.ends))
            && self.sheets.iter().all(|sheet| moves(&sheet.corners));
        if !(is_connected && all_move) {
            return self.parts(&none);
        }
        let (mut springs, mut sheets) =
            (std::mem::take(&mut self.springs), std::mem::take(&mut self.sheets));
        let mut part = Part::default();
        part.rows.extend(0..self.movable);
        part.coupling.movable = self.movable;
        if self.attracts {
            (self.movable..self.rows).for_each(|row| part.hold(&self, row));
        }
        springs.renumber(|row| part.row(&self, row, &|row| row));
        for sheet in &mut sheets {
            sheet.corners = sheet.corners.map(|row| part.row(&self, row, &|row| row));
        }
        (part.coupling.springs, part.coupling.sheets) = (springs, sheets);
        part.finish(&self);
        vec![part]
    }

    /// The sets of movable rows that act on each other, without the rows `removed`.
    fn sets(&self, removed: &[bool]) -> Sets {
        let moves = |row: u32| (row as usize) < self.movable;
        let lives = |rows: &[u32]| rows.iter().all(|row| !removed[*row as usize]);
        let mut sets = Sets::new(self.movable);
        let mut join = |rows: &[u32]| {
            let mut movable = rows.iter().copied().filter(|row| moves(*row));
            if let Some(first) = movable.next() {
                movable.for_each(|row| sets.join(first as usize, row as usize));
            }
        };
        self.springs
            .iter()
            .filter(|spring| lives(&spring.ends))
            .for_each(|spring| join(&spring.ends));
        self.sheets
            .iter()
            .filter(|sheet| lives(&sheet.corners))
            .for_each(|sheet| join(&sheet.corners));
        if self.attracts {
            let all: Vec<u32> =
                (0..).take(self.movable).filter(|row| !removed[*row as usize]).collect();
            join(&all);
        }
        sets
    }

    /// The connected components without the rows `removed`, in the order of their lowest rows. Springs and triangles are
    /// removed with their ends. A row that is left alone is a part of its own.
    pub(super) fn parts(&self, removed: &[bool]) -> Vec<Part> {
        let moves = |row: u32| (row as usize) < self.movable;
        let lives = |rows: &[u32]| rows.iter().all(|row| !removed[*row as usize]);
        let mut sets = self.sets(removed);
        let mut parts: Vec<Part> = Vec::new();
        let mut part_of = vec![usize::MAX; self.movable];
        // Row numbers of the part by rows of the whole.
        let mut numbers = vec![0; self.movable];
        for row in (0..self.movable).filter(|row| !removed[*row]) {
            let first = sets.of(row);
            if first == row {
                part_of[row] = parts.len();
                parts.push(Part::default());
            }
            part_of[row] = part_of[first];
            let rows = &mut parts[part_of[row]].rows;
            numbers[row] = u32::try_from(rows.len()).unwrap_or(u32::MAX);
            rows.push(row);
        }
        for part in &mut parts {
            part.coupling.movable = part.rows.len();
        }
        for row in (self.movable..self.rows).filter(|row| !removed[*row] && self.attracts) {
            parts.iter_mut().for_each(|part| part.hold(self, row));
        }
        let number = |row: u32| numbers[row as usize];
        let part =
            |rows: &[u32]| rows.iter().find(|row| moves(**row)).map(|row| part_of[*row as usize]);
        for SpringRow { ends, elastic } in self.springs.iter().filter(|spring| lives(&spring.ends))
        {
            if let Some(part) = part(&ends) {
                let part = &mut parts[part];
                let ends = ends.map(|row| part.row(self, row, &number));
                part.coupling.springs.push(SpringRow { ends, elastic });
            }
        }
        for SheetRow { corners, mass } in self.sheets.iter().filter(|sheet| lives(&sheet.corners)) {
            if let Some(part) = part(corners) {
                let part = &mut parts[part];
                let corners = corners.map(|row| part.row(self, row, &number));
                part.coupling.sheets.push(SheetRow { corners, mass: *mass });
            }
        }
        parts.iter_mut().for_each(|part| part.finish(self));
        parts
    }
}

impl Coupling {
    /// A subset of `rows`, ascending, in which no two rows act on each other, chosen greedily from the lowest.
    pub(super) fn apart(&self, rows: &[usize]) -> Vec<usize> {
        if self.attracts {
            return rows.first().copied().into_iter().collect();
        }
        let mut lower: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut join = |ends: &[u32]| {
            for (a, b) in
                ends.iter().flat_map(|a| ends.iter().map(move |b| (*a as usize, *b as usize)))
            {
                if a < b && rows.binary_search(&a).is_ok() && rows.binary_search(&b).is_ok() {
                    lower.entry(b).or_default().push(a);
                }
            }
        };
        self.springs.iter().for_each(|spring| join(&spring.ends));
        self.sheets.iter().for_each(|sheet| join(&sheet.corners));
        let mut apart: Vec<usize> = Vec::new();
        for row in rows {
            let before = lower.get(row).map_or(&[][..], Vec::as_slice);
            if !before.iter().any(|other| apart.binary_search(other).is_ok()) {
                apart.push(*row);
            }
        }
        apart
    }
}

impl Part {
    /// Adds an anchor; the movable rows must have been added before.
    fn hold(&mut self, whole: &Coupling, row: usize) {
        self.coupling.sources.push(whole.sources[row - whole.movable]);
        let motion = whole.motions.iter().find(|(of, _)| *of == row);
        self.coupling.motions.extend(motion.map(|(_, motion)| (self.rows.len(), motion.clone())));
        self.held.insert(row, self.rows.len());
        self.rows.push(row);
    }

    /// The number in the part of row `row` of the whole; `number` returns it for a movable row.
    fn row(&mut self, whole: &Coupling, row: u32, number: &impl Fn(u32) -> u32) -> u32 {
        if (row as usize) < whole.movable {
            return number(row);
        }
        let found = self.held.get(&(row as usize)).copied().unwrap_or_else(|| {
            self.hold(whole, row as usize);
            self.rows.len() - 1
        });
        u32::try_from(found).unwrap_or(u32::MAX)
    }

    fn finish(&mut self, whole: &Coupling) {
        self.coupling.attracts = whole.attracts;
        self.coupling.rows = self.rows.len();
        if !self.coupling.sheets.is_empty() {
            let own = self.rows[..self.coupling.movable].iter();
            self.coupling.masses = own.map(|row| whole.masses[*row]).collect();
        }
        self.coupling.finish();
    }
}

impl Coupling {
    /// Updates the masses of the movable rows from the inverse masses `w`, if some were written since the groups were compiled.
    pub(super) fn weigh(&mut self, w: &[Scalar]) {
        if !self.attracts && self.sheets.is_empty() {
            return;
        }
        let mut written = false;
        for (mass, w) in self.masses.iter_mut().zip(w).filter(|(_, w)| **w > 0.0) {
            let now = 1.0 / w;
            written |= now.to_bits() != mass.to_bits();
            *mass = now;
        }
        if written {
            self.finish();
        }
    }
}

impl Coupling {
    /// Computes the masses of triangles: the mass of a point is shared by its triangles. An anchor counts as the mean of the
    /// movable corners.
    pub(super) fn finish(&mut self) {
        let Self { sheets, masses, in_sheets, movable, .. } = self;
        let mut triangles = vec![0_u32; *movable];
        let moves = |row: &u32| (*row as usize) < *movable;
        in_sheets.clear();
        in_sheets.extend(sheets.iter().flat_map(|sheet| sheet.corners).filter(moves));
        in_sheets.iter().for_each(|row| triangles[*row as usize] += 1);
        in_sheets.sort_unstable();
        in_sheets.dedup();
        for sheet in sheets {
            let (mut sum, mut corners) = (0.0, 0);
            for row in sheet.corners.iter().filter(|row| moves(row)) {
                sum += masses[*row as usize] / f64::from(triangles[*row as usize]);
                corners += 1;
            }
            sheet.mass = sum * (3.0 / f64::from(corners.max(1)));
        }
    }
}
