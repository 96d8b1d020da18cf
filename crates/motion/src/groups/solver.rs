//! Conjugate gradients over plain rows, and their settings.

use bevy_ecs::prelude::*;

use super::rows::{Row, RowArray};
use crate::state::threads::Threads;

/// The solver of implicit Euler steps of groups (Baraff, Witkin 1998, eq. 6, in inverse-mass form):
/// `(1 + h W^½ D W^½ + h² W^½ K W^½) y = h W^½ (f - h K v)`, `v1 = v + W^½ y`, with the stiffness K and the damping D of the
/// springs at the start of the step. The system is linear; its matrix is symmetric and positive definite with eigenvalues of
/// at least 1, and the equation of a row of inverse mass 0 is `y = 0`.
///
/// Gravity is a kick before the solve. A spring that is shorter than at rest has no stiffness across its axis, which would
/// be negative (Choi, Ko 2002). Derivatives of laws of single bodies are included if they are attractive; repulsive laws and
/// mutual gravity act as at the start of the step. The masses are the only preconditioner, because no other one keeps
/// momentum when the iteration is stopped early.
///
/// If a called law depends on the state of a body, Newton's method continues from this solution until it converges, as it
/// does for single bodies, with the exact derivatives of all forces but mutual gravity. Their matrix is neither symmetric nor
/// definite: generalized conjugate residuals solve it, with the definite matrix above as preconditioner.
///
/// Springs and air alone are solved by one linear solve, which is not stable for every stiffness: a chain of twenty links
/// of 1e8 N/m and 1 kg that cracks like a whip at 60 Hz gains energy, and with five Newton iterations it does not
/// (`tests/groups/implicit.rs`).
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Norm of the residual, relative to that of the right side, at which the iteration stops.
    pub tolerance: f64,
    /// Most iterations: after them the step uses the last iterate and counts as not converged; at least 1.
    pub most_iterations: u32,
    /// Largest number of Newton iterations after the linearized step of a group without laws that depend on the state of a
    /// body. With such laws it is at least [`MOST_ITERATIONS`](crate::methods::MOST_ITERATIONS).
    pub newton_iterations: u32,
}

impl Default for Solver {
    /// Linearized, to 1e-8, in at most 500 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-8, most_iterations: 500, newton_iterations: 0 }
    }
}

/// Most directions that generalized conjugate residuals keep before they restart.
const KEPT_DIRECTIONS: usize = 10;
/// Most directions of generalized conjugate residuals in all.
const MOST_DIRECTIONS: usize = 60;
/// Squared residual below which every solve has converged: the square of a tiny residual underflows to 0.
pub(super) const LEAST_SQUARED_RESIDUAL: f64 = 1e-290;

/// The matrix of an implicit step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StepMatrix {
    /// Symmetric and positive definite: without the parts of the derivatives that would make it otherwise.
    Definite,
    /// With the exact derivatives.
    Exact,
}

/// Arrays of an iteration for `A y = r`, reused for the next one.
#[derive(Debug, Default)]
pub(super) struct ConjugateGradients {
    /// The solution.
    pub y: RowArray,
    /// The right side, then the residual.
    pub r: RowArray,
    /// The direction.
    p: RowArray,
    /// The product with the direction; scratch space between two solves.
    pub q: RowArray,
    /// Directions of [`ConjugateGradients::solve_indefinite`], each with its product, which has length 1.
    directions: Vec<[RowArray; 2]>,
    /// Solution and residual of [`ConjugateGradients::solve_indefinite`].
    whole: [RowArray; 2],
}

/// How a solve ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub iterations: u32,
    pub converged: bool,
    /// Whether the right side was finite; if not, the solution is 0.
    pub is_finite: bool,
}

impl ConjugateGradients {
    /// Resizes the arrays to `rows`, all 0.
    pub fn fit(&mut self, rows: usize) {
        for array in [&mut self.y, &mut self.r, &mut self.p, &mut self.q] {
            array.resize(rows);
            array.fill([0.0; 4]);
        }
    }

    /// Solves `A y = r` for the first `movable` rows, starting at y = 0 (Hestenes, Stiefel 1952). The caller has put the
    /// right side into `r`; the solution is in `y`. `multiply(p, q)` writes A p into q. Another start would have to
    /// conserve momentum.
    pub fn solve(
        &mut self,
        solver: Solver,
        movable: usize,
        threads: Option<&Threads>,
        mut multiply: impl FnMut(&[Row], &mut [Row]),
    ) -> Solved {
        let tolerance = solver.tolerance;
        self.y.fill([0.0; 4]);
        self.p.copy(&self.r);
        let dot = |a: &[Row], b: &[Row]| dot_shared(threads, &a[..movable], &b[..movable]);
        let mut squared = dot(&self.r, &self.r);
        let is_finite = squared.is_finite();
        let enough = squared * tolerance * tolerance;
        let (mut iterations, mut converged) = (0, squared == 0.0);
        while !converged && iterations < solver.most_iterations.max(1) {
            multiply(&self.p, &mut self.q);
            let curvature = dot(&self.p, &self.q);
            // Stop if it is not finite or lost to rounding.
            if !(curvature > 0.0 && curvature.is_finite()) {
                break;
            }
            let step = squared / curvature;
            let (y, r, p, q) = (&mut self.y[..movable], &mut self.r[..movable], &self.p, &self.q);
            Threads::share_two(threads, y, r, |first, y, r| {
                add_scaled(y, &p[first..], step);
                add_scaled(r, &q[first..], -step);
            });
            iterations += 1;
            let left = dot(&self.r, &self.r);
            converged = left <= enough;
            let keep = left / squared;
            let r = &self.r;
            Threads::share(threads, &mut self.p[..movable], |first, p| {
                for (p, r) in p.as_flattened_mut().iter_mut().zip(r[first..].as_flattened()) {
                    *p = *r + *p * keep;
                }
            });
            squared = left;
        }
        Solved { iterations, converged: converged || squared < LEAST_SQUARED_RESIDUAL, is_finite }
    }

