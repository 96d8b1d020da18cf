//! Swarms against closed forms.

use glam::{DVec3, Vec3};
use swarm::Swarm;

use super::{Device, scene_text};
use crate::rigs::{Drive, H};

const METHODS: [&str; 3] = ["position_verlet", "semi_implicit_euler", "velocity_verlet"];

/// Where a particle is, by its velocity at birth, m/s, the time of its birth and its age, s.
type Path<'a> = &'a dyn Fn(DVec3, f64, f64) -> DVec3;

/// The largest error of a swarm, m, after `seconds` at `hz` ticks per second.
fn error(device: &mut Device, text: &str, hz: u32, seconds: f64, path: Path<'_>) -> f64 {
    let text = text.replace("step_hz: 60", &format!("step_hz: {hz}"));
    let mut drive = Drive::text(&text);
    let length = 1.0 / f64::from(hz);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of ticks"
    )]
    drive.run((seconds / length).round() as u32, length);
    let (now, rate) =
        (drive.session.stage.sim().seconds(), drive.session.stage.sim().scene.emitters[0].rate);
    let living = device.living(&mut drive.session);
    let world = drive.session.stage.world_mut();
    let swarm = world.query::<&Swarm>().single(world).unwrap().clone();
    assert!(!living.is_empty());
    let off = |(number, place): (u64, DVec3)| {
        #[expect(clippy::cast_possible_truncation, reason = "below the number of slots")]
        let launch = Vec3::from(swarm.launches[(number % swarm.slots()) as usize]).as_dvec3();
        #[expect(clippy::cast_precision_loss, reason = "few births")]
        let born = number as f64 / rate;
        place.distance(path(launch, born, now - born))
    };
    living.into_iter().map(off).fold(0.0, f64::max)
}

/// An emitter whose births are at no multiple of a tick, with the layout of `method`.
fn emitter(method: &str, keys: &str) -> String {
    let layout = if method == "position_verlet" { "positions" } else { "velocity" };
    format!("on: gpu, layout: {layout}, method: {method}, rate_per_s: 170, life_s: 2, {keys}")
}

const SPRAY: &str = "position_m: (1, 2, 3), direction: (0, 1, 0), spread_deg: 30, speed_m_s: 9";
const SOURCE: DVec3 = DVec3::new(1.0, 2.0, 3.0);
const G: DVec3 = DVec3::new(0.0, -9.8, 0.0);

#[test]
fn a_parabola_from_the_moment_of_birth() {
    let mut device = Device::new();
    let parabola = |launch: DVec3, _: f64, age: f64| SOURCE + launch * age + G * (age * age / 2.0);
    for method in METHODS {
        let text = scene_text("gravity: (),", &emitter(method, SPRAY));
        let error = error(&mut device, &text, 60, 2.5, &parabola);
        // Both Verlets are exact but for rounding; semi-implicit Euler is g h / 2 too fast.
        let bound = match method {
            "semi_implicit_euler" => 9.8 / 60.0 / 2.0 * 2.0 * 1.01,
            "velocity_verlet" => 1e-4,
            _ => 1e-3,
        };
        assert!(error < bound, "{method}: {error:e} m");
        if method == "semi_implicit_euler" {
            assert!(error > 0.9 * bound, "{error:e} m of {bound:e} m");
        }
    }
}

/// Checks the order by three steps. Single precision hides errors below 1e-4 m.
fn order(
    device: &mut Device,
    method: &str,
    expected: f64,
    (keys, place): (&str, &str),
    path: Path<'_>,
) {
    let text = scene_text(keys, &emitter(method, place));
    let errors = [10, 20, 40].map(|hz| error(device, &text, hz, 2.5, path));
    assert!(errors[2] > 1e-4, "{method}: {errors:?} m are too small to tell an order from");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - expected).abs() < 0.35, "{method}: order {order}, of {errors:?} m");
    }
}

#[test]
fn drag_has_the_order_of_the_method() {
    let mut device = Device::new();
    let rate = 1.5_f64;
    // x' = v, v' = g - c v.
    let path = |launch: DVec3, _: f64, age: f64| {
        let terminal = G / rate;
        SOURCE + terminal * age + (launch - terminal) * ((1.0 - (-rate * age).exp()) / rate)
    };
    for (method, expected) in
        [("position_verlet", 1.0), ("semi_implicit_euler", 1.0), ("velocity_verlet", 2.0)]
    {
        let keys = format!("gravity: (), drag: (linear_per_s: {rate}),");
        order(&mut device, method, expected, (&keys, SPRAY), &path);
    }
}

#[test]
fn gusts_drive_what_they_drag() {
    let mut device = Device::new();
    let (c, gust, hz) = (2.0_f64, 6.0, 0.4);
    let w = std::f64::consts::TAU * hz;
    // In still air, v' = c (air(t) - v) with the air at g sin(wt) along x and g sin(2wt)/2 upward.
    let forced = |speed: f64, strength: f64, w: f64, born: f64, age: f64| {
        let k = c * strength / (c * c + w * w);
        let at = |t: f64| k * (c * (w * t).sin() - w * (w * t).cos());
        let integral = |t: f64| k * (-c / w * (w * t).cos() - (w * t).sin());
        let free = speed - at(born);
        integral(born + age) - integral(born) + free * (1.0 - (-c * age).exp()) / c
    };
    let path = |launch: DVec3, born: f64, age: f64| {
        let z = launch.z * (1.0 - (-c * age).exp()) / c;
        let x = forced(launch.x, gust, w, born, age);
        SOURCE + DVec3::new(x, forced(launch.y, gust / 2.0, 2.0 * w, born, age), z)
    };
    let keys = format!(
        "drag: (linear_per_s: {c}), wind: (velocity_m_s: (0, 0, 0), gust_m_s: {gust}, gust_hz: {hz}),"
    );
    for (method, expected) in
        [("position_verlet", 1.0), ("semi_implicit_euler", 1.0), ("velocity_verlet", 2.0)]
    {
        order(&mut device, method, expected, (&keys, SPRAY), &path);
    }
}

#[test]
fn a_well_holds_a_circle() {
    let mut device = Device::new();
    // One radian per second at 4 m.
    let keys = "wells: [(position_m: (0, 0, 0), strength_m3_s2: 64)],";
    let place = "position_m: (4, 0, 0), direction: (0, 1, 0), speed_m_s: 4";
    let circle = |_: DVec3, _: f64, age: f64| DVec3::new(4.0 * age.cos(), 4.0 * age.sin(), 0.0);
    for method in ["position_verlet", "velocity_verlet"] {
        order(&mut device, method, 2.0, (keys, place), &circle);
    }
    // Whole orbits stay on the circle.
    let text =
        scene_text(keys, &emitter("position_verlet", place).replace("life_s: 2", "life_s: 14"));
    let off = error(&mut device, &text, 120, 13.0, &circle);
    // The angle of Verlet is (w h)²/24 ahead. Each of N = 1,560 steps loses half a digit of 4 m, in all N^1.5 of them, and what is
    // lost along an orbit counts three times.
    let rounding = 3.0 * 1560.0_f64.powf(1.5) * 0.5 * 4.8e-7;
    assert!(off < 4.0 * 13.0 * H * H / 24.0 + rounding, "{off:e} m");
}
