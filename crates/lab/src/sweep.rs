//! Sweeps: a scene run once for every combination of the given values.

mod axis;
mod measure;
mod record;
mod run;

use std::ops::ControlFlow;

use motion::Method;
use scene::{Keeps, Scene, SceneError, VariedScene};

use crate::column::Value;
use crate::ordered::ordered;
use crate::shard::Shard;

pub use axis::Axis;
pub use measure::Measure;
pub use record::{FORMAT, Plan, Record};

/// Most values of an axis that are checked from its start.
const PROBES: usize = 64;

/// A sweep before any of its runs.
#[derive(Clone, Debug)]
pub struct Sweep {
    varied: VariedScene,
    plan: Plan,
    /// Whether the values of each axis are all numbers.
    numeric: Vec<bool>,
    /// Bytes of the scene, and of the run that takes most.
    bytes: [u64; 2],
}

/// How a run of a sweep ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// It ran to its end.
    Finished,
    /// It ran to its end, but a body was quarantined.
    Quarantined,
    /// The scene does not allow its values together.
    Refused,
}

impl Outcome {
    /// Its word in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Quarantined => "quarantined",
            Self::Refused => "refused",
        }
    }
}

/// A run of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its number, from 0.
    pub run: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// Its values in the order of [`Plan::columns`].
    pub values: Vec<Value>,
}

impl Sweep {
    /// A sweep over `scene`.
    ///
    /// # Errors
    /// If the scene does not have a place, or does not allow a value beside the first ones of the other axes. A
    /// method that the scene cannot have is no error, unless it can have none of the methods.
    pub fn new(scene: &Scene, plan: Plan) -> Result<Self, SceneError> {
        let firsts: Vec<(&str, &str)> =
            plan.axes.iter().map(|axis| (&*axis.place, &*axis.values[0])).collect();
        let varied = VariedScene::new(scene, &firsts)?;
        let base = beginning(&varied, &plan)?;
        let keeps = plan.keeps();
        let mut largest = base.clone();
        let mut most = varied.scene(&base)?.estimated_bytes(keeps);
        for (at, axis) in plan.axes.iter().enumerate().filter(|(_, axis)| !is_of_methods(axis)) {
            let (mut values, mut most_of_axis) = (base.clone(), 0);
            // The first values, the last and the greatest tell whether all are allowed: many values come from a range.
            let (first, last) = (axis.values.iter().take(PROBES), axis.values.iter().last());
            let numbers = axis.numbers().unwrap_or_default().into_iter().zip(&axis.values);
            let greatest = numbers.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, value)| value);
            for value in first.chain(last).chain(greatest) {
                values[at] = value;
                let bytes = varied.scene(&values)?.estimated_bytes(keeps);
                if bytes > most_of_axis {
                    (most_of_axis, largest[at]) = (bytes, value);
                }
            }
            most = most.max(most_of_axis);
        }
        // A scene that does not allow its largest values together is not run.
        if let Ok(scene) = varied.scene(&largest) {
            most = most.max(scene.estimated_bytes(keeps));
        }
        let numeric = plan.axes.iter().map(|axis| axis.numbers().is_some()).collect();
        let bytes = [scene.estimated_bytes(Keeps::default()), most];
        Ok(Self { varied, plan, numeric, bytes })
    }

    /// Estimated bytes of the scene, which all runs share, and of the run that takes most.
    #[must_use]
    pub const fn estimated_bytes(&self) -> [u64; 2] {
        self.bytes
    }

    /// The plan of the sweep.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The scene of run number `run`.
    ///
    /// # Errors
    /// If the values are not allowed together.
    pub fn scene(&self, run: u64) -> Result<Scene, SceneError> {
        self.varied.scene(&self.plan.values(run))
    }

    /// Runs the part `shard` of the sweep without its first `done` runs, on `threads` threads, and calls `take` with
    /// each row in the order of run numbers, until it breaks.
    pub fn run(
        &self,
        shard: Shard,
        done: u64,
        threads: usize,
        mut take: impl FnMut(Row) -> ControlFlow<()>,
    ) {
        let left = shard.count(self.plan.runs().unwrap_or(0)).saturating_sub(done);
        ordered(left, threads, |place| self.row(shard.nth(done + place)), &mut take);
    }

    /// Simulates run number `run` and returns its row.
    #[must_use]
    pub fn row(&self, run: u64) -> Row {
        let (outcome, why, measured) = match self.scene(run) {
            Ok(scene) => run::run(scene, &self.plan),
            Err(error) => (Outcome::Refused, reason(&error), Vec::new()),
        };
        let mut measured = measured.into_iter();
        let axes =
            self.numeric.iter().zip(self.plan.values(run)).map(|(numeric, value)| {
                match value.parse() {
                    Ok(number) if *numeric => Value::Number(number),
                    _ => Value::Text(value.to_owned()),
                }
            });
        let mut values = vec![Value::Count(run)];
        values.extend(axes);
        values.push(Value::Text(outcome.name().to_owned()));
        values.push(if why.is_empty() { Value::Absent } else { Value::Text(why) });
        let columns: usize = self.plan.measures.iter().map(|measure| measure.columns().len()).sum();
        values.extend((0..=columns).map(|_| measured.next().unwrap_or(Value::Absent)));
        Row { run, outcome, values }
    }
}

/// Why a scene is refused, in one line, without the name of its file.
fn reason(error: &SceneError) -> String {
    let fault = |fault: &scene::Fault| match &fault.path {
        Some(path) => format!("{path}: {}; {}", fault.what, fault.cure),
        None => format!("{}; {}", fault.what, fault.cure),
    };
    error.faults.iter().map(fault).collect::<Vec<_>>().join("; ").replace('\n', " ")
}

/// Whether all values of the axis are methods. Methods that the scene cannot have give refused rows, not an error.
fn is_of_methods(axis: &Axis) -> bool {
    axis.values.iter().all(|value| Method::from_name(value).is_some())
}

/// Values that the scene allows together: of axes other than methods, the first ones.
///
/// # Errors
/// If there are none: the error of the first values.
fn beginning<'p>(varied: &VariedScene, plan: &'p Plan) -> Result<Vec<&'p str>, SceneError> {
    let mut values: Vec<&str> = plan.axes.iter().map(|axis| &*axis.values[0]).collect();
    let Err(error) = varied.scene(&values) else { return Ok(values) };
    for (at, axis) in plan.axes.iter().enumerate().filter(|(_, axis)| is_of_methods(axis)) {
        for value in &axis.values {
            values[at] = value;
            if varied.scene(&values).is_ok() {
                return Ok(values);
            }
        }
    }
    Err(error)
}