    /// [`ConjugateGradients::solve`] for the exact matrix, which need not be symmetric or definite; the definite one is the
    /// preconditioner (generalized conjugate residuals: Eisenstat, Elman, Schultz 1983). `multiply` multiplies by either.
    pub fn solve_indefinite(
        &mut self,
        solver: Solver,
        movable: usize,
        threads: Option<&Threads>,
        mut multiply: impl FnMut(StepMatrix, &[Row], &mut [Row]),
    ) -> Solved {
        let [mut sum, mut left] = std::mem::take(&mut self.whole);
        let mut directions = std::mem::take(&mut self.directions);
        sum.resize(self.r.len());
        sum.fill([0.0; 4]);
        left.copy(&self.r);
        let tolerance = solver.tolerance;
        let enough = dot(&left[..movable], &left[..movable]) * tolerance * tolerance;
        let mut all = Solved { iterations: 0, converged: false, is_finite: true };
        for number in 0..MOST_DIRECTIONS {
            self.r.copy(&left);
            let Solved { iterations, is_finite, .. } =
                self.solve(solver, movable, threads, |p, q| multiply(StepMatrix::Definite, p, q));
            all.iterations += iterations;
            all.is_finite &= is_finite;
            multiply(StepMatrix::Exact, &self.y, &mut self.q);
            let (y, q) = (&mut self.y[..movable], &mut self.q[..movable]);
            let kept = number % KEPT_DIRECTIONS;
            for [direction, product] in &directions[..kept] {
                let share = dot(product, q);
                add_scaled(y, direction, -share);
                add_scaled(q, product, -share);
            }
            let length = dot(q, q).sqrt();
            // Stop if it is not finite or lost to rounding.
            if !(length > 0.0 && length.is_finite()) {
                break;
            }
            for part in [&mut *y, &mut *q].into_iter().flat_map(<[Row]>::as_flattened_mut) {
                *part *= 1.0 / length;
            }
            let share = dot(&left[..movable], q);
            add_scaled(&mut sum[..movable], y, share);
            add_scaled(&mut left[..movable], q, -share);
            let squared = dot(&left[..movable], &left[..movable]);
            all.converged = squared <= enough || squared < LEAST_SQUARED_RESIDUAL;
            if all.converged {
                break;
            }
            if directions.len() == kept {
                directions.push(<[RowArray; 2]>::default());
            }
            let [direction, product] = &mut directions[kept];
            direction.copy(y);
            product.copy(q);
        }
        self.y.copy(&sum);
        self.whole = [sum, left];
        self.directions = directions;
        all
    }
}

/// Number of rows per partial sum of products. It is fixed, so that the total does not depend on the threads.
const SUMMED_ROWS: usize = 4096;

/// The sum of the products of two arrays.
pub(super) fn dot(a: &[Row], b: &[Row]) -> f64 {
    dot_shared(None, a, b)
}

/// [`dot`] on all threads, with the same bits.
fn dot_shared(threads: Option<&Threads>, a: &[Row], b: &[Row]) -> f64 {
    // Four sums, one per lane, always in the same order.
    let add = |mut sums: [f64; 4], part: [f64; 4]| {
        (0..4).for_each(|lane| sums[lane] += part[lane]);
        sums
    };
    let sum_of = |first: usize| {
        let mut sums = [0.0; 4];
        for (a, b) in a[first..].iter().zip(&b[first..]).take(SUMMED_ROWS) {
            (0..4).for_each(|lane| sums[lane] += a[lane] * b[lane]);
        }
        sums
    };
    let starts = (0..a.len()).step_by(SUMMED_ROWS);
    let [x, y, z, _] = match threads {
        None => starts.map(sum_of).fold([0.0; 4], add),
        Some(_) => {
            let mut parts = vec![[0.0; 4]; starts.len()];
            Threads::share(threads, &mut parts, |first, parts| {
                let parts = parts.iter_mut().zip(first..);
                parts.for_each(|(part, number)| *part = sum_of(number * SUMMED_ROWS));
            });
            parts.into_iter().fold([0.0; 4], add)
        }
    };
    x + y + z
}

/// Adds `factor` times `by` to `sum`.
pub(super) fn add_scaled(sum: &mut [Row], by: &[Row], factor: f64) {
    for (sum, by) in sum.as_flattened_mut().iter_mut().zip(by.as_flattened()) {
        *sum += *by * factor;
    }
}
