//! The ledger of a running session, kept while its panel is open or a run asked for it, and what the panel plots.

use motion::clock::StepClock;
use motion::ledger;
use scene::Substepping;

use crate::stage::Stage;

/// Greatest number of points of a plot: twice as many as there are pixels.
const MOST_POINTS: usize = 2_000;

/// Energies at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Point {
    /// Time of the scene, s.
    pub time: f64,
    /// Kinetic and potential energy, J.
    pub energy: f64,
    pub kinetic: f64,
    /// Residual since the opening, J.
    pub residual: f64,
}

/// Energies over time. When there are too many points, every second one is dropped and half as many are taken from
/// then on.
#[derive(Clone, Debug)]
pub(super) struct History {
    points: Vec<Point>,
    /// Ticks from one point to the next.
    every: u64,
    ticks: u64,
}

impl History {
    fn new(start: Point) -> Self {
        Self { points: vec![start], every: 1, ticks: 0 }
    }

    fn note(&mut self, point: Point) {
        if self.points.last().is_some_and(|last| point.time < last.time) {
            // The scene restarted.
            *self = Self::new(point);
            return;
        }
        self.ticks += 1;
        if !self.ticks.is_multiple_of(self.every) {
            return;
        }
        self.points.push(point);
        if self.points.len() > MOST_POINTS {
            let mut number = 0_u64;
            self.points.retain(|_| {
                number += 1;
                !number.is_multiple_of(2)
            });
            self.every *= 2;
        }
    }

    /// The points, in the order of time.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
}

/// The effect of a method on energy while it was that of the scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Period {
    /// The method in words, with its substeps.
    pub method: String,
    /// Time of the scene at the start of the period, s.
    pub from: f64,
    /// Time of the scene at the end of the period, s.
    pub to: f64,
    /// Residual, J.
    pub residual: f64,
    /// The residual as a fraction of the larger of the energy at the start and the peak kinetic energy.
    pub share: f64,
}

/// A ledger of one method, and its history.
struct Kept {
    ledger: ledger::Ledger,
    history: History,
    /// The method in words, with its substeps.
    method: String,
    /// Time of the scene at its opening, s.
    from: f64,
}

/// The ledger, while it is wanted. It restarts when the scene restarts and when its method changes.
#[derive(Default)]
pub(crate) struct Ledger {
    /// Whether it is kept while its panel is closed, too, and over all methods: for the summary of a run.
    pub always: bool,
    kept: Option<Box<Kept>>,
    /// Periods of earlier methods, the earliest first.
    past: Vec<Period>,
}

/// The method of a stage in words, with its substeps.
pub(super) fn method_of(stage: &Stage) -> String {
    let (stepper, substeps) = (&stage.sim().stepper, stage.sim().substeps());
    let method = match stepper.plan().own.is_empty() {
        true => stepper.method().claims().title,
        false => "several methods",
    };
    if substeps == Substepping::Fixed(1) {
        method.to_owned()
    } else {
        format!("{method} x {substeps:#}")
    }
}

fn point(ledger: &ledger::Ledger, time: f64) -> Point {
    let energies = ledger.energies();
    Point {
        time,
        energy: energies.total(),
        kinetic: energies.kinetic,
        residual: ledger.since_opening().energy.residual,
    }
}

fn scene_seconds(stage: &Stage) -> f64 {
    stage.sim().world.resource::<StepClock>().scene_seconds()
}

impl Ledger {
    /// The ledger, if one is kept.
    pub fn kept(&self) -> Option<&ledger::Ledger> {
        self.kept.as_ref().map(|kept| &kept.ledger)
    }

    /// The ledger for the next tick, if one is kept.
    pub fn kept_mut(&mut self) -> Option<&mut ledger::Ledger> {
        self.kept.as_mut().map(|kept| &mut kept.ledger)
    }

    /// The points that the panel plots.
    pub(super) fn points(&self) -> &[Point] {
        self.kept.as_ref().map_or(&[], |kept| kept.history.points())
    }

    /// Periods of earlier methods since the scene began, the earliest first.
    pub(super) fn past(&self) -> &[Period] {
        &self.past
    }

    /// Opens the ledger when it is first wanted, and forgets it when it is not.
    pub fn keep(&mut self, stage: &Stage, wanted: bool) {
        if !wanted {
            self.close();
        } else if self.kept.is_none() {
            let (ledger, from) = (ledger::Ledger::open(&stage.sim().world), scene_seconds(stage));
            let history = History::new(point(&ledger, from));
            self.kept = Some(Box::new(Kept { ledger, history, method: method_of(stage), from }));
        }
    }

    /// Closes the ledger until it is wanted again.
    pub fn close(&mut self) {
        self.kept = None;
        self.past.clear();
    }

    /// Restarts the ledger if one is kept: the run continues from another tick.
    pub fn reopen(&mut self, stage: &Stage) {
        let kept = self.kept.is_some();
        self.close();
        self.keep(stage, kept);
    }

    /// Restarts the ledger if the method has changed: the totals are those of the earlier method.
    pub fn follow_method(&mut self, stage: &Stage) {
        let changed = self.kept.take_if(|kept| !self.always && kept.method != method_of(stage));
        let Some(Kept { ledger, method, from, .. }) = changed.map(|kept| *kept) else { return };
        if ledger.seconds() > 0.0 {
            let (residual, share) =
                (ledger.since_opening().energy.residual, ledger.relative_residual());
            self.past.push(Period { method, from, to: scene_seconds(stage), residual, share });
        }
        self.keep(stage, true);
    }

    /// Notes the energies after a tick, if a ledger is kept.
    pub fn note(&mut self, stage: &Stage) {
        if let Some(Kept { ledger, history, .. }) = self.kept.as_deref_mut() {
            history.note(point(ledger, scene_seconds(stage)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_stays_short_keeps_its_start_and_goes_on_evenly() {
        let point = |tick: u32| Point { time: f64::from(tick), ..Point::default() };
        let mut history = History::new(point(0));
        for tick in 1..=50_000 {
            history.note(point(tick));
            assert!(history.points().len() <= MOST_POINTS);
        }
        let points = history.points();
        assert!(points.len() > MOST_POINTS / 2 - 1, "{}", points.len());
        assert_eq!(points[0], point(0));
        let step = points[1].time;
        assert!(
            points.windows(2).all(|pair| pair[1].time - pair[0].time == step),
            "every {step} ticks"
        );
        assert!(50_000.0 - points[points.len() - 1].time < step);
    }
}
