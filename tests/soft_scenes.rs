//! The shipped scenes of soft bodies and particles: their pictures against references, and how they move when pushed.

use glam::DVec3;
use sandbox::input::{Button, Input};

use crate::rigs::{Drive, FILM_SIZE, Film, Studio, assert_pictures, at};

/// Rows and columns of points of the flag, and the distance between two neighbors at the start, m.
const ROWS: u32 = 17;
const COLUMNS: u32 = 25;
const CELL: f64 = 0.25;

fn point(row: u32, column: u32) -> String {
    format!("flag.r{row}.c{column}")
}

/// Every point of the flag, row by row.
fn points(drive: &Drive) -> Vec<DVec3> {
    (0..ROWS * COLUMNS).map(|number| drive.x(&point(number / COLUMNS, number % COLUMNS))).collect()
}

/// The number of a point in that list.
const fn number(row: u32, column: u32) -> usize {
    (row * COLUMNS + column) as usize
}

/// Row and column of the point of that number.
fn place(number: usize) -> (u32, u32) {
    let number = u32::try_from(number).unwrap();
    (number / COLUMNS, number % COLUMNS)
}

/// The flag after `seconds`, in selection mode.
fn flag(seconds: u32) -> Drive {
    let mut drive = Drive::shipped("flag");
    drive.press("Q").ticks(120 * seconds);
    drive
}

/// How far each point of one flag is from where it is in the other.
fn apart(one: &Drive, other: &Drive) -> Vec<f64> {
    points(one).into_iter().zip(points(other)).map(|(a, b)| a.distance(b)).collect()
}

fn farthest(apart: &[f64]) -> usize {
    (0..apart.len()).max_by(|a, b| apart[*a].total_cmp(&apart[*b])).unwrap()
}

#[test]
fn scenes_after_two_seconds_are_their_references() {
    let mut studio = Studio::new(FILM_SIZE);
    let names = ["flag", "cape", "fountain"];
    let pictures = names.map(|name| {
        let mut film = Film::shipped(name);
        film.frames(120);
        assert_eq!(film.session.stage.sim().ticks(), 240);
        studio.draw_bodies(&mut film.session)
    });
    assert_pictures(names, &pictures);
}

#[test]
fn the_springs_of_the_flag_are_their_reference() {
    let mut film = Film::shipped("flag");
    film.frames(120).press("P").press("3");
    assert_pictures(["flag_springs"], &[Studio::new(FILM_SIZE).draw_bodies(&mut film.session)]);
}

#[test]
fn a_pushed_jelly_is_its_reference() {
    let mut film = Film::shipped("jelly");
    film.press("Q");
    let middle = film.pixel("jelly.x2.y2.z4");
    film.frame([at(middle)]).click(Button::Left);
    let selected = film.session.stage.selection().expect("the jelly is under the pointer");
    assert_eq!(film.session.stage.name(selected), "jelly");
    film.frame([Input::Wheel(3.0)]);
    for _ in 0..4 {
        film.click(Button::Right);
    }
    film.press("Escape").frames(1);
    assert_pictures(["jelly_pushed"], &[Studio::new(FILM_SIZE).draw_bodies(&mut film.session)]);
}

#[test]
fn the_free_edge_of_the_flag_waves_and_the_edge_at_the_pole_stays() {
    let mut drive = flag(1);
    let before = points(&drive);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for _ in 0..120 {
        drive.ticks(1);
        let z = drive.x(&point(ROWS / 2, COLUMNS - 1)).z;
        (low, high) = (low.min(z), high.max(z));
    }
    let after = points(&drive);
    assert!(high - low > CELL, "the middle of the free edge moved between {low} m and {high} m");
    for row in 0..ROWS {
        let [free, pinned] = [number(row, COLUMNS - 1), number(row, 0)];
        assert!(before[free].distance(after[free]) > 0.1 * CELL, "row {row} stands still");
        assert_eq!(before[pinned], after[pinned]);
    }
}

#[test]
fn a_push_in_the_middle_of_the_flag_moves_the_point_there_and_its_neighbors_follow() {
    let (mut pushed, mut plain) = (flag(1), flag(1));
    let pixel = pushed.pixel(pushed.x(&point(8, 12)));
    assert_eq!(pushed.select(pixel).as_deref(), Some("flag"));
    pushed.click(Button::Right, pixel).ticks(1);
    plain.ticks(1);
    let first = apart(&pushed, &plain);
    let hit = farthest(&first);
    let (row, column) = place(hit);
    assert!(
        row.abs_diff(8) <= 1 && column.abs_diff(12) <= 1,
        "row {row}, column {column} was pushed"
    );
    // Springs carry it on at once, but most of it is in one point yet.
    let beside = [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
        .map(|(row, column)| number(row, column));
    let far = [(0, 1), (0, COLUMNS - 1), (ROWS - 1, 1), (ROWS - 1, COLUMNS - 1)]
        .map(|(row, column)| number(row, column));
    for place in beside.into_iter().chain(far) {
        assert!(first[place] < 0.5 * first[hit], "{} m and {} m", first[place], first[hit]);
    }
    // 0.1 s. The air takes the motion away within that time, so it is the farthest of each that counts.
    let mut peaks = first;
    for _ in 0..12 {
        pushed.ticks(1);
        plain.ticks(1);
        peaks.iter_mut().zip(apart(&pushed, &plain)).for_each(|(peak, now)| *peak = peak.max(now));
    }
    for place in beside {
        assert!(
            peaks[place] > 0.05 * peaks[hit],
            "a neighbor: {} m of {} m",
            peaks[place],
            peaks[hit]
        );
        for far in far {
            assert!(
                peaks[far] < 0.5 * peaks[place],
                "far away: {} m of {} m",
                peaks[far],
                peaks[place]
            );
        }
    }
}

#[test]
fn a_push_on_a_triangle_of_the_flag_moves_its_nearest_point_that_is_not_pinned() {
    for (row, column, along, down, expected) in [
        (8, 12, 0.05, 0.06, (8, 12)),
        (8, 12, 0.20, 0.21, (9, 13)),
        (3, 20, 0.21, 0.02, (3, 21)),
        (3, 20, 0.02, 0.21, (4, 20)),
        // Nearest is a point that is pinned to the pole.
        (8, 0, 0.08, 0.03, (8, 1)),
    ] {
        let (mut pushed, mut plain) = (flag(0), flag(0));
        let corner = pushed.x(&point(row, column));
        let pixel = pushed.pixel(corner + DVec3::new(along, -down, 0.0));
        assert_eq!(pushed.select(pixel).as_deref(), Some("flag"));
        pushed.click(Button::Right, pixel).ticks(1);
        plain.ticks(1);
        let hit = farthest(&apart(&pushed, &plain));
        assert_eq!(place(hit), expected, "{along} m along, {down} m down");
    }
}
