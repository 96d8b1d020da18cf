//! The editor: what it adds, changes and removes, undo and redo, saving, and the question before changes are lost.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::{Damping, Drag, Gravity, Method};
use sandbox::input::{Button, Input};
use sandbox::{Order, Overrides, Panel, SwitchedBy};
use scene::{BodySpec, Scene};

use crate::rigs::{Cockpit, Dice, Drive, at, middle};

/// A paused scene with the editor open.
fn editor(scene: &str) -> Cockpit {
    let mut cockpit = Cockpit::of(scene, [1600, 1200]);
    cockpit.drive.press("P").press("M").ticks(2);
    assert_eq!(cockpit.drive.session.open_panels(), [Panel::Editor]);
    cockpit
}

fn scene(cockpit: &Cockpit) -> &Scene {
    &cockpit.drive.session.stage.sim().scene
}

/// The text that saving orders to be written.
fn saved(cockpit: &mut Cockpit) -> Arc<str> {
    cockpit.drive.press("Ctrl+Shift+S");
    ordered_text(cockpit)
}

/// The text of the one order, which is to write a scene.
fn ordered_text(cockpit: &mut Cockpit) -> Arc<str> {
    let orders = cockpit.drive.session.stage.take_orders();
    let [Order::Scene(file)] = &orders[..] else { panic!("{orders:?}") };
    Arc::clone(&file.text)
}

/// The state two seconds later.
fn later(mut drive: Drive) -> u64 {
    drive.session.stage.playback_mut().limit_ticks(240);
    if drive.session.stage.playback().paused() {
        drive.press("P");
    }
    drive.ticks(240).hash()
}

#[test]
fn everything_that_can_be_added_stands_selected_and_stays_finite() {
    let mut cockpit = editor("empty");
    for (button, bodies) in [
        ("Sphere", 1),
        ("Box", 1),
        ("Post", 1),
        ("Particle", 1),
        ("Rope", 11),
        ("Cloth", 63),
        ("Jelly", 64),
        ("Emitter", 180),
    ] {
        let before = scene(&cockpit).bodies.len();
        cockpit.click(button);
        assert_eq!(scene(&cockpit).bodies.len(), before + bodies, "{button}");
        assert!(cockpit.drive.session.stage.selection().is_some(), "{button}");
        let text = &scene(&cockpit).text;
        assert!(!text.contains("-0.0,") && !text.contains("-0.0)"), "{button}: {text}");
        let clock = cockpit.drive.session.stage.sim().world.resource::<StepClock>();
        assert!(
            cockpit.drive.session.stage.playback().paused() && clock.scene_seconds() == 0.0,
            "{button}"
        );
    }
    assert_eq!(
        sandbox::Tools::forecast(&cockpit.drive.session.stage)
            .iter()
            .filter(|row| row.is_fault())
            .count(),
        0
    );
    cockpit.drive.press("P").ticks(600);
    assert_eq!(cockpit.drive.session.stage.quarantines().all(), []);
}

#[test]
fn a_handle_moves_the_selection_along_its_axis() {
    let mut cockpit = editor("tutorial");
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player).ticks(1);
    let before = cockpit.drive.x("player");
    let (from, to) =
        (cockpit.pixel(before + DVec3::Y * 8.0), cockpit.pixel(before + DVec3::Y * 15.0));
    cockpit.drag(Button::Left, from, to);
    cockpit.drive.ticks(1);
    let moved = cockpit.drive.x("player") - before;
    assert!((moved - DVec3::Y * 7.0).length() < 0.2, "{moved}");
    assert_eq!(cockpit.drive.selected().as_deref(), Some("player"));
    cockpit.drive.press("Ctrl+Z").ticks(1);
    assert_eq!(cockpit.drive.x("player"), before);
    // A drag that ends where it began is no change, and Escape leaves the body where it is.
    let changes = scene(&cockpit).text.clone();
    cockpit.drag(Button::Left, from, from);
    assert_eq!(scene(&cockpit).text, changes);
    // Behind another tab the editor has no handles.
    cockpit.click("Look");
    cockpit.drive.ticks(2);
    cockpit.drag(Button::Left, from, to);
    cockpit.drive.ticks(1);
    assert_eq!(scene(&cockpit).text, changes);
}

