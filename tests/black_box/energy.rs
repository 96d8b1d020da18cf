//! The watch for energy that a method creates or destroys.

use glam::DVec3;
use history::{Fault, FaultEntry, Simulation, Watch};
use motion::effects::Effect;
use motion::ledger::Ledger;
use motion::{Method, Request};

use super::program::STIFF;
use crate::rigs::{Dice, mixed, scene_of};
use crate::snapshot::{outcome, restored};

fn run(text: &str) -> Simulation {
    Simulation::new(scene_of(text))
}

/// The first fault of `ticks` ticks, `act` acting before each, with a ledger that is kept anyway or without one.
fn first_fault(
    mut run: Simulation,
    books: bool,
    ticks: u64,
    act: impl Fn(&mut Simulation, u64),
) -> Option<(u64, Option<u32>, String)> {
    let mut ledger = books.then(|| Ledger::open(&run.world));
    let mut watch = Watch::new(&run);
    let fault = (0..ticks).find_map(|tick| {
        let method = run.method();
        act(&mut run, tick);
        // As a timeline does.
        if run.method() != method {
            watch.note_change(tick);
        }
        watch.tick(&mut run, ledger.as_mut())
    });
    fault.map(|Fault { tick, body, what, quarantined, .. }| {
        assert!(!quarantined, "{what}");
        (tick, body, what)
    })
}

/// A spring of `w h` 1.9, which semi-implicit Euler holds, beside a light ball that hardly has energy.
const SPRING: &str = "(version: 1, step_hz: 100, bodies: [
    (name: \"wall\", immovable: true), (name: \"light\", position_m: (0, 5, 0), mass_kg: 0.001, velocity_m_s: (1, 0, 0)),
    (name: \"ball\", position_m: (1.1, 0, 0))],
    springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 36100, rest_length_m: 1)])";

#[test]
fn an_explosion_is_found_without_a_ledger_and_is_the_same_fault_as_with_one() {
    let found = |books| first_fault(run(STIFF), books, 50, |_, _| {});
    let (tick, body, what) = found(false).unwrap();
    assert_eq!((tick, body), (1, Some(1)), "{what}");
    assert_eq!(found(true), Some((tick, body, what)));
}

#[test]
fn an_explosion_that_begins_later_is_found_where_it_begins() {
    let act = |run: &mut Simulation, tick| {
        if tick == 50 {
            run.set_method(Method::ExplicitEuler);
        }
    };
    assert_eq!(first_fault(run(SPRING), false, 300, |_, _| {}), None);
    let found = first_fault(run(SPRING), false, 300, act).unwrap();
    // Energy is 4.6 times as large after each tick, and at this w h semi-implicit Euler had ten times of it in motion.
    assert!((51..=55).contains(&found.0) && found.1 == Some(2), "{found:?}");
    assert_eq!(first_fault(run(SPRING), true, 300, act), Some(found));
}

/// A spring that explicit Euler lets grow 49 times a second; semi-implicit Euler holds it.
const SLOW: &str = "(version: 1, step_hz: 60, method: explicit_euler, bodies: [
    (name: \"wall\", immovable: true), (name: \"ball\", position_m: (0.1, 0, 0))],
    springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 241, rest_length_m: 0)])";

#[test]
fn energy_that_grows_slowly_is_found_soon_and_from_where_it_began_to_grow() {
    // 1,000 times the energy is there after 107 ticks.
    let found = |books| first_fault(run(SLOW), books, 150, |_, _| {});
    let (tick, body, what) = found(false).unwrap();
    assert!(tick <= 12 && body == Some(1), "tick {tick}, {what}");
    assert_eq!(found(true), Some((tick, body, what)));

    let act = |run: &mut Simulation, tick| match tick {
        0 => run.set_method(Method::SemiImplicitEuler),
        200 => run.set_method(Method::ExplicitEuler),
        _ => {}
    };
    let (tick, ..) = first_fault(run(SLOW), false, 400, act).unwrap();
    assert!((200..=212).contains(&tick), "{tick}");
}

