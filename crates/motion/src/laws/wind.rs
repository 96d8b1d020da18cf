//! Wind: the motion of the fluid that drags.

use crate::units::{Scalar, Vector};

/// Motion of the air. [`Drag`](crate::Drag) acts on the velocity of a body relative to it.
///
/// The velocity at position x and time t is `V + g (e sin p + up/2 sin 2p)`, with `p = 2 pi f (t - x·n / |V|)`: gusts
/// of wavelength |V| / f across the mean wind V = |V| n, which carries them along unchanged (Taylor 1938). `e` is
/// horizontal and perpendicular to V, `up` is perpendicular to both. In vertical wind e is the x axis. In still air
/// (|V| up to 1e-6 m/s) p is `2 pi f t`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Wind {
    /// Mean velocity V, m/s.
    pub velocity: Vector,
    /// Strength g of the gusts, m/s, at least 0.
    pub gust: Scalar,
    /// Frequency f of the gusts, Hz, at least 0.
    pub gust_hz: Scalar,
}

impl Wind {
    /// Steady wind of that velocity, m/s.
    #[must_use]
    pub const fn new(velocity: Vector) -> Self {
        Self { velocity, gust: 0.0, gust_hz: 0.0 }
    }

    /// The same with gusts of that strength, m/s, and frequency, Hz.
    #[must_use]
    pub const fn gusting(self, gust: Scalar, gust_hz: Scalar) -> Self {
        Self { gust, gust_hz, ..self }
    }

    /// Whether the velocity of the air is the same at every position and time.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.gust == 0.0 || self.gust_hz == 0.0
    }

    /// Unit vector of the mean wind; zero in still air.
    fn along(&self) -> Vector {
        if self.velocity.length() > STILL { self.velocity.normalize() } else { Vector::ZERO }
    }

    /// The velocity field at `time`, s.
    #[must_use]
    pub fn air(&self, time: f64) -> Air {
        let turns = std::f64::consts::TAU * self.gust_hz;
        let along = self.along();
        let across = Vector::Y.cross(along);
        // Every horizontal direction is perpendicular to vertical wind, and to still air.
        let across = if across.length() > 1e-6 { across.normalize() } else { Vector::X };
        let up = if along == Vector::ZERO { Vector::Y } else { along.cross(across) };
        let speed = self.velocity.length().max(STILL);
        Air {
            mean: self.velocity,
            across: (across * self.gust),
            up: (up * self.gust),
            wave: (along * (turns / speed)),
            phase: turns * time,
            steady: self.is_steady(),
        }
    }

    /// Velocity of the air at `time`, s, and `position`, m, in m/s.
    pub fn at(&self, time: f64, position: Vector) -> Vector {
        self.air(time).at(position)
    }
}

/// Mean speed up to which air is still, m/s.
const STILL: Scalar = 1e-6;

/// The velocity field of the air at one time: everything that does not depend on the position is computed.
#[derive(Clone, Copy, Debug)]
pub struct Air {
    /// The mean wind, m/s.
    pub mean: Vector,
    /// Amplitude of the gusts along e, m/s.
    pub across: Vector,
    /// Amplitude of the gusts along up, m/s.
    pub up: Vector,
    /// Wave vector of the gusts, rad/m.
    pub wave: Vector,
    /// Phase at the origin, rad.
    phase: f64,
    /// Whether there are no gusts.
    pub steady: bool,
}

impl Air {
    /// Phase of the gusts at `position`, m, in rad.
    #[must_use]
    pub fn phase(&self, position: Vector) -> f64 {
        self.phase - position.dot(self.wave)
    }

    /// Velocity of the air at `position`, m/s.
    #[must_use]
    pub fn at(&self, position: Vector) -> Vector {
        if self.steady {
            return self.mean;
        }
        let phase = self.phase(position);
        self.mean + self.across * libm::sin(phase) + self.up * (libm::sin(phase + phase) * 0.5)
    }

    /// Derivative a b^T of the velocity by position, 1/s, as the vectors a and b.
    pub(crate) fn gradient(&self, position: Vector) -> (Vector, Vector) {
        let phase = self.phase(position);
        (self.across * libm::cos(phase) + self.up * libm::cos(phase + phase), -self.wave)
    }
}
