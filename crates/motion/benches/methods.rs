//! Every method beside a hand-written fused loop of the same arithmetic, under gravity and linear drag: the
//! step schedule of a world, and bare blocks.
//!
//! Ratios are medians inside interleaved rounds of thread CPU time; two threads are measured by the wall clock.
//! `-- METHOD ...` measures these methods alone. `-- --steps METHOD BODIES STEPS` does nothing but steps of a
//! world, for an instruction counter: the difference between two numbers of steps is free of the start.

#[path = "common/mod.rs"]
mod common;

use std::hint::black_box;
use std::time::Instant;

use bevy_ecs::prelude::*;
use common::{Contestant, avx2_or_plain, compare};
use motion::arrays::Bare;
use motion::units::Vector;
use motion::{Drag, Gravity, METHODS, Method, PhysicsBody, Stepper, Threads, TimeStep, Transform};

const H: f64 = 1.0 / 120.0;
const C: f64 = 0.4;
const G: f64 = -9.8;
const SIZES: [usize; 3] = [1_000, 100_000, 1_000_000];

/// Columns of x, v and w that start at different offsets of a page and on cache lines.
struct Soa {
    numbers: Vec<f64>,
    aligned: usize,
    n: usize,
}

fn start(i: usize) -> ([f64; 3], [f64; 3], f64) {
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let at = i as f64;
    let movable = i % 64 != 63;
    ([at, 10.0, -at], if movable { [1.0, 2.0, 3.0] } else { [0.0; 3] }, if movable { 10.0 } else { 0.0 })
}

impl Soa {
    fn new(n: usize) -> Self {
        let numbers = vec![0.0; 7 * Self::stride(n) + 64];
        let aligned = numbers.as_ptr().align_offset(64);
        let mut soa = Self { numbers, aligned, n };
        let (x, v, w) = soa.columns();
        for i in 0..n {
            let (position, velocity, inverse_mass) = start(i);
            for axis in 0..3 {
                x[axis][i] = position[axis];
                v[axis][i] = velocity[axis];
            }
            w[i] = inverse_mass;
        }
        soa
    }

    fn stride(n: usize) -> usize {
        n.next_multiple_of(1024) + 144
    }

    fn columns(&mut self) -> ([&mut [f64]; 3], [&mut [f64]; 3], &mut [f64]) {
        let (n, stride) = (self.n, Self::stride(self.n));
        let mut columns =
            self.numbers[self.aligned..].chunks_exact_mut(stride).map(|column| &mut column[..n]);
        let mut next = || columns.next().expect("seven columns");
        ([next(), next(), next()], [next(), next(), next()], next())
    }
}

/// The hand-written loop of a method: `$step` is one step of one axis, with `$a` the acceleration at a velocity.
macro_rules! fused {
    ($name:ident, |$x:ident, $v:ident, $h:ident, $a:ident| $step:expr) => {
        avx2_or_plain! {
            fn $name(soa: &mut Soa) {
                const $h: f64 = 1.0 / 120.0;
                let ([x0, x1, x2], [v0, v1, v2], w) = soa.columns();
                let n = w.len();
                let (x0, x1, x2) = (&mut x0[..n], &mut x1[..n], &mut x2[..n]);
                let (v0, v1, v2) = (&mut v0[..n], &mut v1[..n], &mut v2[..n]);
                for i in 0..n {
                    let movable = w[i] > 0.0;
                    #[inline(always)]
                    fn axis(movable: bool, g: f64, $x: f64, $v: f64) -> (f64, f64) {
                        let $a = |v: f64| if movable { g - v * C } else { 0.0 };
                        let (x, v): (f64, f64) = $step;
                        (x, if v.abs() < 1e-290 { 0.0 } else { v })
                    }
                    (x0[i], v0[i]) = axis(movable, 0.0, x0[i], v0[i]);
                    (x1[i], v1[i]) = axis(movable, G, x1[i], v1[i]);
                    (x2[i], v2[i]) = axis(movable, 0.0, x2[i], v2[i]);
                }
            }
        }
    };
}

