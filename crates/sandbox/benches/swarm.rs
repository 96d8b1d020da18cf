//! What particles cost by what is stored of them: `cargo bench -p inertia-sandbox --bench swarm [-- PARTICLES...]`. `scripts/studies swarm`
//! writes the tables into docs/methods.md.

#![allow(clippy::unwrap_used, reason = "a benchmark that fails should panic")]

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use cockpit::view::on_device::swarms;
use glam::{DVec3, Vec3};
use history::Simulation;
use motion::{Dormant, Method, Threads, Transform};
use render::{Gpu, wgpu};
use sandbox::clock::FrameClock;
use sandbox::input::InputFrame;
use sandbox::{Options, Session};
use scene::Scene;
use swarm::{DrawnSwarm, Swarm, SwarmLaws, SwarmLook, SwarmTick, Swarms};

const METHODS: [(&str, Method); 3] = [
    ("two positions, position Verlet", Method::PositionVerlet),
    ("position and velocity, semi-implicit Euler", Method::SemiImplicitEuler),
    ("position and velocity, velocity Verlet", Method::VelocityVerlet),
];

/// The number of particles of each row, if the command line names none.
const SIZES: [u32; 4] = [10_000, 100_000, 1_000_000, 4_000_000];

/// Time for which a device is measured at least.
const WARM_UP: Duration = Duration::from_millis(700);

/// How often a time is measured; the least counts.
const REPEATS: usize = 5;

fn main() {
    // Cargo adds `--bench`.
    let named: Vec<u32> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let sizes = if named.is_empty() { SIZES.to_vec() } else { named };
    let gpu = Gpu::headless().unwrap();
    println!("Times on {}.\n", gpu.info);
    println!("{}", times(&gpu, &sizes));
    println!("{}", errors(&gpu));
}

/// The laws in the table of times.
fn laws(all: bool) -> SwarmLaws {
    let constant = [0.0, -9.8, 0.0];
    if !all {
        return SwarmLaws { constant, ..SwarmLaws::default() };
    }
    SwarmLaws {
        constant,
        drag: Some([0.3, 0.05, 4.4]),
        wind: [[4.0, 0.0, -3.0], [1.2, 0.0, 1.6], [0.0, 2.0, 0.0], [0.7, 0.0, -0.5]],
        wells: Arc::new([[5.0, 8.0, 0.0, 60.0, 1.0], [-5.0, 6.0, 3.0, 40.0, 1.0]]),
        ..SwarmLaws::default()
    }
}

/// A scene of the same particles and laws as bodies, all of which are born in the first tick.
fn pool(particles: u32, all: bool) -> Scene {
    let more = "drag: (linear_per_s: 0.3, quadratic_per_m: 0.05), wind: (velocity_m_s: (4, 0, -3), gust_m_s: 2, gust_hz: 0.7), \
                wells: [(position_m: (5, 8, 0), strength_m3_s2: 60, softening_m: 1), \
                        (position_m: (-5, 6, 3), strength_m3_s2: 40, softening_m: 1)],";
    let rate = f64::from(particles) * 240.0;
    let text = format!(
        "(version: 1, step_hz: 120, method: position_verlet, gravity: (), {} emitters: [(rate_per_s: {rate}, life_s: 100, \
         capacity: {particles}, direction: (0, 1, 0), spread_deg: 20, speed_m_s: 9)])",
        if all { more } else { "" }
    );
    Scene::parse("pool", &text).unwrap()
}

/// Nanoseconds per particle per step.
fn times(gpu: &Gpu, sizes: &[u32]) -> String {
    let mut table = "| ns per particle per step | bytes per particle per step |".to_owned();
    for size in sizes {
        let _ = write!(table, " {size} |");
    }
    table += "\n| --- | --- |";
    table += &" --- |".repeat(sizes.len());
    table += "\n";
    for all in [false, true] {
        let under = if all { "gravity, drag in gusts, two wells" } else { "gravity" };
        for (name, method) in METHODS {
            let bytes = swarm(0, method).bytes_per_step();
            let _ = write!(table, "| {name}, {under} | {bytes} |");
            for size in sizes {
                let _ = write!(table, " {} |", digits(on_device(gpu, *size, method, all)));
            }
            table += "\n";
        }
        for threads in [1, 2] {
            let s = if threads == 1 { "" } else { "s" };
            let _ =
                write!(table, "| bodies on {threads} thread{s}, position Verlet, {under} | 128 |");
            for size in sizes {
                let _ = write!(table, " {} |", digits(on_processor(*size, threads, all)));
            }
            table += "\n";
        }
    }
    table
}

