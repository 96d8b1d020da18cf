//! What ghosts look like.

use render::{Frame, Line};
use scene::Scene;

use crate::rigs::{FILM_SIZE, Film, Studio, assert_pictures, change, scene_of};

/// Seconds of `scene` with ghosts from the start.
fn haunted(scene: Scene, seconds: u32) -> Film {
    let mut film = Film::of(scene);
    film.press("T").frames(60 * seconds);
    film
}

#[test]
fn ghosts_are_drawn_translucent_in_the_colors_of_their_methods() {
    let mut film = haunted(scene::load("third_law").unwrap(), 4);
    let picture = Studio::new(FILM_SIZE).draw(&mut film.session);
    assert_pictures(["ghosts"], &[picture]);
}

fn has_color(color: [f32; 4], srgb: [u8; 3]) -> bool {
    color.iter().zip(srgb).all(|(a, b)| (a * 255.0 - f32::from(b)).abs() < 0.5)
}

#[test]
fn each_ghost_has_a_line_to_the_reference_in_its_color() {
    let mut film = haunted(scene::load("third_law").unwrap(), 4);
    let frame = film.session.picture();
    let wide = |line: &&Line| line.start_width_px == 1.5 && line.start_color[3] == 0.9;
    for ink in report::INKS {
        let lines =
            frame.lines.iter().filter(wide).filter(|line| has_color(line.start_color, ink.srgb));
        assert_eq!(lines.count(), 5, "{}", ink.short);
    }
    let reference = frame.translucent.spheres.iter().filter(|ball| has_color(ball.color, [255; 3]));
    let reference: Vec<_> = reference.map(|ball| ball.position).collect();
    assert_eq!(reference.len(), 5);
    let inked = |line: &&Line| report::INKS.iter().any(|ink| has_color(line.start_color, ink.srgb));
    let mut lines = frame.lines.iter().filter(wide).filter(inked);
    assert!(lines.all(|line| reference.contains(&line.end)), "lines end at it");
    // Eight ghosts beside the solid method, and the reference.
    assert_eq!(frame.translucent.spheres.len(), 9 * 5);
    assert!(frame.translucent.spheres.iter().all(|ball| ball.color[3] == 0.35));
}

#[test]
fn of_many_bodies_the_farthest_have_lines() {
    let film = |count: u32| {
        let text = format!(
            "(version: 1, step_hz: 30, gravity: (), drag: (quadratic_per_m: 0.1), camera: (position_m: (0, 0, 90), pitch_deg: 0, yaw_deg: 0),
              clouds: [(count: {count}, center_m: (0, 0, 0), half_extents_m: (20, 20, 20), speed_m_s: 9)])"
        );
        haunted(scene_of(&text), 1).session.picture().lines
    };
    let length = |line: &Line| glam::Vec3::from(line.start).distance(line.end.into());
    assert_eq!(film(10).len(), 90);
    let lines = film(300);
    assert_eq!(lines.len(), 200);
    assert!(lines.windows(2).all(|pair| length(&pair[0]) > length(&pair[1]) - 1e-4));
}

fn moving(frame: &Frame) -> Vec<[f32; 3]> {
    frame.translucent.spheres.iter().map(|ball| ball.position).collect()
}

#[test]
fn ghosts_are_drawn_between_two_ticks_as_solid_bodies_are() {
    let text =
        "(version: 1, step_hz: 15, camera: (position_m: (0, 0, 20), pitch_deg: 0, yaw_deg: 0), bodies: [
        (name: \"ball\", shape: sphere(radius_m: 1), velocity_m_s: (3, 0, 0))])";
    let mut film = Film::of(scene_of(text));
    film.press("T");
    for _ in 0..9 {
        film.frames(1);
        let frame = film.session.picture();
        // Coasting, all methods agree but for rounding.
        let [solid] = frame.spheres[..] else { panic!("one ball") };
        let near = |place: &[f32; 3]| (place[0] - solid.position[0]).abs() < 1e-4;
        assert!(moving(&frame).len() == 9 && moving(&frame).iter().all(near));
    }
}

#[test]
fn what_is_on_its_way_to_infinity_is_not_drawn() {
    let text = "(version: 1, camera: (position_m: (0, 0, 20), pitch_deg: 0, yaw_deg: 0), bodies: [
        (name: \"ball\", shape: sphere(radius_m: 1)), (name: \"still\", shape: sphere(radius_m: 1), position_m: (4, 0, 0))])";
    let mut film = Film::of(scene_of(text));
    film.press("T")
        .frame([change("ball", scene::ChangeAction::SetVelocity, [1e300, 0.0, 0.0])])
        .frames(3);
    let places = moving(&film.session.picture());
    assert_eq!(places.len(), 9);
    assert!(places.iter().flatten().all(|part| part.is_finite()));
    Studio::new(FILM_SIZE).draw(&mut film.session);
}
