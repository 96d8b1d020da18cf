//! One run of a sweep: the scene from its start to its end, measured after every tick.

use std::collections::HashMap;
use std::sync::LazyLock;

use history::{Distances, Simulation, Twin, reference_substeps};
use motion::ledger::Ledger;
use motion::units::Vector;
use scene::{Scene, StepKind, shown};

use super::measure::Measure;
use super::{Outcome, Plan};
use crate::clock::thread_time;
use crate::column::Value;
use crate::cost::{Machine, Runner, invented, larger};
use crate::run::movable;
use crate::trial::thrown_after;

/// The processor that the times refer to.
static PROCESSOR: LazyLock<String> = LazyLock::new(|| Machine::here().processor);

/// Why a scene with a tick per frame is refused.
const FRAMES: &str = "its ticks are as long as frames, and a sweep has none; give step: fixed";

/// Runs `scene`. Returns how the run ended, why it was refused or a body was quarantined, and the simulated seconds
/// with the values of the measures of `plan`.
pub(super) fn run(scene: Scene, plan: &Plan) -> (Outcome, String, Vec<Value>) {
    if scene.step == StepKind::Frame {
        return (Outcome::Refused, FRAMES.to_owned(), Vec::new());
    }
    let ticks = scene.ticks_in(plan.seconds);
    if ticks == 0 {
        let why = format!(
            "{} s are less than half a tick of {} s",
            shown(plan.seconds),
            shown(1.0 / scene.step_hz)
        );
        return (Outcome::Refused, why, Vec::new());
    }
    let measures = |measure| plan.measures.contains(&measure);
    let start = thread_time();
    let step_hz = scene.step_hz;
    let mut simulation = Simulation::new(scene);
    let thrown = measures(Measure::Survives)
        .then(|| thrown_after(&simulation, ticks as f64 / step_hz))
        .flatten();
    let mut truth = measures(Measure::Error).then(|| Truth::of(&simulation));
    let mut energy = plan.keeps().ledger.then(|| Energy::of(&simulation));
    let looks = measures(Measure::LargestSpeed) || measures(Measure::LargestDistance);
    let mut motion = looks.then(|| Motion::of(&simulation));
    for _ in 0..ticks {
        match &mut energy {
            Some(energy) => energy.tick(&mut simulation),
            None => simulation.tick(),
        }
        motion.iter_mut().for_each(|motion| motion.look(&simulation));
        truth.iter_mut().for_each(|truth| truth.look(&simulation));
    }
    let cpu_s = thread_time() - start;
    let failure = Runner::failure(&mut simulation);
    let (outcome, why, quarantined) = match failure {
        Some(why @ crate::cost::Failure::Quarantined { tick, .. }) => {
            (Outcome::Quarantined, why.to_string(), Some(tick))
        }
        _ => (Outcome::Finished, String::new(), None),
    };
    let speed_and_distance = |pick: fn(&Motion) -> f64| motion.as_ref().map_or(f64::NAN, pick);
    let mut values = vec![Value::Number(ticks as f64 / step_hz)];
    for measure in &plan.measures {
        match measure {
            Measure::Error => {
                let errors = truth.as_ref().map_or([f64::NAN; 2], |truth| truth.errors);
                values.extend(errors.map(Value::Number));
            }
            Measure::Drift => {
                values.push(Value::Number(energy.as_ref().map_or(f64::NAN, Energy::drift)));
            }
            Measure::Survives => {
                let thrown = thrown.map(|after| (after * step_hz).round() as u64);
                let lost = thrown.into_iter().chain(quarantined).min();
                values.push(Value::Flag(lost.is_none()));
                let survived = lost.map_or(ticks, |lost| lost.saturating_sub(1));
                values.push(Value::Number(survived as f64 / step_hz));
            }
            Measure::LargestSpeed => {
                values.push(Value::Number(speed_and_distance(|motion| motion.speed)));
            }
            Measure::LargestDistance => {
                values.push(Value::Number(speed_and_distance(|motion| motion.distance)));
            }
            Measure::Evaluations => {
                let counts = Runner::counts(&mut simulation);
                let bodies = movable(&simulation.scene).count();
                values.push(Value::Number(
                    (counts.accelerations + counts.solver) as f64 / bodies as f64,
                ));
            }
            Measure::Unconverged => {
                values.push(Value::Count(simulation.evaluations().unconverged_steps()));
            }
            Measure::StateHash => values.push(Value::Text(format!("{:016x}", simulation.hash()))),
            Measure::Time => {
                values.push(Value::Number(cpu_s));
                values.push(Value::Text(PROCESSOR.clone()));
            }
        }
    }
    (outcome, why, values)
}

