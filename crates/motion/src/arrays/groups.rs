//! Groups of bodies in plain arrays.

use super::Bare;
use crate::groups::{
    Coupling, GroupCache, GroupEnvironment, GroupField, GroupKernel, GroupRows, Row, RowArray, Watch,
};
use crate::kernels::{OfRows, StepStatistics};
use crate::methods::MethodStateKind;
use crate::methods::table::Method;
use crate::real::Real;

/// A group of bodies in plain arrays.
#[derive(Debug, Default)]
pub(super) struct ArrayGroup<T: Real> {
    pub coupling: Coupling<T>,
    /// The rows of its bodies, movable ones first.
    pub rows: Vec<usize>,
    /// Its own rows whose options change them, ascending.
    pub with_options: Vec<u32>,
    /// Its own rows with own laws, ascending.
    pub with_laws: Vec<u32>,
    pub substeps: Option<u32>,
    /// The method of its bodies, if they have their own.
    pub method: Option<Method>,
    pub cache: GroupCache<T>,
    pub x: RowArray<T>,
    pub v: RowArray<T>,
    /// Rounding errors of both, where sums are compensated.
    pub residues: [RowArray<T>; 2],
    pub w: Vec<T>,
    pub last: Vec<T>,
}

impl<T: Real> ArrayGroup<T> {
    /// The rows of the movable bodies.
    pub fn members(&self) -> impl Iterator<Item = usize> {
        self.rows[..self.coupling.movable].iter().copied()
    }

    pub fn forget(&mut self) {
        self.cache = GroupCache::default();
    }
}

impl<T: Real> Bare<T> {
    pub(super) fn method_of_group(&self, group: usize) -> Method {
        self.groups[group].method.unwrap_or(self.method)
    }

    /// Integrates a tick of `kernel` for a group; if a row fails, all rows keep their state.
    pub(super) fn tick_group(&mut self, number: usize, kernel: GroupKernel<T>) {
        let mut group = std::mem::take(&mut self.groups[number]);
        let mut scratch = std::mem::take(&mut self.scratch);
        let rows = std::mem::take(&mut group.rows);
        let members = &rows[..group.coupling.movable];
        let times = self.times(group.substeps.unwrap_or(self.substeps));
        let shared = self.resources.environment(times);
        let called = shared.called();
        let environment =
            GroupEnvironment::new(kernel.single.traits, shared, &called, self.resources.solver, &[], None);
        let options = OfRows { whole: &self.individuals, rows: &rows };
        let mut statistics = StepStatistics::default();
        let mut outcome = Ok(());
        for watch in [Watch::Off, Watch::On] {
            self.gather(&rows, &mut group);
            self.gather_pushes(members, &mut scratch.pushes);
            let ArrayGroup { coupling, with_options, with_laws, cache, x, v, residues, w, last, .. } =
                &mut group;
            let residues = self.residues.is_some().then(|| residues.each_mut().map(|rows| &mut **rows));
            let last = &mut last[..coupling.movable];
            let (cache, shares) = (Some(cache), &[][..]);
            let rows = GroupRows { x, v, residues, w, last, with_options, with_laws, cache, shares };
            let field =
                GroupField::new(coupling, &environment, rows, &options, &mut scratch, &mut statistics);
            outcome = (kernel.tick)(field, watch);
            if outcome.is_ok() {
                break;
            }
        }
        drop(called);
        self.scratch = scratch;
        match outcome {
            Ok(()) => {
                self.statistics.add(&statistics);
                self.scatter(kernel, members, &group);
            }
            Err(first) => {
                let is_finite = |row: usize| self.forces[row].iter().all(|part| part.is_finite());
                let pushed = members.iter().copied().find(|row| !is_finite(*row));
                self.refused.push(pushed.or(first.first().map(|row| rows[*row])).unwrap_or(rows[0]));
                group.forget();
            }
        }
        group.rows = rows;
        self.groups[number] = group;
    }

    fn gather(&self, rows: &[usize], group: &mut ArrayGroup<T>) {
        let ArrayGroup { x, v, .. } = group;
        x.resize(rows.len());
        v.resize(rows.len());
        for ((row, x), v) in rows.iter().zip(x.iter_mut()).zip(v.iter_mut()) {
            let ([a, b, c], [d, e, f, _]) = (self.positions[*row], self.bodies[*row]);
            (*x, *v) = ([a, b, c, T::ZERO], [d, e, f, T::ZERO]);
        }
        if let Some(residues) = &self.residues {
            for (to, from) in group.residues.iter_mut().zip(residues) {
                to.resize(rows.len());
                for (to, row) in to.iter_mut().zip(rows) {
                    let [x, y, z] = from[*row];
                    *to = [x, y, z, T::ZERO];
                }
            }
        }
        let ArrayGroup { w, last, .. } = group;
        w.clear();
        w.extend(rows.iter().map(|row| self.bodies[*row][3]));
        last.clear();
        last.extend(rows.iter().map(|row| self.last_steps.get(*row).copied().unwrap_or(T::ZERO)));
    }

    /// Collects the pushes on a group, by its own rows.
    fn gather_pushes(&self, members: &[usize], pushes: &mut Vec<(usize, Row<T>)>) {
        pushes.clear();
        if self.pushed.is_empty() {
            return;
        }
        pushes.extend(members.iter().enumerate().filter_map(|(own, row)| {
            let [x, y, z] = self.forces[*row];
            self.pushed.binary_search(&(0, *row)).ok().map(|_| (own, [x, y, z, T::ZERO]))
        }));
    }

    fn scatter(&mut self, kernel: GroupKernel<T>, members: &[usize], group: &ArrayGroup<T>) {
        let keeps_last_step = kernel.single.traits.state == MethodStateKind::LastStep;
        if keeps_last_step {
            self.last_steps.resize(self.bodies.len(), T::ZERO);
        }
        for (own, row) in members.iter().enumerate() {
            self.positions[*row].copy_from_slice(&group.x[own][..3]);
            self.bodies[*row][..3].copy_from_slice(&group.v[own][..3]);
            if keeps_last_step {
                self.last_steps[*row] = group.last[own];
            }
            for (to, from) in self.residues.iter_mut().flatten().zip(&group.residues) {
                to[*row].copy_from_slice(&from[own][..3]);
            }
        }
    }
}
