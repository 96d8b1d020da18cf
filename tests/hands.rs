//! Fingers, input methods and taps, by the events of a window.

use glam::DVec2;
use sandbox::Order;
use sandbox::input::{Button, Input, TouchPhase};

use super::rigs::{Cockpit, Drive, H, SIZE, at, scene_of, tap};

const SIZE_PX: [u32; 2] = [1280, 720];

/// A finger at a pixel.
fn finger(number: u64, phase: TouchPhase, pixel: DVec2) -> Input {
    Input::Touch(number, phase, pixel.x, pixel.y)
}

/// The tutorial with the bars around it, and the selected player.
fn cockpit() -> Cockpit {
    let mut cockpit = Cockpit::of("tutorial", SIZE_PX);
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player);
    assert_eq!(cockpit.drive.selected().as_deref(), Some("player"));
    cockpit
}

#[test]
fn a_finger_does_what_the_left_button_does() {
    let down = |place| vec![finger(3, TouchPhase::Down, place)];
    let (mut by_mouse, mut by_finger) = (cockpit(), cockpit());
    let (from, by) = (by_mouse.seen("enemy"), DVec2::new(9.0, -6.0));
    by_mouse.drive.frame(H, [at(from), Input::ButtonDown(Button::Left)]);
    by_finger.drive.frame(H, down(from));
    for step in 1..=30 {
        let to = from + by * f64::from(step);
        by_mouse.drive.frame(H, [at(to)]);
        by_finger.drive.frame(H, [finger(3, TouchPhase::Move, to)]);
    }
    by_mouse.drive.frame(H, [Input::ButtonUp(Button::Left)]).ticks(9);
    by_finger.drive.frame(H, [finger(3, TouchPhase::Up, from + 30.0 * by)]).ticks(9);
    assert!(by_mouse.drive.v("enemy").length() > 0.1, "it was pulled");
    assert_eq!(by_finger.drive.hash(), by_mouse.drive.hash());
    assert_eq!(by_finger.drive.selected().as_deref(), Some("enemy"));

    // A tap is a click, on bodies, beside them and on buttons.
    let mut tapped = |place| {
        by_finger.drive.frame(H, down(place)).frame(H, [finger(3, TouchPhase::Up, place)]).ticks(2);
        (by_finger.drive.selected(), by_finger.drive.session.stage.playback().paused())
    };
    let player = by_mouse.seen("player");
    assert_eq!(tapped(player), (Some("player".to_owned()), false));
    assert_eq!(tapped(by_mouse.view()[0] + DVec2::splat(30.0)), (None, false));
    assert!(tapped(by_mouse.middle_of("Pause")).1);
}

#[test]
fn a_finger_that_rests_is_a_click_of_the_right_button() {
    let (mut by_mouse, mut by_finger) = (cockpit(), cockpit());
    let player = by_mouse.seen("player");
    by_finger.drive.frame(H, [finger(3, TouchPhase::Down, player)]);
    by_finger.drive.ticks(48);
    assert_eq!(by_finger.drive.v("player").length(), 0.0);
    by_finger.drive.ticks(24);
    let pushed = by_finger.drive.v("player").length();
    by_mouse.drive.click(Button::Right, player);
    by_mouse.drive.ticks(12);
    assert!(pushed > 0.01 && (by_mouse.drive.v("player").length() / pushed - 1.0).abs() < 0.2);
    // Once, and lifting it is no click beside the body, which has moved on.
    by_finger.drive.ticks(120);
    assert!(by_finger.drive.v("player").length() < pushed);
    by_finger.drive.frame(H, [finger(3, TouchPhase::Up, player)]).ticks(2);
    assert_eq!(by_finger.drive.selected().as_deref(), Some("player"));

    // Two that come down one after the other push nothing.
    let before = by_finger.drive.v("player").length();
    by_finger.drive.frame(H, [finger(1, TouchPhase::Down, player)]);
    by_finger.drive.frame(H, [finger(2, TouchPhase::Down, player + 60.0)]);
    by_finger.drive.ticks(120);
    assert!(by_finger.drive.v("player").length() <= before);
}

#[test]
fn the_force_of_a_click_is_changed_without_a_wheel() {
    let mut cockpit = cockpit();
    let force = |cockpit: &Cockpit| cockpit.drive.session.view.click_force();
    let usual = force(&cockpit);
    for (name, change) in [("More force", 100.0), ("Less force", 0.0), ("Less force", -100.0)] {
        let place = cockpit.middle_of(name);
        cockpit.drive.click(Button::Left, place).ticks(2);
        assert_eq!(force(&cockpit), usual + change);
    }
    assert_eq!(cockpit.drive.selected().as_deref(), Some("player"));
}

