//! The search for cures: the least number of substeps, and the first method, with which a trial finds no fault.

use motion::margin::{Cure, as_good_as};
use motion::{Method, Substeps};
use scene::{Substepping, unsolvable};

use super::judge::Run;

enum Phase {
    /// Has the bodies choose.
    Choosing,
    /// Doubles the number of substeps until one holds.
    Doubling,
    /// Halves the interval between the largest number that fails and the least that holds.
    Halving,
    Methods,
}

/// A search in progress.
pub(super) struct Search {
    method: Method,
    substeps: Substepping,
    error: f64,
    phase: Phase,
    /// Largest number of substeps that fails, and least that holds.
    interval: [u32; 2],
    methods: std::vec::IntoIter<Method>,
    /// The setting that is tried.
    now: (Method, Substepping),
    found: Cure,
    /// Steps per tick where the bodies chose.
    chosen: f64,
    gave_up: bool,
    /// The run of that setting.
    pub run: Option<Run>,
}

impl Search {
    /// A search for cures of what has a fault with `method` and `substeps`; they may be chosen for an error of a tick of `error`, m.
    pub fn new(method: Method, substeps: Substepping, error: f64) -> Self {
        let mut others: Vec<_> = as_good_as(method).filter(|other| *other != method).collect();
        // Over a longer time it gains energy wherever nothing damps.
        others.sort_by_key(|other| *other == Method::ExplicitEuler);
        Self {
            method,
            substeps,
            error,
            phase: if substeps.fixed().is_some() { Phase::Choosing } else { Phase::Methods },
            interval: [substeps.least(); 2],
            methods: others.into_iter(),
            now: (method, substeps),
            found: Cure::default(),
            chosen: 0.0,
            gave_up: false,
            run: None,
        }
    }

    /// The next setting to try, with up to `most` substeps.
    pub fn next(&mut self, most: u32, attracts: bool) -> Option<(Method, Substepping)> {
        let most = most.clamp(2, Substeps::MOST);
        loop {
            let [low, high] = self.interval;
            match self.phase {
                Phase::Choosing => {
                    self.now = (self.method, Substepping::auto(self.error).up_to(most));
                    return Some(self.now);
                }
                Phase::Doubling if low >= most => self.phase = Phase::Methods,
                Phase::Doubling => {
                    self.now = (self.method, low.saturating_mul(2).min(most).into());
                    return Some(self.now);
                }
                Phase::Halving if high - low > 1 => {
                    self.now = (self.method, low.midpoint(high).into());
                    return Some(self.now);
                }
                Phase::Halving => {
                    self.found.substeps = Some(high);
                    self.phase = Phase::Methods;
                }
                Phase::Methods => {
                    let mut solving = self
                        .methods
                        .by_ref()
                        .filter(|method| unsolvable(*method, attracts).is_none());
                    self.now = (solving.next()?, self.substeps);
                    return Some(self.now);
                }
            }
        }
    }

    /// Ends the search with what was found.
    pub fn give_up(&mut self) {
        (self.run, self.gave_up) = (None, true);
        if matches!(self.phase, Phase::Halving) {
            self.found.substeps = Some(self.interval[1]);
        }
        (self.phase, self.methods) = (Phase::Methods, Vec::new().into_iter());
    }

    /// Steps per tick of the setting that is tried, so far.
    pub fn steps(&self) -> f64 {
        let (_, substeps) = self.now;
        let chosen = self.run.as_ref().filter(|_| substeps.fixed().is_none()).map(Run::steps);
        chosen.unwrap_or_else(|| f64::from(substeps.least()))
    }

    /// Whether the setting that is tried holds.
    pub fn answer(&mut self, holds: bool) {
        let steps = self.run.take().map_or(f64::INFINITY, |run| run.steps());
        let (method, substeps) = self.now;
        match (&self.phase, holds) {
            (Phase::Choosing, _) => {
                self.found.error = Some(self.error).filter(|_| holds);
                (self.phase, self.chosen) = (Phase::Doubling, steps);
            }
            (Phase::Methods, true) => {
                self.found.method = Some(method);
                self.methods = Vec::new().into_iter();
            }
            (Phase::Methods, false) => {}
            (_, true) => (self.phase, self.interval[1]) = (Phase::Halving, substeps.least()),
            (_, false) => self.interval[0] = substeps.least(),
        }
    }

    /// The cures that were found, and whether all were tried.
    pub fn result(&self) -> (Cure, bool) {
        let Cure { substeps, error, .. } = self.found;
        let few = substeps.is_none_or(|substeps| 2.0 * self.chosen < f64::from(substeps));
        (Cure { error: error.filter(|_| few), ..self.found }, !self.gave_up)
    }
}
