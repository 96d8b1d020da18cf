//! The path of a body in a tick, interpolated between its two ends.

use smallvec::SmallVec;

use super::bodies::PhasePoint;
use crate::kernels::cubic::Cubic;
use crate::laws::tick_times::TickTimes;
use crate::laws::{EvaluationTime, PrescribedMotion};
use crate::units::{Scalar, Vector};

/// A discontinuity within this fraction of a tick from one of its ends does not split the tick.
const NEAR: Scalar = 1e-9;

/// The cubic through position and velocity at both ends of a tick (Hermite 1878), with a bend where a law jumps. Its
/// velocity in the middle is of order 4, like that at the ends.
#[derive(Clone, Debug)]
pub(super) struct Path {
    ends: [PhasePoint; 2],
    length: Scalar,
    cubic: Cubic,
    /// Times of jumps since the start, s, and the jumps of the acceleration, m/s².
    bends: SmallVec<[(Scalar, Vector); 2]>,
    /// The prescribed motion that the body follows instead.
    motion: Option<PrescribedMotion>,
}

impl Path {
    /// Makes a path between two ends that are `length` seconds apart.
    pub fn new(ends: [PhasePoint; 2], length: Scalar) -> Self {
        let [from, to] = ends.map(|end| [end.position, end.velocity]);
        Self {
            ends,
            length,
            cubic: Cubic::new(from, to, length),
            bends: SmallVec::new(),
            motion: None,
        }
    }

    /// The path of a body that follows a motion, if there is one.
    pub fn following(self, motion: Option<&PrescribedMotion>) -> Self {
        Self { motion: motion.cloned(), ..self }
    }

    /// Adds a jump of the acceleration `after` seconds; both ends stay unchanged.
    pub fn bend(&mut self, after: Scalar, jump: Vector) {
        let rest = self.length - after;
        // The jump would move the end by this much: the cubic takes it back.
        let (moved, turned) = (jump * (rest * rest / 2.0), jump * (rest * self.length));
        self.cubic.curve[0] -= moved * 3.0 - turned;
        self.cubic.curve[1] -= turned - moved * 2.0;
        self.bends.push((after, jump));
    }

    /// Position and velocity at a node.
    pub fn at_node(&self, node: &QuadratureNode) -> PhasePoint {
        self.motion.as_ref().map_or_else(
            || self.at(node.after),
            |motion| {
                let [position, velocity] = motion.at(node.at);
                PhasePoint { position, velocity }
            },
        )
    }

    /// Position and velocity `after` seconds from the start.
    pub fn at(&self, after: Scalar) -> PhasePoint {
        let [start, end] = self.ends;
        if after <= 0.0 {
            return start;
        }
        if after >= self.length {
            return end;
        }
        let [mut position, mut velocity] = self.cubic.at(after / self.length, after);
        for (bend, jump) in self.bends.iter().filter(|(bend, _)| *bend < after) {
            let since = after - bend;
            position += *jump * (since * since / 2.0);
            velocity += *jump * since;
        }
        PhasePoint { position, velocity }
    }
}

/// A node of Simpson's rule: a time of a tick at which laws are evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuadratureNode {
    /// Seconds since the start of the tick.
    pub after: Scalar,
    /// Weight, s; the weights of a tick sum to its length.
    pub weight: Scalar,
    /// The time at which laws are evaluated.
    pub at: EvaluationTime,
}

/// Cuts a tick into intervals in which nothing jumps: its ends and the discontinuities between them, s since its start.
pub(super) fn cuts<'a>(
    times: &TickTimes,
    discontinuities: impl Iterator<Item = &'a Scalar>,
) -> SmallVec<[Scalar; 4]> {
    let TickTimes { start, tick, .. } = *times;
    let near = tick * NEAR;
    let mut cuts = SmallVec::from_slice(&[0.0]);
    cuts.extend(
        discontinuities
            .map(|time| time - start)
            .filter(|after| *after > near && *after < tick - near),
    );
    cuts.sort_unstable_by(Scalar::total_cmp);
    cuts.dedup_by(|a, b| *a - *b < near);
    cuts.push(tick);
    cuts
}

/// The nodes of Simpson's rule on every interval between two `cuts`: exact if the power is a cubic in time.
pub(super) fn nodes(times: &TickTimes, cuts: &[Scalar]) -> SmallVec<[QuadratureNode; 3]> {
    let mut nodes = SmallVec::new();
    for pair in cuts.windows(2) {
        let &[from, to] = pair else { continue };
        let middle = 0.5 * (from + to);
        let within_step = times.start + middle;
        for (after, part) in [(from, 1.0), (middle, 4.0), (to, 1.0)] {
            let time = if after == times.tick { times.end } else { times.start + after };
            nodes.push(QuadratureNode {
                after,
                weight: (to - from) * part / 6.0,
                at: EvaluationTime { time, within_step },
            });
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: PhasePoint =
        PhasePoint { position: Vector::new(1.0, 2.0, 3.0), velocity: Vector::new(0.5, -1.0, 2.0) };

    fn moved(state: PhasePoint, a: Vector, t: Scalar) -> PhasePoint {
        PhasePoint {
            position: state.position + state.velocity * t + a * (t * t / 2.0),
            velocity: state.velocity + a * t,
        }
    }

    fn near(a: PhasePoint, b: PhasePoint) -> bool {
        a.position.distance(b.position) < 1e-14 && a.velocity.distance(b.velocity) < 1e-13
    }

    #[test]
    fn a_constant_acceleration_that_begins_within_the_tick_is_followed_exactly() {
        let (h, b, jump) = (0.25, 0.1, Vector::new(8.0, -3.0, 1.0));
        let truth = |t: Scalar| {
            if t < b {
                moved(START, Vector::ZERO, t)
            } else {
                moved(moved(START, Vector::ZERO, b), jump, t - b)
            }
        };
        let mut path = Path::new([START, truth(h)], h);
        assert!(!near(path.at(0.15), truth(0.15)), "the cubic alone knows of no bend");
        path.bend(b, jump);
        for t in [0.0, 0.05, 0.1, 0.15, 0.2, 0.25] {
            assert!(near(path.at(t), truth(t)), "{t}: {:?} {:?}", path.at(t), truth(t));
        }
    }

    #[test]
    fn nodes_make_the_tick_and_stand_between_the_cuts() {
        let times = TickTimes { start: 2.0, end: 3.0, tick: 1.0, substeps: 1 };
        let cuts = cuts(&times, [2.0, 2.25, 2.25, 5.0, 1.0, 3.0].iter());
        assert_eq!(cuts[..], [0.0, 0.25, 1.0]);
        let nodes = nodes(&times, &cuts);
        assert!((nodes.iter().map(|node| node.weight).sum::<Scalar>() - 1.0).abs() < 1e-15);
        let cubic = |t: Scalar| 1.0 + t * (2.0 + t * (3.0 + t * 4.0));
        let integral = nodes.iter().map(|node| node.weight * cubic(node.after)).sum::<Scalar>();
        assert!((integral - 4.0).abs() < 1e-14, "{integral}");
        assert_eq!((nodes[2].at.time, nodes[3].at.time), (2.25, 2.25));
        assert!(nodes[2].at.within_step < 2.25 && nodes[3].at.within_step > 2.25);
    }
}