#[test]
fn energy_that_grows_by_half_in_every_tick_is_no_jump_and_is_found_all_the_same() {
    // (w h)² is 0.56, which is what explicit Euler adds.
    let text = SLOW.replace("241", "2000");
    let (tick, ..) = first_fault(run(&text), false, 100, |_, _| {}).unwrap();
    assert!(tick <= 5, "{tick}");
}

#[test]
fn an_engine_that_starts_from_nothing_is_no_fault_under_any_method() {
    for method in Method::ALL {
        for curve in [
            "sine(amplitude_n: (0, 300, 0), angular_frequency_rad_s: 0.5)",
            "table([(1, (0, 0, 0)), (6, (1000, 0, 0))])",
        ] {
            let text = format!(
                "(version: 1, step_hz: 60, method: {}, bodies: [(name: \"rocket\")],
                thrusts: [(body: \"rocket\", curve: {curve})])",
                method.name()
            );
            for books in [false, true] {
                assert_eq!(
                    first_fault(run(&text), books, 600, |_, _| {}),
                    None,
                    "{method:?} {curve}"
                );
            }
        }
    }
}

#[test]
fn a_fall_beside_a_spring_that_grows_slowly_is_no_fault() {
    // Runge-Kutta 2 falls exactly, and lets the energy of the spring grow to three times of it in 2,000 ticks.
    let text =
        "(version: 1, step_hz: 60, method: runge_kutta_2_midpoint, gravity: (on_at_start: false), bodies: [
        (name: \"wall\", immovable: true), (name: \"ball\", position_m: (0.11, 0, 0)),
        (name: \"heavy\", mass_kg: 100, position_m: (5, 0, 0))],
        springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 169, rest_length_m: 0)])";
    let act = |run: &mut Simulation, tick| {
        if tick == 2000 {
            run.request(Request::Switch(Effect::Gravity, true));
        }
    };
    for books in [false, true] {
        assert_eq!(first_fault(run(text), books, 2200, act), None);
    }
}

#[test]
fn a_watch_that_goes_on_from_any_tick_finds_the_same_fault() {
    let mut whole = run(SLOW);
    let mut watch = Watch::new(&whole);
    let mut going_on = Vec::new();
    let fault = loop {
        let energy = watch.energy();
        let run = restored(&mut whole);
        going_on.push((run, energy));
        if let Some(fault) = watch.tick(&mut whole, None) {
            break fault;
        }
    };
    for (mut run, energy) in going_on {
        let mut watch = Watch::resume(&run, energy);
        let found = (0..150).find_map(|_| watch.tick(&mut run, None));
        assert_eq!(found, Some(fault.clone()), "{energy:?}");
    }
}

#[test]
fn pushes_requests_and_springs_that_are_let_go_are_no_faults() {
    let text = "(version: 1, gravity: (), step_hz: 100, bodies: [
        (name: \"wall\", immovable: true), (name: \"ball\", position_m: (0.1, 0, 0)), (name: \"free\", position_m: (0, 9, 0))],
        springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 1000, rest_length_m: 1)])";
    for books in [false, true] {
        let act = |run: &mut Simulation, tick| {
            let (ball, free) = (run.bodies[1], run.bodies[2]);
            if tick % 20 == 7 {
                // Each a hundred times the last.
                let newtons = 100_f64.powi(1 + (tick / 20) as i32);
                run.push(free, DVec3::X * newtons);
            }
            let velocity = |body, speed| Request::SetVelocity(body, DVec3::Y * speed);
            let requests = match tick {
                150 => vec![velocity(free, 1e9), velocity(ball, 1e3)],
                180 => vec![Request::Impulse(ball, DVec3::Z * 1e12)],
                _ => vec![],
            };
            requests.into_iter().for_each(|request| run.request(request));
        };
        assert_eq!(first_fault(run(text), books, 250, act), None);
    }
}

