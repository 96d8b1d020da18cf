//! The options of single bodies.

use crate::laws::Law;
use crate::laws::damping::Damping;
use crate::laws::tick_times::TickTimes;
use crate::state::components::AxisLocks;
use crate::units::Scalar;

/// The options of a body, which add to the environment of all bodies or replace a part of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyOptions<'a> {
    pub gravity_off: bool,
    /// Its own rate of damping, 1/s.
    pub damping_rate: Option<Scalar>,
    /// Largest speed, m/s.
    pub speed_limit: Option<Scalar>,
    pub locks: Option<AxisLocks>,
    /// Its own laws.
    pub laws: &'a [Box<dyn Law>],
    /// Changes whenever its own laws do.
    pub laws_version: u64,
    /// Its own number of substeps.
    pub substeps: Option<u32>,
}

impl BodyOptions<'_> {
    /// The options of a body that has none.
    pub const NONE: Self = Self {
        gravity_off: false,
        damping_rate: None,
        speed_limit: None,
        locks: None,
        laws: &[],
        laws_version: 0,
        substeps: None,
    };

    /// The damping of the body where that of all bodies is `shared`.
    pub fn damping(&self, shared: Option<Damping>) -> Option<Damping> {
        shared.map(|shared| Damping { rate: self.damping_rate.unwrap_or(shared.rate), ..shared })
    }

    /// Axes along which nothing accelerates it: locked axes, unless a limit after the kick sees the velocity along them.
    pub fn closed_axes(&self, limits_after_kick: bool) -> Option<AxisLocks> {
        self.locks.filter(|_| !(limits_after_kick && self.speed_limit.is_some()))
    }

    /// Whether anything but own laws and substeps is set: a row of a group is then in a class of its own.
    pub const fn changes_row(&self) -> bool {
        self.gravity_off
            || self.damping_rate.is_some()
            || self.speed_limit.is_some()
            || self.locks.is_some()
    }

    /// Whether one of its own laws jumps in a tick of these times.
    pub fn jumps(&self, times: &TickTimes) -> bool {
        self.laws.iter().flat_map(|law| law.discontinuities()).any(|time| times.holds(*time))
    }

    /// Whether the options equal those of `other` except for the formulas of own laws. The bodies are then integrated together,
    /// unless one of these laws [jumps](Self::jumps).
    pub fn is_like(&self, other: &BodyOptions<'_>) -> bool {
        let kind = |laws: &[Box<dyn Law>]| {
            (laws.is_empty(), laws.iter().any(|law| law.depends_on_velocity()))
        };
        (self.gravity_off, self.damping_rate, self.speed_limit, self.locks, self.substeps)
            == (
                other.gravity_off,
                other.damping_rate,
                other.speed_limit,
                other.locks,
                other.substeps,
            )
            && kind(self.laws) == kind(other.laws)
    }
}

/// Looks up the options of single rows.
pub(crate) trait RowOptions {
    fn row(&self, row: usize) -> BodyOptions<'_>;
}

/// The options of some rows of a whole.
pub(crate) struct OfRows<'a> {
    pub whole: &'a dyn RowOptions,
    pub rows: &'a [usize],
}

impl RowOptions for OfRows<'_> {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        self.whole.row(self.rows[row])
    }
}

/// The same options on every row.
impl RowOptions for BodyOptions<'_> {
    fn row(&self, _: usize) -> BodyOptions<'_> {
        *self
    }
}
