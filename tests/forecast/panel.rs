//! The panel and the colors of springs, before and while something grows.

use history::Change;
use lab::trial::{Ahead, Trial};
use motion::margin::Margins;
use motion::{Method, Request};
use render::Frame;
use report::ForecastRow;
use sandbox::Session;
use sandbox::input::SwitchedBy;
use scene::Scene;

use crate::rigs::{FILM_SIZE, Film, Studio};

/// Four weights on a row of springs, the third of which is the stiffest, in a scene at 60 Hz.
fn hung(stiffest: f64) -> Film {
    let weight = |i: u32| {
        format!(
            "(name: \"w{i}\", position_m: ({}, 0, 0), mass_kg: 1.0, shape: sphere(radius_m: 0.2)),",
            f64::from(i) * 1.001
        )
    };
    let spring = |i: u32| {
        let stiffness = if i == 2 { stiffest } else { 50.0 };
        format!(
            "(between: (\"w{i}\", \"w{}\"), stiffness_n_m: {stiffness:?}, rest_length_m: 1.0),",
            i + 1
        )
    };
    let (weights, springs): (String, String) =
        ((0..5).map(weight).collect(), (0..4).map(spring).collect());
    let text = format!(
        "(version: 1, step_hz: 60, camera: (position_m: (2, 0, 6), pitch_deg: 0, yaw_deg: 0), bodies: [{weights}], springs: [{springs}])"
    );
    Film::of(Scene::parse("hung", &text).unwrap())
}

/// Red, green and blue of the springs, from the left.
fn colors(frame: &Frame) -> Vec<[f32; 4]> {
    let mut lines: Vec<_> = frame.lines.iter().filter(|line| line.start_width_px == 2.0).collect();
    lines.sort_by(|a, b| (a.start[0] + a.end[0]).total_cmp(&(b.start[0] + b.end[0])));
    lines.into_iter().map(|line| line.start_color).collect()
}

fn is_red([red, green, blue, _]: [f32; 4]) -> bool {
    red > 0.9 && green < 0.2 && blue < 0.2
}

fn is_green([red, green, ..]: [f32; 4]) -> bool {
    green > 2.0 * red
}

fn size(session: &Session) -> f64 {
    let positions = session
        .stage
        .sim()
        .remaining_bodies()
        .filter_map(|thing| session.stage.sim().world.get::<motion::Transform>(thing));
    positions.map(|at| at.position.length()).fold(0.0, f64::max)
}

#[test]
fn a_spring_turns_red_before_the_run_diverges() {
    // Two weights of 1 kg: w² = 2 k; the limit is w = 120 / s.
    let mut film = hung(1.15 * 7200.0);
    film.press("V").frames(1);
    let rows = film.session.tools.shown_forecast().unwrap();
    assert!(rows[0].is_fault() && rows[0].element == "spring w2 - w3", "{rows:?}");
    assert!(size(&film.session) < 5.0, "it is still where it was");
    let seen = colors(&film.session.picture());
    assert_eq!(seen.len(), 4);
    assert!(is_red(seen[2]) && is_green(seen[0]), "{seen:?}");
    film.frames(120);
    let end = size(&film.session);
    assert!(end.is_nan() || end > 1e3, "and then it diverges: {end}");

    let mut calm = hung(0.2 * 7200.0);
    calm.press("V").frames(60);
    assert!(!calm.session.tools.shown_forecast().unwrap()[0].is_fault());
    assert!(colors(&calm.session.picture()).into_iter().all(|color| !is_red(color)));
    assert!(size(&calm.session) < 5.0);
}

#[test]
fn a_spring_that_is_faster_than_every_number_is_red() {
    let mut film = hung(1e308);
    film.press("P").press("V").frames(1);
    let seen = colors(&film.session.picture());
    assert!(is_red(seen[2]), "{seen:?}: {:?}", film.session.tools.shown_forecast());
}

