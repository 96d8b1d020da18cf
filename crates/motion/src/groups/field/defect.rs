//! The error of a tick, estimated from the states between its steps.

use crate::groups::rows::{Array, Element};
use crate::kernels::record::vector;
use crate::units::{Scalar, Vector};

/// The states at the ends of the steps of a tick, two steps at a time, and how far the positions are from the velocities.
///
/// Simpson's rule for two steps of the lengths g and h (any lengths): `x2 - x0 = (g + h) / 6 ((2 - h / g) v0 + (g + h)² / (g h) v1
/// + (2 - g / h) v2)`, exact if the velocity is a polynomial of degree 2, and of degree 3 for equal steps.
#[derive(Debug, Default)]
pub(crate) struct Defect<E: Element> {
    /// Whether the tick is measured.
    pub on: bool,
    /// Positions and velocities before the pair of steps, and after its first step.
    states: [[Array<E>; 2]; 2],
    /// Whether the first of these is known.
    knows_start: bool,
    /// Length of the first step of the pair, s.
    first: Option<Scalar>,
    /// Sums over the pairs so far, of each row: m, and m/s by which the error grows until the end of the tick.
    sums: Vec<[Scalar; 2]>,
    /// Length of the steps so far, and of those in pairs, s.
    length: Scalar,
    paired: Scalar,
}

/// Rounding of the positions of a pair, in units of that of a number.
const ROUNDING: Scalar = 8.0 * f64::EPSILON;

impl<E: Element> Defect<E> {
    /// Begins a tick.
    pub fn begin(&mut self) {
        (self.on, self.knows_start, self.first) = (true, false, None);
        self.sums.clear();
        (self.length, self.paired) = (0.0, 0.0);
    }

    /// Ends the tick. Returns the largest sum, m: the error of its positions. A step beside a jump may be in no pair; its share is that
    /// of the others. Infinite if there is no pair.
    pub fn end(&mut self) -> Scalar {
        self.on = false;
        // Not `max`, which would drop NaN.
        let errors = self.sums.iter().map(|[sum, growth]| sum + growth * self.length);
        let most = errors.fold(0.0, |most, error| if error <= most { most } else { error });
        if self.paired > 0.0 { most * (self.length / self.paired) } else { Scalar::INFINITY }
    }

    /// Notes the state before a step, which jumps at its start or not.
    pub fn before(&mut self, x: &[E], v: &[E], jump: bool) {
        if !self.knows_start || jump {
            self.knows_start = true;
            self.first = None;
            copy(&mut self.states[0], x, v);
        }
    }

    /// Notes the state after a step of `h` seconds.
    pub fn after(&mut self, x: &[E], v: &[E], h: Scalar) {
        self.length += h;
        let Some(g) = self.first.take() else {
            self.first = Some(h);
            copy(&mut self.states[1], x, v);
            return;
        };
        let sum = g + h;
        self.paired += sum;
        let factors =
            [2.0 - h / g, sum * sum / (g * h), 2.0 - g / h].map(|part| part * (sum / 6.0));
        let [[x0, v0], [_, v1]] = &self.states;
        self.sums.resize(x.len() * E::LANES, [0.0; 2]);
        for (row, total) in self.sums.iter_mut().enumerate() {
            let at = |rows: &[E]| vector(&rows[row / E::LANES].row(row % E::LANES));
            let [from, to] = [at(x0), at(x)];
            let velocities = [at(v0), at(v1), at(v)];
            let ways = [0, 1, 2].map(|i| velocities[i] * factors[i]);
            let way = ways[0] + ways[1] + ways[2];
            let size = from.abs().max(to.abs()).max_element();
            let off: Vector = to - from - way;
            let error = off.length() - ROUNDING * size;
            if error > 0.0 || error.is_nan() {
                // An error of position comes with one of velocity, by the rate at which the velocity changes.
                let fastest = velocities.iter().fold(0.0, |most: Scalar, v| most.max(v.length()));
                let change = (velocities[2] - velocities[0]).length();
                total[0] += error;
                total[1] += if change > 0.0 { error * change / (fastest * sum) } else { 0.0 };
            }
        }
        copy(&mut self.states[0], x, v);
    }
}

fn copy<E: Element>(state: &mut [Array<E>; 2], x: &[E], v: &[E]) {
    state[0].copy(x);
    state[1].copy(v);
}
