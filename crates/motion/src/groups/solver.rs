//! Implicit Euler steps of groups: linearised, and solved by conjugate gradients.

use bevy_ecs::prelude::*;

use super::combination::Combination;
use super::coupling::{SheetRow, add, in_air, is_open, rate_along, vector};
use super::field::GroupField;
use super::pull::{SpringRow, axis};
use super::rows::{Row, RowArray};
use crate::laws::{BodyState, EvaluationTime, Law};
use crate::real::{Real, RealMatrix as _, RealVector as _};

/// How an implicit Euler step of bodies that are joined is solved (Baraff, Witkin 1998, eq. 6, in inverse-mass
/// form): `(1 + h W^½ D W^½ + h² W^½ K W^½) y = h W^½ (f - h K v)`, `v1 = v + W^½ y`, with the stiffness K and the
/// damping D of the springs at the start of the step. It is linear, symmetric and positive definite, at least 1,
/// and a row of inverse mass 0 solves itself.
///
/// Gravity is a kick before it. A spring that is shorter than at rest has no stiffness across its axis, which would
/// be negative (Choi, Ko 2002). Of laws of single bodies the derivatives are taken in where they pull together;
/// where they push apart, and of mutual gravity, the law acts as at the start of the step. There is no other
/// preconditioner than the masses, because none other keeps momentum when the iteration is stopped early.
///
/// One linear solve is not stable for every stiffness: a chain of twenty links of 1e8 N/m and 1 kg that cracks like a
/// whip at 60 Hz takes in energy, and does not with five Newton iterations (`tests/groups/implicit.rs`).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Size of the residual, relative to that of the right side, at which the iteration stops.
    pub tolerance: f64,
    /// Iterations after which a step is taken as it is, and counted as not converged; at least 1.
    pub most_iterations: u32,
    /// Newton iterations after the linearised step, towards the solution of the step that is not linearised.
    pub newton_iterations: u32,
}

impl Default for Solver {
    /// Linearised, to 1e-8, in at most 500 iterations. In single precision the tolerance is at least 1e-5.
    fn default() -> Self {
        Self { tolerance: 1e-8, most_iterations: 500, newton_iterations: 0 }
    }
}

/// A spring, linearised: the force on its first end changes by `n (a - b) n·d + b d` with d by how much the second
/// end moves away from the first.
#[derive(Clone, Copy, Debug)]
struct Stiff<T: Real> {
    ends: [u32; 2],
    n: T::Vector,
    /// `h² k`, kg.
    along: T,
    /// `h² k (1 - L0 / L)`, at least 0, kg.
    across: T,
    /// `h c`, kg.
    damping: T,
}

/// Arrays of a solve, kept for the next one.
#[derive(Debug, Default)]
pub(crate) struct Workspace<T: Real> {
    springs: Vec<Stiff<T>>,
    /// Normal n and `h m (c + k |u| + k (u·n)² / |u|)`, kg, of triangles in air: the derivative along n.
    sheets: Vec<(T::Vector, T)>,
    /// Of laws of single bodies, where there are some: `-h da/dv - h² da/dx`, and `h da/dx`.
    local: Vec<(T::Matrix, T::Matrix)>,
    /// Square roots of inverse masses.
    root: Vec<T>,
    forces: RowArray<T>,
    /// Of the iteration: solution, residual, direction, product.
    y: RowArray<T>,
    r: RowArray<T>,
    p: RowArray<T>,
    q: RowArray<T>,
    scaled: RowArray<T>,
    x: RowArray<T>,
    /// Velocities before the step, with the kicks that come before it.
    before: RowArray<T>,
}

