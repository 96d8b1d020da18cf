//! What a method keeps, for how long, and the way back.

use motion::{Curve, Method, Thrust};

use super::laws::{Spring, duffing};
use super::oracle::{after, image};
use super::problems::{ACROSS, kepler_state, linear_thrust, sun};
use super::{Check, SKEW, Stepper, all_pass, beyond, position, velocity, within};
use crate::rigs::Bare;

const LONG: u32 = 10_000_000;

/// Largest relative change of the nearby energy of four oscillators, z = w h = 0.01, 0.1, 1.5 and 1.9, each
/// times `1 - z² / 4`: near z = 2 the energy is a difference of two large parts.
fn modified_energy_drift(method: Method, steps: u32) -> f64 {
    let stepper = Stepper::real(method);
    // No multiple of a period, or the same phase would be looked at again and again. As substeps of 1 s they
    // cost less than as ticks.
    let interval = 9_973;
    let mut bare = stepper.bare(f64::from(interval)).with_law(Spring(1.0)).with_substeps(interval);
    for z in [0.01, 0.1, 1.5, 1.9_f64] {
        bare.add(SKEW.to_array(), (ACROSS * (0.7 * z)).to_array(), z * z);
    }
    let energies = |bare: &Bare| -> Vec<f64> {
        let energy = |body: usize| {
            let (x, v, w2) = (position(bare, body), velocity(bare, body), bare.bodies[body][3]);
            match method {
                Method::VelocityVerlet => v.dot(v) + w2 * (1.0 - w2 / 4.0) * x.dot(x),
                _ => v.dot(v) + w2 * x.dot(x) - w2 * x.dot(v),
            }
        };
        (0..4).map(energy).collect()
    };
    let (start, mut worst) = (energies(&bare), 0.0_f64);
    for _ in 0..steps / interval {
        stepper.run(&mut bare, 1);
        for (body, (now, start)) in energies(&bare).into_iter().zip(&start).enumerate() {
            let z2 = bare.bodies[body][3];
            let drift = (now / start - 1.0).abs() * (1.0 - z2 / 4.0);
            worst = if drift <= worst { worst } else { drift };
        }
    }
    worst
}

#[test]
fn nearby_energies_stay_for_ten_million_steps() {
    for method in [Method::VelocityVerlet, Method::SemiImplicitEuler] {
        let drift = modified_energy_drift(method, LONG);
        assert!(drift <= 1e-11, "{method:?}: {drift:e}");
    }
}

/// Unbiased roundings add up like the root of their number, or a little faster; a bias like the number itself.
#[test]
fn drifts_of_nearby_energies_grow_slower_than_a_bias_would() {
    for method in [Method::VelocityVerlet, Method::SemiImplicitEuler] {
        let [short, long] = [99_730, 9_973_000].map(|steps| modified_energy_drift(method, steps));
        let exponent = (long / short).log10() / 2.0;
        assert!(exponent <= 0.85, "{method:?}: from {short:e} to {long:e}, exponent {exponent}");
    }
}

const ECCENTRICITIES: [f64; 4] = [0.0, 0.6, 0.9, 0.99];

/// Largest relative change of angular momentum over an orbit of `steps` steps, at any of the eccentricities.
fn angular_momentum_drift(stepper: &Stepper, steps: u32, eccentricities: &[f64]) -> f64 {
    let mut bare = stepper.bare(std::f64::consts::TAU / f64::from(steps)).with_law(sun());
    for e in eccentricities {
        let (x, v) = kepler_state(*e, 0.0);
        bare.add(x.to_array(), v.to_array(), 0.5);
    }
    let momentum = |bare: &Bare, body| position(bare, body).cross(velocity(bare, body));
    let start: Vec<_> = (0..eccentricities.len()).map(|body| momentum(&bare, body)).collect();
    let mut worst = 0.0;
    for _ in 0..100 {
        stepper.run(&mut bare, steps / 100);
        for (body, start) in start.iter().enumerate() {
            let drift = (momentum(&bare, body) - *start).length() / start.length();
            worst = if drift <= worst { worst } else { drift };
        }
    }
    worst
}

/// Kicks along the radius turn nothing: the symplectic methods keep angular momentum to rounding.
pub fn check_angular_momentum(stepper: &Stepper) -> Check {
    if !stepper.claims().symplectic {
        return Ok(());
    }
    within(|| "angular momentum".into(), angular_momentum_drift(stepper, 1000, &[0.6]), 1e-12)
}