fused!(explicit_euler, |x, v, H, a| (x + v * H, v + a(v) * H));
fused!(semi_implicit_euler, |x, v, H, a| {
    let v = v + a(v) * H;
    (x + v * H, v)
});
fused!(implicit_euler, |x, v, H, a| {
    let v = v + a(v) * (H / (1.0 + C * H));
    (x + v * H, v)
});
// The step never changes, so that there is nothing to remember.
fused!(position_verlet, |x, v, H, a| {
    let v = v + a(v) * (0.5 * (H + H));
    (x + v * H, v)
});
fused!(velocity_verlet, |x, v, H, a| {
    let first = a(v);
    let x = x + (v + first * (H * 0.5)) * H;
    (x, v + (first + a(v + first * H)) * (H * 0.5))
});
fused!(runge_kutta_2_midpoint, |x, v, H, a| {
    let middle = v + a(v) * (0.5 * H);
    (x + middle * H, v + a(middle) * H)
});
fused!(runge_kutta_2_heun, |x, v, H, a| {
    let first = a(v);
    let end = v + first * H;
    (x + (v + end) * (H * 0.5), v + (first + a(end)) * (H * 0.5))
});
fused!(runge_kutta_4, |x, v, H, a| {
    const SIXTH: f64 = 1.0 / 6.0;
    let a1 = a(v);
    let a2 = a(v + a1 * (H * 0.5));
    let a3 = a(v + a2 * (H * 0.5));
    let a4 = a(v + a3 * H);
    let inner = a2 + a3;
    (x + (v + (a1 + inner) * (H * SIXTH)) * H, v + (a1 + inner + inner + a4) * (H * SIXTH))
});
fused!(yoshida_4, |x, v, H, a| {
    const OUTER: f64 = 1.351_207_191_959_657_6;
    const INNER: f64 = 1.0 - 2.0 * 1.351_207_191_959_657_6;
    let (mut x, mut v) = (x, v);
    for h in [OUTER * H, INNER * H, OUTER * H] {
        let first = a(v);
        x += (v + first * (h * 0.5)) * h;
        v += (first + a(v + first * h)) * (h * 0.5);
    }
    (x, v)
});

/// The hand-written loop of a method.
fn by_hand(method: Method) -> fn(&mut Soa) {
    match method {
        Method::ExplicitEuler => explicit_euler,
        Method::SemiImplicitEuler => semi_implicit_euler,
        Method::ImplicitEuler => implicit_euler,
        Method::PositionVerlet => position_verlet,
        Method::VelocityVerlet => velocity_verlet,
        Method::RungeKutta2Midpoint => runge_kutta_2_midpoint,
        Method::RungeKutta2Heun => runge_kutta_2_heun,
        Method::RungeKutta4 => runge_kutta_4,
        Method::Yoshida4 => yoshida_4,
    }
}

/// Bare blocks.
fn bare(method: Method, n: usize) -> Bare {
    let mut bare = Bare::new(method, 1.0 / 120.0)
        .with_law(Gravity { acceleration: Vector::new(0.0, G, 0.0), on: true })
        .with_law(Drag::new(C, 0.0));
    for (x, v, w) in (0..n).map(start) {
        bare.add(x.map(|x| x), v.map(|v| v), w);
    }
    bare
}

/// Both sides must do the same work, or the ratio means nothing: the same bits, but of position
/// Verlet, which starts with another step.
fn assert_same_bits(method: Method) {
    let n = 1_003;
    let (mut soa, mut bare) = (Soa::new(n), bare(method, n));
    if method == Method::PositionVerlet {
        bare.tick();
        let ([x0, x1, x2], [v0, v1, v2], _) = soa.columns();
        for i in 0..n {
            [x0[i], x1[i], x2[i]] = bare.positions[i];
            [v0[i], v1[i], v2[i], _] = bare.bodies[i];
        }
    }
    for _ in 0..50 {
        by_hand(method)(&mut soa);
        bare.tick();
    }
    let (x, v, _) = soa.columns();
    for i in 0..n {
        for axis in 0..3 {
            assert_eq!(bare.positions[i][axis].to_bits(), x[axis][i].to_bits(), "{method:?} row {i}");
            assert_eq!(bare.bodies[i][axis].to_bits(), v[axis][i].to_bits(), "{method:?} row {i}");
        }
    }
}

struct Ecs {
    world: World,
    stepper: Stepper,
}

