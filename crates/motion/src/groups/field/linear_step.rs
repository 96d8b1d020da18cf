//! An implicit Euler step of a group, linearized: the matrix that its solver multiplies by.

use glam::DMat3;

use super::GroupField;
use crate::groups::coupling::{SheetRow, add, in_air, is_open, rate_along};
use crate::groups::pull::{AxisBlock, Linearized, SpringRow, axis};
use crate::groups::rows::{Row, RowArray};
use crate::groups::solver::StepMatrix;
use crate::kernels::record::vector;
use crate::laws::{BodyState, EvaluationTime, Jacobians, Law};
use crate::methods::Field as _;
use crate::state::components::AxisLocks;
use crate::state::threads::Threads;
use crate::units::Vector;

/// Derivatives of the called laws of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// `-h da/dv - h² da/dx` of attractive laws.
    attractive: DMat3,
    /// `-h da/dv - h² da/dx` of all laws, minus `attractive`.
    rest: DMat3,
    /// `h da/dx` of attractive laws.
    pub moved: DMat3,
}

/// Derivatives of the forces on a group by its state: the matrix `1 + h W^½ D W^½ + h² W^½ K W^½` of
/// [`Solver`](crate::groups::Solver), and what it lacks of the exact one.
#[derive(Debug, Default)]
pub(super) struct LinearStep {
    axes: Vec<AxisBlock>,
    /// Normal n and `h m (c + k |u| + k (u·n)² / |u|)`, kg, of triangles in air: the derivative along n.
    sheets: Vec<(Vector, f64)>,
    /// The called laws by row, if there are any.
    pub local: Vec<Local>,
    /// Springs that are shorter than at rest: their ends, their directions, and `h² k (1 - L0 / L)`, kg, which is negative.
    compressed: Vec<([u32; 2], Vector, f64)>,
    /// Square roots of inverse masses.
    pub root: Vec<f64>,
    /// Forces of the coupling, N.
    pub forces: RowArray,
    scaled: RowArray,
}

impl LinearStep {
    /// Resizes the arrays to `rows`; `movable` are the inverse masses of the movable rows.
    pub fn fit(&mut self, rows: usize, movable: &[f64]) {
        for array in [&mut self.forces, &mut self.scaled] {
            array.resize(rows);
            array.fill([0.0; 4]);
        }
        self.root.clear();
        self.root.extend(movable.iter().map(|w| if *w > 0.0 { w.sqrt() } else { 0.0 }));
    }

    /// Computes the derivatives of springs and air for a step in the state `x`, `v`, without those of called laws. For
    /// the exact matrix, also those of the forces across springs that are shorter than at rest.
    pub fn linearize(&mut self, field: &GroupField<'_>, x: &[Row], v: &[Row], matrix: StepMatrix) {
        let (h, springs) = (field.step(), field.springs());
        springs.find_axes(field.threads, x, &mut self.axes);
        self.compressed.clear();
        if matrix == StepMatrix::Exact {
            self.compressed.extend(springs.iter().filter_map(|SpringRow { ends, elastic }| {
                let [a, b] = ends.map(|end| vector(&x[end as usize]));
                let (n, taut) = axis(b - a, elastic.rest_length);
                (taut < 0.0).then_some((ends, n, h * h * elastic.stiffness * taut))
            }));
        }
        self.sheets.clear();
        if let Some(drag) = field.environment.shared.laws.drag {
            let air = drag.wind.map(|wind| wind.air(field.end().time));
            let sheets = field.coupling.sheets.iter();
            self.sheets.extend(sheets.map(|&SheetRow { corners, mass }| {
                match in_air(air.as_ref(), corners, x, v) {
                    Some((u, n)) => (n, h * mass * rate_along(drag, u, n)),
                    None => (Vector::ZERO, 0.0),
                }
            }));
        }
        self.local.clear();
    }

    /// Makes room for the derivatives of laws that are called for single rows.
    pub fn expect_laws(&mut self) {
        let zero = DMat3::ZERO;
        self.local.resize(self.root.len(), Local { attractive: zero, rest: zero, moved: zero });
    }

    /// Adds the derivatives of a law that is called for a row in a step of `h` seconds. Returns whether any of them is
    /// not zero.
    pub fn add_law(
        &mut self,
        row: usize,
        law: &dyn Law,
        at: EvaluationTime,
        h: f64,
        body: BodyState,
    ) -> bool {
        if body.inverse_mass <= 0.0 {
            return false;
        }
        let Jacobians { position, velocity } = law.jacobians(at, body);
        let [by_x, by_v] = [position, velocity].map(attractive_part);
        let Local { attractive, rest, moved } = self.local[row];
        let rest = rest - (velocity - by_v) * h - (position - by_x) * (h * h);
        let attractive = attractive - by_v * h - by_x * (h * h);
        self.local[row] = Local { attractive, rest, moved: moved + by_x * h };
        let is_zero = |matrix: DMat3| columns(matrix).as_flattened().iter().all(|x| *x == 0.0);
        !(is_zero(position) && is_zero(velocity))
    }

