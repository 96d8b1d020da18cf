//! The cockpit: bars, browser and dock around the view, and what the mouse does there.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{Gravity, Method, PhysicsBody, Quarantine, SoftBody, Substeps, Transform};
use sandbox::input::{Button, Input};
use sandbox::{Control, Mode, Options, Order, Overrides, Panel};

use crate::rigs::{Cockpit, Drive, H, at, click, down, middle, scene_of, tap, up};

/// A place of the view where nothing is.
fn empty_place(cockpit: &Cockpit) -> DVec2 {
    let [corner, size] = cockpit.view();
    corner + size * DVec2::new(0.5, 0.08)
}

#[test]
fn hiding_the_bars_hides_the_panels_of_the_dock_and_a_key_or_the_bars_bring_them_back() {
    let mut cockpit = Cockpit::of("orbit", [1280, 720]);
    for key in ["B", "T", "V"] {
        cockpit.press(key);
    }
    let windows = |cockpit: &Cockpit| {
        let titles = ["Ledger", "Ghosts", "Forecast"];
        let controls = cockpit.session().controls();
        titles
            .into_iter()
            .filter(|title| controls.iter().any(|control| control.name == *title))
            .count()
    };
    cockpit.press("F10");
    assert_eq!((windows(&cockpit), cockpit.session().open_panels().len()), (0, 3));
    assert!(cockpit.session().tools.ledger().is_some(), "its totals continue");
    cockpit.press("B");
    assert_eq!(windows(&cockpit), 1);
    cockpit.press("Escape");
    assert_eq!((windows(&cockpit), cockpit.session().open_panels().len()), (0, 2));
    cockpit.press("F10");
    assert!(cockpit.has("Ghosts") && cockpit.has("Forecast"));
    assert_eq!(cockpit.session().open_panels().len(), 2);
}

#[test]
fn the_camera_of_a_scene_without_one_comes_back_to_its_bodies() {
    let folder = crate::rigs::folder([(
        "far.ron",
        "(version: 1, bodies: [(name: \"ball\", shape: sphere(radius_m: 0.1), position_m: (500, 0, 0))])",
    )]);
    let path = folder.path().join("far.ron");
    let distance =
        |cockpit: &Cockpit| cockpit.viewpoint().position.distance(cockpit.drive.x("ball"));
    let mut cockpit = Cockpit::of(path.to_str().unwrap(), [1280, 720]);
    assert!(distance(&cockpit) > 100.0);
    cockpit.press("F2");
    assert!(distance(&cockpit) < 10.0, "{} m", distance(&cockpit));
}

#[test]
fn the_view_is_what_bars_browser_and_dock_leave_and_nothing_overlaps() {
    for (size, scale) in [
        ([1024, 600], 1.0),
        ([1280, 720], 1.0),
        ([1280, 720], 1.5),
        ([2560, 1440], 1.0),
        ([2560, 1440], 2.0),
    ] {
        let mut cockpit = Cockpit::of("everything", size);
        cockpit.drive.give([Input::Scaled(scale)]).ticks(2);
        for key in
            [None, Some("Tab"), Some("E"), Some("C"), Some("T"), Some("B"), Some("V"), Some("R")]
        {
            if let Some(key) = key {
                cockpit.drive.press(key).ticks(3);
            }
            let [corner, area] = cockpit.view();
            let (end, case) = (corner + area, format!("{size:?} x {scale}, {key:?}"));
            let whole = DVec2::from_array(size.map(f64::from));
            assert!(
                corner.cmpge(DVec2::ZERO).all() && end.cmple(whole).all(),
                "{case}: {corner} {end}"
            );
            assert!(area.x > 0.3 * whole.x && area.y > 0.8 * whole.y, "{case}: {area}");
            for control in cockpit.session().controls() {
                // What a dock has scrolled away is beyond its edges; what is inside the screen stays out of the view.
                let at = middle(&control);
                let inside = at.cmpgt(corner + 1.0).all() && at.cmplt(end - 1.0).all();
                assert!(
                    !inside,
                    "{case}: {} at {at} is over the view {corner} {end}",
                    control.name
                );
            }
        }
    }
}

#[test]
fn f10_shows_the_cockpit_with_a_free_pointer_and_hides_it() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    assert_eq!(cockpit.session().view.mode(), Mode::Selection);
    assert!(cockpit.view()[0].y > 0.0);
    cockpit.drive.press("F10").ticks(2);
    assert_eq!(cockpit.view(), [DVec2::ZERO, DVec2::new(1280.0, 720.0)]);
}

#[test]
fn buttons_do_what_their_keys_do() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let gravity = |cockpit: &Cockpit| cockpit.session().stage.sim().world.resource::<Gravity>().on;
    cockpit.click("Gravity");
    assert!(gravity(&cockpit));
    cockpit.click("Gravity");
    assert!(!gravity(&cockpit));
    cockpit.click("Pause");
    assert!(cockpit.session().stage.playback().paused());
    let ticks = cockpit.session().stage.sim().ticks();
    cockpit.click("Step");
    assert_eq!(cockpit.session().stage.sim().ticks(), ticks + 1);
    cockpit.click("Play");
    assert!(!cockpit.session().stage.playback().paused());
    cockpit.click("Build");
    assert_eq!(cockpit.session().open_panels(), [Panel::Editor], "no tab is empty");
    cockpit.click("Settings");
    assert_eq!(cockpit.session().open_panels(), [Panel::Editor, Panel::Settings]);
    cockpit.click("Settings");
    assert_eq!(cockpit.session().open_panels(), [Panel::Editor]);
    cockpit.click("Fly");
    assert_eq!(cockpit.session().view.mode(), Mode::Camera);
}

#[test]
fn back_and_step_repeat_while_they_are_held_and_act_once_when_they_are_clicked() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.session.stage.keep_timeline();
    cockpit.click("Pause");
    for (name, forward) in [("Step", true), ("Back", false)] {
        let (middle, from) = (cockpit.middle_of(name), cockpit.session().stage.sim().ticks());
        cockpit
            .drive
            .frame(H, [at(middle)])
            .frame(H, [Input::ButtonDown(Button::Left)])
            .run(60, 1.0 / 60.0);
        cockpit.drive.frame(H, [Input::ButtonUp(Button::Left)]).ticks(3);
        let moved = cockpit.session().stage.sim().ticks().abs_diff(from);
        assert!((5..=20).contains(&moved), "{name}: {moved} in a second");
        assert_eq!(cockpit.session().stage.sim().ticks() > from, forward);
        let from = cockpit.session().stage.sim().ticks();
        cockpit.click(name);
        assert_eq!(cockpit.session().stage.sim().ticks().abs_diff(from), 1, "{name}");
    }
}

#[test]
fn enter_in_the_finder_opens_a_file_of_yours_that_has_what_is_typed_in_its_name() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let files = ["scenes/my_own_bridge.ron", "scenes/other.ron"].map(std::path::PathBuf::from);
    cockpit.drive.session.stage.files.remember(files.to_vec());
    cockpit.drive.frame(H, tap("Ctrl+O")).ticks(2);
    cockpit.drive.frame(H, [Input::Text("own_b".to_owned())]).frame(H, tap("Enter"));
    let orders = cockpit.drive.session.stage.take_orders();
    assert_eq!(orders, [Order::Open("scenes/my_own_bridge.ron".to_owned())]);
}

