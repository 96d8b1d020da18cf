//! What acts on bodies in plain arrays.

use crate::groups::Solver;
use crate::laws::damping::Damping;
use crate::laws::tick_times::TickTimes;
use crate::laws::{Gravity, Law, MutualGravity, WorldLaws};
use crate::state::range::Range;
use crate::tick::environment::Environment;

/// The owner of what an [`Environment`] of arrays borrows; resources in a world.
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
            // Laws change only where all cached accelerations are dropped.
            epoch: 0,
        }
    }
}