    /// Adds the change of the spring forces in a step at the velocities `v`, linearized at the positions `x`: the forces
    /// become `f - h K v`.
    pub fn add_moves_of_springs(&mut self, field: &GroupField<'_>, x: &[Row], v: &[Row]) {
        let h = field.step();
        let change = Linearized {
            x,
            axes: Some(&self.axes),
            moves: v,
            stiffness: h * h,
            damping: 0.0,
            times: 1.0 / h,
        };
        field.springs().add(field.shares(), &change, &mut self.forces);
    }

    /// Computes `q = A p` without a matrix, with springs at the positions `x`; `row_terms` returns the rate of linear drag and
    /// the locks of a row. A is `matrix`.
    pub fn multiply(
        &mut self,
        field: &GroupField<'_>,
        x: &[Row],
        row_terms: impl Fn(usize) -> (f64, Option<AxisLocks>) + Sync,
        matrix: StepMatrix,
        p: &[Row],
        q: &mut [Row],
    ) {
        let h = field.step();
        // Once: dereferencing an array costs more than the work on a row.
        let Self { axes, sheets: normals, local, compressed, root, forces, scaled } = self;
        let (forces, scaled): (&mut [Row], &mut [Row]) = (forces, scaled);
        let movable = root.len();
        for ((scaled, p), root) in scaled[..movable].iter_mut().zip(p).zip(&*root) {
            (0..3).for_each(|axis| scaled[axis] = p[axis] * *root);
        }
        forces.fill([0.0; 4]);
        let axes = Some(&axes[..]);
        let change =
            Linearized { x, axes, moves: scaled, stiffness: h * h, damping: h, times: -1.0 };
        field.springs().add(field.shares(), &change, forces);
        for (ends, n, across) in compressed.iter().take_while(|_| matrix == StepMatrix::Exact) {
            let [a, b] = ends.map(|end| end as usize);
            let d = vector(&scaled[b]) - vector(&scaled[a]);
            let change = (d - *n * n.dot(d)) * *across;
            add(&mut forces[a], -change);
            add(&mut forces[b], change);
        }
        for (SheetRow { corners, .. }, (n, strength)) in field.coupling.sheets.iter().zip(&*normals)
        {
            let [a, b, c] = corners.map(|corner| vector(&scaled[corner as usize]));
            let ninth = 1.0 / 9.0;
            let change = *n * (*strength * n.dot(a + b + c) * ninth);
            corners.iter().for_each(|corner| add(&mut forces[*corner as usize], change));
        }
        let threads = field.shares().map(|(threads, _)| threads);
        Threads::share(threads, &mut q[..movable], |first, q| {
            for (row, q) in (first..).zip(q) {
                let (root, (rate, locks)) = (root[row], row_terms(row));
                let local = match local.get(row) {
                    Some(Local { attractive, rest, .. }) if matrix == StepMatrix::Exact => {
                        ((*attractive + *rest) * vector(&p[row])).to_array()
                    }
                    Some(Local { attractive, .. }) => (*attractive * vector(&p[row])).to_array(),
                    None => [0.0; 3],
                };
                for axis in 0..3 {
                    let part = p[row][axis];
                    q[axis] = if is_open(locks, axis) {
                        part + root * forces[row][axis] + (rate * h) * part + local[axis]
                    } else {
                        part
                    };
                }
            }
        });
    }
}

/// The columns of a matrix.
fn columns(matrix: DMat3) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|axis| {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        (matrix * Vector::from_array(unit)).to_array()
    })
}

/// The symmetric part of a derivative if it has no positive eigenvalue, and zero if it has one.
fn attractive_part(derivative: DMat3) -> DMat3 {
    let columns = columns(derivative);
    let half = 0.5;
    let s = |i: usize, j: usize| -((columns[i][j] + columns[j][i]) * half);
    let minor = |i: usize, j: usize| s(i, i) * s(j, j) - s(i, j) * s(i, j);
    let cross = |i: usize, j: usize, k: usize| s(i, j) * s(j, k) - s(j, j) * s(i, k);
    let whole = s(0, 0) * minor(1, 2) - s(0, 1) * (s(0, 1) * s(2, 2) - s(1, 2) * s(0, 2))
        + s(0, 2) * cross(0, 1, 2);
    let minors = [s(0, 0), s(1, 1), s(2, 2), minor(0, 1), minor(1, 2), minor(0, 2), whole];
    // Sylvester: every principal minor of a semidefinite matrix is at least 0.
    if minors.iter().all(|minor| *minor >= 0.0) {
        let column = |j: usize| Vector::from_array([0, 1, 2].map(|i| -s(i, j)));
        let [x, y, z] = [0, 1, 2].map(column);
        DMat3::from_cols(x, y, z)
    } else {
        DMat3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    #[test]
    fn a_derivative_is_taken_in_where_it_pulls_together() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
        let with = |a: f64, b: f64, c: f64| {
            turn * DMat3::from_diagonal(DVec3::new(a, b, c)) * turn.transpose()
        };
        for (matrix, taken) in [
            (with(-1.0, -2.0, -3.0), true),
            (with(-1.0, -2.0, 0.1), false),
            (with(2.0, -1.0, -1.0), false),
            (with(1.0, 2.0, -3.0), false),
            (DMat3::ZERO, true),
        ] {
            let part = attractive_part(matrix);
            let expected = if taken { matrix } else { DMat3::ZERO };
            assert!(part.abs_diff_eq(expected, 1e-12), "{matrix}: {part}");
        }
    }
}
