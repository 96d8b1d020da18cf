//! Converts the recording of a session to a bundle, and a bundle to a session.

use history::{
    BUNDLE_FORMAT, Bundle, Fault, FaultEntry, Keyframe, Manifest, Overrides, Rerun, TIMELINE_BYTES,
    Watch,
};
use scene::Scene;

use crate::app::session::Session;
use crate::refused::Refused;
use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::stage::options::Options;
use crate::stage::recorder::Recorder;

/// Name and version of the program, for files that it writes.
pub const PROGRAM: &str = concat!("sandbox ", env!("CARGO_PKG_VERSION"));

/// Result of simulating a bundle again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repetition {
    /// The first tick whose state is known to differ from the recorded one.
    pub first_different_tick: Option<u64>,
    /// State hash at the end of the last tick.
    pub state_hash: u64,
    /// The recorded fault if it was reproduced, otherwise the first fault of this run.
    pub fault: Option<FaultEntry>,
    /// Whether the recorded fault, or its absence, was reproduced.
    pub same_fault: bool,
}

impl Repetition {
    /// Whether nothing differs.
    #[must_use]
    pub const fn same(&self) -> bool {
        self.first_different_tick.is_none() && self.same_fault
    }

    /// The differences from `then`, as clauses.
    #[must_use]
    pub fn differences(&self, then: &Manifest) -> Vec<String> {
        let mut differences = Vec::new();
        match self.first_different_tick {
            Some(tick) if tick == then.end_tick => {
                differences.push(format!("the state differs at the end, tick {tick}"));
            }
            Some(tick) => differences.push(format!("the state differs from tick {tick} on")),
            None => {}
        }
        if !self.same_fault {
            let words = |fault: Option<&FaultEntry>| {
                fault.map_or("no fault".to_owned(), ToString::to_string)
            };
            let (now, then) = (self.fault.as_ref(), then.fault.as_ref());
            differences.push(format!("{} instead of {}", words(now), words(then)));
        }
        if !differences.is_empty() && then.program != PROGRAM {
            differences.push(format!("it was written by {}, this is {PROGRAM}", then.program));
        }
        differences
    }
}

impl Session {
    /// Simulates `bundle` again and returns a session that is paused at its end, with its timeline. A run that resumes from an
    /// earlier tick repeats the recorded changes from outside until a new one comes. `name` is the name of the file; `look` gets
    /// the number of every finished tick.
    ///
    /// # Errors
    /// If the bundle contradicts itself, is of another kind of scene, or is too large.
    pub fn of_bundle(
        bundle: &Bundle,
        name: &str,
        options: Options,
        look: &mut dyn FnMut(u64),
    ) -> Result<(Self, Repetition), Refused> {
        let scene = bundle.scene(&format!("{name}: scene.ron"))?;
        let rerun = Rerun::of(scene.clone(), bundle, TIMELINE_BYTES, look)
            .map_err(|error| Refused(format!("{name}: {error}")))?;
        Ok(Self::of_rerun(rerun, scene, &bundle.manifest, options))
    }

    /// A session of `rerun`, which is that of a bundle with the manifest `then`, at its end.
    #[must_use]
    pub fn of_rerun(
        rerun: Rerun,
        scene: Scene,
        then: &Manifest,
        options: Options,
    ) -> (Self, Repetition) {
        let Rerun { timeline, end, faults, diverged_at, state_hash, .. } = rerun;
        let mut session = Self::new(scene, Options { paused: true, ..options });
        let names = &session.stage.sim().scene.names;
        let named = |fault: &Fault| fault.named(names);
        let is_then = |fault: &Fault| then.fault.as_ref().is_some_and(|then| fault.is(then, names));
        let fault = faults.iter().find(|fault| is_then(fault)).or(faults.first()).cloned();
        let same_end = format!("{state_hash:016x}") == then.end_state_hash;
        let repetition = Repetition {
            first_different_tick: diverged_at.or((!same_end).then_some(then.end_tick)),
            state_hash,
            same_fault: fault.as_ref().map_or(then.fault.is_none(), is_then),
            fault: fault.as_ref().map(named),
        };
        let watch = Watch::resume(session.stage.sim(), end.watch.energy());
        session.stage.resume(Recorder::opened(timeline, watch, fault), end);
        (session, repetition)
    }

    /// Goes to the last good tick before the fault, if there is one. Tells the person what differs from the recording in the file
    /// `name`.
    pub fn show_repetition(&mut self, name: &str, repetition: &Repetition, then: &Manifest) {
        self.rewind_before_fault();
        let notices = &mut self.stage.notices;
        let differences = repetition.differences(then);
        if !differences.is_empty() {
            let what = format!("{name} does not repeat: {}", differences.join("; "));
            notices.say(Topic::Other, what);
        }
        if let Some(fault) = &repetition.fault {
            notices.say(Topic::Other, fault.to_string());
        }
    }
}

impl Stage {
    /// Makes a bundle of everything that is recorded, for replay elsewhere; `picture` is a PNG of the last good tick. `None` if
    /// nothing is recorded, or if the run cannot be reproduced here.
    #[must_use]
    pub fn bundle(&self, picture: Option<Vec<u8>>) -> Option<Bundle> {
        let timeline = self.recorder().timeline()?;
        let (snapshot, events, energy) = timeline.origin()?;
        let hash = |hash: u64| format!("{hash:016x}");
        let keyframes =
            timeline.keyframes().map(|(tick, state)| Keyframe { tick, state_hash: hash(state) });
        let range = timeline.range();
        Some(Bundle {
            scene: self.sim().scene.text.to_string(),
            manifest: Manifest {
                format: BUNDLE_FORMAT,
                program: PROGRAM.to_owned(),
                scene: self.sim().scene.name.clone(),
                settings: Overrides::of(&self.sim().scene),
                snapshot_tick: *range.start(),
                end_tick: *range.end(),
                end_state_hash: hash(timeline.end_hash(&self.sim().scene).ok()?),
                keyframes: keyframes.collect(),
                fault: self
                    .recorder()
                    .fault()
                    .filter(|fault| *range.start() < fault.found && fault.found <= *range.end())
                    .map(|fault| fault.named(&self.sim().scene.names)),
            },
            snapshot: snapshot.clone(),
            events,
            energy: energy.largest_j.is_finite().then_some(energy),
            picture,
        })
    }
}
