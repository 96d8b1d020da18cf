//! Nets of springs without a length at rest, which are linear, run by the real methods.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::margin::Margins;
use motion::{Drag, Elastic, Method, PhysicsBody, Spring, StableId, Stepper, TimeStep, Transform};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use super::limit::{Criterion, Limit, bisect, largest_stable};

/// A net of springs between masses and a post.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// Name of the net.
    pub name: String,
    /// Masses, kg. The post is the body before the first.
    pub masses: Vec<f64>,
    /// Ends, 0 being the post, and stiffness, N/m.
    pub springs: Vec<([usize; 2], f64)>,
    /// Rate of linear drag on all, 1/s.
    pub drag: f64,
}

/// A net in its own world.
pub struct Stepped {
    /// The world.
    pub world: World,
    /// Its stepper.
    pub stepper: Stepper,
    bodies: Vec<Entity>,
}

/// A run that exceeds this multiple of its start has failed.
const MOST: f64 = 1e3;

/// Ticks of a run: a step 0.1 % above the limit without damping has failed by then.
const TICKS: u32 = 400;
/// Ticks of a run of a method that is not symplectic, whose growth begins slowly.
const TICKS_OF_SLOW_GROWTH: u32 = 2_000;
/// Ticks of a run of a method without a limit.
const TICKS_OF_NO_LIMIT: u32 = 100;

/// Relative change of energy that may be rounding; Runge-Kutta 2 at w h = 0.01 adds 2.5e-9 of the energy of the
/// fastest mode.
const ROUNDING: f64 = 1e-12;

/// Ten to a random power in a range.
fn decade(random: &mut Pcg64, [low, high]: [f64; 2]) -> f64 {
    10.0_f64.powf(random.random_range(low..high))
}

impl Net {
    /// Ten bodies in a row from a post, joined by springs of 100 N/m; all but the last have 1 kg.
    pub fn chain(last: f64) -> Self {
        let mut masses = vec![1.0; 10];
        masses[9] = last;
        let springs = (0..10).map(|i| ([i, i + 1], 100.0)).collect();
        Self { name: format!("chain of 10, last mass {last:e} kg"), masses, springs, drag: 0.0 }
    }

    /// 3 to 12 bodies of 1e-3 to 1e3 kg, joined at random by springs of 10 to 1e4 N/m, and all connected to the post.
    pub fn random(number: u64) -> Self {
        let random = &mut Pcg64::seed_from_u64(number);
        let n = random.random_range(3..13);
        let masses = (0..n).map(|_| decade(random, [-3.0, 3.0])).collect();
        let mut springs: Vec<_> = (1..=n)
            .map(|body| ([random.random_range(0..body), body], decade(random, [1.0, 4.0])))
            .collect();
        for _ in 0..n {
            let [a, b] = [(); 2].map(|()| random.random_range(0..=n));
            if a != b {
                springs.push(([a, b], decade(random, [1.0, 4.0])));
            }
        }
        Self { name: format!("random net {number}"), masses, springs, drag: 0.0 }
    }

