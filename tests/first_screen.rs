//! The picture with the bars shown: the program's own look, what a push and an empty view say, tabs, and the price in one sentence.

use glam::DVec3;
use lab::cost::{Accuracy, Cost};
use motion::Method;
use render::Frame;
use sandbox::input::Button;
use sandbox::{Mode, Options, Overrides, Session, Words};
use scene::Scene;

use crate::rigs::Cockpit;

/// The words of labels that begin with `start`.
fn labels(cockpit: &Cockpit, start: &str) -> Vec<String> {
    let labels = cockpit.session().controls().into_iter().filter(|control| control.role == "Label");
    labels.filter(|label| label.name.starts_with(start)).map(|label| label.name).collect()
}

/// A picture without bars and with those words.
fn picture(words: Words) -> Frame {
    let options = Options { words, ..Options::default() };
    Session::new(scene::load("tutorial").unwrap(), options).picture()
}

#[test]
fn the_tutorials_look_is_that_without_bars_and_the_programs_own_that_with_bars_or_without_words() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let own = cockpit.drive.session.picture();
    cockpit.press("F10");
    let bare = cockpit.drive.session.picture();
    for (frame, is_own) in [
        (&own, true),
        (&bare, false),
        (&picture(Words::All), false),
        (&picture(Words::Captions), true),
        (&picture(Words::Labels), true),
        (&picture(Words::None), true),
    ] {
        assert_eq!(frame.soft, is_own);
        // The floor is a body of the tutorial, and the ground of the own look.
        assert_eq!(frame.ground.is_some(), is_own);
        let floors = frame.cuboids.iter().filter(|cuboid| cuboid.half_extents[0] > 50.0).count();
        assert_eq!(floors, usize::from(!is_own));
        let checkered =
            frame.spheres.iter().filter(|sphere| sphere.surface & render::CHECKER != 0).count();
        assert_eq!(checkered > 0, !is_own);
    }
    let colors = |frame: &Frame| [frame.spheres[0].color, frame.cuboids.last().unwrap().color];
    let [ball, cube] = colors(&own);
    assert_ne!(ball, cube, "each kind has its color");
    assert_eq!(colors(&bare), [[1.0; 4]; 2]);
}

#[test]
fn a_selected_body_keeps_its_color_and_has_an_outline() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let pixel = cockpit.seen("player");
    let before = cockpit.drive.session.picture();
    assert_eq!(cockpit.drive.select(pixel).as_deref(), Some("player"));
    let after = cockpit.drive.session.picture();
    let changed = before.cuboids.iter().zip(&after.cuboids).filter(|(a, b)| a.surface != b.surface);
    let changed: Vec<_> = changed.map(|(a, b)| (a.color, b.color, b.surface)).collect();
    let [(a, b, surface)] = changed[..] else { panic!("{changed:?}") };
    assert_eq!((a, surface), (b, render::OUTLINED));
}

#[test]
fn a_push_is_shown_for_a_while_by_an_arrow_that_ends_at_the_body() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let pixel = cockpit.seen("player");
    cockpit.drive.select(pixel);
    let lines = |cockpit: &mut Cockpit| cockpit.drive.session.picture().lines.len();
    let before = lines(&mut cockpit);
    cockpit.drive.click(Button::Right, pixel).ticks(1);
    assert!(cockpit.drive.v("player").length() > 0.0);
    assert!(lines(&mut cockpit) > before);
    cockpit.drive.ticks(180);
    assert_eq!(lines(&mut cockpit), before, "it is gone");
}

#[test]
fn a_scene_without_a_camera_wants_to_be_framed_and_one_with_a_camera_does_not() {
    let wants = |scene: Scene| {
        let session = Session::new(scene, Options::default());
        session.view.should_be_framed(&session.stage)
    };
    for name in ["tutorial", "frame_step"] {
        assert!(wants(scene::load(name).unwrap()), "{name}");
    }
    // The large grid fills the view as it is.
    for name in ["tutorial_large", "projectile", "orbit", "thousand", "empty"] {
        assert!(!wants(scene::load(name).unwrap()), "{name}");
    }
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.press("F");
    assert!(!cockpit.session().view.should_be_framed(&cockpit.session().stage), "it is framed");
}

