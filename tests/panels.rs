//! Panels: when they are closed, what they take from the scene and what they leave to it.

use glam::DVec2;
use motion::internals::Solver;
use motion::{Gravity, Method};
use sandbox::actions::{Act, BINDINGS};
use sandbox::input::{Button, Input};
use sandbox::{Order, Panel};

use crate::rigs::{Drive, Film, H, at, click, down, middle, tap, up, write_step_hz};

/// In selection mode, looking down 35 degrees so that the floor is behind the settings; and the pixel of the player.
fn looking_down() -> (Drive, DVec2) {
    let mut drive = Drive::tutorial();
    drive.give([Input::Mouse(0.0, 286.0)]).press("Q");
    let player = drive.pixel(drive.x("player"));
    (drive, player)
}

/// The same with the settings open.
fn with_settings() -> (Drive, DVec2) {
    let (mut drive, player) = looking_down();
    let _ = drive.session.controls();
    drive.press("Tab").ticks(2);
    (drive, player)
}

/// A pixel of the open settings that takes no click: the name of a number.
fn on_settings() -> DVec2 {
    middle(&with_settings().0.find(|control| control.name == "ticks per second"))
}

#[test]
fn ctrl_q_quits_also_while_something_is_typed_and_escape_never_does() {
    for open in [None, Some("Tab"), Some("Ctrl+O")] {
        let mut drive = Drive::tutorial();
        for key in open.into_iter().chain(["Escape"; 5]).chain(open) {
            drive.press(key).ticks(2);
        }
        assert_eq!(drive.session.stage.take_orders(), []);
        assert_eq!(drive.press("Ctrl+Q").session.stage.take_orders(), [Order::Quit], "{open:?}");
    }
}

#[test]
fn escape_closes_what_was_opened_last_and_then_clears_the_selection() {
    let panels: Vec<_> = BINDINGS
        .iter()
        .filter_map(
            |row| if let Act::Panel(panel) = row.act { Some((row.keys[0], panel)) } else { None },
        )
        .collect();
    for (key, panel) in panels {
        // One that takes no text.
        let (other_key, other) =
            if panel == Panel::Help { ("E", Panel::Effects) } else { ("H", Panel::Help) };
        let mut drive = Drive::tutorial();
        let player = drive.pixel(drive.x("player"));
        drive.press("Q").select(player);
        assert_eq!(
            drive.press(other_key).press(key).ticks(1).session.open_panels(),
            [other, panel]
        );
        assert_eq!(drive.press("Escape").session.open_panels(), [other]);
        assert_eq!(drive.press("Escape").session.open_panels(), []);
        assert_eq!(drive.selected().as_deref(), Some("player"));
        assert_eq!(drive.press("Escape").selected(), None);
    }
}

#[test]
fn escape_closes_an_open_list_and_a_number_being_typed_before_their_panel() {
    let (mut drive, _) = with_settings();
    let method = |drive: &Drive| drive.session.stage.sim().stepper.method();
    drive.click_on(Method::SemiImplicitEuler.claims().title);
    let other = middle(&drive.control(Method::ExplicitEuler.claims().title));
    drive.press("Escape").ticks(1);
    assert_eq!(drive.session.open_panels(), [Panel::Settings]);
    drive.frame(H, [at(other)]).frame(H, click(Button::Left)).ticks(2);
    assert_eq!(method(&drive), Method::SemiImplicitEuler, "the list is closed");

    write_step_hz(&mut drive);
    drive.press("Escape").ticks(2);
    assert_eq!(
        (drive.session.open_panels(), drive.session.takes_text()),
        (&[Panel::Settings][..], false)
    );
    assert_eq!(drive.press("Escape").session.open_panels(), []);
}

#[test]
fn a_paused_session_changes_by_itself_only_where_something_goes_on() {
    let mut film = Film::shipped("tutorial");
    assert_eq!(film.session.changes_in_s(), 0.0, "it runs");
    film.press("P").frames(3);
    assert_eq!(film.session.changes_in_s(), f64::INFINITY);
    for key in ["H", "Tab", "E", "T", "B", "V", "R"] {
        film.press(key).frames(5);
        assert_eq!(film.session.changes_in_s(), f64::INFINITY, "{key}");
        film.press(key);
    }
    // A cursor blinks, and a notice goes.
    film.press("Ctrl+O").frames(5);
    let blinks = film.session.changes_in_s();
    assert!(blinks > 0.0 && blinks < 1.0, "{blinks} s");
    film.press("Escape").frames(5).press("-").frames(5);
    let goes = film.session.changes_in_s();
    assert!(goes > 3.0 && goes < 4.0, "{goes} s");
    film.frames(300);
    // What is held flies on.
    film.frame([down("W")]);
    assert_eq!(film.session.changes_in_s(), 0.0);
    film.frame([up("W")]).frames(3);
    assert_eq!(film.session.changes_in_s(), f64::INFINITY);
}

