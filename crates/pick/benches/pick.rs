//! What a pick costs: the scan while all bodies move, the tree while they rest beside parry's own, and the
//! crossovers that the constants in `bvh.rs` are read from.

use std::hint::black_box;
use std::time::Instant;

use bevy_ecs::entity::Entity;
use criterion::{BenchmarkId, Criterion, Throughput};
use glam::{DQuat, DVec3};
use motion::{Orientation, PreviousPosition, Transform};
use parry3d::math::Pose;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::RayCast;
use parry3d::shape::{Ball, Cuboid};
use pick::{Chunk, Ray, Shape, Targets};

const SIZES: [(&str, usize); 3] = [("1k", 1_000), ("10k", 10_000), ("100k", 100_000)];
const RAYS: usize = 512;

/// Half balls, half turned cubes, filling some 2.5 % of a cube around the origin; rays from an eye outside.
struct Bench {
    entities: Vec<Entity>,
    transforms: Vec<Transform>,
    previous: Vec<PreviousPosition>,
    shapes: Vec<Shape>,
    orientations: Vec<Orientation>,
    eye: DVec3,
    rays: Vec<Ray>,
    dice: u64,
}

impl Bench {
    fn new(count: usize) -> Self {
        let mut bench = Self {
            entities: (0..count as u32).filter_map(Entity::from_raw_u32).collect(),
            transforms: Vec::new(),
            previous: Vec::new(),
            shapes: Vec::new(),
            orientations: Vec::new(),
            eye: DVec3::ZERO,
            rays: Vec::new(),
            dice: 0x5EED,
        };
        let half = 1.71 * (count as f64).cbrt();
        for i in 0..count {
            let size = 0.3 + 0.5 * bench.unit();
            let shape =
                if i % 2 == 0 { Shape::sphere(size) } else { Shape::cuboid(DVec3::splat(size)) };
            bench.shapes.push(shape.expect("sizes are between 0.3 and 0.8 m"));
            let (axis, angle) = (bench.vector(), bench.unit());
            let turned = if i % 2 == 0 {
                DQuat::IDENTITY
            } else {
                DQuat::from_scaled_axis(axis * angle * 3.0)
            };
            bench.orientations.push(Orientation(turned));
            let position = bench.vector() * half;
            bench.transforms.push(Transform::at(position));
            let step = bench.vector() * 0.01;
            bench.previous.push(PreviousPosition(position - step));
        }
        bench.eye = DVec3::new(0.3, 0.9, 2.5) * half;
        for _ in 0..RAYS {
            let at = bench.vector() * half;
            bench.rays.push(Ray::new(bench.eye, at - bench.eye).expect("the eye is outside"));
        }
        bench
    }

    fn unit(&mut self) -> f64 {
        self.dice ^= self.dice << 13;
        self.dice ^= self.dice >> 7;
        self.dice ^= self.dice << 17;
        (self.dice >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn chunk(&self, interpolated: Interpolated) -> impl Iterator<Item = Chunk<'_>> {
        std::iter::once(Chunk {
            entities: &self.entities,
            transforms: &self.transforms,
            previous: matches!(interpolated, Interpolated::Yes).then_some(&self.previous[..]),
            shapes: &self.shapes,
            orientations: Some(&self.orientations),
        })
    }

    fn targets(&self) -> Targets {
        let mut targets = Targets::default();
        targets.update(self.eye, 1.0, self.chunk(Interpolated::No));
        targets
    }

    fn parry(&self) -> Parry {
        let rows = self.shapes.iter().zip(&self.transforms).zip(&self.orientations);
        let leaves: Vec<_> = rows
            .map(|((shape, transform), turned)| {
                let pose =
                    Pose::from_parts((transform.position - self.eye).as_vec3(), turned.0.as_quat());
                match *shape {
                    Shape::Sphere { radius } => (pose, Leaf::Ball(Ball::new(radius as f32))),
                    Shape::Cuboid { half_extents } => {
                        (pose, Leaf::Cuboid(Cuboid::new(half_extents.as_vec3())))
                    }
                }
            })
            .collect();
        let boxes: Vec<_> = leaves
            .iter()
            .map(|(pose, leaf)| match leaf {
                Leaf::Ball(ball) => ball.aabb(pose),
                Leaf::Cuboid(cuboid) => cuboid.aabb(pose),
            })
            .collect();
        Parry { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), leaves }
    }
}

