//! Nets of springs without a length at rest, which are linear, run by the real methods.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Drag, Elastic, Forecast, Method, PhysicsBody, Spring, StableId, Stepper, TimeStep, Transform};

use super::{Criterion, Limit};

/// A net of springs between masses and a post.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// What it is.
    pub name: String,
    /// Masses, kg. The post is the body before the first.
    pub masses: Vec<f64>,
    /// Ends, 0 being the post, and stiffness, N/m.
    pub springs: Vec<([usize; 2], f64)>,
    /// Rate of linear drag on all, 1/s.
    pub drag: f64,
}

/// A net in a world of its own.
pub struct Stepped {
    /// The world.
    pub world: World,
    /// Its stepper.
    pub stepper: Stepper,
    bodies: Vec<Entity>,
}

/// A run that exceeds this times its start has failed.
const MOST: f64 = 1e3;

/// Ticks of a run: what is 0.1 % beyond the limit without damping has failed by then.
const TICKS: u32 = 400;
/// The same of Runge-Kutta 4, whose growth begins slowly; the others' like a root.
const TICKS_OF_RK4: u32 = 2_000;

/// Numbers in [0, 1) that look random and are the same on every machine (`SplitMix64`).
struct Dice(u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn number(&mut self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "53 bits")]
        let bits = (self.bits() >> 11) as f64;
        bits / 9_007_199_254_740_992.0
    }

    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.bits() % end as u64).unwrap_or(0)
    }

    /// Ten to a random power in a range.
    fn decade(&mut self, [low, high]: [f64; 2]) -> f64 {
        10.0_f64.powf(low + (high - low) * self.number())
    }
}

impl Net {
    /// Ten bodies in a row from a post, of 1 kg but the last, on springs of 100 N/m.
    #[must_use]
    pub fn chain(last: f64) -> Self {
        let mut masses = vec![1.0; 10];
        masses[9] = last;
        let springs = (0..10).map(|i| ([i, i + 1], 100.0)).collect();
        Self { name: format!("chain of 10, last mass {last:e} kg"), masses, springs, drag: 0.0 }
    }

    /// 3 to 12 bodies of 1e-3 to 1e3 kg, joined at random on springs of 10 to 1e4 N/m, all of them to the post in the end.
    #[must_use]
    pub fn random(number: u64) -> Self {
        let mut dice = Dice(number);
        let n = 3 + dice.below(10);
        let masses = (0..n).map(|_| dice.decade([-3.0, 3.0])).collect();
        let mut springs: Vec<_> =
            (1..=n).map(|body| ([dice.below(body), body], dice.decade([1.0, 4.0]))).collect();
        for _ in 0..n {
            let (a, b) = (dice.below(n + 1), dice.below(n + 1));
            if a != b {
                springs.push(([a, b], dice.decade([1.0, 4.0])));
            }
        }
        Self { name: format!("random net {number}"), masses, springs, drag: 0.0 }
    }

    /// The same with linear drag of that rate, 1/s.
    #[must_use]
    pub fn with_drag(mut self, rate: f64) -> Self {
        self.name += &format!(", drag of {rate:.3}/s");
        self.drag = rate;
        self
    }

    /// Largest frequency w, 1/s: of `W^½ K W^½`, whose high powers grow by w² (Gelfand 1941).
    #[must_use]
    pub fn largest_frequency(&self) -> f64 {
        let n = self.masses.len();
        let mut a = vec![vec![0.0; n]; n];
        for ([from, to], k) in &self.springs {
            for (one, other, sign) in [(from, from, 1.0), (to, to, 1.0), (from, to, -1.0), (to, from, -1.0)] {
                if *one > 0 && *other > 0 {
                    let mass = (self.masses[one - 1] * self.masses[other - 1]).sqrt();
                    a[one - 1][other - 1] += sign * k / mass;
                }
            }
        }
        let largest = |a: &[Vec<f64>]| a.iter().flatten().map(|entry| entry.abs()).fold(0.0, f64::max);
        let (mut logarithm, mut weight) = (0.0, 1.0);
        for _ in 0..40 {
            let size = largest(&a);
            logarithm += weight * size.ln();
            weight /= 2.0;
            a = (0..n)
                .map(|i| (0..n).map(|j| (0..n).map(|k| a[i][k] / size * (a[k][j] / size)).sum()).collect())
                .collect();
        }
        (0.5 * (logarithm + weight * largest(&a).ln())).exp()
    }

    /// In a world of its own, moved at random.
    #[must_use]
    pub fn stepped(&self, method: Method, h: f64) -> Stepped {
        let mut world = World::new();
        if self.drag > 0.0 {
            world.insert_resource(Drag::new(self.drag, 0.0));
        }
        let mut dice = Dice(1);
        let mut bodies = Vec::new();
        for (id, inverse_mass) in
            (0..).zip(std::iter::once(0.0).chain(self.masses.iter().map(|mass| 1.0 / mass)))
        {
            let mut part = || 2.0 * dice.number() - 1.0;
            let position = if inverse_mass > 0.0 { DVec3::new(part(), part(), part()) } else { DVec3::ZERO };
            let body = PhysicsBody { velocity: DVec3::ZERO, inverse_mass };
            bodies.push(world.spawn((StableId(id), Transform::at(position), body)).id());
        }
        for (ends, stiffness) in &self.springs {
            let elastic = Elastic { stiffness: *stiffness, damping: 0.0, rest_length: 0.0 };
            world.spawn(Spring { ends: ends.map(|end| bodies[end]), elastic });
        }
        let stepper = Stepper::new(&mut world, method, TimeStep(h));
        Stepped { world, stepper, bodies }
    }

    /// Its largest stable step by `method`, which has one.
    #[must_use]
    pub fn limit(&self, method: Method) -> Limit {
        let (w, theory) = (self.largest_frequency(), method.claims().stability_limit);
        let ticks = if method == Method::RungeKutta4 { TICKS_OF_RK4 } else { TICKS };
        let stays = |z: f64| self.stepped(method, z / w).stays(ticks);
        // Wider and wider until both ends are what they should be: the closed form says only where to begin.
        let (mut low, mut high, mut by) = (0.98 * theory, 1.02 * theory, 1.1);
        while !stays(low) {
            (low, high, by) = (low / by, low, by * by);
        }
        while stays(high) {
            (low, high, by) = (high, high * by, by * by);
        }
        while high - low > 1e-3 * high {
            let middle = f64::midpoint(low, high);
            if stays(middle) { low = middle } else { high = middle }
        }
        Limit {
            system: self.name.clone(),
            method: method.name(),
            criterion: Criterion::Amplitude,
            measured: f64::midpoint(low, high),
            theory,
        }
    }
}

impl Stepped {
    /// Whether no body goes farther than a thousand times the size of the start in so many ticks.
    #[must_use]
    pub fn stays(&mut self, ticks: u32) -> bool {
        let start = self.size();
        (0..ticks).all(|_| {
            self.stepper.tick(&mut self.world);
            self.size() <= MOST * start
        })
    }

    fn size(&self) -> f64 {
        let far = |body: &Entity| self.world.get::<Transform>(*body).map_or(0.0, |at| at.position.length());
        self.bodies.iter().map(far).fold(0.0, f64::max)
    }

    /// What its forecast says.
    #[must_use]
    pub fn forecast(&mut self) -> Forecast {
        Forecast::of(&mut self.world, self.stepper.method())
    }
}
