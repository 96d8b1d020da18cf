//! The forecast of a session: margins at once, and a trial that goes on from frame to frame.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use history::RunSettings;
use lab::trial::{Ahead, Trial};
use motion::internals::Groups;
use motion::margin::{Margins, MarginsInParts};
use report::ForecastRow;
use report::numbers::capital;

use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::words::with_titles;

/// How long margins are shown before they are computed again, s: speeds and distances change all the time.
pub(super) const FRESH_S: f64 = 0.25;

/// How long the margins of a large net are shown before they are computed again, s.
pub(super) const FRESH_LARGE_S: f64 = 10.0;
/// Number of springs above which a net is large.
pub(super) const LARGE_NET: usize = 5_000;

/// Work of the trial in a frame: some 2 ms.
const WORK_OF_FRAME: f64 = 8e4;

/// Work of margins in a frame: some 8 ms (`meadow` takes a hundred frames).
const MARGINS_OF_FRAME: usize = 6_000;

/// How much farther the trial of an open panel looks than that of the start of a run.
const FARTHER: f64 = 10.0;

/// Part of the time that a trial looked ahead after which another one begins.
const AGAIN: f64 = 0.25;

/// A trial that looked less far, s, begins again as if it had looked that far.
const LEAST_AHEAD_S: f64 = 8.0;

/// The settings and the structure on which a forecast depends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Circumstances {
    settings: RunSettings,
    /// Groups, springs in them, bodies in them, and quarantined bodies.
    pub structure: [usize; 4],
}

/// The margins that are shown.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub of: Circumstances,
    /// Time since they were computed, s.
    pub age: f64,
    margins: Vec<ForecastRow>,
    springs: HashMap<[Entity; 2], f64>,
}

