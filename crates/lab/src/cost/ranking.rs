//! How methods rank by the time of a step: the time of a tick as a line, ties, and sizes at which two change places.

use std::cmp::Ordering;

use motion::Method;
use scene::Substepping;

use super::record::{Cell, Host, Setting, Study, TickTime, Time, TimedTick};

const HOSTS: [Host; 2] = [Host::World, Host::Arithmetic];

/// Relative noise of a time: how far the median of the passes lies above the least.
fn spread(quartiles: [f64; 3]) -> f64 {
    (quartiles[1] - 1.0).max(0.0)
}

impl TimedTick {
    /// Compares two times; `None` for a tie, if they differ by no more than the spread of their passes.
    fn compare(&self, other: &Self) -> Option<Ordering> {
        let noise = (self.ns * spread(self.quartiles)).max(other.ns * spread(other.quartiles));
        ((self.ns - other.ns).abs() > noise).then(|| self.ns.total_cmp(&other.ns))
    }
}

impl TickTime {
    /// The times at `points`, without a fitted line yet.
    pub(crate) fn unfitted(setting: Setting, host: Host, points: Vec<TimedTick>) -> Self {
        let (fixed_ns, ns_per_body_step, yardstick_ns) = (0.0, 0.0, 1.0);
        Self {
            method: setting.method,
            host,
            fixed_ns,
            ns_per_body_step,
            substeps: None,
            yardstick_ns,
            points,
        }
    }

    pub(crate) fn is_of(&self, setting: Setting, host: Host) -> bool {
        (self.method, self.host) == (setting.method, host)
    }

    /// Fits the line through its points.
    pub(crate) fn fit(self) -> Self {
        let (fixed_ns, ns_per_body_step) = line(&self.points);
        Self { fixed_ns, ns_per_body_step, ..self }
    }

    /// The tick of that size, if it was timed.
    fn at(&self, body_steps: f64) -> Option<&TimedTick> {
        self.points.iter().find(|point| point.body_steps.to_bits() == body_steps.to_bits())
    }
}

/// Intercept and slope, neither below 0, with the least sum of relative deviations. Such a line passes through two of
/// the points, or through one if its intercept or slope is 0: all of them are tried. A disturbed measurement of one size bends
/// it little.
fn line(points: &[TimedTick]) -> (f64, f64) {
    let single = |point: &TimedTick| [(point.ns, 0.0), (0.0, point.ns / point.body_steps)];
    let through = |a: &TimedTick, b: &TimedTick| {
        let slope = (b.ns - a.ns) / (b.body_steps - a.body_steps);
        (a.ns - slope * a.body_steps, slope)
    };
    let pairs =
        points.iter().enumerate().flat_map(|(i, b)| points[..i].iter().map(move |a| through(a, b)));
    let off = |(fixed, slope): &(f64, f64)| -> f64 {
        points.iter().map(|point| ((fixed + slope * point.body_steps) / point.ns - 1.0).abs()).sum()
    };
    pairs
        .chain(points.iter().flat_map(single))
        .filter(|(fixed, slope)| *fixed >= 0.0 && *slope >= 0.0)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap_or_default()
}

/// A method's place by the time of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The method.
    pub method: Method,
    /// Thread CPU time per body per step at [`Study::size`] bodies, ns.
    pub ns_per_body_step: f64,
    /// Relative excess of the median of the passes over that time.
    pub spread: f64,
    /// Whether it shares the rank of the place before: it ties with the first of that rank.
    pub tied: bool,
    /// Its rank, from 1.
    pub rank: usize,
}

impl Place {
    /// The place that others are compared with: that of semi-implicit Euler, or the first.
    pub fn base(places: &[Self]) -> Option<&Self> {
        places.iter().find(|place| place.method == Method::SemiImplicitEuler).or(places.first())
    }
}

/// The time of a step of this program relative to that of the arithmetic alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverArithmetic {
    /// The method.
    pub method: Method,
    /// The ratio of the least times of all passes.
    pub times: f64,
    /// Relative excess of the median of the passes over the least, the larger one of the two hosts.
    pub spread: f64,
}

/// A size at which two methods change places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The method with the shorter step above that size.
    pub above: Method,
    /// The method with the shorter step below that size.
    pub below: Method,
    /// Bodies times steps of a tick.
    pub body_steps: f64,
}

impl Study {
    /// Number of bodies that times refer to.
    pub fn size(&self) -> usize {
        self.timed_bodies.unwrap_or(self.bodies).max(1)
    }