#[test]
fn a_watched_run_has_the_bits_and_the_evaluations_of_another() {
    for scene in [mixed(), scene_of(STIFF), scene::load("everything").unwrap()] {
        let (mut alone, mut watched) = (Simulation::new(scene.clone()), Simulation::new(scene));
        let mut watch = Watch::new(&watched);
        for _ in 0..400 {
            alone.tick();
            watch.tick(&mut watched, None);
        }
        assert_eq!(outcome(&mut alone), outcome(&mut watched));
    }
}

#[test]
fn no_hard_case_is_at_fault_by_its_own_method() {
    for case in scene::cases() {
        let mut run = Simulation::new(case.load().unwrap());
        let mut watch = Watch::new(&run);
        for _ in 0..600 {
            assert_eq!(watch.tick(&mut run, None), None, "{}", case.name);
        }
    }
}

/// Energy of all movable bodies, J.
fn energy(run: &mut Simulation) -> f64 {
    let totals = motion::totals(&run.world);
    totals.kinetic_energy + totals.potential_energy
}

/// The energy after the last good tick before the first fault of a run that has `ticks` at most, as a multiple of the first
/// energy.
fn growth_at_last_good_tick(text: &str, ticks: u64) -> f64 {
    let mut run = run(text);
    let mut watch = Watch::new(&run);
    let mut energies = vec![energy(&mut run)];
    let fault = loop {
        assert!(run.ticks() < ticks, "no fault at {:?} J in {text}", energies.last());
        if let Some(fault) = watch.tick(&mut run, None) {
            break fault;
        }
        energies.push(energy(&mut run));
    };
    1.0 + (energies[fault.tick as usize - 1] - energies[0]) / energies[0].abs()
}

