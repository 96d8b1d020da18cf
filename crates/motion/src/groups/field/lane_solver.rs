//! Implicit Euler steps of several groups of one shape: conjugate gradients of four groups at a time.
//!
//! Each lane performs the operations of [`Workspace`](super::solving::Workspace) in the same order, and stays unchanged once it
//! has converged or rounding has ended its iteration. Groups with called laws, or that continue by Newton's method, are not
//! solved here.

use fearless_simd::{Simd, SimdBase, f64x4, prelude::*};

use super::GroupField;
use super::classes::Class;
use crate::groups::coupling::is_open;
use crate::groups::lanes::{differences, four, three};
use crate::groups::pull::{AT_ONCE, axes, stiffnesses};
use crate::groups::rows::Array;
use crate::groups::solver::{LEAST_SQUARED_RESIDUAL, Solver};
use crate::kernels::evaluations::Iterations;
use crate::laws::{Axes, BLOCK_BODIES};
use crate::methods::Field as _;
use crate::simd::{Lanes as _, with_simd};

/// Arrays of a solve, reused for the next one.
#[derive(Debug, Default)]
pub(crate) struct LaneSolver {
    /// Forces of the springs of all groups, N.
    pub forces: Array<Axes>,
    /// The rows of four groups, anchors included.
    rows: Vec<SolverRow>,
    /// The springs of four groups.
    springs: Vec<SolverSpring>,
}

type Mask<S> = <f64x4<S> as SimdBase<S>>::Mask;

/// Three numbers of four groups.
type Vectors = [[f64; AT_ONCE]; 3];

/// The place of four groups: their block, and the first of their lanes in it.
#[derive(Clone, Copy)]
struct Four {
    block: usize,
    lane: usize,
}

/// A row of four groups.
#[derive(Clone, Copy, Debug, Default)]
struct SolverRow {
    /// Square roots of the inverse masses; 0 for an anchor.
    root: [f64; AT_ONCE],
    /// Rate of linear drag, 1/s.
    rate: f64,
    /// `rate` times the length of the step.
    rate_in_step: f64,
    /// The axes along which the row can move.
    open: [bool; 3],
    /// The solution, the residual, and the direction of conjugate gradients.
    y: Vectors,
    r: Vectors,
    p: Vectors,
    /// The direction as velocities.
    moved: Vectors,
    /// Forces; then the product with the direction.
    q: Vectors,
}

/// A linearized spring of four groups.
#[derive(Clone, Copy, Debug)]
struct SolverSpring {
    ends: [usize; 2],
    /// Unit vectors from the first end to the second.
    n: Vectors,
    /// The [stiffnesses] in a step, kg: across the axis, and along minus across.
    stiffnesses: [[f64; AT_ONCE]; 2],
}

impl LaneSolver {
    /// Replaces the velocities `v`, kicked by constant accelerations, by those at the end of the step, given the forces of the
    /// springs, N. Adds to the iterations of each group.
    pub fn solve(
        &mut self,
        field: &GroupField<'_, Axes>,
        forces: &[Axes],
        v: &mut [Axes],
        iterations: &mut [Iterations],
    ) {
        for (number, iterations) in iterations.chunks_mut(AT_ONCE).enumerate() {
            let first = number * AT_ONCE;
            let at = Four { block: first / BLOCK_BODIES, lane: first % BLOCK_BODIES };
            with_simd!(simd => self.solve_four(simd, field, at, forces, v, iterations));
        }
    }

    /// [`Self::solve`] for four groups.
    #[inline(always)]
    fn solve_four<S: Simd>(
        &mut self,
        simd: S,
        field: &GroupField<'_, Axes>,
        at: Four,
        forces: &[Axes],
        v: &mut [Axes],
        iterations: &mut [Iterations],
    ) {
        self.linearize(simd, field, at, forces, v);
        let squared = self.right_side(simd, field, at, v);
        let movable = field.coupling.movable;
        let (count, converged) = self.iterate(simd, field.environment.solver, movable, squared);
        let (count, converged): ([f64; AT_ONCE], [i64; AT_ONCE]) = (count.into(), converged.into());
        for (iterations, (count, converged)) in
            iterations.iter_mut().zip(count.into_iter().zip(converged))
        {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
            let count = count as u64;
            iterations.cg += count;
            iterations.unconverged_steps += u64::from(converged == 0);
        }
        let most = f64x4::splat(simd, f64::MAX);
        let is_finite = squared.simd_le(most);
        for (number, row) in self.rows[..movable].iter().enumerate() {
            let v = &mut v[number * field.width + at.block];
            let root = f64x4::simd_from(simd, row.root);
            let (y, r) = (of(simd, &row.y), of(simd, &row.r));
            for axis in 0..3 {
                // A right side that is not finite goes into the velocity, to be found.
                let keeps = is_finite | r[axis].abs().simd_le(most);
                let sum = keeps.select(four(simd, at.lane, &v[axis]), r[axis]) + y[axis] * root;
                sum.store_slice(&mut v[axis][at.lane..at.lane + AT_ONCE]);
            }
        }
    }