#[test]
fn the_browser_opens_a_scene_by_its_name_and_finds_it_by_its_description() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.click("tutorial large");
    let opened = [Order::Open("tutorial_large".to_owned())];
    assert_eq!(cockpit.drive.session.stage.take_orders(), opened);

    let field = middle(&cockpit.drive.find(|control| control.role == "TextInput"));
    cockpit.drive.click(Button::Left, field).ticks(2);
    assert!(cockpit.session().takes_text());
    cockpit.drive.give([Input::Text("gusty".to_owned())]).ticks(2);
    let names: Vec<_> =
        cockpit.session().controls().into_iter().map(|control| control.name).collect();
    assert!(
        names.contains(&"flag".to_owned()) && !names.contains(&"frame step".to_owned()),
        "{names:?}"
    );
}

#[test]
fn the_search_finds_scenes_by_their_group_and_by_what_they_show() {
    for (words, finds, leaves_out) in [
        ("soft", "jelly", "orbit"),
        ("cloth", "flag", "projectile"),
        ("energy", "oscillator", "wall"),
        ("Particles", "sparks", "orbit"),
        ("orbits_race", "orbits race", "flag"),
    ] {
        let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
        cockpit.press("F6").press("F6");
        cockpit.drive.give([Input::Text(words.to_owned())]).ticks(2);
        let names: Vec<_> =
            cockpit.session().controls().into_iter().map(|control| control.name).collect();
        let has = |name: &str| names.iter().any(|other| other == name);
        assert!(has(finds) && !has(leaves_out), "{words}: {names:?}");
    }
}

#[test]
fn scene_files_of_earlier_windows_are_listed_and_found() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.session.stage.files.remember(vec!["/a/older.ron".into(), "/b/swing.ron".into()]);
    cockpit.drive.ticks(2);
    cockpit.click("swing.ron");
    assert_eq!(cockpit.drive.session.stage.take_orders(), [Order::Open("/b/swing.ron".to_owned())]);
    cockpit.press("F8").press("Ctrl+O");
    cockpit.click("older.ron");
    assert_eq!(cockpit.drive.session.stage.take_orders(), [Order::Open("/a/older.ron".to_owned())]);
}

#[test]
fn every_shipped_scene_is_in_the_browser_and_those_of_no_group_are_hard_cases() {
    let cockpit = Cockpit::of("tutorial", [1280, 9000]);
    let controls = cockpit.session().controls();
    let top = |name: &str| {
        controls.iter().find(|control| control.name == name).map(|control| control.rect_px[1])
    };
    let heading = top("Hard cases").unwrap();
    let place = |name: &str| top(&name.replace('_', " "));
    for scene in scene::shipped() {
        assert!(place(scene.name).is_some_and(|top| top < heading), "{}", scene.name);
    }
    for scene in scene::cases() {
        assert!(place(scene.name).is_some_and(|top| top > heading), "{}", scene.name);
    }
}

#[test]
fn a_drag_pulls_a_body_to_the_pointer_and_a_click_only_selects_it() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let from = cockpit.seen("player");
    cockpit.drive.click(Button::Left, from).ticks(60);
    assert_eq!(cockpit.drive.selected().as_deref(), Some("player"));
    assert_eq!(cockpit.drive.v("player"), DVec3::ZERO);

    let to = from + DVec2::new(80.0, -40.0);
    cockpit.drive.give([at(from), Input::ButtonDown(Button::Left), at(from.lerp(to, 0.5)), at(to)]);
    cockpit.drive.ticks(240);
    let (seen, speed) = (cockpit.seen("player"), cockpit.drive.v("player").length());
    // It was taken near its middle, and nothing else pulls it.
    assert!(seen.distance(to) < 3.0 && speed < 0.05, "{seen} {to} {speed}");
    cockpit.drive.give([Input::ButtonUp(Button::Left)]).ticks(1);
    let still = cockpit.drive.v("player");
    cockpit.drive.give([at(from)]).ticks(60);
    assert!(
        cockpit.drive.v("player").length() <= still.length(),
        "let go, it is not pulled any more"
    );
}

#[test]
fn what_is_pulled_comes_to_the_pointer_and_not_beyond() {
    let text = "(version: 1, camera: (position_m: (0, 0, 10), pitch_deg: 0, yaw_deg: 0), bodies: [
        (name: \"ball\", shape: sphere(radius_m: 1), mass_kg: 3),
    ])";
    let mut cockpit = Cockpit::of("empty", [1280, 720]);
    cockpit.drive.session.open(scene::Scene::parse("t", text).unwrap());
    cockpit.drive.ticks(2);
    let from = cockpit.seen("ball");
    let by = DVec2::new(120.0, -60.0);
    cockpit.drive.give([at(from), Input::ButtonDown(Button::Left)]);
    cockpit.drive.give([at(from + by)]);
    let mut farthest = 0.0_f64;
    for _ in 0..360 {
        cockpit.drive.ticks(1);
        farthest = farthest.max((cockpit.seen("ball") - from).dot(by));
    }
    // It was taken at its surface, which is nearer than its middle.
    let end = (cockpit.seen("ball") - from).dot(by);
    assert!(
        end > 0.85 * by.length_squared() && farthest < 1.05 * end,
        "it goes {farthest}, and ends at {end}"
    );
}

#[test]
fn a_jelly_is_lifted_by_one_of_its_points() {
    let mut cockpit = Cockpit::of("jelly", [1280, 720]);
    let [corner, size] = cockpit.view();
    let height = |cockpit: &mut Cockpit| {
        let world = cockpit.drive.session.stage.world_mut();
        let soft = world.query::<&SoftBody>().single(world).unwrap().clone();
        let heights =
            soft.points.iter().map(|point| world.get::<Transform>(*point).unwrap().position.y);
        heights.sum::<f64>() / soft.points.len() as f64
    };
    let is_soft = |cockpit: &Cockpit| cockpit.drive.selected().as_deref() == Some("jelly");
    let mut places = (1..40).map(|i| corner + size * f64::from(i) / 40.0);
    let from = places.find(|place| {
        cockpit.drive.click(Button::Left, *place);
        is_soft(&cockpit)
    });
    let (from, before) = (from.unwrap(), height(&mut cockpit));
    cockpit.drive.give([at(from), Input::ButtonDown(Button::Left)]);
    cockpit.drive.give([at(from - DVec2::new(0.0, 0.3 * size.y))]).ticks(90);
    let rise = height(&mut cockpit) - before;
    assert!(rise > 0.6, "{rise} m");
}

