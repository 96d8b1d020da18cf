//! Keys, mouse and time: what each does, and what frame rates and hitches change.

use glam::{DVec2, DVec3};
use history::Change;
use motion::{Gravity, Method, Request};
use sandbox::actions::{self, BINDINGS, Key};
use sandbox::input::{Button, Input};
use sandbox::{Mode, Order, SwitchedBy};
use scene::CameraSpec;

use crate::rigs::{Drive, H, at, click, close, down, own_method, tap, up};

fn gravity_on(drive: &Drive) -> bool {
    drive.session.stage.sim().world.resource::<Gravity>().on
}

/// The tutorial in selection mode with the player selected.
fn with_player() -> (Drive, DVec2) {
    player_of(Drive::tutorial())
}

fn player_of(mut drive: Drive) -> (Drive, DVec2) {
    let pixel = drive.pixel(drive.x("player"));
    drive.press("Q");
    assert_eq!(drive.select(pixel).as_deref(), Some("player"));
    (drive, pixel)
}

fn undamped_with_player() -> Drive {
    let scene = scene::Scene { damping: None, ..scene::load("tutorial").unwrap() };
    player_of(Drive::of(scene)).0
}

#[test]
fn it_starts_in_camera_mode_with_gravity_off_and_nothing_selected() {
    let mut drive = Drive::tutorial();
    assert_eq!((drive.session.view.mode(), gravity_on(&drive)), (Mode::Camera, false));
    assert_eq!((drive.session.stage.selection(), drive.session.view.click_force()), (None, 10.0));
    assert!(
        drive.session.view.grabs_pointer()
            && !drive.session.stage.playback().paused()
            && !drive.session.takes_text()
    );
    let before = drive.hash();
    drive.ticks(120);
    assert_eq!(
        (drive.hash(), drive.session.stage.sim().ticks()),
        (before, 120),
        "nothing moves by itself"
    );
}

#[test]
fn q_changes_the_mode_and_g_the_gravity_and_two_g_in_one_frame_change_nothing() {
    let mut drive = Drive::tutorial();
    assert_eq!(drive.press("Q").session.view.mode(), Mode::Selection);
    assert!(!drive.session.view.grabs_pointer());
    assert_eq!(drive.press("Q").session.view.mode(), Mode::Camera);
    for on in [true, false, true] {
        drive.press("G");
        assert_eq!(gravity_on(&drive), on);
    }
    drive.frame(H, tap("G").into_iter().chain(tap("G")));
    assert!(gravity_on(&drive));
    assert!(drive.v("player").y < 0.0);
}

#[test]
fn f1_resets_the_world_and_keeps_camera_gravity_and_click_force() {
    let (mut drive, pixel) = with_player();
    let start = drive.hash();
    drive.press("G").press("L").give([Input::Wheel(2.0)]).click(Button::Right, pixel).ticks(60);
    let camera = *drive.session.view.camera();
    assert_ne!(drive.hash(), start);
    drive.press("F1");
    assert_eq!(drive.hash(), start);
    assert_eq!((*drive.session.view.camera(), drive.session.view.click_force()), (camera, 210.0));
    assert_eq!(
        (drive.session.stage.selection(), drive.session.view.mode()),
        (None, Mode::Selection)
    );
    assert!(gravity_on(&drive));
    // The lock is gone as well: the camera no longer follows.
    drive.ticks(10);
    assert_eq!(*drive.session.view.camera(), camera);
    assert!(drive.v("player").y < 0.0);
}

#[test]
fn f1_forgets_a_click_that_no_tick_has_taken() {
    let (mut drive, pixel) = with_player();
    let start = drive.hash();
    drive.click(Button::Right, pixel).press("F1").ticks(2);
    assert_eq!(drive.hash(), start);
}

