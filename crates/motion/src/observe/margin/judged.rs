//! Motions that are judged by stepping them: orbits and drag, beside the true motion.

use std::ops::ControlFlow;

use glam::DVec3;

use super::cure::{LinearSystem, as_good_as};
use super::flight::{Point, Subject};
use super::modes::Stepping;
use super::orbit::{Apsides, CircleLimits, LASTING_TURNS, leaves};
use super::{Cure, Deviation, Fate, LimitingPart, Margin, Occasion};
use crate::laws::{BodyState, Well};
use crate::methods::table::Method;
use crate::state::substeps::Substeps;
use crate::units::Scalar;

/// Largest number of bodies that attract each other and are tried together.
pub(super) const MOST_BODIES: usize = 16;

/// Most ticks of a trial.
const MOST_TICKS: f64 = 20_000.0;

/// Number of steps after which a trial ends, but not before [`LEAST_TURNS`].
const ENOUGH_STEPS: f64 = 1e6;
/// Least number of turns of a trial.
const LEAST_TURNS: f64 = 2.0;

/// Most steps of a trial of a cure.
const MOST_STEPS: f64 = 1e7;

/// Share of a limit below which a motion is not tried.
const SAFE: f64 = 0.25;

/// Most numbers of substeps that are tried before a cure names none.
const MOST_TRIES: u32 = 12;

/// The true motion of bodies that are attracted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Truth {
    pub apsides: Apsides,
    /// Largest squared frequency that it meets, 1/s².
    pub pull: Scalar,
    /// Time of a turn, s.
    pub turn: Scalar,
    /// The time after which a motion that is not bound is compared, s.
    pub passage: Option<Scalar>,
    /// Largest distance of each of several bodies from their center, m.
    pub farthest: [Scalar; MOST_BODIES],
}

/// Bodies that are attracted, whose motion is judged by stepping it.
pub(super) trait Attracted {
    /// Squared frequency in the present state, 1/s².
    fn pull(&self) -> Scalar;
    /// The state that has the largest value, if it is not the present one.
    fn occasion(&self) -> Occasion;
    /// Softening over distance.
    fn softness(&self, distance: Option<Scalar>) -> f64;
    /// The true motion, if it can be resolved.
    fn truth(&self, tick: Scalar) -> Option<Truth>;
    /// Number of steps of a trial.
    fn steps(&self, truth: &Truth, stepping: Stepping) -> f64;
    /// Number of turns after which the method leaves the true orbit; infinite for a gain of energy in a passage, `None` if the
    /// method keeps the orbit.
    fn leaves(&self, truth: &Truth, stepping: Stepping) -> Option<Scalar>;

    /// Whether a trial ends before the body has come around.
    fn is_too_slow(&self, truth: &Truth, stepping: Stepping) -> bool {
        truth.passage.is_none() && truth.turn > MOST_TICKS * stepping.tick
    }

    /// Number of turns after which the method leaves a motion with that value; `None` if it keeps the motion.
    fn turns(&self, truth: &Truth, value: Scalar, stepping: Stepping) -> Option<Scalar> {
        let limits = CircleLimits::of(stepping.method, self.softness(Some(truth.apsides.nearest)));
        if value < SAFE * limits.lasts {
            // Far below every limit nothing has to be tried.
            None
        } else if self.steps(truth, stepping) > MOST_STEPS || self.is_too_slow(truth, stepping) {
            // A motion that cannot be tried is judged like a circle.
            (limits.fate(value) != Fate::Holds).then_some(LASTING_TURNS)
        } else {
            self.leaves(truth, stepping)
        }
    }

