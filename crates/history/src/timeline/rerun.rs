//! Simulates a bundle again and finds the first difference from the recorded run.

use std::sync::Arc;

use scene::Scene;

use super::{Fault, Replay, Timeline};
use crate::bundle::{BadBundle, Bundle, CONTRADICTION, EnergyState, UNDAMAGED};

/// The result of simulating a bundle again.
pub struct Rerun {
    /// Timeline of the run, as far back as its memory limit allows.
    pub timeline: Timeline,
    /// The run at its end, with the changes after the last tick.
    pub end: Replay,
    /// All faults.
    pub faults: Vec<Fault>,
    /// Tick of the first keyframe of the bundle whose state differs.
    pub diverged_at: Option<u64>,
    /// State hash at the end of the last tick.
    pub state_hash: u64,
    /// Numbers of keyframes and events of the bundle that were passed.
    passed: [usize; 2],
}

impl Rerun {
    /// Simulates `bundle`, whose scene is `scene`, to its end, with a timeline of at most `cap` bytes. Calls `after_tick`
    /// with the number of every simulated tick.
    ///
    /// # Errors
    /// If the bundle contradicts itself or is too large.
    pub fn of(
        scene: impl Into<Arc<Scene>>,
        bundle: &Bundle,
        cap: usize,
        after_tick: &mut dyn FnMut(u64),
    ) -> Result<Self, BadBundle> {
        let mut rerun = Self::begin(scene, bundle, cap)?;
        while rerun.tick(bundle) {
            after_tick(rerun.end.simulation.ticks());
        }
        Ok(rerun)
    }

    /// Begins to simulate `bundle` as [`Self::of`] does; [`Self::tick`] continues.
    ///
    /// # Errors
    /// If the bundle contradicts itself or is too large.
    pub fn begin(
        scene: impl Into<Arc<Scene>>,
        bundle: &Bundle,
        cap: usize,
    ) -> Result<Self, BadBundle> {
        let manifest = &bundle.manifest;
        // Without a recorded energy, no energy counts as grown: none exceeds infinity.
        let energy =
            bundle.energy.unwrap_or(EnergyState::at(manifest.snapshot_tick, f64::INFINITY));
        let end = Replay::of(scene, &bundle.snapshot, energy).map_err(|error| {
            let what = format!("the snapshot in the bundle does not match its scene: {error}");
            BadBundle::new(what, UNDAMAGED)
        })?;
        if end.simulation.ticks() != manifest.snapshot_tick
            || manifest.end_tick < manifest.snapshot_tick
        {
            return Err(BadBundle::new(CONTRADICTION, UNDAMAGED));
        }
        let timeline = Timeline::new(&end.simulation, cap, energy).ok_or_else(|| {
            let what = "the bundle has more bodies than a timeline can hold";
            BadBundle::new(what, "unpack it and run its scene.ron")
        })?;
        let (faults, passed) = (Vec::new(), [0; 2]);
        Ok(Self { timeline, end, faults, diverged_at: None, state_hash: 0, passed })
    }

    /// Simulates the next tick of `bundle`. Returns false at its end, once the changes after the last tick are applied.
    pub fn tick(&mut self, bundle: &Bundle) -> bool {
        let Self { timeline, end, faults, .. } = self;
        let [keyframes, events] = &mut self.passed;
        let now = end.simulation.ticks();
        if let Some(keyframe) = bundle.manifest.keyframes.get(*keyframes)
            && keyframe.tick == now
        {
            *keyframes += 1;
            let differs = format!("{:016x}", end.simulation.hash()) != keyframe.state_hash;
            self.diverged_at = self.diverged_at.or(differs.then_some(now));
        }
        while let Some(event) = bundle.events.get(*events).filter(|event| event.tick <= now) {
            *events += 1;
            if event.tick == now {
                timeline.note(&end.simulation, event.what.clone());
            }
        }
        // The changes between tick number `now` and the next one, lent by the timeline.
        let mut noted = timeline.events_after(now).peekable();
        if now >= bundle.manifest.end_tick {
            self.state_hash = end.simulation.hash();
            if faults.is_empty() && bundle.manifest.fault.is_some() {
                faults.extend(end.watch.finish(&end.simulation));
            }
            end.carry_out(&mut noted);
            return false;
        }
        faults.extend(end.tick(&mut noted));
        drop(noted);
        timeline.after_tick(&end.simulation, end.watch.energy());
        true
    }
}
