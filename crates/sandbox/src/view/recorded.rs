//! A recording of the last minute.

use std::ops::RangeInclusive;

use history::{Fault, Seek, Simulation, Timeline, Watch};
use motion::ledger::Ledger;

/// A timeline and the watch over it.
pub(crate) struct Recorded {
    pub timeline: Timeline,
    pub watch: Watch,
    /// What the tick that was simulated last did wrong.
    pub found: Option<Fault>,
    /// What went wrong last, and is still ahead or just happened.
    pub fault: Option<Fault>,
    /// Whether it has been met at the end of its frame.
    pub met: bool,
    /// The tick of a fault that the person was told of: going on goes through it, if nothing is done before.
    pub passed: Option<u64>,
    /// Whether going on from the past repeats what came from outside, until something else does.
    pub repeats: bool,
    /// The seek to another tick, while it takes frames.
    pub way: Option<Box<Way>>,
}

/// A seek, and what follows it.
pub(crate) struct Way {
    pub seek: Seek,
    /// Whether it ends at the last good tick before a fault, which the person is told.
    pub tells: bool,
}

impl Recorded {
    pub const fn new(timeline: Timeline, watch: Watch) -> Self {
        Self { timeline, watch, found: None, fault: None, met: true, passed: None, repeats: false, way: None }
    }

    /// One tick, entered into `ledger` if there is one.
    pub fn tick(&mut self, sim: &mut Simulation, ledger: Option<&mut Ledger>) {
        self.found = self.watch.tick(sim, ledger);
    }
}

/// Where in the last minute a session is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Within {
    pub range: RangeInclusive<u64>,
    /// The tick of the state that is shown, or the one that is sought.
    pub at: u64,
    /// Ticks left to simulate until then.
    pub left: u64,
    pub keyframes: Vec<u64>,
    pub fault: Option<Fault>,
    /// Whether going on repeats what is ahead, instead of dropping it.
    pub repeats: bool,
    pub bytes: usize,
    pub cap: usize,
}
