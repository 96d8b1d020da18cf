//! Many small groups beside a hand-written loop of the same arithmetic: masses on springs to posts, pairs, chains of ten.
//!
//! The loop has the springs of one group as constants and the groups in one array, group after group. Ratios are medians
//! inside interleaved rounds of thread CPU time. `-- --steps SHAPE METHOD BODIES STEPS` does nothing but steps, for an
//! instruction counter; METHOD may be `loop`.

#[path = "common/mod.rs"]
mod common;

use std::hint::black_box;
use std::ops::{Add, Mul, Sub};

use bevy_ecs::prelude::*;
use common::{Contestant, compare};
use motion::methods::{Field, Integrator, RungeKutta4, SemiImplicitEuler, StepState};
use motion::units::Vector;
use motion::{
    Elastic, Gravity, Method, PhysicsBody, Spring, StableId, Stepper, TimeStep, Transform,
};

const H: f64 = 1.0 / 240.0;
const G: Vector = Vector::new(0.0, -9.8, 0.0);

/// A group: the bodies that move hang below a post, or below each other.
#[derive(Clone, Copy)]
struct Shape {
    name: &'static str,
    /// Whether the first body hangs on a post.
    hangs: bool,
    bodies: usize,
    elastic: Elastic,
    /// The ratios to the loop that semi-implicit Euler and Runge-Kutta 4 are to keep.
    reach: [Option<f64>; 2],
}

const HARMONIC: Elastic = Elastic::new(40.0, 0.0);
const STIFF: Elastic = Elastic::new(40.0, 1.0);

const SHAPES: [Shape; 4] = [
    Shape { name: "harmonic", hangs: true, bodies: 1, elastic: HARMONIC, reach: [None; 2] },
    Shape { name: "post", hangs: true, bodies: 1, elastic: STIFF, reach: [Some(3.0), Some(1.5)] },
    Shape { name: "pair", hangs: false, bodies: 2, elastic: STIFF, reach: [Some(2.5), Some(1.5)] },
    Shape {
        name: "chain",
        hangs: false,
        bodies: 10,
        elastic: STIFF,
        reach: [Some(2.5), Some(1.5)],
    },
];

/// Position of body `k` of a group, 0 for a post.
fn start(group: usize, k: usize) -> Vector {
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let (group, k) = (group as f64, k as f64);
    Vector::new(group * 3.0 + 0.1 * k, -1.1 * k, 0.02 * k * k)
}

fn world(shape: Shape, groups: usize, method: Method) -> (World, Stepper) {
    let mut world = World::new();
    world.insert_resource(Gravity::new(G));
    let mut ids = 0..;
    let mut spawn = |world: &mut World, at: Vector, body: PhysicsBody| {
        world
            .spawn((
                StableId(ids.next().expect("there is always a next number")),
                Transform::at(at),
                body,
            ))
            .id()
    };
    for group in 0..groups {
        let post = shape.hangs.then(|| spawn(&mut world, start(group, 0), PhysicsBody::IMMOVABLE));
        let bodies: Vec<_> = (1..=shape.bodies)
            .map(|k| {
                spawn(
                    &mut world,
                    start(group, k),
                    PhysicsBody { inverse_mass: 1.0, ..PhysicsBody::IMMOVABLE },
                )
            })
            .collect();
        let all: Vec<_> = post.into_iter().chain(bodies).collect();
        for ends in all.windows(2) {
            world.spawn(Spring { ends: [ends[0], ends[1]], elastic: shape.elastic });
        }
    }
    let stepper = Stepper::new(&mut world, method, TimeStep(H));
    (world, stepper)
}

/// Positions, velocities or accelerations of the bodies of a group.
#[derive(Clone, Copy)]
struct Bodies<const N: usize>([Vector; N]);

impl<const N: usize> Add for Bodies<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<const N: usize> Sub for Bodies<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl<const N: usize> Mul<f64> for Bodies<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|v| v * factor))
    }
}

