//! Pictures against references, and relations between pictures.

use std::path::Path;
use std::process::Command;

use glam::{DVec2, DVec3};
use motion::{FrameClock, Transform};
use render::{AdapterSummary, Gpu, Image, OFFSCREEN_FORMAT, Offscreen, Quality, Renderer};
use sandbox::actions::Key;
use sandbox::input::{Button, Experiment, Input, InputFrame};
use sandbox::player::Player;
use sandbox::{Mode, Options, Order, Session};
use scene::{Scene, Script};

use crate::harness::{program, root};

/// Small: drawn in software, and stored; large enough that the panels leave the bodies in sight.
pub const SIZE: [u32; 2] = [640, 360];

/// A channel may be off by this much of 255. Versions of a software renderer differ by 1 or 2 where they round
/// and interpolate otherwise; a body, a shadow, a word in the wrong place is off by dozens.
const CHANNEL: u8 = 8;

/// Of this many pixels one may be off by more: on the edges of bodies and shadows another rounding is another
/// surface. Vulkan and OpenGL in software differ in one or two pixels of these pictures; a test below shows that
/// a single small body cannot hide in what is allowed.
const ONE_OF: usize = 5000;

/// How two pictures differ.
pub struct Difference {
    /// Pixels that are off by more than [`CHANNEL`].
    pub pixels: usize,
    /// What may be.
    pub allowed: usize,
    /// Their worst channel.
    pub worst: u8,
    /// White where they differ, the first picture darkened elsewhere.
    pub picture: Image,
}

impl Difference {
    /// Between pictures of one size.
    pub fn between(a: &Image, b: &Image) -> Self {
        assert_eq!(a.size_px, b.size_px, "pictures of two sizes");
        let mut difference =
            Self { pixels: 0, allowed: a.rgba.len() / 4 / ONE_OF, worst: 0, picture: a.clone() };
        let pixels = difference.picture.rgba.chunks_exact_mut(4).zip(b.rgba.chunks_exact(4));
        for (shown, other) in pixels {
            let off = shown.iter().zip(other).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            difference.worst = difference.worst.max(off);
            if off > CHANNEL {
                difference.pixels += 1;
                shown.copy_from_slice(&[255; 4]);
            } else {
                shown[..3].iter_mut().for_each(|channel| *channel /= 4);
            }
        }
        difference
    }

    /// Whether it is small enough.
    pub fn accepted(&self) -> bool {
        self.pixels <= self.allowed
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { pixels, allowed, worst, .. } = self;
        write!(
            out,
            "{pixels} pixels are off by more than {CHANNEL}, {allowed} may be (worst channel {worst})"
        )
    }
}

/// What keeps `actual` from being the picture `name` of `references`; the reasons are left in `evidence`.
fn compared(
    actual: &Image,
    name: &str,
    references: &Path,
    evidence: &Path,
    bless: bool,
) -> Result<(), String> {
    let reference = references.join(format!("{name}.png"));
    std::fs::create_dir_all(evidence).unwrap();
    let write = |what: &str, image: &Image| {
        let path = evidence.join(format!("{name}.{what}.png"));
        image.write_png(&path, &[]).unwrap();
        path.display().to_string()
    };
    if bless {
        actual.write_png(&reference, &[]).unwrap();
        return Err(format!("{} is blessed: look at it, and run again without BLESS", reference.display()));
    }
    let Ok(expected) = Image::read_png(&reference) else {
        let seen = write("actual", actual);
        return Err(format!("{} is missing; the picture is {seen}; BLESS=1 stores it", reference.display()));
    };
    if expected.size_px != actual.size_px {
        let seen = write("actual", actual);
        return Err(format!("{} has another size than {seen}", reference.display()));
    }
    let difference = Difference::between(actual, &expected);
    if difference.accepted() {
        return Ok(());
    }
    let [seen, wanted, off] =
        [("actual", actual), ("expected", &expected), ("difference", &difference.picture)]
            .map(|(what, image)| write(what, image));
    Err(format!("{name}: {difference}: compare {seen}, {wanted} and {off}; BLESS=1 stores the new picture"))
}

