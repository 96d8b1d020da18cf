//! Tests of laws against their own derivatives, potentials and promises.

use glam::DVec3;

use super::*;

const AT: EvaluationTime = EvaluationTime { time: 0.3, within_step: 0.3 };

fn body(position: DVec3, velocity: DVec3) -> BodyState {
    BodyState { position, velocity, inverse_mass: 0.5 }
}

/// Compares the Jacobians of a law with central differences of its acceleration.
fn jacobians_are_derivatives(law: &dyn Law) {
    let (x, v) = (DVec3::new(0.3, -1.2, 0.7), DVec3::new(2.0, -0.4, 1.1));
    let stated = law.jacobians(AT, body(x, v));
    let d = 1e-6;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let by = |dx: DVec3, dv: DVec3| {
            (law.acceleration(AT, body(x + dx, v + dv))
                - law.acceleration(AT, body(x - dx, v - dv)))
                / (2.0 * d)
        };
        for (stated, measured) in [
            (stated.position * axis, by(axis * d, DVec3::ZERO)),
            (stated.velocity * axis, by(DVec3::ZERO, axis * d)),
        ] {
            assert!((stated - measured).length() < 1e-7, "{law:?} {axis}: {stated} {measured}");
        }
    }
}

/// Examples of a world law: the tests of Jacobians and potentials do not compile for a law without them.
trait Samples: Law + Sized {
    fn samples() -> Vec<Self>;
}

impl Samples for Drag {
    fn samples() -> Vec<Self> {
        let still = Self::new(0.4, 0.05);
        let windy = [DVec3::new(3.0, 0.0, 1.0), DVec3::Y, DVec3::ZERO].map(|velocity| Self {
            wind: Some(Wind { velocity, gust: 0.7, gust_hz: 0.4 }),
            ..still
        });
        windy.into_iter().chain([still]).collect()
    }
}

impl Samples for Wells {
    fn samples() -> Vec<Self> {
        let well = |position| Well { position, strength: 2.0, softening: 0.1 };
        vec![Self(vec![well(DVec3::ZERO), well(DVec3::ONE)])]
    }
}

impl Samples for Lift {
    fn samples() -> Vec<Self> {
        vec![Self { turn: DVec3::new(0.3, -1.0, 2.0) }]
    }
}

macro_rules! jacobians_of_each {
    ($($name:ident: $law:ident ($($part:ident: $of:ident)?) $formula:literal;)+) => {
        $(<$law as Samples>::samples().iter().for_each(|law| jacobians_are_derivatives(law));)+
    };
}

#[test]
fn stated_jacobians_are_the_derivatives() {
    with_world_laws! { jacobians_of_each }
    jacobians_are_derivatives(&Gravity::EARTH);
    jacobians_are_derivatives(&BodyDrag::new(0.3, 0.7));
    jacobians_are_derivatives(&Thrust::new(Curve::Polynomial(vec![DVec3::X, DVec3::Y]), 0.0, 1.0));
}

/// Compares the acceleration of a law with the fall of its potential, if it has one.
fn potential_falls_along_acceleration(law: &dyn Law) {
    let listed = crate::LAWS_WITH_POTENTIAL.contains(&law.name());
    assert_eq!(listed, law.has_potential(), "{} in LAWS_WITH_POTENTIAL", law.name());
    if !law.has_potential() {
        return;
    }
    let (x, d) = (DVec3::new(0.3, -1.2, 0.7), 1e-6);
    let force = law.acceleration(AT, body(x, DVec3::ZERO)) / 0.5;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let up = law.potential_energy(body(x + axis * d, DVec3::ZERO));
        let down = law.potential_energy(body(x - axis * d, DVec3::ZERO));
        assert!(((down - up) / (2.0 * d) - force.dot(axis)).abs() < 1e-7, "{law:?} {axis}");
    }
}

macro_rules! potential_of_each {
    ($($name:ident: $law:ident ($($part:ident: $of:ident)?) $formula:literal;)+) => {
        $(<$law as Samples>::samples().iter().for_each(|law| potential_falls_along_acceleration(law));)+
    };
}

#[test]
fn a_potential_falls_along_the_acceleration() {
    with_world_laws! { potential_of_each }
    potential_falls_along_acceleration(&Gravity::EARTH);
}

#[test]
fn affine_laws_are_what_they_say() {
    let state = body(DVec3::ONE, DVec3::new(3.0, -2.0, 1.0));
    let laws: [&dyn Law; 3] =
        [&Gravity::EARTH, &Gravity { on: false, ..Gravity::EARTH }, &Drag::new(0.4, 0.0)];
    for law in laws {
        let Affine { constant, rate } = law.affine().expect("affine");
        assert_eq!(law.acceleration(AT, state), constant - state.velocity * rate, "{law:?}");
    }
    assert!(Law::affine(&Drag::new(0.4, 1.0)).is_none());
}

#[test]
fn a_thrust_is_on_between_its_ends_and_looks_at_the_time_within_the_step() {
    let thrust = Thrust::new(Curve::Polynomial(vec![DVec3::X * 10.0, DVec3::X * 15.0]), 0.0, 2.0);
    let at = |time, within_step| {
        thrust.acceleration(EvaluationTime { time, within_step }, body(DVec3::ZERO, DVec3::ZERO)).x
    };
    assert_eq!(at(1.0, 1.0), 12.5);
    // The last stage of the step that ends at the discontinuity still has the engine on, the first of the next has not.
    assert_eq!(at(2.0, 1.99), 20.0);
    assert_eq!(at(2.0, 2.01), 0.0);
    assert_eq!(Law::discontinuities(&thrust), [0.0, 2.0]);
}

#[test]
fn a_table_is_linear_between_its_points_and_bends_at_them() {
    let points = vec![(1.0, DVec3::X * 2.0), (2.0, DVec3::X * 6.0), (4.0, DVec3::ZERO)];
    let thrust = Thrust::new(Curve::Table(points), f64::NEG_INFINITY, f64::INFINITY);
    let at = |time, within_step| {
        thrust.acceleration(EvaluationTime { time, within_step }, body(DVec3::ZERO, DVec3::ZERO)).x
    };
    assert_eq!([at(0.0, 0.0), at(1.5, 1.5), at(3.0, 3.0), at(5.0, 5.0)], [1.0, 2.0, 1.5, 0.0]);
    assert_eq!(at(2.0, 1.9), at(2.0, 2.1));
    assert_eq!(at(2.5, 1.9), 4.0, "extrapolated from the points around the step");
    assert_eq!(Law::discontinuities(&thrust), [1.0, 2.0, 4.0]);
}

#[test]
fn a_sine_has_amplitude_frequency_and_phase() {
    let sine = Curve::Sine { amplitude: DVec3::X, angular_frequency: 2.0, phase: 0.5 };
    let thrust = Thrust::new(sine, 0.0, 1.0);
    let a: f64 = thrust.acceleration(AT, body(DVec3::ZERO, DVec3::ZERO)).x;
    assert!((a - 0.5 * libm::sin(1.1)).abs() < 1e-15);
}
