//! What is proven of [`Bare`] holds for worlds: the same bits, and what only a world has.

mod added;
mod agreement;
mod counts;
mod engines;
mod kept;
mod limits;
mod mixed;
mod outside;
mod quarantined;
mod requests;
mod switches;
mod threads;

use crate::rigs::Bare;
use glam::DVec3;
use motion::{Curve, Method, OwnLaws, Thrust};

use crate::rigs::{Bits, Dice, Environment, Lab, Start, bits, wells};

const H: f64 = 1.0 / 60.0;

/// The one of [`starts`] that is immovable.
const IMMOVABLE: usize = 5;

/// Eleven bodies, so that blocks of four leave a rest.
fn starts() -> Vec<Start> {
    let mut dice = Dice(7);
    let start = |i: usize| {
        let (x, v) = (dice.vector() * 3.0 + DVec3::X * 2.0, dice.vector() * 2.0);
        if i == IMMOVABLE {
            Start { x, v: DVec3::ZERO, w: 0.0 }
        } else {
            Start { x, v, w: 1.0 / (1.0 + i as f64) }
        }
    };
    (0..11).map(start).collect()
}

/// An engine that comes on inside the third tick and goes off inside the fourth second.
fn engine() -> Thrust {
    let curve = Curve::Polynomial(vec![DVec3::new(4.0, -2.0, 1.0), DVec3::new(-1.0, 3.0, 0.5)]);
    Thrust::new(curve, 2.3 * H, 3.0 + 0.4 * H)
}

fn engines() -> OwnLaws {
    OwnLaws::new(vec![Box::new(engine())])
}

/// A world with the bodies of [`starts`].
fn crowd(scene: &Environment, method: Method) -> Lab {
    let mut lab = scene.lab(method, H);
    for start in starts() {
        lab.spawn(start);
    }
    lab
}

/// The same, the fourth body with engines.
fn crowd_with_engines(scene: &Environment, method: Method) -> Lab {
    let mut lab = crowd(scene, method);
    lab.insert(3, engines());
    lab
}

fn add(bare: &mut Bare, start: Start) -> usize {
    bare.add(start.x.to_array(), start.v.to_array(), start.w)
}

fn bare_bits(bare: &Bare, body: usize) -> Bits {
    bits(super::position(bare, body), super::velocity(bare, body))
}

/// The pushes of each tick of a run: body, N.
fn pushes(seed: u64, ticks: usize, bodies: usize) -> Vec<Vec<(usize, DVec3)>> {
    let mut dice = Dice(seed);
    let mut pushes = vec![Vec::new(); ticks];
    for _ in 0..ticks / 3 {
        pushes[dice.below(ticks)].push((dice.below(bodies), dice.vector() * 30.0));
    }
    pushes
}
