//! Scripts: the same inputs as a person's, and experiments.

use glam::DVec3;
use motion::{Damping, DampingModel, ForceCause, Gravity, Method};
use sandbox::Mode;
use sandbox::input::{Button, Input, InputFrame};
use sandbox::player::Player;
use scene::{Script, When};

use crate::rigs::{Drive, H, at, change, click, down, remove, tap, up};

/// Reads `script` as the program does: every body has to be one of the session's, every key one of the table's.
fn read(drive: &Drive, script: &str) -> Result<Script, scene::SceneError> {
    let read = Script::parse("test", script)?;
    let is_key = |word: &str| sandbox::actions::key_of_word(word).is_ok();
    let is_request = |_: &str| true;
    read.check("test", script, &drive.session.stage.sim().scene, is_key, is_request, |_| false)?;
    Ok(read)
}

/// Plays `script` on `drive` for `frames` frames of 1/60 s.
fn play(drive: &mut Drive, script: &str, frames: u32) {
    let script = read(drive, script).unwrap();
    drive.session.play(Player::new(script).unwrap());
    for frame in 1..=frames {
        let time = drive.clock.advance_to(f64::from(frame) / 60.0).unwrap();
        drive.session.advance(&InputFrame::NOTHING, time);
    }
    assert!(drive.session.player().is_some_and(Player::finished));
}

/// The tutorial after the script.
fn played(script: &str, frames: u32) -> Drive {
    let mut drive = Drive::tutorial();
    play(&mut drive, script, frames);
    drive
}

#[test]
fn a_script_and_the_same_inputs_by_hand_end_in_the_same_state() {
    let mut hand = Drive::tutorial();
    let player = hand.pixel(hand.x("player")).round();
    let script = format!(
        r#"[
            (at_s: 0, do: press("Q")),
            (at_s: 0.1, do: move_mouse({x}, {y})), (at_s: 0.1, do: click(left)),
            (at_s: 0.2, do: wheel(3)), (at_s: 0.2, do: click(right)),
            (at_frame: 30, do: press("toggle_gravity")),
            (at_tick: 80, do: hold("Right", 0.25)),
            (at_frame: 60, do: mouse_down(left)), (at_frame: 61, do: mouse_up(left)),
            (at_frame: 70, do: press("F1")),
            (at_frame: 71, do: impulse("enemy", (1, 0, 0))),
        ]"#,
        x = player.x,
        y = player.y
    );
    let drive = played(&script, 90);
    for frame in 0..90_u32 {
        let time = hand.clock.advance_to(f64::from(frame + 1) / 60.0).unwrap();
        let events: Vec<Input> = match frame {
            0 => tap("Q").to_vec(),
            // A frame ends at 0.1 s, a sixtieth after it began.
            5 => [at(player)].into_iter().chain(click(Button::Left)).collect(),
            11 => [Input::Wheel(3.0)].into_iter().chain(click(Button::Right)).collect(),
            30 => tap("G").to_vec(),
            40 => vec![down("Right")],
            55 => vec![up("Right")],
            60 => click(Button::Left).to_vec(),
            70 => tap("F1").to_vec(),
            71 => vec![change("enemy", scene::ChangeAction::Impulse, [1.0, 0.0, 0.0])],
            _ => Vec::new(),
        };
        hand.session.advance(&events.into_iter().collect(), time);
    }
    assert_eq!(drive.hash(), hand.hash());
    assert_eq!(
        (drive.session.view.mode(), drive.session.view.click_force()),
        (Mode::Selection, 310.0)
    );
    assert!(drive.v("enemy").x > 0.0 && drive.v("player").y < 0.0);
}

/// Experiments with the times at which a script has them, and the ticks that they belong to.
const EXPERIMENTS: [(&str, u32, &str); 11] = [
    ("at_s: 0.05", 6, "set_velocity(\"player\", (1, 2, 3))"),
    ("at_s: 0.05", 6, "impulse(\"player\", (0, 4, 0))"),
    ("at_tick: 7", 7, "push(\"enemy\", (30, 0, 0))"),
    ("at_s: 0.1234", 15, "set_gravity((0, -1.6, 0))"),
    ("at_s: 0.2", 24, "switch_effect(\"gravity\", true)"),
    ("at_tick: 33", 33, "set_method(explicit_euler)"),
    ("at_tick: 35", 35, "set_body_method(\"bonus\", runge_kutta_4)"),
    ("at_s: 0.30", 36, "set_damping(2)"),
    ("at_tick: 45", 45, "reverse_velocities"),
    ("at_tick: 50", 50, "remove(\"grid.x0.z0\")"),
    ("at_s: 0.45", 54, "set_position(\"bonus\", (7, 8, 9))"),
];