#[test]
fn what_hangs_from_a_spring_is_framed_as_far_as_it_swings() {
    for (name, place, more) in [
        ("cord", "(1, 0, 0)", "stiffness_n_m: 30, rest_length_m: 5, pull_only: true"),
        ("compressed", "(0, -1, 0)", "stiffness_n_m: 30, rest_length_m: 5"),
        ("pendulum", "(3, 0, 0)", "stiffness_n_m: 3000, rest_length_m: 3"),
    ] {
        let text = format!(
            "(version: 1, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [
                (name: \"post\", shape: cuboid(half_extents_m: (0.1, 0.1, 0.1)), immovable: true),
                (name: \"ball\", shape: sphere(radius_m: 0.2), position_m: {place})],
            springs: [(between: (\"post\", \"ball\"), {more})])"
        );
        let mut cockpit = Cockpit::of("empty", [1280, 720]);
        cockpit.drive.session.open(Scene::parse(name, &text).unwrap());
        cockpit.drive.ticks(1);
        cockpit.press("F").drive.ticks(1);
        let [corner, size] = cockpit.view();
        let mut lowest = f64::INFINITY;
        for _ in 0..300 {
            cockpit.drive.ticks(1);
            lowest = lowest.min(cockpit.drive.x("ball").y);
            for body in ["post", "ball"] {
                let at = (cockpit.seen(body) - corner) / size;
                let inside = at.min_element() > 0.0 && at.max_element() < 1.0;
                assert!(inside, "{name}: {body} is at {at} of the view");
            }
        }
        // It is not far away either: the drop is a quarter of the picture or more.
        let tall = cockpit.pixel(DVec3::ZERO).distance(cockpit.pixel(DVec3::Y * lowest));
        assert!(tall > 0.25 * size.y, "{name}: {tall} of {size}");
    }
}

#[test]
fn an_empty_view_says_why_and_has_two_ways_out() {
    const FELL: &str = "Nothing collides here: everything fell through the floor.";
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.press("F").press("G").drive.ticks(60);
    assert_eq!(labels(&cockpit, FELL).len(), 0, "bodies are in the view");
    cockpit.drive.ticks(8 * 120);
    assert_eq!(labels(&cockpit, FELL).len(), 1);
    assert!(cockpit.has("Gravity off"), "with it everything falls again");
    cockpit.click("Follow");
    let camera = cockpit.session().view.camera().position;
    assert!(camera.y < -50.0, "{camera}");
    assert_eq!(labels(&cockpit, FELL).len(), 0);
    let mut back = Cockpit::of("tutorial", [1280, 720]);
    back.press("F").press("F2");
    let first = back.session().view.camera().position;
    back.press("G").drive.ticks(8 * 120);
    back.click("First view");
    assert_eq!(back.session().view.camera().position, first, "not of what has fallen");
    cockpit.press("F1").drive.ticks(2);
    assert!(cockpit.session().view.camera().position.y > 0.0, "the camera comes back, too");
    cockpit.press("F").drive.ticks(2);
    assert_eq!(labels(&cockpit, FELL).len(), 0);
    assert!(cockpit.drive.x("player").y > 4.0);

    let text = "(version: 1, bodies: [(position_m: (0, 0, -20), velocity_m_s: (90, 0, 0), shape: sphere(radius_m: 1))],
        camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0))";
    let mut gone = Cockpit::of("empty", [1280, 720]);
    gone.drive.session.open(Scene::parse("gone", text).unwrap());
    gone.drive.ticks(240);
    assert_eq!(labels(&gone, "Everything that moves has left the view.").len(), 1);
    let look = |gone: &Cockpit| gone.session().view.camera().position;
    gone.press("F");
    let (there, begins) = (look(&gone), DVec3::ZERO);
    gone.drive.ticks(240);
    gone.click("First view");
    assert!(there != begins && look(&gone) == begins, "{there}");
}

#[test]
fn the_key_of_a_tool_opens_its_tab_and_the_arrangement_brings_the_tab_back() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    for (key, tool) in [("E", "Effects"), ("M", "Editor"), ("R", "Timeline"), ("Y", "Graphs")] {
        assert!(!cockpit.has(tool), "{tool} is in another tab");
        cockpit.press(key);
        assert!(cockpit.has(tool), "{key} shows {tool}");
    }
    cockpit.click("Measure");
    let arranged = cockpit.session().arrangement();
    let mut next = Cockpit::of("orbit", [1280, 720]);
    next.drive.give([sandbox::input::Input::Arrange(arranged.clone())]).ticks(2);
    assert!(next.has("Effects") && !next.has("Graphs"), "{arranged}");
    assert_eq!(next.session().arrangement(), arranged);
}

#[test]
fn the_first_sentence_of_accuracy_and_cost_offers_what_is_nearer_at_the_same_cost() {
    let overrides = Overrides { method: Some(Method::ExplicitEuler), ..Overrides::default() };
    let mut cockpit = Cockpit::with("orbit", [1280, 900], overrides);
    cockpit.press("C");
    let done = |cockpit: &Cockpit| cockpit.session().tools.cost_progress() == 1.0;
    for _ in 0..10_000 {
        if done(&cockpit) {
            break;
        }
        cockpit.drive.frame(0.05, []);
    }
    assert!(done(&cockpit));
    cockpit.drive.ticks(2);
    let error = |cockpit: &Cockpit| {
        let (study, setting) =
            (cockpit.session().tools.cost_study().unwrap(), cockpit.session().stage.setting());
        let cell = study.cells.iter().find(|cell| cell.setting == setting).unwrap();
        let of = |cost| study.cost(cell, cost).unwrap();
        (study.error(cell, Accuracy::Position).unwrap(), of(Cost::Evaluations))
    };
    let yours = labels(&cockpit, "Yours: up to ");
    let (before, cost_before) = error(&cockpit);
    let [yours] = &yours[..] else { panic!("{yours:?}") };
    assert!(yours.contains(&report::numbers::length(before, 2)), "{yours}: {before}");
    cockpit.click("Use");
    let (after, cost_after) = error(&cockpit);
    assert!(after * 1.5 <= before, "{before} {after}");
    assert!(cost_after <= 1.03 * cost_before, "{cost_before} {cost_after}");
    assert_eq!(cockpit.session().view.mode(), Mode::Selection);
    cockpit.click("Use");
    assert_eq!(error(&cockpit), (after, cost_after), "nothing is nearer at this cost");
}
