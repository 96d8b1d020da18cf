//! The step schedule beside hand-written loops of the same arithmetic, in the same run.
//!
//! Times are thread CPU time. Below the criterion groups a table gives the medians of the ratios inside
//! interleaved rounds, which is what a shared machine can be asked for.

#[path = "common/mod.rs"]
mod common;

use std::hint::black_box;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use common::{avx2_or_plain, compare};
use cpu_time::ThreadTime;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{BenchmarkId, Criterion, Throughput};
use motion::internals::{
    Passes, StepPlan, insert_step_resources, integrate_acceleration, integrate_velocity,
    step_schedule,
};
use motion::units::Vector;
use motion::{Damping, Force, Gravity, PhysicsBody, PushQueue, TimeStep, Transform};

const H: f64 = 1.0 / 120.0;
const SIZES: [usize; 6] = [1, 100, 1_000, 10_000, 100_000, 1_000_000];
const RATE: f64 = 0.4;
const G: f64 = -9.8;
const SNAP: f64 = 1e-290;

/// Criterion's clock, on the CPU time of this thread.
struct ThreadCpu;

impl Measurement for ThreadCpu {
    type Intermediate = ThreadTime;
    type Value = std::time::Duration;

    fn start(&self) -> ThreadTime {
        ThreadTime::now()
    }
    fn end(&self, start: ThreadTime) -> Self::Value {
        start.elapsed()
    }
    fn add(&self, a: &Self::Value, b: &Self::Value) -> Self::Value {
        *a + *b
    }
    fn zero(&self) -> Self::Value {
        std::time::Duration::ZERO
    }
    #[expect(clippy::cast_precision_loss, reason = "nanoseconds of a benchmark")]
    fn to_f64(&self, value: &Self::Value) -> f64 {
        value.as_nanos() as f64
    }
    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

/// The hand-written structure of arrays: x, v and f in three columns each, and w.
///
/// One allocation with staggered columns: ten large ones would start at equal offsets in a page and fight for
/// the same cache sets.
struct Soa {
    n: usize,
    numbers: Vec<f64>,
    /// First number on a cache line: without it the loop is half again slower or not, by luck.
    aligned: usize,
}

struct Views<'a> {
    x: [&'a mut [f64]; 3],
    v: [&'a mut [f64]; 3],
    f: [&'a mut [f64]; 3],
    w: &'a [f64],
}

#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn start(i: usize) -> (Vector, Vector, f64) {
    let at = i as f64;
    let w = if i % 64 == 63 { 0.0 } else { 10.0 };
    (Vector::new(at, 10.0, -at), if w > 0.0 { Vector::new(1.0, 2.0, 3.0) } else { Vector::ZERO }, w)
}

impl Soa {
    fn new(n: usize) -> Self {
        let numbers = vec![0.0; 10 * Self::stride(n) + 8];
        let aligned = numbers.as_ptr().align_offset(64);
        let mut soa = Self { n, numbers, aligned };
        let Views { x, v, .. } = soa.views();
        for i in 0..n {
            let (position, velocity, _) = start(i);
            for axis in 0..3 {
                x[axis][i] = position[axis];
                v[axis][i] = velocity[axis];
            }
        }
        let w = soa.aligned + 9 * Self::stride(n);
        (0..n).for_each(|i| soa.numbers[w + i] = start(i).2);
        soa
    }

    /// A whole number of pages and nine cache lines.
    fn stride(n: usize) -> usize {
        n.next_multiple_of(512) + 72
    }

    fn views(&mut self) -> Views<'_> {
        let n = self.n;
        let mut columns = self.numbers[self.aligned..]
            .chunks_exact_mut(Self::stride(n))
            .map(|column| &mut column[..n]);
        let mut next = || columns.next().expect("ten columns");
        Views {
            x: [next(), next(), next()],
            v: [next(), next(), next()],
            f: [next(), next(), next()],
            w: next(),
        }
    }

    fn push(&mut self, stride: usize) {
        let [f, ..] = self.views().f;
        f.iter_mut().step_by(stride).for_each(|f| *f += 10.0);
    }
}

#[inline(always)]
fn snapped(v: f64, snap: bool) -> f64 {
    if snap && v.abs() < SNAP { 0.0 } else { v }
}

#[inline(always)]
fn fused_loop<const SNAPS: bool>(soa: &mut Soa, gravity: f64) {
    let k = 1.0 - RATE * H;
    let Views { x: [x0, x1, x2], v: [v0, v1, v2], f: [f0, f1, f2], w } = soa.views();
    let n = w.len();
    let (x0, x1, x2) = (&mut x0[..n], &mut x1[..n], &mut x2[..n]);
    let (v0, v1, v2) = (&mut v0[..n], &mut v1[..n], &mut v2[..n]);
    let (f0, f1, f2) = (&mut f0[..n], &mut f1[..n], &mut f2[..n]);
    for i in 0..n {
        let movable = w[i] > 0.0;
        let a = [f0[i] * w[i], f1[i] * w[i] + gravity, f2[i] * w[i]];
        let a = a.map(|a| if movable { a } else { 0.0 });
        let v = [v0[i] + a[0] * H, v1[i] + a[1] * H, v2[i] + a[2] * H];
        x0[i] += v[0] * H;
        x1[i] += v[1] * H;
        x2[i] += v[2] * H;
        v0[i] = snapped(v[0] * k, SNAPS);
        v1[i] = snapped(v[1] * k, SNAPS);
        v2[i] = snapped(v[2] * k, SNAPS);
        f0[i] = 0.0;
        f1[i] = 0.0;
        f2[i] = 0.0;
    }
}

avx2_or_plain! { fn fused(soa: &mut Soa, gravity: f64) { fused_loop::<true>(soa, gravity); } }
avx2_or_plain! { fn fused_without_snap(soa: &mut Soa, gravity: f64) { fused_loop::<false>(soa, gravity); } }

avx2_or_plain! {
    fn four_passes(soa: &mut Soa) {
        let k = 1.0 - RATE * H;
        let Views { mut x, mut v, mut f, w } = soa.views();
        for f in &mut f {
            // Apply: the pushed bodies were written already; a full pass over the forces is what a port does.
            f.iter_mut().for_each(|f| *f += 0.0);
        }
        for axis in 0..3 {
            let gravity = if axis == 1 { G } else { 0.0 };
            for ((v, f), w) in v[axis].iter_mut().zip(&*f[axis]).zip(w) {
                let a = if *w > 0.0 { f * w + gravity } else { 0.0 };
                *v += a * H;
            }
        }
        for (x, v) in x.iter_mut().zip(&mut v) {
            for (x, v) in x.iter_mut().zip(v.iter_mut()) {
                *x += *v * H;
                *v = snapped(*v * k, true);
            }
        }
        f.iter_mut().for_each(|f| f.fill(0.0));
    }
}

/// The tables of the ECS as plain vectors, for hand-written passes over the same columns.
struct Columns {
    transforms: Vec<Transform>,
    bodies: Vec<PhysicsBody>,
}

impl Columns {
    fn new(n: usize) -> Self {
        let rows = || (0..n).map(start);
        Self {
            transforms: rows().map(|(x, ..)| Transform::at(x)).collect(),
            bodies: rows()
                .map(|(_, velocity, inverse_mass)| PhysicsBody { velocity, inverse_mass })
                .collect(),
        }
    }
}

avx2_or_plain! {
    fn column_passes(columns: &mut Columns) {
        let k = 1.0 - RATE * H;
        let g = Vector::new(0.0, G, 0.0);
        for body in &mut columns.bodies {
            let a = if body.inverse_mass > 0.0 { g } else { Vector::ZERO };
            body.velocity += a * H;
        }
        for (transform, body) in columns.transforms.iter_mut().zip(&mut columns.bodies) {
            transform.position += body.velocity * H;
            let v = body.velocity * k;
            body.velocity = Vector::new(snapped(v.x, true), snapped(v.y, true), snapped(v.z, true));
        }
    }
}

struct Ecs {
    world: World,
    schedule: Schedule,
    pushed: Vec<Entity>,
}

impl Ecs {
    fn new(n: usize, gravity: f64, schedule: fn(&mut World) -> Schedule) -> Self {
        let mut world = World::new();
        insert_step_resources(&mut world, TimeStep(H));
        let mut uniform = Gravity::new(Vector::new(0.0, gravity, 0.0));
        uniform.on = gravity != 0.0;
        world.insert_resource(uniform);
        world.insert_resource(Damping::new(Damping::TUTORIAL.model, RATE));
        let bodies: Vec<_> = (0..n)
            .map(start)
            .map(|(x, velocity, inverse_mass)| {
                (Transform::at(x), PhysicsBody { velocity, inverse_mass })
            })
            .collect();
        let entities: Vec<_> = world.spawn_batch(bodies).collect();
        let mut schedule = schedule(&mut world);
        schedule.initialize(&mut world).expect("ordered");
        Self { world, schedule, pushed: entities.into_iter().step_by(100).collect() }
    }