#[test]
fn l_locks_the_camera_to_the_selection_and_f2_resets_it_and_unlocks() {
    let (mut drive, _) = with_player();
    let start = *drive.session.view.camera();
    drive.press("G").press("L").ticks(30);
    assert!(drive.x("player").y < 4.75);
    // Locked it looks at the body as drawn, which is a tick behind when the frame ends with a tick.
    let eye = drive.session.view.camera().position;
    assert!((eye - drive.x("player") - DVec3::new(0.0, 14.0, 20.0)).length() < 0.1);
    close(drive.session.view.camera().pitch, -34.992_020_198_558_66, 1e-12);
    drive.press("L").ticks(10);
    assert_eq!(drive.session.view.camera().position, eye, "unlocked it stays");
    drive.press("L").ticks(1).press("F2").ticks(5);
    assert_eq!(*drive.session.view.camera(), start);
    // Without a selection there is nothing to lock to.
    let mut drive = Drive::tutorial();
    drive.press("L").press("G").ticks(30);
    assert_eq!(*drive.session.view.camera(), start);
}

#[test]
fn flying_is_level_at_100_meters_a_second_and_only_in_camera_mode() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (forward, right) = (DVec3::new(half, 0.0, -half), DVec3::new(half, 0.0, half));
    let table = [
        (&["W"][..], forward),
        (&["S"], -forward),
        (&["D"], right),
        (&["A"], -right),
        (&["Space"], DVec3::Y),
        (&["Shift"], -DVec3::Y),
        (&["W", "D", "Space"], forward + right + DVec3::Y),
        (&["W", "S"], DVec3::ZERO),
    ];
    for (keys, direction) in table {
        // Also when it looks far up: only the yaw counts.
        for looked in [0.0, -500.0] {
            let mut drive = Drive::tutorial();
            drive
                .give([Input::Mouse(0.0, looked)])
                .give(keys.iter().map(|key| down(key)))
                .frames(30);
            let moved = drive.session.view.camera().position - CameraSpec::TUTORIAL.position;
            assert!((moved - direction * 50.0).length() < 1e-9, "{keys:?}: {moved}");
            drive.press("Q");
            let there = drive.session.view.camera().position;
            drive.frames(10).press("Q").give(keys.iter().map(|key| up(key))).frames(10);
            assert_eq!(drive.session.view.camera().position, there);
        }
    }
}

#[test]
fn nothing_stays_held_when_the_focus_is_lost_or_control_goes_down_meanwhile() {
    let start = CameraSpec::TUTORIAL.position;
    let mut drive = Drive::tutorial();
    drive.give([down("W"), Input::FocusLost]).ticks(5);
    assert_eq!(drive.session.view.camera().position, start);
    // A key that went down alone and comes up beside the control key is the same key.
    drive.give([down("W"), up("Ctrl+W")]).ticks(5);
    assert_eq!(drive.session.view.camera().position, start);
    let (mut drive, _) = with_player();
    let enemy = drive.pixel(drive.x("enemy"));
    drive.give([Input::ButtonDown(Button::Left), down("Up"), Input::FocusLost, at(enemy)]).ticks(5);
    assert_eq!((drive.selected().as_deref(), drive.v("player")), (Some("player"), DVec3::ZERO));
}

#[test]
fn the_mouse_turns_the_view_by_seven_hundredths_of_a_degree_a_count() {
    let mut drive = Drive::tutorial();
    drive.give([Input::Mouse(100.0, -50.0)]);
    close(drive.session.view.camera().yaw, 308.0, 1e-15);
    close(drive.session.view.camera().pitch, -11.5, 1e-15);
    drive.give([Input::Mouse(-1000.0, 0.0)]);
    close(drive.session.view.camera().yaw, 18.0, 1e-13);
    drive.give([Input::Mouse(0.0, 1e5)]);
    assert_eq!(drive.session.view.camera().pitch, -90.0);
    drive.give([Input::Mouse(0.0, -1e5)]);
    assert_eq!(drive.session.view.camera().pitch, 90.0);
    let camera = *drive.session.view.camera();
    drive.press("Q").give([Input::Mouse(3.0, 4.0)]);
    assert_eq!(*drive.session.view.camera(), camera);
}

