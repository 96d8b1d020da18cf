//! Ghosts: twins by every method, which have the bits of runs of their own.

mod pictures;
mod twins;
mod unsolvable;

use glam::DVec3;
use history::{Distances, Simulation};
use motion::effects::Effect;
use motion::{Method, PhysicsBody, Quarantined};
use sandbox::input::Input;
use sandbox::{GhostRow, GhostState};
use scene::{ChangeAction, Scene};

use crate::rigs::{Drive, H, change, mixed, own_method, push, remove, scene_of, tap};

/// A run of `scene` by one method, for every body of it.
fn alone(mut scene: Scene, method: Method, substeps: Option<u32>) -> Drive {
    scene.method = method;
    scene.bodies.iter_mut().for_each(|body| body.method = None);
    if let Some(substeps) = substeps {
        scene.substeps = substeps.into();
        scene.bodies.iter_mut().for_each(|body| body.substeps = None);
    }
    Drive::of(scene)
}

fn reference(scene: Scene) -> Drive {
    alone(scene, Method::RungeKutta4, Some(16))
}

/// Distances of bodies that move in both runs, in the order of ids.
fn distances(a: &Drive, b: &Drive) -> Vec<f64> {
    let moving = |drive: &Drive, name: &str| {
        let body = drive.session.stage.sim().named(name)?;
        let world = &drive.session.stage.sim().world;
        let moves = world.get::<PhysicsBody>(body).is_some_and(|state| state.inverse_mass > 0.0);
        let there = world.get::<Quarantined>(body).is_none()
            && world.get::<motion::Dormant>(body).is_none();
        (moves && there).then(|| drive.x(name))
    };
    let names: Vec<_> =
        a.session.stage.sim().scene.names.iter().map(|name| name.into_owned()).collect();
    names.iter().filter_map(|name| Some((moving(a, name)? - moving(b, name)?).length())).collect()
}

fn row(drive: &Drive, method: Method) -> GhostRow {
    drive
        .session
        .tools
        .ghosts(&drive.session.stage)
        .into_iter()
        .find(|row| row.method == Some(method))
        .unwrap()
}

/// Fails unless the row tells the distances between two runs, bit for bit.
#[track_caller]
fn assert_tells(drive: &Drive, method: Method, alone: &Drive, reference: &Drive) {
    let each = distances(alone, reference);
    assert!(!each.is_empty());
    let row = row(drive, method);
    assert_eq!(row.distance, each.iter().copied().reduce(f64::max), "{method:?}");
}

/// Inputs of frame number `frame`: pushes, held keys aside, and every kind of change.
fn inputs(frame: u32) -> Vec<Input> {
    let switch = |effect, on| Input::Change(ChangeAction::SwitchEffect(effect, on));
    match frame {
        3 => vec![push("ball", [50.0, -20.0, 5.0]), push("second", [0.0, 90.0, 0.0])],
        9 => vec![
            change("first", ChangeAction::Impulse, [1.0, 2.0, 3.0]),
            push("ball", [9.0, 0.0, 0.0]),
        ],
        14 => tap("G").to_vec(),
        20 => vec![change("dust", ChangeAction::SetVelocity, [0.0, 4.0, 1.0])],
        24 => vec![switch(Effect::Drag, false), push("box", [0.0, 0.0, 40.0])],
        30 => vec![Input::Change(ChangeAction::SetGravity(DVec3::new(0.5, -5.0, 0.0)))],
        33 => vec![remove("spare"), change("box", ChangeAction::SetPosition, [2.0, 2.0, 2.0])],
        36 => vec![Input::Change(ChangeAction::SetDamping(0.5)), switch(Effect::Drag, true)],
        40 => vec![Input::Change(ChangeAction::ReverseVelocities)],
        44 => vec![own_method("ball", Method::ExplicitEuler)],
        50 => vec![switch(Effect::Springs, false)],
        55 => vec![switch(Effect::Springs, true), switch(Effect::Emitters, false)],
        _ => Vec::new(),
    }
}

/// The same without what a twin ignores.
fn inputs_of_runs(frame: u32) -> Vec<Input> {
    let of_one = |input: &Input| matches!(input, Input::Change(ChangeAction::SetBodyMethod(..)));
    inputs(frame).into_iter().filter(|input| !of_one(input)).collect()
}