fn in_order([a, b]: [Entity; 2]) -> [Entity; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The forecast of an open panel, and that of the start of the scene.
#[derive(Default)]
pub(crate) struct Forecast {
    pub(super) shown: Option<Shown>,
    /// The margins that will be shown next, and of what.
    pub(super) coming: Option<(Circumstances, MarginsInParts)>,
    /// The margins of the start of the scene, until all of them are computed.
    start: Option<MarginsInParts>,
    trial: Option<Trial>,
    /// Rows of the trial, and how much of it is done.
    tried: Vec<ForecastRow>,
    progress: f64,
    rows: Vec<ForecastRow>,
    /// Whether the trial is that of the start, whose faults are told.
    begins: bool,
    /// Time of the scene at which the trial began, s.
    since: f64,
    at_start: Vec<ForecastRow>,
}

impl Forecast {
    /// The rows at the start of the scene that have a fault, or grow slowly.
    pub fn at_start(&self) -> &[ForecastRow] {
        &self.at_start
    }

    /// The forecast of the open panel, the worst first.
    pub fn shown(&self) -> Option<&[ForecastRow]> {
        self.shown.as_ref().map(|_| &self.rows[..])
    }

    /// How much of the trial is done, 0 to 1.
    pub(super) const fn progress(&self) -> f64 {
        self.progress
    }

    /// How much of its limit a spring between two bodies uses, while the panel is open; 0 for a spring that is in no group.
    pub fn spring_ratio(&self, ends: [Entity; 2]) -> Option<f64> {
        self.shown.as_ref().map(|shown| shown.springs.get(&in_order(ends)).copied().unwrap_or(0.0))
    }

    /// Begins the forecast at the start of a scene with frames of that length, s: margins and a trial that
    /// [go on](Self::advance).
    pub fn begin(&mut self, stage: &mut Stage, frame: f64) {
        stage.expect_frame(frame);
        self.at_start.clear();
        self.start = Some(MarginsInParts::new(false));
        self.trial = Some(Trial::new(stage.sim(), Ahead::DEFAULT));
        (self.tried, self.begins, self.since) = (Vec::new(), true, stage.sim().seconds());
        self.advance_start(stage, MARGINS_OF_FRAME);
    }

    /// Continues the margins of the start. Returns whether all of them are known.
    fn advance_start(&mut self, stage: &mut Stage, work: usize) -> bool {
        let Some(mut margins) = self.start.take() else { return true };
        let sim = stage.sim();
        if !margins.advance(&sim.world, sim.method(), work) {
            self.start = Some(margins);
            return false;
        }
        self.at_start = ForecastRow::of_margins(sim, &margins.into_margins());
        self.keep_listed(stage);
        true
    }

    /// Computes the forecast at the start of a scene with frames of that length, s. Keeps the rows with a fault and those that grow
    /// slowly for the summary; tells and returns those with a fault.
    pub fn compute(&mut self, stage: &mut Stage, frame: f64) -> Vec<ForecastRow> {
        self.begin(stage, frame);
        self.advance_start(stage, usize::MAX);
        self.advance(stage, f64::INFINITY);
        self.at_start.iter().filter(|row| row.is_fault()).cloned().collect()
    }

    fn keep_listed(&mut self, stage: &mut Stage) {
        self.at_start.retain(|row| row.margin().is_some_and(|_| row.is_listed()));
        self.at_start.extend(self.tried.iter().filter(|row| row.is_listed()).cloned());
        ForecastRow::arrange(&mut self.at_start);
        if let Some(worst) = self.at_start.iter().find(|row| row.is_fault()) {
            let words = [worst.verdict(), ": ", &worst.element, ", ", &worst.cure_words].concat();
            let words = capital(&with_titles(words.trim_end_matches(", ")));
            stage.notices.say(Topic::Forecast, words);
        }
    }

    /// Continues the trial for about that much work.
    pub(super) fn advance(&mut self, stage: &mut Stage, work: f64) {
        let Some(trial) = &mut self.trial else { return };
        let is_over = trial.advance(work);
        let tried = ForecastRow::of_trial(stage.sim(), trial);
        self.progress = trial.progress();
        if is_over {
            self.trial = None;
        }
        // What the last trial found stays until this one has ended, or has found a fault.
        let is_shown = is_over || self.begins || self.tried.is_empty();
        if tried != self.tried && (is_shown || tried.iter().any(ForecastRow::is_fault)) {
            self.tried = tried;
            if self.begins {
                self.keep_listed(stage);
            }
            self.list();
        }
        self.begins &= !is_over;
    }

    /// Continues the trial in a frame. With `open`, a trial that has ended begins again when the scene has come a part of its way.
    pub(super) fn advance_frame(&mut self, stage: &mut Stage, open: bool) {
        if !open && !self.begins {
            self.trial = None;
        }
        if !self.advance_start(stage, MARGINS_OF_FRAME) {
            return;
        }
        let ahead = self.tried.iter().filter_map(ForecastRow::tried);
        let shortest = ahead.map(|tried| tried.seconds).fold(f64::INFINITY, f64::min);
        let passed = stage.sim().seconds() - self.since;
        if open && self.trial.is_none() && passed > AGAIN * shortest.max(LEAST_AHEAD_S) {
            self.begin_trial(stage);
        }
        self.advance(stage, WORK_OF_FRAME);
    }

    /// Begins a trial of the present state, and forgets the last one.
    pub(super) fn restart_trial(&mut self, stage: &Stage) {
        self.tried.clear();
        self.begin_trial(stage);
    }

    fn begin_trial(&mut self, stage: &Stage) {
        let ahead = Ahead { work: FARTHER * Ahead::DEFAULT.work, ..Ahead::DEFAULT };
        self.since = stage.sim().seconds();
        self.trial = Some(Trial::new(stage.sim(), ahead));
        self.begins = false;
    }

    /// Continues the margins of the present state, and shows them once all of them are known.
    pub(super) fn refresh(&mut self, stage: &Stage, of: Circumstances) {
        let (sim, coming) = (stage.sim(), self.coming.take().filter(|(known, _)| *known == of));
        let mut parts = coming.map_or_else(|| MarginsInParts::new(true), |(_, parts)| parts);
        if !parts.advance(&sim.world, sim.method(), MARGINS_OF_FRAME) {
            self.shown.take_if(|shown| shown.of != of);
            self.coming = Some((of, parts));
            return;
        }
        let found = parts.into_margins();
        let mut springs = HashMap::new();
        for spring in found.springs() {
            let ratio: &mut f64 = springs.entry(in_order(spring.ends)).or_default();
            *ratio = ratio.max(spring.ratio);
        }
        let margins = ForecastRow::of_margins(sim, &found);
        self.shown = Some(Shown { of, age: 0.0, margins, springs });
        self.list();
    }

    fn list(&mut self) {
        let margins = self.shown.iter().flat_map(|shown| &shown.margins);
        self.rows = self.tried.iter().chain(margins).cloned().collect();
        ForecastRow::arrange(&mut self.rows);
    }
}

/// The whole forecast of the present state, faults first.
pub(crate) fn rows(stage: &Stage) -> Vec<ForecastRow> {
    let mut trial = Trial::new(stage.sim(), Ahead::DEFAULT);
    trial.finish();
    let margins = Margins::of(&stage.sim().world, stage.sim().method());
    ForecastRow::of(stage.sim(), &margins, &trial)
}

pub(super) fn circumstances(stage: &Stage) -> Circumstances {
    let settings = RunSettings::of(stage.sim());
    let groups = stage.sim().world.get_resource::<Groups>();
    let structure = groups.map_or([0; 4], |groups| {
        [groups.len(), groups.springs(), groups.bodies(), stage.quarantines().here().len()]
    });
    Circumstances { settings, structure }
}