#[test]
fn the_key_that_opened_a_panel_closes_it() {
    for (open, close) in [("H", "H"), ("H", "?"), ("?", "H"), ("Tab", "Tab")] {
        let mut drive = Drive::tutorial();
        assert_eq!(drive.press(open).ticks(2).session.open_panels().len(), 1, "{open}");
        assert_eq!(drive.press(close).ticks(2).session.open_panels(), [], "{open}, {close}");
    }
}

#[test]
fn beside_open_settings_clicks_wheel_and_keys_reach_the_scene() {
    let (mut drive, player) = with_settings();
    drive.frame(H, [at(player)]);
    assert_eq!(drive.frame(H, click(Button::Left)).selected().as_deref(), Some("player"));
    assert_eq!(drive.frame(H, [Input::Wheel(1.0)]).session.view.click_force(), 110.0);
    drive.frame(H, click(Button::Right)).ticks(1);
    assert!(drive.v("player").length() > 0.0);
    assert!(drive.press("G").session.stage.sim().world.resource::<Gravity>().on);
}

#[test]
fn a_click_on_open_settings_neither_selects_nor_clears() {
    let on_settings = on_settings();
    let (mut drive, _) = looking_down();
    assert_eq!(drive.select(on_settings).as_deref(), Some("floor"), "behind the settings");
    let (mut drive, player) = with_settings();
    drive.frame(H, [at(on_settings)]).frame(H, click(Button::Left)).ticks(1);
    assert_eq!(drive.selected(), None);
    assert_eq!(drive.frame(H, [Input::Wheel(1.0)]).session.view.click_force(), 10.0);
    drive.frame(H, [at(player)]).frame(H, click(Button::Left)).ticks(1);
    drive.frame(H, [at(on_settings)]).frame(H, click(Button::Left)).ticks(1);
    assert_eq!(drive.selected().as_deref(), Some("player"));
}

#[test]
fn a_pointer_that_moves_and_clicks_in_one_frame_clicks_where_it_came_to() {
    let on_settings = on_settings();
    let (mut drive, player) = with_settings();
    let onto = |pixel| [at(pixel)].into_iter().chain(click(Button::Left));
    drive.frame(H, onto(on_settings)).ticks(1);
    assert_eq!(drive.selected(), None);
    assert_eq!(drive.frame(H, onto(player)).selected().as_deref(), Some("player"));
    drive.frame(H, onto(on_settings));
    assert_eq!(drive.selected().as_deref(), Some("player"));
    assert_eq!(
        drive.frame(H, [at(on_settings), Input::Wheel(1.0)]).session.view.click_force(),
        10.0
    );
    assert_eq!(drive.frame(H, [at(player), Input::Wheel(1.0)]).session.view.click_force(), 110.0);
}

#[test]
fn closed_settings_take_no_clicks_and_camera_mode_leaves_the_wheel_to_the_scene() {
    let on_settings = on_settings();
    let (mut drive, _) = with_settings();
    drive.frame(H, [at(on_settings)]).press("Q").ticks(1);
    assert_eq!(drive.frame(H, [Input::Wheel(1.0)]).session.view.click_force(), 110.0);
    drive.press("Tab").press("Q").ticks(1);
    assert_eq!(drive.select(on_settings).as_deref(), Some("floor"));
}

#[test]
fn what_is_typed_into_the_finder_opens_a_scene_and_does_not_act_on_this_one() {
    let mut drive = Drive::tutorial();
    drive.frame(H, tap("Ctrl+O")).ticks(2);
    assert!(drive.session.takes_text());
    let mode = drive.session.view.mode();
    for letter in ["t", "h", "o", "u"] {
        let [down, up] = tap(&letter.to_uppercase());
        drive.frame(H, [down, Input::Text(letter.to_owned())]).frame(H, [up]);
    }
    assert_eq!(drive.session.stage.take_orders(), []);
    drive.frame(H, tap("Enter"));
    assert_eq!(drive.session.stage.take_orders(), [Order::Open("thousand".to_owned())]);
    drive.ticks(1);
    assert!(!drive.session.takes_text() && drive.session.view.mode() == mode);
    drive.session.open(scene::load("thousand").unwrap());
    drive.ticks(2);
    assert_eq!(
        (
            drive.session.stage.sim().scene.name.as_str(),
            drive.session.stage.sim().remaining_bodies().count()
        ),
        ("thousand", 1001)
    );
}