#[test]
fn held_keys_push_the_selection_with_10_newtons_in_every_tick_begun_while_held() {
    let table = [
        ("Up", DVec3::NEG_Z),
        ("Down", DVec3::Z),
        ("Left", DVec3::NEG_X),
        ("Right", DVec3::X),
        ("PageUp", DVec3::Y),
        ("PageDown", DVec3::NEG_Y),
    ];
    for (key, axis) in table {
        for rate in [30.0, 60.0, 144.0, 1000.0] {
            let mut drive = undamped_with_player();
            drive.give([down(key)]);
            while drive.session.stage.sim().ticks() < 24 {
                drive.frame(1.0 / rate, []);
            }
            let held = drive.session.stage.sim().ticks() as f64;
            drive.give([up(key)]).run(10, 1.0 / rate);
            let expected = axis * held * 10.0 * 0.5 * H;
            let v = drive.v("player");
            assert!((v - expected).length() < 1e-13, "{key} at {rate}: {v}");
            assert_eq!(drive.v("enemy"), DVec3::ZERO);
        }
    }
}

#[test]
fn held_keys_push_in_selection_mode_only_and_two_opposite_ones_cancel() {
    let (mut drive, _) = with_player();
    drive.give([down("Up"), down("Down")]).ticks(3).give([up("Down")]).press("Q").ticks(3);
    assert_eq!(drive.v("player"), DVec3::ZERO);
    drive.press("Q").ticks(1);
    assert!(drive.v("player").z < 0.0);
    let mut drive = Drive::tutorial();
    drive.press("Q").give([down("Up")]).ticks(3);
    assert!(
        drive.session.stage.sim().remaining_bodies().count() == 29
            && drive.v("player") == DVec3::ZERO
    );
}

#[test]
fn p_pauses_and_owes_nothing_and_a_point_steps_once() {
    let mut drive = Drive::tutorial();
    drive.press("G").frames(3);
    assert_eq!(drive.session.stage.sim().ticks(), 6);
    let before = drive.hash();
    drive.press("P").frames(300);
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (6, before));
    drive.press("P").frames(1);
    assert_eq!(
        (drive.session.stage.sim().ticks(), drive.session.stage.playback().dropped()),
        (8, 0.0)
    );
    drive.frame(1.0 / 60.0, tap("."));
    assert!(drive.session.stage.playback().paused());
    assert_eq!(drive.frames(9).session.stage.sim().ticks(), 9);
    drive.frame(0.0, tap(".").into_iter().chain(tap(".")));
    assert_eq!(drive.session.stage.sim().ticks(), 11);
    // A step that is asked for in the frame in which the pause ends is not kept for the next pause.
    drive.frame(0.0, tap(".").into_iter().chain(tap("P")));
    assert!(!drive.session.stage.playback().paused());
    let ticks = drive.session.stage.sim().ticks();
    drive.press("P").frames(3);
    assert_eq!(drive.session.stage.sim().ticks(), ticks);
}

#[test]
fn slow_and_fast_motion_visit_the_states_of_the_normal_run() {
    let normal = {
        let (mut drive, pixel) = with_player();
        drive.press("G").click(Button::Right, pixel);
        (0..120).flat_map(|_| drive.visited(1.0 / 60.0, [])).collect::<Vec<_>>()
    };
    assert_eq!(normal.len(), 240);
    let (mut drive, pixel) = with_player();
    drive.press("G").click(Button::Right, pixel);
    let (mut visited, mut counts) = (Vec::new(), Vec::new());
    for (key, pace) in
        [("P", 0.0), ("P", 1.0), ("-", 0.5), ("-", 0.25), ("=", 0.5), ("=", 1.0), ("=", 2.0)]
    {
        drive.press(key);
        let here: Vec<_> = (0..12).flat_map(|_| drive.visited(1.0 / 60.0, [])).collect();
        counts.push((here.len() as f64, pace * 24.0));
        visited.extend(here);
    }
    assert!(counts.iter().all(|(ticks, expected)| ticks == expected), "{counts:?}");
    assert!(visited.len() > 100 && visited == normal[..visited.len()]);
}

