//! Pictures against references, and relations between pictures.

use std::process::Command;

use glam::DVec2;
use render::Image;
use sandbox::clock::FrameClock;
use sandbox::input::{Button, Input, InputFrame};
use sandbox::player::Player;
use sandbox::{Mode, Options, Order, Session, Words};
use scene::{Scene, Script};
use tempfile::TempDir;

use crate::rigs::{
    CHANNEL, Difference, FILM_SIZE, Film, Studio, assert_pictures, blesses, change, compared, down,
    green, output, places, program, remove, root, sandbox, tap, yellow,
};

/// A stage close by, `offset` meters along x and z from the world's origin.
fn stage(offset: f64, shadows: bool, grid: bool) -> Scene {
    let grid = if grid {
        format!(
            "grids: [(kind: mixed, rows: 3, columns: 3, spacing_m: (3.5, 3.5),
                      origin_m: ({x}, 6.0, {z}), mass_kg: 0.1)],",
            x = offset - 3.5,
            z = offset - 8.0
        )
    } else {
        String::new()
    };
    let text = format!(
        "(
            version: 1, name: \"stage\", description: \"a stage close by\", seed: 7,
            gravity: (acceleration_m_s2: (0.0, -9.8, 0.0), on_at_start: false),
            push: (start_n: 60.0, newtons_per_notch: 100.0),
            camera: (position_m: ({offset}, 6.0, {camera}), pitch_deg: -15.0, yaw_deg: 0.0,
                     fov_y_deg: 45.0, near_m: 0.1, far_m: 500.0),
            light: (position_m: ({light}, 60.0, {light}), color: (0.8, 0.8, 0.5), shadows: {shadows}),
            bodies: [
                (name: \"floor\", shape: cuboid(half_extents_m: (100.0, 2.0, 100.0)),
                 position_m: ({offset}, -2.0, {offset}), immovable: true, texture: checker),
                (name: \"box\", shape: cuboid(half_extents_m: (0.9, 0.9, 0.9)),
                 position_m: ({left}, 3.0, {offset}), rotation_deg: (0.0, 30.0, 0.0), mass_kg: 1.0),
                (name: \"ball\", shape: sphere(radius_m: 1.0),
                 position_m: ({right}, 3.0, {offset}), mass_kg: 1.0, texture: checker),
            ],
            {grid}
        )",
        camera = offset + 18.0,
        light = offset + 60.0,
        left = offset - 2.0,
        right = offset + 2.0,
    );
    Scene::parse("stage", &text).unwrap_or_else(|error| panic!("{error}"))
}

fn middle(places: &[DVec2]) -> DVec2 {
    assert!(!places.is_empty(), "no such pixel");
    places.iter().sum::<DVec2>() / places.len() as f64
}

/// The tour as `sandbox run` plays it, its pointer scaled to the smaller picture: the pictures named `wanted`.
fn tour(wanted: &[&str]) -> Vec<Image> {
    let path = root().join("assets/scripts/tour.ron");
    let script = Script::parse("tour.ron", &std::fs::read_to_string(path).unwrap()).unwrap();
    let mut player = Player::new(script).unwrap();
    let scene = scene::load("tutorial").unwrap();
    let mut session = Session::new(scene, Options { size_px: FILM_SIZE, ..Options::default() });
    let (mut clock, mut studio, mut pictures) =
        (FrameClock::default(), Studio::new(FILM_SIZE), Vec::new());
    while !player.finished() {
        let time = clock.advance_to(session.stage.playback().frames() as f64 / 60.0).unwrap();
        let mut events = player.of_frame(
            session.stage.playback().frames(),
            session.stage.sim().ticks(),
            time.total() - time.length(),
            time.total(),
        );
        for event in &mut events {
            // The tour points at pixels of a picture of twice the size; counts that turn the camera stay.
            if let (Input::Mouse(x, y), Mode::Selection) = (event, session.view.mode()) {
                (*x, *y) = (*x / 2.0, *y / 2.0);
            }
        }
        session.advance(&events.into_iter().collect(), time);
        for order in session.stage.take_orders() {
            if matches!(order, Order::Screenshot(Some(name)) if wanted.contains(&name.as_str())) {
                pictures.push(studio.draw(&mut session));
            }
        }
    }
    assert_eq!(pictures.len(), wanted.len(), "the tour has no such screenshots: {wanted:?}");
    pictures
}