#[test]
fn a_newborn_particle_is_drawn_where_it_is_born_and_not_on_its_way_from_its_last_life() {
    // As many drops as live at once, and fewer: then each is taken out of its flight.
    for capacity in [30, 20] {
        let text = format!(
            "(version: 1, emitters: [(name: \"drop\", rate_per_s: 30, position_m: (0, 5, 0), direction: (1, 0, 0),
            speed_m_s: 10, life_s: 1, capacity: {capacity})])"
        );
        let mut drive = Drive::with(
            scene::Scene::parse("t", &text).unwrap(),
            Options { pictures: true, interpolate: true, ..Options::default() },
        );
        let (mut born, mut before) = (0, Vec::new());
        // Frames that end within ticks, over several lives.
        for _ in 0..400 {
            drive.frame(0.75 * H, []);
            let frame = drive.session.picture();
            let eye = drive.session.view.camera().position;
            let xs: Vec<_> =
                frame.sprites.iter().map(|drop| f64::from(drop.position[0]) + eye.x).collect();
            born += usize::from(xs.len() == capacity && before != xs);
            // A drop is born at 0 and flies away; on its way back from there it would be seen against the stream.
            let mut sorted = xs.clone();
            sorted.sort_by(f64::total_cmp);
            let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
            assert!(gaps.clone().all(|gap| gap > 0.1), "{sorted:?}");
            before = xs;
        }
        assert!(born > 100);
    }
}

#[test]
fn what_is_not_seen_is_simulated_and_not_laid_out() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.session.set_unseen(true);
    let ticks = cockpit.session().stage.sim().ticks();
    let pause = cockpit.middle_of("Pause");
    cockpit
        .drive
        .press("Tab")
        .ticks(10)
        .frame(H, [at(pause)])
        .frame(H, click(Button::Left))
        .ticks(3);
    assert!(
        cockpit.session().stage.sim().ticks() >= ticks + 15
            && !cockpit.has("Moon")
            && !cockpit.session().stage.playback().paused()
    );
    cockpit.drive.session.set_unseen(false);
    cockpit.drive.ticks(3);
    assert!(
        cockpit.has("Moon") && cockpit.session().stage.playback().paused(),
        "the click is not lost"
    );
}

#[test]
fn a_click_just_beside_a_button_belongs_to_the_view() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    // Without the list of scenes the view begins below the button.
    cockpit.press("F8");
    let below = cockpit.middle_of("Pause").with_y(cockpit.view()[0].y + 1.0);
    assert!(below.x > cockpit.view()[0].x);
    cockpit.drive.click(Button::Left, below).ticks(2);
    assert!(!cockpit.session().stage.playback().paused());
    let camera = *cockpit.session().view.camera();
    cockpit.drag(Button::Right, below, below + DVec2::X * 50.0);
    assert_ne!(*cockpit.session().view.camera(), camera, "a drag from there orbits");
}

#[test]
fn soft_bodies_bear_a_hard_pull() {
    for scene in ["jelly", "flag", "rope", "cape"] {
        let mut cockpit = Cockpit::of(scene, [1280, 720]);
        let size = cockpit.view()[1];
        let world = cockpit.drive.session.stage.world_mut();
        let softs: Vec<_> = world.query::<&SoftBody>().iter(world).cloned().collect();
        let position = |point: &Entity| {
            cockpit.session().stage.sim().world.get::<Transform>(*point).unwrap().position
        };
        let points = softs.iter().flat_map(|soft| &soft.points);
        let places: Vec<_> = points.map(|point| cockpit.pixel(position(point))).collect();
        let is_soft = |cockpit: &Cockpit| {
            let selected = cockpit.session().stage.selection();
            selected.is_some_and(|thing| {
                cockpit.session().stage.sim().world.get::<SoftBody>(thing).is_some()
            })
        };
        let found = places.into_iter().rev().find(|place| {
            cockpit.drive.click(Button::Left, *place);
            is_soft(&cockpit)
        });
        let from = found.unwrap_or_else(|| panic!("nothing soft in {scene}"));
        cockpit.drive.give([at(from), Input::ButtonDown(Button::Left)]);
        for tick in 0..360_u32 {
            let around = DVec2::from_angle(f64::from(tick) * 0.05) * 0.3 * size.y;
            cockpit.drive.frame(H, [at(from + around)]);
        }
        let bad = cockpit.session().stage.sim().world.resource::<Quarantine>();
        assert_eq!(bad.records().len(), 0, "{scene}");
    }
}

#[test]
fn orbiting_keeps_what_was_under_the_pointer_and_panning_takes_it_along() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let player = cockpit.drive.x("player");
    let from = cockpit.pixel(player);
    let distance = cockpit.viewpoint().position.distance(player);
    cockpit.drag(Button::Right, from, from + DVec2::new(150.0, 30.0));
    // The pivot is on its surface.
    assert!(cockpit.pixel(player).distance(from) < 8.0, "{} {from}", cockpit.pixel(player));
    assert!((cockpit.viewpoint().position.distance(player) - distance).abs() < 2.0);

    let from = cockpit.pixel(player);
    let to = from + DVec2::new(-60.0, 40.0);
    cockpit.drag(Button::Middle, from, to);
    assert!(cockpit.pixel(player).distance(to) < 3.0, "{} {to}", cockpit.pixel(player));
}

#[test]
fn the_wheel_zooms_while_nothing_is_selected_and_else_changes_the_force() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let player = cockpit.drive.x("player");
    let (pixel, force) = (cockpit.pixel(player), cockpit.session().view.click_force());
    let distance = cockpit.viewpoint().position.distance(player);
    cockpit.drive.give([at(pixel), Input::Wheel(3.0)]);
    let nearer = cockpit.viewpoint().position.distance(player);
    assert!(
        nearer < 0.8 * distance && cockpit.pixel(player).distance(pixel) < 3.0,
        "{distance} {nearer}"
    );
    assert_eq!(cockpit.session().view.click_force(), force);
    cockpit.drive.give(click(Button::Left)).give([Input::Wheel(1.0)]);
    assert_eq!(cockpit.session().view.click_force(), force + 100.0);
    assert_eq!(cockpit.viewpoint().position.distance(player), nearer);
}

#[test]
fn a_right_click_at_the_selection_pushes_and_does_not_orbit() {
    let told = |cockpit: &Cockpit| {
        cockpit.session().stage.notices.texts().any(|text| text.starts_with("click a body first"))
    };
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let pixel = cockpit.seen("player");
    cockpit.drag(Button::Right, pixel, pixel + DVec2::new(50.0, 0.0));
    assert!(!told(&cockpit), "a drag turns the camera");
    cockpit.press("F2").drive.ticks(2);
    let pixel = cockpit.seen("player");
    cockpit.drive.click(Button::Right, pixel).ticks(1);
    assert!(told(&cockpit) && cockpit.drive.v("player").length() == 0.0);
    let camera = *cockpit.session().view.camera();
    cockpit.drive.click(Button::Left, pixel);
    cockpit.drag(Button::Right, pixel, pixel + DVec2::new(50.0, 0.0));
    cockpit.drive.ticks(2);
    assert!(cockpit.drive.v("player").length() > 0.0);
    assert_eq!(*cockpit.session().view.camera(), camera);
    let empty = empty_place(&cockpit);
    cockpit.drag(Button::Right, empty, empty + DVec2::new(50.0, 0.0));
    assert_ne!(*cockpit.session().view.camera(), camera);
}