#[test]
fn letters_typed_into_the_finder_do_not_press_their_keys() {
    let mut drive = Drive::tutorial();
    let (hash, camera) = (drive.hash(), *drive.session.view.camera());
    drive.frame(H, tap("Ctrl+O")).ticks(2);
    for key in ["Q", "G", "W", "P", "F1", "[", "]", "."] {
        drive.frame(H, tap(key));
    }
    drive.ticks(30);
    assert!(
        !drive.session.stage.playback().paused()
            && !drive.session.stage.sim().world.resource::<Gravity>().on
    );
    assert_eq!((drive.hash(), *drive.session.view.camera()), (hash, camera));
    assert_eq!(
        (drive.session.stage.take_orders(), drive.session.view.mode()),
        (Vec::new(), sandbox::Mode::Camera)
    );
    assert_eq!(drive.press("Escape").session.open_panels(), []);
    assert!(!drive.session.takes_text());
}

#[test]
fn ctrl_a_selects_all_of_the_finder() {
    let mut drive = Drive::tutorial();
    drive.frame(H, tap("Ctrl+O")).ticks(2);
    let text = |text: &str| [Input::Text(text.to_owned())];
    drive
        .frame(H, text("jel"))
        .frame(H, tap("Ctrl+A"))
        .frame(H, text("thou"))
        .frame(H, tap("Enter"));
    assert_eq!(drive.session.stage.take_orders(), [Order::Open("thousand".to_owned())]);
}

#[test]
fn a_number_being_typed_into_the_settings_takes_the_keys() {
    let (mut drive, _) = with_settings();
    write_step_hz(&mut drive);
    let gravity = *drive.session.stage.sim().world.resource::<Gravity>();
    drive.frame(H, tap("G")).frame(H, tap("Q")).ticks(1);
    assert_eq!(*drive.session.stage.sim().world.resource::<Gravity>(), gravity);
    assert!(!drive.session.view.grabs_pointer());
    drive.press("Escape");
    assert!(!drive.session.takes_text());
    assert_ne!(*drive.press("G").session.stage.sim().world.resource::<Gravity>(), gravity);
}

#[test]
fn what_is_changed_in_the_settings_acts_on_the_scene() {
    let (mut drive, _) = with_settings();
    drive.click_on("on");
    assert!(drive.session.stage.sim().world.resource::<Gravity>().on);
    assert!(drive.ticks(5).v("player").y < 0.0);
}

#[test]
fn a_method_is_chosen_from_the_list_in_the_settings() {
    let (mut drive, _) = with_settings();
    assert_eq!(drive.session.stage.sim().stepper.method(), Method::SemiImplicitEuler);
    drive
        .click_on(Method::SemiImplicitEuler.claims().title)
        .click_on(Method::ExplicitEuler.claims().title);
    assert_eq!(drive.session.stage.sim().bodies_per_method(), [(Method::ExplicitEuler, 28)]);
}

#[test]
fn notices_are_one_a_topic_and_go_when_they_are_no_longer_true() {
    let says = |film: &Film, what: &str| {
        film.session.stage.notices.texts().filter(|notice| notice.contains(what)).count()
    };
    let mut scene = scene::load("rope").unwrap();
    scene.method = Method::ImplicitEuler;
    let mut film = Film::of(scene);
    let stop_early = |film: &mut Film| {
        let solver = Solver { tolerance: 0.0, most_iterations: 1, ..Solver::default() };
        film.session.stage.world_mut().insert_resource(solver);
        film.frames(2);
        assert_eq!(says(film, "did not converge"), 1);
    };
    stop_early(&mut film);
    // A world that was built again solves its steps.
    film.press("F1").frames(5);
    assert_eq!(says(&film, "did not converge"), 0);
    stop_early(&mut film);
    film.session.open(scene::load("tutorial").unwrap());
    film.frames(5);
    assert_eq!(says(&film, "did not converge"), 0);

    film.press("-").press("-");
    assert_eq!((says(&film, "x speed"), says(&film, "1/4 x speed")), (1, 1));
    film.press("P");
    film.session.stage.keep_timeline();
    film.press(",");
    assert_eq!(says(&film, "nothing is kept"), 1);
    film.press("P").frames(5);
    assert_eq!(says(&film, "nothing is kept"), 0);
    // A reset is a start: also of the speed.
    film.press("F1");
    assert_eq!(film.session.stage.notices.texts().count(), 0);
    let ticks = film.session.stage.sim().ticks();
    film.frames(60);
    assert_eq!(film.session.stage.sim().ticks(), ticks + 120);
}
