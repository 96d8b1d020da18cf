//! What is drawn is what is picked: ids in a picture against rays through the same pixels.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use history::Change;
use motion::SoftBody;
use pick::Shape;
use render::{Frame, Gpu, Image, Offscreen, Quality, Renderer};
use scene::{Appearance, Scene};

use crate::app::session::Session;
use crate::clock::FrameClock;
use crate::input::{InputFrame, SwitchedBy};
use crate::stage::options::{Options, Words};
use crate::view::picture::find_points;

const SIZE: [u32; 2] = [320, 200];

/// Balls are round to a pixel, and edges are not smoothed.
const QUALITY: Quality = Quality { sphere_meridians: 48, ..Quality::FIXED };

/// Draws without a window.
struct Camera {
    gpu: Gpu,
    renderer: Renderer,
    target: Offscreen,
}

impl Camera {
    fn new() -> Self {
        let gpu = Gpu::headless().expect("a device");
        let renderer = Renderer::new(&gpu, render::OFFSCREEN_FORMAT, QUALITY);
        let target = Offscreen::new(&gpu, SIZE).expect("a picture");
        Self { gpu, renderer, target }
    }

    fn picture(&mut self, frame: &Frame) -> Image {
        self.renderer.draw(&self.gpu, frame, self.target.view());
        self.target.read(&self.gpu).expect("a picture")
    }
}

/// A session in the program's own look after some time.
fn session(scene: Scene, seconds: f64) -> Session {
    let options = Options { words: Words::None, ..Options::default() };
    let mut session = Session::new(scene, options);
    session.view.size_px = SIZE;
    let mut clock = FrameClock::default();
    for _ in 0..(seconds * 30.0) as u32 {
        session.advance(&InputFrame::NOTHING, clock.advance_by(1.0 / 30.0).expect("a time"));
    }
    session
}

/// Everything that can be seen and picked.
fn things(session: &mut Session) -> Vec<Entity> {
    let world = &mut session.stage.sim_mut().world;
    let mut things: Vec<_> =
        world.query_filtered::<Entity, Or<(With<Shape>, With<SoftBody>)>>().iter(world).collect();
    let mut points = Vec::new();
    find_points(&session.stage, &mut points);
    things.extend(points.iter().filter(|point| point.fade.is_none()).map(|point| point.entity));
    things
}

/// A picture without words and shadows in which `look` gives each thing its color.
fn picture(
    session: &mut Session,
    camera: &mut Camera,
    things: &[Entity],
    look: impl Fn(usize) -> [f32; 3],
) -> Image {
    for (number, thing) in things.iter().enumerate() {
        let look = Appearance { color: look(number), checker: false };
        session.stage.sim_mut().world.entity_mut(*thing).insert(look);
    }
    // Any change makes the positions that were found out of date.
    let change = Change::Substeps(session.stage.sim().substeps());
    session.stage.change(change, SwitchedBy::Settings);
    let Session { stage, view, .. } = session;
    let mut frame = view.begin_picture(stage, None, true);
    frame.light = None;
    frame.sprites.clear();
    frame.translucent = render::Translucent::default();
    camera.picture(&frame)
}

