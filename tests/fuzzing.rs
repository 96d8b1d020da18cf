//! The targets of `tests/fuzz` on bytes by chance: a bounded number in every test run, more if `FUZZ_CASES` says so.
//!
//! The bytes are the same in every run, unless `FUZZ_SEED` is another number than 0; with `FUZZ_INPUT` they are those of
//! that file instead. What once broke a promise is a test of its own below.

use std::fs;

use acceptance::targets::{TARGETS, Target};
use bevy_ecs::prelude::Entity;
use glam::{DVec2, DVec3};
use history::{Rerun, TIMELINE_BYTES};
use motion::{Damping, DampingModel, Method, Request, Transform};
use proptest::collection::vec;
use proptest::prelude::any;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sandbox::Panel;
use sandbox::input::{Button, Input};

use crate::rigs::{Drive, Environment, H, Lab, Start, bits, elastic, push, remove};

fn number(name: &str) -> Option<u32> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a whole number")))
}

/// Runs the target `name` on `cases` inputs, or on as many as the environment says.
#[track_caller]
fn holds(name: &str, cases: u32) {
    let (_, target): &(&str, Target) = TARGETS.iter().find(|(other, _)| *other == name).unwrap();
    if let Some(path) = std::env::var_os("FUZZ_INPUT") {
        target(
            &fs::read(&path)
                .unwrap_or_else(|error| panic!("FUZZ_INPUT {}: {error}", path.display())),
        );
        return;
    }
    let config = Config {
        cases: number("FUZZ_CASES").unwrap_or(cases),
        failure_persistence: None,
        max_shrink_iters: 400,
        ..Config::default()
    };
    let mut seed = [0; 32];
    seed[..4].copy_from_slice(&number("FUZZ_SEED").unwrap_or(0).to_le_bytes());
    let mut runner =
        TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
    let result = runner.run(&vec(any::<u8>(), 0..1200), |bytes| {
        target(&bytes);
        Ok(())
    });
    if let Err(error) = result {
        panic!("{name}: {error}");
    }
}

#[test]
fn any_text_is_a_scene_or_refused() {
    holds("scene", 500);
}

#[test]
fn a_damaged_scene_is_read_or_refused() {
    holds("mutated_scene", 500);
}

#[test]
fn any_text_is_a_script_or_refused() {
    holds("script", 500);
}

#[test]
fn any_bytes_are_a_bundle_or_refused() {
    holds("bundle", 300);
}

#[test]
fn nothing_that_a_person_does_breaks_a_session() {
    holds("session", 200);
}

#[test]
fn nothing_that_is_asked_of_a_world_harms_another_body() {
    holds("step", 2000);
}

/// Two bodies of position Verlet 2 m apart that fall, on a spring.
fn falling_pair(velocities: [DVec3; 2], rest_length: f64) -> (Lab, [Entity; 2]) {
    let mut lab = Lab::new(Method::PositionVerlet, H).with_gravity();
    let bodies = velocities.map(|velocity| lab.body(1.0, velocity));
    lab.world.get_mut::<Transform>(bodies[1]).unwrap().position.z += 2.0;
    lab.spring(bodies, elastic(50.0, rest_length));
    lab.recompile();
    (lab, bodies)
}

/// Position Verlet's velocity is half a step behind. Gravity that changes when a body is alone again must not act on the
/// half step before.
#[test]
fn a_body_that_left_a_group_of_position_verlet_falls_on_exactly() {
    for later in [0, 1, 5] {
        let (mut lab, bodies) = falling_pair([DVec3::X, DVec3::X], 2.0);
        let start = lab.x(bodies[0]);
        lab.run(10).ask(Request::Remove(bodies[1]));
        if later > 0 {
            lab.run(later);
        }
        let gravity = DVec3::new(3.0, 40.0, 0.0);
        lab.ask(Request::SetGravity(gravity)).run(20);
        let fall =
            |x: DVec3, v: DVec3, a: DVec3, t: f64| (x + v * t + a * (0.5 * t * t), v + a * t);
        let before = (10 + later) as f64 * H;
        let (x, v) = fall(start, DVec3::X, DVec3::Y * -9.8, before);
        let (x, _) = fall(x, v, gravity, 20.0 * H);
        assert!(lab.x(bodies[0]).distance(x) <= 1e-12, "{later}: {} {x}", lab.x(bodies[0]));
    }
}

