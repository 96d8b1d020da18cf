//! Three and more bodies that attract each other: the true motion tells how near they come, and the method steps all of them.

use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

use glam::DVec3;

use super::Occasion;
use super::judged::{Attracted, MOST_BODIES, Truth};
use super::modes::Stepping;
use super::orbit::{Apsides, KEEPS_WITHIN, LASTING_TURNS};
use crate::laws::{BodyState, MutualGravity};
use crate::methods::table::Method;
use crate::methods::{Field, Integrator, RungeKutta4, StepState, with_method};
use crate::units::Scalar;

/// Most pairs that are evaluated in a trial.
const MOST_PAIRS: f64 = 4e6;

/// Steps of the true motion per radian of the fastest pair.
const STEPS_PER_RADIAN: f64 = 16.0;

/// Most steps of the true motion.
const MOST_STEPS: u32 = 100_000;

/// Number of ticks over which the energy is averaged: at a close approach even that of a good method differs for a while.
const AVERAGED: usize = 64;

/// Energy, as a share of the kinetic energy, below which a group is about to fly apart in any case.
const SMALL_ENERGY: f64 = 0.2;

/// Vectors of several bodies.
#[derive(Clone, Copy)]
struct Vectors([DVec3; MOST_BODIES]);

impl Add for Vectors {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Vectors {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul<f64> for Vectors {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|part| part * factor))
    }
}

/// Bodies that attract each other and nothing else.
pub(super) struct Attracting<'a> {
    pub law: &'a MutualGravity,
    /// Up to [`MOST_BODIES`] bodies, movable ones first.
    pub states: &'a [BodyState],
    pub movable: usize,
    /// Masses as sources, kg.
    pub masses: &'a [Scalar],
}

impl Attracting<'_> {
    fn start(&self) -> [Vectors; 2] {
        let of = |part: fn(&BodyState) -> DVec3| {
            Vectors(std::array::from_fn(|row| self.states.get(row).map_or(DVec3::ZERO, part)))
        };
        [of(|state| state.position), of(|state| state.velocity)]
    }

    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        let rows = self.states.len();
        (0..self.movable).flat_map(move |a| (a + 1..rows).map(move |b| [a, b]))
    }

    /// The largest squared frequency of a pair, 1/s², and its distance, m.
    fn fastest(&self, Vectors(x): &Vectors) -> (Scalar, Scalar) {
        let pull = |[a, b]: [usize; 2]| {
            let squared = x[a].distance_squared(x[b]);
            let r = squared + self.law.softening * self.law.softening;
            // An immovable body does not orbit the other one.
            let mass =
                if b < self.movable { self.masses[a] + self.masses[b] } else { self.masses[b] };
            let pull = self.law.constant * mass / (r * r.sqrt());
            // No force acts at the same position.
            (if squared > 0.0 { pull } else { 0.0 }, squared.sqrt())
        };
        self.pairs()
            .map(pull)
            .fold((0.0, 0.0), |most, pull| if pull.0 > most.0 { pull } else { most })
    }

    /// Kinetic and potential energy about the center of mass, J.
    fn energy(&self, [Vectors(x), Vectors(v)]: &[Vectors; 2]) -> Scalar {
        let mass = |row: usize| 1.0 / self.states[row].inverse_mass;
        let total: Scalar = (0..self.movable).map(mass).sum();
        let momentum: DVec3 = (0..self.movable).map(|row| v[row] * mass(row)).sum();
        // With an immovable source the frame is that of the scene: there is no drift to subtract.
        let is_held = self.masses[self.movable..].iter().any(|mass| *mass > 0.0);
        let drift = if is_held { 0.0 } else { momentum.length_squared() / (2.0 * total) };
        let kinetic: Scalar =
            (0..self.movable).map(|row| 0.5 * mass(row) * v[row].length_squared()).sum();
        let potential = |[a, b]: [usize; 2]| {
            let r = x[a].distance_squared(x[b]) + self.law.softening * self.law.softening;
            -self.law.constant * self.masses[a] * self.masses[b] / r.sqrt()
        };
        kinetic - drift + self.pairs().map(potential).sum::<Scalar>()
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between two small counts"
    )]
    fn ticks(&self, turn: Scalar, stepping: Stepping) -> u32 {
        let pairs = self.pairs().count() as f64;
        let most = MOST_PAIRS / (pairs * f64::from(stepping.substeps));
        // Two turns at least; NaN counts as the least.
        let most = most.max((2.0 * turn / stepping.tick).ceil()).min(1e6);
        (LASTING_TURNS * turn / stepping.tick).ceil().clamp(20.0, most.max(20.0)) as u32
    }

    /// Distances of the movable bodies from the center of all, m.
    fn distances(&self, Vectors(x): &Vectors) -> impl Iterator<Item = Scalar> {
        let total: Scalar = self.masses.iter().sum();
        let center =
            (0..self.states.len()).map(|row| x[row] * self.masses[row]).sum::<DVec3>() / total;
        let x = *x;
        (0..self.movable).map(move |row| x[row].distance(center))
    }

    /// Kinetic energy, J.
    fn kinetic(&self, [_, Vectors(v)]: &[Vectors; 2]) -> Scalar {
        (0..self.movable)
            .map(|row| 0.5 * v[row].length_squared() / self.states[row].inverse_mass)
            .sum()
    }

    fn leaves_by<M: Integrator>(
        &self,
        turn: Scalar,
        farthest: &[Scalar],
        stepping: Stepping,
    ) -> Option<Scalar> {
        let mut field = ManyField { bodies: self, h: stepping.tick / f64::from(stepping.substeps) };
        let [mut x, mut v] = self.start();
        let first = self.energy(&[x, v]);
        let most_change =
            (1.0 - 1.0 / KEEPS_WITHIN) * first.abs().max(SMALL_ENERGY * self.kinetic(&[x, v]));
        let mut state = StepState::<ManyField<'_>>::default();
        let mut energies = [first; AVERAGED];
        for tick in 0..self.ticks(turn, stepping) as usize {
            for _ in 0..stepping.substeps {
                (x, v) = M::step(&mut field, x, v, &mut state);
            }
            energies[tick % AVERAGED] = self.energy(&[x, v]);
            let change = energies.iter().sum::<Scalar>() / AVERAGED as Scalar - first;
            let distances = self.distances(&x);
            let is_far = |(distance, most): (Scalar, &Scalar)| distance > KEEPS_WITHIN * most;
            // NaN is outside.
            let keeps_energy = change.abs() <= most_change;
            if !keeps_energy || distances.zip(farthest).any(is_far) {
                return Some((tick + 1) as f64 * stepping.tick / turn);
            }
        }
        None
    }
}