#[test]
fn a_click_on_the_floor_deselects_and_a_floor_that_is_selected_takes_nothing_away() {
    for held in ["Alt", "Ctrl"] {
        let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
        let [corner, size] = cockpit.view();
        let (player, floor) = (cockpit.seen("player"), corner + size * DVec2::new(0.5, 0.9));
        assert_eq!(cockpit.drive.select(player).as_deref(), Some("player"));
        assert_eq!(cockpit.drive.select(floor), None);
        cockpit.drive.give([down(held)]);
        assert!(
            cockpit
                .drive
                .session
                .picture()
                .cuboids
                .iter()
                .any(|body| body.surface & render::OUTLINED != 0)
        );
        assert_eq!(cockpit.drive.select(floor).as_deref(), Some("floor"));
        cockpit.drive.give([up(held)]).ticks(2);
        let green = [0.0, 1.0, 0.0, 1.0];
        assert!(cockpit.drive.session.picture().cuboids.iter().all(|body| body.color != green));
        let hint = |name: &str| name.starts_with("floor: forces do not move it. Right drag orbits");
        assert!(cockpit.session().controls().iter().any(|control| hint(&control.name)));

        let (camera, force) =
            (*cockpit.session().view.camera(), cockpit.session().view.click_force());
        cockpit.drag(Button::Right, floor, floor + DVec2::new(50.0, 0.0));
        let orbited = *cockpit.session().view.camera();
        assert_ne!(orbited, camera);
        cockpit.drive.give([Input::Wheel(1.0)]);
        assert_ne!(*cockpit.session().view.camera(), orbited);
        assert_eq!(cockpit.session().view.click_force(), force);
        assert_eq!(cockpit.drive.select(floor), None, "a click beside a body deselects");
    }
}

#[test]
fn framing_shows_all_that_moves_and_then_the_selection_alone() {
    let scenes = ["tutorial", "thousand", "orbits_race", "flag", "everything"];
    // Wider than high, and higher than wide.
    for (scene, size) in
        scenes.into_iter().flat_map(|scene| [(scene, [1024, 600]), (scene, [1000, 1400])])
    {
        let mut cockpit = Cockpit::of(scene, size);
        cockpit.drive.press("P").press("F").ticks(1);
        let [corner, size] = cockpit.view();
        let bodies: Vec<_> = cockpit.session().stage.sim().remaining_bodies().collect();
        let world = &cockpit.session().stage.sim().world;
        let moving = bodies.into_iter().filter(|thing| {
            world.get::<PhysicsBody>(*thing).is_some_and(|body| body.inverse_mass > 0.0)
        });
        for thing in moving {
            let place = world.get::<Transform>(thing).unwrap().position;
            let inside = cockpit.pixel(place) - corner;
            assert!(
                inside.cmpge(DVec2::ZERO).all() && inside.cmple(size).all(),
                "{scene}: {inside} {size}"
            );
        }
    }
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let (pixel, before) = (cockpit.seen("player"), cockpit.viewpoint().position);
    cockpit.drive.click(Button::Left, pixel).press("F").ticks(1);
    let [corner, size] = cockpit.view();
    assert!(cockpit.seen("player").distance(corner + size / 2.0) < 1.0);
    assert!(cockpit.viewpoint().position.distance(before) > 10.0);
}

#[test]
fn the_toolbar_changes_method_and_substeps() {
    let mut cockpit = Cockpit::of("orbit", [1280, 720]);
    let before = cockpit.session().stage.sim().stepper.method();
    assert_ne!(before, Method::RungeKutta4);
    cockpit.click("method of integration (I and Shift+I)");
    cockpit.click(Method::RungeKutta4.claims().title);
    assert_eq!(cockpit.session().stage.sim().stepper.method(), Method::RungeKutta4);

    let substeps = |cockpit: &Cockpit| cockpit.session().stage.sim().world.resource::<Substeps>().0;
    assert_eq!(substeps(&cockpit), 1);
    // The list that was chosen from is closed; open again, it has the substeps below the methods.
    assert!(!cockpit.has(Method::ExplicitEuler.claims().title));
    cockpit.click("method of integration (I and Shift+I)");
    let last = cockpit.middle_of(Method::ALL[Method::ALL.len() - 1].claims().title).y;
    let below = |control: &Control| control.role == "SpinButton" && middle(control).y > last;
    let number = middle(&cockpit.drive.find(below));
    cockpit.drag(Button::Left, number, number + DVec2::X * 40.0);
    cockpit.drive.ticks(2);
    assert!((3..=5).contains(&substeps(&cockpit)), "{}", substeps(&cockpit));
}

#[test]
fn a_body_that_moves_is_pulled_where_it_was_pressed() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.press("G").ticks(30);
    let from = cockpit.seen("player");
    cockpit.drive.give([at(from), Input::ButtonDown(Button::Left)]).ticks(60);
    let speed = cockpit.drive.v("player").y;
    cockpit.drive.frame(H, [at(from + DVec2::new(0.0, -60.0))]).ticks(60);
    assert!(cockpit.drive.v("player").y > speed, "it is pulled up, though it fell on");
}

#[test]
fn q_f10_and_a_lost_focus_let_go_of_what_is_pulled() {
    for lets_go in [tap("Q").to_vec(), tap("F10").to_vec(), vec![Input::FocusLost]] {
        let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
        let from = cockpit.seen("player");
        cockpit.drive.give([at(from), Input::ButtonDown(Button::Left), at(from + 30.0)]).ticks(10);
        assert!(cockpit.drive.v("player").length() > 0.0);
        cockpit.drive.give(lets_go).ticks(1);
        // Damping alone acts on it, which takes the same part of its velocity in every tick.
        let [first, second, third] = [(); 3].map(|()| cockpit.drive.ticks(1).v("player"));
        let kept = second.length() / first.length();
        assert!(
            kept < 1.0 && third.distance(second * kept) < 1e-9 * first.length(),
            "{first} {second} {third}"
        );
    }
}

#[test]
fn the_dock_is_resized_at_its_edge_and_nothing_is_selected_or_pulled_there() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let pixel = cockpit.seen("player");
    cockpit.drive.click(Button::Left, pixel).ticks(60);
    let [corner, size] = cockpit.view();
    let edge = corner + size * DVec2::new(1.0, 0.5) - DVec2::X;
    cockpit.drive.frame(H, [at(edge)]).frame(H, [Input::ButtonDown(Button::Left)]);
    cockpit
        .drive
        .frame(H, [at(edge - 60.0 * DVec2::X)])
        .frame(H, [Input::ButtonUp(Button::Left)])
        .ticks(2);
    assert!((cockpit.view()[1].x - (size.x - 60.0)).abs() < 3.0, "{} {}", cockpit.view()[1], size);
    assert_eq!(cockpit.drive.selected().as_deref(), Some("player"));
}

#[test]
fn what_the_tools_say_fits_into_the_dock_at_its_usual_width() {
    for size @ [width, _] in [[1024, 600], [1280, 720]] {
        for scene in ["tutorial", "orbits_race", "flag", "jelly"] {
            let mut cockpit = Cockpit::of(scene, size);
            cockpit.drive.press("K").ticks(30);
            for tool in ["E", "T", "V", "B", "Y", "R", "M"] {
                cockpit.drive.press(tool).ticks(10);
                let [corner, view] = cockpit.view();
                let controls = cockpit.session().controls();
                let dock = controls.iter().filter(|control| control.rect_px[0] > corner.x + view.x);
                for control in dock.filter(|control| !control.name.is_empty()) {
                    let right = control.rect_px[2];
                    assert!(
                        right <= f64::from(width) - 8.0,
                        "{scene}, {tool} at {size:?}: {control:#?}"
                    );
                }
                cockpit.drive.press(tool).ticks(2);
            }
        }
    }
}