#[test]
fn the_same_clicks_before_the_same_ticks_end_in_the_same_bits_at_every_frame_rate() {
    let jitter =
        |i: u32| H * (0.05 + 0.9 * f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0);
    let lengths: [(&str, Box<dyn Fn(u32) -> f64>); 6] = [
        ("30", Box::new(|_| 1.0 / 30.0)),
        ("60", Box::new(|_| 1.0 / 60.0)),
        ("120", Box::new(|_| H)),
        ("144", Box::new(|_| 1.0 / 144.0)),
        ("1000", Box::new(|_| 1e-3)),
        ("jitter", Box::new(jitter)),
    ];
    let mut hashes = Vec::new();
    for (name, length) in lengths {
        let (mut drive, pixel) = with_player();
        let mut clicks = vec![8, 20, 64, 100];
        for i in 0.. {
            let ticks = drive.session.stage.sim().ticks();
            if ticks >= 120 {
                break;
            }
            let due = clicks.first() == Some(&ticks);
            if due {
                clicks.remove(0);
            }
            drive.frame(length(i), if due { click(Button::Right).to_vec() } else { Vec::new() });
        }
        assert!(clicks.is_empty() && drive.session.stage.sim().ticks() == 120);
        // Four clicks of one tick each, as damping leaves them.
        let left: f64 = [8, 20, 64, 100].iter().map(|tick| (1.0 - 0.4 * H).powi(120 - tick)).sum();
        close(drive.v("player").length(), left * 10.0 * 0.5 * H, 1e-12);
        assert!((drive.pixel(drive.x("player")) - pixel).length() < 10.0);
        hashes.push((name, drive.hash()));
    }
    assert!(hashes.iter().all(|(_, hash)| *hash == hashes[0].1), "{hashes:?}");
}

#[test]
fn every_click_is_one_tick_of_push_however_frame_times_jitter() {
    let mut drive = undamped_with_player();
    let mut clicks = 0;
    for i in 0..200_u32 {
        // From no time at all to 60 ms.
        let length = 0.06 * f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
        let here = u32::from(i % 9 == 0) + u32::from(i % 45 == 0);
        clicks += here;
        let events = (0..here).flat_map(|_| click(Button::Right)).collect::<Vec<_>>();
        drive.frame(if i % 7 == 3 { 0.0 } else { length }, events);
    }
    drive.ticks(1);
    close(drive.v("player").length(), f64::from(clicks) * 10.0 * 0.5 * H, 1e-12);
}

#[test]
fn a_frame_of_no_time_changes_no_body_and_no_camera() {
    let (mut drive, _) = with_player();
    drive.press("G").frame(0.021, []).give([down("Up")]).press("Q").give([down("W")]);
    let (hash, camera, ticks) =
        (drive.hash(), *drive.session.view.camera(), drive.session.stage.sim().ticks());
    drive.run(20, 0.0);
    assert_eq!((drive.hash(), drive.session.stage.sim().ticks()), (hash, ticks));
    assert_eq!(
        (*drive.session.view.camera(), drive.session.stage.playback().dropped()),
        (camera, 0.0)
    );
}

#[test]
fn a_hitch_of_a_second_simulates_a_quarter_and_reports_the_rest_as_dropped() {
    let mut drive = Drive::tutorial();
    drive.frames(3).frame(1.0, []);
    assert_eq!(drive.session.stage.sim().ticks(), 36);
    close(drive.session.stage.playback().dropped(), 0.75, 1e-12);
    drive.frames(3);
    assert_eq!(drive.session.stage.sim().ticks(), 42);
    close(drive.session.stage.playback().dropped(), 0.75, 1e-12);
    close(drive.session.stage.sim().seconds(), 42.0 * H, 1e-15);
}

#[test]
fn one_step_a_frame_depends_on_the_frame_rate_and_a_fixed_step_does_not() {
    let end = |name: &str, rate: u32| {
        let mut drive = Drive::shipped(name);
        drive.press("G").run(rate, 1.0 / f64::from(rate));
        (drive.session.stage.sim().ticks(), drive.x("player").y, drive.hash())
    };
    assert_eq!(end("tutorial", 30), end("tutorial", 60));
    let (slow, fast) = (end("frame_step", 30), end("frame_step", 60));
    assert_eq!((slow.0, fast.0), (30, 60));
    // The drops of one second that the tutorial's scheme gives at these rates.
    crate::rigs::digits(slow.1 - 5.0, "-4.467492");
    crate::rigs::digits(fast.1 - 5.0, "-4.387138");
}

