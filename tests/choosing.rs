//! Substeps that a body chooses: the error that was asked for, against the truth, what it costs, and what it does to the energy.

mod cases;

use glam::DVec3;
use motion::{
    AutoSubsteps, Evaluations, Method, MutualGravity, OwnSubsteps, PhysicsBody, Spring, StableId,
    Transform, Well, Wells, snapshot,
};

use crate::rigs::{Lab, Start, elastic};

/// Ticks per turn: no whole number of them is near a simple part of it.
const TICKS: u32 = 61;
const TURN: f64 = std::f64::consts::TAU;

/// A body on an ellipse of that eccentricity about a well of 1 m³/s², with a semi-major axis of 1 m, at its farthest.
fn comet(method: Method, e: f64, substeps: impl bevy_ecs::bundle::Bundle) -> Lab {
    let lab = Lab::new(method, TURN / f64::from(TICKS));
    let well = Well { position: DVec3::ZERO, strength: 1.0, softening: 0.0 };
    let mut lab = lab.with(Wells(vec![well]));
    let v = ((1.0 - e) / (1.0 + e)).sqrt();
    let body = lab.spawn(Start::of(1.0, DVec3::X * (1.0 + e), DVec3::Y * v));
    lab.insert(body, substeps);
    lab.recompile();
    lab
}

/// Where the body is `dt` seconds later, by Kepler's equation and Lagrange's coefficients.
fn after((x, v): (DVec3, DVec3), dt: f64) -> DVec3 {
    let r = x.length();
    let a = 1.0 / (2.0 / r - v.length_squared());
    let n = a.powf(-1.5);
    let (cos, sin) = (1.0 - r / a, x.dot(v) / a.sqrt());
    let mut d = n * dt;
    for _ in 0..50 {
        let f = d - cos * d.sin() + sin * (1.0 - d.cos()) - n * dt;
        d -= (f / (1.0 - cos * d.cos() + sin * d.sin())).clamp(-1.0, 1.0);
    }
    x * (1.0 - a / r * (1.0 - d.cos())) + v * (dt - (d - d.sin()) / n)
}

/// Largest error of a tick in `turns` turns, m, and the evaluations.
fn run(lab: &mut Lab, turns: u32) -> (f64, u64) {
    let mut worst = 0.0_f64;
    for _ in 0..TICKS * turns {
        let before = lab.states()[0];
        lab.run(1);
        worst = worst.max((lab.states()[0].0 - after(before, TURN / f64::from(TICKS))).length());
    }
    (worst, lab.world.resource::<Evaluations>().accelerations())
}

fn choice(lab: &Lab) -> AutoSubsteps {
    *lab.world.get::<AutoSubsteps>(lab.bodies[0]).unwrap()
}

fn asking(error: f64, most: u32) -> AutoSubsteps {
    let mut choice = AutoSubsteps::new(error);
    choice.most = most;
    choice
}

#[test]
fn every_tick_has_the_error_that_was_asked_for_and_a_comet_takes_half_of_the_evaluations_at_most() {
    for e in [0.2, 0.9, 0.99, 0.999] {
        for method in [Method::VelocityVerlet, Method::RungeKutta4, Method::Yoshida4] {
            for error in [1e-3, 1e-5] {
                let mut lab = comet(method, e, asking(error, 1 << 16));
                let (worst, evaluations) = run(&mut lab, 3);
                let AutoSubsteps { exceeded, .. } = choice(&lab);
                let what = format!("{e}, {method:?}, {error:e}: {worst:e}, {evaluations}");
                assert!(worst <= error || exceeded > 0, "{what}");
                // Close to the well even 65,536 may not suffice.
                assert!(exceeded == 0 || e == 0.999, "{what}");
                if e < 0.9 || exceeded > 0 {
                    continue;
                }
                // The fewest fixed substeps with that error in every tick.
                let fixed =
                    (1..=15).map(|power| run(&mut comet(method, e, OwnSubsteps(1 << power)), 3));
                let cheapest = { fixed }.find(|(worst, _)| *worst <= error);
                assert!(cheapest.is_none_or(|(_, fixed)| 2 * evaluations <= fixed), "{what}");
            }
        }
    }
}

