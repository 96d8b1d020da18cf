//! What must not matter: the order of the axes, and who else is there.

use glam::DVec3;
use motion::{Curve, Damping, DampingModel, Drag, Gravity, Thrust};

use super::problems::sun;
use super::{Stepper, position, velocity};
use crate::rigs::Bare;
use crate::rigs::pull;

const H: f64 = 1.0 / 60.0;

/// x, y, z become y, z, x.
fn turned(v: DVec3) -> DVec3 {
    DVec3::new(v.y, v.z, v.x)
}

/// The tutorial's ship: an engine along and a thruster across, gravity and drag.
#[test]
fn axes_are_independent_and_alike() {
    for stepper in Stepper::all() {
        for model in DampingModel::ALL {
            let fly = |turn: fn(DVec3) -> DVec3| {
                let curve = Curve::Polynomial(vec![
                    turn(DVec3::new(3.0, 20.0, 0.0)),
                    turn(DVec3::new(0.0, 30.0, 1.0)),
                ]);
                let mut bare = stepper
                    .bare(H)
                    .with_law(pull(turn(Gravity::EARTH.acceleration)))
                    .with_law(Drag::new(0.3, 0.0))
                    .with_law(Thrust::new(curve, 0.0, 0.7))
                    .with_damping(Damping { model, rate: 0.4 });
                bare.add(
                    (turn(DVec3::new(1.0, -7.0, 0.3))).to_array(),
                    (turn(DVec3::new(0.1, 5.0, -2.0))).to_array(),
                    0.3,
                );
                stepper.run(&mut bare, 60);
                (position(&bare, 0), velocity(&bare, 0))
            };
            let (x, v) = fly(|v| v);
            assert_eq!(fly(turned), (turned(x), turned(v)), "{} {model:?}", stepper.name);
        }
    }
}

fn orbiter(i: usize) -> ([f64; 3], [f64; 3], f64) {
    let i = i as f64;
    ([1.0 + 0.3 * i, 0.2 * i, -0.1], [0.1 * i, 1.0 - 0.05 * i, 0.3], 1.0 / (1.0 + i))
}

/// To the bit, also where solves need different numbers of iterations.
#[test]
fn a_body_moves_as_it_does_alone() {
    for stepper in Stepper::all() {
        let scene = || -> Bare {
            let drag = Drag::new(0.1, 0.2);
            let damping = Damping { model: DampingModel::Exact, rate: 0.2 };
            stepper.bare(H).with_law(sun()).with_law(drag).with_damping(damping).with_substeps(2)
        };
        let mut together = scene();
        for i in 0..11 {
            let (x, v, w) = orbiter(i);
            together.add(x, v, if i == 5 { 0.0 } else { w });
        }
        together.push(2, [3.0, 0.0, 1.0]);
        stepper.run(&mut together, 60);
        for i in (0..11).filter(|i| *i != 5) {
            let (x, v, w) = orbiter(i);
            let mut alone = scene();
            alone.add(x, v, w);
            if i == 2 {
                alone.push(0, [3.0, 0.0, 1.0]);
            }
            stepper.run(&mut alone, 60);
            assert_eq!(alone.positions[0], together.positions[i], "{} {i}", stepper.name);
            assert_eq!(alone.bodies[0], together.bodies[i], "{} {i}", stepper.name);
        }
    }
}