#[test]
fn showing_the_cockpit_changes_no_setting_and_no_bit() {
    let hash = |cockpit: bool| {
        let overrides = Overrides { substeps: Some(5000.into()), ..Overrides::default() };
        let options =
            Options { pictures: false, interpolate: true, overrides, ..Options::default() };
        let mut drive = Drive::with(scene::load("oscillator").unwrap(), options);
        if cockpit {
            drive.press("F10");
        }
        let hash = drive.ticks(20).hash();
        assert_eq!(drive.session.stage.setting().substeps, 5000.into());
        hash
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn a_graph_of_a_soft_body_claims_no_acceleration() {
    let mut cockpit = Cockpit::of("jelly", [1280, 720]);
    cockpit.drive.press("Y");
    let [corner, size] = cockpit.view();
    let found = (1..40).any(|i| {
        cockpit.drive.click(Button::Left, corner + size * f64::from(i) / 40.0).ticks(60);
        cockpit.drive.selected().as_deref() == Some("jelly")
    });
    assert!(found);
    cockpit.drive.ticks(10);
    cockpit.click("Save CSV");
    let table = cockpit.saved_table();
    let row: Vec<_> = table.lines().last().unwrap().split(',').collect();
    assert_eq!(row.len(), 14);
    assert!(
        row[7..13].iter().all(|cell| cell.is_empty())
            && row[..7].iter().all(|cell| !cell.is_empty())
    );
}

#[test]
fn two_balls_of_a_millimeter_are_framed_selected_and_come_near_by_the_wheel() {
    let ball = |name: &str, x: f64| {
        format!(
            "(name: \"{name}\", shape: sphere(radius_m: 0.0005), position_m: ({x}, 0, 0), mass_kg: 1),"
        )
    };
    let bodies = ball("one", -0.001) + &ball("other", 0.001);
    let scene = scene_of(&format!("(version: 1, bodies: [{bodies}])"));
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.drive.session.open(scene);
    cockpit.drive.ticks(3);
    cockpit.press("F");
    let apart = |cockpit: &Cockpit| cockpit.seen("one").distance(cockpit.seen("other"));
    let framed = apart(&cockpit);
    assert!((150.0..600.0).contains(&framed), "{framed} pixels");
    let one = cockpit.seen("one");
    cockpit.drive.give([at(one), Input::Wheel(3.0)]).ticks(2);
    let nearer = apart(&cockpit);
    assert!(nearer > 1.1 * framed, "{nearer} pixels after {framed}");
    let one = cockpit.seen("one");
    cockpit.drive.click(Button::Left, one).ticks(2);
    assert_eq!(cockpit.drive.selected().as_deref(), Some("one"));
}

#[test]
fn a_double_click_frames_what_it_selects_and_two_slow_clicks_do_not() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let (pixel, start) = (cockpit.seen("player"), *cockpit.session().view.camera());
    cockpit.drive.click(Button::Left, pixel).ticks(60).click(Button::Left, pixel).ticks(60);
    assert_eq!(*cockpit.session().view.camera(), start);
    cockpit.drive.click(Button::Left, pixel).ticks(12).click(Button::Left, pixel);
    let [corner, size] = cockpit.view();
    assert!(cockpit.seen("player").distance(corner + size / 2.0) < 1.0);
}

#[test]
fn what_a_click_would_select_is_outlined() {
    let outlined = |cockpit: &mut Cockpit| {
        let frame = cockpit.drive.session.picture();
        frame
            .cuboids
            .iter()
            .chain(&frame.spheres)
            .filter(|body| body.surface & render::OUTLINED != 0)
            .count()
    };
    let mut cockpit = Cockpit::of("thousand", [1280, 720]);
    let (body, empty) = (cockpit.seen("layer9.x9.z0"), empty_place(&cockpit));
    cockpit.drive.give([at(empty)]);
    assert_eq!(outlined(&mut cockpit), 0);
    cockpit.drive.give([at(body)]);
    assert_eq!(outlined(&mut cockpit), 1);
    cockpit.drive.press("F10").give([at(body)]);
    assert_eq!(outlined(&mut cockpit), 0, "the tutorial's window outlines the selection alone");
}

#[test]
fn graphs_keep_the_last_ten_seconds_and_save_them_as_a_table() {
    let mut cockpit = Cockpit::of("oscillator", [1280, 720]);
    cockpit.drive.press("Y");
    let body = cockpit.seen("ball");
    cockpit.drive.click(Button::Left, body).ticks(12 * 120);
    cockpit.click("Save CSV");
    let table = cockpit.saved_table();
    let mut lines = table.lines();
    let heading: Vec<_> = lines.next().unwrap().split(',').collect();
    assert_eq!(
        (heading[0], heading[1], heading[12], heading[13]),
        ("time_s", "position_x_m", "force_z_n", "kinetic_energy_j")
    );
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect();
    assert!(
        rows.iter().all(|row| row.len() == 14)
            && rows.windows(2).all(|pair| pair[0][0] < pair[1][0])
    );
    let length = rows.last().unwrap()[0] - rows[0][0];
    assert!(length > 9.9 && length <= 10.0, "{length} s");
    let body = cockpit.drive.entity("ball");
    let mass = cockpit.session().stage.sim().world.get::<PhysicsBody>(body).unwrap().mass();
    for row in rows {
        let speed = DVec3::new(row[4], row[5], row[6]).length();
        assert!((row[13] - 0.5 * mass * speed * speed).abs() < 1e-9);
        assert!((row[10] - mass * row[7]).abs() < 1e-9, "force is mass times acceleration");
    }
}

/// Runs until a fault pauses the run.
fn run_to_fault(cockpit: &mut Cockpit) {
    for _ in 0..200 {
        if cockpit.drive.ticks(10).session.stage.playback().paused() {
            return;
        }
    }
    panic!("no fault");
}

#[test]
fn a_fault_stays_with_its_cures_until_it_is_dismissed() {
    let overrides = Overrides { method: Some(Method::ExplicitEuler), ..Overrides::default() };
    let mut cockpit = Cockpit::with("stiff_spring", [1280, 720], overrides);
    cockpit.drive.session.stage.keep_timeline();
    // The frames in which the cockpit was measured are over; the scene starts again.
    cockpit.drive.press("F1");
    run_to_fault(&mut cockpit);
    cockpit.drive.ticks(3);
    let fault = cockpit.session().stage.recorder().fault().expect("explicit Euler cannot").tick;
    assert_eq!(cockpit.session().stage.sim().ticks(), fault - 1);
    cockpit.drive.ticks(1000);
    cockpit.click("implicit Euler");
    assert_eq!(cockpit.session().stage.sim().stepper.method(), Method::ImplicitEuler);
    cockpit.click("Play");
    cockpit.drive.ticks(600);
    assert!(
        !cockpit.session().stage.playback().paused()
            && cockpit.session().stage.recorder().fault().is_none(),
        "cured"
    );

    // From the start again: by now the spring has no length to grow from.
    let explicit = Input::Change(scene::ChangeAction::SetMethod(Method::ExplicitEuler));
    cockpit.drive.give([explicit]).press("F1");
    run_to_fault(&mut cockpit);
    cockpit.drive.ticks(3);
    cockpit.click("Dismiss");
    assert!(!cockpit.has("Dismiss"));
}

#[test]
fn going_on_through_a_fault_keeps_its_cures_and_calls_no_later_tick_good() {
    let overrides = Overrides { method: Some(Method::ExplicitEuler), ..Overrides::default() };
    let mut cockpit = Cockpit::with("stiff_spring", [1280, 720], overrides);
    cockpit.drive.session.stage.keep_timeline();
    cockpit.drive.press("F1");
    run_to_fault(&mut cockpit);
    cockpit.drive.ticks(3);
    let good = cockpit.session().stage.sim().ticks();
    let offers = |cockpit: &Cockpit| {
        let controls = cockpit.session().controls();
        ["implicit Euler", "Reset to start", "Last good tick"].map(|name| {
            controls.iter().any(|control| control.name == name && control.role == "Button")
        })
    };
    let says_good = |cockpit: &Cockpit| {
        cockpit.session().stage.notices.texts().any(|notice| notice.contains("good"))
    };
    assert!(offers(&cockpit) == [true, true, false] && says_good(&cockpit));

    // It explodes until a number is too large, and stops once more: before that the run had gone wrong already.
    cockpit.click("Play");
    while !cockpit.session().stage.playback().paused() {
        assert!(
            offers(&cockpit) == [true; 3] && !says_good(&cockpit),
            "tick {}",
            cockpit.session().stage.sim().ticks()
        );
        cockpit.drive.ticks(1);
    }
    cockpit.drive.ticks(3);
    let fault = cockpit.session().stage.recorder().fault().unwrap();
    assert!(
        fault.quarantined
            && cockpit.session().stage.sim().ticks() == fault.tick - 1
            && fault.tick > good + 100
    );
    assert!(offers(&cockpit) == [true; 3] && !says_good(&cockpit));

    cockpit.click("Last good tick");
    assert_eq!(cockpit.session().stage.sim().ticks(), good);
    cockpit.click("implicit Euler");
    cockpit.click("Play");
    cockpit.drive.ticks(600);
    assert!(
        !cockpit.session().stage.playback().paused()
            && cockpit.session().stage.recorder().fault().is_none(),
        "cured"
    );
}

#[test]
fn thousands_of_random_events_over_all_tools_do_no_harm() {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = move |below: u32| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        u32::try_from(state % u64::from(below)).unwrap()
    };
    let keys = [
        "Tab",
        "E",
        "C",
        "B",
        "V",
        "R",
        "H",
        "T",
        "Q",
        "F10",
        "F",
        "P",
        ".",
        ",",
        "I",
        "G",
        "1",
        "2",
        "3",
        "7",
        "F1",
        "F2",
        "Escape",
        "Ctrl+O",
        "=",
        "-",
        "L",
        "W",
        "Space",
        "Up",
        "F6",
        "Shift+Tab",
        "Enter",
        "Down",
        "F8",
        "F9",
        "M",
        "K",
        "Ctrl+Z",
        "Ctrl+Y",
        "Ctrl+D",
        "Delete",
        "Ctrl+S",
        "Ctrl+Shift+S",
    ];
    let buttons = [Button::Left, Button::Right, Button::Middle];
    for scene in ["tutorial", "orbits_race", "jelly", "bridge", "everything"] {
        let mut cockpit = Cockpit::of(scene, [1024, 600]);
        for _ in 0..125 {
            let events: Vec<_> = (0..16)
                .flat_map(|_| match random(12) {
                    0 => tap(keys[random(44) as usize]).to_vec(),
                    1 => vec![down(keys[random(44) as usize])],
                    2 => vec![up(keys[random(44) as usize])],
                    3 => vec![Input::ButtonDown(buttons[random(3) as usize])],
                    4 => vec![Input::ButtonUp(buttons[random(3) as usize])],
                    5 => vec![Input::Wheel(f64::from(random(7)) - 3.0)],
                    6 => click(Button::Left).to_vec(),
                    7 if random(20) == 0 => vec![Input::FocusLost],
                    7 if random(20) == 0 => {
                        vec![Input::Resized([500 + random(1500), 300 + random(900)])]
                    }
                    _ => vec![at(DVec2::new(f64::from(random(1024)), f64::from(random(600))))],
                })
                .collect();
            cockpit.drive.frame(H, events);
            let _ = cockpit.drive.session.stage.take_orders();
        }
        cockpit.drive.give([Input::FocusLost]).ticks(3);
        assert!(cockpit.session().view.camera().position.is_finite(), "{scene}");

        // Panels that went with the bars come back with them.
        if cockpit.session().arrangement().contains("toggle_cockpit off") {
            cockpit.drive.press("F10").ticks(1);
        }
        // What is open is closed by Escape; then the scene, as it was edited, begins as one that was just opened and runs.
        for _ in 0..15 {
            cockpit.drive.press("Escape").ticks(1);
        }
        assert!(
            !cockpit.session().takes_text() && cockpit.session().open_panels().is_empty(),
            "{scene}"
        );
        cockpit.drive.press("F1");
        let ticks = cockpit.session().stage.sim().ticks();
        let fresh = Drive::of(scene::Scene::clone(&cockpit.session().stage.sim().scene));
        assert_eq!(cockpit.drive.hash(), fresh.hash(), "{scene}: the start");
        if cockpit.session().stage.playback().paused() {
            cockpit.drive.press("P");
        }
        assert!(
            cockpit.drive.frames(10).session.stage.sim().ticks() > ticks,
            "{scene}: it does not run"
        );
    }
}