/// Fails unless each picture is the stored one of its name.
#[track_caller]
pub fn assert_pictures<const N: usize>(names: [&str; N], pictures: &[Image]) {
    assert_eq!(pictures.len(), N);
    let bless = std::env::var("BLESS").is_ok_and(|value| value == "1");
    let (references, evidence) = (root().join("tests/pictures"), root().join("target/pictures"));
    let compare = |(name, picture)| compared(picture, name, &references, &evidence, bless).err();
    let faults: Vec<_> = names.into_iter().zip(pictures).filter_map(compare).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Draws sessions without a window.
pub struct Studio {
    gpu: Gpu,
    renderer: Renderer,
    target: Offscreen,
}

impl Studio {
    /// # Panics
    /// Without a graphics adapter; the message says what to install.
    pub fn new(size_px: [u32; 2]) -> Self {
        Self::of_quality(size_px, |_| Quality::FIXED)
    }

    /// The same with the quality that the window has.
    pub fn like_the_window(size_px: [u32; 2]) -> Self {
        Self::of_quality(size_px, Quality::for_adapter)
    }

    fn of_quality(size_px: [u32; 2], quality: fn(&AdapterSummary) -> Quality) -> Self {
        let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
        let renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, quality(&gpu.info));
        let target = Offscreen::new(&gpu, size_px).unwrap();
        Self { gpu, renderer, target }
    }

    /// The present picture of `session`.
    pub fn draw(&mut self, session: &mut Session) -> Image {
        let frame = session.picture();
        assert_eq!(frame.size_px, self.target.size_px());
        self.renderer.draw(&self.gpu, &frame, self.target.view());
        self.target.read(&self.gpu).unwrap()
    }

    /// The same without words and panels.
    pub fn draw_bodies(&mut self, session: &mut Session) -> Image {
        let mut frame = session.picture();
        if let Some(panels) = &mut frame.panels {
            panels.primitives.clear();
        }
        self.renderer.draw(&self.gpu, &frame, self.target.view());
        self.target.read(&self.gpu).unwrap()
    }
}

/// A session and its frames, 60 a second.
pub struct Film {
    pub session: Session,
    clock: FrameClock,
}

impl Film {
    pub fn of(scene: Scene) -> Self {
        let mut film = Self {
            session: Session::new(scene, Options { size_px: SIZE, ..Options::default() }),
            clock: FrameClock::default(),
        };
        film.frame([]);
        film
    }

    /// A shipped scene.
    pub fn shipped(name: &str) -> Self {
        Self::of(scene::load(name).unwrap())
    }

    pub fn frame(&mut self, events: impl IntoIterator<Item = Input>) {
        let time = self.clock.advance_to(self.session.frames() as f64 / 60.0).unwrap();
        self.session.advance(&events.into_iter().collect::<InputFrame>(), time);
        let _ = self.session.take_orders();
    }

    pub fn frames(&mut self, count: u32) {
        (0..count).for_each(|_| self.frame([]));
    }

    pub fn press(&mut self, key: &str) {
        let key: Key = key.parse().unwrap();
        self.frame([Input::KeyDown(key.clone())]);
        self.frame([Input::KeyUp(key)]);
    }

    pub fn click(&mut self, button: Button) {
        self.frame([Input::ButtonDown(button)]);
        self.frame([Input::ButtonUp(button)]);
    }

    fn position(&self, body: &str) -> DVec3 {
        self.session.world().get::<Transform>(self.session.body(body).unwrap()).unwrap().position
    }

    /// Where the middle of `body` is seen.
    pub fn pixel(&self, body: &str) -> DVec2 {
        let size = DVec2::from_array(SIZE.map(f64::from));
        self.session.camera().viewpoint().project(self.position(body), size).unwrap()
    }

    /// Changes to selection mode and selects `body` by a click on its middle.
    fn select(&mut self, body: &str) {
        self.press("Q");
        let at = self.pixel(body);
        self.frame([Input::Mouse(at.x, at.y)]);
        self.click(Button::Left);
        assert_eq!(self.session.selection(), self.session.body(body));
    }
}

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

