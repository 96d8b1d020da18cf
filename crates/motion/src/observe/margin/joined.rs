//! The true motion of a few bodies that springs join: a net is linear only near the state in which it is linearized.

use bevy_ecs::prelude::*;
use glam::DVec3;
use smallvec::SmallVec;

use crate::groups::{Coupling, Row, is_open, row_of, states_of};
use crate::laws::Wells;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::{BodyState, EvaluationTime, Law};
use crate::state::clock::StepClock;
use crate::state::components::AxisLocks;
use crate::tick::columns::options_of;
use crate::tick::environment::Environment;
use crate::units::Scalar;

/// Largest number of bodies whose motion is computed.
const MOST_BODIES: usize = 16;

/// Number of ticks of the computed motion: ten seconds at 60 Hz.
const TICKS: u32 = 600;

/// Number of states at which the motion is sampled; only the later half is used.
const LOOKS: u32 = 24;

/// Most steps of the motion.
const MOST_STEPS: f64 = 60_000.0;

/// Steps per radian of the fastest mode.
const STEPS_PER_RADIAN: f64 = 8.0;

/// Computes the positions by row that a group meets in the later half of the next ticks of `tick` seconds, where `rate` is a
/// bound of its fastest frequency and damping, 1/s. `None` if that would take too long, if the group is at rest in its
/// equilibrium, or if wells, mutual gravity or air on sheets act.
pub(super) fn positions_met(
    world: &World,
    coupling: &Coupling,
    bodies: &[Entity],
    [tick, rate]: [Scalar; 2],
) -> Option<Vec<Vec<Row>>> {
    let is_net = !world.contains_resource::<Wells>()
        && !coupling.attracts
        && coupling.sheets.is_empty()
        && coupling.rows <= MOST_BODIES;
    let steps =
        (tick * f64::from(TICKS) / f64::from(LOOKS) * rate * STEPS_PER_RADIAN).ceil().max(4.0);
    let is_short = steps * f64::from(LOOKS) <= MOST_STEPS;
    if !(is_net && is_short) {
        return None;
    }
    let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
    let environment = Environment::of(world, clock, tick);
    let options: Vec<_> = bodies.iter().map(|body| options_of(world.entity(*body))).collect();
    let laws: Vec<SmallVec<[&dyn Law; 8]>> =
        options.iter().map(|options| environment.on_body(options, false).collect()).collect();
    let damping = world.get_resource::<Damping>().copied();
    let damping = |body: &Entity| {
        let own = world.get::<DampingRate>(*body).map(DampingRate::rate);
        damping.map_or(0.0, |scenes| own.unwrap_or(scenes.rate))
    };
    let net = Joined {
        coupling,
        laws,
        damping: bodies.iter().map(damping).collect(),
        locks: options.iter().map(|options| options.locks).collect(),
        masses: states_of(world, bodies),
    };
    let mut time = environment.times.start;
    let mut x: Vec<_> = net.masses.iter().map(|state| state.position).collect();
    let mut v: Vec<_> = net.masses.iter().map(|state| state.velocity).collect();
    let h = tick * f64::from(TICKS) / (f64::from(LOOKS) * steps);
    let start = x.clone();
    let mut met = Vec::new();
    for look in 0..LOOKS {
        for _ in 0..steps as u32 {
            net.step(h, time, &mut x, &mut v);
            time += h;
        }
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        // The motion settles in the first half.
        if look >= LOOKS / 2 {
            met.push(x.iter().map(|x| row_of(*x)).collect());
        }
    }
    let moved =
        x.iter().zip(&start).any(|(x, start)| x.distance(*start) > 1e-9 * (1.0 + start.length()));
    moved.then_some(met)
}

/// Bodies that springs join, and everything else that acts on each.
struct Joined<'a> {
    coupling: &'a Coupling,
    laws: Vec<SmallVec<[&'a dyn Law; 8]>>,
    /// Rate of the scene's damping by row, 1/s.
    damping: Vec<Scalar>,
    locks: Vec<Option<AxisLocks>>,
    /// The states at the start, of which only the masses are used.
    masses: Vec<BodyState>,
}

impl Joined<'_> {
    fn accelerations(&self, time: Scalar, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let at = EvaluationTime { time, within_step: time };
        let movable = self.coupling.movable;
        let mut sum: Vec<_> = (0..x.len())
            .map(|row| {
                let body = BodyState { position: x[row], velocity: v[row], ..self.masses[row] };
                let laws = self.laws[row].iter().filter(|_| row < movable);
                laws.map(|law| law.acceleration(at, body)).sum::<DVec3>()
                    - v[row] * self.damping[row]
            })
            .collect();
        for spring in self.coupling.springs.iter() {
            let [a, b] = spring.ends.map(|end| end as usize);
            let (d, length) = (x[b] - x[a], x[b].distance(x[a]));
            if length > 0.0 {
                let n = d * (1.0 / length);
                let pull = spring.elastic.tension(length, n.dot(v[b] - v[a]));
                sum[a] += n * (pull * self.masses[a].inverse_mass);
                sum[b] -= n * (pull * self.masses[b].inverse_mass);
            }
        }
        for (row, sum) in sum.iter_mut().enumerate() {
            let open =
                |axis: usize| f64::from(u8::from(row < movable && is_open(self.locks[row], axis)));
            *sum *= DVec3::new(open(0), open(1), open(2));
        }
        sum
    }

    /// A step of Runge-Kutta 4 in place.
    fn step(&self, h: Scalar, time: Scalar, x: &mut [DVec3], v: &mut [DVec3]) {
        let moved = |x: &[DVec3], v: &[DVec3], h: Scalar| -> Vec<DVec3> {
            x.iter().zip(v).map(|(x, v)| *x + *v * h).collect()
        };
        let a1 = self.accelerations(time, x, v);
        let v2 = moved(v, &a1, 0.5 * h);
        let a2 = self.accelerations(time + 0.5 * h, &moved(x, v, 0.5 * h), &v2);
        let v3 = moved(v, &a2, 0.5 * h);
        let a3 = self.accelerations(time + 0.5 * h, &moved(x, &v2, 0.5 * h), &v3);
        let v4 = moved(v, &a3, h);
        let a4 = self.accelerations(time + h, &moved(x, &v3, h), &v4);
        for row in 0..x.len() {
            x[row] += (v[row] + (v2[row] + v3[row]) * 2.0 + v4[row]) * (h / 6.0);
            v[row] += (a1[row] + (a2[row] + a3[row]) * 2.0 + a4[row]) * (h / 6.0);
        }
    }
}
