//! Springs between the bodies of a group, in a loop over groups: several bodies are one state.

use std::array::from_fn;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};

use glam::{DMat3, DVec3};
use motion::Method;
use motion::methods::{Field, Integrator, MethodStateKind, Newton, NewtonField, StepState, newton_velocity};
use num_traits::Float as _;
use scene::Scene;

use super::numbers::{Compensated, LoopSpace, Single};
use super::{Steps, Vector, step_by};
use crate::cost::record::{Counts, Failure, Precision, Setting};
use crate::cost::runner::{Runner, Sample};
use crate::run::movable;

/// The springs of a group of `N` bodies.
pub(crate) trait Net<const N: usize>: Copy + Send + 'static {
    /// Masses, kg.
    const MASSES: [f64; N];
    /// The bodies that each spring joins, its stiffness, N/m, and its rest length, m.
    const SPRINGS: &'static [([usize; 2], f64, f64)];
}

/// Positions, velocities or accelerations of the bodies of a group.
#[derive(Clone, Copy)]
struct Several<S, const N: usize>([S; N]);

impl<S: LoopSpace, const N: usize> Add for Several<S, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<S: LoopSpace, const N: usize> Sub for Several<S, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl<S: LoopSpace, const N: usize> Mul<f64> for Several<S, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(from_fn(|k| self.0[k] * factor))
    }
}

impl<S: LoopSpace, const N: usize> Several<S, N> {
    fn to_double(self) -> [DVec3; N] {
        self.0.map(|vector| vector.seen().to_double())
    }
}

/// The field of one group.
struct Group<F, S, const N: usize> {
    h: f64,
    counts: Counts,
    unconverged: u64,
    net: PhantomData<(F, S)>,
}

impl<F: Net<N>, S: LoopSpace, const N: usize> Field for Group<F, S, N> {
    type Space = Several<S, N>;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.h
    }

    #[inline(always)]
    fn laws(&mut self, _: f64, Several(x): Self::Space, _: Self::Space) -> Self::Space {
        self.counts.accelerations += N as u64;
        let x = x.map(LoopSpace::seen);
        let mut forces = [<S::Seen as Vector>::of(DVec3::ZERO); N];
        for ([a, b], stiffness, rest_length) in F::SPRINGS {
            let d = x[*b] - x[*a];
            let number = <S::Seen as Vector>::number;
            let stretch = number(1.0) - number(*rest_length) * d.dot(d).sqrt().recip();
            let pull = d.times(number(*stiffness) * stretch);
            (forces[*a], forces[*b]) = (forces[*a] + pull, forces[*b] - pull);
        }
        Several(from_fn(|k| S::of(forces[k].times(<S::Seen as Vector>::number(1.0 / F::MASSES[k])))))
    }

    #[inline(always)]
    fn applied(&self) -> Self::Space {
        Several([S::default(); N])
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

impl<F: Net<N>, S: LoopSpace, const N: usize> NewtonField for Group<F, S, N> {
    const EPSILON: f64 =
        if size_of::<<S::Seen as Vector>::Number>() == 4 { f32::EPSILON as f64 } else { f64::EPSILON };

    fn linear_rate(&self) -> Option<f64> {
        None
    }

    fn correction(&mut self, x: Self::Space, _: Self::Space, residual: Self::Space) -> Self::Space {
        let (x, residual) = (x.to_double(), residual.to_double());
        let mut matrix: [[DMat3; N]; N] = from_fn(|_| [DMat3::ZERO; N]);
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = DMat3::IDENTITY;
        }
        for ([a, b], stiffness, rest_length) in F::SPRINGS {
            let d = x[*b] - x[*a];
            let (n, taut) = (d.normalize(), 1.0 - rest_length / d.length());
            let along = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            let stiff = (along + (DMat3::IDENTITY - along) * taut) * (stiffness * self.h * self.h);
            for [from, to] in [[*a, *b], [*b, *a]] {
                matrix[from][from] += stiff * (1.0 / F::MASSES[from]);
                matrix[from][to] -= stiff * (1.0 / F::MASSES[from]);
            }
        }
        let solved = eliminate(matrix, residual);
        Several(from_fn(|k| S::of(<S::Seen as Vector>::of(solved[k]))))
    }

    fn size(&self, v: Self::Space) -> f64 {
        v.to_double().into_iter().fold(0.0, |size, v| v.abs().max_element().max(size))
    }

    fn report(&mut self, Newton { iterations, converged }: Newton) {
        self.counts.solver += u64::from(iterations);
        self.unconverged += u64::from(!converged);
    }
}

