//! Sessions drawn without a window, and their pictures beside stored ones.

use std::path::Path;

use glam::{DVec2, DVec3};
use motion::Transform;
use render::{AdapterSummary, Gpu, Image, OFFSCREEN_FORMAT, Offscreen, Quality, Renderer};
use sandbox::clock::FrameClock;
use sandbox::input::{Button, Input, InputFrame};
use sandbox::{Options, Session};
use scene::Scene;

use crate::rigs::{at, blesses, click, root, tap};

/// Small: drawn in software, and stored; large enough that the panels leave the bodies in sight.
pub const FILM_SIZE: [u32; 2] = [640, 360];

/// A channel may be off by this much of 255. Versions of a software renderer differ by 1 or 2 where they round
/// and interpolate otherwise; a body, a shadow, a word in the wrong place is off by dozens.
pub const CHANNEL: u8 = 8;

/// Of this many pixels one may be off by more: on the edges of bodies and shadows another rounding is another
/// surface. Vulkan and OpenGL in software differ in one or two pixels of these pictures; a test of `pixels.rs` shows
/// that a single small body cannot hide in what is allowed.
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
pub fn compared(
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
        std::fs::write(&path, image.png(&[]).unwrap()).unwrap();
        path.display().to_string()
    };
    if bless {
        std::fs::write(&reference, actual.png(&[]).unwrap()).unwrap();
        return Err(format!(
            "{} is blessed: look at it, and run again without BLESS",
            reference.display()
        ));
    }
    let Ok(expected) = Image::read_png(&reference) else {
        let seen = write("actual", actual);
        return Err(format!(
            "{} is missing; the picture is {seen}; BLESS=1 stores it",
            reference.display()
        ));
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
    Err(format!(
        "{name}: {difference}: compare {seen}, {wanted} and {off}; BLESS=1 stores the new picture"
    ))
}

/// Fails unless each picture is the stored one of its name.
#[track_caller]
pub fn assert_pictures<const N: usize>(names: [&str; N], pictures: &[Image]) {
    assert_eq!(pictures.len(), N);
    let (references, evidence) = (root().join("tests/pictures"), root().join("target/pictures"));
    let compare =
        |(name, picture)| compared(picture, name, &references, &evidence, blesses()).err();
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

    /// With the best quality, as the pictures of the documents have it.
    pub fn of_high_quality(size_px: [u32; 2]) -> Self {
        Self::of_quality(size_px, |_| Quality::HIGH)
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
            session: Session::new(scene, Options { size_px: FILM_SIZE, ..Options::default() }),
            clock: FrameClock::default(),
        };
        film.frame([]);
        film
    }

    /// A shipped scene.
    pub fn shipped(name: &str) -> Self {
        Self::of(scene::load(name).unwrap())
    }

    pub fn frame(&mut self, events: impl IntoIterator<Item = Input>) -> &mut Self {
        let time =
            self.clock.advance_to(self.session.stage.playback().frames() as f64 / 60.0).unwrap();
        self.session.advance(&events.into_iter().collect::<InputFrame>(), time);
        let _ = self.session.stage.take_orders();
        self
    }

    pub fn frames(&mut self, count: u32) -> &mut Self {
        for _ in 0..count {
            self.frame([]);
        }
        self
    }

    pub fn press(&mut self, key: &str) -> &mut Self {
        let [down, up] = tap(key);
        self.frame([down]).frame([up])
    }

    pub fn click(&mut self, button: Button) -> &mut Self {
        let [down, up] = click(button);
        self.frame([down]).frame([up])
    }

    pub fn position(&self, body: &str) -> DVec3 {
        self.session
            .stage
            .sim()
            .world
            .get::<Transform>(self.session.stage.sim().named(body).unwrap())
            .unwrap()
            .position
    }

    /// Where the middle of `body` is seen.
    pub fn pixel(&self, body: &str) -> DVec2 {
        self.pixel_of(self.position(body))
    }

    pub fn pixel_of(&self, point: DVec3) -> DVec2 {
        let size = DVec2::from_array(FILM_SIZE.map(f64::from));
        self.session.view.camera().viewpoint().project(point, size).unwrap()
    }

    /// Changes to selection mode and selects `body` by a click on its middle.
    pub fn select(&mut self, body: &str) -> &mut Self {
        self.press("Q");
        let pixel = self.pixel(body);
        self.frame([at(pixel)]).click(Button::Left);
        assert_eq!(self.session.stage.selection(), self.session.stage.sim().named(body));
        self
    }
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