#[test]
fn experiments_act_in_the_tick_of_their_time_whatever_the_frames_are() {
    const TICKS: u64 = 60;
    let played = |steps: &dyn Fn(&(&str, u32, &str)) -> String, fps: f64| {
        let mut drive = Drive::tutorial();
        let script = format!("[{}]", EXPERIMENTS.iter().map(steps).collect::<String>());
        drive.session.play(Player::new(read(&drive, &script).unwrap()).unwrap());
        drive.session.stage.playback_mut().limit_ticks(TICKS);
        let (mut hashes, mut frame) = (Vec::new(), 0.0);
        while drive.session.stage.sim().ticks() < TICKS {
            let time = drive.clock.advance_to(frame / fps).unwrap();
            drive.session.advance_watched(&InputFrame::NOTHING, time, &mut |session, _| {
                hashes.push(sandbox::report::state_hash(session));
                std::ops::ControlFlow::Continue(())
            });
            frame += 1.0;
        }
        assert!(drive.session.player().is_some_and(Player::finished));
        hashes
    };
    // Frames of a tick each, of which the first is empty: there is no time between them.
    let by_frames =
        |(_, tick, action): &(&str, u32, &str)| format!("(at_frame: {}, do: {action}),", tick + 1);
    let expected = played(&by_frames, 1.0 / H);
    let by_times = |(when, _, action): &(&str, u32, &str)| format!("({when}, do: {action}),");
    for fps in [24.0, 30.0, 59.0, 144.0] {
        assert!(played(&by_times, fps) == expected, "{fps} frames a second");
    }
}