#[test]
fn a_scene_a_method_and_a_tool_are_reached_by_keys_alone() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    cockpit.press("F6").press("F6");
    assert_eq!(cockpit.focused().unwrap().role, "TextInput");
    cockpit.drive.give([Input::Text("orbit".to_owned())]).ticks(1);
    cockpit.go_to("orbit", "Tab").press("Enter");
    assert_eq!(cockpit.drive.session.stage.take_orders(), [Order::Open("orbit".to_owned())]);

    cockpit.press("F6");
    assert_eq!(cockpit.focused().unwrap().name, "Look");
    cockpit.go_to("Build", "Tab").press("Enter").go_to("Settings", "Tab").press("Enter");
    assert_eq!(cockpit.session().open_panels(), [Panel::Editor, Panel::Settings]);
    cockpit.go_to("Moon", "Tab").press("Space");
    assert_eq!(cockpit.session().stage.sim().world.resource::<Gravity>().acceleration.y, -1.62);

    // Past the last part is the scene, and after that the first part.
    cockpit.press("F6");
    assert_eq!(cockpit.focused(), None);
    cockpit.press("F6").go_to("method of integration (I and Shift+I)", "Tab");
    cockpit.press("Enter").go_to(Method::RungeKutta4.claims().title, "Down").press("Enter");
    assert_eq!(cockpit.session().stage.sim().stepper.method(), Method::RungeKutta4);
    assert_eq!(
        cockpit.focused().unwrap().name,
        "method of integration (I and Shift+I)",
        "the list is closed"
    );
    cockpit.press("Shift+Tab").press("Tab");
    assert_eq!(cockpit.focused().unwrap().name, "method of integration (I and Shift+I)");
}