#[test]
fn brackets_ask_for_the_neighboring_scenes_and_f12_for_a_screenshot() {
    let names: Vec<_> = scene::shipped().iter().map(|scene| scene.name.to_owned()).collect();
    for (i, name) in names.iter().enumerate() {
        let mut drive = Drive::shipped(name);
        let (before, after) = ((i + names.len() - 1) % names.len(), (i + 1) % names.len());
        assert_eq!(
            drive.press("[").session.stage.take_orders(),
            [Order::Open(names[before].clone())]
        );
        assert_eq!(
            drive.press("]").session.stage.take_orders(),
            [Order::Open(names[after].clone())]
        );
        assert_eq!(drive.press("F12").session.stage.take_orders(), [Order::Screenshot(None)]);
        assert_eq!(drive.session.stage.take_orders(), []);
    }
}

#[test]
fn i_and_shift_i_go_through_the_methods_of_the_scene_and_a_reset_keeps_the_chosen_one() {
    let mut drive = Drive::tutorial();
    for (key, step) in [("I", Method::next as fn(Method) -> Method), ("Shift+I", Method::previous)]
    {
        for _ in Method::ALL {
            let expected = step(drive.session.stage.sim().stepper.method());
            assert_eq!(drive.press(key).session.stage.sim().stepper.method(), expected, "{key}");
        }
    }
    assert_eq!(drive.session.stage.sim().stepper.method(), Method::SemiImplicitEuler);
    // Each press of a frame counts.
    drive.give(tap("I").into_iter().chain(tap("I")).chain(tap("Shift+I")));
    assert_eq!(drive.session.stage.sim().stepper.method(), Method::ImplicitEuler);
    assert_eq!(drive.press("F1").session.stage.sim().stepper.method(), Method::ImplicitEuler);
    let hash = drive.hash();
    drive.press("G").ticks(10);
    assert_ne!(drive.hash(), hash);
}

#[test]
fn shift_changes_only_the_keys_that_have_a_row_with_it() {
    let fly = |keys: &[&str]| {
        let mut drive = Drive::tutorial();
        drive.give(keys.iter().map(|key| down(key))).frames(10);
        let there = drive.session.view.camera().position;
        drive.give(keys.iter().map(|key| up(key))).frames(10);
        assert_eq!(drive.session.view.camera().position, there, "{keys:?}");
        there
    };
    // A window reports the letter with shift while both are held.
    assert_eq!(fly(&["Shift", "Shift+W"]), fly(&["Shift", "W"]));
    assert!(gravity_on(Drive::tutorial().press("Shift+G")));
    // A key that went down with shift and comes up without it is the same key.
    let mut drive = Drive::tutorial();
    drive.give([down("Shift+W"), up("W")]).ticks(5);
    assert_eq!(drive.session.view.camera().position, CameraSpec::TUTORIAL.position);
    assert_eq!(
        Drive::tutorial().press("Ctrl+Shift+I").session.stage.sim().stepper.method(),
        Method::default()
    );
    assert_eq!(Key::character('i').with_shift(true).to_string(), "Shift+I");
    assert_eq!(Key::character('?').with_shift(true).to_string(), "?");
    for word in ["Shift+?", "Shift+Up", "Shift+", "Shift+Ctrl+I", "Shift+Shift"] {
        assert!(word.parse::<Key>().is_err(), "{word}");
    }
}

#[test]
fn shift_that_belongs_to_another_key_does_not_fly() {
    let start = CameraSpec::TUTORIAL.position;
    // `?` is typed with shift, and so is `=` on some keyboards.
    for key in ["Shift+I", "Shift+T", "?", "="] {
        let mut drive = Drive::tutorial();
        drive.give([down("Shift")]).frames(6);
        assert!(drive.session.view.camera().position.y < start.y, "shift may be all that comes");
        drive.give([down(key)]).frames(6).give([up(key)]).frames(6).give([up("Shift")]).frames(6);
        assert!((drive.session.view.camera().position - start).length() < 1e-9, "{key}");
        // The next press of shift flies again.
        drive.give([down("Shift")]).frames(6);
        assert!((drive.session.view.camera().position - start + DVec3::Y * 10.0).length() < 1e-9);
    }
    // After a second of flying it was meant.
    let mut drive = Drive::tutorial();
    drive.give([down("Shift")]).frames(60).press("Shift+I").frames(6);
    assert!((drive.session.view.camera().position - start + DVec3::Y * 110.0).length() < 1e-9);
}