#[test]
fn two_clicks_join_two_bodies_and_a_point_of_a_soft_body_by_a_spring() {
    let mut cockpit = editor("tutorial");
    cockpit.click("Spring");
    for body in ["player", "enemy"] {
        let pixel = cockpit.seen(body);
        cockpit.drive.click(Button::Left, pixel).ticks(1);
    }
    let [spring] = &scene(&cockpit).springs[..] else { panic!("one spring") };
    assert_eq!(
        spring.ends.map(|end| scene(&cockpit).names.get(end).unwrap().into_owned()),
        ["player", "enemy"]
    );
    assert_eq!(spring.elastic.rest_length, 5.0);
    // Its weight stretches one of the two bodies' springs by a tenth, and its values are those of the selection.
    assert!((9.8 / spring.elastic.stiffness - 0.5).abs() < 0.01, "{spring:?}");
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player).ticks(2);
    assert!(cockpit.has("pull only") && cockpit.has("rest length"));
    // Deleted with one of its ends.
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player).press("Delete").ticks(1);
    assert!(
        scene(&cockpit).springs.is_empty()
            && cockpit.drive.session.stage.sim().named("player").is_none()
    );

    let mut cockpit = editor("rope");
    cockpit.click("Spring");
    for body in ["rope.10", "weight"] {
        let pixel = cockpit.seen(body);
        cockpit.drive.click(Button::Left, pixel).ticks(1);
    }
    let spring = scene(&cockpit).springs.last().unwrap();
    assert_eq!(scene(&cockpit).names.get(spring.ends[0]).unwrap(), "rope.10");
}

#[test]
fn a_bungee_with_an_emitter_that_rides_on_it_is_built_by_mouse() {
    let mut cockpit = editor("empty");
    cockpit.click("Post");
    // The first body of a scene is at its origin, and in the view.
    assert_eq!(scene(&cockpit).bodies[0].position, DVec3::ZERO);
    cockpit.drive.ticks(90);
    cockpit.seen("post");
    cockpit.click("Sphere");
    cockpit.click("Add emitter");
    let sphere = scene(&cockpit).names.find("sphere").unwrap();
    assert!(cockpit.has("rides on"), "it is listed with its body");
    let [emitter] = &scene(&cockpit).emitters[..] else { panic!("one emitter") };
    assert_eq!((emitter.rides_on, emitter.position), (Some(sphere), DVec3::ZERO));
    // An emitter that gets a carrier later is on it, too: the first body that moves, and none of its own particles.
    cockpit.click("Emitter");
    assert_ne!(scene(&cockpit).emitters[1].position, DVec3::ZERO);
    cockpit.click("Add a value");
    cockpit.click("rides on");
    let second = &scene(&cockpit).emitters[1];
    assert_eq!((second.rides_on, second.position), (Some(sphere), DVec3::ZERO));
    // The words about an empty scene are gone.
    assert_eq!(scene(&cockpit).description, "");
    assert!(!scene(&cockpit).text.contains("name: \"empty\""));
}

#[test]
fn a_grid_taken_apart_runs_as_before() {
    let mut cockpit = editor("tutorial");
    let pixel = cockpit.seen("grid.x4.z4");
    cockpit.drive.click(Button::Left, pixel).ticks(1);
    let before: Vec<_> = scene(&cockpit).bodies.clone();
    cockpit.click("Take apart");
    assert_eq!(scene(&cockpit).bodies, before);
    assert!(cockpit.drive.session.stage.sim().named("grid-x4-z4").is_some());
}

/// The boxes around two bodies of the scene overlap.
fn overlap(a: &BodySpec, b: &BodySpec) -> bool {
    let half =
        |body: &BodySpec| body.shape.map_or(DVec3::splat(0.15), |shape| shape.half_extents());
    (a.position - b.position).abs().cmplt(half(a) + half(b) - 1e-9).all()
}