#[test]
fn distances_are_those_between_runs_of_their_own_bit_for_bit() {
    let mut drive = Drive::of(mixed());
    drive.press("T");
    let mut runs: Vec<_> =
        Method::ALL.map(|method| alone(mixed(), method, None)).into_iter().collect();
    let mut reference = reference(mixed());
    for frame in 0..70 {
        // Frames of no, one and several ticks.
        let length = [0.0, 1.0, 0.5, 3.0][frame as usize % 4] / 60.0;
        drive.frame(length, inputs(frame));
        for run in runs.iter_mut().chain([&mut reference]) {
            run.frame(length, inputs_of_runs(frame));
        }
        for (method, run) in Method::ALL.into_iter().zip(&runs) {
            // The body with a method of its own is solid, and no ghost.
            if method != Method::SemiImplicitEuler || frame < 44 {
                assert_tells(&drive, method, run, &reference);
            }
        }
    }
    let far = |method| row(&drive, method).distance.unwrap();
    assert!(far(Method::ExplicitEuler) > 10.0 * far(Method::RungeKutta4));
}

#[test]
fn the_row_of_a_method_keeps_no_error_that_another_one_made() {
    let mut drive = Drive::of(mixed());
    drive.press("T");
    let set = |method| Input::Change(ChangeAction::SetMethod(method));
    let mixed_row = |drive: &Drive| {
        let rows = drive.session.tools.ghosts(&drive.session.stage);
        rows.into_iter().find(|row| row.state == GhostState::Mixed)
    };
    drive.ticks(5);
    assert_eq!(mixed_row(&drive), None, "the solid bodies are where their method has them");
    drive
        .frame(H, [set(Method::ExplicitEuler)])
        .ticks(60)
        .frame(H, [set(Method::RungeKutta4)])
        .ticks(60);
    let (mut run, mut reference) = (alone(mixed(), Method::RungeKutta4, None), reference(mixed()));
    // As many frames.
    for other in [&mut run, &mut reference] {
        other.ticks(5 + 1 + 60 + 1 + 60);
    }
    let of_method = row(&drive, Method::RungeKutta4);
    assert_eq!(of_method.state, GhostState::Solid);
    assert_tells(&drive, Method::RungeKutta4, &run, &reference);
    let solid = mixed_row(&drive).expect("several methods moved the solid bodies");
    assert_eq!(solid.distance, distances(&drive, &reference).into_iter().reduce(f64::max));
    assert!(solid.largest.unwrap() > 100.0 * of_method.largest.unwrap(), "{solid:?} {of_method:?}");
}

#[test]
fn shipped_scenes_have_the_distances_of_runs_of_their_own() {
    // One step a frame; methods of single bodies; a previous position; soft bodies; a method that is not the first.
    for name in ["frame_step", "orbits_race", "verlet_start", "rope", "third_law"] {
        let scene = scene::load(name).unwrap();
        let mut drive = Drive::of(scene.clone());
        drive.press("T");
        let mut reference = reference(scene.clone());
        let length = |frame: u32| f64::from(1 + frame % 3) / 100.0;
        for frame in 0..40 {
            reference.frame(length(frame), []);
        }
        for frame in 0..40 {
            drive.frame(length(frame), []);
        }
        for method in Method::ALL {
            if drive.session.stage.sim().stepper.method() == method && name == "orbits_race" {
                continue;
            }
            let mut run = alone(scene.clone(), method, None);
            for frame in 0..40 {
                run.frame(length(frame), []);
            }
            assert_tells(&drive, method, &run, &reference);
        }
    }
}

#[test]
fn a_held_key_pushes_ghosts_too_and_what_is_told_is_the_selection() {
    let pushed = |mut drive: Drive| {
        drive.press("Q").ticks(4);
        let ball = drive.pixel(drive.x("ball"));
        assert_eq!(drive.select(ball).as_deref(), Some("ball"));
        drive.give([crate::rigs::down("Up")]).ticks(60).give([crate::rigs::up("Up")]).ticks(9);
        drive
    };
    let mut drive = Drive::of(mixed());
    drive.press("T");
    let (drive, reference) = (pushed(drive), pushed(reference(mixed())));
    assert!(drive.x("ball").z < -1.0, "it was pushed");
    for method in [Method::ExplicitEuler, Method::PositionVerlet, Method::RungeKutta4] {
        let alone = pushed(alone(mixed(), method, None));
        let distance = (alone.x("ball") - reference.x("ball")).length();
        assert_eq!(row(&drive, method).distance, Some(distance), "{method:?}");
    }
}