    /// The margin of the motion.
    fn margin(&self, part: LimitingPart, bodies: usize, stepping: Stepping) -> Margin {
        let h = stepping.tick / f64::from(stepping.substeps);
        let now = h * self.pull().sqrt();
        let truth = self.truth(stepping.tick);
        let value = truth.map_or(now, |truth| now.max(h * truth.pull.sqrt()));
        let softness = self.softness(truth.map(|truth| truth.apsides.nearest));
        let limits = CircleLimits::of(stepping.method, softness);
        let (fate, growth_per_s) = match &truth {
            Some(truth) if value.is_finite() => match self.turns(truth, value, stepping) {
                None => (Fate::Holds, 1.0),
                // A gain of energy in a passage.
                Some(turns) if turns.is_infinite() => (Fate::Grows, Scalar::INFINITY),
                Some(turns) => {
                    let grows = limits.grows.is_some_and(|grows| value >= grows);
                    let fate = if grows { Fate::Grows } else { Fate::Drifts(turns) };
                    (fate, libm::pow(2.0, 1.0 / (turns * truth.turn)))
                }
            },
            // A fall into a point cannot be resolved.
            Some(_) => (Fate::Grows, Scalar::INFINITY),
            None => match self.untried(value, limits) {
                Fate::Grows => (Fate::Grows, Scalar::INFINITY),
                fate => (fate, 1.0),
            },
        };
        let is_now = truth.is_none() || value <= 1.001 * now;
        let Stepping { method, substeps, .. } = stepping;
        let margin = Margin {
            part,
            bodies,
            method,
            substeps,
            value,
            now,
            occasion: if is_now { Occasion::Now } else { self.occasion() },
            at_most: value,
            limit: limits.grows.unwrap_or(limits.lasts),
            lasts: Some(limits.lasts),
            fate,
            growth_per_s,
            growth_per_tick: libm::pow(growth_per_s, stepping.tick),
            cure: Cure::default(),
        };
        let cure = match truth.filter(|_| value.is_finite()) {
            _ if !margin.is_unstable() => Cure::default(),
            Some(truth) => self.cure(&truth, value, softness, stepping),
            None => cure_of_circle(value, softness, stepping),
        };
        Margin { cure, ..margin }
    }

    /// The fate of a motion that is not tried.
    fn untried(&self, value: Scalar, limits: CircleLimits) -> Fate {
        limits.fate(value)
    }

    /// The cures that keep the motion when they are tried.
    fn cure(&self, truth: &Truth, value: Scalar, softness: Scalar, stepping: Stepping) -> Cure {
        let holds =
            |stepping: Stepping, value: Scalar| self.turns(truth, value, stepping).is_none();
        let limits = CircleLimits::of(stepping.method, softness);
        let substeps = shortest(stepping.substeps, value / limits.lasts, |substeps| {
            let value = value * f64::from(stepping.substeps) / f64::from(substeps);
            holds(Stepping { substeps, ..stepping }, value)
        });
        let mut methods = cures_of_orbit(stepping.method);
        let method = methods.find(|method| holds(Stepping { method: *method, ..stepping }, value));
        Cure { substeps, method }
    }
}

/// A body in a well, and in everything else that acts on it.
pub(super) struct Orbit<'a> {
    pub subject: Subject<'a>,
    pub well: Well,
    /// Whether nothing else acts on the body: then energy and angular momentum tell how near it comes.
    pub is_alone: bool,
    /// Sum of the squared frequencies of circles about all wells at a position, 1/s².
    pub pull: &'a dyn Fn(DVec3) -> Scalar,
}

impl Attracted for Orbit<'_> {
    fn pull(&self) -> Scalar {
        (self.pull)(self.subject.start.position)
    }

    fn occasion(&self) -> Occasion {
        if self.is_alone { Occasion::ClosestApproach } else { Occasion::Met }
    }

    fn softness(&self, distance: Option<Scalar>) -> f64 {
        let r =
            distance.unwrap_or_else(|| self.subject.start.position.distance(self.well.position));
        softness(&self.well, r)
    }

    fn steps(&self, truth: &Truth, stepping: Stepping) -> f64 {
        f64::from(ticks_of(truth.turn, stepping)) * f64::from(stepping.substeps)
    }

    fn leaves(&self, truth: &Truth, stepping: Stepping) -> Option<Scalar> {
        match truth.passage {
            Some(passage) => self.gains_in(passage, stepping).then_some(Scalar::INFINITY),
            None => self.turns_kept(truth, stepping, ticks_of(truth.turn, stepping)),
        }
    }

    fn truth(&self, tick: Scalar) -> Option<Truth> {
        let start = self.subject.start;
        let apsides = self.well.apsides(start);
        let is_bound = apsides.farthest.is_finite();
        let pull = |r: Scalar| self.well.squared_frequency(self.well.position + DVec3::X * r);
        let passage = 4.0 * start.position.distance(self.well.position) / start.velocity.length();
        let turn = if is_bound { self.well.turn_s(apsides) } else { passage };
        if self.is_alone {
            let passage = (!is_bound).then_some(passage);
            let farthest = [0.0; MOST_BODIES];
            return Some(Truth { pull: pull(apsides.nearest), apsides, turn, passage, farthest });
        }
        let mut met = Truth {
            apsides: Apsides { nearest: f64::INFINITY, farthest: 0.0 },
            pull: 0.0,
            turn,
            passage: None,
            farthest: [0.0; MOST_BODIES],
        };
        // A motion that cannot be resolved to its end counts as far as it was resolved.
        let _: bool = self.subject.reference_motion(
            tick,
            ticks_of(turn, whole_ticks(tick)),
            &mut |_, [x, _]| {
                let r = x.distance(self.well.position);
                met.apsides = Apsides {
                    nearest: met.apsides.nearest.min(r),
                    farthest: met.apsides.farthest.max(r),
                };
                met.pull = met.pull.max((self.pull)(x));
            },
        );
        (met.apsides.farthest > 0.0).then_some(met)
    }
}

