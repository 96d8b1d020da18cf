//! A seek to another tick, a few ticks at a time.

use std::sync::Arc;

use scene::Scene;

use super::{Broken, FIRST_SPACING, Keyframe, Replay, Timeline};

/// A run that is simulated again, from a snapshot to the end of a later tick.
pub struct Seek {
    replay: Replay,
    from: u64,
    to: u64,
    /// A snapshot taken shortly before the end of a long seek, so that a following seek a bit further back is short.
    near: Option<Keyframe>,
}

impl Seek {
    /// The tick that is sought.
    #[must_use]
    pub const fn to(&self) -> u64 {
        self.to
    }

    /// Ticks that are left to simulate.
    #[must_use]
    pub fn ticks_left(&self) -> u64 {
        self.to.saturating_sub(self.replay.simulation.ticks())
    }
}

impl Timeline {
    /// Begins to seek the end of tick number `tick`, or of the nearest one that the timeline still has. An event that
    /// is noted meanwhile invalidates the seek.
    ///
    /// # Errors
    /// If no snapshot lies before `tick`, or one cannot be restored or restores to another state: each is a bug of this program.
    pub fn begin_seek(&self, scene: &Arc<Scene>, tick: u64) -> Result<Seek, Broken> {
        let to = self.nearest(tick);
        let keyframe = self.keyframe_before(to).ok_or(Broken { tick: to })?;
        let replay = Replay::of(Arc::clone(scene), &keyframe.snapshot, keyframe.energy)
            .map_err(|_| Broken { tick: to })?;
        if replay.simulation.hash() != keyframe.state_hash {
            return Err(Broken { tick: keyframe.snapshot.ticks() });
        }
        Ok(Seek { from: replay.simulation.ticks(), to, near: None, replay })
    }

    /// Moves the end of `seek` to `tick` if simulating on is at least as short as starting from a snapshot. Returns whether it did.
    pub fn redirect(&self, seek: &mut Seek, tick: u64) -> bool {
        let (to, now) = (self.nearest(tick), seek.replay.simulation.ticks());
        let ahead = now <= to
            && self.keyframe_before(to).is_some_and(|keyframe| keyframe.snapshot.ticks() <= now);
        if ahead {
            seek.to = to;
        }
        ahead
    }

    /// Simulates the next tick of `seek`; false if none was left.
    pub fn seek_tick(&self, seek: &mut Seek) -> bool {
        let left = seek.ticks_left();
        if left == 0 {
            return false;
        }
        let Seek { replay, from, to, near } = seek;
        // Further than from one snapshot to the next in a new timeline.
        let long = *to - *from > FIRST_SPACING;
        if long && left <= FIRST_SPACING && near.is_none() {
            *near = Some(Keyframe::of(&replay.simulation, replay.watch.energy()));
        }
        let mut events = self.events_after(replay.simulation.ticks()).peekable();
        // A fault here was found when the tick was first simulated.
        let _ = replay.tick(&mut events);
        true
    }

    /// Ends `seek`, which must have no ticks left, and returns the run there. At the last tick it is the present run, with all
    /// changes since.
    pub fn finish_seek(&mut self, seek: Seek) -> Replay {
        debug_assert_eq!(seek.ticks_left(), 0, "a seek is finished when it has no ticks left");
        let Seek { mut replay, near, .. } = seek;
        if replay.simulation.ticks() >= self.last_tick {
            replay.carry_out(&mut self.events_after(self.last_tick).peekable());
        }
        if let Some(near) = near {
            self.keep_near(near);
        }
        replay
    }

    /// State hash at the end of the last tick, simulated again.
    ///
    /// # Errors
    /// As [`Timeline::begin_seek`].
    pub fn end_hash(&self, scene: &Arc<Scene>) -> Result<u64, Broken> {
        let mut seek = self.begin_seek(scene, self.last_tick)?;
        while self.seek_tick(&mut seek) {}
        Ok(seek.replay.simulation.hash())
    }

    fn nearest(&self, tick: u64) -> u64 {
        tick.clamp(*self.range().start(), self.last_tick)
    }
}