#[test]
fn the_start_view_of_the_tutorial_is_its_reference() {
    let mut film = Film::shipped("tutorial");
    assert_pictures(["tutorial_start"], &[Studio::new(FILM_SIZE).draw(&mut film.session)]);
}

#[test]
fn the_tour_falls_and_ends_as_its_references() {
    let pictures = tour(&["4_falling.png", "5_fallen_through_the_floor.png"]);
    assert_pictures(["tour_falling", "tour_end"], &pictures);
}

#[test]
fn a_selected_body_close_by_is_its_reference() {
    let mut film = Film::of(stage(0.0, true, true));
    film.select("box");
    assert_pictures(["selected"], &[Studio::new(FILM_SIZE).draw(&mut film.session)]);
}

#[test]
fn the_settings_beside_a_selected_body_are_their_reference() {
    let mut film = Film::of(stage(0.0, true, false));
    film.select("ball").press("Tab");
    assert_pictures(["settings"], &[Studio::new(FILM_SIZE).draw(&mut film.session)]);
}

#[test]
fn a_selected_body_is_green_and_outlined_where_it_is_projected_to() {
    let mut studio = Studio::new(FILM_SIZE);
    for body in ["box", "ball"] {
        let mut film = Film::of(stage(0.0, true, false));
        let before = studio.draw_bodies(&mut film.session);
        assert_eq!(places(&before, |pixel| green(pixel) || yellow(pixel)), []);
        film.select(body);
        let after = studio.draw_bodies(&mut film.session);
        for color in [green, yellow] {
            let places = places(&after, color);
            assert!(places.len() > 200, "{body}: {} pixels", places.len());
            // A lit and a dark side shift the middle a little.
            let off = middle(&places).distance(film.pixel(body));
            assert!(off < 6.0, "{body} is seen {off} pixels from where it is");
        }
    }
}

#[test]
fn a_push_along_the_ray_takes_the_selected_body_away_from_the_eye() {
    let mut studio = Studio::new(FILM_SIZE);
    let mut film = Film::of(stage(0.0, true, false));
    film.select("ball");
    let (aim, before) = (film.pixel("ball"), studio.draw_bodies(&mut film.session));
    film.click(Button::Right).frames(120);
    let after = studio.draw_bodies(&mut film.session);
    let (near, far) = (places(&before, yellow), places(&after, yellow));
    let width = |places: &[DVec2]| {
        places.iter().map(|place| place.x).fold(f64::MIN, f64::max)
            - places.iter().map(|place| place.x).fold(f64::MAX, f64::min)
    };
    // 60 N on 1 kg for a tick are 0.5 m/s, one meter of nearly twenty.
    assert!(width(&far) < width(&near), "{} pixels wide, then {}", width(&near), width(&far));
    assert!(Difference::between(&before, &after).pixels > 100);
    // Straight away from the eye: its middle stays under the pointer.
    assert!(film.pixel("ball").distance(aim) < 1e-6);
    assert!(middle(&far).distance(aim) < 2.0);
}

#[test]
fn a_push_key_to_the_right_moves_the_selected_body_to_the_right_and_not_the_floor() {
    let mut studio = Studio::new(FILM_SIZE);
    let mut film = Film::of(stage(0.0, true, false));
    film.select("box");
    let (from, before) = (film.pixel("box"), studio.draw_bodies(&mut film.session));
    film.frame([down("Right")]).frames(30);
    let (to, after) = (film.pixel("box"), studio.draw_bodies(&mut film.session));
    let seen = middle(&places(&after, green)) - middle(&places(&before, green));
    assert!(to.x > from.x + 15.0, "from {from} to {to}");
    assert!(seen.distance(to - from) < 4.0, "moved by {} and is seen to move by {seen}", to - from);
    // The left edge of the picture and its near floor: no body comes there and no shadow.
    for (origin, size) in [([0, 0], [120, 360]), ([0, 300], [640, 60])] {
        let strip = |image: &Image| image.crop(origin, size).unwrap();
        assert!(strip(&before) == strip(&after), "the floor changed in {size:?} at {origin:?}");
    }
}

