//! What the solver of implicit steps sees of a group.

use super::classes::{Class, class_at};
use super::{GroupField, Scratch};
use crate::groups::combination::Combination;
use crate::groups::coupling::SheetRow;
use crate::groups::pull::Springs;
use crate::groups::rows::{Row, RowArray};
use crate::groups::solver::{Solver, Workspace};
use crate::laws::{Drag, EvaluationTime, Law};
use crate::methods::Field as _;
use crate::real::Real;

impl<'a, T: Real> GroupField<'a, T> {
    pub(crate) const fn length(&self) -> T {
        self.piece.length
    }

    pub(crate) fn end(&self) -> EvaluationTime<T> {
        self.piece.moment(T::ONE)
    }

    pub(crate) const fn rows(&self) -> usize {
        self.coupling.rows
    }

    pub(crate) const fn movable(&self) -> usize {
        self.coupling.movable
    }

    pub(crate) fn positions(&self) -> &[Row<T>] {
        self.rows.x
    }

    pub(crate) fn inverse_mass(&self, row: usize) -> T {
        self.rows.w[row]
    }

    pub(crate) fn class(&self, row: usize) -> &Class<T> {
        let Scratch { classes, class_of, .. } = &*self.scratch;
        &classes[class_at(class_of, row)]
    }

    pub(crate) fn any_locks(&self) -> bool {
        self.scratch.classes.iter().any(|class| class.locks.is_some())
    }

    pub(crate) fn springs(&self) -> &'a Springs<T> {
        &self.coupling.springs
    }

    pub(crate) fn sheets(&self) -> &'a [SheetRow<T>] {
        &self.coupling.sheets
    }

    pub(crate) fn drag(&self) -> Option<&'a Drag> {
        self.around.drag
    }

    pub(crate) const fn solver(&self) -> Solver {
        self.around.solver
    }

    pub(crate) fn workspace(&mut self) -> &mut Workspace<T> {
        &mut self.scratch.workspace
    }

    pub(crate) fn slot(&mut self, slot: usize) -> &mut RowArray<T> {
        &mut self.scratch.slots[slot]
    }

    pub(crate) const fn is_compensated(&self) -> bool {
        self.rows.residues.is_some()
    }

    /// What the applied forces do to velocities in a step.
    pub(crate) fn applied_kick(&self) -> Combination<T> {
        self.applied() * self.piece.length
    }

    /// Whether there are laws to be called.
    pub(crate) fn calls(&self) -> bool {
        !self.around.terms.laws.is_empty() || !self.rows.lawful.is_empty()
    }

    /// Every law that is called, for every row that it acts on.
    pub(crate) fn each_call(&self, mut each: impl FnMut(usize, &dyn Law<T>)) {
        for law in self.around.terms.laws {
            for row in 0..self.coupling.movable {
                if self.in_sheets(*law).binary_search(&(row as u32)).is_err() {
                    each(row, *law);
                }
            }
        }
        for row in self.rows.lawful {
            self.askers.laws(*row as usize).0.iter().for_each(|law| each(*row as usize, &**law));
        }
    }

    /// Adds the accelerations of the laws that are called, at the end of the step, and counts an evaluation of
    /// all laws.
    pub(crate) fn call_at_end(&mut self, x: &[Row<T>], v: &[Row<T>], sum: &mut [Row<T>]) {
        if self.calls() {
            let mut stage = std::mem::take(&mut self.scratch.stage[1]);
            stage.copy(v);
            self.call(self.end(), x, &mut stage, sum);
            self.scratch.stage[1] = stage;
        }
        self.count();
    }

    pub(crate) fn report_solve(&mut self, iterations: u32, converged: bool) {
        self.account.cg_iterations += u64::from(iterations);
        self.account.unconverged += u64::from(!converged);
    }
}
