//! Records of the kicks, damping and limits of each body in a tick. Kernels write them only for a ledger.

use std::ops::Range;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use crate::units::{Scalar, Vector};

/// A change of velocity, m/s, of kinetic energy per mass, m²/s², and of angular momentum per mass about the place where
/// the tick began, m²/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct VelocityChange {
    pub energy: Scalar,
    pub velocity: Vector,
    pub angular: Vector,
}

impl VelocityChange {
    /// Adds a change of velocity `moved` meters from the place where the tick began.
    fn add(&mut self, moved: Vector, from: Vector, to: Vector) {
        self.add_change(moved, to - from, (to - from).dot(from + to) * 0.5);
    }

    fn add_change(&mut self, moved: Vector, velocity: Vector, energy: Scalar) {
        self.energy += energy;
        self.velocity += velocity;
        self.angular += moved.cross(velocity);
    }

    /// Adds changes of a system that began `moved` meters from the place where the tick began.
    fn merge(&mut self, moved: Vector, Self { energy, velocity, angular }: &Self) {
        self.add_change(moved, *velocity, *energy);
        self.angular += *angular;
    }
}

/// The kicks of a tick, between which nothing moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Kicks {
    /// Sum of their length times the mean of the velocities before and after, m: the path along which a constant force
    /// does work.
    pub path: Vector,
    /// Sum of their length times the distance from the place where the tick began, m s: the lever arm of a constant
    /// force.
    pub lever: Vector,
    seconds: Scalar,
}

impl Kicks {
    /// Adds a kick of `h` seconds `moved` meters from the place where the tick began.
    fn add(&mut self, h: Scalar, moved: Vector, path: Vector) {
        self.path += path;
        self.lever += moved * h;
        self.seconds += h;
    }
}

/// The record of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TickRecord {
    /// Change by damping, except where damping is a law.
    pub damping: VelocityChange,
    /// Change by speed limit and axis locks.
    pub limits: VelocityChange,
    /// `None` for methods that do not change velocity and position one after the other.
    pub kicks: Option<Kicks>,
    /// Velocities with which the method began and ended, m/s, after the damping before the tick and before the damping after
    /// it; `None` for a method with damping inside its steps.
    pub between: Option<[Vector; 2]>,
    /// Position at which the method began.
    began: Vector,
    /// Distance from the place where the tick began, m.
    moved: Vector,
}

impl TickRecord {
    /// Adds a change by damping.
    pub fn damp(&mut self, from: Vector, to: Vector) {
        self.damping.add(self.moved, from, to);
    }

    /// Adds a change by speed limit and axis locks.
    pub fn limit(&mut self, from: Vector, to: Vector) {
        self.limits.add(self.moved, from, to);
    }

    /// Adds a kick of `h` seconds.
    pub fn kick(&mut self, h: Scalar, from: Vector, to: Vector) {
        self.kicks.get_or_insert_default().add(h, self.moved, (from + to) * (0.5 * h));
    }

    /// Adds a move with the velocity `v` for `h` seconds.
    pub fn travel(&mut self, h: Scalar, v: Vector) {
        self.moved += v * h;
    }

    /// Adds a kick by the acceleration `a`, in which exact damping takes the fraction `1 - e^-q` of the velocity.
    pub fn damped_kick(&mut self, h: Scalar, q: Scalar, a: Vector, from: Vector, to: Vector) {
        let way = (from + (to - from) * mean(q)) * h;
        self.kicks.get_or_insert_default().add(h, self.moved, way);
        let energy = (to - from).dot(from + to) * 0.5 - a.dot(way);
        self.damping.add_change(self.moved, to - from - a * h, energy);
    }

    /// Records that the method begins the tick at `x` with the velocity `v`.
    pub fn begin(&mut self, x: Vector, v: Vector) {
        (self.between, self.began, self.moved) = (Some([v; 2]), x, Vector::ZERO);
    }

    /// Records that the method ends the tick at `x` with the velocity `v`.
    pub fn end(&mut self, x: Vector, v: Vector) {
        if let Some([_, end]) = &mut self.between {
            (*end, self.moved) = (v, x - self.began);
        }
    }

