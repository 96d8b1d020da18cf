//! Looking changes nothing: panels, tabs and views are opened and closed, and the run, its settings and the saved text stay.

use std::sync::Arc;

use glam::DVec2;
use motion::{Damping, Gravity, Substeps, TimeStep};
use sandbox::actions::{Act, BINDINGS};
use sandbox::input::{Button, Input};
use sandbox::{Options, Order};
use scene::{Scene, Source};

use super::rigs::{Drive, H, at, click, middle, scene_of, tap};

/// A scene with a value of every field of the settings, all of that size.
fn scene_of_size(size: f64) -> Scene {
    scene_of(&format!(
        "(version: 1, step_hz: {size:?}, gravity: (acceleration_m_s2: (0.0, -{size:?}, 0.0)), push: (),
          damping: (model: exact, rate_per_s: {size:?}),
          bodies: [(name: \"ball\", mass_kg: {size:?}, velocity_m_s: ({size:?}, {:?}, 0.1234567890123))])",
        std::f64::consts::PI * size
    ))
}

/// A session with the bars and the dock, and the names of its controls.
fn opened(scene: &Scene, size_px: [u32; 2], selects: bool) -> Drive {
    let options = Options { pictures: false, interpolate: true, size_px, ..Options::default() };
    let mut drive = Drive::with(scene.clone(), options);
    let _ = drive.session.controls();
    drive.press("F10").give([]).give([]);
    if selects {
        drive.press("K");
    }
    drive
}

/// State, settings, and the text that Ctrl+Shift+S saves.
fn present(drive: &mut Drive) -> (u64, String, Option<Arc<str>>) {
    let hash = drive.hash();
    let sim = drive.session.stage.sim();
    let world = &sim.world;
    let settings = format!(
        "{:?} {:?} {:?} {:?} {:?}",
        world.resource::<TimeStep>(),
        world.get_resource::<Gravity>(),
        world.get_resource::<Damping>(),
        world.get_resource::<Substeps>(),
        sim.method(),
    );
    drive.session.stage.take_orders();
    drive.press("Ctrl+Shift+S");
    let orders = drive.session.stage.take_orders();
    let saved = orders.into_iter().find_map(|order| match order {
        Order::Scene(file) => Some(file.text),
        _ => None,
    });
    (hash, settings, saved)
}

/// The keys of all panels and of all that is drawn.
fn keys() -> Vec<&'static str> {
    let views = [
        Act::VelocityArrows,
        Act::ForceArrows,
        Act::Springs,
        Act::Trails,
        Act::ToggleTheme,
        Act::ToggleBrowser,
        Act::ToggleDock,
        Act::ToggleCockpit,
    ];
    let is_look = |act: Act| matches!(act, Act::Panel(_)) || views.contains(&act);
    let looks = BINDINGS.iter().filter(|row| is_look(row.act));
    looks.map(|row| row.keys[0]).collect()
}

/// Opens and closes everything, with a tick between every two keys; `only_time` presses nothing.
fn look(drive: &mut Drive, tick: f64, only_time: bool) {
    for key in keys() {
        for key in [key, if key == "Ctrl+O" || key == "F1" { "Escape" } else { key }] {
            if !only_time {
                drive.press(key).give([]).give([]);
            }
            drive.frame(tick, []);
        }
    }
    for tab in ["Look", "Measure", "Build", "Past"] {
        if !only_time && drive.has(tab) {
            let place = middle(&drive.control(tab));
            drive.give([at(place)]).give(click(Button::Left)).give([]).give([]);
        }
        drive.frame(tick, []);
    }
}

#[test]
fn panels_tabs_and_views_change_neither_the_run_nor_its_settings_nor_its_text() {
    let shipped = scene::shipped().iter().map(|shipped| scene::load(shipped.name).unwrap());
    let sizes = [1e-30, 1e-9, 1e-3, 1e4, 5.97e24, 1e30].map(scene_of_size);
    for (place, scene) in shipped.chain(sizes).enumerate() {
        let [size_px, other] =
            [place % 2, 1 - place % 2].map(|size| [[1024, 600], [2560, 1440]][size]);
        let tick = 1.0 / scene.step_hz;
        // A clock of a person cannot have ticks of 1e30 s.
        let tick = if tick < 1e7 { tick } else { 0.0 };
        // Shipped scenes have one of the four combinations each, the others all.
        let all =
            [(size_px, place % 4 < 2), (size_px, place % 4 >= 2), (other, false), (other, true)];
        let is_shipped = scene.source != Source::Text;
        for (size_px, selects) in all.into_iter().take(if is_shipped { 1 } else { 4 }) {
            let [mut still, mut looked] = [(); 2].map(|()| opened(&scene, size_px, selects));
            look(&mut still, tick, true);
            look(&mut looked, tick, false);
            assert_eq!(present(&mut looked), present(&mut still), "{}", scene.name);
        }
    }
}

/// The places of all numbers that can be typed, line by line.
fn numbers(drive: &Drive) -> Vec<DVec2> {
    let controls = drive.session.controls();
    let numbers = controls.iter().filter(|control| control.role == "SpinButton");
    let mut places: Vec<_> = numbers.map(middle).collect();
    places.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    places
}

/// Clicks every number of the panel, and leaves it as it is.
#[test]
fn a_number_that_is_clicked_and_left_stays() {
    for size in [1e-30, 1e-9, 5.97e24] {
        for panel in ["Tab", "M"] {
            let mut drive = opened(&scene_of_size(size), [1280, 1440], true);
            drive.press("P").press(panel).give([]).give([]);
            let before = present(&mut drive);
            let numbers = numbers(&drive);
            assert!(numbers.len() >= 4, "{panel}: {numbers:?}");
            for number in numbers {
                drive.give([at(number)]).give(click(Button::Left)).give([]);
                assert!(drive.session.takes_text(), "{number:?}");
                drive.give(tap("Enter")).give([]).give([]);
            }
            assert_eq!(present(&mut drive), before, "{panel}, {size}");
        }
    }
}

fn typed(drive: &mut Drive, place: DVec2, text: &str) {
    drive.give([at(place)]).give(click(Button::Left)).give([]);
    drive.give([Input::Text(text.to_owned())]).give(tap("Enter")).give([]).give([]);
}

#[test]
fn what_is_typed_into_the_settings_keeps_the_rules_of_scene_files() {
    let mut drive = opened(&scene_of_size(2.0), [1280, 1440], true);
    drive.press("P").press("Tab").give([]).give([]);
    // Gravity has three numbers; damping, rate, mass and velocity follow.
    let places = numbers(&drive);
    let step = |drive: &Drive| drive.session.stage.sim().world.resource::<TimeStep>().0;
    let says = |drive: &Drive, what: &str| {
        drive.session.stage.notices.texts().any(|text| text.contains(what))
    };
    for (text, hz) in [("0,75", 0.75), ("20000", 20_000.0), ("1e-9", 1e-9), ("2.5", 2.5)] {
        typed(&mut drive, places[4], text);
        assert_eq!(step(&drive), 1.0 / hz, "{text}");
    }
    for (number, text, what) in [
        (4, "0", "step_hz: 0 is not a step rate; give a positive number of steps per second"),
        (4, "ten", "\"ten\" is not a number; type one such as 0.75"),
        (3, "-1", "damping.rate_per_s: -1 is not a damping rate; give a rate per second from 0 up"),
        (5, "0", "mass_kg: 0 is not a mass; give a positive number of kilograms"),
        (6, "inf", "velocity_m_s: inf is not finite; give three finite numbers"),
    ] {
        let before = present(&mut drive);
        typed(&mut drive, places[number], text);
        assert!(says(&drive, what), "{text}");
        assert_eq!(present(&mut drive), before, "{text}");
    }
}

/// A field of a body that moves shows another number in every tick.
#[test]
fn a_velocity_can_be_typed_while_the_body_moves() {
    let text = "(version: 1, step_hz: 120, gravity: (), bodies: [(name: \"ball\")])";
    let mut drive = opened(&scene_of(text), [1280, 1440], true);
    drive.press("Tab").ticks(3);
    let y = numbers(&drive)[7];
    drive.frame(H, [at(y)]).frame(H, click(Button::Left)).ticks(2);
    drive.frame(H, [Input::Text("7".to_owned())]).ticks(3);
    let (before, after) = (drive.v("ball").y, drive.frame(H, tap("Enter")).ticks(3).v("ball").y);
    assert!((6.0..7.0).contains(&before) && after < before, "{before} m/s, then {after} m/s");
}