/// Puts two fingers down, moves them in steps from two places to two others, and lifts them.
fn slide(cockpit: &mut Cockpit, from: [DVec2; 2], to: [DVec2; 2]) {
    let both =
        |phase, places: [DVec2; 2]| [finger(1, phase, places[0]), finger(7, phase, places[1])];
    cockpit.drive.give(both(TouchPhase::Down, from));
    for step in 1..=40 {
        let part = f64::from(step) / 40.0;
        let places = [from[0].lerp(to[0], part), from[1].lerp(to[1], part)];
        cockpit.drive.give(both(TouchPhase::Move, places));
    }
    cockpit.drive.give(both(TouchPhase::Up, to));
}

#[test]
fn two_fingers_orbit_or_zoom_and_pan_and_select_nothing() {
    let (left, right) = (DVec2::new(-60.0, 0.0), DVec2::new(60.0, 0.0));
    let way = DVec2::new(80.0, 40.0);
    for (name, spread, shift) in
        [("orbit", 1.0, way), ("zoom", 2.0, DVec2::ZERO), ("both", 2.0, way)]
    {
        let mut cockpit = cockpit();
        cockpit.press("P");
        let place = cockpit.drive.x("player");
        let (before, middle) = (cockpit.viewpoint(), cockpit.seen("player"));
        let hash = cockpit.drive.hash();
        let to = [left, right].map(|side| middle + shift + side * spread);
        slide(&mut cockpit, [middle + left, middle + right], to);
        let after = cockpit.viewpoint();
        let [near, far] = [after, before].map(|view| view.position.distance(place));
        let turned = after.forward().angle_between(before.forward()).to_degrees();
        if name == "orbit" {
            assert!((near / far - 1.0).abs() < 1e-2, "{name}: {near} m, not {far} m");
            assert!(turned > 10.0, "{name}: by {turned} degrees");
        } else {
            // The first motion decides, and counts for nothing.
            assert!((near / far * 2.0 - 1.0).abs() < 0.2, "{name}: {near} m of {far} m");
            assert!(turned < 1e-9, "{name}: by {turned} degrees");
            let off = cockpit.seen("player").distance(middle + shift);
            assert!(off < 40.0, "{name}: {off} px from where the fingers are");
        }
        assert_eq!(cockpit.drive.selected().as_deref(), Some("player"), "{name}");
        assert_eq!(cockpit.drive.hash(), hash, "{name}");
    }
}

#[test]
fn in_camera_mode_a_finger_looks_around() {
    let mut drive = Drive::tutorial();
    let looks = |drive: &Drive| drive.session.view.camera().viewpoint().forward();
    let before = looks(&drive);
    drive.give([finger(1, TouchPhase::Down, SIZE / 2.0)]);
    drive.give([finger(1, TouchPhase::Move, SIZE / 2.0 + DVec2::new(90.0, 0.0))]);
    drive.give([finger(1, TouchPhase::Up, SIZE / 2.0 + DVec2::new(90.0, 0.0))]);
    assert!(looks(&drive).angle_between(before).to_degrees() > 5.0);
}

#[test]
fn what_an_input_method_composes_is_typed_once() {
    let mut drive = Drive::tutorial();
    drive.frame(H, tap("Ctrl+O")).ticks(2);
    for (composed, typed) in [("j", ""), ("je", ""), ("", "jel")] {
        let input = [Input::Compose(composed.to_owned()), Input::Text(typed.to_owned())];
        drive.frame(H, input);
    }
    drive.frame(H, [Input::Text("ly".to_owned())]).frame(H, tap("Enter"));
    assert_eq!(drive.session.stage.take_orders(), [Order::Open("jelly".to_owned())]);
}

#[test]
fn ten_taps_of_a_push_key_are_ten_ticks_also_in_one_slow_frame() {
    let text = "(version: 1, push: (), bodies: [(name: \"ball\", mass_kg: 2)])";
    for (length, ticks) in [(0.5, 0), (1.0 / 60.0, 20)] {
        let mut drive = Drive::of(scene_of(text));
        drive.press("Q").press("K").frame(0.1, []);
        let taps = (1..=10).flat_map(|tap_number| {
            let time = 0.1 + length * f64::from(tap_number) / 11.0;
            let [down, up] = tap("Right");
            [Input::At(time), down, Input::At(time + 0.01 * length), up]
        });
        drive.frame(length, taps).ticks(ticks);
        let pushed = drive.v("ball").x / (10.0 / 2.0 * H);
        assert!((pushed - 10.0).abs() < 1e-9, "{pushed} ticks in a frame of {length} s");
    }
}