#[test]
fn the_panel_follows_the_method_and_forgets_when_it_is_closed() {
    let mut film = hung(1.15 * 7200.0);
    film.frames(1);
    assert!(film.session.tools.shown_forecast().is_none());
    film.press("V").frames(1);
    let now = |film: &Film| film.session.tools.shown_forecast().unwrap()[0].clone();
    assert_eq!(now(&film).cure_words, "needs 2 substeps, or implicit_euler");
    film.press("I").frames(1);
    assert_eq!(now(&film).setting().0, Method::ImplicitEuler);
    assert!(!now(&film).is_fault() && now(&film).cure_words.is_empty());
    film.press("V").frames(1);
    assert!(film.session.tools.shown_forecast().is_none());
}

#[test]
fn the_open_panel_follows_a_changed_body_at_once() {
    let mut film = hung(1.15 * 7200.0);
    film.press("P").press("V").frames(2);
    let worst = |film: &Film| film.session.tools.shown_forecast().unwrap()[0].clone();
    assert!(worst(&film).is_fault());
    for end in ["w2", "w3"] {
        let stage = &mut film.session.stage;
        let id = stage.sim().named(end).and_then(|body| stage.sim().id(body)).unwrap();
        stage.change(Change::request(Request::SetInverseMass(id, 0.1)), SwitchedBy::Settings);
    }
    film.frames(2);
    assert!(!worst(&film).is_fault(), "bodies of ten times the mass are slower");
}

#[test]
fn the_margins_of_thousands_of_groups_are_those_of_all_at_once() {
    let mut film = Film::of(scene::load("meadow").unwrap());
    film.frames(1).press("P").press("V").frames(1);
    assert!(film.session.tools.shown_forecast().is_none(), "a frame has time for a few groups");
    let frames = (0..400).take_while(|_| {
        film.frames(1);
        film.session.tools.shown_forecast().is_none()
    });
    assert!(frames.count() < 300);
    let rows = film.session.tools.shown_forecast().unwrap();
    let margins: Vec<_> = rows.iter().filter_map(ForecastRow::margin).copied().collect();
    let sim = film.session.stage.sim();
    assert_eq!(margins, Margins::of(&sim.world, sim.method()).list());
}

#[test]
fn the_open_panel_changes_no_bit_of_a_run() {
    let hash = |open: bool| {
        let mut film = Film::of(scene::load("flag").unwrap());
        film.press(if open { "V" } else { "1" }).frames(90);
        sandbox::report::state_hash(&film.session.stage)
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn the_panel_is_drawn() {
    let mut film = hung(1.15 * 7200.0);
    film.press("V").frames(3);
    let picture = Studio::new(FILM_SIZE).draw(&mut film.session);
    let closed = {
        let mut film = hung(1.15 * 7200.0);
        film.frames(3);
        Studio::new(FILM_SIZE).draw(&mut film.session)
    };
    assert!(crate::rigs::Difference::between(&picture, &closed).pixels > 5_000);
}

#[test]
fn no_shipped_scene_is_unstable_but_those_that_show_it() {
    let mut said = Vec::new();
    for shipped in scene::shipped() {
        let mut session = Session::new(shipped.load().unwrap(), sandbox::Options::default());
        let rows = session.tools.forecast_start(&mut session.stage, 1.0 / 60.0);
        said.extend(rows.iter().map(|row| format!("{}: {}", shipped.name, row.line())));
    }
    // It shows what implicit Euler makes of an orbit; what explicit Euler does takes longer than is tried.
    let [implicit] = &said[..] else { panic!("{said:#?}") };
    assert!(
        implicit.contains("orbits_race: ") && implicit.contains("implicit_euler loses"),
        "{implicit}"
    );
    let race = history::Simulation::new(scene::load("orbits_race").unwrap());
    let ahead = Ahead { seconds: Some(25.0), ..Ahead::DEFAULT };
    let mut trial = Trial::new(&race, ahead);
    trial.finish();
    let faults = trial.found().into_iter().filter(|tried| tried.verdict.is_fault());
    let methods: Vec<_> = faults.map(|tried| tried.method).collect();
    assert_eq!(methods, [Method::ImplicitEuler, Method::ExplicitEuler]);
}