#[test]
fn what_is_added_or_copied_stands_free_and_near_with_few_digits() {
    let mut cockpit = editor("tutorial");
    let added =
        [vec!["Sphere"; 6], vec!["Box", "Particle", "Post", "Jelly", "Rope", "Sphere", "Jelly"]]
            .concat();
    let written = scene(&cockpit).bodies.len();
    for button in added {
        cockpit.click(button);
    }
    let bodies = &scene(&cockpit).bodies;
    for (at, body) in bodies.iter().enumerate().skip(written) {
        // Points of one soft body are not free of each other.
        let others = bodies[..at].iter().filter(|other| other.shape.is_some());
        assert!(
            body.shape.is_none() || others.clone().all(|other| !overlap(body, other)),
            "{body:?}"
        );
        let digits = body.position.to_array().map(|part| format!("{part:?}").len());
        assert!(
            body.shape.is_none() || digits.iter().all(|length| *length < 8),
            "{}",
            body.position
        );
    }

    let mut cockpit = editor("tutorial");
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player).ticks(1);
    let from = cockpit.drive.x("player");
    for _ in 0..40 {
        cockpit.drive.press("Ctrl+D").ticks(1);
    }
    let last = cockpit.drive.selected().unwrap();
    assert_eq!(last, "player41");
    let far = cockpit.drive.x(&last).distance(from);
    assert!(far < 40.0 * 4.0, "{far} m");
    let text = Arc::clone(&scene(&cockpit).text);
    assert!(!text.contains("00000"), "{text}");

    // A copy of a jelly is beside all of it.
    let mut cockpit = editor("jelly");
    cockpit.drive.press("K").press("Ctrl+D").ticks(1);
    let [first, second] = [0, 1].map(|index| {
        let entry = scene(&cockpit).entry_at(&format!("soft_bodies[{index}]")).unwrap();
        entry.bodies.map(|id| scene(&cockpit).bodies[id as usize].position).collect::<Vec<_>>()
    });
    let [least, most] =
        [DVec3::min, DVec3::max].map(|end| first.iter().copied().reduce(end).unwrap());
    assert!(second.iter().all(|point| point.cmplt(least).any() || point.cmpgt(most).any()));
}

#[test]
fn deleting_one_body_of_a_grid_asks_whether_alone() {
    for (answer, left, name) in [
        ("Delete it alone", 28, Some("grid-x4-z3")),
        ("Delete all 25", 4, None),
        ("Keep it", 29, Some("grid.x4.z3")),
    ] {
        let mut cockpit = editor("tutorial");
        let pixel = cockpit.seen("grid.x4.z4");
        cockpit.drive.click(Button::Left, pixel).press("Delete").ticks(2);
        assert_eq!(scene(&cockpit).bodies.len(), 29, "asked before");
        cockpit.click(answer);
        assert_eq!(scene(&cockpit).bodies.len(), left, "{answer}");
        assert!(
            name.is_none_or(|name| cockpit.drive.session.stage.sim().named(name).is_some()),
            "{answer}"
        );
        assert!(cockpit.drive.session.stage.sim().named("grid-x4-z4").is_none());
        cockpit.drive.press("Ctrl+Z").ticks(1);
        assert_eq!(scene(&cockpit).bodies.len(), 29, "{answer}: one change");
        assert!(cockpit.drive.session.stage.sim().named("grid.x4.z4").is_some());
    }
}

#[test]
fn what_was_set_without_the_editor_is_saved_and_survives_a_change() {
    let mut cockpit = editor("tutorial");
    cockpit.drive.press("G").press("I").ticks(1);
    let method = cockpit.drive.session.stage.sim().stepper.method();
    assert_ne!(method, Method::default());
    cockpit.click("Sphere");
    assert_eq!(cockpit.drive.session.stage.sim().stepper.method(), method);
    assert!(cockpit.drive.session.stage.sim().world.resource::<Gravity>().on);
    let text = saved(&mut cockpit);
    assert!(text.contains(method.name()) && text.contains("on_at_start: true"), "{text}");
    assert!(text.contains("// Inverse mass 0: no force moves it"), "comments stay");
    cockpit.drive.press("Ctrl+Z").ticks(1);
    assert_eq!(
        cockpit.drive.session.stage.sim().stepper.method(),
        method,
        "undo takes the sphere back, not the method"
    );
    assert_eq!(scene(&cockpit).bodies.len(), 29);
}

