//! What is done to bodies between ticks does in arrays what a request does in a world.

use glam::DVec3;
use history::Simulation;
use motion::arrays::Bare;
use motion::{Damping, DampingModel, Gravity, Method, Request};

use super::{arrays, arrays_by, run, states, twin};
use crate::rigs::all_bits;

const IMPULSE: DVec3 = DVec3::new(0.5, -2.0, 0.25);
const VELOCITY: DVec3 = DVec3::new(-1.0, 3.0, 0.5);
const GRAVITY: DVec3 = DVec3::new(0.5, -3.0, 0.0);
const DAMPING: Damping = Damping { model: DampingModel::Clamped, rate: 0.7 };

/// The experiment after that tick, in both.
fn experiment(tick: u32, twin: &mut Simulation, bare: &mut Bare) {
    let row = bare.bodies.iter().rposition(|body| body[3] > 0.0).unwrap();
    let body = twin.bodies[bare.states().nth(row).unwrap().0.0 as usize];
    let request = match tick {
        3 => {
            bare.give_impulse(row, IMPULSE.to_array());
            Request::Impulse(body, IMPULSE)
        }
        6 => {
            bare.set_velocity(row, VELOCITY.to_array());
            Request::SetVelocity(body, VELOCITY)
        }
        9 => {
            let on = bare.gravity().is_none_or(|gravity| gravity.on);
            bare.set_gravity(Some(Gravity { acceleration: GRAVITY, on }));
            Request::SetGravity(GRAVITY)
        }
        12 => {
            bare.set_gravity(bare.gravity().map(|gravity| Gravity { on: false, ..gravity }));
            Request::SwitchGravity(false)
        }
        15 => {
            bare.set_damping(Some(DAMPING));
            Request::SetDamping(DAMPING)
        }
        18 => {
            bare.reverse_velocities();
            Request::ReverseVelocities
        }
        _ => {
            bare.push(row, IMPULSE.to_array());
            twin.push(body, IMPULSE);
            return;
        }
    };
    twin.request(request);
}

#[test]
fn experiments_do_what_requests_do() {
    for name in ["projectile", "ship", "third_law", "rope", "orbit", "terminal_speed"] {
        for method in Method::ALL {
            let mut twin = twin(scene::load(name).unwrap(), method, 2);
            let mut bare = arrays(&mut twin);
            for tick in 0..24 {
                run(&mut bare, 1);
                twin.tick();
                assert!(!bare.has_failed(), "{name} by {method:?}");
                let (own, of_twin) = (all_bits(states(&bare)), all_bits(twin.states()));
                assert_eq!(own, of_twin, "{name} by {method:?} at tick {tick}");
                experiment(tick, &mut twin, &mut bare);
            }
        }
    }
}

#[test]
fn another_method_goes_on_from_where_the_last_one_was() {
    for name in ["ship", "third_law", "orbit"] {
        for (from, to) in [
            (Method::PositionVerlet, Method::RungeKutta4),
            (Method::VelocityVerlet, Method::PositionVerlet),
            (Method::PositionVerlet, Method::ImplicitEuler),
        ] {
            let mut twin = twin(scene::load(name).unwrap(), from, 1);
            let mut bare = arrays(&mut twin);
            run(&mut bare, 7);
            twin.run(7);
            // Taken in by the arrays while it is still half a step behind.
            let mut newer = arrays_by(&mut twin, to);
            bare.set_method(to);
            twin.set_method(to);
            for bare in [&mut bare, &mut newer] {
                run(bare, 7);
            }
            twin.run(7);
            for (bare, how) in [(&bare, "changed"), (&newer, "taken in")] {
                let (own, of_twin) = (all_bits(states(bare)), all_bits(twin.states()));
                assert_eq!(own, of_twin, "{name}, {from:?} to {to:?}, {how}");
            }
        }
    }
}
