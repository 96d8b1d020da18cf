//! Groups of bodies joined by springs, integrated in a loop; the state of a group is one value.

use std::array::from_fn;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};

use glam::{DMat3, DVec3};
use motion::Method;
use motion::methods::{
    Field, Integrator, MethodStateKind, Newton, NewtonField, StepState, newton_velocity,
};
use scene::Scene;

use super::{Steps, step_by};
use crate::cost::record::{Counts, Failure, Setting};
use crate::cost::runner::{Runner, Sample};
use crate::run::movable;

/// The springs of a group of `N` bodies.
pub(crate) trait Springs<const N: usize>: Copy + Send + 'static {
    /// Masses, kg.
    const MASSES: [f64; N];
    /// The bodies that each spring joins, its stiffness, N/m, and its rest length, m.
    const SPRINGS: &'static [([usize; 2], f64, f64)];
}

/// Positions, velocities or accelerations of the bodies of a group.
#[derive(Clone, Copy)]
struct Several<const N: usize>([DVec3; N]);

impl<const N: usize> Add for Several<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<const N: usize> Sub for Several<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl<const N: usize> Mul<f64> for Several<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(from_fn(|k| self.0[k] * factor))
    }
}

/// The field of one group.
struct Group<S, const N: usize> {
    h: f64,
    counts: Counts,
    unconverged: u64,
    springs: PhantomData<S>,
}

impl<S: Springs<N>, const N: usize> Field for Group<S, N> {
    type Space = Several<N>;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.h
    }

    #[inline(always)]
    fn laws(&mut self, _: f64, Several(x): Self::Space, _: Self::Space) -> Self::Space {
        self.counts.accelerations += N as u64;
        let mut forces = [DVec3::ZERO; N];
        for ([a, b], stiffness, rest_length) in S::SPRINGS {
            let d = x[*b] - x[*a];
            let stretch = 1.0 - rest_length * d.dot(d).sqrt().recip();
            let pull = d * (stiffness * stretch);
            (forces[*a], forces[*b]) = (forces[*a] + pull, forces[*b] - pull);
        }
        Several(from_fn(|k| forces[k] * (1.0 / S::MASSES[k])))
    }

    #[inline(always)]
    fn applied(&self) -> Self::Space {
        Several([DVec3::ZERO; N])
    }

    #[inline(always)]
    fn plus_applied(&self, a: Self::Space) -> Self::Space {
        a
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space {
        newton_velocity(self, x, v)
    }
}

impl<S: Springs<N>, const N: usize> NewtonField for Group<S, N> {
    fn linear_rate(&self) -> Option<f64> {
        None
    }

    fn correction(
        &mut self,
        Several(x): Self::Space,
        _: Self::Space,
        residual: Self::Space,
    ) -> Self::Space {
        let mut matrix: [[DMat3; N]; N] = from_fn(|_| [DMat3::ZERO; N]);
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = DMat3::IDENTITY;
        }
        for ([a, b], stiffness, rest_length) in S::SPRINGS {
            let d = x[*b] - x[*a];
            let (n, taut) = (d.normalize(), 1.0 - rest_length / d.length());
            let along = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            let stiff = (along + (DMat3::IDENTITY - along) * taut) * (stiffness * self.h * self.h);
            for [from, to] in [[*a, *b], [*b, *a]] {
                matrix[from][from] += stiff * (1.0 / S::MASSES[from]);
                matrix[from][to] -= stiff * (1.0 / S::MASSES[from]);
            }
        }
        Several(eliminate(matrix, residual.0))
    }

    fn size(&self, v: Self::Space) -> f64 {
        v.0.into_iter().fold(0.0, |size, v| v.abs().max_element().max(size))
    }

    fn report(&mut self, Newton { iterations, converged }: Newton) {
        self.counts.solver += u64::from(iterations);
        self.unconverged += u64::from(!converged);
    }
}