impl Attracted for Attracting<'_> {
    fn pull(&self) -> Scalar {
        self.fastest(&self.start()[0]).0
    }

    fn occasion(&self) -> Occasion {
        Occasion::Met
    }

    fn softness(&self, distance: Option<Scalar>) -> f64 {
        let r = distance.unwrap_or_else(|| self.fastest(&self.start()[0]).1);
        if self.law.softening == 0.0 {
            0.0
        } else {
            self.law.softening / r.max(1e-3 * self.law.softening)
        }
    }

    fn truth(&self, tick: Scalar) -> Option<Truth> {
        let [mut x, mut v] = self.start();
        let turn = TAU / self.fastest(&x).0.sqrt();
        let mut field = ManyField { bodies: self, h: tick };
        let (mut pull, mut nearest, mut farthest) = (0.0, 0.0, [0.0_f64; MOST_BODIES]);
        let whole =
            Stepping { method: Method::RungeKutta4, tick, substeps: 1, may_be_implicit: false };
        let mut left = f64::from(self.ticks(turn, whole)) * tick;
        for _ in 0..MOST_STEPS {
            let (here, r) = self.fastest(&x);
            if here > pull {
                (pull, nearest) = (here, r);
            }
            farthest
                .iter_mut()
                .zip(self.distances(&x))
                .for_each(|(most, r): (&mut Scalar, _)| *most = most.max(r));
            if left <= 0.0 || !here.is_finite() {
                break;
            }
            field.h = tick.min(left).min(1.0 / (STEPS_PER_RADIAN * here.sqrt()));
            left -= field.h;
            (x, v) = RungeKutta4::step(&mut field, x, v, &mut StepState::default());
        }
        // A motion that cannot be resolved to its end counts as far as it was resolved.
        let apsides = Apsides { nearest, farthest: Scalar::INFINITY };
        Some(Truth { apsides, pull, turn, passage: None, farthest })
    }

    fn steps(&self, truth: &Truth, stepping: Stepping) -> f64 {
        f64::from(self.ticks(truth.turn, stepping))
            * f64::from(stepping.substeps)
            * self.pairs().count() as f64
    }

    fn leaves(&self, truth: &Truth, stepping: Stepping) -> Option<Scalar> {
        with_method!(stepping.method, M => self.leaves_by::<M>(truth.turn, &truth.farthest, stepping))
    }
}

/// The field of several bodies in one step.
struct ManyField<'a> {
    bodies: &'a Attracting<'a>,
    h: f64,
}

impl Field for ManyField<'_> {
    type Space = Vectors;

    fn step(&self) -> f64 {
        self.h
    }

    fn laws(&mut self, _: f64, Vectors(x): Vectors, _: Vectors) -> Vectors {
        let Attracting { law, masses, .. } = self.bodies;
        let mut sum = [DVec3::ZERO; MOST_BODIES];
        for [a, b] in self.bodies.pairs() {
            let r = x[b] - x[a];
            let squared = r.length_squared() + law.softening * law.softening;
            if squared > 0.0 {
                let pull = r * (law.constant / (squared * squared.sqrt()));
                sum[a] += pull * masses[b];
                if b < self.bodies.movable {
                    sum[b] -= pull * masses[a];
                }
            }
        }
        Vectors(sum)
    }

    fn applied(&self) -> Vectors {
        Vectors([DVec3::ZERO; MOST_BODIES])
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    /// Implicit Euler does not solve mutual gravity.
    fn implicit_velocity(&mut self, _: Vectors, v: Vectors) -> Vectors {
        v
    }
}
