//! Wind.

use crate::real::{Real, RealVector};
use crate::units::{Scalar, Vector};

/// Air that moves: what [`Drag`](crate::Drag) measures velocities against.
///
/// The velocity at the place x and the time t is `V + g (e sin p + up/2 sin 2p)`, with `p = 2 pi f (t - x·n / |V|)`:
/// gusts that the wind carries along unchanged (Taylor 1938), as long as |V| / f, across the mean wind V = |V| n.
/// `e` is horizontal and square to V, `up` is square to both; in vertical wind e is the x axis, in still air, up to a
/// micrometer a second, p is `2 pi f t`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wind {
    /// Mean velocity V, m/s.
    pub velocity: Vector,
    /// Strength g of the gusts, m/s, at least 0.
    pub gust: Scalar,
    /// Gusts a second f, Hz, at least 0.
    pub gust_hz: Scalar,
}

impl Wind {
    /// Whether it blows everywhere and always alike.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.gust == 0.0 || self.gust_hz == 0.0
    }

    /// Its direction; still air, and what is hardly more, has none.
    fn along(&self) -> Vector {
        if self.velocity.length() > STILL { self.velocity.normalize() } else { Vector::ZERO }
    }

    /// The air at `time`, s.
    pub(crate) fn air<T: Real>(&self, time: T) -> Air<T> {
        let turns = std::f64::consts::TAU * self.gust_hz;
        let along = self.along();
        let across = Vector::Y.cross(along);
        // Of vertical wind every horizontal direction is square to it; so it is of still air.
        let across = if across.length() > 1e-6 { across.normalize() } else { Vector::X };
        let up = if along == Vector::ZERO { Vector::Y } else { along.cross(across) };
        let speed = self.velocity.length().max(STILL);
        Air {
            mean: T::Vector::of(self.velocity),
            across: T::Vector::of(across * self.gust),
            up: T::Vector::of(up * self.gust),
            wave: T::Vector::of(along * (turns / speed)),
            phase: T::of(turns) * time,
            steady: self.is_steady(),
        }
    }

    /// Velocity of the air, m/s.
    pub fn at<T: Real>(&self, time: T, position: T::Vector) -> T::Vector {
        self.air(time).at(position)
    }
}

/// Speed up to which air is still, m/s.
const STILL: Scalar = 1e-6;

/// The air at some time: what does not depend on the place is worked out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Air<T: Real> {
    mean: T::Vector,
    across: T::Vector,
    up: T::Vector,
    /// Radians by which gusts are behind, a meter on, 1/m.
    wave: T::Vector,
    /// Radians at the origin.
    phase: T,
    steady: bool,
}

impl<T: Real> Air<T> {
    fn phase(&self, position: T::Vector) -> T {
        self.phase - position.dot(self.wave)
    }

    /// Velocity of the air, m/s.
    pub fn at(&self, position: T::Vector) -> T::Vector {
        if self.steady {
            return self.mean;
        }
        let phase = self.phase(position);
        self.mean + self.across * phase.sin() + self.up * ((phase + phase).sin() * T::of(0.5))
    }

    /// How the velocity of the air changes from place to place: the vectors a and b of its derivative a b^T, 1/s.
    pub fn gradient(&self, position: T::Vector) -> (T::Vector, T::Vector) {
        let phase = self.phase(position);
        (self.across * phase.cos() + self.up * (phase + phase).cos(), -self.wave)
    }
}
