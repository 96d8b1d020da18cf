//! What decays ends at zero, not in subnormal numbers, which run many times slower.

use crate::rigs::Bare;
use glam::DVec3;
use motion::{Damping, DampingModel, DampingRate, Drag, Elastic, Method, SpeedLimit};

use crate::rigs::{Environment, Lab, Net, Start};

/// 2,000 s in ticks of 1/30 s.
const TICKS: u32 = 60_000;
const STEP: f64 = 1.0 / 30.0;

/// What slows bodies down.
#[derive(Clone, Copy, Debug)]
enum Brake {
    Model(DampingModel),
    /// As a law that is summed up before a tick, and as one that is called.
    Drag(f64, f64),
}

fn brakes() -> impl Iterator<Item = Brake> {
    let models = DampingModel::ALL.into_iter().map(Brake::Model);
    models.chain([Brake::Drag(0.4, 0.0), Brake::Drag(0.4, 1e-3)])
}

/// A few bodies that slow down for 2,000 s; some start close to nothing.
fn slowed(method: Method, brake: Brake) -> Bare {
    let mut bare = Bare::new(method, STEP);
    bare = match brake {
        Brake::Model(model) => bare.with_damping(Damping { model, rate: 0.4 }),
        Brake::Drag(linear, quadratic) => bare.with_law(Drag::new(linear, quadratic)),
    };
    for i in 0..5 {
        let speed = [1.0, -20.0, 1e-3, 1e-289, 1e-303][i];
        bare.add([0.0; 3], [speed, -0.3 * speed, 1e-304], [1.0, 10.0, 0.0][i % 3]);
    }
    (0..TICKS).for_each(|_| bare.tick());
    bare
}

fn has_none(method: Method) {
    for brake in brakes() {
        let bare = slowed(method, brake);
        let what = format!("{method:?}, {brake:?}");
        assert!(!bare.has_failed(), "{what}");
        for (row, (x, body)) in bare.positions.iter().zip(&bare.bodies).enumerate() {
            assert!(
                !x.iter().chain(body).any(|number| number.is_subnormal()),
                "{what}: {x:?} {body:?}"
            );
            // Nothing ever slows an immovable body but the multipliers.
            let rests = body[..3] == [0.0; 3];
            assert!(rests || row == 2, "{what}: row {row} still moves at {:?}", &body[..3]);
        }
    }
}

#[test]
fn no_state_is_subnormal_after_2000_s_of_damping_in_any_method() {
    for method in Method::ALL {
        has_none(method);
    }
}

/// A chain that comes to rest on a post, with members that ask for something.
fn chain(model: DampingModel, method: Method) -> Lab {
    let start = |i: usize| {
        let x = DVec3::X * (1.1 * i as f64);
        if i == 0 { Start::held(x) } else { Start::of(1.0, x, DVec3::ZERO) }
    };
    let elastic = Elastic::new(4.0, 1.0).damped(0.5);
    let springs = (0..3).map(|i| ([i, i + 1], elastic)).collect();
    let net = Net { bodies: (0..4).map(start).collect(), springs };
    let around =
        Environment { damping: Some(Damping { model, rate: 2.0 }), ..Environment::default() };
    let mut lab = net.lab(&around, method, 1.0 / 20.0);
    lab.insert(2, (DampingRate::new(3.0), SpeedLimit(5.0)));
    lab.recompile();
    lab
}

#[test]
fn no_state_of_a_group_is_subnormal_after_2000_s_of_damping() {
    for method in Method::ALL {
        for model in DampingModel::ALL {
            let mut lab = chain(model, method);
            for (x, v) in lab.run(40_000).states() {
                let numbers = x.to_array().into_iter().chain(v.to_array());
                let what = format!("{method:?}, {model:?}: {x:?} {v:?}");
                assert!(!numbers.into_iter().any(f64::is_subnormal), "{what}");
                assert!(v.length() < 1e-12, "{what}");
            }
        }
    }
}
