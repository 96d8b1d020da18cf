//! Laws that are called, beside hand-written loops over arrays of the same arithmetic with baseline instructions, by
//! semi-implicit Euler and Runge-Kutta 4: one well, five wells, quadratic drag, and a law of a user's own.
//!
//! Ratios are medians inside interleaved rounds of thread CPU time. Both sides are first shown to have the same bits.

#[path = "common/mod.rs"]
mod common;

use std::hint::black_box;

use bevy_ecs::prelude::*;
use common::{Contestant, compare};
use motion::units::Vector;
use motion::{
    BodyState, Drag, EvaluationTime, Jacobians, Law, Laws, Method, PhysicsBody, Stepper, TimeStep, Transform,
    Well, Wells,
};

const H: f64 = 1.0 / 120.0;
const SIZES: [usize; 2] = [1_000, 100_000];

/// A spring to the origin with a cubic part, as a user writes it.
#[derive(Debug)]
struct Stiffening;

impl Law for Stiffening {
    fn name(&self) -> &'static str {
        "stiffening"
    }
    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
        let x = body.position;
        x * -(1e-3 + 1e-9 * x.dot(x))
    }
    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians { position: glam::DMat3::IDENTITY * -1e-3, ..Jacobians::zero() }
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}

fn wells(count: u32) -> Vec<Well> {
    let well = |i| Well {
        position: Vector::new(-10.0 - f64::from(i), 3.0 * f64::from(i), -10.0),
        strength: 1e3,
        softening: 0.1,
    };
    (0..count).map(well).collect()
}

type V = [f64; 3];

/// `wells` and their sum, written by hand.
#[inline(always)]
fn pulled<const N: usize>(wells: &[(V, f64, f64); N], x: V) -> V {
    let mut sum = [0.0; 3];
    for (at, strength, softening) in wells {
        let r = [x[0] - at[0], x[1] - at[1], x[2] - at[2]];
        let q = 1.0 / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + softening * softening).sqrt();
        let f = -(strength * q * q * q);
        (0..3).for_each(|axis| sum[axis] += r[axis] * f);
    }
    sum
}

fn by_hand<const N: usize>(wells: &[Well]) -> [(V, f64, f64); N] {
    std::array::from_fn(|i| (wells[i].position.to_array(), wells[i].strength, wells[i].softening))
}