#[test]
fn symplectic_methods_keep_angular_momentum() {
    all_pass(check_angular_momentum);
    for stepper in Stepper::all() {
        let drift = angular_momentum_drift(&stepper, 100_000, &ECCENTRICITIES);
        let kept = drift <= 1e-12;
        assert_eq!(kept, stepper.claims().symplectic, "{}: {drift:e}", stepper.name);
    }
}

/// Distance from the start after `seconds` there and back at 60 Hz on the hardening spring.
fn return_error(stepper: &Stepper, seconds: u32) -> f64 {
    let mut bare = stepper.bare(1.0 / 60.0).with_law(duffing());
    let (x, v) = (SKEW, ACROSS * 0.7);
    bare.add(x.to_array(), v.to_array(), 0.5);
    stepper.run(&mut bare, 60 * seconds);
    bare.reverse_velocities();
    stepper.run(&mut bare, 60 * seconds);
    position(&bare, 0).distance(x)
}

/// The methods that are called reversible come back the way they went, and no others.
pub fn check_reversible(stepper: &Stepper) -> Check {
    let error = return_error(stepper, 10);
    if stepper.claims().reversible {
        within(|| "return".into(), error, 1e-12)
    } else {
        beyond(|| "return".into(), error, 1e-9)
    }
}

#[test]
fn reversible_methods_come_back() {
    all_pass(check_reversible);
}

#[test]
fn the_others_miss_by_what_theory_says() {
    let (z, n, start) = (1.0 / 30.0, 600, [SKEW, ACROSS * 0.7]);
    for stepper in Stepper::all().filter(|stepper| stepper.method != Method::PositionVerlet) {
        let mut bare = stepper.bare(z / 2.0).with_law(Spring(8.0));
        bare.add((start[0] / 2.0).to_array(), (start[1]).to_array(), 0.5);
        stepper.run(&mut bare, n);
        bare.reverse_velocities();
        stepper.run(&mut bare, n);
        let m = after(stepper.method, z, n);
        let [x, v] = image(m, start);
        let [x, _] = image(m, [x, -v]);
        let (missed, expected) =
            ((position(&bare, 0) * 2.0).distance(start[0]), x.distance(start[0]));
        // 1200 steps, each rounded a few times, of a state that explicit Euler doubles.
        assert!(
            (missed - expected).abs() <= 1e-12 * x.length(),
            "{}: {missed:e} {expected:e}",
            stepper.name
        );
    }
}

/// Where the velocity's order integrates a linear acceleration exactly.
#[test]
fn momentum_is_the_integral_of_the_thrust() {
    let problem = linear_thrust();
    for stepper in Stepper::all().filter(|stepper| stepper.claims().velocity_order >= 2) {
        let mut bare = problem.bare(&stepper, 1.0 / 60.0);
        stepper.run(&mut bare, 60);
        let momentum = velocity(&bare, 0) / problem.inverse_mass;
        // 60 additions, each rounded by half a unit of the result.
        let bound = 60.0 * f64::EPSILON / 2.0 * 35.0;
        assert!(momentum.distance(SKEW * 35.0) <= bound, "{}: {momentum}", stepper.name);
    }
}

/// The tutorial's "we do not know what happened in between".
#[test]
fn the_eulers_hold_the_thrust_over_the_step() {
    let late = [(1, 10.0), (10, 16.75), (60, 17.375), (1000, 17.4925)];
    let early = [(1, 25.0), (10, 18.25), (60, 17.625), (1000, 17.5075)];
    let both = [
        (Method::ExplicitEuler, late),
        (Method::SemiImplicitEuler, late),
        (Method::ImplicitEuler, early),
    ];
    for (method, gained) in both {
        for (hz, gained) in gained {
            let stepper = Stepper::real(method);
            let curve = Curve::Polynomial(vec![SKEW * 10.0, SKEW * 15.0]);
            let engine = Thrust::new(curve, 0.0, 1.0);
            let mut bare = stepper.bare(1.0 / f64::from(hz)).with_law(engine);
            bare.add([0.0; 3], [0.0; 3], 1.0);
            stepper.run(&mut bare, hz);
            let v = velocity(&bare, 0).dot(SKEW);
            assert!(
                (v - gained).abs() <= f64::from(hz) * f64::EPSILON * gained,
                "{method:?} {hz}: {v}"
            );
        }
    }
}
