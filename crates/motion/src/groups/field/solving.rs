//! Implicit Euler steps of groups: linearized, and solved by conjugate gradients.

use super::classes::Class;
use super::linear_step::LinearStep;
use super::{GroupField, Layout};
use crate::groups::combination::Combination;
use crate::groups::coupling::is_open;
use crate::groups::rows::{Row, RowArray, row_of};
use crate::groups::solver::{ConjugateGradients, Solved, StepMatrix, add_scaled, dot};
use crate::kernels::evaluations::Iterations;
use crate::kernels::record::vector;
use crate::laws::{BodyState, EvaluationTime, Law};
use crate::methods::Field as _;
use crate::methods::{ImplicitEuler, MOST_HALVINGS, MOST_ITERATIONS};
use crate::state::threads::Threads;

/// Arrays of a solve, reused for the next one.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    linear: LinearStep,
    gradients: ConjugateGradients,
    x: RowArray,
    /// Velocities before the solve, with the kicks that precede it.
    before: RowArray,
    /// Trial velocities of a Newton iteration.
    tried: RowArray,
}

impl<E: Layout> GroupField<'_, E> {
    pub(super) fn end(&self) -> EvaluationTime {
        self.segment.evaluation_time(1.0)
    }

    /// The velocity after an implicit step from the velocity `v`, as an array.
    pub(super) fn solve(&mut self, v: Combination) -> Combination {
        let v = v + self.applied() * self.step();
        let start = self.own_array(&v);
        let mut v = std::mem::take(&mut self.scratch.slots[start]);
        self.kick_by_constants(&mut v);
        self.move_anchors(&mut v);
        let mut iterations = std::mem::take(&mut self.scratch.iterations);
        iterations.resize(self.rows.groups, Iterations::default());
        E::solve(self, &mut v, &mut iterations);
        self.scratch.iterations = iterations;
        self.scratch.slots[start] = v;
        // One row is enough: the solution depends on all rows.
        self.look(|field| field.broken(field.array(start)).take(1).collect());
        Combination::of(start)
    }

    /// Gives the anchors that follow a motion the mean velocity of the step, which takes them to its end.
    fn move_anchors(&self, v: &mut [E]) {
        for (row, motion) in &self.coupling.motions {
            let (element, lane) = self.place(*row, 0);
            let start = vector(&self.rows.x[element].row(lane));
            let [end, _] = motion.at(self.end());
            v[element].set_row(lane, row_of((end - start) / self.step()));
        }
    }

    /// Adds `g h` to the velocities of movable rows.
    fn kick_by_constants(&self, v: &mut [E]) {
        let h = self.step();
        let rows = v[..self.movable()].iter_mut().zip(self.rows.w.chunks_exact(E::LANES));
        for (element, (v, w)) in rows.enumerate() {
            let Class { constant, locks, .. } = *self.class(element / self.width);
            for (axis, g) in constant.to_array().into_iter().enumerate() {
                if is_open(locks, axis) {
                    for (v, w) in v.axis_mut(axis).iter_mut().zip(w) {
                        *v = if *w > 0.0 { *v + g * h } else { *v };
                    }
                }
            }
        }
    }
}

impl GroupField<'_> {
    /// Calls `each` for every called law and every row that it acts on.
    fn each_call(&self, mut each: impl FnMut(usize, &dyn Law)) {
        for law in self.environment.parameters.laws {
            for row in 0..self.coupling.movable {
                if self.in_sheets(*law).binary_search(&(row as u32)).is_err() {
                    each(row, *law);
                }
            }
        }
        for row in self.rows.with_laws {
            self.options.row(*row as usize).laws.iter().for_each(|law| each(*row as usize, &**law));
        }
    }

    /// Adds the accelerations of the called laws at the end of the step, and counts an evaluation of all laws.
    fn call_at_end(&mut self, x: &[Row], v: &[Row], sum: &mut [Row]) {
        if self.calls() {
            let mut stage = std::mem::take(&mut self.scratch.stage[1]);
            stage.copy(v);
            Row::call(self, self.end(), x, &mut stage, sum);
            self.scratch.stage[1] = stage;
        }
        self.evaluations += 1;
    }
}

