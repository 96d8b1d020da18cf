//! Evaluations of a world: as many as claimed.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{
    Damping, DampingModel, Drag, Gravity, GravityOff, Laws, Method, Request, Substeps, mark_method,
};

use super::{Dice, Environment, Start, crowd, engines, starts};
use crate::rigs::{Lab, engine};

const TICKS: u64 = 10;

/// Movable ones of [`starts`].
const MOVABLE: u64 = 10;

fn counts(lab: &Lab) -> (u64, Vec<(&'static str, u64)>) {
    assert_eq!(lab.evaluations().unconverged_steps(), 0);
    lab.counts()
}

/// Evaluations of one body in [`TICKS`] ticks: from the table, and what Newton's method took beyond.
fn of_a_body(method: Method, velocity_laws: bool, kept: bool) -> u64 {
    let claims = method.claims();
    let of_a_step =
        if velocity_laws { claims.evaluations_with_velocity_laws } else { claims.evaluations };
    let start_up = if kept && !velocity_laws { claims.start_up_evaluations } else { 0 };
    TICKS * u64::from(of_a_step) + u64::from(start_up)
}

/// Every iteration but the last, which only corrects, evaluates once more.
fn of_newton(lab: &Lab, steps: u64) -> u64 {
    lab.evaluations().newton_iterations().saturating_sub(steps)
}

#[test]
fn laws_that_are_summed_up_count_as_claimed() {
    for method in Method::ALL {
        for substeps in [1, 3] {
            let fall = Environment { substeps: Some(substeps), ..Environment::falling() };
            let drag = Environment { drag: Some(Drag::new(0.3, 0.0)), ..fall.clone() };
            // Exact damping is one of the laws but in the Eulers of the tutorial, which have one evaluation.
            let damping = Some(Damping { model: DampingModel::Exact, rate: 0.3 });
            let damping = Environment { damping, ..fall.clone() };
            for (law, scene) in [("", fall), ("drag", drag), ("damping", damping)] {
                let mut lab = crowd(&scene, method);
                lab.run(TICKS);
                let n = MOVABLE * u64::from(substeps) * of_a_body(method, !law.is_empty(), false);
                let laws = [law, "gravity"].into_iter().filter(|law| !law.is_empty());
                assert_eq!(
                    counts(&lab),
                    (n, laws.map(|law| (law, n)).collect()),
                    "{method:?} gravity {law}"
                );
            }
        }
    }
}

#[test]
fn drag_among_other_laws_counts_as_drag() {
    for method in Method::ALL {
        for damping in [None, Some(Damping { model: DampingModel::Tutorial, rate: 0.3 })] {
            for linear in [0.0, 0.3] {
                let mut lab = crowd(&Environment { damping, ..Environment::falling() }, method);
                lab.world.insert_resource(Laws(vec![Box::new(Drag::new(linear, 0.0))]));
                lab.recompile().run(TICKS);
                let n = MOVABLE * of_a_body(method, linear > 0.0, false);
                let expected = (n, vec![("drag", n), ("gravity", n)]);
                assert_eq!(counts(&lab), expected, "{method:?} {linear} {damping:?}");
            }
        }
    }
}

#[test]
fn laws_that_are_called_count_as_claimed() {
    for method in Method::ALL {
        for (drag, velocity_laws) in [(None, false), (Some(Drag::new(0.0, 0.1)), true)] {
            let mut lab = crowd(&Environment { drag, ..Environment::orbiting() }, method);
            lab.run(TICKS);
            let mut n = MOVABLE * of_a_body(method, velocity_laws, true);
            if method == Method::ImplicitEuler {
                n += of_newton(&lab, MOVABLE * TICKS);
            }
            let laws =
                if velocity_laws { vec![("drag", n), ("wells", n)] } else { vec![("wells", n)] };
            assert_eq!(counts(&lab), (n, laws), "{method:?} {velocity_laws}");
        }
    }
}

#[test]
fn engines_count_for_the_body_that_has_them() {
    for method in Method::ALL {
        let mut lab = crowd(&Environment::falling(), method);
        // Always on: the steps are not split.
        lab.insert(3, motion::OwnLaws::new(vec![Box::new(engine([DVec3::X, DVec3::Y]))]));
        lab.run(TICKS);
        let mut own = of_a_body(method, false, true);
        if method == Method::ImplicitEuler {
            own += of_newton(&lab, TICKS);
        }
        let n = (MOVABLE - 1) * of_a_body(method, false, false) + own;
        assert_eq!(counts(&lab), (n, vec![("gravity", n), ("thrusts", own)]), "{method:?}");
    }
}

#[test]
fn a_body_that_asks_for_something_later_is_counted_once() {
    let asks: [(&str, fn(&mut Lab, Entity)); 5] = [
        ("a limit", |lab, body| lab.insert(body, motion::SpeedLimit(1e9))),
        ("a lock", |lab, body| lab.insert(body, motion::AxisLocks::default())),
        ("a method", |lab, body| {
            let method = lab.stepper.method();
            mark_method(&mut lab.world.entity_mut(body), Some(method));
        }),
        ("substeps", |lab, body| lab.insert(body, motion::OwnSubsteps(1))),
        ("laws", |lab, body| lab.insert(body, motion::OwnLaws::new(vec![]))),
    ];
    for method in Method::ALL {
        for (name, ask) in asks {
            // A body of that kind has been there before or not: a new kind of entity is noticed anyway.
            for seen in [false, true] {
                let mut lab = crowd(&Environment::falling(), method);
                if seen {
                    let first = lab.spawn(Start { w: 0.0, ..starts()[0] });
                    ask(&mut lab, first);
                }
                lab.run(5);
                let third = lab.bodies[2];
                ask(&mut lab, third);
                lab.run(5);
                let n = MOVABLE * of_a_body(method, false, false);
                assert_eq!(counts(&lab), (n, vec![("gravity", n)]), "{method:?} {name} {seen}");
            }
        }
    }
}

#[test]
fn what_comes_later_is_counted_from_then_on() {
    for method in Method::ALL {
        let mut lab = crowd(&Environment { substeps: Some(1), ..Environment::falling() }, method);
        lab.run(5);
        lab.world.resource_mut::<Substeps>().0 = 2;
        lab.run(5);
        let half = MOVABLE * of_a_body(method, false, false) / 2;
        assert_eq!(counts(&lab).0, 3 * half, "{method:?} substeps");

        let mut lab = crowd(&Environment::falling(), method);
        for _ in 0..300 {
            // A large world has the same schedule with drag and without.
            lab.world.spawn((starts()[0].components(), GravityOff));
        }
        lab.recompile().run(5);
        let before = counts(&lab).0;
        lab.world.insert_resource(Drag::new(0.3, 0.0));
        lab.recompile().run(5);
        let all = (MOVABLE + 300) * of_a_body(method, true, false) / 2;
        assert_eq!(counts(&lab).0 - before, all, "{method:?} drag");
    }
}

#[test]
fn a_body_in_quarantine_counts_no_more() {
    for method in Method::ALL {
        for scene in [Environment::falling(), Environment::orbiting()] {
            let of_a_run = |victims: &[usize]| {
                let mut lab = crowd(&scene, method);
                lab.run(5);
                for victim in victims {
                    lab.have(Request::SetVelocity(lab.bodies[*victim], DVec3::NAN));
                }
                let before = counts(&lab).0;
                lab.run(5);
                let after = counts(&lab).0;
                after
                    - before
                    - if method == Method::ImplicitEuler { of_newton(&lab, 0) } else { 0 }
            };
            if method == Method::ImplicitEuler && scene.wells.is_some() {
                continue;
            }
            let all = of_a_run(&[]);
            assert_eq!(of_a_run(&[2, 9]) * MOVABLE, all * (MOVABLE - 2), "{method:?} {scene:?}");
            // One that never moved.
            assert_eq!(of_a_run(&[super::IMMOVABLE]), all, "{method:?} {scene:?}");
        }
    }
}

/// All bodies of a block have cached accelerations or none has: an added body costs a start of its block.
#[test]
fn a_body_that_comes_later_costs_a_start_of_its_block_and_no_more() {
    for method in [Method::VelocityVerlet, Method::Yoshida4] {
        let mut lab = crowd(&Environment::orbiting(), method);
        lab.run(5);
        let before = counts(&lab).0;
        let mut dice = Dice(1);
        lab.spawn(Start { x: dice.vector(), v: dice.vector(), w: 1.0 });
        lab.run(5);
        let claims = method.claims();
        let without_start = 5 * (MOVABLE + 1) * u64::from(claims.evaluations);
        let starts = counts(&lab).0 - before - without_start;
        let one = u64::from(claims.start_up_evaluations);
        assert!((one..=4 * one).contains(&starts), "{method:?}: {starts}");
    }
}

#[test]
fn gravity_counts_where_it_acts() {
    for method in Method::ALL {
        let mut lab = crowd(&Environment::falling(), method);
        lab.insert(0, (GravityOff, engines()));
        lab.insert(1, GravityOff);
        lab.world.insert_resource(Gravity::EARTH);
        lab.run(TICKS);
        let falling = (MOVABLE - 2) * of_a_body(method, false, false);
        let (_, laws) = counts(&lab);
        assert!(laws.contains(&("gravity", falling)), "{method:?}: {laws:?}, {falling}");
    }
}
