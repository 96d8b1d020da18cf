//! The cubic through position and velocity at both ends of a time interval.

use crate::units::{Scalar, Vector};

/// The cubic through position, m, and velocity, m/s, at both ends of a time interval (Hermite 1878).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cubic {
    from: [Vector; 2],
    length: Scalar,
    /// Coefficients of s² and s³, m, where s is the elapsed fraction of the interval.
    pub curve: [Vector; 2],
}

impl Cubic {
    /// The cubic between two ends that are `length` seconds apart.
    pub fn new(from: [Vector; 2], to: [Vector; 2], length: Scalar) -> Self {
        let moved = to[0] - from[0];
        let [first, last] = [from, to].map(|[_, velocity]| velocity * length);
        let curve = [moved * 3.0 - first * 2.0 - last, first + last - moved * 2.0];
        Self { from, length, curve }
    }

    /// Position and velocity after the fraction `s`, which is `after` seconds.
    pub fn at(&self, s: Scalar, after: Scalar) -> [Vector; 2] {
        let ([x, v], [square, cube]) = (self.from, self.curve);
        let position = x + v * after + (square + cube * s) * (s * s);
        let velocity = v + (square * 2.0 + cube * (3.0 * s)) * (s / self.length);
        [position, velocity]
    }
}
