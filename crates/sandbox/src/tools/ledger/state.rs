//! The ledger of a running session, kept while its panel is open or a run asked for it, and what the panel plots.

use motion::ledger::Ledger;

use crate::app::session::Session;
use crate::app::ui::Panel;

/// Points that a plot has at most: twice as many as there are pixels.
const MOST_POINTS: usize = 2_000;

/// Energies at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Point {
    /// Simulated time, s.
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
pub(crate) struct History {
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

/// A ledger and its history.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub ledger: Ledger,
    pub history: History,
}

impl Kept {
    fn point(ledger: &Ledger, time: f64) -> Point {
        let energies = ledger.energies();
        Point {
            time,
            energy: energies.total(),
            kinetic: energies.kinetic,
            residual: ledger.since_opening().energy.residual,
        }
    }
}

impl Session {
    /// Keeps books of energy and momentum from now on, whether the panel is open or not.
    pub fn keep_ledger(&mut self) {
        self.ledger_asked = true;
        self.open_or_close_ledger();
    }

    /// The books, if any are kept.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger> {
        self.ledger.as_ref().map(|kept| &kept.ledger)
    }

    /// What the panel plots.
    pub(crate) fn ledger_points(&self) -> &[Point] {
        self.ledger.as_ref().map_or(&[], |kept| kept.history.points())
    }

    /// Opens the ledger when it is first wanted, and forgets it when it is not.
    pub(crate) fn open_or_close_ledger(&mut self) {
        if !(self.ui.shows(Panel::Ledger) || self.ledger_asked) {
            self.ledger = None;
        } else if self.ledger.is_none() {
            let ledger = Ledger::open(&mut self.sim.world);
            let history = History::new(Kept::point(&ledger, self.simulated()));
            self.ledger = Some(Box::new(Kept { ledger, history }));
        }
    }

    /// One tick, booked if books are kept and watched if it is recorded.
    pub(crate) fn tick(&mut self) {
        let mut kept = self.ledger.take();
        let books = kept.as_mut().map(|kept| &mut kept.ledger);
        match (&mut self.recorded, books) {
            (Some(recorded), books) => recorded.tick(&mut self.sim, books),
            (None, Some(books)) => books.tick(&mut self.sim.stepper, &mut self.sim.world),
            (None, None) => self.sim.tick(),
        }
        if let Some(kept) = &mut kept {
            kept.history.note(Kept::point(&kept.ledger, self.simulated()));
        }
        self.ledger = kept;
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
        assert!(points.windows(2).all(|pair| pair[1].time - pair[0].time == step), "every {step} ticks");
        assert!(50_000.0 - points[points.len() - 1].time < step);
    }
}