impl Orbit<'_> {
    /// Turns after which the motion leaves its orbit, if it does within [`LASTING_TURNS`].
    fn turns_kept(&self, truth: &Truth, stepping: Stepping, ticks: u32) -> Option<Scalar> {
        let Apsides { nearest, farthest } = truth.apsides;
        let nearest = if self.is_alone { nearest } else { 0.0 };
        let turns = |ticks: u32| f64::from(ticks) * stepping.tick / truth.turn;
        let left = leaves(&self.subject, self.well.position, [nearest, farthest], stepping, ticks);
        if let Some(tick) = left {
            return Some(turns(tick));
        }
        let flown = turns(ticks);
        if flown >= LASTING_TURNS || stepping.method.claims().symplectic || !self.is_alone {
            return None;
        }
        // A slow orbit is too long to be tried as a whole: a change of its energy by half is a factor of 2 in its size.
        let (start, end) = self.energies(stepping, ticks)?;
        let turns = flown * 0.5 / (end / start - 1.0).abs();
        (turns <= LASTING_TURNS).then_some(turns)
    }

    /// Energies before and after `ticks` ticks, J/kg; `None` if a state is not finite, or something takes or gives energy.
    fn energies(&self, stepping: Stepping, ticks: u32) -> Option<(Scalar, Scalar)> {
        let BodyState { position, velocity, inverse_mass } = self.subject.start;
        let (start, mut last) = ([position, velocity], [position, velocity]);
        let is_finite = self.subject.fly(stepping, ticks, &mut |_, point| {
            last = point;
            ControlFlow::Continue(())
        });
        let energy = |[x, v]: Point| {
            Some(self.subject.potential(x)? * inverse_mass + 0.5 * v.length_squared())
        };
        is_finite.then_some((energy(start)?, energy(last)?))
    }

    /// Whether a passage changes the energy by more than the total and the kinetic energy before it.
    fn gains_in(&self, passage: Scalar, stepping: Stepping) -> bool {
        let kinetic = 0.5 * self.subject.start.velocity.length_squared();
        let energies = self.energies(stepping, ticks_of(passage / LASTING_TURNS, stepping));
        energies.is_none_or(|(before, after)| (after - before).abs() > before.abs().max(kinetic))
    }
}

/// A body and one of many that attract it, judged in the present state because the motion of the others is unknown.
pub(super) struct Pair {
    pub well: Well,
    pub distance: Scalar,
    /// Whether the body is judged by another well that attracts it more.
    pub is_lesser: bool,
}

impl Attracted for Pair {
    fn pull(&self) -> Scalar {
        self.well.squared_frequency(self.well.position + DVec3::X * self.distance)
    }

    fn occasion(&self) -> Occasion {
        Occasion::Now
    }

    fn softness(&self, _: Option<Scalar>) -> f64 {
        softness(&self.well, self.distance)
    }

    fn truth(&self, _: Scalar) -> Option<Truth> {
        None
    }

    fn steps(&self, _: &Truth, _: Stepping) -> f64 {
        0.0
    }

    fn leaves(&self, _: &Truth, _: Stepping) -> Option<Scalar> {
        None
    }

    fn untried(&self, value: Scalar, limits: CircleLimits) -> Fate {
        if self.is_lesser { Fate::Holds } else { limits.fate(value) }
    }
}

/// The methods that may cure an orbit under the method `of`. Implicit Euler is left out: it shrinks every orbit, and ejects a
/// body that has come near.
fn cures_of_orbit(of: Method) -> impl Iterator<Item = Method> {
    as_good_as(of).filter(move |method| *method != Method::ImplicitEuler && *method != of)
}

