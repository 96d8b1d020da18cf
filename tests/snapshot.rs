//! Snapshots: a run that is taken out of a world and put into a new one continues as if nothing had happened.

mod interventions;
mod shipped;
mod worlds;

use std::sync::Arc;

use history::Simulation;
use motion::{Evaluations, Iterations, Method, Quarantine, StableId};

use crate::rigs::scene_of;

/// The same in a new world.
pub fn restored(run: &mut Simulation) -> Simulation {
    let snapshot = run.snapshot();
    Simulation::restore(Arc::clone(&run.scene), &snapshot).unwrap()
}

/// What must be equal in runs that are: the state, what was counted and who was quarantined.
pub fn outcome(run: &mut Simulation) -> Outcome {
    let evaluations = run.world.resource::<Evaluations>().clone();
    let records = run.world.resource::<Quarantine>().records().iter();
    let quarantined = records.map(|record| (record.id, record.tick, record.cause.what())).collect();
    Outcome {
        hash: run.snapshot().state_hash(),
        method: run.method(),
        evaluations: sorted(&evaluations),
        quarantined,
    }
}

/// Counts of evaluations, laws in the order of their names.
fn sorted(evaluations: &Evaluations) -> Evaluations {
    let mut laws = evaluations.laws().to_vec();
    laws.sort_unstable();
    Evaluations::from_counts(evaluations.accelerations(), laws, iterations(evaluations))
}

fn iterations(evaluations: &Evaluations) -> Iterations {
    Iterations {
        newton: evaluations.newton_iterations(),
        cg: evaluations.cg_iterations(),
        unconverged_steps: evaluations.unconverged_steps(),
    }
}

/// Whether `method` caches accelerations: a snapshot has none of them, so that a restored run evaluates them once more.
pub fn caches(method: Method) -> bool {
    matches!(method, Method::VelocityVerlet | Method::Yoshida4)
}

#[test]
fn steps_that_did_not_converge_are_counted_on() {
    // Implicit Euler falls into a sun.
    let text = "(version: 1, method: implicit_euler, step_hz: 20,
        wells: [(position_m: (0, 0, 0), strength_m3_s2: 50, softening_m: 1e-4)],
        bodies: [(name: \"comet\", position_m: (1, 0, 0), velocity_m_s: (0, 0.1, 0))])";
    let mut whole = Simulation::new(scene_of(text));
    let counted = |run: &Simulation| run.world.resource::<Evaluations>().unconverged_steps();
    while counted(&whole) < 5 {
        whole.tick();
    }
    let before = counted(&whole);
    let mut again = restored(&mut whole);
    for run in [&mut whole, &mut again] {
        run.run(100);
    }
    assert!(before < counted(&whole), "{before} and no more");
    assert_eq!(outcome(&mut again), outcome(&mut whole));
}

/// What a run came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub hash: u64,
    pub method: Method,
    pub evaluations: Evaluations,
    pub quarantined: Vec<(Option<StableId>, u64, String)>,
}

impl Outcome {
    /// Asserts that this is the outcome of `whole` but for at most `again` more evaluations, of what was cached when the
    /// run was restored.
    pub fn assert_restored(&self, whole: &Self, again: u64, what: &str) {
        let (counted, expected) = (&self.evaluations, &whole.evaluations);
        let all = |evaluations: &Evaluations| {
            let laws = evaluations.laws().iter().copied();
            laws.chain([("accelerations", evaluations.accelerations())]).collect::<Vec<_>>()
        };
        let (counts, counts_expected) = (all(counted), all(expected));
        assert_eq!(counts.len(), counts_expected.len(), "{what}: {counts:?} {counts_expected:?}");
        for ((law, count), (law_expected, expected)) in counts.into_iter().zip(counts_expected) {
            assert_eq!(law, law_expected, "{what}");
            // The engines of a body are counted one by one; it has two at most.
            let again = if law == "thrusts" { 2 * again } else { again };
            assert!(
                (expected..=expected + again).contains(&count),
                "{what}: {law} {count}, {expected}"
            );
        }
        let laws = expected.laws().iter().copied();
        let evaluations =
            Evaluations::from_counts(expected.accelerations(), laws, iterations(counted));
        assert_eq!(Self { evaluations, ..self.clone() }, *whole, "{what}");
    }
}