/// Places of the pixels that `wanted` accepts.
pub fn places(image: &Image, wanted: impl Fn([u8; 4]) -> bool) -> Vec<DVec2> {
    let [width, height] = image.size_px;
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    all.filter(|(x, y)| wanted(image.pixel(*x, *y).unwrap()))
        .map(|(x, y)| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
        .collect()
}

/// The green of a selected body, lit or in shade.
pub fn green([r, g, b, _]: [u8; 4]) -> bool {
    g > r.saturating_add(30) && g > b.saturating_add(30)
}

/// The yellow of its outline.
pub fn yellow([r, g, b, _]: [u8; 4]) -> bool {
    r > 200 && g > 200 && b < 100
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
    let mut session = Session::new(scene, Options { size_px: SIZE, ..Options::default() });
    let (mut clock, mut studio, mut pictures) = (FrameClock::default(), Studio::new(SIZE), Vec::new());
    while !player.finished() {
        let time = clock.advance_to(session.frames() as f64 / 60.0).unwrap();
        let mut input = player.input(&session, time.total());
        for event in &mut input.events {
            // The tour points at pixels of a picture of twice the size; counts that turn the camera stay.
            if let (Input::Mouse(x, y), Mode::Selection) = (event, session.mode()) {
                (*x, *y) = (*x / 2.0, *y / 2.0);
            }
        }
        session.advance(&input, time);
        for order in session.take_orders() {
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
    assert_pictures(["tutorial_start"], &[Studio::new(SIZE).draw(&mut film.session)]);
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
    assert_pictures(["selected"], &[Studio::new(SIZE).draw(&mut film.session)]);
}

#[test]
fn the_settings_beside_a_selected_body_are_their_reference() {
    let mut film = Film::of(stage(0.0, true, false));
    film.select("ball");
    film.press("Tab");
    assert_pictures(["settings"], &[Studio::new(SIZE).draw(&mut film.session)]);
}

#[test]
fn a_selected_body_is_green_and_outlined_where_it_is_projected_to() {
    let mut studio = Studio::new(SIZE);
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
    let mut studio = Studio::new(SIZE);
    let mut film = Film::of(stage(0.0, true, false));
    film.select("ball");
    let (aim, before) = (film.pixel("ball"), studio.draw_bodies(&mut film.session));
    film.click(Button::Right);
    film.frames(120);
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
    let mut studio = Studio::new(SIZE);
    let mut film = Film::of(stage(0.0, true, false));
    film.select("box");
    let (from, before) = (film.pixel("box"), studio.draw_bodies(&mut film.session));
    film.frame([Input::KeyDown("Right".parse().unwrap())]);
    film.frames(30);
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
    let mut studio = Studio::new(SIZE);
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
    film.press("G");
    film.frames(30);
    let fallen = grid(&mut studio, &mut film);
    assert!(fallen.y > start.y + 8.0, "from row {} to row {}", start.y, fallen.y);
}

#[test]
fn velocity_arrows_add_pixels_of_their_color_where_something_moves() {
    let mut studio = Studio::new(SIZE);
    let arrow = |[r, g, b, _]: [u8; 4]| r.abs_diff(77) < 4 && g.abs_diff(191) < 4 && b > 251;
    let mut film = Film::of(stage(0.0, true, false));
    let mut count = |film: &mut Film| places(&studio.draw_bodies(&mut film.session), arrow).len();
    film.press("1");
    assert_eq!(count(&mut film), 0, "nothing moves yet");
    let fast = Experiment::OfBody("ball".to_owned(), motion::Request::SetVelocity, [0.0, 8.0, 0.0]);
    film.frame([Input::Experiment(fast)]);
    film.frames(5);
    assert!(count(&mut film) > 10, "{} pixels of an arrow", count(&mut film));
    film.press("1");
    assert_eq!(count(&mut film), 0, "the arrows are off again");
}

#[test]
fn pictures_of_one_state_are_equal_to_the_bit() {
    let pictures: Vec<_> = (0..2)
        .map(|_| {
            let mut studio = Studio::new(SIZE);
            let mut film = Film::of(stage(0.0, true, true));
            film.select("box");
            film.press("G");
            film.frames(20);
            [studio.draw(&mut film.session), studio.draw(&mut film.session)]
        })
        .collect();
    assert!(pictures[0][0] == pictures[0][1], "a second drawing of the same session differs");
    assert!(pictures[0] == pictures[1], "a second session differs");
}

#[test]
fn a_session_100_km_from_the_origin_draws_the_same_picture() {
    let mut studio = Studio::new(SIZE);
    // Without shadows: the shadow map looks at the world's origin, as the tutorial's does.
    let mut pictures = [0.0, 1e5].map(|offset| {
        let mut film = Film::of(stage(offset, false, true));
        film.select("box");
        film.press("G");
        film.frames(20);
        studio.draw_bodies(&mut film.session)
    });
    let difference = Difference::between(&pictures[0], &pictures[1]);
    assert!(difference.accepted(), "{difference}");
    pictures[1] = studio.draw_bodies(&mut Film::of(stage(1e5, false, true)).session);
    assert!(!Difference::between(&pictures[0], &pictures[1]).accepted(), "both show nothing");
}

#[test]
fn a_picture_without_one_small_body_is_rejected() {
    let mut studio = Studio::new(SIZE);
    let mut pictures = [false, true].map(|removes| {
        let mut film = Film::shipped("tutorial");
        let remove = Input::Experiment(Experiment::Remove("grid.x4.z4".to_owned()));
        film.frame(removes.then_some(remove));
        film.frame([]);
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
    assert!(compared(&other, "plain", references, &evidence, false).unwrap_err().contains("another size"));
}

#[test]
fn pictures_without_an_adapter_are_exit_code_4_that_says_what_to_install() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(program())
        .args(["run", "tutorial", "--ticks", "1", "--frames"])
        .arg(folder.path())
        // Hides every driver.
        .env("WGPU_BACKEND", "vulkan")
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(message.contains("mesa-vulkan-drivers"), "{message}");
}