    /// Adds the record of a system that follows in the same tick.
    fn merge(&mut self, other: &Self) {
        self.damping.merge(self.moved, &other.damping);
        self.limits.merge(self.moved, &other.limits);
        if let Some(Kicks { path, lever, seconds }) = other.kicks {
            let kicks = self.kicks.get_or_insert_default();
            kicks.add(seconds, self.moved, path);
            kicks.lever += lever;
        }
        self.moved += other.moved;
        self.between = other.between.or(self.between);
    }
}

/// Mean over s from 0 to 1 of `(1 - e^(-q s)) / (1 - e^-q)`: the mean of a velocity that follows `v' = a - c v` for h
/// seconds, as a fraction of the way from its start to its end, with q = c h.
fn mean(q: Scalar) -> Scalar {
    // For small q the closed form loses more to cancellation than the series to truncation.
    if q < 0.1 {
        let square = q * q;
        return 0.5 + q * (1.0 / 12.0 - square * (1.0 / 720.0 - square / 30_240.0));
    }
    -1.0 / libm::expm1(-q) - 1.0 / q
}

/// Adds a change from one vector to another to the record of a row; compiled once and called by every method.
pub(crate) type Note<'a> = &'a dyn Fn(&mut TickRecord, usize, Vector, Vector);

/// The records of the rows that a kernel integrates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Recorder {
    rows: Vec<TickRecord>,
    /// The number in the record of the first row of the batch.
    pub first: usize,
    block: Range<usize>,
}

impl Recorder {
    pub fn of(rows: usize) -> Self {
        Self { rows: vec![TickRecord::default(); rows], first: 0, block: 0..rows }
    }

    /// Enters these rows of the batch.
    pub fn enter(&mut self, rows: &Range<usize>) {
        self.block = self.first + rows.start..self.first + rows.end;
    }

    /// Records the change of the current rows; `note` gets the number of each row among them.
    #[cold]
    pub fn note(&mut self, from: &[[f64; 4]], to: &[[f64; 4]], note: Note<'_>) {
        let rows = self.rows[self.block.clone()].iter_mut().zip(from.iter().zip(to)).enumerate();
        rows.for_each(|(k, (row, (from, to)))| note(row, k, vector(from), vector(to)));
    }

    /// Appends the records of another part.
    pub fn append(&mut self, other: Self) {
        self.rows.extend(other.rows);
    }

    /// Sets the records of `rows` to those of `of`.
    pub fn take_over(&mut self, rows: &[usize], of: &Self) {
        rows.iter().zip(&of.rows).for_each(|(row, record)| self.rows[*row] = *record);
    }
}

/// Position, velocity or acceleration of a row.
#[inline(always)]
pub(crate) fn vector([x, y, z, _]: &[f64; 4]) -> Vector {
    Vector::new(*x, *y, *z)
}

/// The records of the running tick; `None` without a ledger.
#[derive(Resource, Debug, Default)]
pub(crate) struct TickRecords(pub Option<EntityHashMap<TickRecord>>);

impl TickRecords {
    /// A recorder of `rows` rows, if the tick has a ledger.
    pub fn recorder(&self, rows: usize) -> Option<Recorder> {
        self.0.is_some().then(|| Recorder::of(rows))
    }

    /// Adds what a system did to `bodies`, whose records begin at `first`. The two halves of an Euler step may be two systems.
    pub fn add(&mut self, bodies: &[Entity], recorder: Option<&Recorder>, first: usize) {
        let (Some(records), Some(recorder)) = (&mut self.0, recorder) else { return };
        for (body, record) in bodies.iter().zip(&recorder.rows[first..]) {
            records.entry(*body).or_default().merge(record);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_the_mean_agree_with_a_sum_of_many_parts() {
        for q in [1e-9, 1e-3, 0.05, 0.0999, 0.1001, 0.7, 5.0, 60.0] {
            let parts = 200_000;
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(parts);
            let f = |s: Scalar| libm::expm1(-q * s) / libm::expm1(-q);
            let sum = (0..parts).map(|i| f(at(i))).sum::<Scalar>() / f64::from(parts);
            assert!((mean(q) - sum).abs() < 1e-8, "{q}: {} {sum}", mean(q));
        }
        assert!((mean(0.1 - 1e-13) - mean(0.1)).abs() < 1e-12);
    }
}
