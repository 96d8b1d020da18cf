//! Groups of bodies in plain arrays.

use super::Bare;
use crate::groups::{
    Coupling, GroupCache, GroupEnvironment, GroupField, GroupKernel, GroupRows, Push, RowArray,
    Watch, are_at_rest,
};
use crate::kernels::{OfRows, StepStatistics};
use crate::methods::MethodStateKind;
use crate::methods::table::Method;

/// A group of bodies in plain arrays.
#[derive(Debug, Default)]
pub(super) struct ArrayGroup {
    pub coupling: Coupling,
    /// The rows of its bodies, movable ones first.
    pub rows: Vec<usize>,
    /// Group rows with options other than own laws and substeps, ascending.
    pub with_options: Vec<u32>,
    /// Group rows with own laws, ascending.
    pub with_laws: Vec<u32>,
    pub substeps: Option<u32>,
    /// The method of its bodies, if they have their own.
    pub method: Option<Method>,
    pub cache: GroupCache,
    pub x: RowArray,
    pub v: RowArray,
    pub w: Vec<f64>,
    pub last: Vec<f64>,
}

impl ArrayGroup {
    /// The rows of the movable bodies.
    pub fn members(&self) -> impl Iterator<Item = usize> {
        self.rows[..self.coupling.movable].iter().copied()
    }

    pub fn forget(&mut self) {
        self.cache = GroupCache::default();
    }
}

impl Bare {
    pub(super) fn method_of_group(&self, group: usize) -> Method {
        self.groups[group].method.unwrap_or(self.method)
    }

    /// Integrates a tick of `kernel` for a group; if a row fails, all rows keep their state.
    pub(super) fn tick_group(&mut self, number: usize, kernel: GroupKernel) {
        let mut group = std::mem::take(&mut self.groups[number]);
        let mut scratch = std::mem::take(&mut self.scratch);
        let rows = std::mem::take(&mut group.rows);
        let members = &rows[..group.coupling.movable];
        let times = self.times(group.substeps.unwrap_or(self.substeps));
        let shared = self.resources.environment(times);
        let called = shared.called();
        let environment = GroupEnvironment::new(
            kernel.single.traits,
            shared,
            &called,
            self.resources.solver,
            &[],
            None,
        );
        let options = OfRows { whole: &self.individuals, rows: &rows };
        let mut statistics = StepStatistics::default();
        let mut outcome = Ok(());
        for watch in [Watch::Off, Watch::On] {
            self.gather(&rows, &mut group);
            self.gather_pushes(members, &mut scratch.pushes);
            let ArrayGroup { coupling, with_options, with_laws, cache, x, v, w, last, .. } =
                &mut group;
            let last = &mut last[..coupling.movable];
            let (groups, apart, springs) = (1, &[][..], &[][..]);
            let (cache, anchors_rest) = (Some(cache), are_at_rest(&v[coupling.movable..]));
            let rows = GroupRows {
                x,
                v,
                w,
                groups,
                apart,
                last,
                with_options,
                with_laws,
                cache,
                anchors_rest,
                springs,
            };
            let field = GroupField::new(
                coupling,
                &environment,
                rows,
                &options,
                &mut scratch,
                &mut statistics,
            );
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
                self.refused
                    .push(pushed.or(first.first().map(|row| rows[*row])).unwrap_or(rows[0]));
                group.forget();
            }
        }
        group.rows = rows;
        self.groups[number] = group;
    }

    fn gather(&self, rows: &[usize], group: &mut ArrayGroup) {
        let ArrayGroup { x, v, w, last, .. } = group;
        x.resize(rows.len());
        v.resize(rows.len());
        for ((row, x), v) in rows.iter().zip(x.iter_mut()).zip(v.iter_mut()) {
            let ([a, b, c], [d, e, f, _]) = (self.positions[*row], self.bodies[*row]);
            (*x, *v) = ([a, b, c, 0.0], [d, e, f, 0.0]);
        }
        w.clear();
        w.extend(rows.iter().map(|row| self.bodies[*row][3]));
        last.clear();
        last.extend(rows.iter().map(|row| self.last_steps.get(*row).copied().unwrap_or(0.0)));
    }

    /// Collects the pushes on a group, by group row.
    fn gather_pushes(&self, members: &[usize], pushes: &mut Vec<Push>) {
        pushes.clear();
        if self.pushed.is_empty() {
            return;
        }
        pushes.extend(members.iter().enumerate().filter_map(|(own, row)| {
            let [x, y, z] = self.forces[*row];
            let push = Push { lane: 0, row: own, force: [x, y, z, 0.0] };
            self.pushed.binary_search(&(0, *row)).ok().map(|_| push)
        }));
    }

    fn scatter(&mut self, kernel: GroupKernel, members: &[usize], group: &ArrayGroup) {
        let keeps_last_step = kernel.single.traits.state == MethodStateKind::LastStep;
        if keeps_last_step {
            self.last_steps.resize(self.bodies.len(), 0.0);
        }
        for (own, row) in members.iter().enumerate() {
            self.positions[*row].copy_from_slice(&group.x[own][..3]);
            self.bodies[*row][..3].copy_from_slice(&group.v[own][..3]);
            if keeps_last_step {
                self.last_steps[*row] = group.last[own];
            }
        }
    }
}