impl Ecs {
    fn new(method: Method, n: usize) -> Self {
        let mut world = World::new();
        world.insert_resource(Gravity { acceleration: Vector::new(0.0, G, 0.0), on: true });
        world.insert_resource(Drag::new(C, 0.0));
        let body = |(x, v, inverse_mass): ([f64; 3], [f64; 3], f64)| {
            (
                Transform::at(Vector::from_array(x)),
                PhysicsBody { velocity: Vector::from_array(v), inverse_mass },
            )
        };
        world.spawn_batch((0..n).map(start).map(body).collect::<Vec<_>>());
        let stepper = Stepper::new(&mut world, method, TimeStep(H));
        Self { world, stepper }
    }

    fn tick(&mut self) {
        self.stepper.tick(&mut self.world);
    }
}

/// What the step of a world and bare blocks may cost, in hand-written loops.
fn reach(method: Method, n: usize) -> Option<f64> {
    match (method, n) {
        (Method::SemiImplicitEuler, 1_000) => Some(2.0),
        (Method::SemiImplicitEuler, _) => Some(1.3),
        (Method::RungeKutta4, 1_000) => Some(2.2),
        (Method::RungeKutta4, _) => Some(1.7),
        _ => None,
    }
}

fn ratios(only: &[String]) {
    println!("\nns a tick and median ratio to the first of each group (interleaved, thread CPU time)");
    for n in SIZES {
        for claims in
            METHODS.iter().filter(|claims| only.is_empty() || only.iter().any(|name| name == claims.name))
        {
            let (method, title) = (claims.method, claims.name);
            let bound = reach(method, n);
            let (mut soa, mut bare) = (Soa::new(n), bare(method, n));
            let mut ecs = Ecs::new(method, n);
            let contestants: Vec<Contestant<'_>> = vec![
                ("hand fused", Box::new(|| by_hand(method)(black_box(&mut soa)))),
                ("world", Box::new(|| ecs.tick())),
                ("bare blocks", Box::new(|| bare.tick())),
            ];
            compare(n, title, &[None, bound, None], contestants);
        }
    }
}

/// A step after 2,000 s of nothing but drag beside a fresh one, which does not grow old in the measurement.
fn decayed() {
    for claims in METHODS.iter() {
        let n = 1_000;
        let [mut fresh, mut old] = [0; 2].map(|_| {
            let mut ecs = Ecs::new(claims.method, n);
            ecs.world.remove_resource::<Gravity>();
            ecs
        });
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of ticks")]
        let ticks = (2_000.0 / H) as u64;
        (0..ticks).for_each(|_| old.tick());
        compare(
            n,
            claims.name,
            &[None, Some(1.1)],
            vec![("fresh", Box::new(|| fresh.tick())), ("after 2,000 s of drag", Box::new(|| old.tick()))],
        );
    }
}

/// One thread against two, by the wall clock: the shortest of many rounds, because others use the machine too.
fn threads() {
    println!("\none thread over two, shortest of 15 interleaved rounds of 10 ticks, wall clock");
    for method in [Method::SemiImplicitEuler, Method::RungeKutta4] {
        let n = 1_000_000;
        let (mut one, mut two) = (Ecs::new(method, n), Ecs::new(method, n));
        two.world.insert_resource(Threads::new(2));
        let mut shortest = [f64::INFINITY; 2];
        for _ in 0..15 {
            for (ecs, shortest) in [&mut one, &mut two].into_iter().zip(&mut shortest) {
                let clock = Instant::now();
                (0..10).for_each(|_| ecs.tick());
                *shortest = shortest.min(clock.elapsed().as_secs_f64());
            }
        }
        let ratio = shortest[0] / shortest[1];
        let held = if ratio >= 1.35 { "held" } else { "MISSED" };
        println!("{:>22} {n:>9}  {ratio:6.3}  reach 1.35: {held}", method.name());
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(place) = arguments.iter().position(|argument| argument == "--steps") {
        let [method, bodies, steps] = &arguments[place + 1..place + 4] else { panic!("METHOD BODIES STEPS") };
        let method = Method::from_name(method).expect("a method");
        let mut ecs = Ecs::new(method, bodies.parse().expect("a number"));
        (0..steps.parse().expect("a number")).for_each(|_: u32| ecs.tick());
        return;
    }
    for method in Method::ALL {
        assert_same_bits(method);
    }
    if !arguments.iter().any(|argument| argument == "--test") {
        let only: Vec<String> = arguments.into_iter().skip(1).filter(|word| !word.starts_with('-')).collect();
        ratios(&only);
        decayed();
        threads();
    }
}
