//! A run of a row: a world of entities, with the script of the row.

use std::collections::VecDeque;

use history::{Change, Simulation};
use motion::TimeStep;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use scene::{Scene, Step, SurvivalRow};

use crate::cost::Sample;

/// A run of a row in progress.
pub(super) struct RowRun {
    simulation: Box<Simulation>,
    ledger: Option<Box<Ledger>>,
    script: VecDeque<Step>,
    lengths: scene::Lengths,
    /// Length of the last tick, s.
    length: f64,
    clock: StepClock,
}

impl RowRun {
    /// The start of a run of `scene`, which is the scene of `row`.
    pub fn new(scene: &Scene, row: &SurvivalRow, with_ledger: bool) -> Self {
        let simulation = Box::new(Simulation::new(scene.clone()));
        let ledger = with_ledger.then(|| Box::new(Ledger::open(&simulation.world)));
        Self {
            simulation,
            ledger,
            script: row.script.iter().cloned().collect(),
            lengths: row.lengths(),
            length: 1.0 / scene.step_hz,
            clock: StepClock::default(),
        }
    }

    /// Ticks so far.
    pub const fn ticks(&self) -> u64 {
        self.clock.ticks()
    }

    /// Simulates one tick of the row's own length, with the actions of its script.
    pub fn tick(&mut self) {
        let length = self.lengths.next().unwrap_or(self.length);
        let start = self.clock.seconds();
        let Self { simulation, ledger, script, clock, .. } = self;
        let mut due = Vec::new();
        while let Some(step) =
            script.pop_front_if(|step| step.when.is_due(clock.ticks(), start, length))
        {
            // A body that was removed before is not changed.
            let change = step.action.change().map(|change| Change::of(change, simulation));
            due.extend(change.and_then(Result::ok));
        }
        if length.to_bits() != self.length.to_bits() {
            simulation.world.insert_resource(TimeStep(length));
        }
        due.iter().for_each(|change| simulation.give(change));
        match ledger {
            Some(ledger) => simulation.tick_with(ledger),
            None => simulation.tick(),
        }
        self.length = length;
        self.clock.count(length);
    }

    /// Stable id, position and velocity of every body with physics.
    pub fn states(&mut self) -> Vec<Sample> {
        self.simulation.states().collect()
    }

    /// The ledger, if the run has one.
    pub fn ledger(&self) -> Option<&Ledger> {
        self.ledger.as_deref()
    }

    /// Which body turned non-finite first, and when; `None` if none did.
    pub fn failure(&self) -> Option<String> {
        let failure = self.simulation.failure()?;
        let name = failure.name(&self.simulation.scene);
        Some(format!("{name}: {} in tick {}", failure.cause.what(), failure.tick))
    }

    /// Number of implicit steps that did not converge.
    pub fn unconverged(&self) -> u64 {
        self.simulation.evaluations().unconverged_steps()
    }
}