#[derive(Clone, Copy)]
enum Interpolated {
    Yes,
    No,
}

enum Leaf {
    Ball(Ball),
    Cuboid(Cuboid),
}

/// What somebody writes who uses parry's tree and nothing else.
struct Parry {
    bvh: Bvh,
    leaves: Vec<(Pose, Leaf)>,
}

impl Parry {
    fn cast(&self, ray: &Ray) -> Option<(u32, f32)> {
        let ray = parry3d::query::Ray::new(glam::Vec3::ZERO, ray.direction().as_vec3());
        self.bvh.cast_ray(&ray, f32::MAX, |row, best| {
            let (pose, leaf) = &self.leaves[row as usize];
            match leaf {
                Leaf::Ball(ball) => ball.cast_ray(pose, &ray, best, true),
                Leaf::Cuboid(cuboid) => cuboid.cast_ray(pose, &ray, best, true),
            }
        })
    }
}

/// Next of the rays, round and round.
fn next<'a>(rays: &'a [Ray], at: &mut usize) -> &'a Ray {
    *at = (*at + 1) % rays.len();
    black_box(&rays[*at])
}

fn moving(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("moving");
    for (name, count) in SIZES {
        group.throughput(Throughput::Elements(count as u64));
        for (how, interpolated) in
            [("current", Interpolated::No), ("interpolated", Interpolated::Yes)]
        {
            let mut bench = Bench::new(count);
            let mut targets = bench.targets();
            let (mut alpha, mut at) = (0.0, 0);
            let mut elsewhere = bench.previous.iter().map(|p| Transform::at(p.0)).collect();
            group.bench_function(BenchmarkId::new(how, name), |b| {
                b.iter(|| {
                    alpha = (alpha + 0.37) % 1.0;
                    // Interpolated ones move by alpha, and these because they are swapped.
                    if matches!(interpolated, Interpolated::No) {
                        std::mem::swap(&mut bench.transforms, &mut elsewhere);
                    }
                    targets.update(
                        bench.eye + DVec3::X * alpha,
                        alpha,
                        black_box(bench.chunk(interpolated)),
                    );
                    targets.cast_by_scan(next(&bench.rays, &mut at))
                });
            });
        }
    }
}

fn resting(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("static");
    for (name, count) in SIZES {
        let bench = Bench::new(count);
        let (targets, parry) = (bench.targets(), bench.parry());
        let _ = targets.cast_by_tree(&bench.rays[0]);
        let mut at = 0;
        group.bench_function(BenchmarkId::new("targets", name), |b| {
            b.iter(|| targets.cast(next(&bench.rays, &mut at)));
        });
        group.bench_function(BenchmarkId::new("parry", name), |b| {
            b.iter(|| parry.cast(next(&bench.rays, &mut at)));
        });
    }
}

/// Seconds that `run` takes, the median of `runs`.
fn seconds(runs: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[runs / 2]
}

fn all_rays(bench: &Bench, mut cast: impl FnMut(&Ray) -> bool) -> f64 {
    let mut hits = 0_u32;
    let time = seconds(1, || {
        hits += bench.rays.iter().map(|r| u32::from(cast(black_box(r)))).sum::<u32>();
    });
    black_box(hits);
    time / bench.rays.len() as f64
}

/// Interleaved, so that both see the same machine.
fn ratios() {
    println!("\nstatic: a ray, ns            targets    parry    ratio");
    for (name, count) in SIZES {
        let bench = Bench::new(count);
        let (targets, parry) = (bench.targets(), bench.parry());
        let _ = targets.cast_by_tree(&bench.rays[0]);
        let (mut ours, mut theirs, mut ratio) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..61 {
            let a = all_rays(&bench, |ray| targets.cast(ray).is_some());
            let b = all_rays(&bench, |ray| parry.cast(ray).is_some());
            ours.push(a);
            theirs.push(b);
            ratio.push(a / b);
        }
        for column in [&mut ours, &mut theirs, &mut ratio] {
            column.sort_by(f64::total_cmp);
        }
        println!("{name:>26} {:>9.0} {:>8.0} {:>8.2}", ours[30] * 1e9, theirs[30] * 1e9, ratio[30]);
    }
}

