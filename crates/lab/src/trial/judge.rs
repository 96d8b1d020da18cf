//! Compares a run with the truth, tick by tick.

use history::Simulation;

use super::truth::{Body, Cast, Look, Most, Truth, Window};
use super::{Excess, Settled, THROWN};
use crate::run::movable;

/// Least ticks by which the truth is ahead of the run.
const LEAST_LEAD: u64 = 2;

/// The tick by which the truth must have had the values that a run has after `tick` ticks.
pub(super) const fn lead(tick: u64) -> u64 {
    let third = tick / 3;
    tick + if third > LEAST_LEAD { third } else { LEAST_LEAD }
}

/// The last tick of a run that can be judged by a truth of `ticks` ticks.
pub(super) fn judged(ticks: u64) -> u64 {
    // The largest t with t + t / 3 <= ticks in whole numbers: three of four, and up to two of the rest.
    let by_third = 3 * (ticks / 4) + (ticks % 4).min(2);
    by_third.min(ticks.saturating_sub(LEAST_LEAD))
}

/// A run beside the truth.
pub(super) struct Run {
    simulation: Simulation,
    pub ticks: u64,
    /// The last tick by which no body was beyond what the truth had by then, as far as that can be predicted.
    pub held: u64,
    most: Most,
    window: Window,
    /// Least and largest velocity along the true one, as multiples of it, by body.
    along: Vec<[f64; 2]>,
    start: f64,
    /// The largest excess in the first half of the run and in the second.
    peaks: [f64; 2],
    /// The largest speed or distance as a multiple of that of the truth.
    swing: f64,
}

/// A deviation: number of the body, and number of its bond.
pub(super) type Found<T> = (Option<usize>, Option<usize>, T);

impl Run {
    pub fn new(simulation: Simulation, cast: &Cast) -> Self {
        let look = Look::at(&simulation, cast);
        let count = cast.ids.len();
        Self {
            simulation,
            ticks: 0,
            held: 0,
            most: Most::of(&look),
            window: Window::default(),
            along: vec![[f64::INFINITY, f64::NEG_INFINITY]; count],
            start: look.energy,
            peaks: [0.0; 2],
            swing: 0.0,
        }
    }

    /// Steps per tick, by the evaluations.
    pub fn steps(&self) -> f64 {
        let claims = self.simulation.method().claims();
        let bodies = movable(&self.simulation.scene).count() as u64 * self.ticks;
        let steps = bodies * u64::from(claims.evaluations);
        self.simulation.evaluations().accelerations() as f64 / steps.max(1) as f64
    }

    /// Simulates a tick, and returns the largest excess in it, if a body is thrown out. `settling` is whether the tick is within the
    /// window, and `late` whether it is in the second half of the run.
    pub fn tick(
        &mut self,
        cast: &Cast,
        truth: &Truth,
        settling: bool,
        late: bool,
    ) -> Option<Found<Excess>> {
        self.simulation.tick();
        self.ticks += 1;
        let look = Look::at(&self.simulation, cast);
        if settling {
            self.window.add(&look);
            for (i, body) in look.bodies.iter().enumerate() {
                let Body::Present(_, v) = *body else { continue };
                if let Some(mean) = truth.window.settled(i) {
                    let along = v.dot(mean) / mean.length_squared();
                    let [least, most] = self.along[i];
                    self.along[i] = [least.min(along), most.max(along)];
                }
            }
        }
        self.most.add(&look);
        let is_known = truth.parted_from.is_none_or(|parted| self.ticks < parted);
        if is_known && truth.is_resolved(self.ticks) && !self.is_early(cast, truth) {
            self.held = self.ticks;
        }
        let largest = self.excess(&look, cast, truth)?;
        let (.., excess) = largest;
        let peak = &mut self.peaks[usize::from(late)];
        *peak = peak.max(excess.times());
        if let Excess::Speed(times) | Excess::Distance(times) = excess {
            self.swing = self.swing.max(times);
        }
        (excess.times() > THROWN).then_some(largest)
    }

    /// Whether the run need not go on: a body is far beyond the truth.
    pub fn is_over(&self) -> bool {
        self.peaks[0].max(self.peaks[1]) > FAR
    }

    /// How many times too far bodies swing that springs hold, if that does not grow any more.
    pub fn swing(&self, cast: &Cast) -> Option<f64> {
        let [early, late] = self.peaks;
        (cast.held && late <= BOUNDED * early && !self.is_over()).then_some(self.swing)
    }