/// The forces of one group.
struct Group<const N: usize, const HANGS: bool> {
    elastic: Elastic,
    post: Vector,
}

impl<const N: usize, const HANGS: bool> Group<N, HANGS> {
    #[inline(always)]
    fn pull(&self, d: Vector) -> Vector {
        let Elastic { stiffness, rest_length, .. } = self.elastic;
        if rest_length == 0.0 {
            d * stiffness
        } else {
            d * (stiffness * (1.0 - rest_length / d.length()))
        }
    }
}

impl<const N: usize, const HANGS: bool> Field for Group<N, HANGS> {
    type Space = Bodies<N>;

    fn step(&self) -> f64 {
        H
    }

    #[inline(always)]
    fn laws(&mut self, _: f64, Bodies(x): Bodies<N>, _: Bodies<N>) -> Bodies<N> {
        let mut a = [G; N];
        if HANGS {
            a[0] += self.pull(self.post - x[0]);
        }
        for k in 1..N {
            let pull = self.pull(x[k] - x[k - 1]);
            a[k - 1] += pull;
            a[k] -= pull;
        }
        Bodies(a)
    }

    fn applied(&self) -> Bodies<N> {
        Bodies([Vector::ZERO; N])
    }

    #[inline(always)]
    fn plus_applied(&self, a: Bodies<N>) -> Bodies<N> {
        a
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn implicit_velocity(&mut self, _: Bodies<N>, v: Bodies<N>) -> Bodies<N> {
        v
    }
}

fn rival<M: Integrator, const N: usize, const HANGS: bool>(
    shape: Shape,
    groups: usize,
) -> Box<dyn FnMut()> {
    let at = |group| Bodies(std::array::from_fn(|k| start(group, k + 1)));
    let mut states: Vec<_> =
        (0..groups).map(|group| (at(group), Bodies([Vector::ZERO; N]), start(group, 0))).collect();
    let elastic = black_box(shape.elastic);
    Box::new(move || {
        for (x, v, post) in &mut states {
            let mut field = Group::<N, HANGS> { elastic, post: *post };
            (*x, *v) = M::step(&mut field, *x, *v, &mut StepState::default());
        }
    })
}

fn rival_of<M: Integrator>(shape: Shape, groups: usize) -> Box<dyn FnMut()> {
    match (shape.bodies, shape.hangs) {
        (1, true) => rival::<M, 1, true>(shape, groups),
        (2, false) => rival::<M, 2, false>(shape, groups),
        (10, false) => rival::<M, 10, false>(shape, groups),
        _ => unreachable!("one of the shapes"),
    }
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [flag, shape, method, bodies, steps] = &arguments[..]
        && flag == "--steps"
    {
        let shape = *SHAPES.iter().find(|known| known.name == shape).expect("a shape");
        let (bodies, steps): (usize, usize) =
            (bodies.parse().expect("bodies"), steps.parse().expect("steps"));
        let groups = bodies / shape.bodies;
        if method == "loop" {
            let mut rival = rival_of::<SemiImplicitEuler>(shape, groups);
            (0..steps).for_each(|_| rival());
        } else {
            let (mut world, mut stepper) =
                world(shape, groups, Method::from_name(method).expect("a method"));
            (0..steps).for_each(|_| stepper.tick(&mut world));
            black_box(world);
        }
        return;
    }
    for bodies in [1_000, 100_000] {
        for shape in SHAPES {
            let groups = bodies / shape.bodies;
            for (method, loops, reach) in [
                (
                    Method::SemiImplicitEuler,
                    rival_of::<SemiImplicitEuler>(shape, groups),
                    shape.reach[0],
                ),
                (Method::RungeKutta4, rival_of::<RungeKutta4>(shape, groups), shape.reach[1]),
            ] {
                let (mut world, mut stepper) = world(shape, groups, method);
                let contestants: Vec<Contestant> = vec![
                    ("loop", loops),
                    (method.name(), Box::new(move || stepper.tick(&mut world))),
                ];
                compare(bodies, shape.name, &[None, reach], contestants);
            }
        }
    }
}
