//! Thread CPU time of runs, block by block and in turns with a yardstick.
//!
//! A run is cut into short blocks. It is repeated, and the least time of each block counts: a disturbance rarely hits the same block
//! every time. Other settings run between two runs of the same setting.
//!
//! Whole runs are timed, because ticks of one run differ: conjugate gradients take few iterations on a flag at rest and
//! hundreds on one in the wind.

use std::hint::black_box;

use super::runner::Runner;
use crate::clock::{BLOCK_S, Clock};

/// The times of one setting over all passes.
#[derive(Clone, Debug, Default)]
pub struct Trial {
    /// Ticks of a block; 0 before the first pass.
    block: u64,
    /// Ticks that are timed.
    ticks: u64,
    /// Least time of each block, s.
    least: Vec<f64>,
    /// Time of each pass, s.
    totals: Vec<f64>,
}

impl Trial {
    /// Times one pass: `run` from its start, for `ticks` ticks or until `longest` seconds are spent.
    pub fn pass(&mut self, run: &mut dyn Runner, ticks: u64, longest: f64, clock: &Clock) {
        // The first tick makes columns and caches.
        run.tick();
        if self.block == 0 {
            let start = clock();
            run.tick();
            let tick = (clock() - start).max(1e-9);
            let fit = |seconds: f64| ((seconds / tick) as u64).clamp(1, ticks.max(1));
            self.block = fit(BLOCK_S);
            self.ticks = fit(longest).next_multiple_of(self.block);
        } else {
            run.tick();
        }
        let blocks = (self.ticks / self.block).max(1);
        let mut total = 0.0;
        for number in 0..usize::try_from(blocks).unwrap_or(usize::MAX) {
            let start = clock();
            for _ in 0..self.block {
                run.tick();
            }
            let time = clock() - start;
            total += time;
            match self.least.get_mut(number) {
                Some(least) => *least = least.min(time),
                None => self.least.push(time),
            }
        }
        self.totals.push(total);
    }

    /// Least thread CPU time of a tick, s; `None` before the first pass.
    pub fn tick(&self) -> Option<f64> {
        let ticks = self.least.len() as f64 * self.block as f64;
        (ticks > 0.0).then(|| self.least.iter().sum::<f64>() / ticks)
    }

    /// Quartiles of the passes' times as ratios to the least.
    pub fn quartiles(&self) -> [f64; 3] {
        let least: f64 = self.least.iter().sum();
        let mut totals = self.totals.clone();
        totals.sort_by(f64::total_cmp);
        [1, 2, 3].map(|quarter| match totals.len() {
            0 => 1.0,
            len => totals[(quarter * (len - 1) + 2) / 4] / least,
        })
    }
}

/// A fixed loop of semi-implicit Euler over falling bodies, which is the least that a substep of a body can take. The
/// loop is never changed, so that ratios to it can be compared between versions.
#[derive(Clone, Debug)]
pub struct Yardstick {
    x: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    least: f64,
}

impl Default for Yardstick {
    fn default() -> Self {
        Self { x: vec![[0.0; 3]; 1000], v: vec![[1.0; 3]; 1000], least: f64::INFINITY }
    }
}

impl Yardstick {
    /// Times the loop once more.
    pub fn measure(&mut self, clock: &Clock) {
        const STEPS: u32 = 40;
        let (g, h) = (black_box([0.0, -9.8, 0.0]), black_box(1e-6));
        let start = clock();
        for _ in 0..STEPS {
            for (x, v) in self.x.iter_mut().zip(&mut self.v) {
                for axis in 0..3 {
                    v[axis] += g[axis] * h;
                    x[axis] += v[axis] * h;
                }
            }
        }
        black_box(&self.x);
        let time = (clock() - start) / f64::from(STEPS) / 1e3;
        // A coarse clock may measure 0.
        self.least = self.least.min(time.max(1e-12));
    }

    /// Least thread CPU time of one substep of one body, s.
    pub const fn seconds(&self) -> f64 {
        self.least
    }
}
