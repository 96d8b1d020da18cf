//! Cloth of damped springs beside hand-written array loops of the same arithmetic, in f64: structural and shear
//! springs, four a point, the corners of one edge pinned, gravity.
//!
//! Ratios are medians inside interleaved rounds of thread CPU time. `-- --steps METHOD POINTS STEPS` does nothing
//! but steps of a square cloth, for an instruction counter; METHOD `loop` is the hand-written one.

#[path = "common/mod.rs"]
mod common;

use std::hint::black_box;

use bevy_ecs::prelude::*;
use common::{Contestant, compare};
use motion::units::Vector;
use motion::{
    Elastic, Gravity, Link, Method, PhysicsBody, SoftBody, StableId, Stepper, TimeStep, Transform,
};

const H: f64 = 1.0 / 240.0;
const G: f64 = -9.8;
const CELL: f64 = 0.05;
const W: f64 = 100.0;
const SIZES: [usize; 3] = [10, 100, 300];

/// The springs of a cloth of `n` by `n` points, row by row, those of one point together.
fn links(n: usize) -> Vec<Link> {
    let mut links = Vec::new();
    let mut join = |a: usize, b: usize, length: f64| {
        let elastic = Elastic::new(40.0, length).damped(0.01);
        let ends = [a, b].map(|end| u32::try_from(end).expect("small"));
        links.push(Link { ends, elastic });
    };
    let diagonal = CELL * 2.0_f64.sqrt();
    for row in 0..n {
        for column in 0..n {
            let at = row * n + column;
            let (right, down) = (column + 1 < n, row + 1 < n);
            if right {
                join(at, at + 1, CELL);
            }
            if down {
                join(at, at + n, CELL);
            }
            if right && down {
                join(at, at + n + 1, diagonal);
                join(at + 1, at + n, diagonal);
            }
        }
    }
    links
}

/// Position and inverse mass of every point.
fn points(n: usize) -> impl Iterator<Item = ([f64; 3], f64)> {
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    (0..n * n).map(move |i| {
        let (row, column) = (i / n, i % n);
        let pinned = row == 0 && (column == 0 || column == n - 1);
        ([column as f64 * CELL, 0.0, row as f64 * CELL], if pinned { 0.0 } else { W })
    })
}

/// The plain loop: what one would write who has nothing but this cloth. Rows of three numbers, or of four, which
/// are faster to load.
struct Loop<const LANES: usize> {
    x: Vec<[f64; LANES]>,
    v: Vec<[f64; LANES]>,
    f: Vec<[f64; LANES]>,
    w: Vec<f64>,
    springs: Vec<(u32, u32, f64, f64, f64)>,
}

impl<const LANES: usize> Loop<LANES> {
    fn new(n: usize) -> Self {
        let row = |[a, b, c]: [f64; 3]| std::array::from_fn(|lane| [a, b, c, 0.0][lane]);
        let (x, w): (Vec<_>, Vec<_>) = points(n).map(|(at, w)| (row(at), w)).unzip();
        let springs = links(n)
            .iter()
            .map(|Link { ends: [a, b], elastic }| {
                (*a, *b, elastic.stiffness, elastic.damping, elastic.rest_length)
            })
            .collect();
        Self { v: vec![[0.0; LANES]; x.len()], f: vec![[0.0; LANES]; x.len()], x, w, springs }
    }

    fn step(&mut self) {
        let Self { x, v, f, w, springs } = self;
        for (a, b, stiffness, damping, rest) in &*springs {
            let (a, b) = (*a as usize, *b as usize);
            let (xa, xb, va, vb) = (&x[a], &x[b], &v[a], &v[b]);
            let (dx, dy, dz) = (xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]);
            let inverse = 1.0 / (dx * dx + dy * dy + dz * dz).sqrt();
            let rate = dx * (vb[0] - va[0]) + dy * (vb[1] - va[1]) + dz * (vb[2] - va[2]);
            let tension = stiffness * (1.0 - rest * inverse) + damping * rate * inverse * inverse;
            let (fx, fy, fz) = (dx * tension, dy * tension, dz * tension);
            let fa = &mut f[a];
            fa[0] += fx;
            fa[1] += fy;
            fa[2] += fz;
            let fb = &mut f[b];
            fb[0] -= fx;
            fb[1] -= fy;
            fb[2] -= fz;
        }
        for (((x, v), f), w) in x.iter_mut().zip(v).zip(f).zip(w) {
            if *w > 0.0 {
                for (i, g) in [0.0, G, 0.0].into_iter().enumerate() {
                    v[i] += (f[i] * *w + g) * H;
                    x[i] += v[i] * H;
                }
            }
            *f = [0.0; LANES];
        }
    }
}

fn cloth(n: usize, method: Method) -> (World, Stepper) {
    let mut world = World::new();
    world.insert_resource(Gravity::new(Vector::Y * G));
    let points: Vec<_> = (0..)
        .zip(points(n))
        .map(|(id, (at, inverse_mass))| {
            let body = PhysicsBody { velocity: Vector::ZERO, inverse_mass };
            world.spawn((StableId(id), Transform::at(Vector::from_array(at)), body)).id()
        })
        .collect();
    world.spawn(SoftBody::new(points, links(n)));
    let stepper = Stepper::new(&mut world, method, TimeStep(H));
    (world, stepper)
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [flag, method, n, steps] = &arguments[..]
        && flag == "--steps"
    {
        let (n, steps): (usize, usize) =
            (n.parse().expect("points"), steps.parse().expect("steps"));
        if method == "loop" {
            let mut rival = Loop::<4>::new(n);
            (0..steps).for_each(|_| rival.step());
            black_box((rival.x, rival.v));
        } else {
            let method = Method::ALL
                .into_iter()
                .find(|known| known.claims().name == method)
                .expect("a method");
            let (mut world, mut stepper) = cloth(n, method);
            (0..steps).for_each(|_| stepper.tick(&mut world));
            black_box(world);
        }
        return;
    }
    for n in SIZES {
        let (mut three, mut four) = (Loop::<3>::new(n), Loop::<4>::new(n));
        let mut contestants: Vec<Contestant> = vec![
            ("loop of rows of four", Box::new(move || four.step())),
            ("loop of rows of three", Box::new(move || three.step())),
        ];
        let methods = [
            Method::SemiImplicitEuler,
            Method::VelocityVerlet,
            Method::RungeKutta4,
            Method::ImplicitEuler,
        ];
        let mut bounds = vec![None; 2];
        for method in methods {
            let (mut world, mut stepper) = cloth(n, method);
            contestants.push((method.claims().name, Box::new(move || stepper.tick(&mut world))));
            bounds.push((method == Method::SemiImplicitEuler && n > 10).then_some(1.15));
        }
        compare(links(n).len(), "springs", &bounds, contestants);
        let against = |method| -> Contestant<'static> {
            let (mut world, mut stepper) = cloth(n, method);
            (method.claims().name, Box::new(move || stepper.tick(&mut world)))
        };
        let pair = [Method::SemiImplicitEuler, Method::RungeKutta4].map(against);
        compare(links(n).len(), "evaluations", &[None, (n > 10).then_some(5.0)], pair.into());
    }
}