#[test]
fn undo_and_redo_keep_a_method_that_was_chosen_after_the_change() {
    let mut cockpit = editor("tutorial");
    cockpit.click("Sphere");
    for (keys, bodies) in [("Ctrl+Z", 29), ("Ctrl+Shift+Z", 30)] {
        cockpit.drive.press("I").press("G").ticks(1);
        let chosen = |cockpit: &Cockpit| {
            let session = &cockpit.drive.session;
            (
                session.stage.sim().stepper.method(),
                session.stage.sim().world.resource::<Gravity>().on,
            )
        };
        let before = chosen(&cockpit);
        cockpit.drive.press(keys).ticks(1);
        assert_eq!(scene(&cockpit).bodies.len(), bodies, "{keys}");
        assert_eq!(chosen(&cockpit), before, "{keys}");
    }
}

#[test]
fn what_is_switched_off_stays_off_through_a_change_and_a_save() {
    let mut cockpit = editor("everything");
    let switch = |cockpit: &mut Cockpit, effect, on| {
        cockpit.drive.session.stage.switch_effect(effect, on, SwitchedBy::Panel).unwrap();
    };
    let is_on = |cockpit: &Cockpit| {
        let world = &cockpit.drive.session.stage.sim().world;
        (world.contains_resource::<Damping>(), world.contains_resource::<Drag>())
    };
    switch(&mut cockpit, Effect::Damping, false);
    switch(&mut cockpit, Effect::Drag, false);
    cockpit.click("Sphere");
    assert_eq!(is_on(&cockpit), (false, false));
    let text = saved(&mut cockpit);
    assert!(text.contains("off_at_start: [damping, drag]"), "{text}");
    let again = Drive::text(&text);
    assert_eq!(again.session.stage.sim().scene.off_at_start, [Effect::Damping, Effect::Drag]);
    assert_eq!(again.hash(), cockpit.drive.hash());
    // A reset keeps what was switched since, too.
    switch(&mut cockpit, Effect::Damping, true);
    cockpit.drive.press("F1").ticks(1);
    assert_eq!(is_on(&cockpit), (true, false));
    switch(&mut cockpit, Effect::Drag, true);
    let text = saved(&mut cockpit);
    assert!(!text.contains("off_at_start"), "{text}");
    assert_eq!(later(Drive::text(&text)), later(cockpit.drive));
}

#[test]
fn a_change_that_makes_no_scene_says_why_and_changes_nothing() {
    let mut cockpit = editor("tutorial");
    let player = cockpit.seen("player");
    cockpit.drive.click(Button::Left, player).ticks(2);
    let before = Arc::clone(&scene(&cockpit).text);
    let field =
        cockpit.drive.find(|control| control.role == "TextInput" && control.name == "player");
    cockpit.drive.click(Button::Left, middle(&field)).ticks(2);
    assert!(cockpit.drive.session.takes_text());
    cockpit.drive.give([Input::Text(" one".to_owned())]).press("Enter").ticks(2);
    assert_eq!(scene(&cockpit).text, before);
    let controls = cockpit.drive.session.controls();
    assert!(
        controls.iter().any(|control| control.name.contains("\"player one\" cannot be a name")),
        "{controls:#?}"
    );
}

