//! What a click selects and what a push does: against rays tested one by one, in f64, by other formulas.

use glam::{DVec2, DVec3};
use motion::Transform;
use pick::Shape;
use sandbox::input::{Button, Input};
use scene::Scene;

use crate::rigs::{
    Drive, H, SIZE, at, change, click, close, digits, down, push, remove, scene_of, up,
};

/// What the tutorial's damping leaves of a velocity after one tick.
const KEEP: f64 = 1.0 - 0.4 * H;

/// The ray through a pixel of a picture 16:9, 45 degrees high, by trigonometry alone: the eye and a unit vector.
fn ray(drive: &Drive, pixel: DVec2) -> (DVec3, DVec3) {
    let camera = drive.session.view.camera();
    let (yaw, pitch) = (camera.yaw.to_radians(), camera.pitch.to_radians());
    let right = DVec3::new(yaw.cos(), 0.0, -yaw.sin());
    let forward = DVec3::new(-yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    let up = right.cross(forward);
    let half_height = 22.5_f64.to_radians().tan();
    let across = (2.0 * pixel.x / 1280.0 - 1.0) * half_height * 16.0 / 9.0;
    let upwards = (1.0 - 2.0 * pixel.y / 720.0) * half_height;
    (camera.position, (forward + right * across + up * upwards).normalize())
}

/// Distance to a shape `center` away from the ray's origin: three slabs, or a quadratic equation.
fn distance(shape: Shape, center: DVec3, direction: DVec3) -> Option<f64> {
    match shape {
        Shape::Sphere { radius } => {
            let b = center.dot(direction);
            let root = b * b - (center.length_squared() - radius * radius);
            (root >= 0.0).then(|| b - root.sqrt()).filter(|distance| *distance > 0.0)
        }
        Shape::Cuboid { half_extents: half } => {
            let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
            for axis in 0..3 {
                let one = (center[axis] - half[axis]) / direction[axis];
                let other = (center[axis] + half[axis]) / direction[axis];
                near = near.max(one.min(other));
                far = far.min(one.max(other));
            }
            (near <= far && near > 0.0).then_some(near)
        }
    }
}

/// Name and distance of the closest thing behind a pixel, every thing tested.
fn closest(drive: &Drive, pixel: DVec2) -> Option<(String, f64)> {
    let (eye, direction) = ray(drive, pixel);
    let world = &drive.session.stage.sim().world;
    let hits = drive.session.stage.sim().remaining_bodies().filter_map(|thing| {
        let center = world.get::<Transform>(thing)?.position - eye;
        Some((
            drive.session.stage.name(thing),
            distance(*world.get::<Shape>(thing)?, center, direction)?,
        ))
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn name_of(hit: Option<(String, f64)>) -> Option<String> {
    hit.map(|(name, _)| name)
}

/// In selection mode.
fn selecting(mut drive: Drive) -> Drive {
    drive.press("Q");
    drive
}

/// The tutorial, everything of it and the camera moved by `offset`.
fn tutorial_at(offset: DVec3) -> Drive {
    let mut scene: Scene = scene::load("tutorial").unwrap();
    scene.camera.position += offset;
    scene.bodies.iter_mut().for_each(|body| body.position += offset);
    selecting(Drive::of(scene))
}

/// Pixels all over the picture.
fn pixels(apart: u32) -> impl Iterator<Item = DVec2> {
    let (across, down) = (1280 / apart, 720 / apart);
    (0..across * down)
        .map(move |i| DVec2::new(f64::from(i % across), f64::from(i / across)) * f64::from(apart))
}

#[test]
fn the_check_points_of_the_tutorial_appear_on_their_pixels() {
    let drive = Drive::tutorial();
    let table = [
        ((0.0, 10.0, 0.0), "640.00", "427.96"),
        ((14.0, 10.0, 14.0), "831.78", "427.96"),
        ((0.0, 10.0, 14.0), "747.33", "463.85"),
        ((14.0, 10.0, 0.0), "726.65", "398.99"),
        ((0.0, 5.0, 0.0), "640.00", "473.11"),
        ((10.0, 5.0, 0.0), "702.81", "448.96"),
    ];
    for (point, x, y) in table {
        let pixel = drive.pixel(point.into());
        digits(pixel.x, x);
        digits(pixel.y, y);
        let (eye, direction) = ray(&drive, pixel);
        assert!((DVec3::from(point) - eye).cross(direction).length() < 1e-9);
    }
}

#[test]
fn the_middle_of_the_first_picture_is_a_point_of_the_floor() {
    let mut drive = selecting(Drive::tutorial());
    let ray = drive.session.view.camera().viewpoint().ray_through(SIZE / 2.0, SIZE);
    let (name, distance) = closest(&drive, SIZE / 2.0).unwrap();
    assert_eq!((name.as_str(), drive.select(SIZE / 2.0).as_deref()), ("floor", Some("floor")));
    digits(distance, "154.548");
    let point = ray.at(distance);
    digits(point.x, "45.558");
    digits(point.z, "-45.558");
    assert!(point.y.abs() < 1e-9);
}

#[test]
fn a_click_on_a_bodys_center_selects_it_or_what_is_nearer() {
    let mut drive = selecting(Drive::tutorial());
    let mut free = 0;
    for x in 0..5 {
        for z in 0..5 {
            let name = format!("grid.x{x}.z{z}");
            let pixel = drive.pixel(drive.x(&name));
            let expected = name_of(closest(&drive, pixel));
            free += u32::from(expected.as_ref() == Some(&name));
            assert_eq!(drive.select(pixel), expected, "at the center of {name}, {pixel}");
        }
    }
    assert!(free > 15, "only {free} of 25 centers are free");
}

#[test]
fn a_click_anywhere_selects_what_a_test_of_every_thing_finds() {
    let mut drive = selecting(Drive::tutorial());
    let mut found = std::collections::BTreeSet::new();
    // All over the picture, and densely where the bodies are.
    let dense = pixels(8)
        .filter(|pixel| (600.0..860.0).contains(&pixel.x) && (380.0..520.0).contains(&pixel.y));
    for pixel in pixels(40).chain(dense) {
        let expected = name_of(closest(&drive, pixel));
        assert_eq!(drive.select(pixel), expected, "at {pixel}");
        found.insert(expected);
    }
    // Nothing at all, the floor, three characters and the grid.
    assert!(found.len() > 27, "{found:?}");
}

#[test]
fn the_floor_is_selected_and_never_pushed() {
    let mut drive = selecting(Drive::tutorial());
    assert_eq!(drive.select(SIZE / 2.0).as_deref(), Some("floor"));
    let before = drive.hash();
    drive.give([Input::Wheel(1e6)]).click(Button::Right, SIZE / 2.0).ticks(10);
    assert_eq!(drive.hash(), before);
}

#[test]
fn a_click_on_the_sky_clears_and_a_second_click_on_a_body_keeps_it() {
    let mut drive = selecting(Drive::tutorial());
    let player = drive.pixel(drive.x("player"));
    assert_eq!(drive.select(player).as_deref(), Some("player"));
    assert_eq!(drive.select(player).as_deref(), Some("player"));
    assert_eq!(drive.select(DVec2::new(640.0, 5.0)), None);
    assert_eq!(drive.select(player).as_deref(), Some("player"));
    let enemy = drive.pixel(drive.x("enemy"));
    assert_eq!(drive.select(enemy).as_deref(), Some("enemy"));
}

#[test]
fn the_left_button_selects_as_long_as_it_is_held() {
    let mut drive = selecting(Drive::tutorial());
    let stops =
        ["player", "enemy", "bonus", "player"].map(|name| (name, drive.pixel(drive.x(name))));
    drive.give([at(stops[0].1), Input::ButtonDown(Button::Left)]);
    for (name, pixel) in stops {
        assert_eq!(drive.give([at(pixel)]).selected().as_deref(), Some(name));
    }
    assert_eq!(drive.give([at(DVec2::new(640.0, 5.0))]).selected(), None);
    assert_eq!(drive.give([at(stops[1].1)]).selected().as_deref(), Some("enemy"));
    drive.give([Input::ButtonUp(Button::Left)]);
    assert_eq!(drive.give([at(stops[0].1)]).selected().as_deref(), Some("enemy"));
}

#[test]
fn what_flies_under_a_held_pointer_is_selected_while_it_is_there() {
    let ball = "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (-10, 0, -50), velocity_m_s: (60, 0, 0))";
    let mut drive = selecting(Drive::bodies(ball));
    drive.give([at(SIZE / 2.0), Input::ButtonDown(Button::Left)]);
    assert_eq!(drive.selected(), None);
    // It is at 0 after 20 ticks.
    drive.ticks(21);
    assert_eq!(drive.selected().as_deref(), Some("ball"));
    drive.ticks(20);
    assert_eq!(drive.selected(), None);
}

#[test]
fn a_selection_survives_the_mode_and_camera_mode_selects_nothing() {
    let mut drive = selecting(Drive::tutorial());
    let player = drive.pixel(drive.x("player"));
    drive.select(player);
    drive.press("Q");
    assert_eq!(drive.selected().as_deref(), Some("player"));
    drive.give(click(Button::Left)).ticks(2);
    assert_eq!(
        drive.selected().as_deref(),
        Some("player"),
        "the floor is in the middle of the view"
    );
    drive.press("Q");
    assert_eq!(drive.selected().as_deref(), Some("player"));
    let mut drive = Drive::tutorial();
    assert_eq!(drive.give(click(Button::Left)).ticks(2).selected(), None);
}

/// Two balls, the near one in front of the left half of the far one.
const TWO: &str = "(name: \"near\", shape: sphere(radius_m: 2), position_m: (-1.5, 0, -20)),
                   (name: \"far\", shape: sphere(radius_m: 4), position_m: (0, 0, -40))";

#[test]
fn a_push_reaches_only_what_the_ray_meets_first() {
    let mut drive = selecting(Drive::bodies(TWO));
    let (hidden, free) =
        (drive.pixel(DVec3::new(-1.0, 0.0, -40.0)), drive.pixel(DVec3::new(3.5, 0.0, -40.0)));
    assert_eq!(drive.select(hidden).as_deref(), Some("near"));
    assert_eq!(drive.select(free).as_deref(), Some("far"));
    drive.click(Button::Right, hidden).ticks(2);
    assert_eq!((drive.v("near"), drive.v("far")), (DVec3::ZERO, DVec3::ZERO));
    drive.click(Button::Right, DVec2::new(5.0, 5.0)).ticks(2);
    assert_eq!((drive.v("near"), drive.v("far")), (DVec3::ZERO, DVec3::ZERO));
    drive.click(Button::Right, free).ticks(2);
    assert_eq!(drive.v("near"), DVec3::ZERO);
    let (_, direction) = ray(&drive, free);
    assert!((drive.v("far") - direction * 10.0 * H).length() < 1e-13);
}

#[test]
fn in_camera_mode_a_push_goes_through_the_middle_of_the_view() {
    let mut drive = selecting(Drive::bodies(TWO));
    let free = drive.pixel(DVec3::new(3.5, 0.0, -40.0));
    assert_eq!(drive.select(free).as_deref(), Some("far"));
    drive.press("Q").give(click(Button::Right)).ticks(2);
    assert_eq!(drive.v("far"), DVec3::ZERO, "the near ball is in the middle of the view");
    // 80 counts to the right are 5.6 degrees: 3.9 m beside the middle of the far ball.
    drive.give([Input::Mouse(80.0, 0.0)]).give(click(Button::Right)).ticks(2);
    assert!(
        (drive.v("far") - drive.session.view.camera().viewpoint().forward() * 10.0 * H).length()
            < 1e-13
    );
    // Away from it, the ray meets nothing.
    let before = drive.v("far");
    drive.give([Input::Mouse(400.0, 0.0)]).give(click(Button::Right)).ticks(2);
    assert_eq!(drive.v("far"), before);
}

#[test]
fn scenery_is_selected_and_pushing_it_does_nothing() {
    let mut drive = selecting(Drive::bodies(
        "(name: \"wall\", shape: cuboid(half_extents_m: (3, 3, 1)), position_m: (0, 0, -20), scenery: true)",
    ));
    assert_eq!(drive.give([down("Alt")]).select(SIZE / 2.0).as_deref(), Some("wall"));
    drive.click(Button::Right, SIZE / 2.0).give([down("Up")]).ticks(3);
    assert_eq!((drive.x("wall"), drive.selected().as_deref()), (DVec3::Z * -20.0, Some("wall")));
}

#[test]
fn a_click_on_what_cannot_be_moved_clears_the_selection_unless_alt_is_held() {
    let scene = |key: &str| {
        let text = format!(
            "(version: 1, {key} camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0), bodies: [
                (name: \"ball\", shape: sphere(radius_m: 1), position_m: (-4, 0, -20)),
                (name: \"block\", shape: sphere(radius_m: 1), position_m: (4, 0, -20), immovable: true)])"
        );
        selecting(Drive::text(&text))
    };
    let mut drive = scene("");
    let [ball, block] = ["ball", "block"].map(|name| drive.pixel(drive.x(name)));
    assert_eq!(drive.select(ball).as_deref(), Some("ball"));
    assert_eq!(drive.select(block), None);
    assert_eq!(drive.give([down("Alt")]).select(block).as_deref(), Some("block"));
    assert_eq!(drive.give([up("Alt")]).select(block), None);
    assert_eq!(scene("select_immovable: true,").select(block).as_deref(), Some("block"));
    // A body that was quarantined can be looked at.
    drive.give([push("ball", [f64::NAN, 0.0, 0.0])]).ticks(1);
    assert_eq!(drive.session.stage.quarantines().so_far().len(), 1);
    assert_eq!(drive.select(ball).as_deref(), Some("ball"));
}

#[test]
fn a_body_that_was_put_elsewhere_is_drawn_and_hit_there_and_not_on_the_way() {
    let ball = "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (-6, 0, -40))";
    let mut drive = selecting(Drive::bodies(ball));
    let to = DVec3::new(6.0, 0.0, -40.0);
    let put = change("ball", scene::ChangeAction::SetPosition, to.to_array());
    // In the middle between two ticks.
    drive.ticks(2).frame(0.5 * H, [put]);
    assert_eq!(drive.session.picture().spheres[0].position, to.as_vec3().to_array());
    for (x, expected) in [(-6.0, None), (0.0, None), (6.0, Some("ball"))] {
        let pixel = drive.pixel(DVec3::new(x, 0.0, -40.0));
        assert_eq!(drive.select(pixel).as_deref(), expected, "at {x} m");
    }
}

#[test]
fn the_wheel_changes_the_click_force_by_100_newtons_a_notch() {
    let mut drive = Drive::tutorial();
    assert_eq!(drive.session.view.click_force(), 10.0);
    assert_eq!(drive.give([Input::Wheel(1.0)]).session.view.click_force(), 110.0);
    drive.press("Q");
    assert_eq!(
        drive.give([Input::Wheel(-2.0), Input::Wheel(-1.0)]).session.view.click_force(),
        -190.0
    );
    assert_eq!(drive.give([Input::Wheel(0.5)]).session.view.click_force(), -140.0);
    assert_eq!(drive.selected(), None);
}

#[test]
fn one_click_adds_newtons_times_inverse_mass_times_one_tick_along_the_ray() {
    for (name, w) in [("player", 0.5), ("bonus", 1.0), ("grid.x0.z4", 10.0)] {
        for notches in [0.0, 3.0, -1.0, -25.0] {
            let mut drive = selecting(Drive::tutorial());
            let pixel = drive.pixel(drive.x(name)) + DVec2::new(0.4, -0.3);
            assert_eq!(drive.select(pixel).as_deref(), Some(name));
            drive.give([Input::Wheel(notches)]).click(Button::Right, pixel).ticks(1);
            let newtons = 10.0 + 100.0 * notches;
            let (_, direction) = ray(&drive, pixel);
            let v = drive.v(name);
            close(v.length(), newtons.abs() * w * H * KEEP, 1e-12);
            // A negative force pulls, toward the camera.
            close(v.dot(direction), newtons * w * H * KEEP, 1e-12);
            assert!(v.cross(direction).length() <= 1e-12 * v.length());
        }
    }
}

#[test]
fn a_hundred_kilometers_away_clicks_select_and_push_the_same() {
    let mut here = tutorial_at(DVec3::ZERO);
    let mut there = tutorial_at(DVec3::new(1e5, 0.0, -1e5));
    let dense = pixels(10)
        .filter(|pixel| (600.0..860.0).contains(&pixel.x) && (380.0..520.0).contains(&pixel.y));
    for pixel in pixels(40).chain(dense) {
        assert_eq!(there.select(pixel), here.select(pixel), "at {pixel}");
    }
    for name in ["player", "enemy", "bonus", "grid.x0.z4", "grid.x4.z4", "grid.x2.z4"] {
        let pixel = here.pixel(here.x(name));
        assert!((there.pixel(there.x(name)) - pixel).length() < 1e-6);
        for drive in [&mut here, &mut there] {
            assert_eq!(drive.select(pixel).as_deref(), Some(name));
            drive.click(Button::Right, pixel).ticks(1);
        }
        let (v, w) = (here.v(name), there.v(name));
        assert!(
            v.length() > 0.0 && (v - w).length() <= 1e-6 * v.length(),
            "{name}: {v} here, {w} there"
        );
    }
}

#[test]
fn a_push_with_a_radius_moves_the_bodies_around_the_place_that_is_hit() {
    let ball = |x: i32| {
        format!(
            "(name: \"b{x}\", mass_kg: 2, shape: sphere(radius_m: 0.5), position_m: ({x}, 0, -50))"
        )
    };
    let balls = [0, 1, 2, 3].map(ball).join(", ");
    let text = format!(
        "(version: 1, step_hz: 100, push: (radius_m: 2.5), camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0),
          bodies: [{balls}, (name: \"held\", immovable: true, position_m: (0, 1, -50))])"
    );
    let mut drive = selecting(Drive::of(scene_of(&text)));
    let middle = drive.pixel(drive.x("b0"));
    assert_eq!(drive.select(middle).as_deref(), Some("b0"));
    drive.click(Button::Right, middle).frame(0.01, []);
    // 10 N along -z for a tick, at the front of the first ball: 0.5 m nearer than the middles.
    for (name, x) in [("b1", 1.0_f64), ("b2", 2.0)] {
        let share = (1.0 - (x * x + 0.25) / 6.25).powi(2);
        let off = drive.v(name) + DVec3::Z * (0.05 * share);
        assert!(off.length() < 1e-8, "{name}: {off}");
    }
    assert!(
        (drive.v("b0") + DVec3::Z * 0.05).length() < 1e-8,
        "the one that is hit gets all of it"
    );
    assert_eq!((drive.v("b3"), drive.v("held")), (DVec3::ZERO, DVec3::ZERO));
}

#[test]
fn a_fast_body_is_hit_where_it_is_drawn_and_not_where_the_tick_has_it() {
    let ball = "(name: \"ball\", shape: sphere(radius_m: 0.5), position_m: (-10, 0, -50), velocity_m_s: (600, 0, 0))";
    let mut drive = selecting(Drive::bodies(ball));
    // Two ticks and a quarter of the next have passed, so it is drawn a quarter of the way from tick 1 to tick 2.
    drive.frame(2.25 * H, []);
    assert!((drive.x("ball").x - 0.0).abs() < 1e-9);
    let (drawn, of_tick) =
        (drive.pixel(DVec3::new(-3.75, 0.0, -50.0)), drive.pixel(drive.x("ball")));
    assert_eq!(drive.select(of_tick), None);
    assert_eq!(drive.select(drive.pixel(DVec3::new(-5.0, 0.0, -50.0))), None);
    assert_eq!(drive.select(drawn).as_deref(), Some("ball"));
    // Pushed there, too, and only there.
    drive.click(Button::Right, of_tick).click(Button::Right, drawn).frame(H, []);
    let dv = drive.v("ball") - DVec3::X * 600.0;
    assert!((dv.length() - 10.0 * H).abs() < 1e-12, "{dv}");
    // While paused the state of the tick is drawn.
    drive.press("P");
    assert_eq!(drive.select(drive.pixel(drive.x("ball"))).as_deref(), Some("ball"));
}

#[test]
fn a_click_right_after_a_reset_finds_the_new_bodies_also_from_the_origin() {
    let mut drive = selecting(Drive::bodies(TWO));
    let pixel = drive.pixel(DVec3::new(3.5, 0.0, -40.0));
    let events = [at(pixel)].into_iter().chain(click(Button::Left));
    drive.give(events.chain(crate::rigs::tap("F1")).chain(click(Button::Left)));
    assert_eq!(drive.selected().as_deref(), Some("far"));
}

#[test]
fn a_removed_body_is_selected_no_more_even_while_the_button_is_held() {
    let mut drive = selecting(Drive::bodies(TWO));
    drive.give([at(SIZE / 2.0), Input::ButtonDown(Button::Left)]);
    assert_eq!(drive.selected().as_deref(), Some("near"));
    drive.give([remove("near")]);
    assert!(
        drive.session.stage.selection().is_none_or(|thing| drive
            .session
            .stage
            .sim()
            .world
            .get_entity(thing)
            .is_ok())
    );
    assert_eq!(drive.give([]).selected().as_deref(), Some("far"));
}

#[test]
fn pixels_are_those_of_the_present_size_of_the_picture() {
    let mut drive = selecting(Drive::tutorial());
    let player = drive.pixel(drive.x("player"));
    drive.give([Input::Resized([640, 360])]);
    assert_eq!(drive.select(player / 2.0).as_deref(), Some("player"));
    assert_ne!(drive.select(player).as_deref(), Some("player"));
    // A minimized window has no pixels; a click then must do no harm.
    drive
        .give([Input::Resized([0, 0])])
        .click(Button::Left, DVec2::ZERO)
        .click(Button::Right, DVec2::ZERO);
    drive.ticks(2).give([Input::Resized([1280, 720])]);
    assert_eq!(drive.select(player).as_deref(), Some("player"));
}
