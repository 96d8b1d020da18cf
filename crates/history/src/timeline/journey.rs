//! Going to a past tick, a few ticks at a time.

use scene::Scene;

use super::{Broken, FIRST_SPACING, Keyframe, Replay, Timeline};

/// A world on its way from a snapshot to the end of a later tick.
pub struct Journey {
    replay: Replay,
    from: u64,
    to: u64,
    /// A snapshot shortly before the end of a long way: who went there may go further back.
    near: Option<Keyframe>,
}

impl Journey {
    /// The tick at whose end it ends.
    #[must_use]
    pub const fn to(&self) -> u64 {
        self.to
    }

    /// Ticks that are left.
    #[must_use]
    pub fn ticks_left(&self) -> u64 {
        self.to.saturating_sub(self.replay.ticks())
    }
}

impl Timeline {
    /// A way to the end of tick number `tick`, or of the nearest one that is left. What is noted while it lasts makes
    /// it worthless.
    ///
    /// # Errors
    /// A snapshot that gives another state than it was taken of, which is a fault of this program.
    pub fn set_out(&self, scene: &Scene, tick: u64) -> Result<Journey, Broken> {
        let to = self.nearest(tick);
        let keyframe = self.keyframe_before(to).ok_or(Broken { tick: to })?;
        let mut replay =
            Replay::of(scene, &keyframe.snapshot, keyframe.energy).map_err(|_| Broken { tick: to })?;
        if replay.state_hash() != keyframe.state_hash {
            return Err(Broken { tick: keyframe.snapshot.ticks() });
        }
        Ok(Journey { from: replay.ticks(), to, near: None, replay })
    }

    /// Lets a way end at tick number `tick` instead, if that is ahead of it and no snapshot is nearer; whether it is so.
    pub fn turn(&self, journey: &mut Journey, tick: u64) -> bool {
        let (to, now) = (self.nearest(tick), journey.replay.ticks());
        let ahead = now <= to && self.keyframe_before(to).is_some_and(|near| near.snapshot.ticks() <= now);
        if ahead {
            journey.to = to;
        }
        ahead
    }

    /// Simulates a tick of a way; whether there was one left.
    pub fn go_on(&self, journey: &mut Journey) -> bool {
        let left = journey.ticks_left();
        if left == 0 {
            return false;
        }
        let Journey { replay, from, to, near } = journey;
        let long = *to - *from > FIRST_SPACING;
        if long && left <= FIRST_SPACING && near.is_none() {
            let (method, energy) = (replay.stepper.method(), replay.watch.energy());
            *near = Some(Keyframe::of(&mut replay.world, method, energy));
        }
        let mut events = self.events_after(replay.ticks()).peekable();
        replay.tick(&mut events);
        true
    }

    /// The world at the end of a way. At the last tick it is the present one, with everything that was done to it since.
    pub fn arrive(&mut self, journey: Journey) -> Replay {
        let Journey { mut replay, near, .. } = journey;
        if replay.ticks() >= self.head {
            replay.carry_out(&mut self.events_after(self.head).peekable());
        }
        if let Some(near) = near {
            self.keep_near(near);
        }
        replay
    }

    /// The world at the end of tick number `tick`, out of the range the nearest that there is, simulated again in one
    /// go. At the last tick it is the present one, with everything that was done to it since.
    ///
    /// # Errors
    /// As [`Timeline::set_out`].
    pub fn seek(&mut self, scene: &Scene, tick: u64) -> Result<Replay, Broken> {
        let journey = self.travelled(scene, tick)?;
        Ok(self.arrive(journey))
    }

    /// State hash at the end of the last tick, simulated again.
    ///
    /// # Errors
    /// As [`Timeline::set_out`].
    pub fn end_hash(&self, scene: &Scene) -> Result<u64, Broken> {
        Ok(self.travelled(scene, self.head)?.replay.state_hash())
    }

    fn travelled(&self, scene: &Scene, tick: u64) -> Result<Journey, Broken> {
        let mut journey = self.set_out(scene, tick)?;
        while self.go_on(&mut journey) {}
        Ok(journey)
    }

    fn nearest(&self, tick: u64) -> u64 {
        tick.clamp(*self.range().start(), self.head)
    }
}