    /// The largest excess in the present state.
    fn excess(&self, look: &Look, cast: &Cast, truth: &Truth) -> Option<Found<Excess>> {
        let most = truth.by(lead(self.ticks));
        let parted = |all: &[f64], is_parted: &dyn Fn(usize) -> bool| {
            let parted = all.iter().enumerate().filter(|(i, _)| is_parted(*i));
            parted.map(|(_, most)| *most).fold(0.0, f64::max)
        };
        let is_resolved = truth.is_resolved(lead(self.ticks));
        let is_parted = |body: usize| truth.is_parted(body, lead(self.ticks));
        let fastest = parted(&most.speeds, &is_parted);
        let farthest = parted(&most.arms, &|bond| is_parted(cast.bound[bond]));
        let mut worst: Option<Found<Excess>> = None;
        let mut quickest = (None, 1.0);
        let mut keep = |body, bond, excess: Excess| {
            let times = excess.times();
            if worst.is_none_or(|(.., known)| times > known.times()) {
                worst = Some((body, bond, excess));
            }
        };
        for (i, body) in look.bodies.iter().enumerate().filter(|_| is_resolved) {
            match body {
                Body::Present(_, v) => {
                    let own = if is_parted(i) { fastest } else { most.speeds[i] };
                    let times = v.length() / own.max(most.faint(i, cast));
                    if times > quickest.1 {
                        quickest = (Some(i), times);
                    }
                    keep(Some(i), None, Excess::Speed(times));
                }
                Body::Quarantined if !most.is_quarantined(i) => {
                    keep(Some(i), None, Excess::Quarantined);
                }
                Body::Away | Body::Quarantined => {}
            }
        }
        for (bond, arm) in look.arms.iter().enumerate().filter(|_| is_resolved) {
            let Some(arm) = arm else { continue };
            let body = cast.bound[bond];
            let own = if is_parted(body) { farthest } else { most.arms[bond] };
            keep(Some(body), Some(bond), Excess::Distance(arm.length() / own));
        }
        // Springs that hold everything bound energy by sizes and speeds. Semi-implicit Euler, whose velocities are half a step late,
        // shows too much of it.
        if cast.held {
            return worst;
        }
        let change = look.energy - self.start;
        // Without a truth, energy that stays is compared with itself.
        let own = if is_resolved { 0.0 } else { self.start.abs() };
        let scale = most.energy_scale().max(own);
        let [gained, lost] = [change - most.energy[1], most.energy[0] - change];
        if change.is_finite() && scale > 0.0 && gained.max(lost) > 0.0 {
            let beyond = if gained > lost { gained } else { -lost };
            let body = quickest.0.filter(|_| !cast.joined);
            keep(body, None, Excess::Energy(beyond / scale));
        }
        worst
    }

    /// Whether a body has been beyond what the truth has had by now, even if the truth comes there a little later.
    fn is_early(&self, cast: &Cast, truth: &Truth) -> bool {
        let (own, most) = (&self.most, truth.by(self.ticks));
        let is_early = |i: usize| own.speeds[i] > THROWN * most.speeds[i].max(most.faint(i, cast));
        let is_compared = |i: &usize| !truth.is_parted(*i, self.ticks);
        let mut bonds = cast.bound.iter().enumerate().filter(|(_, body)| is_compared(body));
        bonds.any(|(bond, _)| own.arms[bond] > THROWN * most.arms[bond])
            || (0..cast.ids.len()).filter(is_compared).any(is_early)
    }

    /// Where a body settles that the truth does not.
    pub fn settled(&self, cast: &Cast, truth: &Truth) -> Option<Found<Settled>> {
        if truth.unresolved_from.is_some() {
            return None;
        }
        let most = truth.by(truth.ticks);
        for i in (0..cast.ids.len()).filter(|i| !truth.is_parted(*i, truth.ticks)) {
            let allowed = most.speeds[i].max(most.faint(i, cast));
            if let Some(mean) = truth.window.settled(i)
                && mean.length() > SLOW * allowed
                && let Some(own) = self.window.mean(i)
            {
                let [least, largest] = self.along[i];
                let own = own.dot(mean) / mean.length_squared();
                let is_near = (own - 1.0).abs() <= NEAR && least > 0.5 && largest < 1.5;
                if !is_near && least.is_finite() {
                    return Some((Some(i), None, Settled::Velocity([least, largest])));
                }
            }
            let (own, true_speed) =
                (self.window.speeds.get(i).copied()?, truth.window.speeds.get(i).copied()?);
            if true_speed <= AT_REST * most.speeds[i] && own > THROWN * true_speed + NEAR * allowed
            {
                return Some((Some(i), None, Settled::Moving(own / allowed)));
            }
        }
        for (bond, body) in cast.bound.iter().copied().enumerate() {
            let ([least, most], [true_least, true_most]) =
                (*self.window.arms.get(bond)?, *truth.window.arms.get(bond)?);
            if most < 0.5 * true_least || least > 2.0 * true_most {
                let ratio = [least / true_most, most / true_least];
                return Some((Some(body), Some(bond), Settled::Distance(ratio)));
            }
        }
        None
    }
}

/// An excess with which a run is over.
const FAR: f64 = 1e3;

/// An excess whose largest value in the second half of a run is no larger than this many times that in the first does not grow.
const BOUNDED: f64 = 1.5;

/// Velocities that differ by less than this part are equal.
const NEAR: f64 = 0.1;

/// Part of its largest speed below which a body that settles counts as at rest.
const SLOW: f64 = 1e-3;

/// Part of its largest speed below which a body has come to rest.
const AT_REST: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_tick_that_can_be_judged_is_the_largest_whose_lead_is_there() {
        for ticks in 0..200 {
            let last = (1..=ticks).rev().find(|tick| lead(*tick) <= ticks).unwrap_or(0);
            assert_eq!(judged(ticks), last, "{ticks}");
        }
    }
}