#[test]
fn gravity_makes_the_grid_lower_in_the_picture() {
    let mut studio = Studio::new(FILM_SIZE);
    // Without shadows a difference to the empty stage is a body.
    let empty = studio.draw_bodies(&mut Film::of(stage(0.0, false, false)).session);
    let mut film = Film::of(stage(0.0, false, true));
    let grid = |studio: &mut Studio, film: &mut Film| {
        let picture = studio.draw_bodies(&mut film.session);
        middle(&places(&Difference::between(&picture, &empty).picture, |pixel| pixel == [255; 4]))
    };
    let start = grid(&mut studio, &mut film);
    film.frames(30);
    assert_eq!(grid(&mut studio, &mut film), start, "nothing moves before gravity is on");
    film.press("G").frames(30);
    let fallen = grid(&mut studio, &mut film);
    assert!(fallen.y > start.y + 8.0, "from row {} to row {}", start.y, fallen.y);
}

#[test]
fn velocity_arrows_add_pixels_of_their_color_where_something_moves() {
    let mut studio = Studio::new(FILM_SIZE);
    let arrow = |[r, g, b, _]: [u8; 4]| r.abs_diff(77) < 4 && g.abs_diff(191) < 4 && b > 251;
    let mut film = Film::of(stage(0.0, true, false));
    let mut count = |film: &mut Film| places(&studio.draw_bodies(&mut film.session), arrow).len();
    film.press("1");
    assert_eq!(count(&mut film), 0, "nothing moves yet");
    film.frame([change("ball", scene::ChangeAction::SetVelocity, [0.0, 8.0, 0.0])]).frames(5);
    assert!(count(&mut film) > 10, "{} pixels of an arrow", count(&mut film));
    film.press("1");
    assert_eq!(count(&mut film), 0, "the arrows are off again");
}

#[test]
fn pictures_of_one_state_are_equal_to_the_bit() {
    let pictures: Vec<_> = (0..2)
        .map(|_| {
            let mut studio = Studio::new(FILM_SIZE);
            let mut film = Film::of(stage(0.0, true, true));
            film.select("box").press("G").frames(20);
            [studio.draw(&mut film.session), studio.draw(&mut film.session)]
        })
        .collect();
    assert!(pictures[0][0] == pictures[0][1], "a second drawing of the same session differs");
    assert!(pictures[0] == pictures[1], "a second session differs");
}

#[test]
fn a_session_100_km_from_the_origin_draws_the_same_picture() {
    let mut studio = Studio::new(FILM_SIZE);
    // Without shadows: the shadow map looks at the world's origin, as the tutorial's does.
    let mut pictures = [0.0, 1e5].map(|offset| {
        let mut film = Film::of(stage(offset, false, true));
        film.select("box").press("G").frames(20);
        studio.draw_bodies(&mut film.session)
    });
    let difference = Difference::between(&pictures[0], &pictures[1]);
    assert!(difference.accepted(), "{difference}");
    pictures[1] = studio.draw_bodies(&mut Film::of(stage(1e5, false, true)).session);
    assert!(!Difference::between(&pictures[0], &pictures[1]).accepted(), "both show nothing");
}

#[test]
fn a_picture_without_one_small_body_is_rejected() {
    let mut studio = Studio::new(FILM_SIZE);
    let mut pictures = [false, true].map(|removes| {
        let mut film = Film::shipped("tutorial");
        film.frame(removes.then(|| remove("grid.x4.z4"))).frame([]);
        studio.draw_bodies(&mut film.session)
    });
    let difference = Difference::between(&pictures[0], &pictures[1]);
    assert!(!difference.accepted(), "{difference}");
    // Noise below the threshold is no difference, and one above it in every pixel is.
    for (noise, accepted) in [(CHANNEL, true), (CHANNEL + 1, false)] {
        pictures[1] = pictures[0].clone();
        pictures[1].rgba.iter_mut().for_each(|channel| *channel = channel.abs_diff(noise));
        assert_eq!(Difference::between(&pictures[0], &pictures[1]).accepted(), accepted);
    }
}