#[test]
fn a_control_with_the_keyboard_takes_the_keys_that_move_on_and_press_and_no_other() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let settings = |cockpit: &Cockpit| cockpit.session().open_panels().contains(&Panel::Settings);
    cockpit.press("F6").go_to("Pause", "Tab");
    assert!(!settings(&cockpit) && !cockpit.session().takes_text());
    cockpit.press("Space");
    assert!(cockpit.session().stage.playback().paused());
    cockpit.press("P");
    assert!(!cockpit.session().stage.playback().paused());
    cockpit.press("Escape");
    assert_eq!(cockpit.focused(), None);
    cockpit.press("Tab");
    assert!(settings(&cockpit), "nothing has the keyboard: Tab opens the settings");

    // A click elsewhere takes the keyboard back, too.
    cockpit.press("F6");
    assert!(cockpit.focused().is_some());
    let empty = empty_place(&cockpit);
    cockpit.drive.click(Button::Left, empty).ticks(2);
    assert_eq!(cockpit.focused(), None);
}

#[test]
fn tab_passes_every_control_in_sight_of_all_tools_and_frames_it() {
    let everywhere = ["Step", "Help", "tutorial", "coincident points", "Look", "Past"];
    for (opens, names) in [
        ("Tab", ["Settings", "Moon"]),
        ("E", ["Effects", "Measure costs"]),
        ("Y", ["Graphs", "Measure"]),
    ] {
        let passed = passed(opens);
        for name in everywhere.into_iter().chain(names) {
            assert!(
                passed.iter().any(|control| control.name == name),
                "{name} is not passed: {passed:#?}"
            );
        }
    }
}

/// The controls that Tab passes while the tab is chosen that the key `opens`.
fn passed(opens: &str) -> Vec<Control> {
    let mut cockpit = Cockpit::of("tutorial", [1024, 600]);
    cockpit.press("F8").press(opens).press("P");
    let mut passed: Vec<Control> = Vec::new();
    let first = cockpit.press("F6").focused().unwrap();
    loop {
        let control =
            cockpit.focused().unwrap_or_else(|| panic!("lost after {:#?}", passed.last()));
        let at = middle(&control);
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::new(1024.0, 600.0)).all();
        assert!(inside, "{control:#?} is out of sight");
        passed.push(control);
        cockpit.press("Tab");
        if cockpit.focused().is_some_and(|control| control.name == first.name) {
            break;
        }
        assert!(passed.len() < 400, "{passed:#?}");
    }
    passed
}

#[test]
fn f8_and_f9_hide_and_show_the_scenes_and_the_dock() {
    for size in [[1024, 600], [1280, 720]] {
        let mut cockpit = Cockpit::of("tutorial", size);
        let parts = |cockpit: &Cockpit| [cockpit.has("frame step"), cockpit.has("Measure")];
        let wide = size[0] == 1280;
        assert_eq!(parts(&cockpit), [wide, true]);
        cockpit.press("F8").press("F9");
        assert_eq!(parts(&cockpit), [!wide, false]);
        cockpit.press("F8").press("F9");
        assert_eq!(parts(&cockpit), [wide, true]);
    }
}

#[test]
fn the_edge_of_the_dock_is_moved_by_the_arrows() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let width = cockpit.view()[1].x;
    // Behind the first part's first control is, backwards, the last one.
    cockpit.press("F6").press("Shift+Tab").press("Left").press("Left");
    let narrower = cockpit.view()[1].x;
    assert!(narrower < width - 20.0, "{narrower} {width}");
    cockpit.press("Right");
    assert!(cockpit.view()[1].x > narrower);
    assert!(cockpit.focused().is_some(), "the edge keeps the keyboard");
}

#[test]
fn the_panels_are_made_larger_smaller_and_light() {
    let mut cockpit = Cockpit::of("tutorial", [1024, 600]);
    let height = |cockpit: &Cockpit| {
        let [_, top, _, bottom] = cockpit.drive.control("Pause").rect_px;
        bottom - top
    };
    let usual = height(&cockpit);
    cockpit.press("Ctrl+=");
    assert!(height(&cockpit) > 1.1 * usual);
    cockpit.press("Ctrl+-").press("Ctrl+-");
    assert!(height(&cockpit) < usual);
    // As often as there are sizes: the largest one leaves the scene in sight.
    for _ in 0..10 {
        cockpit.press("Ctrl+=");
    }
    let [_, size] = cockpit.view();
    assert!(size.x > 250.0 && size.y > 400.0, "{size}");
    let largest = height(&cockpit);
    cockpit.press("Ctrl+-");
    assert!(height(&cockpit) < largest, "what there was no room for is not counted");
    let surround = |cockpit: &mut Cockpit| cockpit.drive.session.picture().surround;
    let dark = surround(&mut cockpit);
    cockpit.press("F7");
    assert_ne!(surround(&mut cockpit), dark);
    cockpit.press("F7");
    assert_eq!(surround(&mut cockpit), dark);
}

/// A session of that size without the cockpit, which is arranged as `text` says.
fn arranged(text: &str, size_px: [u32; 2]) -> Drive {
    let options = Options { pictures: false, interpolate: true, size_px, ..Options::default() };
    let mut drive = Drive::with(scene::load("tutorial").unwrap(), options);
    drive.give([Input::Arrange(text.to_owned())]).ticks(3);
    drive
}

#[test]
fn how_the_panels_are_arranged_is_brought_back() {
    let sizes = [[1024, 600], [1280, 720], [2560, 1440]];
    for keys in [
        &[][..],
        &["F7", "F9", "E", "Y"],
        &["F8", "Ctrl+-", "Tab"],
        &["Ctrl+=", "Ctrl+=", "F8", "R"],
        &["F10"],
    ] {
        for from in sizes {
            let mut cockpit = Cockpit::of("tutorial", from);
            for key in keys {
                cockpit.press(key);
            }
            let text = cockpit.session().arrangement();
            for to in sizes {
                let drive = arranged(&text, to);
                assert_eq!(drive.session.arrangement(), text, "{keys:?} from {from:?} to {to:?}");
            }
        }
    }
}

#[test]
fn the_width_of_the_dock_is_brought_back() {
    let size = [1280, 720];
    let mut cockpit = Cockpit::of("tutorial", size);
    assert!(!cockpit.session().arrangement().contains("dock_width"));
    let edge = |cockpit: &mut Cockpit| {
        let [left, _, width, _] = cockpit.drive.session.picture().view_px();
        DVec2::new(f64::from(left + width), 500.0)
    };
    let from = edge(&mut cockpit);
    cockpit.drive.give([at(from)]).ticks(1);
    cockpit.drive.give([Input::ButtonDown(Button::Left)]).ticks(1);
    for moved in [40.0, 100.0] {
        cockpit.drive.give([at(from - DVec2::X * moved)]).ticks(1);
    }
    cockpit.drive.give([Input::ButtonUp(Button::Left)]).ticks(2);
    let wider = edge(&mut cockpit);
    assert!(wider.x < from.x - 50.0, "{from} {wider}");
    let text = cockpit.session().arrangement();
    let mut drive = arranged(&text, size);
    assert_eq!(drive.session.arrangement(), text);
    let [left, _, width, _] = drive.session.picture().view_px();
    assert!((f64::from(left + width) - wider.x).abs() <= 1.0, "{text}");
    // In a window that is too narrow for it, it is as wide as it can be.
    let drive = arranged("dock_width 100000", [1024, 600]);
    assert!(drive.session.view.view_area()[1].x > 200.0);
}

