//! The tutorial's aside: is `F * inverse mass` faster than `F / m`? Kicks of bodies in cache and out of it, thread CPU time, the two in
//! turns, as a ratio to the multiplication.

use std::hint::black_box;

use cpu_time::ThreadTime;

/// Bodies that fit into the first-level cache, into the second, and into none.
const BODIES: [usize; 3] = [512, 16_384, 1_000_000];

const ROUNDS: usize = 31;

/// Kicks that one measurement takes, about.
const KICKS: usize = 4_000_000;

struct Bodies {
    velocities: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    masses: Vec<f64>,
    inverse_masses: Vec<f64>,
}

impl Bodies {
    fn new(count: usize) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a million")]
        let masses: Vec<f64> = (0..count).map(|i| 0.1 + (i % 97) as f64).collect();
        let inverse_masses = masses.iter().map(|mass| 1.0 / mass).collect();
        Self {
            velocities: vec![[0.0; 3]; count],
            forces: vec![[0.1, -9.8, 0.3]; count],
            masses,
            inverse_masses,
        }
    }

    #[inline(never)]
    fn divide(&mut self, h: f64) {
        for ((v, f), mass) in self.velocities.iter_mut().zip(&self.forces).zip(&self.masses) {
            for axis in 0..3 {
                v[axis] += f[axis] / mass * h;
            }
        }
    }

    #[inline(never)]
    fn multiply(&mut self, h: f64) {
        for ((v, f), inverse) in
            self.velocities.iter_mut().zip(&self.forces).zip(&self.inverse_masses)
        {
            for axis in 0..3 {
                v[axis] += f[axis] * inverse * h;
            }
        }
    }

    /// One division a body, for all three axes.
    #[inline(never)]
    fn divide_once(&mut self, h: f64) {
        for ((v, f), mass) in self.velocities.iter_mut().zip(&self.forces).zip(&self.masses) {
            let inverse = 1.0 / mass;
            for axis in 0..3 {
                v[axis] += f[axis] * inverse * h;
            }
        }
    }
}

fn seconds(count: usize, bodies: &mut Bodies, kick: fn(&mut Bodies, f64)) -> f64 {
    let passes = (KICKS / count).max(1);
    let start = ThreadTime::now();
    for _ in 0..passes {
        kick(black_box(bodies), black_box(1e-3));
    }
    #[expect(clippy::cast_precision_loss, reason = "a count of kicks")]
    let kicks = (passes * count) as f64;
    start.elapsed().as_secs_f64() / kicks
}

fn main() {
    println!("bodies, ns a kick: F * w, F / m, F * (1 / m); ratios to the first");
    for count in BODIES {
        let mut bodies = Bodies::new(count);
        let kicks: [fn(&mut Bodies, f64); 3] =
            [Bodies::multiply, Bodies::divide, Bodies::divide_once];
        let mut least = [f64::INFINITY; 3];
        for _ in 0..ROUNDS {
            for (least, kick) in least.iter_mut().zip(kicks) {
                *least = least.min(seconds(count, &mut bodies, kick));
            }
        }
        let [multiply, divide, once] = least.map(|seconds| seconds * 1e9);
        println!(
            "{count:>9}: {multiply:.2}, {divide:.2}, {once:.2}; {:.2}, {:.2}",
            divide / multiply,
            once / multiply
        );
    }
}