#[test]
fn a_tap_shorter_than_a_frame_flies_for_the_frame_and_pushes_for_a_tick() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut drive = Drive::tutorial();
    drive.frame(0.05, tap("W")).run(9, 0.05);
    let moved = drive.session.view.camera().position - CameraSpec::TUTORIAL.position;
    assert!((moved - DVec3::new(half, 0.0, -half) * 5.0).length() < 1e-9, "{moved}");
    // Also in frames that have no tick, and where the key comes up in a later one of them than it went down in.
    let [pressed, released] = tap("Right");
    let one_frame: &[(f64, &[Input])] = &[(0.05, &[pressed.clone(), released.clone()])];
    let no_tick: &[(f64, &[Input])] = &[(0.001, &[pressed.clone(), released.clone()])];
    let two_frames: &[(f64, &[Input])] = &[(0.001, &[pressed]), (0.001, &[released])];
    for frames in [one_frame, no_tick, two_frames] {
        let mut drive = undamped_with_player();
        for (seconds, events) in frames {
            drive.frame(*seconds, events.iter().cloned());
        }
        drive.run(9, 0.05);
        close(drive.v("player").x, 10.0 * 0.5 * H, 1e-12);
    }
}

#[test]
fn a_body_gets_a_method_of_its_own_and_the_scenes_again() {
    let mut drive = Drive::tutorial();
    let count = |drive: &mut Drive| drive.session.stage.sim().bodies_per_method();
    assert_eq!(count(&mut drive), [(Method::SemiImplicitEuler, 28)]);
    drive.give([own_method("player", Method::RungeKutta4), own_method("enemy", Method::Yoshida4)]);
    drive.give([own_method("missing", Method::Yoshida4)]);
    let own = [(Method::SemiImplicitEuler, 26), (Method::RungeKutta4, 1), (Method::Yoshida4, 1)];
    assert_eq!(count(&mut drive), own);
    // The scene's method is that of all others.
    drive.press("Shift+I");
    assert_eq!(count(&mut drive)[0], (Method::ExplicitEuler, 26));
    let player = drive.session.stage.sim().scene.names.find("player").unwrap();
    let scenes = Change::request(Request::SetBodyMethod(player, None));
    drive.session.stage.change(scenes, SwitchedBy::Settings);
    drive.give([own_method("enemy", Method::ExplicitEuler)]);
    assert_eq!(count(&mut drive), [(Method::ExplicitEuler, 28)]);
}

#[test]
fn one_two_and_seven_show_velocities_forces_and_trails() {
    for key in ["1", "2", "7"] {
        let (mut drive, _) = with_player();
        drive.press("G").press(key).ticks(20);
        assert!(!drive.session.picture().lines.is_empty(), "{key} shows lines");
        drive.press(key).ticks(2);
        assert!(drive.session.picture().lines.is_empty(), "{key} hides them");
    }
}

/// The longest line in the picture, m, and how many there are.
fn lines(drive: &mut Drive) -> (f32, usize) {
    let lines = drive.session.picture().lines;
    let length = |line: &render::Line| glam::Vec3::from(line.start).distance(line.end.into());
    (lines.iter().map(length).fold(0.0, f32::max), lines.len())
}

#[test]
fn trails_have_their_points_by_time_and_no_line_across_what_they_did_not_see() {
    let (mut smooth, mut slow) = (Drive::shipped("orbit"), Drive::shipped("orbit"));
    let [(_, by_ticks), (_, by_frames)] =
        [lines(smooth.run(120, H)), lines(slow.run(10, 12.0 * H))];
    assert!(by_ticks > 100 && by_ticks.abs_diff(by_frames) <= 1, "{by_ticks} and {by_frames}");
    // Off and on again while it moves on.
    let (longest, _) = lines(&mut smooth);
    smooth.press("7").ticks(120).press("7").ticks(20);
    assert!(lines(&mut smooth).0 < 1.5 * longest);
    // Particles whose slots are taken while they live.
    let text = "(version: 1, trails: true, emitters: [(rate_per_s: 60, position_m: (0, 0, -20), direction: (1, 0, 0),
        spread_deg: 20, speed_m_s: 10, life_s: 5, capacity: 10, mass_kg: 1)])";
    let mut drive = Drive::text(text);
    let (longest, count) = lines(drive.ticks(240));
    assert!(count > 50 && longest < 0.4, "{count} lines of up to {longest} m");
}