    /// Bodies times steps of the tick that methods are ranked at: one step of [`Self::size`] bodies, or the scene's own
    /// tick.
    fn ranked_at(&self) -> f64 {
        let steps = if self.timed_bodies.is_some() { 1 } else { self.own.substeps.least() };
        self.size() as f64 * f64::from(steps)
    }

    /// Times of ticks in the world, in the order of the table of methods.
    pub fn world_times(&self) -> impl Iterator<Item = &TickTime> {
        self.times_in(Host::World)
    }

    fn times_in(&self, host: Host) -> impl Iterator<Item = &TickTime> {
        self.tick_times.iter().filter(move |times| times.host == host)
    }

    /// Methods by the time of a step at [`Self::size`] bodies, the shortest first.
    pub fn ranking(&self, host: Host) -> Vec<Place> {
        let at = self.ranked_at();
        let mut timed: Vec<_> =
            self.times_in(host).filter_map(|times| Some((times.method, times.at(at)?))).collect();
        timed.sort_by(|(_, a), (_, b)| a.ns.total_cmp(&b.ns));
        let (mut first, mut rank): (Option<&TimedTick>, _) = (None, 0);
        let place = |(i, (method, tick)): (usize, (Method, _))| {
            let tied = first.is_some_and(|first| first.compare(tick).is_none());
            if !tied {
                first = Some(tick);
                rank = i + 1;
            }
            let spread = spread(tick.quartiles);
            Place { method, ns_per_body_step: tick.ns / at, spread, tied, rank }
        };
        timed.into_iter().enumerate().map(place).collect()
    }

    /// The time of a step of this program relative to that of the arithmetic alone, by method.
    pub fn over_arithmetic(&self) -> Vec<OverArithmetic> {
        let alone = self.ranking(Host::Arithmetic);
        let over = |place: Place| {
            let own = alone.iter().find(|own| own.method == place.method)?;
            Some(OverArithmetic {
                method: place.method,
                times: place.ns_per_body_step / own.ns_per_body_step,
                spread: place.spread.max(own.spread),
            })
        };
        self.ranking(Host::World).into_iter().filter_map(over).collect()
    }