impl Workspace {
    /// [`Layout::solve`] of one group.
    pub fn step(&mut self, field: &mut GroupField<'_>, v: &mut [Row], iterations: &mut Iterations) {
        self.x.copy(field.rows.x);
        self.fit(field);
        let follows_state = self.linearize(field, v, StepMatrix::Definite);
        self.force(field, v);
        self.right_side(field, v, false);
        let most = field.environment.solver.newton_iterations;
        let most = if follows_state { most.max(MOST_ITERATIONS) } else { most };
        if most > 0 {
            self.before.copy(v);
        }
        let mut converged = self.iterate(field, v, iterations);
        let nonlinear = self.converge(field, v, most, iterations);
        if follows_state {
            converged = nonlinear;
        }
        iterations.unconverged_steps += u64::from(!converged);
    }

    fn fit(&mut self, field: &GroupField<'_>) {
        self.gradients.fit(field.coupling.rows);
        self.linear.fit(field.coupling.rows, &field.rows.w[..field.coupling.movable]);
    }

    /// Linearizes all laws at the positions of this workspace and the velocities `v`. Returns whether a called law depends
    /// on the state of its body.
    fn linearize(&mut self, field: &GroupField<'_>, v: &[Row], matrix: StepMatrix) -> bool {
        let Self { linear, x, .. } = self;
        linear.linearize(field, x, v, matrix);
        let mut follows_state = false;
        if field.calls() {
            linear.expect_laws();
            field.each_call(|row, law| {
                let (position, velocity) = (vector(&x[row]), vector(&v[row]));
                let body = BodyState { position, velocity, inverse_mass: field.rows.w[row] };
                follows_state |= linear.add_law(row, law, field.end(), field.step(), body)
                    || law.depends_on_velocity();
            });
        }
        follows_state
    }

    /// The forces of the coupling, N.
    fn force(&mut self, field: &GroupField<'_>, v: &[Row]) {
        Row::pull(field, field.end().time, &self.x, v, &mut self.linear.forces);
    }

    /// Computes the right side: `h W^½ (f - h K v)` from the forces f at the start of the step, or, for a Newton iteration,
    /// `W^-½ (v0 + h a - v)` from the forces at its end.
    fn right_side(&mut self, field: &mut GroupField<'_>, v: &[Row], is_newton: bool) {
        let h = field.step();
        if !is_newton {
            self.linear.add_moves_of_springs(field, &self.x, v);
        }
        self.gradients.q.fill([0.0; 4]);
        let mut called = std::mem::take(&mut self.gradients.q);
        field.call_at_end(&self.x, v, &mut called);
        let (r, forces): (&mut [Row], &[Row]) = (&mut self.gradients.r, &self.linear.forces);
        let (LinearStep { root, local, .. }, before) = (&self.linear, &self.before);
        let classes = &field.scratch.classes;
        Threads::share(field.threads, &mut r[..field.coupling.movable], |first, r| {
            for (row, r) in (first..).zip(r) {
                let (root, Class { rate, locks, .. }) = (root[row], *classes.of(row));
                let mut a = [0, 1, 2].map(|axis| called[row][axis] - rate * v[row][axis]);
                if !is_newton {
                    let moved = match local.get(row) {
                        Some(local) => (local.moved * vector(&v[row])).to_array(),
                        None => [0.0; 3],
                    };
                    a = [0, 1, 2].map(|axis| a[axis] + moved[axis]);
                }
                for axis in 0..3 {
                    let change = if is_newton { before[row][axis] - v[row][axis] } else { 0.0 };
                    r[axis] = if root > 0.0 && is_open(locks, axis) {
                        h * root * forces[row][axis] + (h * a[axis] + change) / root
                    } else {
                        0.0
                    };
                }
            }
        });
        self.gradients.q = called;
    }

    /// The residual of the implicit step `v1 = v0 + h a(x0 + h v1, v1)`, times the roots of the masses.
    fn residual(&mut self, field: &mut GroupField<'_>, v: &[Row]) {
        let h = field.step();
        for (x, (start, v)) in self.x.iter_mut().zip(field.rows.x.iter().zip(v)) {
            (0..3).for_each(|axis| x[axis] = start[axis] + v[axis] * h);
        }
        self.force(field, v);
        self.right_side(field, v, true);
    }