/// Three digits of a number.
fn digits(number: f64) -> String {
    match number {
        number if number >= 100.0 => format!("{number:.0}"),
        number if number >= 10.0 => format!("{number:.1}"),
        number if number >= 1.0 => format!("{number:.2}"),
        number => format!("{number:.3}"),
    }
}

/// A swarm of that many particles.
fn swarm(particles: u32, method: Method) -> Swarm {
    let speeds = (0..particles).map(|i| [0.01 * (i % 97) as f32, 9.0, -0.01 * (i % 89) as f32]);
    Swarm { method, substeps: None, anchor: DVec3::ZERO, launches: speeds.collect() }
}

fn on_device(gpu: &Gpu, particles: u32, method: Method, all: bool) -> f64 {
    let births = SwarmTick {
        key: 1,
        step: 1.0 / 120.0,
        substeps: 1,
        births: [0, u64::from(particles)],
        born: true,
        first_birth: 0.0,
        between: 1e-10,
        source: [0.0; 3],
        carried: [0.0; 3],
        dead: 0,
        other_laws: false,
        reversed: false,
        phase: 0.0,
        laws: laws(all).into(),
    };
    let look = SwarmLook {
        anchor: [0.0; 3],
        radius_m: 0.01,
        color: [1.0; 4],
        back: 0.0,
        exposure_s: 0.0,
        life_s: 1e9,
        fades_in: 0.3,
    };
    let swarm = swarm(particles, method);
    let mut swarm = DrawnSwarm { swarm, ticks: vec![births], goes_back: false, look };
    let mut swarms = Swarms::new(gpu);
    let steps = (200_000_000 / u64::from(particles).max(1)).clamp(20, 500);
    let mut least = f64::INFINITY;
    let (begun, mut measured) = (Instant::now(), 0);
    // A device that was idle takes its time to run at its full clock.
    while begun.elapsed() < WARM_UP || measured < REPEATS {
        measured += 1;
        swarms.follow(gpu, std::slice::from_ref(&swarm));
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let last = swarm.ticks.last().unwrap().clone();
        let more = (1..=steps).map(|i| SwarmTick {
            key: last.key + i,
            births: [u64::from(particles); 2],
            ..last.clone()
        });
        swarm.ticks = std::iter::once(last.clone()).chain(more).collect();
        let start = Instant::now();
        swarms.follow(gpu, std::slice::from_ref(&swarm));
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        least = least.min(start.elapsed().as_secs_f64());
    }
    least * 1e9 / (steps as f64 * f64::from(particles))
}

fn on_processor(particles: u32, threads: usize, all: bool) -> f64 {
    let mut simulation = Simulation::prepared(pool(particles, all), |world, _| {
        world.insert_resource(Threads::new(threads));
    });
    simulation.tick();
    // Else each would be replaced in every tick.
    simulation.request(motion::Request::Switch(motion::effects::Effect::Emitters, false));
    simulation.run(2);
    let steps = (20_000_000 / u64::from(particles)).clamp(5, 200);
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let start = Instant::now();
        simulation.run(steps);
        least = least.min(start.elapsed().as_secs_f64());
    }
    least * 1e9 / (steps as f64 * f64::from(particles))
}