#[test]
fn unsaved_changes_are_asked_about_before_they_are_left() {
    let mut cockpit = editor("tutorial");
    cockpit.drive.press("]");
    assert_eq!(
        cockpit.drive.session.stage.take_orders(),
        [Order::Open("tutorial_large".to_owned())]
    );
    cockpit.click("Sphere");
    assert!(cockpit.drive.session.has_unsaved_changes());
    let asked = |cockpit: &mut Cockpit, answer: &str| {
        cockpit.drive.press("Ctrl+Q").ticks(2);
        assert_eq!(cockpit.drive.session.stage.take_orders(), []);
        match answer {
            "Escape" => cockpit.drive.press("Escape").ticks(2).session.stage.take_orders(),
            answer => {
                cockpit.click(answer);
                cockpit.drive.session.stage.take_orders()
            }
        }
    };
    assert_eq!(asked(&mut cockpit, "Stay"), []);
    assert_eq!(asked(&mut cockpit, "Escape"), []);
    let orders = asked(&mut cockpit, "Save as tutorial.ron");
    assert!(matches!(&orders[..], [Order::Scene(_), Order::Quit]), "{orders:?}");
    assert_eq!(asked(&mut cockpit, "Discard them"), [Order::Quit]);
    cockpit.drive.press("Ctrl+Q").ticks(2);
    assert_eq!(cockpit.drive.session.stage.take_orders(), [Order::Quit], "asked once");
}

/// The editor with body `a` selected, whose mass has many digits, and the middle of the field of that mass.
fn with_a_mass() -> (Cockpit, DVec2) {
    let text = "(version: 1, camera: (position_m: (0, 0, 10), pitch_deg: 0, yaw_deg: 0), bodies: [
        (name: \"a\", shape: sphere(radius_m: 1), position_m: (-2, 0, 0), mass_kg: 0.1234567891),
        (name: \"b\", shape: sphere(radius_m: 1), position_m: (2, 0, 0), mass_kg: 2),
    ])";
    let mut cockpit = Cockpit::of("empty", [1600, 1200]);
    cockpit.drive.session.open(Scene::parse("t", text).unwrap());
    cockpit.drive.press("P").press("M").ticks(2);
    let a = cockpit.seen("a");
    cockpit.drive.click(Button::Left, a).ticks(2);
    let field = cockpit.drive.find(|control| control.role == "SpinButton" && control.name == "kg");
    (cockpit, middle(&field))
}

#[test]
fn a_field_that_is_only_visited_changes_nothing_and_escape_takes_back_what_was_typed() {
    let (mut cockpit, field) = with_a_mass();
    let before = Arc::clone(&scene(&cockpit).text);
    cockpit.drive.click(Button::Left, field).ticks(3).press("Enter").ticks(3);
    assert_eq!(scene(&cockpit).text, before);
    cockpit.drive.click(Button::Left, field).ticks(3);
    assert!(cockpit.drive.session.takes_text());
    cockpit.drive.give([Input::Text("7".to_owned())]).ticks(2).press("Escape").ticks(4);
    assert_eq!(scene(&cockpit).text, before);
    cockpit.drive.click(Button::Left, field).ticks(3);
    cockpit.drive.give([Input::Text("7".to_owned())]).ticks(2).press("Enter").ticks(3);
    assert_eq!(scene(&cockpit).bodies[0].inverse_mass, Some(1.0 / 7.0));
}

#[test]
fn a_typed_value_is_taken_when_another_body_is_clicked_and_when_the_scene_is_saved() {
    let (mut cockpit, field) = with_a_mass();
    let b = cockpit.seen("b");
    cockpit.drive.click(Button::Left, field).ticks(3);
    cockpit.drive.give([Input::Text("7".to_owned())]).ticks(2).click(Button::Left, b).ticks(3);
    assert_eq!(scene(&cockpit).bodies[0].inverse_mass, Some(1.0 / 7.0));
    assert_eq!(cockpit.drive.selected().as_deref(), Some("b"));

    let (mut cockpit, field) = with_a_mass();
    cockpit.drive.click(Button::Left, field).ticks(3);
    cockpit.drive.give([Input::Text("5".to_owned())]).ticks(2).press("Ctrl+Shift+S").ticks(1);
    let text = ordered_text(&mut cockpit);
    assert!(text.contains("mass_kg: 5.0"), "{text}");
}

/// One thing that a person does in the editor.
#[derive(Clone, Copy, Debug)]
enum Deed {
    Add(&'static str),
    Duplicate(usize),
    Delete(usize),
    Move(usize, f64),
}

impl Deed {
    fn by_chance(dice: &mut Dice) -> Self {
        let body = dice.below(1000);
        match dice.below(6) {
            0..3 => Self::Add(["Sphere", "Box", "Particle", "Rope", "Jelly"][dice.below(5)]),
            3 => Self::Duplicate(body),
            4 => Self::Delete(body),
            _ => Self::Move(body, 60.0 * dice.number()),
        }
    }