/// The largest speed of a body so far, m/s, and the largest distance, m, of a body from its start, except particles.
struct Motion {
    starts: HashMap<u32, Vector>,
    speed: f64,
    distance: f64,
}

impl Motion {
    fn of(simulation: &Simulation) -> Self {
        // Particles of emitters have a new start at every birth.
        let bodies = simulation.states().filter(|(id, ..)| !simulation.scene.is_particle(*id));
        let starts = bodies.map(|(id, position, _)| (id, position)).collect();
        let mut motion = Self { starts, speed: 0.0, distance: 0.0 };
        motion.look(simulation);
        motion
    }

    fn look(&mut self, simulation: &Simulation) {
        for (id, position, velocity) in simulation.states() {
            self.speed = larger(self.speed, velocity.length());
            if let Some(start) = self.starts.get(&id) {
                self.distance = larger(self.distance, position.distance(*start));
            }
        }
    }
}

/// The energy that a method invents or loses, by the ledger.
struct Energy {
    ledger: Ledger,
    /// The largest magnitude after any tick, J.
    largest: f64,
}

impl Energy {
    fn of(simulation: &Simulation) -> Self {
        Self { ledger: Ledger::open(&simulation.world), largest: 0.0 }
    }

    fn tick(&mut self, simulation: &mut Simulation) {
        simulation.tick_with(&mut self.ledger);
        self.largest = larger(self.largest, invented(&self.ledger, simulation).abs());
    }

    /// The largest magnitude relative to the larger of the energy at the start and the peak kinetic energy; 0 where nothing
    /// moves.
    fn drift(&self) -> f64 {
        let scale = self.ledger.energies_at_opening().total().abs().max(self.ledger.peak_kinetic());
        if self.largest == 0.0 { 0.0 } else { self.largest / scale }
    }
}

/// The true motion by two far finer runs, and how far the run is from it.
struct Truth {
    /// One with twice the substeps of the other.
    twins: [Twin; 2],
    /// The largest distance of the run from the finer one, and that of the other one, m.
    errors: [f64; 2],
}

impl Truth {
    fn of(simulation: &Simulation) -> Self {
        let substeps = reference_substeps(&simulation.scene);
        let finer = [substeps.finer(2), substeps];
        // In the reference, damping per tick is replaced by the law that it approximates.
        Self { twins: finer.map(|substeps| Twin::finer(simulation, 1, substeps)), errors: [0.0; 2] }
    }

    fn look(&mut self, simulation: &Simulation) {
        // A run that has lost a body is no longer compared.
        if self.errors[0].is_nan() {
            return;
        }
        self.twins.iter_mut().for_each(Twin::tick);
        let [fine, coarse] = self.twins.each_ref().map(Twin::simulation);
        for (error, run) in self.errors.iter_mut().zip([simulation, coarse]) {
            let farthest = Distances::between(run, fine).farthest(|_| true);
            *error = larger(*error, farthest.map_or(0.0, |(_, distance)| distance));
        }
        if simulation.failure().is_some() {
            self.errors[0] = f64::NAN;
        }
        if self.twins.iter().any(|twin| twin.failure().is_some()) {
            self.errors = [f64::NAN; 2];
        }
    }
}