#[test]
fn a_reference_is_missing_blessed_matched_or_missed() {
    let folder = tempfile::tempdir().unwrap();
    let (references, evidence) = (folder.path(), folder.path().join("evidence"));
    let plain = |shade: u8| Image { size_px: [8, 8], rgba: vec![shade; 256] };
    let compare = |shade: u8, bless| compared(&plain(shade), "plain", references, &evidence, bless);
    assert!(compare(9, false).unwrap_err().contains("is missing"));
    assert!(compare(9, true).unwrap_err().contains("run again"), "a blessing run fails too");
    assert_eq!(compare(9, false), Ok(()));
    let reason = compare(99, false).unwrap_err();
    for what in ["actual", "expected", "difference"] {
        let path = evidence.join(format!("plain.{what}.png"));
        assert!(path.exists() && reason.contains(path.to_str().unwrap()), "{reason}");
    }
    let other = Image { size_px: [4, 16], rgba: vec![9; 256] };
    assert!(
        compared(&other, "plain", references, &evidence, false)
            .unwrap_err()
            .contains("another size")
    );
}

#[test]
fn pictures_without_an_adapter_are_exit_code_4_that_says_what_to_install() {
    let folder = tempfile::tempdir().unwrap();
    let mut program = Command::new(program());
    program.args(["run", "tutorial", "--ticks", "1", "--frames"]).arg(folder.path());
    // Hides every driver.
    program.env("WGPU_BACKEND", "vulkan");
    program
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .env("VK_DRIVER_FILES", "/nonexistent.json");
    output(&mut program).fails(4, "mesa-vulkan-drivers");
}

#[test]
fn the_film_of_a_run_has_all_of_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.png");
    sandbox(&folder, "run orbits_race --seconds 0.2 --fps 20 --size 320x180 --film film.png")
        .fine();
    let bytes = std::fs::read(&film).unwrap();
    let chunks = |name: &[u8]| bytes.windows(4).filter(|bytes| *bytes == name).count();
    assert_eq!([b"acTL", b"fcTL", b"IDAT", b"fdAT"].map(|name| chunks(name)), [1, 5, 1, 4]);
    assert_eq!(Image::read_png(&film).unwrap().size_px, [320, 180]);
}

/// The cockpit of a paused scene with these keys pressed; the view itself is black.
fn cockpit(size_px: [u32; 2], keys: &[&str]) -> Image {
    let options = Options { size_px, paused: true, ..Options::default() };
    let mut session = Session::new(scene::load("bridge").unwrap(), options);
    let mut clock = FrameClock::default();
    let frames =
        keys.iter().map(|key| tap(key).to_vec()).chain([Vec::new(), Vec::new(), Vec::new()]);
    for events in frames {
        session.advance(&events.into_iter().collect(), clock.advance_by(1.0 / 60.0).unwrap());
    }
    let mut image = Studio::new(size_px).draw(&mut session);
    let [corner, size] = session.view.view_area();
    for (at, pixel) in (0..).zip(image.rgba.chunks_exact_mut(4)) {
        let place =
            DVec2::new(f64::from(at % size_px[0]), f64::from(at / size_px[0])) + 0.5 - corner;
        if place.cmpge(DVec2::ZERO).all() && place.cmplt(size).all() {
            pixel.copy_from_slice(&[0, 0, 0, 255]);
        }
    }
    image
}

#[test]
fn the_cockpit_is_its_reference_at_four_sizes_and_in_both_themes() {
    let pictures = [
        cockpit([1024, 600], &["F10", "Tab"]),
        cockpit([1280, 720], &["F10", "F7", "V", "Y", "F6"]),
        cockpit([1920, 1080], &["F10", "Tab", "E", "V"]),
        cockpit([2560, 1440], &["F10", "F7", "Ctrl+=", "Tab", "B", "R"]),
    ];
    assert_pictures(["cockpit_1024", "cockpit_1280", "cockpit_1920", "cockpit_2560"], &pictures);
}

/// Seconds after which a thumbnail is drawn, for scenes that show little after two seconds.
const SECONDS: [(&str, u32); 11] = [
    ("galaxies", 7),
    ("solar", 6),
    ("orbits_race", 6),
    ("orbit", 6),
    ("figure_eight", 6),
    ("ship", 4),
    ("ship_between", 6),
    ("verlet_start", 3),
    ("coast", 3),
    ("everything", 5),
    ("fountain", 4),
];