    fn done(self, cockpit: &mut Cockpit) {
        let select = |cockpit: &mut Cockpit, body: usize| {
            let session = &cockpit.drive.session;
            let things: Vec<_> = session.stage.sim().remaining_bodies().collect();
            let name = session.stage.name(things[body % things.len()]);
            let pixel = cockpit.seen(&name);
            // Beside everything first: the arrows of what was selected would take the click.
            let corner = cockpit.view()[0] + DVec2::splat(8.0);
            cockpit.drive.click(Button::Left, corner).ticks(1).click(Button::Left, pixel).ticks(1);
            pixel
        };
        match self {
            Self::Add(button) => cockpit.click(button),
            Self::Duplicate(body) => {
                select(cockpit, body);
                cockpit.drive.press("Ctrl+D").ticks(1);
            }
            Self::Delete(body) => {
                select(cockpit, body);
                cockpit.drive.press("Delete").ticks(1);
                if cockpit.drive.session.asks() {
                    cockpit.click(if body % 2 == 0 { "Delete it alone" } else { "Delete all 25" });
                }
            }
            Self::Move(body, by) => {
                let pixel = select(cockpit, body);
                let up = pixel - DVec2::new(0.0, 60.0);
                cockpit.drag(Button::Left, up, up - DVec2::new(0.0, by));
            }
        }
        cockpit.drive.ticks(1);
    }
}

#[test]
fn changes_undone_and_redone_are_the_changes_that_are_left_and_saved_they_are_the_same_scene() {
    for (seed, name) in
        [(1, "tutorial"), (2, "third_law"), (3, "rope"), (4, "tutorial"), (5, "bridge")]
    {
        let mut dice = Dice(seed);
        let mut cockpit = editor(name);
        let (mut done, mut undone): (Vec<Deed>, Vec<Deed>) = (Vec::new(), Vec::new());
        for _ in 0..25 {
            match dice.below(6) {
                0 => {
                    cockpit.drive.press("Ctrl+Z").ticks(1);
                    undone.extend(done.pop());
                }
                1 => {
                    cockpit.drive.press("Ctrl+Y").ticks(1);
                    done.extend(undone.pop());
                }
                _ => {
                    let deed = Deed::by_chance(&mut dice);
                    let before = Arc::clone(&scene(&cockpit).text);
                    deed.done(&mut cockpit);
                    if scene(&cockpit).text != before {
                        done.push(deed);
                        undone.clear();
                    }
                }
            }
        }
        assert!(done.len() > 3, "{name}: {done:?}");
        let mut fresh = editor(name);
        for deed in &done {
            deed.done(&mut fresh);
        }
        assert_eq!(scene(&cockpit).text, scene(&fresh).text, "{name}: {done:?}");

        let text = saved(&mut cockpit);
        let loaded = scene(&cockpit).reread(&text).unwrap();
        assert_eq!(
            sandbox::plan::text(loaded.clone(), Overrides::default()),
            sandbox::plan::text(scene(&fresh).clone(), Overrides::default())
        );
        let hashes = [cockpit.drive, fresh.drive, Drive::of(loaded)].map(later);
        assert!(hashes[0] == hashes[1] && hashes[0] == hashes[2], "{name}: {hashes:x?}");
    }
}

#[test]
fn undo_follows_the_pointer_into_every_mode() {
    let mut cockpit = editor("tutorial");
    cockpit.click("Sphere");
    // Also with the bars hidden and the camera flying.
    cockpit.drive.press("F10").press("Q").press("Ctrl+Z").ticks(1);
    assert_eq!(scene(&cockpit).bodies.len(), 29);
    cockpit.drive.press("Ctrl+Shift+Z").ticks(1);
    assert_eq!(scene(&cockpit).bodies.len(), 30);
    cockpit.drive.give([at(DVec2::ZERO)]);
}