#[test]
fn a_key_that_is_held_twice_in_a_row_is_held_for_both_times() {
    // Of the frames of 0.07 s the second hold begins before the first is over.
    for fps in [1.0 / 0.07, 24.0, 60.0, 144.0] {
        let held = |script: &str| {
            let mut player = Player::new(Script::parse("test", script).unwrap()).unwrap();
            let mut is_down = false;
            let mut in_frame = |frame: u32| {
                let ends = [f64::from(frame) - 1.0, f64::from(frame)].map(|frame| frame / fps);
                for event in player.of_frame(u64::from(frame), 0, ends[0], ends[1]) {
                    match event {
                        Input::KeyDownUntil(..) => is_down = true,
                        Input::KeyUp(_) => is_down = false,
                        _ => {}
                    }
                }
                is_down
            };
            (0..200).map(&mut in_frame).collect::<Vec<_>>()
        };
        let twice =
            held(r#"[(at_s: 0.1, do: hold("Right", 0.5)), (at_s: 0.6, do: hold("Right", 0.5))]"#);
        let once = held(r#"[(at_s: 0.1, do: hold("Right", 1.0))]"#);
        assert!(once.contains(&true) && !once[199]);
        assert_eq!(twice, once, "{fps} frames a second");
    }
}

#[test]
fn keys_of_a_recording_push_by_their_times_and_those_of_an_older_one_in_whole_frames() {
    let ball = "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 0, -10), mass_kg: 1)";
    // From 0.31 s to 0.57 s 31 ticks of 1/120 s end; frames of 0.05 s have 6 ticks.
    for (version, times, ticks) in [
        (2, ["(at_frame: 7, do: at(0.31)),", "(at_frame: 12, do: at(0.57)),"], 31.0),
        (1, [""; 2], 30.0),
    ] {
        let mut drive = Drive::bodies(ball);
        let at = drive.pixel(drive.x("ball"));
        let ends: Vec<_> = (0..20).map(|frame| 0.05 * f64::from(frame)).collect();
        let script = format!(
            "(version: {version}, scene: \"bodies\", size_px: (1280, 720), frame_ends_s: {ends:?}, steps: [
                (at_frame: 0, do: key_down(\"Q\")), (at_frame: 1, do: key_up(\"Q\")), (at_frame: 1, do: move_mouse({}, {})),
                (at_frame: 1, do: mouse_down(left)), (at_frame: 2, do: mouse_up(left)),
                {} (at_frame: 7, do: key_down(\"Right\")), {} (at_frame: 12, do: key_up(\"Right\"))])",
            at.x, at.y, times[0], times[1]
        );
        drive.session.play(Player::new(read(&drive, &script).unwrap()).unwrap());
        for end in ends {
            let time = drive.clock.advance_to(end).unwrap();
            drive.session.advance(&InputFrame::NOTHING, time);
        }
        let pushed = drive.v("ball").length() / (10.0 * H);
        assert!((pushed - ticks).abs() < 1e-9, "version {version}: {pushed} ticks");
    }
}

/// 30, 60, 144 frames per second, and some that do not divide the ticks.
const RATES: [f64; 7] = [24.0, 30.0, 59.0, 60.0, 100.0, 144.0, 240.0];

#[test]
fn a_key_pushes_for_its_time_and_a_press_for_one_tick_at_every_frame_rate() {
    // Newtons of a key; the undamped body has 1 kg.
    const KEY_N: f64 = 10.0;
    for (script, ticks) in [
        ("(at_s: 1, do: press(\"Right\"))", 1),
        ("(at_s: 1, do: hold(\"Right\", 0.5))", 60),
        ("(at_s: 0.777, do: hold(\"Right\", 0.1))", 12),
        ("(at_s: 1, do: hold(\"Right\", 0.001))", 1),
        ("(at_s: 1, do: key_down(\"Right\")), (at_s: 1.25, do: key_up(\"Right\"))", 30),
        ("(at_s: 1, do: press(\"Right\")), (at_s: 1.1, do: press(\"Right\"))", 2),
        ("(at_s: 1, do: hold(\"Right\", 0.2)), (at_s: 1.1, do: hold(\"Right\", 0.2))", 36),
    ] {
        for fps in RATES {
            let mut drive = Drive::bodies(
                "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 0, -10), mass_kg: 1)",
            );
            let ball = drive.pixel(drive.x("ball"));
            let script = format!(
                "[(at_frame: 0, do: press(\"Q\")), (at_frame: 0, do: move_mouse({}, {})), (at_frame: 0, do: mouse_down(left)),
                  (at_frame: 1, do: mouse_up(left)), {script}]",
                ball.x, ball.y
            );
            drive.session.play(Player::new(read(&drive, &script).unwrap()).unwrap());
            for frame in 0..(2.0 * fps) as u32 {
                let time = drive.clock.advance_to(f64::from(frame) / fps).unwrap();
                drive.session.advance(&InputFrame::NOTHING, time);
            }
            let pushed = drive.v("ball").length() / (KEY_N * H);
            assert!(
                (pushed - f64::from(ticks)).abs() < 1e-9,
                "{script}: {pushed} ticks at {fps} frames per second"
            );
        }
    }
}

#[test]
fn steps_of_one_frame_or_tick_are_done_in_the_order_of_the_list() {
    let mut drive = Drive::bodies(
        "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 0, -10)), (name: \"other\", shape: sphere(radius_m: 1), position_m: (3, 0, -10))",
    );
    let (ball, other) = (drive.pixel(drive.x("ball")), drive.pixel(drive.x("other")));
    let script = format!(
        r#"[(at_frame: 0, do: press("Q")), (at_frame: 0, do: move_mouse({}, {})), (at_frame: 0, do: mouse_down(left)),
            (at_frame: 0, do: mouse_up(left)),
            (at_frame: 0, do: move_mouse({}, {})),
            (at_s: 0, do: set_velocity("ball", (1, 0, 0))), (at_tick: 0, do: set_velocity("ball", (5, 0, 0))),
            (at_s: 0, do: impulse("ball", (0, 2, 0)))]"#,
        other.x, other.y, ball.x, ball.y
    );
    play(&mut drive, &script, 2);
    assert_eq!(
        drive.selected().as_deref(),
        Some("other"),
        "the pointer was there when the button went down"
    );
    assert_eq!(drive.v("ball"), DVec3::new(5.0, 2.0, 0.0));
}

#[test]
fn of_two_pushes_in_ticks_of_one_frame_the_last_is_shown() {
    let mut drive = Drive::tutorial();
    let script = r#"[(at_tick: 0, do: push("enemy", (30, 0, 0))), (at_tick: 1, do: push("enemy", (0, 5, 0)))]"#;
    play(&mut drive, script, 1);
    assert_eq!(drive.session.stage.sim().ticks(), 2);
    let enemy = drive.entity("enemy");
    let mut forces = drive.session.stage.forces_on(enemy);
    forces.retain(|(cause, newtons)| matches!(cause, ForceCause::Push) && *newtons != DVec3::ZERO);
    assert_eq!(forces, [(ForceCause::Push, DVec3::Y * 5.0)]);
}

#[test]
fn a_paused_run_waits_for_no_key_that_is_held_for_ever() {
    let waits = |hold_s: &str| {
        let mut drive = Drive::tutorial();
        let script =
            format!(r#"[(at_frame: 0, do: press("P")), (at_frame: 1, do: hold("W", {hold_s}))]"#);
        drive.session.play(Player::new(read(&drive, &script).unwrap()).unwrap());
        drive.frames(5);
        assert!(
            drive.session.stage.playback().paused() && !drive.session.player().unwrap().finished()
        );
        drive.session.player().unwrap().waits_forever(
            drive.session.stage.playback().frames(),
            drive.session.stage.sim().ticks(),
            60.0,
        )
    };
    assert_eq!(waits("5"), None);
    assert!(matches!(waits("1e300"), Some(When::Seconds(until)) if until >= 1e300));
}

/// A frame ends at a sum of lengths, which may round to the number beside the time.
#[test]
fn a_key_at_a_late_time_is_pressed_in_the_frame_that_ends_then_and_not_before() {
    let length = 1.0 / 60.0;
    for at in [1e4_f64, 1e8, 3e8] {
        for end in [at, at.next_down(), at.next_up()] {
            let script =
                Script::parse("test", &format!(r#"[(at_s: {at:?}, do: press("P"))]"#)).unwrap();
            let mut player = Player::new(script).unwrap();
            let pressed = [end - length, end].map(|end| {
                let inputs = player.of_frame(0, 0, end - length, end);
                inputs.iter().filter(|input| matches!(input, Input::KeyDownUntil(..))).count()
            });
            assert_eq!(pressed, [0, 1], "{at} s, frame that ends at {end:?} s");
        }
    }
}

#[test]
fn what_a_script_asks_of_another_scene_is_refused_there() {
    let mut drive = Drive::tutorial();
    play(
        &mut drive,
        r#"[(at_tick: 20, do: set_damping(1)), (at_tick: 20, do: remove("player"))]"#,
        30,
    );
    drive.session.stage.notices.take_refusals();
    let player = Script::parse(
        "test",
        r#"[(at_tick: 70, do: set_damping(1)), (at_tick: 70, do: push("player", (1, 0, 0)))]"#,
    );
    drive.session.play(Player::new(player.unwrap()).unwrap());
    drive.session.open(scene::load("empty").unwrap());
    drive.ticks(20);
    let refusals = drive.session.stage.notices.take_refusals();
    assert_eq!(refusals, ["this scene never declared damping", "there is no body player any more"]);
}

#[test]
fn a_script_sets_gravity_damping_and_method() {
    let drive = played(
        r#"[(at_s: 0, do: set_gravity((0, 0, -1.6))), (at_s: 0, do: set_damping(0)), (at_frame: 0, do: press("G")),
            (at_tick: 10, do: set_method(explicit_euler))]"#,
        60,
    );
    let world = &drive.session.stage.sim().world;
    assert_eq!(*world.resource::<Gravity>(), Gravity { acceleration: DVec3::Z * -1.6, on: true });
    assert_eq!(*world.resource::<Damping>(), Damping { model: DampingModel::Tutorial, rate: 0.0 });
    assert_eq!(drive.session.stage.sim().stepper.method(), Method::ExplicitEuler);
    assert!((drive.v("player").z + 1.6).abs() < 1e-13);
}

#[test]
fn gravity_and_damping_that_were_set_survive_a_reset_also_of_the_same_frame() {
    for reset in ["at_frame: 0", "at_frame: 5"] {
        let script = format!(
            r#"[(at_frame: 0, do: set_gravity((0, -1.6, 0))), (at_frame: 0, do: set_damping(2)),
                (at_frame: 0, do: set_method(explicit_euler)), ({reset}, do: press("F1"))]"#
        );
        let drive = played(&script, 10);
        assert_eq!(
            drive.session.stage.sim().world.resource::<Gravity>().acceleration,
            DVec3::Y * -1.6,
            "{reset}"
        );
        assert_eq!(drive.session.stage.sim().world.resource::<Damping>().rate, 2.0, "{reset}");
        assert_eq!(drive.session.stage.sim().stepper.method(), Method::ExplicitEuler);
    }
}

#[test]
fn a_script_changes_single_bodies() {
    let drive = played(
        r#"[(at_s: 0, do: set_damping(0)),
            (at_s: 0, do: set_velocity("player", (1, 2, 3))), (at_s: 0, do: impulse("enemy", (0, 4, 0))),
            (at_s: 0, do: set_position("bonus", (7, 8, 9))), (at_s: 0, do: remove("grid.x0.z0")),
            (at_s: 0, do: push("grid.x1.z0", (12, 0, 0))), (at_s: 0.5, do: reverse_velocities)]"#,
        60,
    );
    assert_eq!(drive.v("player"), DVec3::new(-1.0, -2.0, -3.0));
    assert_eq!(drive.v("enemy"), DVec3::new(0.0, -2.0, 0.0), "an impulse is mass times velocity");
    assert_eq!(drive.x("bonus"), DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(drive.session.stage.sim().named("grid.x0.z0"), None);
    assert_eq!(drive.session.stage.sim().remaining_bodies().count(), 28);
    assert!((drive.v("grid.x1.z0").x + 1.0).abs() < 1e-14, "12 N for a tick of 1/120 s on 0.1 kg");
}

#[test]
fn removing_the_selection_clears_it_and_releases_the_camera() {
    let mut drive = Drive::tutorial();
    let player = drive.pixel(drive.x("player"));
    drive.press("Q").select(player);
    drive.press("L").ticks(2).give([remove("player")]);
    let camera = *drive.session.view.camera();
    drive.press("G").ticks(10);
    assert_eq!((drive.selected(), *drive.session.view.camera()), (None, camera));
    drive.press("F1").ticks(1);
    assert!(drive.session.stage.sim().named("player").is_some());
}

#[test]
fn bodies_that_would_turn_non_finite_are_quarantined_and_named() {
    let drive = played(
        r#"[(at_tick: 0, do: set_velocity("enemy", (NaN, 0, 0))),
            (at_tick: 4, do: set_velocity("player", (1e308, 0, 0))), (at_tick: 4, do: push("player", (1e308, 0, 0))),
            (at_tick: 8, do: push("bonus", (inf, 0, 0)))]"#,
        10,
    );
    let mut named: Vec<_> = drive
        .session
        .stage
        .quarantines()
        .so_far()
        .iter()
        .map(|body| (body.tick, body.body.as_str()))
        .collect();
    named.sort_unstable();
    assert!(named.contains(&(1, "enemy")) && named.contains(&(9, "bonus")), "{named:?}");
    for name in ["enemy", "player", "bonus"] {
        assert!(drive.x(name).is_finite() && drive.v(name).is_finite(), "{name}");
    }
    assert_eq!(drive.x("enemy"), DVec3::new(5.0, 5.0, 0.0));
    assert_eq!(drive.x("bonus"), DVec3::new(10.0, 5.0, 0.0));
}

#[test]
fn a_script_that_presses_no_key_or_names_no_body_is_refused() {
    let drive = Drive::tutorial();
    let script = r#"[(at_s: 0, do: press("G")), (at_s: 1, do: press("Gravity"))]"#;
    let error = read(&drive, script).unwrap_err().to_string();
    assert!(error.contains("steps[1]") && error.contains("`Gravity`"), "{error}");
    let unknown = Player::new(Script::parse("test", script).unwrap()).unwrap_err();
    assert_eq!((unknown.len(), unknown[0].0, unknown[0].1.0.as_str()), (1, 1, "Gravity"));
    let error = read(&drive, r#"[(at_s: 0, do: remove("playr"))]"#).unwrap_err().to_string();
    assert!(error.contains("did you mean \"player\"?"), "{error}");
}