#[test]
fn what_is_smooth_costs_what_its_fixed_number_costs() {
    // Two of the Eulers lose or gain energy, and so leave the circle.
    for method in Method::ALL.into_iter().filter(|method| method.claims().position_order > 1) {
        let mut lab = comet(method, 0.0, asking(1e-6, 4096));
        let (_, evaluations) = run(&mut lab, 5);
        let (_, fixed) = run(&mut comet(method, 0.0, OwnSubsteps(choice(&lab).last)), 5);
        assert!(evaluations as f64 <= 1.1 * fixed as f64, "{method:?}: {evaluations} {fixed}");
    }
}

#[test]
fn symplectic_methods_keep_the_energy_for_a_thousand_turns() {
    for (method, error, bound) in
        [(Method::VelocityVerlet, 1e-4, 2e-3), (Method::Yoshida4, 1e-5, 1e-4)]
    {
        let mut lab = comet(method, 0.5, asking(error, 4096));
        let mut numbers = std::collections::BTreeSet::new();
        for turn in 0..1000 {
            // The mean of a turn: within one it swings.
            let mut mean = 0.0;
            for _ in 0..TICKS {
                let (x, v) = lab.run(1).states()[0];
                mean += (0.5 * v.length_squared() - 1.0 / x.length()) / f64::from(TICKS);
                numbers.insert(choice(&lab).last);
            }
            let off = (mean / -0.5 - 1.0).abs();
            assert!(off < bound, "{method:?}, turn {turn}: {off:e}");
        }
        assert!(numbers.len() > 1, "{method:?} changes its step: {numbers:?}");
    }
}

#[test]
fn a_restored_world_chooses_the_same_numbers() {
    let mut lab = comet(Method::VelocityVerlet, 0.9, AutoSubsteps::new(1e-4));
    lab.run(25);
    let saved = snapshot::take(&lab.world, &lab.stepper);
    let end = |lab: &mut Lab| {
        lab.run(60);
        (lab.states(), choice(lab))
    };
    let first = end(&mut lab);
    snapshot::restore(&mut lab.world, &mut lab.stepper, &saved).unwrap();
    assert_eq!(end(&mut lab), first);
}

#[test]
fn a_group_has_the_choice_of_its_first_body_and_pushes_act_once() {
    let mut lab = Lab::new(Method::VelocityVerlet, 0.1);
    let ends = [0.0, 1.5].map(|x| lab.spawn(Start::of(1.0, DVec3::X * x, DVec3::ZERO)));
    (0..).zip(ends).for_each(|(id, end)| lab.insert(end, StableId(id)));
    lab.world.spawn(Spring { ends, elastic: elastic(400.0, 1.0) });
    lab.insert(0, asking(1e-6, 4096));
    lab.recompile().push(1, DVec3::Y * 20.0).run(30);
    let both = ends.map(|end| lab.world.get::<AutoSubsteps>(end).is_some());
    assert_eq!(both, [true; 2]);
    assert!(choice(&lab).last > 16 && choice(&lab).exceeded == 0);
    // 20 N for one tick.
    let momentum: DVec3 =
        ends.iter().map(|end| lab.world.get::<PhysicsBody>(*end).unwrap().momentum()).sum();
    assert!((momentum - DVec3::Y * 2.0).length() < 1e-12, "{momentum}");
}

#[test]
fn mutual_gravity_has_its_binary() {
    // A tight pair beside a third body: the pair sets the number.
    let mut lab = Lab::new(Method::VelocityVerlet, 0.05).with(MutualGravity::new(1.0, 0.0));
    let v = 0.5 * (2.0_f64 / 0.02).sqrt();
    for (id, (x, v)) in (0..).zip([(5.0, 0.0), (-0.01, v), (0.01, -v)]) {
        let body = lab.spawn(Start::of(1.0, DVec3::X * x, DVec3::Y * v));
        lab.insert(body, StableId(id));
    }
    lab.insert(0, asking(1e-4, 1 << 16));
    lab.recompile().run(40);
    let at = |body: usize| lab.world.get::<Transform>(lab.bodies[body]).unwrap().position;
    let apart = at(1).distance(at(2));
    assert!((apart - 0.02).abs() < 2e-3, "{apart}");
    assert!(choice(&lab).last >= 64 && choice(&lab).exceeded == 0);
}

#[test]
fn numbers_out_of_range_are_refused() {
    for wrong in [asking(0.0, 4096), asking(f64::NAN, 4096), asking(1e-3, 1000), asking(1e-3, 1)] {
        let insert = || drop(comet(Method::VelocityVerlet, 0.5, wrong));
        assert!(std::panic::catch_unwind(insert).is_err(), "{wrong:?}");
    }
}