/// The thumbnail of a shipped scene: without words, framed if the scene leaves that to the program.
fn thumbnail(name: &str, studio: &mut Studio) -> Image {
    let options =
        Options { size_px: [240, 135], words: Words::None, pictures: false, ..Options::default() };
    let mut session = Session::new(scene::load(name).unwrap(), options);
    let mut clock = FrameClock::default();
    let seconds =
        SECONDS.iter().find(|(other, _)| *other == name).map_or(2, |(_, seconds)| *seconds);
    for frame in 0..=60 * seconds {
        let frames = frame == 0 && session.view.should_be_framed(&session.stage);
        let events = if frames { tap("F").to_vec() } else { Vec::new() };
        session.advance(&InputFrame { events }, clock.advance_to(f64::from(frame) / 60.0).unwrap());
    }
    studio.draw(&mut session)
}

/// How many tiles of two pictures have another mean color. Edges differ by the renderer.
fn other_tiles(a: &Image, b: &Image) -> usize {
    const TILE: [u32; 2] = [6, 5];
    const OFF: u32 = 6;
    assert_eq!(a.size_px, b.size_px);
    let mean = |image: &Image, tile: [u32; 2]| {
        let mut sums = [0; 3];
        for (dx, dy) in (0..TILE[0]).flat_map(|x| (0..TILE[1]).map(move |y| (x, y))) {
            let pixel = image.pixel(tile[0] * TILE[0] + dx, tile[1] * TILE[1] + dy).unwrap();
            sums.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += u32::from(channel));
        }
        sums.map(|sum| sum / (TILE[0] * TILE[1]))
    };
    let [columns, rows] = [a.size_px[0] / TILE[0], a.size_px[1] / TILE[1]];
    let tiles = (0..columns).flat_map(|x| (0..rows).map(move |y| [x, y]));
    let differs = |tile: &[u32; 2]| {
        let [a, b] = [mean(a, *tile), mean(b, *tile)];
        a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > OFF)
    };
    tiles.filter(differs).count()
}

#[test]
fn the_pictures_of_the_documents_show_the_window_of_this_program() {
    let folder = TempDir::new().unwrap();
    let mut script = Command::new("bash");
    script.arg(root().join("scripts/pictures")).arg(folder.path()).env("SANDBOX", program());
    output(&mut script).fine();
    let (wanted, evidence) = (root().join("docs/window"), root().join("target/pictures/window"));
    let other = std::fs::read_dir(&wanted).unwrap().filter_map(|stored| {
        let file = stored.unwrap().file_name();
        let picture = Image::read_png(folder.path().join(&file)).unwrap();
        let name = file.to_str().unwrap().strip_suffix(".png").unwrap();
        compared(&picture, name, &wanted, &evidence, blesses()).err()
    });
    let other: Vec<_> = other.collect();
    assert!(other.is_empty(), "{}", other.join("\n"));
}

#[test]
fn every_thumbnail_shows_its_scene() {
    // Of 1080 tiles.
    const MOST: usize = 5;
    let mut studio = Studio::of_high_quality([240, 135]);
    let path = |name: &str| root().join(format!("crates/cockpit/assets/thumbnails/{name}.png"));
    // A lesson plays in the last one.
    let shipped = scene::shipped().iter().map(|scene| scene.name);
    let names: Vec<_> = shipped.chain(["stiff_spring"]).collect();
    let pictures: Vec<_> = names.iter().map(|name| thumbnail(name, &mut studio)).collect();
    if blesses() {
        for (name, picture) in names.iter().zip(&pictures) {
            std::fs::write(path(name), picture.png(&[]).unwrap()).unwrap();
        }
        panic!("the thumbnails are written: look at them, and run again without BLESS");
    }
    let stored: Vec<_> = names.iter().map(|name| Image::read_png(path(name)).unwrap()).collect();
    for (i, (name, picture)) in names.iter().zip(&pictures).enumerate() {
        let off: Vec<_> = stored.iter().map(|stored| other_tiles(picture, stored)).collect();
        assert!(off[i] <= MOST, "{name}: {} tiles are off; BLESS=1 draws it again", off[i]);
        // The tutorial and its step by frames look alike; no other two scenes do.
        let alike = off.iter().filter(|off| **off <= MOST).count();
        assert!(alike <= 2, "{name} looks like {alike} thumbnails");
    }
}