#[inline(always)]
fn plus(a: V, b: V, factor: f64) -> V {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

#[inline(always)]
fn sum(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// x, y, z, and the velocities.
struct Soa([Vec<f64>; 6]);

impl Soa {
    fn new(n: usize) -> Self {
        Self(std::array::from_fn(|column| (0..n).map(|i| start(i)[column / 3][column % 3]).collect()))
    }

    /// One step of every body by `step`, which gets its position and velocity.
    #[inline(always)]
    fn step(&mut self, step: impl Fn(V, V) -> (V, V)) {
        let [x, y, z, a, b, c] = &mut self.0;
        let n = x.len();
        let (x, y, z, a, b, c) =
            (&mut x[..n], &mut y[..n], &mut z[..n], &mut a[..n], &mut b[..n], &mut c[..n]);
        for i in 0..n {
            let (p, v) = step([x[i], y[i], z[i]], [a[i], b[i], c[i]]);
            ([x[i], y[i], z[i]], [a[i], b[i], c[i]]) = (p, v);
        }
    }

    #[inline(always)]
    fn euler(&mut self, law: impl Fn(V, V) -> V) {
        self.step(
            #[inline(always)]
            |x, v| {
                let v = plus(v, law(x, v), H);
                (plus(x, v, H), v)
            },
        );
    }

    #[inline(always)]
    fn runge_kutta(&mut self, law: impl Fn(V, V) -> V) {
        let (half, sixth) = (H * 0.5, H * (1.0 / 6.0));
        self.step(
            #[inline(always)]
            |x, v| {
                let a1 = law(x, v);
                let v2 = plus(v, a1, half);
                let a2 = law(plus(x, v, half), v2);
                let v3 = plus(v, a2, half);
                let a3 = law(plus(x, v2, half), v3);
                let v4 = plus(v, a3, H);
                let a4 = law(plus(x, v3, H), v4);
                let inner = sum(a2, a3);
                let x = plus(x, plus(v, sum(a1, inner), sixth), H);
                (x, plus(v, sum(sum(sum(a1, inner), inner), a4), sixth))
            },
        );
    }
}

#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn start(i: usize) -> [V; 2] {
    [[(i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64 + 1.0], [1.0, 0.5, -0.5]]
}

struct Ecs {
    world: World,
    stepper: Stepper,
}

impl Ecs {
    fn new(method: Method, n: usize, law: impl FnOnce(&mut World)) -> Self {
        let mut world = World::new();
        law(&mut world);
        let body = |i| {
            let [x, v] = start(i).map(Vector::from_array);
            (Transform::at(x), PhysicsBody { velocity: v, inverse_mass: 1.0 })
        };
        world.spawn_batch((0..n).map(body).collect::<Vec<_>>());
        let stepper = Stepper::new(&mut world, method, TimeStep(H));
        Self { world, stepper }
    }

    fn tick(&mut self) {
        self.stepper.tick(&mut self.world);
    }
}

/// A law: its name, the world that has it, and a step by hand of each of the two methods.
type Case = (&'static str, fn(&mut World), [fn(&mut Soa); 2], [f64; 2]);

fn cases() -> [Case; 4] {
    let one = |soa: &mut Soa| {
        let wells = by_hand::<1>(&wells(1));
        soa.euler(|x, _| pulled(&wells, x));
    };
    let one_by_four = |soa: &mut Soa| {
        let wells = by_hand::<1>(&wells(1));
        soa.runge_kutta(|x, _| pulled(&wells, x));
    };
    let five = |soa: &mut Soa| {
        let wells = by_hand::<5>(&wells(5));
        soa.euler(|x, _| pulled(&wells, x));
    };
    let five_by_four = |soa: &mut Soa| {
        let wells = by_hand::<5>(&wells(5));
        soa.runge_kutta(|x, _| pulled(&wells, x));
    };
    [
        ("one well", |world| world.insert_resource(Wells(wells(1))), [one, one_by_four], [2.0, 1.2]),
        ("five wells", |world| world.insert_resource(Wells(wells(5))), [five, five_by_four], [1.2, 1.2]),
        (
            "quadratic drag",
            |world| world.insert_resource(Drag::new(0.0, 0.01)),
            [|soa| soa.euler(resisted), |soa| soa.runge_kutta(resisted)],
            [2.0, 1.2],
        ),
        (
            "a law of one's own",
            |world| world.insert_resource(Laws(vec![Box::new(Stiffening)])),
            [|soa| soa.euler(stiffened), |soa| soa.runge_kutta(stiffened)],
            [2.5, 2.5],
        ),
    ]
}

#[inline(always)]
fn resisted(_: V, v: V) -> V {
    let k = 0.01 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|part| -(part * k))
}

#[inline(always)]
fn stiffened(x: V, _: V) -> V {
    let k = -(1e-3 + 1e-9 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
    x.map(|part| part * k)
}

const METHODS: [Method; 2] = [Method::SemiImplicitEuler, Method::RungeKutta4];

/// Both sides must do the same work, or the ratio means nothing.
fn assert_same_bits((name, law, by_hand, _): &Case) {
    let n = 1_003;
    for (method, step) in METHODS.into_iter().zip(by_hand) {
        let (mut soa, mut ecs) = (Soa::new(n), Ecs::new(method, n, law));
        for _ in 0..50 {
            step(&mut soa);
            ecs.tick();
        }
        let mut bodies = ecs.world.query::<(&Transform, &PhysicsBody)>();
        for (i, (transform, body)) in bodies.iter(&ecs.world).enumerate() {
            let world = transform.position.to_array().into_iter().chain(body.velocity.to_array());
            for (axis, number) in world.enumerate() {
                assert_eq!(number.to_bits(), soa.0[axis][i].to_bits(), "{name}, {method:?}, row {i}");
            }
        }
    }
}

fn main() {
    let cases = cases();
    cases.iter().for_each(assert_same_bits);
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("\nns a tick and median ratio to the loop by hand (interleaved, thread CPU time)");
    for n in SIZES {
        for (name, law, by_hand, bounds) in &cases {
            for ((method, step), bound) in METHODS.into_iter().zip(by_hand).zip(bounds) {
                let (mut soa, mut ecs) = (Soa::new(n), Ecs::new(method, n, law));
                let contestants: Vec<Contestant<'_>> = vec![
                    ("by hand", Box::new(|| step(black_box(&mut soa)))),
                    (method.name(), Box::new(|| ecs.tick())),
                ];
                compare(n, name, &[None, Some(*bound)], contestants);
            }
        }
    }
}
