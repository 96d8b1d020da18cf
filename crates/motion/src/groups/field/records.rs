//! Records of a tick of a group for a ledger.

use super::classes::Class;
use super::{GroupField, Layout};
use crate::groups::combination::Combination;
use crate::groups::rows::{Array, Row};
use crate::kernels::record::{Note, vector};
use crate::methods::Field as _;

impl<E: Layout> GroupField<'_, E> {
    /// Records a change, if a ledger wants it.
    pub(super) fn record_change(&mut self, from: Combination, to: Combination, note: Note<'_>) {
        if self.statistics.record.is_some() {
            let [from, to] = [from, to].map(|v| self.rows_of(&v));
            self.statistics.record.iter_mut().for_each(|record| record.note(&from, &to, note));
        }
    }

    /// Records a kick.
    pub(super) fn record_kick(&mut self, v: Combination, a: Combination, kicked: Combination) {
        if self.statistics.record.is_some() {
            let h = self.step();
            let damped = |row| {
                let Class { damping, decay, .. } = self.class(row);
                damping.filter(|_| decay.keep.is_some()).map(|damping| damping.rate * h)
            };
            let rates: Vec<_> = (0..self.coupling.rows).map(damped).collect();
            let a = self.rows_of(&a);
            self.record_change(v, kicked, &|record, row, from, to| match rates[row % rates.len()] {
                Some(q) => record.damped_kick(h, q, vector(&a[row]), from, to),
                None => record.kick(h, from, to),
            });
        }
    }

    /// Applies and records speed limits and axis locks.
    pub(super) fn limited(&mut self, v: Combination) -> Combination {
        let limited = self.restrain(v);
        self.record_change(v, limited, &|record, _, from, to| record.limit(from, to));
        limited
    }

    /// All rows, group by group.
    fn rows_of(&self, sum: &Combination) -> Vec<Row> {
        let mut elements = Array::default();
        self.compute(sum, &mut elements);
        let row = |group: usize, row: usize| {
            let (element, lane): (usize, usize) = self.place(row, group);
            elements[element].row(lane)
        };
        let of_group = |group: usize| (0..self.coupling.rows).map(move |number| (group, number));
        (0..self.rows.groups).flat_map(of_group).map(|(group, number)| row(group, number)).collect()
    }
}
