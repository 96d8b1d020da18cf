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
        let manifest = &bundle.manifest;
        // Without a recorded energy, no energy counts as grown: none exceeds infinity.
        let energy =
            bundle.energy.unwrap_or(EnergyState::at(manifest.snapshot_tick, f64::INFINITY));
        let mut end = Replay::of(scene, &bundle.snapshot, energy).map_err(|error| {
            let what = format!("the snapshot in the bundle does not match its scene: {error}");
            BadBundle::new(what, UNDAMAGED)
        })?;
        if end.simulation.ticks() != manifest.snapshot_tick
            || manifest.end_tick < manifest.snapshot_tick
        {
            return Err(BadBundle::new(CONTRADICTION, UNDAMAGED));
        }
        let mut timeline = Timeline::new(&end.simulation, cap, energy).ok_or_else(|| {
            let what = "the bundle has more bodies than a timeline can hold";
            BadBundle::new(what, "unpack it and run its scene.ron")
        })?;
        let mut keyframes = manifest.keyframes.iter().peekable();
        let mut events = bundle.events.iter().peekable();
        let (mut faults, mut diverged_at) = (Vec::new(), None);
        loop {
            let now = end.simulation.ticks();
            if let Some(keyframe) = keyframes.next_if(|keyframe| keyframe.tick == now)
                && diverged_at.is_none()
                && format!("{:016x}", end.simulation.hash()) != keyframe.state_hash
            {
                diverged_at = Some(now);
            }
            while let Some(event) = events.next_if(|event| event.tick <= now) {
                if event.tick == now {
                    timeline.note(&end.simulation, event.what.clone());
                }
            }
            // The changes between tick number `now` and the next one, lent by the timeline.
            let mut noted = timeline.events_after(now).peekable();
            if now >= manifest.end_tick {
                let state_hash = end.simulation.hash();
                if faults.is_empty() && manifest.fault.is_some() {
                    faults.extend(end.watch.finish(&end.simulation));
                }
                end.carry_out(&mut noted);
                drop(noted);
                return Ok(Self { timeline, end, faults, diverged_at, state_hash });
            }
            faults.extend(end.tick(&mut noted));
            drop(noted);
            timeline.after_tick(&end.simulation, end.watch.energy());
            after_tick(end.simulation.ticks());
        }
    }
}
