//! Forces of one tick, gravity that is switched, and masses.

use glam::DVec3;
use motion::internals::{BLOCK_BODIES, BodyBlock};
use motion::{Drag, Gravity, Law, Method, Well, Wells};

use super::problems::sun;
use super::{Check, SKEW, Stepper, all_pass, position, velocity, within};
use crate::rigs::Bare;
use crate::rigs::{engine, pull};

const H: f64 = 1.0 / 60.0;

/// A push of one tick gives F h / m, once, whatever the substeps and whatever else acts.
pub fn check_push(stepper: &Stepper) -> Check {
    let (force, w) = (DVec3::new(100.0, -40.0, 7.0), 0.5);
    for (substeps, gravity) in [(1, false), (3, false), (8, false), (1, true), (3, true), (8, true)]
    {
        let mut bare = stepper.bare(H).with_substeps(substeps);
        if gravity {
            bare = bare.with_law(Gravity::EARTH);
        }
        let pushed = bare.add([0.0; 3], [0.0; 3], w);
        let left = bare.add([0.0; 3], [0.0; 3], w);
        bare.push(pushed, force.to_array());
        let gained = force * (w * H);
        for tick in 1..=3 {
            stepper.run(&mut bare, 1);
            let error = velocity(&bare, pushed) - velocity(&bare, left) - gained;
            // 2 ulp of what the number is, and half of one for every addition beyond the first.
            let size = velocity(&bare, pushed).abs().max_element().max(gained.abs().max_element());
            let ulps = 2.0 + f64::from(substeps * tick - 1) / 2.0;
            let what = || format!("push, {substeps} substeps, gravity {gravity}, tick {tick}");
            within(what, error.abs().max_element(), ulps * f64::EPSILON * size)?;
        }
    }
    Ok(())
}

#[test]
fn a_push_of_one_tick_gives_its_impulse_once() {
    all_pass(check_push);
}

/// F h² / 2 m, where the position integrates a constant acceleration exactly.
#[test]
fn a_push_moves_by_half_its_impulse_in_its_tick() {
    for stepper in Stepper::all().filter(|stepper| stepper.claims().position_order >= 2) {
        for substeps in [1, 3, 8] {
            let mut bare = stepper.bare(H).with_substeps(substeps);
            bare.add([0.0; 3], [0.0; 3], 0.5);
            bare.push(0, (SKEW * 100.0).to_array());
            stepper.run(&mut bare, 1);
            let expected = SKEW * (100.0 * 0.5 * H * H / 2.0);
            let bound = 4.0 * f64::from(substeps) * f64::EPSILON * expected.length();
            assert!(position(&bare, 0).distance(expected) <= bound, "{} {substeps}", stepper.name);
        }
    }
}

/// Gravity switched at steps 37 and 91, off and then on with another value.
fn gravity_of_step(step: u32) -> Option<DVec3> {
    match step {
        0..37 => Some(Gravity::EARTH.acceleration),
        37..91 => None,
        _ => Some(DVec3::new(2.0, 5.0, -1.0)),
    }
}

/// A step under a constant acceleration.
pub fn uniform_step(method: Method, x: DVec3, v: DVec3, a: DVec3) -> (DVec3, DVec3) {
    let of_step = match method {
        Method::ExplicitEuler => v,
        Method::SemiImplicitEuler | Method::ImplicitEuler => v + a * H,
        _ => v + a * (H / 2.0),
    };
    (x + of_step * H, v + a * H)
}

/// The laws that change between two ticks act from then on and not before: a parabola in pieces, or what the
/// Eulers make of it.
pub fn check_toggles(stepper: &Stepper) -> Check {
    let start = (DVec3::new(3.0, -2.0, 0.0), DVec3::new(1.0, 12.0, 0.5));
    let mut bare = stepper.bare(H);
    bare.set_laws(vec![Box::new(Gravity::EARTH)]);
    bare.add(start.0.to_array(), start.1.to_array(), 0.5);
    let (mut x, mut v) = start;
    for step in 0..150 {
        if step == 37 || step == 91 {
            let laws = gravity_of_step(step).map(pull);
            bare.set_laws(laws.into_iter().map(|law| Box::new(law) as Box<dyn Law>).collect());
        }
        let a = gravity_of_step(step).unwrap_or(DVec3::ZERO);
        (x, v) = uniform_step(stepper.method, x, v, a);
        stepper.run(&mut bare, 1);
        // Two additions a step on either side, and stages of up to twice the step.
        let bound = 8.0 * f64::from(step + 1) * f64::EPSILON;
        let error = position(&bare, 0).distance(x);
        within(|| format!("position after step {step}"), error, bound * (x.length() + v.length()))?;
        if stepper.method != Method::PositionVerlet {
            let error = velocity(&bare, 0).distance(v);
            within(
                || format!("velocity after step {step}"),
                error,
                bound * (start.1.length() + v.length()),
            )?;
        }
    }
    Ok(())
}