#[test]
fn the_largest_distance_and_the_mean_are_of_all_ticks() {
    // A swinging weight: its errors come and go.
    let scene = || {
        scene_of(
            r#"(version: 1, step_hz: 40, method: semi_implicit_euler, bodies: [
                (name: "post", position_m: (0, 0, 0), immovable: true),
                (name: "weight", shape: sphere(radius_m: 0.5), position_m: (2, 0, -9)),
             ], springs: [(between: ("post", "weight"), stiffness_n_m: 90, rest_length_m: 8)])"#,
        )
    };
    let mut drive = Drive::of(scene());
    // Several ticks a frame: those in between count, too.
    drive.press("T").run(60, 0.1);
    assert!(drive.session.stage.sim().ticks() > 200);
    let run = |method, substeps: u32| {
        Simulation::new(Scene { method, substeps: substeps.into(), ..scene() })
    };
    let mut nearer_now = 0;
    for method in Method::ALL {
        let (mut run, mut reference) = (run(method, 1), run(Method::RungeKutta4, 16));
        let (mut largest, mut squares, mut last) = (0.0, 0.0, 0.0);
        for _ in 0..drive.session.stage.sim().ticks() {
            run.tick();
            reference.tick();
            last = Distances::between(&run, &reference).each[0].1;
            (largest, squares) = (f64::max(largest, last), squares + last * last);
        }
        let row = row(&drive, method);
        assert_eq!((row.distance, row.largest), (Some(last), Some(largest)), "{method:?}");
        // At the start there is none.
        let mean = squares / (drive.session.stage.sim().ticks() + 1) as f64;
        assert!((row.rms.unwrap() / mean.sqrt() - 1.0).abs() < 1e-9, "{method:?}");
        nearer_now += usize::from(last < 0.5 * largest);
    }
    assert!(nearer_now > 2, "{nearer_now}");
}

#[test]
fn started_in_the_middle_all_are_where_the_solid_bodies_are() {
    for method in Method::ALL {
        let mut scene = mixed();
        scene.method = method;
        let mut drive = Drive::of(scene);
        for frame in 0..30 {
            drive.frame(H, inputs(frame));
        }
        drive.press("T");
        for row in drive.session.tools.ghosts(&drive.session.stage) {
            let expected = row.method.map(|_| 0.0);
            assert_eq!(
                [row.distance, row.largest, row.rms],
                [expected; 3],
                "{row:?} after {method:?}"
            );
        }
        drive.ticks(30);
        assert!(row(&drive, Method::ExplicitEuler).distance.unwrap() > 0.0);
    }
}

#[test]
fn ghosts_change_nothing_of_the_run_and_leave_nothing_behind() {
    let mut plain = Drive::of(mixed());
    let mut drive = Drive::of(mixed());
    let empty = plain.session.picture();
    for frame in 0..60 {
        plain.frame(H, inputs(frame));
        if frame == 5 || frame == 48 {
            drive.press("T");
        }
        drive.frame(H, inputs(frame));
        assert_eq!(drive.hash(), plain.hash());
        assert_eq!(
            drive.session.tools.ghosts(&drive.session.stage).is_empty(),
            !(5..48).contains(&frame)
        );
    }
    assert_eq!(
        drive.session.stage.sim().evaluations().laws(),
        plain.session.stage.sim().evaluations().laws()
    );
    let (with, without) = (drive.session.picture(), plain.session.picture());
    assert!(empty.translucent.is_empty() && with.translucent.is_empty());
    assert_eq!((with.spheres, with.cuboids), (without.spheres, without.cuboids));
    assert_eq!((with.lines, with.particles), (without.lines, without.particles));
}

/// A spring that is far too stiff for a tick of most methods, not for a sixteenth of one.
fn stiff(method: &str) -> Scene {
    let text = format!(
        r#"(version: 1, step_hz: 10, method: {method}, bodies: [
            (name: "post", position_m: (0, 0, 0), immovable: true),
            (name: "weight", shape: sphere(radius_m: 0.5), position_m: (2, 0, -9)),
            (name: "free", shape: sphere(radius_m: 0.5), position_m: (-2, 0, -9), velocity_m_s: (0, 0.1, 0)),
         ], springs: [(between: ("post", "weight"), stiffness_n_m: 10000)])"#
    );
    scene_of(&text)
}

#[test]
fn a_ghost_that_is_quarantined_is_named_with_its_time_and_the_others_go_on() {
    let mut drive = Drive::of(stiff("implicit_euler"));
    drive.press("T").run(700, 0.1);
    for method in Method::ALL {
        let row = row(&drive, method);
        if method == Method::ImplicitEuler {
            assert_eq!(row.state, GhostState::Solid);
            assert!(row.distance.is_some_and(|distance| distance > 0.0 && distance < 100.0));
            continue;
        }
        let mut run = alone(stiff(method.name()), method, None);
        run.run(700, 0.1);
        let record = &run.session.stage.quarantines().so_far()[0];
        let seconds = record.tick as f64 / run.session.stage.sim().scene.step_hz;
        let words = format!("{} was quarantined at {seconds:.2} s: {}", record.body, record.what);
        assert_eq!(row.state, GhostState::Failed(words), "{method:?}");
        assert_eq!([row.distance, row.largest, row.rms], [None; 3]);
    }
    assert_eq!(
        drive.session.tools.ghosts(&drive.session.stage).last().unwrap().state,
        GhostState::Runs
    );
    // The reference alone is drawn: two balls.
    assert_eq!(drive.session.picture().translucent.spheres.len(), 2);
    assert!(drive.session.stage.quarantines().so_far().is_empty());
}