    /// Sets up the rows and linearizes the springs. Their forces become `f - h K v`: those at the end of the step if no body were
    /// accelerated.
    #[inline(always)]
    fn linearize<S: Simd>(
        &mut self,
        simd: S,
        field: &GroupField<'_, Axes>,
        Four { block, lane }: Four,
        forces: &[Axes],
        v: &[Axes],
    ) {
        let (h, x) = (field.step(), &field.rows.x);
        self.rows.clear();
        self.springs.clear();
        for row in 0..field.coupling.rows {
            let mut of_row = SolverRow::default();
            if row < field.coupling.movable {
                let element = row * field.width + block;
                let Class { rate, locks, .. } = *field.class(row);
                let w = f64x4::from_slice(
                    simd,
                    &field.rows.w[element * BLOCK_BODIES + lane..][..AT_ONCE],
                );
                of_row.root = w.sqrt().only(w.simd_gt(f64x4::splat(simd, 0.0))).into();
                (of_row.rate, of_row.rate_in_step) = (rate, rate * h);
                of_row.open = [0, 1, 2].map(|axis| is_open(locks, axis));
                of_row.q = three(simd, lane, &forces[element]).map(Into::into);
            }
            self.rows.push(of_row);
        }
        let of_block = field.rows.springs.of_block(block);
        for (spring, elastic) in field.coupling.springs.iter().zip(of_block) {
            let ends = spring.ends.map(|end| end as usize);
            let [a, b] = ends.map(|end| end * field.width + block);
            let elastic = elastic.four(simd, lane);
            let (d, u) =
                (differences(simd, lane, [&x[a], &x[b]]), differences(simd, lane, [&v[a], &v[b]]));
            let [inverse, taut] = axes(simd, d, elastic.rest_length);
            let n = [d[0] * inverse, d[1] * inverse, d[2] * inverse];
            let without_damping = stiffnesses(simd, elastic, taut, h * h, 0.0);
            self.pull(simd, ends, pulls(n, u, without_damping, f64x4::splat(simd, 1.0 / h)));
            let stiffnesses = stiffnesses(simd, elastic, taut, h * h, h).map(Into::into);
            self.springs.push(SolverSpring { ends, n: n.map(Into::into), stiffnesses });
        }
    }

    /// Adds forces to those on the first end of a spring, and subtracts them from those on the second.
    #[inline(always)]
    fn pull<S: Simd>(&mut self, simd: S, [a, b]: [usize; 2], pulls: [f64x4<S>; 3]) {
        let (sum, [x, y, z]) = (of(simd, &self.rows[a].q), pulls);
        self.rows[a].q = [sum[0] + x, sum[1] + y, sum[2] + z].map(Into::into);
        let sum = of(simd, &self.rows[b].q);
        self.rows[b].q = [sum[0] - x, sum[1] - y, sum[2] - z].map(Into::into);
    }

    /// Sets residual and direction to the right side, `h W^½ f - h W^-½ c v` from the forces. Returns the sum of its squares.
    #[inline(always)]
    fn right_side<S: Simd>(
        &mut self,
        simd: S,
        field: &GroupField<'_, Axes>,
        Four { block, lane }: Four,
        v: &[Axes],
    ) -> f64x4<S> {
        let splat = |number: f64| f64x4::splat(simd, number);
        let (h, zero) = (splat(field.step()), splat(0.0));
        let mut squares = [zero; 3];
        for (number, row) in self.rows[..field.coupling.movable].iter_mut().enumerate() {
            let root = f64x4::simd_from(simd, row.root);
            let v = &v[number * field.width + block];
            for axis in (0..3).filter(|axis| row.open[*axis]) {
                let a = zero - splat(row.rate) * four(simd, lane, &v[axis]);
                let force = f64x4::simd_from(simd, row.q[axis]);
                let r = (h * root * force + (h * a + zero) / root).only(root.simd_gt(zero));
                squares[axis] += r * r;
                (row.r[axis], row.p[axis]) = (r.into(), r.into());
            }
        }
        squares[0] + squares[1] + squares[2]
    }