#[test]
fn gravity_that_is_switched_is_a_parabola_in_pieces() {
    all_pass(check_toggles);
}

/// No cached acceleration of the old laws is used, under laws of position either.
#[test]
fn laws_that_change_leave_nothing_behind() {
    for stepper in Stepper::all().filter(|stepper| stepper.method != Method::PositionVerlet) {
        let laws = || -> Vec<Box<dyn Law>> { vec![Box::new(sun())] };
        let mut changed = stepper.bare(H);
        changed.set_laws(vec![Box::new(Wells(vec![Well {
            position: SKEW,
            strength: 5.0,
            softening: 0.1,
        }]))]);
        changed.add([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
        stepper.run(&mut changed, 7);
        changed.set_laws(laws());
        let mut fresh = stepper.bare(H);
        fresh.set_laws(laws());
        let [x, y, z, w] = changed.bodies[0];
        fresh.add(changed.positions[0], [x, y, z], w);
        stepper.run(&mut changed, 20);
        stepper.run(&mut fresh, 20);
        assert_eq!(changed.positions, fresh.positions, "{}", stepper.name);
        assert_eq!(changed.bodies, fresh.bodies, "{}", stepper.name);
    }
}

/// Bodies of every mass fall alike, and one of infinite mass stays where it is, under a law that says so.
pub fn check_gravity(gravity: fn(Bare) -> Bare) -> Check {
    for stepper in Stepper::all() {
        let mut bare = gravity(stepper.bare(H));
        for w in [1e-3, 0.5, 1.0, 7.0] {
            bare.add(SKEW.to_array(), [1.0, 2.0, 3.0], w);
        }
        stepper.run(&mut bare, 60);
        for body in 1..4 {
            let apart = position(&bare, body).distance(position(&bare, 0));
            within(|| format!("{}: fall of body {body}", stepper.name), apart, 0.0)?;
        }
    }
    Ok(())
}

#[test]
fn bodies_of_every_mass_fall_alike() {
    check_gravity(|bare| bare.with_law(Gravity::EARTH)).unwrap();
    check_gravity(|bare| bare.with_law(sun())).unwrap();
}

/// A law adds nothing to the rows of inverse mass 0, whatever lies next to them.
pub fn check_passes_over(law: &dyn Law) -> Check {
    let at = motion::EvaluationTime { time: 0.5, within_step: 0.5 };
    let axes = |numbers: [f64; 3]| numbers.map(|number| [number; BLOCK_BODIES]);
    let (positions, velocities, mut sum) = (axes([1.0, 2.0, 3.0]), axes([1.0; 3]), axes([0.5; 3]));
    let mut inverse_masses = [2.0; BLOCK_BODIES];
    inverse_masses[1] = 0.0;
    let bodies = BodyBlock {
        positions: &positions,
        velocities: &velocities,
        inverse_masses: &inverse_masses,
    };
    law.accelerate(at, &bodies, &mut sum);
    let added = |k: usize| sum.iter().map(|axis| f64::abs(axis[k] - 0.5)).sum::<f64>();
    within(|| format!("{}, added to an immovable body", law.name()), added(1), 0.0)?;
    if added(0) > 0.0 && added(2) > 0.0 {
        Ok(())
    } else {
        Err(format!("{} does nothing", law.name()))
    }
}

#[test]
fn laws_pass_over_immovable_bodies() {
    let laws: [&dyn Law; 4] = [&Gravity::EARTH, &Drag::new(0.4, 0.1), &sun(), &engine([SKEW])];
    for law in laws {
        check_passes_over(law).unwrap();
    }
}

/// Under every law, force and damping except the tutorial's.
#[test]
fn an_immovable_body_moves_uniformly() {
    for stepper in Stepper::all() {
        let mut bare = stepper.bare(0.25).with_law(Gravity::EARTH).with_law(sun());
        bare.add(SKEW.to_array(), [0.0; 3], 0.0);
        bare.add([8.0, 0.0, 0.0], [1.0, 2.0, -0.5], 0.0);
        bare.push(0, [1e38, 0.0, 0.0]);
        stepper.run(&mut bare, 8);
        assert_eq!(position(&bare, 0), SKEW, "{}", stepper.name);
        // Sums of powers of 2, exact for all but the composed steps of Yoshida.
        let error = position(&bare, 1).distance(DVec3::new(10.0, 4.0, -1.0));
        assert!(error <= 24.0 * f64::EPSILON * 10.0, "{}: {error:e}", stepper.name);
        assert_eq!(velocity(&bare, 1), DVec3::new(1.0, 2.0, -0.5), "{}", stepper.name);
    }
}