/// Solves the equations of blocks by Gauss's elimination: their matrix is that of a stable step, near 1.
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
        let known = (row + 1..N).fold(DVec3::ZERO, |sum, column| sum + matrix[row][column] * right[column]);
        right[row] = matrix[row][row].inverse() * (right[row] - known);
    }
    right
}

/// Groups in an array.
struct Groups<F, S, const N: usize> {
    field: Group<F, S, N>,
    method: Method,
    substeps: u32,
    ids: Vec<u32>,
    /// Position, velocity and last acceleration of each group.
    states: Vec<[Several<S, N>; 3]>,
    has_a: bool,
    /// Length of the last step, s; 0 at the start.
    last_step: f64,
}

/// The run of `scene`, copies of a group with the springs of `F`, in a loop.
pub(crate) fn run_groups<F: Net<N>, const N: usize>(scene: &Scene, setting: Setting) -> Box<dyn Runner> {
    match setting.precision {
        Precision::F64 => Box::new(Groups::<F, DVec3, N>::new(scene, setting)),
        Precision::F32 => Box::new(Groups::<F, Single, N>::new(scene, setting)),
        Precision::CompensatedF32 => Box::new(Groups::<F, Compensated, N>::new(scene, setting)),
    }
}

impl<F: Net<N>, S: LoopSpace, const N: usize> Groups<F, S, N> {
    fn new(scene: &Scene, setting: Setting) -> Self {
        let bodies: Vec<_> = movable(scene).collect();
        let space = |vector| S::of(<S::Seen as Vector>::of(vector));
        let group = |bodies: &[(u32, &scene::BodySpec)]| {
            let x = Several(from_fn(|k| space(bodies[k].1.position)));
            [x, Several(from_fn(|k| space(bodies[k].1.velocity))), Several([S::default(); N])]
        };
        Self {
            field: Group {
                h: 1.0 / (scene.step_hz * f64::from(setting.substeps)),
                counts: Counts::default(),
                unconverged: 0,
                net: PhantomData,
            },
            method: setting.method,
            substeps: setting.substeps,
            states: bodies.chunks_exact(N).map(group).collect(),
            ids: bodies.into_iter().map(|(id, _)| id).collect(),
            has_a: false,
            last_step: 0.0,
        }
    }
}

impl<F: Net<N>, S: LoopSpace, const N: usize> Steps for Groups<F, S, N> {
    fn step<M: Integrator>(&mut self) {
        let caches = M::STATE == MethodStateKind::LastAcceleration;
        for _ in 0..self.substeps {
            for [x, v, a] in &mut self.states {
                let start = (caches && self.has_a).then_some(*a);
                let mut state = StepState { last_step: self.last_step, start };
                (*x, *v) = M::step(&mut self.field, *x, *v, &mut state);
                *a = state.start.unwrap_or(*a);
            }
            (self.has_a, self.last_step) = (caches, self.field.h);
        }
    }
}

impl<F: Net<N>, S: LoopSpace, const N: usize> Runner for Groups<F, S, N> {
    fn tick(&mut self) {
        step_by(self.method, self);
    }

    fn states(&mut self) -> Vec<Sample> {
        let rows = self.states.iter().flat_map(|[x, v, _]| x.to_double().into_iter().zip(v.to_double()));
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
