//! Implicit Euler steps of groups: linearized, and solved by conjugate gradients.

use super::GroupField;
use super::classes::Class;
use crate::groups::combination::Combination;
use crate::groups::coupling::{is_open, vector};
use crate::groups::linear::LinearStep;
use crate::groups::rows::{Row, RowArray};
use crate::groups::solver::{Gradients, Solved, advance, dot};
use crate::laws::{BodyState, EvaluationTime, Law};
use crate::methods::Field as _;
use crate::methods::{ImplicitEuler, MOST_HALVINGS, MOST_ITERATIONS};
use crate::real::{Real, RealMatrix as _, RealVector as _};
use crate::state::threads::Threads;

/// Arrays of a solve, reused for the next one.
#[derive(Debug, Default)]
pub(super) struct Workspace<T: Real> {
    linear: LinearStep<T>,
    gradients: Gradients<T>,
    x: RowArray<T>,
    /// Velocities before the solve, with the kicks that precede it.
    before: RowArray<T>,
    /// Velocities that a Newton iteration tries.
    tried: RowArray<T>,
}

impl<T: Real> GroupField<'_, T> {
    fn end(&self) -> EvaluationTime<T> {
        self.segment.evaluation_time(T::ONE)
    }

    pub(super) fn class(&self, row: usize) -> &Class<T> {
        self.scratch.classes.of(row)
    }

    /// Whether any law is called.
    pub(super) fn calls(&self) -> bool {
        !self.environment.terms.laws.is_empty() || !self.rows.with_laws.is_empty()
    }

    /// Calls `each` for every called law and every row that it acts on.
    fn each_call(&self, mut each: impl FnMut(usize, &dyn Law<T>)) {
        for law in self.environment.terms.laws {
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
    fn call_at_end(&mut self, x: &[Row<T>], v: &[Row<T>], sum: &mut [Row<T>]) {
        if self.calls() {
            let mut stage = std::mem::take(&mut self.scratch.stage[1]);
            stage.copy(v);
            self.call(self.end(), x, &mut stage, sum);
            self.scratch.stage[1] = stage;
        }
        self.count();
    }

    /// The velocity after an implicit step from the velocity `v`, as an array.
    pub(super) fn solve(&mut self, v: Combination<T>) -> Combination<T> {
        let v = v + self.applied() * self.step();
        let (before, start) = (v, self.own_array(&v));
        let mut work = std::mem::take(&mut self.scratch.workspace);
        let mut v = std::mem::take(&mut self.scratch.slots[start]);
        self.kick_by_constants(&mut v);
        let gained = self.rows.residues.is_some().then(|| self.own_array(&Combination::ZERO));
        let mut gain = gained.map(|slot| std::mem::take(&mut self.scratch.slots[slot]));
        if let Some(gain) = &mut gain {
            self.kick_by_constants(gain);
        }
        work.x.copy(self.rows.x);
        work.fit(self);
        let follows_state = work.linearize(self, &v, false);
        work.force(self, &v);
        work.right_side(self, &v, false);
        let most = self.environment.solver.newton_iterations;
        let most = if follows_state { most.max(MOST_ITERATIONS) } else { most };
        if most > 0 {
            work.before.copy(&v);
        }
        let mut converged = work.iterate(self, &mut v, gain.as_deref_mut());
        let nonlinear = work.converge(self, &mut v, gain.as_deref_mut(), most);
        if follows_state {
            converged = nonlinear;
        }
        self.statistics.iterations.unconverged_steps += u64::from(!converged);
        self.scratch.slots[start] = v;
        self.scratch.workspace = work;
        // One row is enough: the solution depends on all of them.
        self.look(|field| field.broken(field.array(start)).take(1).collect());
        match gained.zip(gain) {
            None => Combination::of(start),
            Some((slot, gain)) => {
                self.scratch.slots[slot] = gain;
                before + Combination::of(slot)
            }
        }
    }

    /// Adds `g h` to the velocities of movable rows.
    fn kick_by_constants(&self, v: &mut [Row<T>]) {
        let h = self.step();
        for (row, v) in v[..self.coupling.movable].iter_mut().enumerate() {
            if self.rows.w[row] > T::ZERO {
                let class = self.class(row);
                let g = class.constant.to_array();
                for axis in 0..3 {
                    if is_open(class.locks, axis) {
                        v[axis] += g[axis] * h;
                    }
                }
            }
        }
    }
}

impl<T: Real> Workspace<T> {
    fn fit(&mut self, field: &GroupField<'_, T>) {
        self.gradients.fit(field.coupling.rows);
        self.linear.fit(field.coupling.rows, &field.rows.w[..field.coupling.movable]);
    }

    /// Linearizes all laws at the positions of this workspace and the velocities `v`. Returns whether a called law depends
    /// on the state of its body.
    fn linearize(&mut self, field: &GroupField<'_, T>, v: &[Row<T>], exact: bool) -> bool {
        let Self { linear, x, .. } = self;
        let step = (field.end(), field.step());
        let drag = field.environment.shared.laws.drag;
        linear.linearize(field.threads, field.coupling, drag, step, exact, (x, v));
        let mut follows_state = false;
        if field.calls() {
            linear.expect_laws();
            field.each_call(|row, law| {
                let (position, velocity) = (vector(&x[row]), vector(&v[row]));
                let body = BodyState { position, velocity, inverse_mass: field.rows.w[row] };
                follows_state |= linear.add_law(row, law, step, body) || law.depends_on_velocity();
            });
        }
        follows_state
    }

    /// The forces of the coupling, N.
    fn force(&mut self, field: &GroupField<'_, T>, v: &[Row<T>]) {
        field.coupling_forces(field.end().time, &self.x, v, &mut self.linear.forces);
    }

    /// `h W^½ (f - h K v)`, from the forces f at the start of the step; for an iteration of Newton `W^-½ (v0 + h a - v)`,
    /// from the forces at its end.
    fn right_side(&mut self, field: &mut GroupField<'_, T>, v: &[Row<T>], is_newton: bool) {
        let h = field.step();
        if !is_newton {
            self.linear.add_moves_of_springs(field.shares(), h, v);
        }
        self.gradients.q.fill([T::ZERO; 4]);
        let mut called = std::mem::take(&mut self.gradients.q);
        field.call_at_end(&self.x, v, &mut called);
        let (r, forces): (&mut [Row<T>], &[Row<T>]) = (&mut self.gradients.r, &self.linear.forces);
        let (LinearStep { root, local, .. }, before) = (&self.linear, &self.before);
        let classes = &field.scratch.classes;
        Threads::share(field.threads, &mut r[..field.coupling.movable], |first, r| {
            for (row, r) in (first..).zip(r) {
                let (root, Class { rate, locks, .. }) = (root[row], *classes.of(row));
                let mut a = [0, 1, 2].map(|axis| called[row][axis] - rate * v[row][axis]);
                if !is_newton {
                    let moved = match local.get(row) {
                        Some(local) => local.moved.times(vector(&v[row])).to_array(),
                        None => [T::ZERO; 3],
                    };
                    a = [0, 1, 2].map(|axis| a[axis] + moved[axis]);
                }
                for axis in 0..3 {
                    let change = if is_newton { before[row][axis] - v[row][axis] } else { T::ZERO };
                    r[axis] = if root > T::ZERO && is_open(locks, axis) {
                        h * root * forces[row][axis] + (h * a[axis] + change) / root
                    } else {
                        T::ZERO
                    };
                }
            }
        });
        self.gradients.q = called;
    }

    /// The residual of the implicit step `v1 = v0 + h a(x0 + h v1, v1)`, times the roots of the masses.
    fn residual(&mut self, field: &mut GroupField<'_, T>, v: &[Row<T>]) {
        let h = field.step();
        for (x, (start, v)) in self.x.iter_mut().zip(field.rows.x.iter().zip(v)) {
            (0..3).for_each(|axis| x[axis] = start[axis] + v[axis] * h);
        }
        self.force(field, v);
        self.right_side(field, v, true);
    }

    /// Continues from `v` by Newton's method, for at most so many iterations. Returns whether it has converged.
    fn converge(
        &mut self,
        field: &mut GroupField<'_, T>,
        v: &mut [Row<T>],
        mut gain: Option<&mut [Row<T>]>,
        most: u32,
    ) -> bool {
        if most == 0 {
            return false;
        }
        let (movable, half) = (field.coupling.movable, T::of(0.5));
        let mut tried = std::mem::take(&mut self.tried);
        self.residual(field, v);
        let mut converged = false;
        for _ in 0..most {
            let before = dot(&self.gradients.r[..movable], &self.gradients.r[..movable]);
            self.linearize(field, v, true);
            let Solved { iterations, is_finite, .. } = self.solve(field, true);
            field.statistics.iterations.newton += 1;
            field.statistics.iterations.cg += u64::from(iterations);
            if !is_finite {
                self.show_broken(field, v, gain.as_deref_mut());
                break;
            }
            let Self { gradients, linear, .. } = self;
            for (y, root) in gradients.y[..movable].iter_mut().zip(&linear.root) {
                (0..3).for_each(|axis| y[axis] = y[axis] * *root);
            }
            converged = self.is_small(field, v);
            let mut part = T::ONE;
            let accepted = converged
                || (0..=MOST_HALVINGS).any(|_| {
                    tried.copy(v);
                    advance(&mut tried[..movable], &self.gradients.y, part);
                    self.residual(field, &tried);
                    let after = dot(&self.gradients.r[..movable], &self.gradients.r[..movable]);
                    let is_better = after.is_at_most(before);
                    part = if is_better { part } else { part * half };
                    is_better
                });
            if accepted {
                for sum in [Some(&mut *v), gain.as_deref_mut()].into_iter().flatten() {
                    advance(&mut sum[..movable], &self.gradients.y, part);
                }
            }
            if converged || !accepted {
                break;
            }
        }
        self.tried = tried;
        converged
    }

    /// Whether a correction of `v` is below the tolerance, or moves the bodies by less than the rounding of positions.
    fn is_small(&self, field: &GroupField<'_, T>, v: &[Row<T>]) -> bool {
        let movable = field.coupling.movable;
        let largest = |rows: &[Row<T>]| {
            let parts = rows[..movable].iter().flat_map(|row| &row[..3]);
            parts.fold(T::ZERO, |most, part| if part.abs().is_at_most(most) { most } else { part.abs() })
        };
        let size = largest(&self.gradients.y);
        // Several springs round at each body.
        let rounding = T::EPSILON * T::of(16.0) * largest(&self.x);
        size <= ImplicitEuler::tolerance::<T>() * (largest(v) + largest(&self.before))
            || size * field.step() <= rounding
    }

    /// Solves for the residual in the arrays of the gradients, with exact derivatives or with their definite part.
    fn solve(&mut self, field: &GroupField<'_, T>, exact: bool) -> Solved {
        let Self { linear, gradients, .. } = self;
        let movable = field.coupling.movable;
        let classes = &field.scratch.classes;
        let locked = classes.list.iter().any(|class| class.locks.is_some());
        let row_terms = |row: usize| {
            let Class { rate, locks, .. } = classes.of(row);
            (*rate, if locked { *locks } else { None })
        };
        let (h, sheets, solver) = (field.step(), &field.coupling.sheets, field.environment.solver);
        let (threads, shares) = (field.threads, field.shares());
        let mut multiply = |exact: bool, p: &[Row<T>], q: &mut [Row<T>]| {
            linear.multiply(shares, h, sheets, row_terms, exact, (p, q));
        };
        if exact {
            gradients.solve_exact(solver, movable, threads, multiply)
        } else {
            gradients.solve(solver, movable, threads, |p, q| multiply(false, p, q))
        }
    }

    /// Makes velocities infinite or NaN where the right side was: those of the other rows stay as they are.
    fn show_broken(&self, field: &mut GroupField<'_, T>, v: &mut [Row<T>], gain: Option<&mut [Row<T>]>) {
        let r = &self.gradients.r;
        for sum in [Some(v), gain].into_iter().flatten() {
            for (v, r) in sum[..field.coupling.movable].iter_mut().zip(r.iter()) {
                (0..3).filter(|axis| !r[*axis].is_finite()).for_each(|axis| v[axis] = r[axis]);
            }
        }
        field.look(|field| field.broken(r).collect());
    }

    /// Adds the solution of the linearized step to `v`, and to `gain` if there is one. Returns whether it converged.
    fn iterate(
        &mut self,
        field: &mut GroupField<'_, T>,
        v: &mut [Row<T>],
        mut gain: Option<&mut [Row<T>]>,
    ) -> bool {
        let Solved { iterations, converged, is_finite } = self.solve(field, false);
        if !is_finite {
            self.show_broken(field, v, gain.as_deref_mut());
        }
        let Self { linear, gradients, .. } = self;
        for sum in [Some(v), gain].into_iter().flatten() {
            for ((v, y), root) in
                sum[..field.coupling.movable].iter_mut().zip(gradients.y.iter()).zip(&linear.root)
            {
                (0..3).for_each(|axis| v[axis] += y[axis] * *root);
            }
        }
        field.statistics.iterations.cg += u64::from(iterations);
        converged
    }
}
