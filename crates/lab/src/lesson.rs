//! What lessons measure: quantities of a simulation, and the runs that are made for a lesson.

use std::collections::BTreeMap;

use crate::clock::thread_time;
use crate::cost::larger;
use history::{Change, Distances, Overrides, Simulation, Twin, rate_of};
use motion::clock::StepClock;
use motion::effects::{self, Effect, EffectState};
use motion::units::Vector;
use motion::{Damping, Evaluations, Gravity, PhysicsBody, Quarantine, TimeStep, Transform, totals};
use scene::lesson::{Axis, Lesson, LessonRun, Measure, Quantity, RunMeasure, beside};
use scene::{Scene, SceneError};

/// Values of quantities by name, and what they were before: see [`Quantity`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantities(BTreeMap<String, Values>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Values {
    now: f64,
    before: f64,
    most: f64,
    least: f64,
}

impl Quantities {
    /// Notes the present value of a quantity.
    pub fn note(&mut self, name: &str, now: f64) {
        match self.0.get_mut(name) {
            Some(values) => {
                values.now = now;
                (values.most, values.least) = (values.most.max(now), values.least.min(now));
            }
            None => {
                self.0.insert(name.to_owned(), Values { now, before: now, most: now, least: now });
            }
        }
    }

    /// Starts a new period: `_before`, `_most` and `_least` become the present values.
    pub fn begin(&mut self) {
        for Values { now, before, most, least } in self.0.values_mut() {
            (*before, *most, *least) = (*now, *now, *now);
        }
    }

    /// Forgets all values; the next note of a quantity also sets its `_before`.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// Adds all of `other`.
    pub fn extend(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// The value of `name`, which may end in `_before`, `_most` or `_least`.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        if let Some(values) = self.0.get(name) {
            return Some(values.now);
        }
        let (name, part) = name.rsplit_once('_')?;
        let values = self.0.get(name)?;
        // A removed body has no value, so its earlier values are not given either.
        if values.now.is_nan() {
            return Some(f64::NAN);
        }
        match part {
            "before" => Some(values.before),
            "most" => Some(values.most),
            "least" => Some(values.least),
            _ => None,
        }
    }
}

/// The value of `measure` in `simulation`; NaN for a body that was removed, and
/// for the error, which one run alone does not have.
#[must_use]
pub fn measured(simulation: &Simulation, measure: &RunMeasure) -> f64 {
    let state = |name: &str| {
        let body = simulation.world.get_entity(simulation.named(name)?).ok()?;
        Some((body.get::<Transform>()?.position, *body.get::<PhysicsBody>()?))
    };
    let position = |name: &str| state(name).map(|(position, _)| position);
    let world = &simulation.world;
    let value = match measure {
        RunMeasure::Time => Some(world.resource::<StepClock>().scene_seconds()),
        RunMeasure::Position(body, axis) => position(body).map(|v| along(v, *axis)),
        RunMeasure::Velocity(body, axis) => {
            state(body).map(|(_, body)| along(body.velocity, *axis))
        }
        RunMeasure::Speed(body) => state(body).map(|(_, body)| body.velocity.length()),
        RunMeasure::Mass(body) => state(body).map(|(_, body)| 1.0 / body.inverse_mass),
        RunMeasure::Distance(one, other) => {
            position(one).zip(position(other)).map(|(one, other)| one.distance(other))
        }
        RunMeasure::Energy => {
            let totals = totals(&simulation.world);
            Some(totals.kinetic_energy + totals.potential_energy)
        }
        RunMeasure::KineticEnergy => Some(totals(&simulation.world).kinetic_energy),
        RunMeasure::Momentum(axis) => Some(along(totals(&simulation.world).momentum, *axis)),
        RunMeasure::Gravity => {
            let gravity = world.get_resource::<Gravity>().filter(|gravity| gravity.on);
            Some(gravity.map_or(0.0, |gravity| gravity.acceleration.length()))
        }
        RunMeasure::Damping => {
            let on = effects::state(&simulation.world, Effect::Damping) == EffectState::On;
            let damping = simulation.world.get_resource::<Damping>().filter(|_| on);
            Some(damping.map_or(0.0, |damping| damping.rate))
        }
        RunMeasure::StepHz => Some(rate_of(world.resource::<TimeStep>().0)),
        RunMeasure::Substeps => Some(f64::from(simulation.substeps().least())),
        RunMeasure::Method(method) => Some(f64::from(u8::from(simulation.method() == *method))),
        #[expect(clippy::cast_precision_loss, reason = "a count")]
        RunMeasure::Evaluations => Some(world.resource::<Evaluations>().accelerations() as f64),
        #[expect(clippy::cast_precision_loss, reason = "a count")]
        RunMeasure::Quarantined => Some(world.resource::<Quarantine>().records().len() as f64),
        RunMeasure::Error => None,
    };
    value.unwrap_or(f64::NAN)
}

fn along(v: Vector, axis: Axis) -> f64 {
    match axis {
        Axis::X => v.x,
        Axis::Y => v.y,
        Axis::Z => v.z,
    }
}

/// Longest time of all runs of a lesson together, and what helps where it is too short.
#[derive(Clone, Copy, Debug)]
pub struct RunLimit {
    /// Time of the thread on its processor, s.
    pub seconds: f64,
    /// The cure, in words.
    pub cure: &'static str,
}

impl RunLimit {
    /// The limit of commands and of lessons that are part of the program.
    pub const USUAL: Self =
        Self { seconds: 60.0, cure: "give fewer or shorter runs, larger steps or fewer bodies" };
}

