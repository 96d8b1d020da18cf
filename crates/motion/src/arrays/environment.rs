//! The environment of bodies in plain arrays.

use crate::groups::Solver;
use crate::laws::damping::Damping;
use crate::laws::tick_times::TickTimes;
use crate::laws::{Gravity, Law, MutualGravity, WorldLaws};
use crate::state::range::Range;
use crate::tick::environment::Environment;

/// The laws and settings that an [`Environment`] of arrays borrows; in a world, they are resources.
#[derive(Debug, Default)]
pub(super) struct Resources {
    pub gravity: Option<Gravity>,
    pub world_laws: WorldLaws,
    pub laws: Vec<Box<dyn Law>>,
    pub attraction: Option<MutualGravity>,
    pub damping: Option<Damping>,
    pub solver: Solver,
    pub range: Option<Range>,
}

impl Resources {
    /// The environment of a tick of these times.
    pub fn environment(&self, times: TickTimes) -> Environment<'_> {
        Environment {
            gravity: self.gravity.as_ref().filter(|gravity| gravity.on),
            laws: self.world_laws.and(&self.laws),
            attraction: self.attraction.as_ref(),
            damping: self.damping,
            range: self.range.as_ref(),
            times,
            // Constant, because every change of a law drops all cached accelerations.
            epoch: 0,
        }
    }
}