/// The cures of a circle, by its limits alone.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below a small limit")]
fn cure_of_circle(value: Scalar, softness: f64, stepping: Stepping) -> Cure {
    let lasts = |method: Method| CircleLimits::of(method, softness).lasts;
    let substeps = (f64::from(stepping.substeps) * value / lasts(stepping.method)).ceil();
    let method = cures_of_orbit(stepping.method).find(|method| value <= lasts(*method));
    Cure { substeps: (substeps <= f64::from(Substeps::MOST)).then_some(substeps as u32), method }
}

/// Softening over distance, bounded.
fn softness(well: &Well, distance: Scalar) -> f64 {
    if well.softening == 0.0 { 0.0 } else { well.softening / distance.max(1e-3 * well.softening) }
}

/// Number of ticks for which orbits of `turn` seconds are tried.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between two small counts"
)]
fn ticks_of(turn: Scalar, stepping: Stepping) -> u32 {
    let ticks = |turns: Scalar| (turns * turn / stepping.tick).ceil();
    let enough = (ENOUGH_STEPS / f64::from(stepping.substeps)).max(ticks(LEAST_TURNS));
    // NaN counts as the least.
    ticks(LASTING_TURNS).min(enough).clamp(20.0, MOST_TICKS) as u32
}

/// A stepping of which only the length of a tick is used.
fn whole_ticks(tick: Scalar) -> Stepping {
    Stepping { method: Method::default(), tick, substeps: 1, may_be_implicit: false }
}

/// The first number of substeps above `substeps` for which `holds`, tried from `times` as many on in increments of half.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below a small limit")]
fn shortest(substeps: u32, times: Scalar, holds: impl Fn(u32) -> bool) -> Option<u32> {
    let guess = f64::from(substeps) * times;
    if !guess.is_finite() || guess > f64::from(Substeps::MOST) {
        return None;
    }
    let mut tried = (guess.ceil() as u32).max(substeps + 1);
    for _ in 0..MOST_TRIES {
        if tried > Substeps::MOST {
            return None;
        }
        if holds(tried) {
            return Some(tried);
        }
        // In increments of half: the limit that made the guess may be far from that of this motion.
        tried += tried.div_ceil(2);
    }
    None
}

/// A body that drag slows down, and everything else that acts on it.
pub(super) struct Slowed<'a> {
    pub subject: Subject<'a>,
    /// Largest rate of drag to come, 1/s, with the scene's damping.
    pub rate: Scalar,
    /// The rate in the present state, 1/s.
    pub now: Scalar,
    pub occasion: Occasion,
    /// Whether the rate changes with the speed.
    pub is_quadratic: bool,
}

/// Number of ticks for which drag is tried: a body that is slowed by more than [`SAFE`] per tick has settled by then.
const DRAG_TICKS: u32 = 240;

/// Number of these ticks, the last ones, in which the velocity is compared.
const LAST_TICKS: u32 = 60;

/// Relative difference of a velocity that counts as wrong.
const WRONG: Scalar = 0.05;

/// Velocity, as a multiple of the largest of the true motion, that counts as growth.
const GROWN: Scalar = 4.0;