#[test]
fn a_damaged_arrangement_does_no_other_action() {
    let mut drive = arranged("", [1280, 720]);
    let (usual, hash) = (drive.session.arrangement(), drive.hash());
    assert!(usual.starts_with("toggle_cockpit on\n"), "{usual}");
    assert_eq!(drive.session.stage.take_orders(), []);
    let damaged = [
        "quit on\nreset_world on\ntoggle_gravity on\nnext_scene on\ntoggle_ghosts on",
        "toggle_theme yes\n toggle_dock off\ntoggle_cockpit\nlarger many\nsmaller -3\n\u{0}\u{fffd}",
        &usual[..usual.len() / 2],
        "toggle_dock on\ntoggle_dock off\n",
    ];
    for text in damaged {
        let mut drive = arranged(text, [1280, 720]);
        assert_eq!((drive.session.arrangement(), drive.hash()), (usual.clone(), hash), "{text:?}");
        assert_eq!(drive.session.stage.take_orders(), []);
    }
    let text =
        arranged("larger 99999999999999999999\nsmaller 4000\ntoggle_cockpit off", [1280, 720]);
    let arrangement = text.session.arrangement();
    assert!(
        arrangement.contains("smaller") && arrangement.contains("toggle_cockpit off"),
        "{arrangement}"
    );
}

#[test]
fn a_question_that_is_open_at_the_start_leaves_the_arrangement_and_the_pointer() {
    for text in ["", "toggle_ledger_panel on\ntoggle_theme on\n", "toggle_cockpit off\n"] {
        let options = Options { pictures: false, interpolate: true, ..Options::default() };
        let mut drive = Drive::with(scene::load("tutorial").unwrap(), options);
        let _ = drive.session.controls();
        drive.session.offer("draft.ron".into());
        drive.give([Input::Arrange(text.to_owned())]).ticks(3);
        assert_eq!(drive.session.arrangement(), arranged(text, [1280, 720]).session.arrangement());
        assert_eq!(drive.session.view.mode(), Mode::Selection, "{text:?}");
        let mut cockpit = Cockpit { drive };
        cockpit.click("Open them");
        assert_eq!(
            cockpit.drive.session.stage.take_orders(),
            [Order::Restore("draft.ron".into())],
            "{text:?}"
        );
    }
}

#[test]
fn ctrl_and_the_wheel_change_the_force_where_the_wheel_alone_zooms() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let (force, camera) = (cockpit.session().view.click_force(), *cockpit.session().view.camera());
    let pixel = cockpit.seen("player");
    cockpit.drive.give([at(pixel), down("Ctrl"), Input::Wheel(2.0)]);
    assert_eq!(cockpit.session().view.click_force(), force + 200.0);
    assert_eq!(*cockpit.session().view.camera(), camera);
    cockpit.drive.give([up("Ctrl"), Input::Wheel(1.0)]);
    assert_eq!(cockpit.session().view.click_force(), force + 200.0);
    assert_ne!(*cockpit.session().view.camera(), camera);
    let recorded = sandbox::player::recorded(&down("Ctrl"));
    assert_eq!(recorded, Some(scene::InputAction::KeyDown("Ctrl".to_owned()).into()));
}

#[test]
fn flying_is_as_fast_as_the_scene_is_far() {
    let speed = |name: &str| Drive::shipped(name).session.view.camera().speed();
    for scene in ["tutorial", "tutorial_large", "frame_step", "empty"] {
        assert_eq!(speed(scene), 100.0, "{scene}");
    }
    for (scene, slower) in
        [("figure_eight", 2.0), ("cape", 10.0), ("everything", 20.0), ("bridge", 50.0)]
    {
        assert_eq!(speed(scene), slower, "{scene}");
    }
}

#[test]
fn keys_select_one_movable_body_after_the_other_and_push_it() {
    let mut cockpit = Cockpit::of("third_law", [1280, 720]);
    let mut seen = Vec::new();
    loop {
        cockpit.press("K");
        let name = cockpit.drive.selected().unwrap();
        let body = cockpit.drive.entity(&name);
        assert!(
            cockpit.session().stage.sim().world.get::<PhysicsBody>(body).unwrap().inverse_mass
                > 0.0,
            "{name}"
        );
        if seen.contains(&name) {
            assert_eq!(seen[0], name);
            break;
        }
        seen.push(name);
    }
    assert!(seen.len() > 1, "{seen:?}");
    cockpit.press("Shift+K");
    assert_eq!(cockpit.drive.selected(), seen.last().cloned());
    let before = cockpit.drive.v(&seen[seen.len() - 1]);
    cockpit.drive.frame(H, [down("PageUp")]).ticks(2);
    assert!(cockpit.drive.v(&seen[seen.len() - 1]).y > before.y);
}

#[test]
fn a_bar_that_comes_moves_no_button_of_the_lesson_and_of_the_dock() {
    let mut cockpit = Cockpit::of("tutorial", [1280, 720]);
    let text = scene::lesson::shipped()[0].1;
    let lesson = scene::lesson::Lesson::parse("force", text).unwrap();
    cockpit.drive.session.begin_lesson(lesson, lab::lesson::Quantities::default());
    cockpit.drive.ticks(3);
    let places = |cockpit: &Cockpit| {
        ["Skip", "Leave", "Measure", "Build"].map(|name| cockpit.middle_of(name))
    };
    let before = places(&cockpit);
    // Everything falls out of the view.
    cockpit.press("G");
    cockpit.drive.run(300, 1.0 / 30.0);
    assert!(cockpit.has("Follow"), "the bar is there");
    assert_eq!(places(&cockpit), before);
}

#[test]
fn a_control_at_which_a_lesson_points_is_scrolled_to() {
    let mut cockpit = Cockpit::of("orbit", [1280, 320]);
    cockpit.press("B").press("V").press("C");
    let in_sight =
        |cockpit: &Cockpit| cockpit.middle_of("Ledger").y > cockpit.middle_of("Measure").y;
    assert!(!in_sight(&cockpit), "a panel below it was opened last");

    let lessons = scene::lesson::shipped();
    let (_, text) = lessons.iter().find(|(name, _)| *name == "energy").unwrap();
    let text = text.replace(r#"point_at: "method""#, r#"point_at: "Ledger""#);
    let lesson = scene::lesson::Lesson::parse("energy", &text).unwrap();
    cockpit.drive.session.begin_lesson(lesson, lab::lesson::Quantities::default());
    cockpit.drive.ticks(5);
    assert!(in_sight(&cockpit));
}