/// The number of the thing at every pixel; `Err` where another color mixes in.
fn ids(
    session: &mut Session,
    camera: &mut Camera,
    things: &[Entity],
) -> Vec<Result<Option<usize>, ()>> {
    let Session { stage, view, .. } = &mut *session;
    let background = Frame {
        cuboids: Vec::new(),
        spheres: Vec::new(),
        surfaces: Vec::new(),
        particles: Vec::new(),
        sprites: Vec::new(),
        lines: Vec::new(),
        light: None,
        translucent: render::Translucent::default(),
        ..view.begin_picture(stage, None, true)
    };
    let background = camera.picture(&background);
    let bits = usize::BITS - things.len().leading_zeros();
    let passes: Vec<_> = (0..bits)
        .map(|bit| {
            let color = |number: usize| {
                if (number >> bit) & 1 == 1 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 0.9] }
            };
            picture(session, camera, things, color)
        })
        .collect();
    let pixel = |image: &Image, at: usize| -> [i32; 3] {
        std::array::from_fn(|k| i32::from(image.rgba[4 * at + k]))
    };
    let number = |at: usize| {
        let behind = pixel(&background, at);
        let seen: Vec<_> = passes.iter().map(|pass| pixel(pass, at)).collect();
        if seen.iter().all(|seen| (0..3).all(|k| (seen[k] - behind[k]).abs() <= 3)) {
            return Ok(None);
        }
        let mut number = 0;
        for (bit, [r, _, b]) in seen.into_iter().enumerate() {
            match (r, b) {
                _ if r > 2 * b + 20 => number |= 1 << bit,
                _ if b > 2 * r + 20 => {}
                _ => return Err(()),
            }
        }
        if number < things.len() { Ok(Some(number)) } else { Err(()) }
    };
    (0..(SIZE[0] * SIZE[1]) as usize).map(number).collect()
}

/// Compares the pick with the picture at every sixth pixel; returns the number of those with things.
fn compare(session: &mut Session, camera: &mut Camera, name: &str) -> usize {
    let things = things(session);
    let ids = ids(session, camera, &things);
    let [width, height] = SIZE.map(|side| side as usize);
    let (mut with_things, mut wrong) = (0, Vec::new());
    for at in (0..width * height).step_by(6) {
        let Ok(drawn) = ids[at] else { continue };
        let (x, y) = (at % width, at / width);
        let Session { stage, view, .. } = &mut *session;
        let mut pick = |aside: [f64; 2]| {
            let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + DVec2::from_array(aside);
            let ray = view.viewpoint().ray_through(pixel, view.view_area()[1]);
            let ground = view.distance_of_ground(stage, &ray).unwrap_or(f64::INFINITY);
            // The ground is drawn in place of the floor, and what is below it is translucent.
            let picked = view.cast(stage, &ray).filter(|hit| hit.distance < ground * (1.0 - 1e-5));
            picked.map(|hit| hit.entity)
        };
        let picked = pick([0.0; 2]);
        with_things += usize::from(drawn.is_some());
        // Edges lie between pixels.
        let near = |(dx, dy): (isize, isize)| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            ids.get(y * width + x).filter(|_| x < width).copied()
        };
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
        let agrees = |drawn: Result<Option<usize>, ()>| {
            drawn.map(|number| number.map(|number| things[number])) == Ok(picked)
        };
        // A blade may be thinner than a pixel, and a renderer rounds its corners to 1/256 of one. The smooth edges of two boxes
        // fill a gap that is thinner than a pixel.
        let is_at_edge = |pick: &mut dyn FnMut([f64; 2]) -> Option<Entity>| {
            let thing = drawn.map(|number| things[number]);
            let aside = [0.02, -0.02, 0.5, -0.5].map(|by| [[by, 0.0], [0.0, by]]);
            aside.concat().into_iter().any(|aside| pick(aside) == thing)
        };
        if !agrees(Ok(drawn))
            && !around.filter_map(near).any(|drawn| drawn.is_err() || agrees(drawn))
            && !is_at_edge(&mut pick)
        {
            let name = |thing: Option<Entity>| thing.map(|thing| session.stage.name(thing));
            wrong.push((x, y, name(drawn.map(|number| things[number])), name(picked)));
        }
    }
    assert!(wrong.is_empty(), "{name}: {} wrong, {:?}", wrong.len(), &wrong[..wrong.len().min(5)]);
    with_things
}

#[test]
fn what_is_drawn_is_what_is_picked_in_every_scene() {
    let mut camera = Camera::new();
    for shipped in scene::shipped() {
        let mut session = session(shipped.load().expect("a shipped scene"), 1.0);
        let with_things = compare(&mut session, &mut camera, shipped.name);
        println!("{}: {with_things}", shipped.name);
    }
}