impl Slowed<'_> {
    /// The margin of the body, where `linear` is that of linear drag at the same rate, and `least` is its drag without the
    /// quadratic part.
    pub fn margin(&self, linear: Margin, least: &LinearSystem, stepping: Stepping) -> Margin {
        let mut margin = Margin {
            now: linear.value * (self.now / self.rate),
            occasion: self.occasion,
            ..linear
        };
        // The matrix of linear drag is exact.
        if margin.value < SAFE || !self.is_quadratic && margin.is_unstable() {
            return margin;
        }
        let Some(truth) = self.truth(stepping.tick) else { return margin };
        let fate = |stepping: Stepping| {
            // Stepping a body at rest would show nothing.
            if least.is_stable(stepping) { self.fate(&truth, stepping) } else { Fate::Grows }
        };
        let holds = |stepping: Stepping| fate(stepping) == Fate::Holds;
        margin.fate = fate(stepping);
        if self.is_quadratic {
            margin.limit = self.limit(margin.value, stepping);
        }
        let grows = margin.fate == Fate::Grows;
        // The growth accelerates.
        margin.growth_per_s = if grows { Scalar::INFINITY } else { 1.0 };
        margin.growth_per_tick = margin.growth_per_s;
        margin.cure = Cure::default();
        if margin.fate != Fate::Holds {
            let times =
                if margin.limit > 0.0 { (margin.value / margin.limit).max(1.0) } else { 1.0 };
            margin.cure.substeps = shortest(stepping.substeps, times, |substeps| {
                let steps = f64::from(substeps) * f64::from(DRAG_TICKS);
                steps <= MOST_STEPS && holds(Stepping { substeps, ..stepping })
            });
            margin.cure.method = as_good_as(stepping.method)
                .filter(|method| *method != stepping.method)
                .filter(|method| stepping.may_be_implicit || *method != Method::ImplicitEuler)
                .find(|method| holds(Stepping { method: *method, ..stepping }));
        }
        margin
    }

    /// The true motion after each tick.
    fn truth(&self, tick: Scalar) -> Option<Vec<Point>> {
        let mut points = Vec::new();
        let is_resolved = self.subject.reference_motion(tick, DRAG_TICKS, &mut |ends, point| {
            if ends {
                points.push(point);
            }
        });
        is_resolved.then_some(points)
    }

    fn fate(&self, truth: &[Point], stepping: Stepping) -> Fate {
        let start = [self.subject.start.position, self.subject.start.velocity];
        let moves = |points: &[Point]| -> Vec<DVec3> {
            let before = std::iter::once(&start).chain(points);
            points.iter().zip(before).map(|([x, _], [before, _])| *x - *before).collect()
        };
        let expected = moves(truth);
        let longest =
            |moves: &[DVec3]| moves.iter().map(|step| step.length()).fold(0.0, Scalar::max);
        let most = longest(&expected).max(start[1].length() * stepping.tick);
        let (mut last, mut points) = (start[0], Vec::new());
        let is_finite = self.subject.fly(stepping, DRAG_TICKS, &mut |_, point| {
            let step = point[0].distance(last);
            last = point[0];
            points.push(point);
            if step > GROWN * most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if !is_finite || points.len() < truth.len() {
            return Fate::Grows;
        }
        let found = moves(&points);
        let late = (DRAG_TICKS - LAST_TICKS) as usize;
        let settled = expected[late..].iter().sum::<DVec3>() / f64::from(LAST_TICKS);
        let is_settled = |step: &DVec3| step.distance(settled) <= 0.01 * settled.length();
        // A body that comes to rest has no velocity to take a multiple of.
        if settled.length() > WRONG * WRONG * most && expected[late..].iter().all(is_settled) {
            // The tutorial's damping moves a body at the true speed, and stores a smaller one.
            let is_stored = self.subject.damping.is_none_or(|damping| damping.is_exact());
            let steps = points[late..].iter().zip(&found[late..]);
            let steps =
                steps.map(|([_, v], step)| if is_stored { *v * stepping.tick } else { *step });
            let multiples = steps.map(|step| step.dot(settled) / settled.length_squared());
            let none = [Scalar::INFINITY, Scalar::NEG_INFINITY];
            let [least, largest] =
                multiples.fold(none, |[least, largest], m| [least.min(m), largest.max(m)]);
            if largest - least > WRONG {
                return Fate::Wrong(Deviation::Alternates([least, largest]));
            }
            if (least - 1.0).abs() > WRONG {
                return Fate::Wrong(Deviation::Settles(least));
            }
        }
        // A step of almost no length has no direction.
        let turns = |(step, expected): (&DVec3, &DVec3)| {
            step.dot(*expected) < 0.0 && step.length() > WRONG * most
        };
        let goes_on = expected.iter().all(|step| step.dot(expected[0]) >= 0.0);
        if goes_on && found.iter().zip(&expected).any(turns) {
            return Fate::Wrong(Deviation::Reverses);
        }
        Fate::Holds
    }

    /// The value above which the motion grows, found by longer and shorter ticks.
    fn limit(&self, value: Scalar, stepping: Stepping) -> Scalar {
        let grows = |times: Scalar| {
            let stepping = Stepping { tick: stepping.tick * times, ..stepping };
            let truth = self.truth(stepping.tick);
            truth.is_some_and(|truth| self.fate(&truth, stepping) == Fate::Grows)
        };
        const BY: Scalar = 1.5;
        let mut low = 1.0;
        if grows(low) {
            while grows(low) {
                low /= BY;
                if low * value < 0.1 {
                    return 0.0;
                }
            }
        } else {
            while !grows(low * BY) {
                low *= BY;
                if low * value > 100.0 {
                    return Scalar::INFINITY;
                }
            }
        }
        let mut high = low * BY;
        for _ in 0..12 {
            let middle = low.midpoint(high);
            if grows(middle) { high = middle } else { low = middle }
        }
        low * value
    }
}