/// Where drops are after 2 s, by what is stored of them.
fn errors(gpu: &Gpu) -> String {
    let mut table = "| error after 2 s, root mean square, m |".to_owned();
    let rates = [30, 60, 120, 240, 480, 960];
    for hz in rates {
        let _ = write!(table, " {hz} Hz |");
    }
    table += "\n| --- |";
    table += &" --- |".repeat(rates.len());
    table += "\n";
    let parabola = "gravity: (),";
    let air = "gravity: (), drag: (quadratic_per_m: 0.05), wind: (velocity_m_s: (4, 0, -3), gust_m_s: 2, gust_hz: 0.7),";
    for (under, keys) in [("gravity", parabola), ("gravity, drag in gusts", air)] {
        for (name, method) in
            [("position Verlet", "position_verlet"), ("velocity Verlet", "velocity_verlet")]
        {
            for on in ["gpu", "cpu"] {
                let stored = match (on, method) {
                    ("cpu", _) => "f64",
                    (_, "position_verlet") => "two positions, f32",
                    _ => "position and velocity, f32",
                };
                let _ = write!(table, "| {name}, {stored}, {under} |");
                for hz in rates {
                    let _ = write!(table, " {:.1e} |", error(gpu, keys, method, on, hz));
                }
                table += "\n";
            }
        }
    }
    table
}

/// The scene of the table of errors.
fn spray(keys: &str, emitter: &str, hz: u32) -> Scene {
    let text = format!(
        "(version: 1, step_hz: {hz}, seed: 3, {keys} emitters: [(name: \"e\", rate_per_s: 10000, life_s: 2.5, capacity: 500, \
         direction: (0, 1, 0), spread_deg: 20, speed_m_s: 9, {emitter})], off_at_start: [])"
    );
    Scene::parse("spray", &text).unwrap()
}

/// The places of the first 500 particles after two seconds, by number; births end before the pool is full.
fn places_of_bodies(scene: Scene, hz: u32) -> Vec<Option<DVec3>> {
    let mut simulation = Simulation::new(scene);
    run(hz, &mut |switch| {
        if switch {
            let off = motion::Request::Switch(motion::effects::Effect::Emitters, false);
            simulation.request(off);
        }
        simulation.tick();
    });
    let bodies = simulation.bodies.clone();
    let place = |body: &Entity| {
        let body = simulation.world.entity(*body);
        (!body.contains::<Dormant>()).then(|| body.get::<Transform>().unwrap().position)
    };
    bodies.iter().map(place).collect()
}

/// Two seconds of ticks; the first thirtieth of a second emits.
fn run(hz: u32, tick: &mut dyn FnMut(bool)) {
    (0..2 * hz).for_each(|number| tick(number == hz / 30));
}

fn places_on_device(gpu: &Gpu, scene: Scene, hz: u32) -> Vec<Option<DVec3>> {
    let options = Options { pictures: false, interpolate: false, ..Options::default() };
    let mut session = Session::new(scene, options);
    let mut clock = FrameClock::default();
    run(hz, &mut |switch| {
        if switch {
            let off = scene::ChangeAction::SwitchEffect(motion::effects::Effect::Emitters, false);
            let input = [sandbox::input::Input::Change(off)].into_iter().collect::<InputFrame>();
            let now = clock.advance_by(0.0).unwrap();
            session.advance(&input, now);
        }
        let time = clock.advance_by(1.0 / f64::from(hz)).unwrap();
        session.advance(&InputFrame::NOTHING, time);
    });
    let mut device = Swarms::new(gpu);
    device.follow(gpu, &swarms(&session.stage));
    let slots = device.read(gpu, 0).unwrap();
    slots.into_iter().map(|slot| Some(Vec3::from(slot?.position).as_dvec3())).collect()
}

fn error(gpu: &Gpu, keys: &str, method: &str, on: &str, hz: u32) -> f64 {
    let exact = places_of_bodies(spray(keys, "method: runge_kutta_4, substeps: 16", hz), hz);
    let layout = if method == "position_verlet" { "positions" } else { "velocity" };
    let places = match on {
        "gpu" => {
            let emitter = format!("method: {method}, on: gpu, layout: {layout}");
            places_on_device(gpu, spray(keys, &emitter, hz), hz)
        }
        _ => places_of_bodies(spray(keys, &format!("method: {method}"), hz), hz),
    };
    let pairs: Vec<_> =
        exact.iter().zip(&places).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?))).collect();
    let sum: f64 = pairs.iter().map(|(a, b)| a.distance_squared(**b)).sum();
    (sum / pairs.len() as f64).sqrt()
}