fn crossover() {
    println!(
        "\ncosts, ns per target   update  +interp   scan  build  reinsert  refit  followed   tree, ns per ray"
    );
    for (name, count) in SIZES {
        let mut bench = Bench::new(count);
        let per = 1e9 / count as f64;
        let mut targets = bench.targets();
        let mut alpha = 0.0;
        let mut update = |how: Interpolated| {
            per * seconds(101, || {
                alpha = (alpha + 0.37) % 1.0;
                targets.update(bench.eye + DVec3::X * alpha, alpha, black_box(bench.chunk(how)));
            })
        };
        let (plain, interpolated) = (update(Interpolated::No), update(Interpolated::Yes));
        let scan = per * all_rays(&bench, |ray| targets.cast_by_scan(ray).is_some());
        let build =
            per * seconds(5, || {
                let targets = bench.targets();
                let _ = black_box(targets.cast_by_tree(&bench.rays[0]));
            }) - plain;
        let _ = targets.cast_by_tree(&bench.rays[0]);
        let tree = 1e9 * all_rays(&bench, |ray| targets.cast(ray).is_some());
        // A tree is only kept while enough rays ask; a frame of at most 1 % movers with 512 rays keeps it.
        let movers = count / 100;
        let mut follow = |movers: usize| {
            let mut times = Vec::new();
            for _ in 0..21 {
                for row in 0..movers {
                    let shift = bench.vector() * 0.1;
                    let rows = bench.transforms.len();
                    bench.transforms[row * (rows / movers)].position += shift;
                }
                let _ = targets.cast_by_tree(&bench.rays[0]);
                for ray in &bench.rays {
                    let _ = black_box(targets.cast(ray));
                }
                times.push(seconds(1, || {
                    targets.update(bench.eye, 1.0, bench.chunk(Interpolated::No));
                }));
            }
            times.sort_by(f64::total_cmp);
            times[10]
        };
        let rest = follow(1);
        let reinsert = (follow(movers) - rest) * 1e9 / movers as f64;
        let refit = (follow(count) - rest) * per;
        println!(
            "{name:>20} {plain:>8.2} {interpolated:>8.2} {scan:>6.2} {build:>6.0} {reinsert:>9.0} {refit:>6.0} {:>9.2} {tree:>18.0}",
            rest * per
        );
        let (n, saved) = (count as f64, scan * count as f64 - tree);
        if saved > 0.0 {
            println!(
                "{:>20} a build pays after {:.0} rays at rest, a refit from {:.0} rays a frame; with one ray a \
                 frame a tree may follow {:.0} moved",
                "",
                build * n / saved,
                refit * n / saved,
                saved / reinsert,
            );
        } else {
            println!("{:>20} a scan is as fast as a tree", "");
        }
    }
}

fn fewest() {
    println!("\na ray, ns                scan     tree");
    for count in [250, 500, 1_000, 1_500, 2_000, 3_000, 4_000] {
        let bench = Bench::new(count);
        let targets = bench.targets();
        let _ = targets.cast_by_tree(&bench.rays[0]);
        let (mut scan, mut tree) = (Vec::new(), Vec::new());
        for _ in 0..21 {
            scan.push(all_rays(&bench, |ray| targets.cast_by_scan(ray).is_some()));
            tree.push(all_rays(&bench, |ray| targets.cast_by_tree(ray).is_some()));
        }
        scan.sort_by(f64::total_cmp);
        tree.sort_by(f64::total_cmp);
        println!("{count:>20} {:>8.0} {:>8.0}", scan[10] * 1e9, tree[10] * 1e9);
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    moving(&mut criterion);
    resting(&mut criterion);
    criterion.final_summary();
    // `cargo test --benches` passes --test and wants no measurement.
    if !std::env::args().any(|argument| argument == "--test") {
        ratios();
        crossover();
        fewest();
    }
}