/// Curves of numbers that no plot has room for.
#[test]
fn a_ledger_of_huge_energies_is_drawn() {
    for speed in [1e20, 1e150, 1e300] {
        let mut drive = Drive::bodies(&format!(
            "(name: \"a\", shape: sphere(radius_m: 0.1), mass_kg: 1.0, velocity_m_s: ({speed:e}, 0, 0))"
        ));
        drive.press("B").ticks(40);
        assert_eq!(drive.session.open_panels(), [Panel::Ledger]);
        drive.session.picture();
    }
}

/// The second of two points of a curve is too late to be drawn, and the first stands alone.
#[test]
fn a_ledger_is_drawn_after_a_frame_without_end() {
    let text = "(version: 1, step: frame, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [(name: \"a\", \
                velocity_m_s: (2e11, 0, 0), mass_kg: 1.0)])";
    let mut drive = Drive::text(text);
    drive.press("B");
    for length in [1.0 / 60.0, 1e250, 1.0] {
        drive.frame(length, []);
    }
    assert_eq!(
        (drive.session.open_panels(), drive.session.stage.sim().ticks()),
        (&[Panel::Ledger][..], 3)
    );
}

/// `1 - c t` overflows, and zero positions times that are NaN.
#[test]
fn damping_without_end_harms_no_group() {
    for method in Method::ALL {
        let text = format!(
            "(version: 1, step_hz: 0.1, method: {}, damping: (rate_per_s: 1e308),
              bodies: [(name: \"a\", immovable: true), (name: \"b\", position_m: (1.5, 0, 0), mass_kg: 1.0)],
              springs: [(between: (\"a\", \"b\"), stiffness_n_m: 1.0, rest_length_m: 1.0)])",
            method.name()
        );
        let mut drive = Drive::text(&text);
        drive.run(3, 10.0);
        assert!(drive.x("b").is_finite() && drive.v("b").is_finite(), "{method:?}");
    }
}

/// Twins begin with a method that could not solve the mutual gravity that is off.
#[test]
fn ghosts_begin_where_mutual_gravity_is_off() {
    let mut drive = Drive::shipped("figure_eight");
    drive.ticks(3);
    drive.session.stage.keep_timeline();
    let off = sandbox::SwitchedBy::Script;
    drive.session.stage.switch_effect(motion::effects::Effect::MutualGravity, false, off).unwrap();
    drive.give([Input::Change(scene::ChangeAction::SetMethod(Method::ImplicitEuler))]).ticks(3);
    drive.press("T").ticks(3).press(",").ticks(1);
    assert!(
        drive.session.tools.ghosts(&drive.session.stage).len() > 5
            && drive.session.stage.bundle(None).is_some()
    );
}

/// In a scene whose ticks are frames, a frame of no length is no tick and gives a twin no length to begin with.
#[test]
fn ghosts_begin_in_a_frame_of_no_length() {
    let text = "(version: 1, step: frame, bodies: [(name: \"a\", mass_kg: 1.0)])";
    let mut drive = Drive::text(text).recording();
    drive
        .give([])
        .press("T")
        .ticks(2)
        .give([])
        .press("T")
        .press("T")
        .press("R")
        .press(",")
        .ticks(2);
    assert!(drive.session.stage.bundle(None).is_some());
}

#[test]
fn a_fault_is_found_again_where_the_first_energy_is_no_number() {
    let text = "(version: 1, step_hz: 0.001, method: runge_kutta_4, substeps: 3,
        mutual_gravity: (constant_m3_kg_s2: 79.5, softening_m: 89.25),
        bodies: [(name: \"far\", position_m: (1e155, -74, -55), velocity_m_s: (67, 27, -38), mass_kg: 25),
                 (name: \"near\", position_m: (-75, 10, -37), velocity_m_s: (-12, 32, 0), mass_kg: 37)],
        springs: [(between: (\"near\", \"far\"), stiffness_n_m: 0, rest_length_m: 58)],
        emitters: [(rate_per_s: 60, speed_m_s: 5, life_s: 0.2, spread_deg: 20)])";
    let mut drive = Drive::text(text).recording();
    drive.run(4, 1000.0);
    let fault = drive.session.stage.recorder().fault().expect("it explodes").clone();
    let bundle = drive.session.stage.bundle(None).expect("a recorded run comes out the same");
    let again =
        Rerun::of(drive.session.stage.sim().scene.clone(), &bundle, TIMELINE_BYTES, &mut |_| ())
            .unwrap();
    assert!(again.faults.contains(&fault), "{fault:?} is not among {:?}", again.faults);
}

/// A quarantined body that gets another mass has not left its group, which does not restart.
#[test]
fn a_mass_for_a_quarantined_body_is_noticed_by_nobody() {
    let run = |asks: bool| {
        let (mut lab, bodies) = falling_pair([DVec3::X, DVec3::Z], 1.5);
        lab.run(5).push(bodies[0], DVec3::NAN).run(1);
        if asks {
            lab.ask(Request::SetInverseMass(bodies[0], 3.0));
            lab.ask(Request::SetPosition(bodies[0], DVec3::ZERO));
        }
        lab.run(5).bits(1)
    };
    assert_eq!(run(true), run(false));
}

/// A refused position does not restart the other bodies of a group of position Verlet.
#[test]
fn a_place_that_is_refused_is_noticed_by_nobody() {
    for refused in [DVec3::X * f64::INFINITY, DVec3::NAN] {
        let run = |request: fn(Entity, DVec3) -> Request| {
            let (mut lab, bodies) = falling_pair([DVec3::X, DVec3::Z], 1.5);
            lab.run(5).ask(request(bodies[0], refused));
            lab.run(5).bits(1)
        };
        let gone = run(|body, _| Request::Remove(body));
        assert_eq!(run(Request::SetPosition), gone);
        assert_eq!(run(|body, to| Request::SetInverseMass(body, to.x)), gone);
        assert_eq!(run(Request::SetVelocity), gone);
    }
}

/// A body that fails while its group restarts position Verlet is out of the group before the next tick.
#[test]
fn who_breaks_between_two_ticks_is_quarantined_there() {
    let mut lab = Lab::new(Method::PositionVerlet, H);
    let bodies = [DVec3::ZERO, DVec3::X * 1e12].map(|velocity| lab.body(1.0, velocity));
    lab.world.get_mut::<Transform>(bodies[1]).unwrap().position.x += 1.0;
    let rest_length = lab.x(bodies[0]).distance(lab.x(bodies[1]));
    lab.spring(bodies, elastic(1e300, rest_length));
    lab.recompile();
    let quarantined = |lab: &Lab| bodies.map(|body| lab.is_quarantined(body));
    lab.run(1);
    assert_eq!(quarantined(&lab), [false; 2]);
    lab.set_method(Method::ImplicitEuler);
    assert_ne!(quarantined(&lab), [false; 2]);
}

/// A body at rest keeps the zeros that a step would leave when velocities are reversed.
#[test]
fn rest_that_is_turned_round_has_no_sign() {
    let mut lab = Lab::new(Method::RungeKutta4, H);
    let bodies = [0.0, 1.0].map(|w| lab.body(w, DVec3::ZERO));
    for velocity in [DVec3::ZERO, DVec3::splat(-0.0)] {
        for body in bodies {
            lab.ask(Request::SetVelocity(body, velocity));
        }
        lab.run(2).ask(Request::ReverseVelocities).run(2);
        for body in bodies {
            assert_eq!(lab.v(body).to_array().map(f64::to_bits), [0; 3], "{velocity}");
        }
    }
}

/// Switching engines that only a quarantined body has restarts no body of position Verlet.
#[test]
fn what_only_a_quarantined_body_has_is_switched_and_noticed_by_nobody() {
    let text =
        "(version: 1, step_hz: 60, method: position_verlet, drag: (linear_per_s: 3.0, quadratic_per_m: 0.5),
        gravity: (acceleration_m_s2: (0, -9.8, 0), on_at_start: true),
        bodies: [(name: \"ship\", mass_kg: 1.0), (name: \"stone\", mass_kg: 1.0, velocity_m_s: (7, 3, 1))],
        thrusts: [(body: \"ship\", curve: polynomial([(1, 0, 0)]), from_s: 0.0, until_s: 9.0)])";
    let run = |quarantined: bool| {
        let mut drive = Drive::text(text);
        drive
            .ticks(3)
            .frame(H, [if quarantined { push("ship", [f64::NAN; 3]) } else { remove("ship") }]);
        let switched = drive.session.stage.switch_effect(
            motion::effects::Effect::Thrusts,
            false,
            sandbox::SwitchedBy::Script,
        );
        assert_eq!(switched.is_ok(), quarantined);
        drive.ticks(5);
        bits(drive.x("stone"), drive.v("stone"))
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_pointer_goes_to_the_end_of_the_world_and_back() {
    let mut drive = Drive::tutorial();
    drive.press("Q").press("H");
    for (x, notches) in [(1e300, 1e300), (-1e300, -1e300), (3e38, 4e38), (0.0, 0.0), (1e39, 1.0)] {
        let events = [Input::Mouse(x, -x), Input::Wheel(notches)];
        drive.frame(1.0 / 60.0, events).click(Button::Left, DVec2::new(x, 1e30)).ticks(3);
        drive.session.picture();
    }
    assert_eq!(drive.session.open_panels(), [Panel::Help]);
}

#[test]
fn a_study_of_the_shortest_ticks_is_begun() {
    let text = "(version: 1, step_hz: 1e300, bodies: [(name: \"a\", mass_kg: 1.0)])";
    let mut drive = Drive::text(text);
    drive.session.stage.playback_mut().limit_ticks(4);
    drive.press("C").frame(1.0 / 60.0, []);
    assert_eq!(drive.session.open_panels(), [Panel::Cost]);
}

/// Velocities that decay to next to nothing snap to zero at the same places in every kernel, also where damping acts on
/// one side of the move only.
#[test]
fn the_smallest_velocities_are_the_same_in_every_kernel() {
    let models =
        DampingModel::ALL.into_iter().flat_map(|model| [0.5, 33.0].map(|rate| (model, rate)));
    let cases = models.flat_map(|damping| [1, 3].map(|substeps| (damping, substeps)));
    for ((model, rate), substeps) in cases {
        for method in Method::ALL {
            let run = |joined: bool| {
                let around = Environment {
                    damping: Some(Damping { model, rate }),
                    substeps: Some(substeps),
                    ..Environment::pull(DVec3::new(1.0, 0.0, 1e-310))
                };
                let mut lab = around.lab(method, H);
                for _ in 0..5 {
                    lab.spawn(Start::of(1.0, DVec3::ZERO, DVec3::new(1e-289, 1e-310, 0.0)));
                }
                if joined {
                    lab.spring([0, 1], elastic(1.0, 0.0));
                    lab.push(1, DVec3::NAN);
                }
                lab.recompile();
                lab.run(1).bits(0)
            };
            assert_eq!(run(true), run(false), "{method:?}, {model:?} {rate}, {substeps} substeps");
        }
    }
}