/// Solves the equations of blocks by Gaussian elimination. No pivoting: for a stable step the matrix is near the identity. Not
/// inlined, so that the code of explicit steps does not depend on it.
#[inline(never)]
fn eliminate<const N: usize>(mut matrix: [[DMat3; N]; N], mut right: [DVec3; N]) -> [DVec3; N] {
    for pivot in 0..N {
        let (of_pivot, known) = (matrix[pivot], right[pivot]);
        let inverse = of_pivot[pivot].inverse();
        for (row, right) in matrix.iter_mut().zip(&mut right).skip(pivot + 1) {
            let factor = row[pivot] * inverse;
            row.iter_mut().zip(of_pivot).for_each(|(part, of_pivot)| *part -= factor * of_pivot);
            *right -= factor * known;
        }
    }
    for row in (0..N).rev() {
        let known =
            (row + 1..N).fold(DVec3::ZERO, |sum, column| sum + matrix[row][column] * right[column]);
        right[row] = matrix[row][row].inverse() * (right[row] - known);
    }
    right
}

/// Groups in an array.
struct Groups<S, const N: usize> {
    field: Group<S, N>,
    method: Method,
    substeps: u32,
    ids: Vec<u32>,
    /// Position, velocity and last acceleration of each group.
    states: Vec<[Several<N>; 3]>,
    has_last_acceleration: bool,
    /// Length of the last step, s; 0 at the start.
    last_step: f64,
}

/// The run of `scene`, copies of a group with the springs of `S`, in a loop.
pub(crate) fn run_groups<S: Springs<N>, const N: usize>(
    scene: &Scene,
    setting: Setting,
) -> Box<dyn Runner> {
    Box::new(Groups::<S, N>::new(scene, setting))
}

impl<S: Springs<N>, const N: usize> Groups<S, N> {
    fn new(scene: &Scene, setting: Setting) -> Self {
        let bodies: Vec<_> = movable(scene).collect();
        let group = |bodies: &[(u32, &scene::BodySpec)]| {
            let x = Several(from_fn(|k| bodies[k].1.position));
            [x, Several(from_fn(|k| bodies[k].1.velocity)), Several([DVec3::ZERO; N])]
        };
        Self {
            field: Group {
                h: 1.0 / (scene.step_hz * f64::from(setting.substeps.least())),
                counts: Counts::default(),
                unconverged: 0,
                springs: PhantomData,
            },
            method: setting.method,
            substeps: setting.substeps.least(),
            states: bodies.chunks_exact(N).map(group).collect(),
            ids: bodies.into_iter().map(|(id, _)| id).collect(),
            has_last_acceleration: false,
            last_step: 0.0,
        }
    }
}

impl<S: Springs<N>, const N: usize> Steps for Groups<S, N> {
    fn step<M: Integrator>(&mut self) {
        let caches = M::STATE == MethodStateKind::LastAcceleration;
        for _ in 0..self.substeps {
            for [x, v, a] in &mut self.states {
                let start = (caches && self.has_last_acceleration).then_some(*a);
                let mut state = StepState { last_step: self.last_step, start };
                (*x, *v) = M::step(&mut self.field, *x, *v, &mut state);
                *a = state.start.unwrap_or(*a);
            }
            (self.has_last_acceleration, self.last_step) = (caches, self.field.h);
        }
    }
}

impl<S: Springs<N>, const N: usize> Runner for Groups<S, N> {
    fn tick(&mut self) {
        step_by(self.method, self);
    }

    fn states(&mut self) -> Vec<Sample> {
        let rows = self.states.iter().flat_map(|[x, v, _]| x.0.into_iter().zip(v.0));
        self.ids.iter().zip(rows).map(|(id, (x, v))| (*id, x, v)).collect()
    }

    fn counts(&mut self) -> Counts {
        self.field.counts
    }

    fn failure(&mut self) -> Option<Failure> {
        let steps = self.field.unconverged;
        (steps > 0).then_some(Failure::Unconverged { steps })
    }
}