impl<T: Real> GroupField<'_, T> {
    /// The velocity after an implicit step from the positions at its start and the velocity `v`, as an array.
    pub(super) fn solve(&mut self, v: Combination<T>) -> Combination<T> {
        let v = v + self.applied_kick();
        let (before, start) = (v, self.own_array(&v));
        let mut work = std::mem::take(self.workspace());
        let mut v = std::mem::take(self.slot(start));
        self.kick_by_constants(&mut v);
        let gained = self.is_compensated().then(|| self.own_array(&Combination::ZERO));
        let mut gain = gained.map(|slot| std::mem::take(self.slot(slot)));
        if let Some(gain) = &mut gain {
            self.kick_by_constants(gain);
        }
        if self.solver().newton_iterations > 0 {
            work.before.copy(&v);
        }
        work.x.copy(self.positions());
        work.fit(self);
        work.linearise(self, &v);
        work.force(self, &v);
        work.right_side_of_step(self, &v);
        work.iterate(self, &mut v, gain.as_deref_mut());
        for _ in 0..self.solver().newton_iterations {
            let h = self.length();
            for (x, (start, v)) in work.x.iter_mut().zip(self.positions().iter().zip(v.iter())) {
                (0..3).for_each(|axis| x[axis] = start[axis] + v[axis] * h);
            }
            work.linearise(self, &v);
            work.force(self, &v);
            work.right_side_of_newton(self, &v);
            work.iterate(self, &mut v, gain.as_deref_mut());
        }
        *self.slot(start) = v;
        *self.workspace() = work;
        // One: the solution of a system has something of all of its rows.
        self.look(|field| field.broken(field.array(start)).take(1).collect());
        match gained.zip(gain) {
            None => Combination::of(start),
            Some((slot, gain)) => {
                *self.slot(slot) = gain;
                before + Combination::of(slot)
            }
        }
    }

    /// Adds `g h` to the velocities of what can move.
    fn kick_by_constants(&self, v: &mut [Row<T>]) {
        let h = self.length();
        for (row, v) in v[..self.movable()].iter_mut().enumerate() {
            if self.inverse_mass(row) > T::ZERO {
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
        let (rows, movable) = (field.rows(), field.movable());
        for array in [&mut self.forces, &mut self.y, &mut self.r, &mut self.p, &mut self.q, &mut self.scaled]
        {
            array.resize(rows);
            array.fill([T::ZERO; 4]);
        }
        self.root.clear();
        self.root.extend((0..movable).map(|row| {
            let w = field.inverse_mass(row);
            if w > T::ZERO { w.sqrt() } else { T::ZERO }
        }));
    }

    /// Derivatives of everything at the positions of this workspace and the velocities `v`.
    fn linearise(&mut self, field: &GroupField<'_, T>, v: &[Row<T>]) {
        let (h, at) = (field.length(), field.end());
        let x: &[Row<T>] = &self.x;
        self.springs.clear();
        self.springs.extend(field.springs().iter().map(|SpringRow { ends: [a, b], elastic }| {
            let d = vector(&x[b as usize]) - vector(&x[a as usize]);
            let (n, taut) = axis(d, elastic.rest_length);
            let along = h * h * elastic.stiffness;
            let across = along * taut;
            Stiff { ends: [a, b], n, along, across, damping: h * elastic.damping }
        }));
        self.sheets.clear();
        if let Some(drag) = field.drag() {
            let air = drag.wind.map(|wind| wind.air(at.time));
            self.sheets.extend(field.sheets().iter().map(|&SheetRow { corners, mass }| {
                match in_air(air.as_ref(), corners, x, v) {
                    Some((u, n)) => (n, h * mass * rate_along(drag, u, n)),
                    None => (T::Vector::ZERO, T::ZERO),
                }
            }));
        }
        self.local.clear();
        if field.calls() {
            self.local.resize(field.movable(), (T::Matrix::ZERO, T::Matrix::ZERO));
            field.each_call(|row, law| self.local_law(row, law, at, v, field.inverse_mass(row), h));
        }
    }

    fn local_law(&mut self, row: usize, law: &dyn Law<T>, at: EvaluationTime<T>, v: &[Row<T>], w: T, h: T) {
        if w.is_at_most(T::ZERO) {
            return;
        }
        let (position, velocity) = (vector(&self.x[row]), vector(&v[row]));
        let jacobians = law.jacobians(at, BodyState { position, velocity, inverse_mass: w });
        let [by_x, by_v] = [jacobians.position, jacobians.velocity].map(pulling_together::<T>);
        let (sum, moved) = self.local[row];
        self.local[row] = (sum - by_v * h - by_x * (h * h), moved + by_x * h);
    }

    /// Forces of what is coupled, N.
    fn force(&mut self, field: &GroupField<'_, T>, v: &[Row<T>]) {
        field.push_and_pull(field.end().time, &self.x, v, &mut self.forces);
    }

    /// `h W^½ (f - h K v)`, from the forces f at the start of the step.
    fn right_side_of_step(&mut self, field: &mut GroupField<'_, T>, v: &[Row<T>]) {
        let h = field.length();
        let forces: &mut [Row<T>] = &mut self.forces;
        for stiff in &self.springs {
            let [a, b] = stiff.ends.map(|end| end as usize);
            let change = stiff.change(vector(&v[b]) - vector(&v[a]), stiff.along) * (T::ONE / h);
            add(&mut forces[a], change);
            add(&mut forces[b], -change);
        }
        self.q.fill([T::ZERO; 4]);
        let mut called = std::mem::take(&mut self.q);
        field.call_at_end(&self.x, v, &mut called);
        for (row, called) in called[..field.movable()].iter_mut().enumerate() {
            let rate = field.class(row).rate;
            let moved = match self.local.get(row) {
                Some((_, moved)) => moved.times(vector(&v[row])).to_array(),
                None => [T::ZERO; 3],
            };
            (0..3).for_each(|axis| called[axis] = called[axis] - rate * v[row][axis] + moved[axis]);
        }
        self.right_side(field, &called, |_, _| T::ZERO);
        self.q = called;
    }

    /// `W^-½ (v0 + h a - v)`, from the forces at the end of the step.
    fn right_side_of_newton(&mut self, field: &mut GroupField<'_, T>, v: &[Row<T>]) {
        self.q.fill([T::ZERO; 4]);
        let mut called = std::mem::take(&mut self.q);
        field.call_at_end(&self.x, v, &mut called);
        for (row, called) in called[..field.movable()].iter_mut().enumerate() {
            let rate = field.class(row).rate;
            (0..3).for_each(|axis| called[axis] = called[axis] - rate * v[row][axis]);
        }
        let before = std::mem::take(&mut self.before);
        self.right_side(field, &called, |row, axis| before[row][axis] - v[row][axis]);
        (self.q, self.before) = (called, before);
    }

    fn right_side(
        &mut self,
        field: &GroupField<'_, T>,
        called: &[Row<T>],
        change: impl Fn(usize, usize) -> T,
    ) {
        let h = field.length();
        let (r, forces): (&mut [Row<T>], &[Row<T>]) = (&mut self.r, &self.forces);
        for row in 0..field.movable() {
            let (root, locks) = (self.root[row], field.class(row).locks);
            for axis in 0..3 {
                r[row][axis] = if root > T::ZERO && is_open(locks, axis) {
                    h * root * forces[row][axis] + (h * called[row][axis] + change(row, axis)) / root
                } else {
                    T::ZERO
                };
            }
        }
    }

    /// Conjugate gradients from 0 (Hestenes, Stiefel 1952); adds the solution to `v`, and to `gain` if there is one. A
    /// guess other than 0 would have to be one that keeps momentum.
    fn iterate(&mut self, field: &mut GroupField<'_, T>, v: &mut [Row<T>], mut gain: Option<&mut [Row<T>]>) {
        let movable = field.movable();
        let solver = field.solver();
        let least = if T::WIDE { 0.0 } else { 1e-5 };
        let tolerance = T::of(solver.tolerance.max(least));
        self.y.fill([T::ZERO; 4]);
        self.p.copy(&self.r);
        let mut squared = dot(&self.r[..movable], &self.r[..movable]);
        let enough = squared * tolerance * tolerance;
        let (mut iterations, mut converged) = (0, squared == T::ZERO);
        if !squared.is_finite() {
            // Told by the velocities; those that have nothing to do with it stay as they are.
            for sum in [Some(&mut *v), gain.as_deref_mut()].into_iter().flatten() {
                for (v, r) in sum[..movable].iter_mut().zip(self.r.iter()) {
                    (0..3).filter(|axis| !r[*axis].is_finite()).for_each(|axis| v[axis] = r[axis]);
                }
            }
            field.look(|field| field.broken(&self.r).collect());
        }
        while !converged && iterations < solver.most_iterations.max(1) {
            self.multiply(field);
            let curvature = dot(&self.p[..movable], &self.q[..movable]);
            // Not finite, or rounding has eaten it up.
            if !(curvature > T::ZERO && curvature.is_finite()) {
                break;
            }
            let step = squared / curvature;
            advance(&mut self.y[..movable], &self.p, step);
            advance(&mut self.r[..movable], &self.q, -step);
            iterations += 1;
            let left = dot(&self.r[..movable], &self.r[..movable]);
            converged = left.is_at_most(enough);
            let keep = left / squared;
            for (p, r) in self.p[..movable].as_flattened_mut().iter_mut().zip(self.r.as_flattened()) {
                *p = *r + *p * keep;
            }
            squared = left;
        }
        for sum in [Some(v), gain].into_iter().flatten() {
            for ((v, y), root) in sum[..movable].iter_mut().zip(self.y.iter()).zip(&self.root) {
                (0..3).for_each(|axis| v[axis] += y[axis] * *root);
            }
        }
        // What is next to nothing has a square that is nothing: there is no tolerance to get below.
        field.report_solve(iterations, converged || squared < T::SNAP);
    }

    /// `q = A p`, without a matrix.
    fn multiply(&mut self, field: &GroupField<'_, T>) {
        let (h, movable) = (field.length(), field.movable());
        let locked = field.any_locks();
        // Once: finding where an array begins is more than what is done to a row.
        let Self { springs, sheets, local, root, forces, p, q, scaled, .. } = self;
        let (forces, scaled): (&mut [Row<T>], &mut [Row<T>]) = (forces, scaled);
        let (p, q): (&[Row<T>], &mut [Row<T>]) = (p, q);
        for ((scaled, p), root) in scaled[..movable].iter_mut().zip(p).zip(&*root) {
            (0..3).for_each(|axis| scaled[axis] = p[axis] * *root);
        }
        forces.fill([T::ZERO; 4]);
        for stiff in &*springs {
            let [a, b] = stiff.ends.map(|end| end as usize);
            let d = vector(&scaled[b]) - vector(&scaled[a]);
            let change = stiff.change(d, stiff.along + stiff.damping);
            add(&mut forces[a], -change);
            add(&mut forces[b], change);
        }
        for (SheetRow { corners, .. }, (n, strength)) in field.sheets().iter().zip(&*sheets) {
            let [a, b, c] = corners.map(|corner| vector(&scaled[corner as usize]));
            let ninth = T::of(1.0 / 9.0);
            let change = *n * (*strength * n.dot(a + b + c) * ninth);
            corners.iter().for_each(|corner| add(&mut forces[*corner as usize], change));
        }
        for row in 0..movable {
            let (root, rate) = (root[row], field.class(row).rate);
            let locks = if locked { field.class(row).locks } else { None };
            let local = match local.get(row) {
                Some((local, _)) => local.times(vector(&p[row])).to_array(),
                None => [T::ZERO; 3],
            };
            for axis in 0..3 {
                let part = p[row][axis];
                q[row][axis] = if is_open(locks, axis) {
                    part + root * forces[row][axis] + (rate * h) * part + local[axis]
                } else {
                    part
                };
            }
        }
    }
}

impl<T: Real> Stiff<T> {
    /// The force on the first end, times h², where the second moves away by `d`, with `along` along the axis.
    fn change(&self, d: T::Vector, along: T) -> T::Vector {
        d * self.across + self.n * (self.n.dot(d) * (along - self.across))
    }
}

fn dot<T: Real>(a: &[Row<T>], b: &[Row<T>]) -> T {
    // In four sums, one a lane, always in the same order.
    let mut sums = [T::ZERO; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums[0] + sums[1] + sums[2]
}

fn advance<T: Real>(sum: &mut [Row<T>], by: &[Row<T>], factor: T) {
    for (sum, by) in sum.as_flattened_mut().iter_mut().zip(by.as_flattened()) {
        *sum += *by * factor;
    }
}

/// The symmetric part of a derivative if it has no positive eigenvalue, and zero if it has one.
fn pulling_together<T: Real>(derivative: T::Matrix) -> T::Matrix {
    let unit = |axis: usize| {
        let mut unit = [T::ZERO; 3];
        unit[axis] = T::ONE;
        T::Vector::from_array(unit)
    };
    let columns = [0, 1, 2].map(|axis| derivative.times(unit(axis)).to_array());
    let half = T::of(0.5);
    let s = |i: usize, j: usize| -((columns[i][j] + columns[j][i]) * half);
    let minor = |i: usize, j: usize| s(i, i) * s(j, j) - s(i, j) * s(i, j);
    let cross = |i: usize, j: usize, k: usize| s(i, j) * s(j, k) - s(j, j) * s(i, k);
    let whole =
        s(0, 0) * minor(1, 2) - s(0, 1) * (s(0, 1) * s(2, 2) - s(1, 2) * s(0, 2)) + s(0, 2) * cross(0, 1, 2);
    let minors = [s(0, 0), s(1, 1), s(2, 2), minor(0, 1), minor(1, 2), minor(0, 2), whole];
    // Sylvester: of a semidefinite matrix every principal minor is at least 0.
    if minors.iter().all(|minor| *minor >= T::ZERO) {
        let column = |j: usize| T::Vector::from_array([0, 1, 2].map(|i| -s(i, j)));
        T::Matrix::from_columns([0, 1, 2].map(column))
    } else {
        T::Matrix::ZERO
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    #[test]
    fn a_derivative_is_taken_in_where_it_pulls_together() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
        let with =
            |a: f64, b: f64, c: f64| turn * DMat3::from_diagonal(DVec3::new(a, b, c)) * turn.transpose();
        for (matrix, taken) in [
            (with(-1.0, -2.0, -3.0), true),
            (with(-1.0, -2.0, 0.1), false),
            (with(2.0, -1.0, -1.0), false),
            (with(1.0, 2.0, -3.0), false),
            (DMat3::ZERO, true),
        ] {
            let part = pulling_together::<f64>(matrix);
            let expected = if taken { matrix } else { DMat3::ZERO };
            assert!(part.abs_diff_eq(expected, 1e-12), "{matrix}: {part}");
        }
    }
}