    /// Continues from `v` by Newton's method, for at most `most` iterations. Returns whether it has converged.
    fn converge(
        &mut self,
        field: &mut GroupField<'_>,
        v: &mut [Row],
        most: u32,
        counts: &mut Iterations,
    ) -> bool {
        if most == 0 {
            return false;
        }
        let movable = field.coupling.movable;
        let mut tried = std::mem::take(&mut self.tried);
        self.residual(field, v);
        let mut converged = false;
        for _ in 0..most {
            let before = dot(&self.gradients.r[..movable], &self.gradients.r[..movable]);
            self.linearize(field, v, StepMatrix::Exact);
            let Solved { iterations, is_finite, .. } = self.solve(field, StepMatrix::Exact);
            counts.newton += 1;
            counts.cg += u64::from(iterations);
            if !is_finite {
                self.show_broken(field, v);
                break;
            }
            let Self { gradients, linear, .. } = self;
            for (y, root) in gradients.y[..movable].iter_mut().zip(&linear.root) {
                (0..3).for_each(|axis| y[axis] *= *root);
            }
            converged = self.is_small(field, v);
            let mut part = 1.0;
            let accepted = converged
                || (0..=MOST_HALVINGS).any(|_| {
                    tried.copy(v);
                    add_scaled(&mut tried[..movable], &self.gradients.y, part);
                    self.residual(field, &tried);
                    let after = dot(&self.gradients.r[..movable], &self.gradients.r[..movable]);
                    let is_better = after <= before;
                    part = if is_better { part } else { part * 0.5 };
                    is_better
                });
            if accepted {
                add_scaled(&mut v[..movable], &self.gradients.y, part);
            }
            if converged || !accepted {
                break;
            }
        }
        self.tried = tried;
        converged
    }

    /// Whether a correction of `v` is below the tolerance, or moves the bodies by less than the rounding of positions.
    fn is_small(&self, field: &GroupField<'_>, v: &[Row]) -> bool {
        let movable = field.coupling.movable;
        let largest = |rows: &[Row]| {
            let parts = rows[..movable].iter().flat_map(|row| &row[..3]);
            parts.fold(0.0, |most, part| if part.abs() <= most { most } else { part.abs() })
        };
        let size = largest(&self.gradients.y);
        // The forces of several springs are rounded at each body.
        let rounding = f64::EPSILON * 16.0 * largest(&self.x);
        size <= ImplicitEuler::tolerance() * (largest(v) + largest(&self.before))
            || size * field.step() <= rounding
    }

    /// Solves for the residual in the arrays of the gradients.
    fn solve(&mut self, field: &GroupField<'_>, matrix: StepMatrix) -> Solved {
        let Self { linear, gradients, x, .. } = self;
        let movable = field.coupling.movable;
        let classes = &field.scratch.classes;
        let locked = classes.list.iter().any(|class| class.locks.is_some());
        let row_terms = |row: usize| {
            let Class { rate, locks, .. } = classes.of(row);
            (*rate, if locked { *locks } else { None })
        };
        let (solver, threads) = (field.environment.solver, field.threads);
        let mut multiply = |matrix: StepMatrix, p: &[Row], q: &mut [Row]| {
            linear.multiply(field, x, row_terms, matrix, p, q);
        };
        if matrix == StepMatrix::Exact {
            gradients.solve_indefinite(solver, movable, threads, multiply)
        } else {
            gradients.solve(solver, movable, threads, |p, q| multiply(matrix, p, q))
        }
    }

    /// Copies the entries of the right side that are not finite into the velocities. Other velocities stay as they are.
    fn show_broken(&self, field: &mut GroupField<'_>, v: &mut [Row]) {
        let r = &self.gradients.r;
        for (v, r) in v[..field.coupling.movable].iter_mut().zip(r.iter()) {
            (0..3).filter(|axis| !r[*axis].is_finite()).for_each(|axis| v[axis] = r[axis]);
        }
        field.look(|field| field.broken(r).collect());
    }

    /// Adds the solution of the linearized step to `v`. Returns whether it converged.
    fn iterate(
        &mut self,
        field: &mut GroupField<'_>,
        v: &mut [Row],
        counts: &mut Iterations,
    ) -> bool {
        let Solved { iterations, converged, is_finite } = self.solve(field, StepMatrix::Definite);
        if !is_finite {
            self.show_broken(field, v);
        }
        let Self { linear, gradients, .. } = self;
        for ((v, y), root) in
            v[..field.coupling.movable].iter_mut().zip(gradients.y.iter()).zip(&linear.root)
        {
            (0..3).for_each(|axis| v[axis] += y[axis] * *root);
        }
        counts.cg += u64::from(iterations);
        converged
    }
}