    /// The sizes at which the ranking changes, ascending, interpolated linearly between sizes that were timed. Ties
    /// change nothing.
    pub fn crossings(&self) -> Vec<Crossing> {
        let times: Vec<_> = self.world_times().collect();
        let pairs = (0..times.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let mut found: Vec<_> = pairs.flat_map(|(a, b)| crossings(times[a], times[b])).collect();
        found.sort_by(|a, b| a.body_steps.total_cmp(&b.body_steps));
        found
    }

    /// The sizes of copies that were timed, ascending; empty for a scene.
    pub fn sizes(&self) -> Vec<usize> {
        let copies = self.world_times().filter(|times| times.substeps.is_some());
        // A tick of copies is one step, so that its body steps are its bodies.
        let mut sizes: Vec<_> = copies
            .flat_map(|times| times.points.iter().map(|point| point.body_steps as usize))
            .collect();
        sizes.sort_unstable();
        sizes.dedup();
        sizes
    }

    /// This study with the times of copies with `bodies` bodies, one of [`Self::sizes`].
    pub fn at_size(&self, bodies: usize) -> Self {
        let mut study = Self { timed_bodies: Some(bodies), ..self.clone() };
        study.time_cells();
        study
    }

    /// Gives every cell that finished the time of its method's steps at [`Self::size`] bodies.
    pub(crate) fn time_cells(&mut self) {
        let times = |cell: &Cell, host| cell.errors().and_then(|_| self.time_at_size(cell, host));
        let times: Vec<_> =
            self.cells.iter().map(|cell| HOSTS.map(|host| times(cell, host))).collect();
        for (cell, times) in self.cells.iter_mut().zip(times) {
            [cell.time, cell.arithmetic_time] = times;
        }
    }

    /// The time of the cell's method in a tick of one step of copies; `None` for a scene.
    fn time_at_size(&self, cell: &Cell, host: Host) -> Option<Time> {
        let (bodies, setting) = (self.size() as f64, cell.setting);
        let times = self.tick_times.iter().find(|times| times.is_of(setting, host))?;
        let tick = times.at(bodies)?;
        let ns = tick.ns * self.solver_share(cell, times.substeps?);
        Some(Time {
            ns_per_body_step: ns / bodies,
            real_time_factor: self.step_s(setting) / (1e-9 * ns),
            yardsticks: ns / bodies / times.yardstick_ns,
            quartiles: tick.quartiles,
        })
    }

    /// Factor from the time of a step of the cell's method at `substeps`, which was timed, to that of the cell: the ratio of
    /// their evaluations, because the iterations of a solver depend on the step. 1 without a solver.
    fn solver_share(&self, cell: &Cell, substeps: u32) -> f64 {
        let per_step = |cell: &Cell| {
            (cell.counts.accelerations + cell.counts.solver) as f64 / self.steps(cell)
        };
        let timed = self.curve(cell.setting.method).find(|cell| {
            cell.setting.substeps == Substepping::Fixed(substeps) && cell.counts.solver > 0
        });
        timed.map_or(1.0, |timed| per_step(cell) / per_step(timed))
    }

    /// Fits the time of a tick of a scene, as a line over its ladder of substeps, to the times of its cells.
    pub(crate) fn fit_substeps(&mut self, setting: Setting, host: Host) {
        let bodies = self.size() as f64;
        let timed = |cell: &Cell| {
            let Time { ns_per_body_step, quartiles, yardsticks, .. } = cell.time_in(host)?;
            let body_steps = bodies * self.steps(cell);
            let tick = TimedTick { body_steps, ns: ns_per_body_step * body_steps, quartiles };
            Some((tick, ns_per_body_step / yardsticks))
        };
        let cells = self.curve(setting.method);
        let (points, yardsticks): (Vec<_>, Vec<_>) = cells.filter_map(timed).unzip();
        let yardstick_ns = yardsticks.into_iter().fold(f64::INFINITY, f64::min);
        // One point alone does not show the fixed cost.
        if points.len() < 2 {
            return;
        }
        let timed = TickTime { yardstick_ns, ..TickTime::unfitted(setting, host, points) }.fit();
        match self.tick_times.iter_mut().find(|times| times.is_of(setting, host)) {
            Some(times) => *times = timed,
            None => self.tick_times.push(timed),
        }
    }

    /// Part by which the times of two methods may differ by chance.
    pub(crate) fn largest_spread(&self, methods: [Method; 2], host: Host) -> f64 {
        methods.map(|method| self.spread(method, host)).into_iter().fold(0.0, f64::max)
    }

    fn spread(&self, method: Method, host: Host) -> f64 {
        let times = self.curve(method).filter_map(|cell| cell.time_in(host));
        let mut spreads: Vec<_> = times.map(|time| spread(time.quartiles)).collect();
        spreads.sort_by(f64::total_cmp);
        spreads.get(spreads.len() / 2).copied().unwrap_or(0.0)
    }
}

/// The sizes at which `a` and `b` change places.
fn crossings(a: &TickTime, b: &TickTime) -> Vec<Crossing> {
    let both = a.points.iter().filter_map(|tick| Some((tick, b.at(tick.body_steps)?)));
    let clear = both.filter_map(|(a, b)| Some((a.body_steps, a.ns - b.ns, a.compare(b)?)));
    let clear: Vec<_> = clear.collect();
    let flips = clear.windows(2).filter(|pair| pair[0].2 != pair[1].2);
    flips
        .map(|pair| {
            let [(from, before, _), (to, after, order)] = [pair[0], pair[1]];
            let (above, below) =
                if order == Ordering::Less { (a.method, b.method) } else { (b.method, a.method) };
            let body_steps = from + (to - from) * before / (before - after);
            Crossing { above, below, body_steps }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(body_steps: f64, ns: f64) -> TimedTick {
        TimedTick { body_steps, ns, quartiles: [1.0, 1.01, 1.02] }
    }

    #[test]
    fn a_line_is_fitted_past_a_disturbed_size() {
        let of = |n: f64| tick(n, 700.0 + 5.0 * n);
        let mut points = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5].map(of).to_vec();
        points[3].ns *= 1.6;
        let (fixed, slope) = line(&points);
        assert!(
            (fixed / 700.0 - 1.0).abs() < 1e-9 && (slope / 5.0 - 1.0).abs() < 1e-9,
            "{fixed} {slope}"
        );
        // Ticks whose time grows less than in proportion at first do not give a negative fixed cost.
        let (fixed, slope) = line(&[tick(1.0, 1.0), tick(10.0, 10.0), tick(1e5, 2e5)]);
        assert!(fixed == 0.0 && (slope - 1.0).abs() < 1e-9, "{fixed} {slope}");
    }
}