    fn step(&mut self) {
        self.schedule.run(&mut self.world);
    }

    fn step_pushed(&mut self) {
        let mut queue = self.world.resource_mut::<PushQueue>();
        for body in &self.pushed {
            queue.push_once(*body, Vector::new(10.0, 0.0, 0.0));
        }
        self.schedule.run(&mut self.world);
    }
}

fn middle_schedule(_: &mut World) -> Schedule {
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems((integrate_acceleration, integrate_velocity).chain());
    schedule
}

fn one_pass(world: &mut World) -> Schedule {
    step_schedule(world, &StepPlan { passes: Passes::One, ..StepPlan::default() })
}

fn whole(world: &mut World) -> Schedule {
    step_schedule(world, &StepPlan::default())
}

/// Both sides must do the same work to the last bit, or the ratio means nothing.
fn assert_same_bits(n: usize) {
    for schedule in [whole, one_pass] {
        let (mut ecs, mut soa, mut passes) = (Ecs::new(n, G, schedule), Soa::new(n), Soa::new(n));
        for _ in 0..50 {
            ecs.step_pushed();
            soa.push(100);
            fused(&mut soa, G);
            passes.push(100);
            four_passes(&mut passes);
        }
        let mut rows = ecs.world.query::<(&Transform, &PhysicsBody, &Force)>();
        for (i, (transform, body, force)) in rows.iter(&ecs.world).enumerate() {
            for axis in 0..3 {
                for soa in [&mut soa, &mut passes] {
                    let Views { x, v, .. } = soa.views();
                    assert_eq!(transform.position[axis].to_bits(), x[axis][i].to_bits(), "row {i}");
                    assert_eq!(body.velocity[axis].to_bits(), v[axis][i].to_bits(), "row {i}");
                }
            }
            assert_eq!(force.newtons(), Vector::ZERO);
        }
    }
}

fn ratios() {
    println!(
        "\nns a step and median ratio to the first of each group (interleaved, thread CPU time)"
    );
    for n in SIZES {
        let step = match n {
            0..1_000 => None,
            1_000..100_000 => Some(2.0),
            _ => Some(1.6),
        };
        let (mut soa, mut passes, mut ecs) = (Soa::new(n), Soa::new(n), Ecs::new(n, G, whole));
        let mut one = Ecs::new(n, G, one_pass);
        compare(
            n,
            "step",
            &[None, None, None, step],
            vec![
                ("hand fused", Box::new(|| fused(black_box(&mut soa), G))),
                ("hand four passes", Box::new(|| four_passes(black_box(&mut passes)))),
                ("four systems", Box::new(|| ecs.step())),
                ("plan: one pass", Box::new(|| one.step())),
            ],
        );
        drop((soa, passes, ecs, one));
        let (mut soa, mut ecs) = (Soa::new(n), Ecs::new(n, G, whole));
        let mut one = Ecs::new(n, G, one_pass);
        compare(
            n,
            "step, 1 % pushed",
            &[None, None, step],
            vec![
                (
                    "hand fused",
                    Box::new(|| {
                        soa.push(100);
                        fused(black_box(&mut soa), G);
                    }),
                ),
                ("four systems", Box::new(|| ecs.step_pushed())),
                ("plan: one pass", Box::new(|| one.step_pushed())),
            ],
        );
        let (mut columns, mut ecs) = (Columns::new(n), Ecs::new(n, G, middle_schedule));
        compare(
            n,
            "two middle systems",
            &[None, (n >= 100_000).then_some(1.25)],
            vec![
                (
                    "hand passes over the same columns",
                    Box::new(|| column_passes(black_box(&mut columns))),
                ),
                ("integrate_acceleration, _velocity", Box::new(|| ecs.step())),
            ],
        );
    }
    let n = 1_000;
    let decayed = |ecs: &mut Ecs| (0..240_000).for_each(|_| ecs.step());
    let (mut fresh, mut old) = (Ecs::new(n, 0.0, whole), Ecs::new(n, 0.0, whole));
    decayed(&mut old);
    compare(
        n,
        "2,000 s of damping",
        &[None, Some(1.1)],
        vec![("fresh", Box::new(|| fresh.step())), ("after 2,000 s", Box::new(|| old.step()))],
    );
    let (mut fresh, mut old) = (Soa::new(n), Soa::new(n));
    (0..240_000).for_each(|_| fused_without_snap(&mut old, 0.0));
    compare(
        n,
        "the same, no snap",
        &[None, None],
        vec![
            (
                "hand fused, fresh",
                // It does not grow old in the measurement: that takes five times as many steps.
                Box::new(|| fused_without_snap(black_box(&mut fresh), 0.0)),
            ),
            (
                "hand fused, after 2,000 s",
                Box::new(|| fused_without_snap(black_box(&mut old), 0.0)),
            ),
        ],
    );
}

fn groups(criterion: &mut Criterion<ThreadCpu>) {
    let mut group = criterion.benchmark_group("motion_step");
    for n in SIZES {
        group.throughput(Throughput::Elements(n as u64));
        let mut ecs = Ecs::new(n, G, whole);
        group.bench_function(BenchmarkId::new("schedule", n), |b| b.iter(|| ecs.step()));
        let mut soa = Soa::new(n);
        group.bench_function(BenchmarkId::new("hand_fused", n), |b| {
            b.iter(|| fused(black_box(&mut soa), G));
        });
        let mut soa = Soa::new(n);
        group.bench_function(BenchmarkId::new("hand_four_passes", n), |b| {
            b.iter(|| four_passes(black_box(&mut soa)));
        });
    }
    group.finish();
}

fn main() {
    SIZES.into_iter().filter(|n| *n <= 10_000).for_each(assert_same_bits);
    if !std::env::args().any(|argument| argument == "--ratios") {
        let mut criterion = Criterion::default().with_measurement(ThreadCpu).configure_from_args();
        groups(&mut criterion);
        criterion.final_summary();
    }
    if !std::env::args().any(|argument| argument == "--test") {
        ratios();
    }
}