#[test]
fn growth_beside_an_engine_is_found_from_where_it_began() {
    for (w_h, rest) in [(0.9, 0.0), (0.9, 1.0), (1.1, 0.0), (1.1, 1.0), (1.3, 0.0), (1.3, 1.0)] {
        let text = format!(
            "(version: 1, step_hz: 60, method: explicit_euler, bodies: [
            (name: \"wall\", immovable: true), (name: \"ball\", position_m: (1.1, 0, 0), velocity_m_s: (0, 0.5, 0)),
            (name: \"rocket\", position_m: (0, 9, 0))],
            thrusts: [(body: \"rocket\", curve: sine(amplitude_n: (0, 0.001, 0), angular_frequency_rad_s: 1))],
            springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: {}, rest_length_m: {rest})])",
            (60.0_f64 * w_h).powi(2)
        );
        let good = growth_at_last_good_tick(&text, 1000);
        assert!(good <= 2.0, "{good} times the energy: {text}");
    }
}

#[test]
fn the_last_good_tick_has_at_most_twice_the_starting_energy_where_only_the_method_feeds() {
    let spring = |hz: f64, stiffness: f64, rest: f64, speed: f64| {
        format!(
            "(version: 1, step_hz: {hz}, method: explicit_euler, bodies: [
            (name: \"post\", immovable: true),
            (name: \"ball\", mass_kg: 2.3, position_m: (1.1, 0.3, 0.2), velocity_m_s: (0.2, {speed}, -0.6))],
            springs: [(between: (\"post\", \"ball\"), stiffness_n_m: {stiffness}, rest_length_m: {rest})])"
        )
    };
    // A pinned net that is set moving, beside a ball on a spring.
    let net = |hz: f64, stiffness: f64, speed: f64| {
        format!(
            "(version: 1, step_hz: {hz}, method: explicit_euler, bodies: [
            (name: \"post\", immovable: true, position_m: (0, 3, 0)),
            (name: \"ball\", mass_kg: 2, velocity_m_s: (0, 0, {speed}))],
            springs: [(between: (\"post\", \"ball\"), stiffness_n_m: {stiffness}, rest_length_m: 2.8)],
            soft_bodies: [cloth(name: \"net\", rows: 4, columns: 5, corner_m: (0, 5, 0), along_m: (1, 0, 0), down_m: (0, -1, 0),
            mass_kg: 20, stiffness_n_m: {stiffness}, shear: true, pinned: [top_left, top_right], velocity_m_s: (0, 0, {speed}))])"
        )
    };
    let mut dice = Dice(28);
    let mut between = |low: f64, high: f64| low + (high - low) * 0.5 * (dice.number() + 1.0);
    // The second grows for a whole look before it jumps.
    let mut cases = vec![spring(31.0, 19.0, 1.1, 0.4), spring(63.33, 6778.0, 1.2186, -2.8749)];
    for _ in 0..200 {
        let (rate, w_h) = (10_f64.powf(between(0.7, 2.0)), 10_f64.powf(between(-1.2, 0.2)));
        let stiffness = 2.3 * (w_h * rate).powi(2);
        cases.push(spring(rate, stiffness, between(0.0, 2.5), between(-3.0, 3.0)));
    }
    for _ in 0..12 {
        let (rate, w_h) = (10_f64.powf(between(1.0, 2.0)), 10_f64.powf(between(-0.8, 0.0)));
        cases.push(net(rate, 1.0 * (w_h * rate).powi(2) / 8.0, between(0.5, 3.0)));
    }
    for case in cases {
        let good = growth_at_last_good_tick(&case, 100_000);
        assert!(good <= 2.0, "{good} times the energy: {case}");
    }
}

/// A bullet of 5 kJ whose tick ends 10 µm from a weak well.
fn bullet(method: &str) -> String {
    format!(
        "(version: 1, step_hz: 100, method: {method}, wells: [(strength_m3_s2: 1e-3)],
        bodies: [(name: \"bullet\", position_m: (-2, 0.00001, 0), velocity_m_s: (100, 0, 0), mass_kg: 1.0)])"
    )
}

#[test]
fn a_single_tick_that_invents_more_than_there_was_is_a_fault_in_that_tick() {
    for method in ["velocity_verlet", "semi_implicit_euler", "position_verlet"] {
        for books in [false, true] {
            let (tick, body, what) =
                first_fault(run(&bullet(method)), books, 60, |_, _| {}).expect(method);
            // Velocity Verlet feels the pull at the end of tick 2, the others in tick 3.
            assert!(
                [2, 3].contains(&tick) && body == Some(0) && what.contains("the method created"),
                "{method} {tick} {what}"
            );
        }
        let beside = bullet(method).replace("step_hz: 100", "step_hz: 99");
        assert_eq!(first_fault(run(&beside), false, 60, |_, _| {}), None, "{method}");
    }
    // One frame of 4 s, and then ticks that hold.
    let spring = "(version: 1, step_hz: 60, bodies: [(name: \"wall\", immovable: true), (name: \"ball\", position_m: (1.2, 0, 0))],
        springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 40, rest_length_m: 1)])";
    let hitch = |run: &mut Simulation, tick| match tick {
        30 => run.world.insert_resource(motion::TimeStep(4.0)),
        31 => run.world.insert_resource(motion::TimeStep(1.0 / 60.0)),
        _ => {}
    };
    // Damping takes what it invented.
    let damped = spring.replace("rest_length_m: 1", "rest_length_m: 1, damping_n_s_m: 1");
    for text in [spring, &damped] {
        assert_eq!(first_fault(run(text), false, 200, |_, _| {}), None, "{text}");
        let (tick, ..) = first_fault(run(text), false, 200, hitch).expect(text);
        assert_eq!(tick, 31, "{text}");
    }
}

#[test]
fn a_fault_in_the_last_ticks_of_a_run_is_found_when_it_ends() {
    for books in [false, true] {
        for ticks in 2..40 {
            let mut run = run(&bullet("velocity_verlet"));
            let mut ledger = books.then(|| Ledger::open(&run.world));
            let mut watch = Watch::new(&run);
            let found = (0..ticks).find_map(|_| watch.tick(&mut run, ledger.as_mut()));
            let fault = found.or_else(|| watch.finish(&run));
            let fault = fault.map(|fault| (fault.tick, fault.found <= ticks));
            assert_eq!(fault, Some((2, true)), "{ticks}");
        }
    }
    // A right motion that ends anywhere has no fault.
    for ticks in 0..60 {
        let mut run = run(&comet(0.6, "velocity_verlet", 1));
        let mut watch = Watch::new(&run);
        (0..ticks).for_each(|_| assert_eq!(watch.tick(&mut run, None), None));
        assert_eq!(watch.finish(&run), None, "{ticks}");
    }
}

#[test]
fn a_fall_from_rest_where_energy_begins_at_0_is_no_fault() {
    for method in Method::ALL {
        let fall = format!(
            "(version: 1, step_hz: 60, method: {}, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [(name: \"a\")])",
            method.name()
        );
        assert_eq!(first_fault(run(&fall), false, 120, |_, _| {}), None, "{method:?}");
    }
}

/// A comet of semi-major axis 5 m about a well of 100 m³/s², from its far end.
fn comet(eccentricity: f64, method: &str, substeps: u32) -> String {
    let far = 5.0 * (1.0 + eccentricity);
    let speed = (100.0 * (2.0 / far - 1.0 / 5.0)).sqrt();
    format!(
        "(version: 1, step_hz: 60, method: {method}, substeps: {substeps}, wells: [(strength_m3_s2: 100.0)],
        bodies: [(name: \"comet\", position_m: ({far:?}, 0, 0), velocity_m_s: (0, {speed:?}, 0), mass_kg: 1.0)])"
    )
}

#[test]
fn a_bound_orbit_that_becomes_free_is_a_fault_unless_something_works_on_it() {
    for eccentricity in [0.97, 0.99, 0.999] {
        for method in ["semi_implicit_euler", "velocity_verlet", "runge_kutta_4", "yoshida_4"] {
            // Half a year is 211 ticks.
            let found = first_fault(run(&comet(eccentricity, method, 1)), false, 1200, |_, _| {});
            let (tick, ..) = found.unwrap_or_else(|| panic!("{eccentricity} {method}"));
            assert!((200..=640).contains(&tick), "{eccentricity} {method} {tick}");
        }
    }
    for method in
        ["semi_implicit_euler", "position_verlet", "velocity_verlet", "runge_kutta_4", "yoshida_4"]
    {
        // Symplectic methods show an orbit free for a moment where it is nearest, and keep it.
        for (eccentricity, substeps) in [(0.6, 1), (0.9, 8), (0.99, 200)] {
            let text = comet(eccentricity, method, substeps);
            assert_eq!(
                first_fault(run(&text), false, 2600, |_, _| {}),
                None,
                "{eccentricity} {method}"
            );
        }
    }
    // A push may throw it out.
    let push = |run: &mut Simulation, tick| {
        if tick == 100 {
            let comet = run.bodies[0];
            run.push(comet, DVec3::X * 6000.0);
        }
    };
    assert_eq!(first_fault(run(&comet(0.6, "velocity_verlet", 1)), false, 1200, push), None);
    // Two bodies fall on each other, and fly apart.
    let pair = "(version: 1, step_hz: 60, method: velocity_verlet, mutual_gravity: (constant_m3_kg_s2: 1.0),
        bodies: [(name: \"a\", mass_kg: 1.0), (name: \"b\", mass_kg: 1.0, position_m: (2, 0, 0))])";
    let (_, _, what) = first_fault(run(pair), false, 1200, |_, _| {}).unwrap();
    assert!(what.contains("becomes free") || what.contains("created"), "{what}");
}

#[test]
fn a_spring_elsewhere_hides_no_orbit_that_becomes_free() {
    let beside = |text: &str| {
        text.replace("bodies: [", "bodies: [(name: \"one\", position_m: (0, 90, 0)), (name: \"other\", position_m: (0, 91.5, 0)),")
            .replace("wells: [", "springs: [(between: (\"one\", \"other\"), stiffness_n_m: 0.006, rest_length_m: 1)], wells: [")
    };
    let found =
        first_fault(run(&beside(&comet(0.97, "velocity_verlet", 1))), false, 1200, |_, _| {});
    let (tick, body, what) = found.expect("the comet is thrown out");
    assert!((200..=640).contains(&tick) && body == Some(2), "{tick} {body:?} {what}");
    let calm = beside(&comet(0.6, "velocity_verlet", 1));
    assert_eq!(first_fault(run(&calm), false, 1200, |_, _| {}), None);
}

/// A moon around a planet around a heavy sun.
fn moon(hz: f64, method: &str) -> String {
    format!(
        "(version: 1, step_hz: {hz:?}, method: {method}, mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
            (name: \"sun\", mass_kg: 10000),
            (name: \"planet\", mass_kg: 1, position_m: (100, 0, 0), velocity_m_s: (0, 10, 0)),
            (name: \"moon\", mass_kg: 0.001, position_m: (100.5, 0, 0), velocity_m_s: (0, 11.4142136, 0))])"
    )
}

#[test]
fn a_heavy_sun_hides_no_moon_that_leaves_its_planet() {
    for method in ["semi_implicit_euler", "velocity_verlet", "yoshida_4", "runge_kutta_4"] {
        let found = first_fault(run(&moon(1.0, method)), false, 200, |_, _| {});
        let (_, body, what) = found.expect(method);
        assert!(body == Some(2) && what.contains("becomes free"), "{method}: {body:?} {what}");
        assert_eq!(first_fault(run(&moon(60.0, method)), false, 4000, |_, _| {}), None, "{method}");
    }
}

#[test]
fn an_orbit_on_a_spring_does_not_become_free_in_silence() {
    let orbit = |hz: f64| {
        format!(
            "(version: 1, step_hz: {hz:?}, method: position_verlet, wells: [(strength_m3_s2: 1)], bodies: [
                (name: \"anchor\", immovable: true, position_m: (2, 1, 0)),
                (name: \"b\", position_m: (2, 0, 0), velocity_m_s: (0, 0.1, 0))],
              springs: [(between: (\"anchor\", \"b\"), stiffness_n_m: 0.018, rest_length_m: 1)])"
        )
    };
    let (_, _, what) = first_fault(run(&orbit(8.0)), false, 400, |_, _| {}).expect("thrown out");
    assert!(what.contains("free") || what.contains("created"), "{what}");
    assert_eq!(first_fault(run(&orbit(20_000.0)), false, 100_000, |_, _| {}), None);
}

#[test]
fn a_particle_that_is_born_again_escapes_from_nothing() {
    let text = "(version: 1, step_hz: 60, wells: [(strength_m3_s2: 100.0)], damping: (model: exact, rate_per_s: 1.0),
        emitters: [(name: \"e\", position_m: (1, 0, 0), rate_per_s: 2.0, speed_m_s: 20.0, life_s: 2.0)])";
    let fault = first_fault(run(text), false, 600, |_, _| {});
    assert!(fault.as_ref().is_none_or(|(_, _, what)| !what.contains("becomes free")), "{fault:?}");
}

#[test]
fn a_fault_of_energy_is_the_same_in_other_words_and_a_quarantine_is_not() {
    let fault = |quarantined: bool, what: &str| Fault {
        tick: 3,
        found: 5,
        body: None,
        quarantined,
        what: what.to_owned(),
    };
    let names = scene::Names::default();
    let created = fault(false, "the method created 1.000e0 J of energy from here on");
    let refused = fault(true, "velocity would turn non-finite in integrate");
    let earlier = FaultEntry {
        tick: 3,
        body: None,
        what: "energy out of nowhere from here on, 1.000e0 J where there were 2.000e0 J".to_owned(),
    };
    assert!(created.is(&earlier, &names) && !refused.is(&earlier, &names));
    assert!(!created.is(&refused.named(&names), &names));
    assert!(refused.is(&refused.named(&names), &names));
    assert!(!created.is(&FaultEntry { tick: 4, ..earlier }, &names));
}
