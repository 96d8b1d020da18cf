//! The search for cures: the least number of substeps, and the first method, with which a trial finds no fault.

use motion::margin::{Cure, as_good_as};
use motion::{Method, Substeps};
use scene::unsolvable;

use super::judge::Run;

enum Phase {
    /// Doubles the number of substeps until one holds.
    Doubling,
    /// Halves the interval between the largest number that fails and the least that holds.
    Halving,
    Methods,
}

/// A search in progress.
pub(super) struct Search {
    method: Method,
    substeps: u32,
    phase: Phase,
    /// Largest number of substeps that fails, and least that holds.
    interval: [u32; 2],
    methods: std::vec::IntoIter<Method>,
    /// The setting that is tried.
    now: (Method, u32),
    found: Cure,
    gave_up: bool,
    /// The run of that setting.
    pub run: Option<Run>,
}

impl Search {
    /// A search for cures of what has a fault with `method` and `substeps`.
    pub fn new(method: Method, substeps: u32) -> Self {
        let mut others: Vec<_> = as_good_as(method).filter(|other| *other != method).collect();
        // Over a longer time it gains energy wherever nothing damps.
        others.sort_by_key(|other| *other == Method::ExplicitEuler);
        Self {
            method,
            substeps,
            phase: Phase::Doubling,
            interval: [substeps, substeps],
            methods: others.into_iter(),
            now: (method, substeps),
            found: Cure::default(),
            gave_up: false,
            run: None,
        }
    }

    /// The next setting to try, with up to `most` substeps.
    pub fn next(&mut self, most: u32, attracts: bool) -> Option<(Method, u32)> {
        let most = most.clamp(2, Substeps::MOST);
        loop {
            let [low, high] = self.interval;
            match self.phase {
                Phase::Doubling if low >= most => self.phase = Phase::Methods,
                Phase::Doubling => {
                    self.now = (self.method, low.saturating_mul(2).min(most));
                    return Some(self.now);
                }
                Phase::Halving if high - low > 1 => {
                    self.now = (self.method, low.midpoint(high));
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

    /// Substeps of the setting that is tried.
    pub const fn substeps(&self) -> u32 {
        self.now.1
    }

    /// Whether the setting that is tried holds.
    pub fn answer(&mut self, holds: bool) {
        self.run = None;
        let (method, substeps) = self.now;
        match (&self.phase, holds) {
            (Phase::Methods, true) => {
                self.found.method = Some(method);
                self.methods = Vec::new().into_iter();
            }
            (Phase::Methods, false) => {}
            (_, true) => (self.phase, self.interval[1]) = (Phase::Halving, substeps),
            (_, false) => self.interval[0] = substeps,
        }
    }

    /// The cures that were found, and whether all were tried.
    pub const fn result(&self) -> (Cure, bool) {
        (self.found, !self.gave_up)
    }
}