fn scene(bodies: &str) -> Scene {
    let text = format!(
        "(version: 1, gravity: (acceleration_m_s2: (0, -9.8, 0), on_at_start: false), camera: (position_m: (0, 2, 10), near_m: 1, far_m: 50), bodies: [{bodies}])"
    );
    Scene::parse("test", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The name of what is picked at a place, m.
fn at(session: &mut Session, place: DVec3) -> Option<String> {
    let Session { stage, view, .. } = session;
    let (pixel, _) = view.seen_at(place).expect("in front of the camera");
    let ray = view.viewpoint().ray_through(pixel, view.view_area()[1]);
    view.cast(stage, &ray).map(|hit| stage.name(hit.entity))
}

#[test]
fn what_hides_or_is_not_drawn_decides_what_is_picked() {
    let ball = "(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 2, -5), mass_kg: 1)";
    let plate = "(name: \"plate\", shape: cuboid(half_extents_m: (2, 0.000001, 2)), position_m: (0, 2, 4), mass_kg: 1)";
    let cases = [
        (
            "a particle before a ball",
            "(name: \"mote\", position_m: (0, 2, 4), mass_kg: 1)",
            Some("mote"),
        ),
        (
            "a particle nearer than anything is drawn",
            "(name: \"mote\", position_m: (0, 2, 9.5), mass_kg: 1)",
            Some("ball"),
        ),
        (
            "a body nearer than anything is drawn",
            "(name: \"box\", shape: cuboid(half_extents_m: (0.2, 0.2, 0.2)), position_m: (0, 2, 9.4), mass_kg: 1)",
            Some("ball"),
        ),
        ("a plate from its edge", plate, Some("ball")),
    ];
    for (what, body, expected) in cases {
        let mut session = session(scene(&format!("{ball}, {body}")), 0.0);
        assert_eq!(at(&mut session, DVec3::new(0.0, 2.0, -5.0)).as_deref(), expected, "{what}");
    }
    let far = "(name: \"far\", shape: sphere(radius_m: 20), position_m: (0, 2, -90), mass_kg: 1)";
    assert_eq!(at(&mut session(scene(far), 0.0), DVec3::new(0.0, 2.0, -90.0)), None);
}

#[test]
fn the_ground_hides_what_fell_through_it_and_shows_a_ring() {
    let mut camera = Camera::new();
    let scene = Scene::parse(
        "fall",
        "(version: 1, gravity: (acceleration_m_s2: (0, -9.8, 0)), camera: (position_m: (0, 6, 14), pitch_deg: -20),
          bodies: [
            (name: \"floor\", shape: cuboid(half_extents_m: (50, 1, 50)), position_m: (0, -1, 0), immovable: true),
            (name: \"ball\", shape: sphere(radius_m: 0.8), position_m: (-2, 1, 0), mass_kg: 1),
            (name: \"box\", shape: cuboid(half_extents_m: (0.6, 0.6, 0.6)), position_m: (2, 5, 0), mass_kg: 1),
            (name: \"mote\", position_m: (0, 0.5, 0), mass_kg: 1)])",
    )
    .unwrap_or_else(|error| panic!("{error}"));
    let mut session = session(scene, 0.7);
    let place = |session: &Session, name: &str| {
        session
            .stage
            .drawn_position(session.stage.sim().named(name).expect("a body"))
            .expect("it is drawn")
    };
    // What the ground hides is seen faintly, and picked where nothing else is.
    for name in ["ball", "mote", "box"] {
        let place = place(&session, name);
        assert_eq!(place.y < -0.8, name != "box", "{name}: {place}");
        assert_eq!(at(&mut session, place).as_deref(), Some(name));
    }
    assert_eq!(at(&mut session, DVec3::new(8.0, 0.0, 0.0)).as_deref(), Some("floor"));
    assert!(compare(&mut session, &mut camera, "fall") > 5);
    let mut frame = session.picture();
    assert_eq!((frame.translucent.spheres.len(), frame.translucent.particles.len()), (1, 1));
    // One ring, the ball's, which began to fall at 1 m.
    assert_eq!(frame.lines.len(), 32);
    frame.lines.clear();
}
