//! Steps of changing length, starts, and single precision: where Verlet's formula goes wrong if taken literally.

use glam::DVec3;
use motion::{Gravity, Method};

use super::{Check, Stepper, all_pass, position, velocity, within};
use crate::rigs::pull;

const H: f64 = 1.0 / 60.0;

/// Step lengths in [0.5, 1.5] h that repeat after 2^31 steps.
fn jitter() -> impl Iterator<Item = f64> {
    let next =
        |state: &u32| Some(state.wrapping_mul(1_103_515_245).wrapping_add(12_345) & 0x7fff_ffff);
    std::iter::successors(Some(1), next)
        .skip(1)
        .map(|n| H * (0.5 + f64::from(n) / 2.0_f64.powi(31)))
}

/// Steps of changing length: a constant acceleration is still taken in exactly by every position of order 2,
/// free flight by all. T4, G15.
pub fn check_jitter(stepper: &Stepper) -> Check {
    let (x0, v0) = (DVec3::new(0.0, 3.0, 1.0), DVec3::new(5.0, 0.0, -1.0));
    let rates = [60.0, 120.0, 240.0];
    for (rate, gravity) in rates
        .into_iter()
        .flat_map(|rate| [DVec3::ZERO, Gravity::EARTH.acceleration].map(|g| (rate, g)))
    {
        if gravity != DVec3::ZERO && stepper.claims().position_order < 2 {
            continue;
        }
        let mut bare = stepper.bare(1.0 / rate).with_law(pull(gravity));
        bare.add(x0.to_array(), v0.to_array(), 0.5);
        let mut t = 0.0;
        for step in jitter().take(5 * rate as usize).map(|step| step / H / rate) {
            bare.set_step(step);
            stepper.run(&mut bare, 1);
            t += step;
            let exact = x0 + (v0 + gravity * (t / 2.0)) * t;
            let error = position(&bare, 0).distance(exact) / exact.length();
            within(|| format!("{rate} Hz jittered, gravity {gravity}, t = {t:.3}"), error, 1e-10)?;
        }
        let clock = (bare.time() - t).abs();
        within(|| "time".into(), clock, 5.0 * rate * f64::EPSILON * t)?;
    }
    Ok(())
}

#[test]
fn steps_of_changing_length_keep_the_parabola() {
    all_pass(check_jitter);
}

/// A start far from the origin, at rest and not: nothing but the velocity moves the body. T5.
pub fn check_start(stepper: &Stepper) -> Check {
    for v in [DVec3::ZERO, DVec3::new(0.5, -2.0, 1.0)] {
        let mut bare = stepper.bare(H);
        let start = DVec3::new(10.0, 0.0, -7.0);
        bare.add(start.to_array(), v.to_array(), 0.5);
        stepper.run(&mut bare, 60);
        // Positions of about 10 m, three additions in a step at most.
        let error = position(&bare, 0).distance(start + v);
        within(|| format!("start with {v}"), error, 180.0 * f64::EPSILON * 10.0)?;
        within(|| format!("velocity {v}"), velocity(&bare, 0).distance(v), 0.0)?;
    }
    Ok(())
}

#[test]
fn a_body_starts_from_where_it_is() {
    all_pass(check_start);
}

/// T6. Position Verlet ends its half step there.
#[test]
fn a_step_of_no_length_changes_no_bit() {
    for stepper in Stepper::all().filter(|stepper| stepper.method != Method::PositionVerlet) {
        let run = |pause: bool| {
            let mut bare =
                stepper.bare(H).with_law(Gravity::EARTH).with_law(super::problems::sun());
            bare.add([1.0, 0.5, 0.0], [0.1, 1.0, 0.0], 0.5);
            stepper.run(&mut bare, 10);
            if pause {
                let before = (bare.positions.clone(), bare.bodies.clone());
                bare.set_step(0.0);
                stepper.run(&mut bare, 3);
                assert_eq!(
                    (bare.positions.clone(), bare.bodies.clone()),
                    before,
                    "{}",
                    stepper.name
                );
                bare.set_step(H);
            }
            stepper.run(&mut bare, 10);
            (bare.positions, bare.bodies)
        };
        assert_eq!(run(true), run(false), "{}", stepper.name);
    }
}

/// A minute of free fall 1e13 m away, where neighbouring numbers are 2 mm apart, against the same fall at the origin:
/// 2 x - x0 + a h² loses a h², 2.7 mm, below the last digit of x and is wrong by kilometers.
pub fn check_far_away(stepper: &Stepper) -> Check {
    const AWAY: f64 = 1e13;
    let steps = 3600;
    let fall = |from: f64| {
        let mut bare = stepper.bare(1.0 / 60.0).with_law(Gravity::EARTH);
        bare.add([0.0, from, 0.0], [0.0, 100.0, 0.0], 0.5);
        stepper.run(&mut bare, steps);
        bare.positions[0][1] - from
    };
    // Every step rounds the position by half a unit.
    let bound = f64::from(steps) * f64::EPSILON / 2.0 * AWAY;
    within(|| "a minute of free fall far away, m".into(), (fall(AWAY) - fall(0.0)).abs(), bound)
}

#[test]
fn gravity_is_kept_far_away() {
    all_pass(check_far_away);
}

/// The velocity that the new method starts from is that of the time of the position, so order 2 stays.
#[test]
fn a_change_of_method_keeps_the_order() {
    let problem = super::problems::duffing();
    for [from, to] in [
        [Method::PositionVerlet, Method::VelocityVerlet],
        [Method::VelocityVerlet, Method::PositionVerlet],
        [Method::PositionVerlet, Method::RungeKutta4],
        [Method::Yoshida4, Method::VelocityVerlet],
    ] {
        let error = |steps: u32| {
            let mut bare = problem.bare(&Stepper::real(from), problem.span / f64::from(steps));
            (0..steps / 2).for_each(|_| bare.tick());
            bare.set_method(to);
            (0..steps / 2).for_each(|_| bare.tick());
            position(&bare, 0).distance((problem.exact)(problem.span).0)
        };
        let order = (error(1024) / error(2048)).log2();
        assert!((order - 2.0).abs() <= 0.05, "{from:?} {to:?}: {order}");
    }
}