/// What the runs of `lesson` measure, with `times` as many ticks per second as they say.
///
/// # Errors
/// If a scene cannot be read, or if the runs together take longer than `limit`.
pub fn run_lesson(lesson: &Lesson, times: f64, limit: RunLimit) -> Result<Quantities, SceneError> {
    let mut runs = LessonRuns::new(lesson, times, scene::load)?;
    if runs.work(limit.seconds) {
        return Ok(runs.all);
    }
    let number = lesson.runs.len() - 1 - runs.left.len();
    let seconds = runs.present.as_ref().map_or(0.0, |run| run.simulation.seconds());
    let (what, of) = (limit.seconds, lesson.runs[number].seconds);
    let what = format!(
        "its runs take more than {what} s: runs[{number}] came to {seconds:.3} s of {of} s"
    );
    Err(SceneError::of_file(&lesson.name, what, limit.cure))
}

/// The runs of a lesson, in slices.
pub struct LessonRuns {
    /// The later runs, the next one last, and their scenes.
    left: Vec<(Scene, LessonRun)>,
    present: Option<Measured>,
    all: Quantities,
}

impl LessonRuns {
    /// Prepares the runs of `lesson`, with `times` as many ticks per second as they say. `load` reads a scene by its name.
    ///
    /// # Errors
    /// If a scene cannot be read.
    pub fn new(
        lesson: &Lesson,
        times: f64,
        mut load: impl FnMut(&str) -> Result<Scene, SceneError>,
    ) -> Result<Self, SceneError> {
        let scene = |run: &LessonRun| {
            let name = run.scene.as_ref().unwrap_or(&lesson.scene);
            let mut scene = load(&beside(&lesson.name, name))?;
            let step_hz = Some(run.step_hz.unwrap_or(scene.step_hz) * times);
            Overrides { method: run.method, step_hz, substeps: run.substeps, damping: None }
                .apply(&mut scene);
            Ok((scene, run.clone()))
        };
        let mut left = lesson.runs.iter().map(scene).collect::<Result<Vec<_>, _>>()?;
        left.reverse();
        Ok(Self { left, present: None, all: Quantities::default() })
    }

    /// Simulates until `seconds` of the thread's time have passed. Returns whether all runs are done.
    pub fn work(&mut self, seconds: f64) -> bool {
        let start = thread_time();
        loop {
            if let Some(done) = self.present.take_if(|run| run.ticks == 0) {
                self.all.extend(done.quantities);
            }
            if self.present.is_none() {
                let Some((scene, run)) = self.left.pop() else { return true };
                self.present = Some(Measured::begin(scene, run));
            }
            if let Some(run) = self.present.as_mut().filter(|run| run.ticks > 0) {
                if thread_time() - start > seconds {
                    return false;
                }
                run.tick();
            }
        }
    }

    /// What all runs together measured.
    #[must_use]
    pub fn measured(self) -> Quantities {
        self.all
    }
}

/// A run that is measured.
struct Measured {
    simulation: Simulation,
    reference: Option<Twin>,
    measure: Vec<Quantity>,
    /// Ticks that are left.
    ticks: u64,
    quantities: Quantities,
    farthest: f64,
}

impl Measured {
    fn begin(scene: Scene, LessonRun { start, measure, seconds, .. }: LessonRun) -> Self {
        let ticks = scene.ticks_in(seconds);
        let mut simulation = Simulation::new(scene);
        let has_error =
            measure.iter().any(|quantity| quantity.measure == Measure::Run(RunMeasure::Error));
        let mut reference = has_error.then(|| Twin::reference(&simulation));
        let mut quantities = Quantities::default();
        note(&mut quantities, &measure, &simulation, 0.0);
        for action in &start {
            // Bodies are named that the scene has: the lesson was checked against it.
            if let Ok(change) = Change::of(action, &simulation) {
                simulation.give(&change);
                reference.iter_mut().for_each(|reference| reference.give(&change));
            }
        }
        Self { simulation, reference, measure, ticks, quantities, farthest: 0.0 }
    }

    fn tick(&mut self) {
        let Self { simulation, reference, farthest, .. } = self;
        simulation.tick();
        if let Some(reference) = reference {
            reference.tick();
            let apart = Distances::between(simulation, reference.simulation()).farthest(|_| true);
            *farthest = larger(*farthest, apart.map_or(f64::NAN, |(_, distance)| distance));
        }
        note(&mut self.quantities, &self.measure, simulation, *farthest);
        self.ticks -= 1;
    }
}

fn note(quantities: &mut Quantities, measure: &[Quantity], simulation: &Simulation, error: f64) {
    for Quantity { name, measure } in measure {
        let value = match measure {
            Measure::Run(RunMeasure::Error) => error,
            Measure::Run(measure) => measured(simulation, measure),
            Measure::Screen(_) => f64::NAN,
        };
        quantities.note(name, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_remembers_its_start_and_its_extremes() {
        let mut all = Quantities::default();
        for value in [2.0, 5.0, -1.0, 3.0] {
            all.note("v", value);
        }
        let values = ["v", "v_before", "v_most", "v_least"].map(|name| all.value(name));
        assert_eq!(values, [3.0, 2.0, 5.0, -1.0].map(Some));
        assert_eq!(all.value("w"), None);
        assert_eq!(all.value("v_worst"), None);
        all.begin();
        all.note("v", 4.0);
        let values = ["v", "v_before", "v_most", "v_least"].map(|name| all.value(name));
        assert_eq!(values, [4.0, 3.0, 4.0, 3.0].map(Some));
    }
}