    /// [`ConjugateGradients::solve`](crate::groups::solver::ConjugateGradients::solve) for a right side with this sum of
    /// squares. Returns the iterations of each group, and which ones converged.
    #[inline(always)]
    fn iterate<S: Simd>(
        &mut self,
        simd: S,
        solver: Solver,
        movable: usize,
        mut squared: f64x4<S>,
    ) -> (f64x4<S>, Mask<S>) {
        let splat = |number: f64| f64x4::splat(simd, number);
        let (zero, one, tolerance) = (splat(0.0), splat(1.0), splat(solver.tolerance));
        let enough = squared * tolerance * tolerance;
        let mut iterations = zero;
        let mut converged = squared.simd_eq(zero);
        let mut active = !converged;
        for _ in 0..solver.most_iterations.max(1) {
            if !active.any_true() {
                break;
            }
            let curvature = self.multiply(simd, movable);
            // Stop a lane whose curvature is not finite or lost to rounding.
            active &= curvature.simd_gt(zero) & curvature.simd_le(splat(f64::MAX));
            let step = squared / curvature;
            let mut squares = [zero; 3];
            for row in &mut self.rows[..movable] {
                let (y, r) = (of(simd, &row.y), of(simd, &row.r));
                let (p, q) = (of(simd, &row.p), of(simd, &row.q));
                for axis in 0..3 {
                    row.y[axis] = active.select(y[axis] + p[axis] * step, y[axis]).into();
                    let r = active.select(r[axis] + q[axis] * -step, r[axis]);
                    row.r[axis] = r.into();
                    squares[axis] += r * r;
                }
            }
            iterations += one.only(active);
            let left = squares[0] + squares[1] + squares[2];
            converged |= active & left.simd_le(enough);
            let keep = left / squared;
            for row in &mut self.rows[..movable] {
                let (r, p) = (of(simd, &row.r), of(simd, &row.p));
                for axis in 0..3 {
                    row.p[axis] = (r[axis] + p[axis] * keep).into();
                }
            }
            squared = active.select(left, squared);
            active &= !converged;
        }
        (iterations, converged | squared.simd_lt(splat(LEAST_SQUARED_RESIDUAL)))
    }

    /// Sets `q = A p`. Returns the product of p and q.
    #[inline(always)]
    fn multiply<S: Simd>(&mut self, simd: S, movable: usize) -> f64x4<S> {
        let (zero, minus_one) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, -1.0));
        for row in &mut self.rows[..movable] {
            let root = f64x4::simd_from(simd, row.root);
            for axis in 0..3 {
                row.moved[axis] = (f64x4::simd_from(simd, row.p[axis]) * root).into();
            }
            row.q = Vectors::default();
        }
        for number in 0..self.springs.len() {
            let SolverSpring { ends, n, stiffnesses } = self.springs[number];
            let [a, b] = ends.map(|end| of(simd, &self.rows[end].moved));
            let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let stiffnesses = stiffnesses.map(|numbers| f64x4::simd_from(simd, numbers));
            self.pull(simd, ends, pulls(of(simd, &n), u, stiffnesses, minus_one));
        }
        let mut products = [zero; 3];
        for row in &mut self.rows[..movable] {
            let (root, rate) =
                (f64x4::simd_from(simd, row.root), f64x4::splat(simd, row.rate_in_step));
            let (p, q) = (of(simd, &row.p), of(simd, &row.q));
            for axis in 0..3 {
                let product = match row.open[axis] {
                    true => p[axis] + root * q[axis] + rate * p[axis] + zero,
                    false => p[axis],
                };
                products[axis] += p[axis] * product;
                row.q[axis] = product.into();
            }
        }
        products[0] + products[1] + products[2]
    }
}

#[inline(always)]
fn of<S: Simd>(simd: S, [x, y, z]: &Vectors) -> [f64x4<S>; 3] {
    [f64x4::simd_from(simd, *x), f64x4::simd_from(simd, *y), f64x4::simd_from(simd, *z)]
}

/// Changes of the forces on the first ends of linearized springs whose second ends move by `u` relative to the first,
/// multiplied by `times`.
#[inline(always)]
fn pulls<S: Simd>(
    n: [f64x4<S>; 3],
    u: [f64x4<S>; 3],
    [across, beyond]: [f64x4<S>; 2],
    times: f64x4<S>,
) -> [f64x4<S>; 3] {
    let beyond = (n[0] * u[0] + n[1] * u[1] + n[2] * u[2]) * beyond;
    [
        (u[0] * across + n[0] * beyond) * times,
        (u[1] * across + n[1] * beyond) * times,
        (u[2] * across + n[2] * beyond) * times,
    ]
}