#[test]
fn force_arrows_show_an_engine_while_it_is_on() {
    let mut drive = Drive::shipped("ship");
    drive.press("7").press("2").ticks(2);
    assert!(!drive.session.picture().lines.is_empty(), "on for 2 s");
    drive.ticks(240);
    assert!(drive.session.picture().lines.is_empty(), "it coasts");
}

/// Lengths of the arrows of a picture, m, each a shaft and a head.
fn arrows(drive: &mut Drive) -> Vec<f64> {
    let ends = |line: &render::Line| [line.start, line.end].map(glam::Vec3::from_array);
    let lines = drive.session.picture().lines;
    let shafts: Vec<_> = lines.windows(2).filter(|pair| pair[1].end_width_px == 0.0).collect();
    shafts.iter().map(|pair| f64::from(ends(&pair[0])[0].distance(ends(&pair[1])[1]))).collect()
}

#[test]
fn force_arrows_show_springs_and_mutual_gravity_in_newtons_on_one_scale() {
    for name in ["oscillator", "figure_eight", "third_law"] {
        let mut drive = Drive::shipped(name);
        // At the start the body in the middle of the eight is pulled to both sides alike.
        let without = arrows(drive.ticks(30)).len();
        let moving = drive
            .session
            .stage
            .sim()
            .bodies_per_method()
            .into_iter()
            .map(|(_, bodies)| bodies)
            .sum::<usize>();
        assert_eq!((without, arrows(drive.press("2")).len()), (0, moving), "{name}");
    }
    // Equal and opposite forces have arrows of one length, whatever the masses: 60 N on 1 kg and on 10 kg.
    let mut drive = Drive::shipped("third_law");
    let start = arrows(drive.press("2"));
    assert_eq!(start.len(), 5);
    let within = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-5;
    assert!(start.iter().all(|length| within(*length, start[0])), "{start:?}");
    // 20 N per meter, and they stay on their scale as the forces fall.
    assert!(within(start[0], 3.0), "{start:?}");
    let newtons = |drive: &mut Drive, name: &str| -> f64 {
        let body = drive.entity(name);
        drive
            .session
            .stage
            .forces_on(body)
            .into_iter()
            .map(|(_, newtons)| newtons)
            .sum::<DVec3>()
            .length()
    };
    let later = arrows(drive.ticks(30));
    let expected = newtons(&mut drive, "one") / 20.0;
    assert!(within(later[0], expected) && expected < 2.0, "{later:?} {expected}");
}

#[test]
fn no_key_is_bound_twice_and_every_key_and_name_is_known() {
    let (mut keys, mut names) = (Vec::new(), Vec::new());
    for binding in BINDINGS.iter() {
        assert!(!binding.keys.is_empty() && !binding.what.is_empty());
        for key in binding.keys {
            let key: Key = key.parse().unwrap();
            assert_eq!(actions::binding(&key).unwrap().name, binding.name, "{key}");
            keys.push(key);
        }
        assert_eq!(actions::key_of_word(binding.name).unwrap().to_string(), binding.keys[0]);
        names.push(binding.name);
    }
    let names: Vec<_> = names.iter().map(ToString::to_string).collect();
    for list in [keys.iter().map(Key::to_string).collect(), names] {
        let unique: std::collections::BTreeSet<_> = list.iter().collect();
        assert_eq!(unique.len(), list.len(), "{list:?}");
    }
    assert!(actions::key_of_word("no_such_action").is_err());
}

/// Position Verlet with a last position has velocities half a step late, and another method has to bring them to the present.
#[test]
fn the_evaluations_of_a_reset_count() {
    let mut drive = Drive::of(scene::load("verlet_start").unwrap());
    drive.ticks(3).press("I");
    let evaluations = |drive: &Drive| drive.session.stage.sim().evaluations().accelerations();
    let before = evaluations(&drive);
    drive.press("F1");
    assert_eq!(evaluations(&drive), before + 1);
}
