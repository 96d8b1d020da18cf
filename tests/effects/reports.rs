//! The receipt and the ablation of a scene, in the program and in the panel.

use lab::ReceiptLine;
use motion::effects::{Effect, EffectState};
use motion::{Gravity, Method};
use sandbox::{SwitchedBy, report};
use scene::Scene;
use serde_json::Value;

use crate::rigs::{Drive, folder, json, sandbox, scene_of};

const SCENE: &str = "(version: 1, step_hz: 100, method: runge_kutta_4, gravity: (), drag: (quadratic_per_m: 0.1),
    wells: [(strength_m3_s2: 3, softening_m: 1, bodies: [\"a\"])],
    bodies: [
        (name: \"floor\", shape: cuboid(half_extents_m: (9, 1, 9)), position_m: (0, -9, 0), immovable: true),
        (name: \"a\", position_m: (0, 3, 1)),
        (name: \"b\", shape: sphere(radius_m: 1), position_m: (4, 3, 1), velocity_m_s: (1, 2, 0), max_speed_m_s: 1000),
        (name: \"c\", position_m: (9, 3, 1), gravity_off: true),
    ])";

fn scene() -> Scene {
    Scene::parse("four", SCENE).unwrap()
}

fn row<'a>(rows: &'a [ReceiptLine], name: &str) -> &'a ReceiptLine {
    rows.iter().find(|row| row.name == name).unwrap()
}

#[test]
fn the_receipt_says_what_acts_on_how_many_bodies_and_why() {
    let receipt = lab::receipt(&scene(), 20, &[]);
    assert_eq!(
        (receipt.scene.as_str(), receipt.method, receipt.ticks),
        ("four", Method::RungeKutta4, 20)
    );
    let names: Vec<_> = receipt.rows.iter().filter_map(|row| row.effect).collect();
    assert_eq!(names, Effect::ALL);
    for (name, bodies, evaluations) in
        [("gravity", 2, 8.0), ("drag", 3, 12.0), ("wells", 1, 4.0), ("speed_limits", 1, 0.0)]
    {
        let row = row(&receipt.rows, name);
        assert_eq!(row.state, EffectState::On, "{name}");
        assert_eq!((row.bodies, row.evaluations), (bodies, evaluations), "{name}");
        assert!(
            row.bytes > 0 && row.ns.is_some() && row.share.is_some() && row.because.is_some(),
            "{name}"
        );
    }
    let limits = row(&receipt.rows, "speed_limits");
    assert_eq!(limits.because.as_deref(), Some("bodies[2].max_speed_m_s, line 6"));
    for name in
        ["damping", "thrusts", "springs", "mutual_gravity", "axis_locks", "emitters", "wind"]
    {
        let row = row(&receipt.rows, name);
        let expected = ReceiptLine {
            effect: row.effect,
            ns: Some(0.0),
            share: Some(0.0),
            ..ReceiptLine::of(row.name, EffectState::NotDeclared)
        };
        assert_eq!(*row, expected);
    }
}

#[test]
fn the_ablation_of_the_scene_of_everything_names_what_it_does_not_need() {
    let ablation = lab::ablate(&scene::load("everything").unwrap(), 60);
    let needed: Vec<_> = ablation.rows.iter().map(|row| (row.effect, row.needed())).collect();
    // The limit of a speed that is not reached.
    for (effect, needed) in &needed {
        assert_eq!(*needed, *effect != Effect::SpeedLimits, "{effect}: {needed}");
    }
    assert_eq!(needed.len(), Effect::ALL.len(), "every effect is declared: {needed:?}");
}

#[test]
fn the_receipt_has_what_methods_keep() {
    for (method, name) in [
        ("implicit_euler", "implicit_solver"),
        ("position_verlet", "verlet_state"),
        ("velocity_verlet", "kept_accelerations"),
    ] {
        let text = SCENE.replace("runge_kutta_4", method);
        let receipt = lab::receipt(&scene_of(&text), 5, &[]);
        for known in ["implicit_solver", "verlet_state", "kept_accelerations"] {
            let row = row(&receipt.rows, known);
            // Of velocity Verlet only the body with a well of its own keeps an acceleration.
            let bodies = if known != name {
                0
            } else if name == "kept_accelerations" {
                1
            } else {
                3
            };
            assert_eq!(row.bodies, bodies, "{known} under {method}");
            assert_eq!(row.bytes > 0, bodies > 0 && known != "implicit_solver");
            assert_eq!(row.evaluations > 0.0, bodies > 0 && known == "implicit_solver", "{known}");
        }
    }
}

#[test]
fn the_ablation_names_the_effect_that_is_not_needed() {
    let ablation = lab::ablate(&scene(), 50);
    let effects: Vec<_> = ablation.rows.iter().map(|row| row.effect).collect();
    assert_eq!(effects, [Effect::Gravity, Effect::Drag, Effect::Wells, Effect::SpeedLimits]);
    for row in &ablation.rows {
        // Nothing here is as fast as a kilometer a second.
        let needed = row.effect != Effect::SpeedLimits;
        assert_eq!((row.needed(), row.identical), (needed, !needed), "{}", row.effect);
        assert_eq!(row.max_distance > 0.0, needed);
        assert!(row.rms_distance <= row.max_distance);
    }
    // A fall of half a second.
    let gravity = &ablation.rows[0];
    assert!((0.5..1.3).contains(&gravity.max_distance), "{}", gravity.max_distance);
    assert_eq!(gravity.evaluations_saved, 8.0);
}

#[test]
fn an_effect_that_has_changed_velocities_alone_is_needed() {
    // The first step of explicit Euler moves every body by the velocity that it had.
    let text = "(version: 1, method: explicit_euler, gravity: (), drag: (linear_per_s: 1),
        bodies: [(name: \"a\", velocity_m_s: (1, 0, 0)), (name: \"b\", max_speed_m_s: 9)])";
    let ablation = lab::ablate(&scene_of(text), 1);
    let rows =
        ablation.rows.iter().map(|row| (row.effect, row.identical, row.needed(), row.max_distance));
    let expected = [(Effect::Gravity, false), (Effect::Drag, false), (Effect::SpeedLimits, true)];
    assert_eq!(rows.collect::<Vec<_>>(), expected.map(|(effect, same)| (effect, same, !same, 0.0)));
}

#[test]
fn the_program_prints_the_receipt_and_the_ablation_as_tables_and_as_json() {
    let folder = folder([("four.ron", SCENE)]);
    for command in ["effects", "ablate --no-pictures"] {
        let line = format!("{command} four.ron --ticks 10");
        let table = sandbox(&folder, &line).fine();
        let json: Value =
            serde_json::from_str(&sandbox(&folder, &format!("{line} --format json")).fine())
                .unwrap();
        let rows = json["effects"].as_array().unwrap();
        assert_eq!(table.lines().count(), rows.len() + 2, "{table}");
        for (row, line) in rows.iter().zip(table.lines().skip(2)) {
            assert!(line.starts_with(row["effect"].as_str().unwrap()), "{line}");
        }
        assert_eq!((json["scene"].as_str(), json["ticks"].as_u64()), (Some("four"), Some(10)));
    }
    let table = sandbox(&folder, "ablate four.ron --ticks 10 --no-pictures").fine();
    let not_needed: Vec<_> = table.lines().filter(|line| line.ends_with("not needed")).collect();
    assert!(not_needed.len() == 1 && not_needed[0].starts_with("speed_limits"), "{table}");
}

#[test]
fn a_run_without_an_effect_is_that_of_a_scene_without_it() {
    let folder = folder([("four.ron", SCENE)]);
    std::fs::write(
        folder.path().join("three.ron"),
        SCENE.replace(", drag: (quadratic_per_m: 0.1)", ""),
    )
    .unwrap();
    let run = |line: &str| {
        sandbox(&folder, &format!("run {line} --ticks 50 --summary out.json")).fine();
        json(folder.path().join("out.json"))
    };
    let (with, without, never) =
        (run("four.ron"), run("four.ron --without drag"), run("three.ron"));
    assert_eq!(without["state_hash"], never["state_hash"]);
    assert_ne!(without["state_hash"], with["state_hash"]);
    assert_eq!(without["laws"], never["laws"]);
    assert_eq!(
        (without["laws"]["drag"].as_u64(), without["laws"]["thrusts"].as_u64()),
        (Some(0), Some(0))
    );
}

#[test]
fn the_panel_switches_says_by_whom_and_keeps_off_what_is_off_over_a_reset() {
    let mut drive = Drive::of(scene());
    drive.press("E").ticks(3);
    let because = |drive: &mut Drive, name: &str| {
        row(&drive.session.tools.receipt(&drive.session.stage, &drive.session.view), name)
            .because
            .clone()
            .unwrap()
    };
    assert_eq!(because(&mut drive, "drag"), "drag, line 1");
    drive.press("G");
    drive.session.stage.switch_effect(Effect::Drag, false, SwitchedBy::Panel).unwrap();
    drive.session.stage.switch_effect(Effect::SpeedLimits, false, SwitchedBy::Script).unwrap();
    for (name, by) in [
        ("gravity", "switched by G"),
        ("drag", "switched in the panel"),
        ("speed_limits", "switched by script"),
    ] {
        assert_eq!(because(&mut drive, name), by);
    }
    assert!(drive.session.stage.switch_effect(Effect::Thrusts, true, SwitchedBy::Panel).is_err());
    drive.press("F1").ticks(2);
    let states = |drive: &mut Drive| {
        Effect::ALL.map(|effect| motion::effects::state(&drive.session.stage.sim().world, effect))
    };
    let off = states(&mut drive).iter().filter(|state| **state == EffectState::Off).count();
    assert_eq!(off, 3);
    assert!(!drive.session.stage.sim().world.resource::<Gravity>().on);
    drive.session.stage.switch_effect(Effect::Drag, true, SwitchedBy::Panel).unwrap();
    drive.ticks(5);
    assert_eq!(
        row(&drive.session.tools.receipt(&drive.session.stage, &drive.session.view), "drag")
            .evaluations,
        12.0
    );
    assert_ne!(report::state_hash(&drive.session.stage), 0);
}

#[test]
fn a_session_with_pictures_lists_what_pictures_need() {
    let mut drive = Drive::of(scene());
    drive.press("1").ticks(2);
    let rows = drive.session.tools.receipt(&drive.session.stage, &drive.session.view);
    let names: Vec<_> = rows.iter().skip(Effect::ALL.len() + 3).map(|row| row.name).collect();
    assert_eq!(
        names,
        ["interpolation", "picking", "shadows", "arrows", "timeline", "swarms", "energy_watch"]
    );
    assert_eq!(row(&rows, "interpolation").bodies, 3);
    assert_eq!((row(&rows, "arrows").state, row(&rows, "arrows").bodies), (EffectState::On, 3));
    let state =
        |rows: &[ReceiptLine]| ["timeline", "energy_watch"].map(|name| row(rows, name).state);
    assert_eq!(state(&rows), [EffectState::Off; 2]);
    drive.session.stage.keep_timeline();
    let rows = drive.session.tools.receipt(&drive.session.stage, &drive.session.view);
    assert_eq!(state(&rows), [EffectState::On; 2]);
    let watch = row(&rows, "energy_watch");
    assert!(watch.bodies == 3 && watch.bytes > 0 && watch.ns.is_none(), "{watch:?}");
}

#[test]
fn what_watching_energy_costs_is_measured() {
    let report = sandbox(".", "effects tutorial --ticks 60 --format json").fine();
    let report: Value = serde_json::from_str(&report).unwrap();
    let rows = report["effects"].as_array().unwrap();
    let row = rows.iter().find(|row| row["effect"] == "energy_watch").unwrap();
    assert_eq!(row["state"], "on");
    assert!(row["ns_per_step"].is_number() && row["share"].is_number(), "{row}");
    let timeline = rows.iter().find(|row| row["effect"] == "timeline").unwrap();
    assert!(timeline["state"] == "on" && timeline["ns_per_step"].is_null(), "{timeline}");
}
