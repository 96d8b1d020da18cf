//! The way that a body took in a tick, as far as its two ends tell.

use smallvec::SmallVec;

use super::bodies::State;
use crate::laws::EvaluationTime;
use crate::laws::course::Course;
use crate::units::{Scalar, Vector};

/// A break this near to an end of the tick, in ticks, splits nothing off.
const NEAR: Scalar = 1e-9;

/// The cubic that has position and velocity of both ends (Hermite 1878), and a bend of its own where a law jumps.
/// Its velocity in the middle is right to the fourth order of the tick, as that at the ends is.
#[derive(Clone, Debug)]
pub(super) struct Path {
    ends: [State; 2],
    length: Scalar,
    /// Factors of the second and third power of the part of the tick that is over, m.
    curve: [Vector; 2],
    /// Times since the start, s, and by how much the acceleration jumps then, m/s².
    bends: SmallVec<[(Scalar, Vector); 2]>,
}

impl Path {
    /// From one end to the other in `length` seconds.
    pub fn new(ends: [State; 2], length: Scalar) -> Self {
        let moved = ends[1].position - ends[0].position;
        let [from, to] = ends.map(|end| end.velocity * length);
        let curve = [moved * 3.0 - from * 2.0 - to, from + to - moved * 2.0];
        Self { ends, length, curve, bends: SmallVec::new() }
    }

    /// Lets the acceleration jump `after` seconds, both ends staying as they are.
    pub fn bend(&mut self, after: Scalar, jump: Vector) {
        let rest = self.length - after;
        // What the jump moves the end by, taken off again by the cubic.
        let (moved, turned) = (jump * (rest * rest / 2.0), jump * (rest * self.length));
        self.curve[0] -= moved * 3.0 - turned;
        self.curve[1] -= turned - moved * 2.0;
        self.bends.push((after, jump));
    }

    /// Position and velocity `after` seconds.
    pub fn at(&self, after: Scalar) -> State {
        let [start, end] = self.ends;
        if after <= 0.0 {
            return start;
        }
        if after >= self.length {
            return end;
        }
        let s = after / self.length;
        let [square, cube] = self.curve;
        let mut position = start.position + start.velocity * after + (square + cube * s) * (s * s);
        let mut velocity = start.velocity + (square * 2.0 + cube * (3.0 * s)) * (s / self.length);
        for (bend, jump) in self.bends.iter().filter(|(bend, _)| *bend < after) {
            let since = after - bend;
            position += *jump * (since * since / 2.0);
            velocity += *jump * since;
        }
        State { position, velocity }
    }
}

/// A point of a tick at which what acts is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Seconds since the start of the tick.
    pub after: Scalar,
    /// Time that it stands for, s; all of them make the tick.
    pub weight: Scalar,
    /// The moment for laws.
    pub at: EvaluationTime<Scalar>,
}

/// Times of a tick between which nothing jumps, s since its start: both ends, and discontinuities between them.
pub(super) fn cuts<'a>(
    course: &Course,
    discontinuities: impl Iterator<Item = &'a Scalar>,
) -> SmallVec<[Scalar; 4]> {
    let Course { start, tick, .. } = *course;
    let near = tick * NEAR;
    let mut cuts = SmallVec::from_slice(&[0.0]);
    cuts.extend(
        discontinuities.map(|time| time - start).filter(|after| *after > near && *after < tick - near),
    );
    cuts.sort_unstable_by(Scalar::total_cmp);
    cuts.dedup_by(|a, b| *a - *b < near);
    cuts.push(tick);
    cuts
}

/// Simpson's rule on every stretch between two `cuts`: exact for a power that is a cubic in time.
pub(super) fn nodes(course: &Course, cuts: &[Scalar]) -> SmallVec<[Node; 3]> {
    let mut nodes = SmallVec::new();
    for pair in cuts.windows(2) {
        let &[from, to] = pair else { continue };
        let middle = 0.5 * (from + to);
        let within_step = course.start + middle;
        for (after, part) in [(from, 1.0), (middle, 4.0), (to, 1.0)] {
            let time = if after == course.tick { course.end } else { course.start + after };
            nodes.push(Node {
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

    const START: State =
        State { position: Vector::new(1.0, 2.0, 3.0), velocity: Vector::new(0.5, -1.0, 2.0) };

    fn moved(state: State, a: Vector, t: Scalar) -> State {
        State {
            position: state.position + state.velocity * t + a * (t * t / 2.0),
            velocity: state.velocity + a * t,
        }
    }

    fn near(a: State, b: State) -> bool {
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
        let course = Course { start: 2.0, end: 3.0, tick: 1.0, substeps: 1 };
        let cuts = cuts(&course, [2.0, 2.25, 2.25, 5.0, 1.0, 3.0].iter());
        assert_eq!(cuts[..], [0.0, 0.25, 1.0]);
        let nodes = nodes(&course, &cuts);
        assert!((nodes.iter().map(|node| node.weight).sum::<Scalar>() - 1.0).abs() < 1e-15);
        let cubic = |t: Scalar| 1.0 + t * (2.0 + t * (3.0 + t * 4.0));
        let integral = nodes.iter().map(|node| node.weight * cubic(node.after)).sum::<Scalar>();
        assert!((integral - 4.0).abs() < 1e-14, "{integral}");
        assert_eq!((nodes[2].at.time, nodes[3].at.time), (2.25, 2.25));
        assert!(nodes[2].at.within_step < 2.25 && nodes[3].at.within_step > 2.25);
    }
}