#[test]
fn without_the_reference_there_are_no_distances() {
    let mut drive = Drive::of(mixed());
    drive.press("T").ticks(3).frame(H, [push("ball", [f64::NAN; 3])]).ticks(2);
    let rows = drive.session.tools.ghosts(&drive.session.stage);
    assert!(matches!(rows.last().unwrap().state, GhostState::Failed(_)));
    assert!(
        rows.iter().all(|row| row.distance.is_none() && row.largest.is_none() && row.rms.is_none())
    );
    assert!(drive.session.picture().translucent.is_empty());
}

#[test]
fn a_method_that_cannot_solve_the_scene_is_listed_as_such() {
    let mut drive = Drive::shipped("figure_eight");
    drive.press("T").ticks(20);
    for row in drive.session.tools.ghosts(&drive.session.stage) {
        let cannot = matches!(row.state, GhostState::Unsolvable(_));
        assert_eq!(cannot, row.method == Some(Method::ImplicitEuler), "{row:?}");
        assert_eq!(row.distance.is_some(), !cannot && row.method.is_some());
    }
    // Eight methods, one of them solid, and the reference: eight times three bodies.
    assert_eq!(drive.session.picture().translucent.spheres.len(), 24);
}

#[test]
fn the_next_method_becomes_solid_and_the_last_one_a_ghost_again() {
    let mut drive = Drive::of(mixed());
    let solid = |drive: &Drive| {
        let rows = drive.session.tools.ghosts(&drive.session.stage);
        rows.iter().find(|row| row.state == GhostState::Solid).and_then(|row| row.method)
    };
    assert_eq!(
        drive.press("Shift+T").session.stage.sim().stepper.method(),
        Method::SemiImplicitEuler
    );
    drive.press("T").ticks(5);
    assert_eq!(solid(&drive), Some(Method::SemiImplicitEuler));
    let before = row(&drive, Method::SemiImplicitEuler).distance;
    drive.press("Shift+T");
    assert_eq!(drive.session.stage.sim().stepper.method(), Method::ImplicitEuler);
    assert_eq!(solid(&drive), Some(Method::ImplicitEuler));
    // Its twin is where the solid bodies were.
    assert_eq!(row(&drive, Method::SemiImplicitEuler).distance, before);
    assert_eq!(drive.session.picture().translucent.spheres.len(), 9 * 3);
}

#[test]
fn a_reset_restarts_ghosts_and_another_scene_has_none() {
    let mut drive = Drive::of(mixed());
    drive.press("G").press("T").ticks(30).press("F1").ticks(20);
    let mut fresh = Drive::of(mixed());
    fresh.press("G").press("T").ticks(20);
    for method in Method::ALL {
        let [again, first] = [&drive, &fresh].map(|drive| row(drive, method).distance.unwrap());
        // The time of the scene is a difference after a reset, and rounded.
        assert!(first > 0.0 && (again - first).abs() < 1e-9, "{method:?}: {again} m and {first} m");
    }
    drive.session.open(mixed());
    drive.ticks(2);
    assert!(drive.session.tools.ghosts(&drive.session.stage).is_empty());
    assert_eq!(drive.session.open_panels(), [], "no panel is left open");
}

#[test]
fn pause_single_steps_and_slow_motion_keep_ghosts_in_step() {
    let mut drive = Drive::of(mixed());
    drive
        .press("T")
        .ticks(10)
        .press("P")
        .ticks(10)
        .press(".")
        .press(".")
        .press("P")
        .press("-")
        .ticks(40);
    let ticks = u32::try_from(drive.session.stage.sim().ticks()).unwrap();
    let (mut run, mut reference) =
        (alone(mixed(), Method::VelocityVerlet, None), reference(mixed()));
    for other in [&mut run, &mut reference] {
        other.frames(ticks);
        assert_eq!(other.session.stage.sim().ticks(), u64::from(ticks));
    }
    assert_tells(&drive, Method::VelocityVerlet, &run, &reference);
}

#[test]
fn too_many_bodies_have_no_ghosts() {
    for (count, rows) in [(10_000, Method::ALL.len() + 1), (10_001, 0)] {
        let text = format!("(version: 1, clouds: [(count: {count}, half_extents_m: (1, 1, 1))])");
        let mut drive = Drive::text(&text);
        drive.press("T");
        assert_eq!(drive.session.tools.ghosts(&drive.session.stage).len(), rows, "{count} bodies");
    }
}