    /// Largest frequency w, 1/s: of `W^½ K W^½`, whose high powers grow by w² (Gelfand 1941).
    pub fn largest_frequency(&self) -> f64 {
        let n = self.masses.len();
        let mut a = vec![vec![0.0; n]; n];
        for ([from, to], k) in &self.springs {
            for (one, other, sign) in
                [(from, from, 1.0), (to, to, 1.0), (from, to, -1.0), (to, from, -1.0)]
            {
                if *one > 0 && *other > 0 {
                    let mass = (self.masses[one - 1] * self.masses[other - 1]).sqrt();
                    a[one - 1][other - 1] += sign * k / mass;
                }
            }
        }
        let largest =
            |a: &[Vec<f64>]| a.iter().flatten().map(|entry| entry.abs()).fold(0.0, f64::max);
        let (mut logarithm, mut weight) = (0.0, 1.0);
        for _ in 0..40 {
            let size = largest(&a);
            logarithm += weight * size.ln();
            weight /= 2.0;
            a = (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| (0..n).map(|k| a[i][k] / size * (a[k][j] / size)).sum())
                        .collect()
                })
                .collect();
        }
        (0.5 * (logarithm + weight * largest(&a).ln())).exp()
    }

    /// The net in its own world, displaced at random.
    pub fn stepped(&self, method: Method, h: f64) -> Stepped {
        let mut world = World::new();
        if self.drag > 0.0 {
            world.insert_resource(Drag::new(self.drag, 0.0));
        }
        let mut random = Pcg64::seed_from_u64(1);
        let mut bodies = Vec::new();
        for (id, inverse_mass) in
            (0..).zip(std::iter::once(0.0).chain(self.masses.iter().map(|mass| 1.0 / mass)))
        {
            let mut part = || random.random_range(-1.0..1.0);
            let position =
                if inverse_mass > 0.0 { DVec3::new(part(), part(), part()) } else { DVec3::ZERO };
            let body = PhysicsBody { velocity: DVec3::ZERO, inverse_mass };
            bodies.push(world.spawn((StableId(id), Transform::at(position), body)).id());
        }
        for (ends, stiffness) in &self.springs {
            let elastic = Elastic::new(*stiffness, 0.0);
            world.spawn(Spring { ends: ends.map(|end| bodies[end]), elastic });
        }
        let stepper = Stepper::new(&mut world, method, TimeStep(h));
        Stepped { world, stepper, bodies }
    }

    /// Its largest stable step by `method`; without drag.
    pub fn limit(&self, method: Method) -> Limit {
        let (w, theory) = (self.largest_frequency(), method.claims().stability_limit);
        let stepped = |z: f64| self.stepped(method, z / w);
        let (criterion, measured) = if theory == 0.0 {
            (Criterion::Energy, largest_stable(0.01, 1.02, |z| !self.gains(&mut stepped(z))))
        } else if theory.is_infinite() {
            (
                Criterion::Amplitude,
                largest_stable(0.1, 1.3, |z| stepped(z).stays(TICKS_OF_NO_LIMIT)),
            )
        } else {
            let ticks = if method.claims().symplectic { TICKS } else { TICKS_OF_SLOW_GROWTH };
            (Criterion::Amplitude, between(theory, |z| stepped(z).stays(ticks)))
        };
        Limit { system: self.name.clone(), method: method.name(), criterion, measured, theory }
    }

    /// Whether a tick adds to the energy.
    fn gains(&self, stepped: &mut Stepped) -> bool {
        let before = self.energy(stepped);
        stepped.stepper.tick(&mut stepped.world);
        self.energy(stepped) > before * (1.0 + ROUNDING)
    }

    /// Energy, J.
    fn energy(&self, stepped: &Stepped) -> f64 {
        let at = |body: usize| {
            stepped
                .world
                .get::<Transform>(stepped.bodies[body])
                .map_or(DVec3::ZERO, |at| at.position)
        };
        let v = |body: usize| {
            stepped
                .world
                .get::<PhysicsBody>(stepped.bodies[body])
                .map_or(DVec3::ZERO, |body| body.velocity)
        };
        let springs = self.springs.iter().map(|([a, b], k)| k * at(*a).distance_squared(at(*b)));
        let masses =
            self.masses.iter().enumerate().map(|(i, mass)| mass * v(i + 1).length_squared());
        0.5 * springs.chain(masses).sum::<f64>()
    }
}

/// The largest stable value near `theory`, by bisection of an interval that is widened until its lower end is stable
/// and its upper end is not.
fn between(theory: f64, mut stays: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high, mut by) = (0.98 * theory, 1.02 * theory, 1.1);
    while !stays(low) {
        (low, high, by) = (low / by, low, by * by);
    }
    while stays(high) {
        (low, high, by) = (high, high * by, by * by);
    }
    bisect([low, high], 1e-3, stays)
}

impl Stepped {
    /// Whether no body goes farther than a thousand times the size of the start in `ticks` ticks.
    pub fn stays(&mut self, ticks: u32) -> bool {
        let start = self.size();
        (0..ticks).all(|_| {
            self.stepper.tick(&mut self.world);
            self.size() <= MOST * start
        })
    }

    fn size(&self) -> f64 {
        let far = |body: &Entity| {
            self.world.get::<Transform>(*body).map_or(0.0, |at| at.position.length())
        };
        self.bodies.iter().map(far).fold(0.0, f64::max)
    }

    /// The margins of the net.
    pub fn margins(&mut self) -> Margins {
        Margins::of(&self.world, self.stepper.method())
    }
}
