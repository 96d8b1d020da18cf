//! The two layouts of a field: the rows of one group, or the same rows of several groups side by side.

use std::fmt;

use super::GroupField;
use super::lane_solver::LaneSolver;
use super::solving::Workspace;
use crate::groups::direct_sum::DirectSum;
use crate::groups::lanes::LaneSprings;
use crate::groups::pull::{Share, Shares};
use crate::groups::rows::{Element, Row};
use crate::kernels::Block;
use crate::kernels::evaluations::Iterations;
use crate::laws::{Axes, BLOCK_BODIES, BodyBlock, EvaluationTime, Law};

/// An element of the arrays of a field.
pub(crate) trait Layout: Element {
    /// Data from which the forces of springs are computed, besides the coupling.
    type Springs<'a>: Copy;

    /// Sets `sum` to the forces of the coupling in the state (`x`, `v`), N.
    fn pull(field: &GroupField<'_, Self>, time: f64, x: &[Self], v: &[Self], sum: &mut [Self]);

    /// Adds the accelerations of the called laws in the state (`x`, `v`).
    fn call(
        field: &GroupField<'_, Self>,
        at: EvaluationTime,
        x: &[Self],
        v: &mut [Self],
        sum: &mut [Self],
    );

    /// Arrays of an implicit step.
    type Workspace: Default + fmt::Debug;

    /// Replaces the velocities `v`, kicked by constant accelerations, by those after an implicit step, and adds to the
    /// iterations of each group.
    fn solve(field: &mut GroupField<'_, Self>, v: &mut [Self], iterations: &mut [Iterations]);
}

/// The rows of one group.
impl Layout for Row {
    /// The shares of the threads; empty if one thread computes all springs.
    type Springs<'a> = &'a [Share];

    fn pull(field: &GroupField<'_>, time: f64, x: &[Self], v: &[Self], sum: &mut [Self]) {
        let coupling = field.coupling;
        sum.fill([0.0; 4]);
        field.springs().pull(field.shares(), x, v, sum);
        if let Some(drag) = field.environment.shared.laws.drag {
            coupling.blow(drag, time, x, v, sum);
        }
        if let (true, Some(law)) = (coupling.attracts, field.environment.shared.attraction) {
            let sum = &mut sum[..coupling.movable];
            DirectSum { law, x, masses: &field.scratch.masses }
                .attract(field.environment.threads, sum);
        }
    }

    /// Stores inverse masses beside the velocities.
    fn call(
        field: &GroupField<'_>,
        at: EvaluationTime,
        x: &[Self],
        v: &mut [Self],
        sum: &mut [Self],
    ) {
        let movable = field.coupling.movable;
        v.iter_mut().zip(field.rows.w).for_each(|(row, w)| row[3] = *w);
        for law in field.environment.parameters.laws {
            let in_sheets = field.in_sheets(*law);
            // Laws skip rows of inverse mass 0.
            in_sheets.iter().for_each(|row| v[*row as usize][3] = 0.0);
            add_called(*law, at, &x[..movable], &v[..movable], &mut sum[..movable]);
            in_sheets.iter().for_each(|row| v[*row as usize][3] = field.rows.w[*row as usize]);
        }
        for row in field.rows.with_laws {
            let row = *row as usize;
            for law in field.options.row(row).laws {
                add_called(&**law, at, &x[row..=row], &v[row..=row], &mut sum[row..=row]);
            }
        }
    }

    type Workspace = Workspace;

    fn solve(field: &mut GroupField<'_>, v: &mut [Self], iterations: &mut [Iterations]) {
        let mut work = std::mem::take(&mut field.scratch.workspace);
        work.step(field, v, &mut iterations[0]);
        field.scratch.workspace = work;
    }
}

impl<'a> GroupField<'a> {
    pub(super) fn shares(&self) -> Shares<'a> {
        let shares = self.threads.map(|threads| (threads, self.rows.springs));
        shares.filter(|(_, shares)| !shares.is_empty())
    }
}

/// Adds the accelerations of a law to `sum`. The rows of `v` are velocity and inverse mass.
fn add_called(law: &dyn Law, at: EvaluationTime, x: &[Row], v: &[Row], sum: &mut [Row]) {
    let chunks =
        x.chunks(BLOCK_BODIES).zip(v.chunks(BLOCK_BODIES)).zip(sum.chunks_mut(BLOCK_BODIES));
    for ((x, v), sum) in chunks {
        let [positions, velocities, mut block] = [x, v, sum].map(Block::<BLOCK_BODIES>::of);
        // Laws skip bodies of inverse mass 0; a block that is almost full is faster without such bodies.
        let filler = if x.len() > BLOCK_BODIES / 4 { v[0][3] } else { 0.0 };
        let mut inverse_masses = [filler; BLOCK_BODIES];
        inverse_masses.iter_mut().zip(v).for_each(|(w, row)| *w = row[3]);
        let bodies = BodyBlock {
            positions: &positions.0,
            velocities: &velocities.0,
            inverse_masses: &inverse_masses,
        };
        law.accelerate(at, &bodies, &mut block.0);
        for (k, row) in sum.iter_mut().enumerate() {
            row[..3].copy_from_slice(&block.body(k));
        }
    }
}

/// The same row of several groups of one shape, a block of bodies. Groups with sheets, mutual gravity or own laws do not use
/// this layout.
impl Layout for Axes {
    type Springs<'a> = &'a LaneSprings;

    fn pull(field: &GroupField<'_, Self>, _: f64, x: &[Self], v: &[Self], sum: &mut [Self]) {
        sum[..field.movable()].as_flattened_mut().as_flattened_mut().fill(0.0);
        field.rows.springs.pull(field.coupling, x, v, sum);
    }

    fn call(
        field: &GroupField<'_, Self>,
        at: EvaluationTime,
        x: &[Self],
        v: &mut [Self],
        sum: &mut [Self],
    ) {
        let w = field.rows.w.as_chunks().0;
        let rows = sum[..field.movable()].iter_mut().zip(x).zip(v).zip(w);
        for (((sum, positions), velocities), inverse_masses) in rows {
            let bodies = BodyBlock { positions, velocities, inverse_masses };
            for law in field.environment.parameters.laws {
                law.accelerate(at, &bodies, sum);
            }
        }
    }

    type Workspace = LaneSolver;

    fn solve(field: &mut GroupField<'_, Self>, v: &mut [Self], iterations: &mut [Iterations]) {
        let mut solver = std::mem::take(&mut field.scratch.workspace);
        let mut forces = std::mem::take(&mut solver.forces);
        forces.resize(v.len());
        Self::pull(field, field.end().time, field.rows.x, v, &mut forces);
        solver.solve(field, &forces, v, iterations);
        solver.forces = forces;
        field.scratch.workspace = solver;
        field.evaluations += 1;
    }
}
