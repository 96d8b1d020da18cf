//! What is done to a world between two ticks is no residual, and the ledger does nothing to it.

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::effects::Effect;
use motion::ledger::Ledger;
use motion::{Method, PhysicsBody, Request, Transform};

use super::Kept;

const SCENE: &str = "gravity: (), wells: [(strength_m3_s2: 4.0, softening_m: 1.0)],
    bodies: [
        (name: \"post\", position_m: (0.0, 5.0, 0.0), immovable: true),
        (name: \"a\", position_m: (1.0, 4.0, 0.0), velocity_m_s: (0.3, 0.0, 0.1), mass_kg: 2.0),
        (name: \"b\", position_m: (2.5, 4.0, 0.0), velocity_m_s: (0.0, 0.4, 0.0)),
        (name: \"c\", position_m: (-3.0, 2.0, 1.0), velocity_m_s: (0.0, 0.4, 0.0)),
    ],
    springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, rest_length_m: 1.0), (between: (\"a\", \"b\"), stiffness_n_m: 8.0, rest_length_m: 1.0)]";

const DEEDS: [(&str, Request<&str>); 11] = [
    ("gravity off", Request::SwitchGravity(false)),
    ("gravity turned", Request::SetGravity(DVec3::new(3.0, 0.0, 0.0))),
    ("an impulse", Request::Impulse("c", DVec3::new(1.0, 2.0, 0.0))),
    ("a velocity", Request::SetVelocity("b", DVec3::new(1.0, 2.0, 0.0))),
    ("a position", Request::SetPosition("b", DVec3::new(3.0, 6.0, 1.0))),
    ("a mass", Request::SetInverseMass("b", 0.25)),
    ("a body made immovable", Request::SetInverseMass("b", 0.0)),
    ("a body removed, with its springs", Request::Remove("b")),
    ("velocities turned round", Request::ReverseVelocities),
    ("springs off", Request::Switch(Effect::Springs, false)),
    ("wells off", Request::Switch(Effect::Wells, false)),
];

#[test]
fn interventions_are_booked_as_such() {
    let quarantine = ("a body in quarantine, with its springs", None);
    for (name, deed) in DEEDS.map(|(name, deed)| (name, Some(deed))).into_iter().chain([quarantine])
    {
        for method in [Method::RungeKutta4, Method::Yoshida4] {
            let mut kept = Kept::of(SCENE, method, 240.0, 4);
            let interventions = |kept: &Kept| kept.ledger.since_opening().energy.interventions;
            kept.run(60);
            assert_eq!(interventions(&kept), 0.0, "{name}");
            match deed {
                Some(request) => kept.ask(request.rename(|name| Some(kept.body(name))).unwrap()),
                None => kept.push("b", DVec3::NAN),
            }
            .tick();
            let size = kept.ledger.since_opening().energy.interventions.abs();
            let turned = kept.ledger.since_opening().momentum.interventions.length();
            assert!(size > 0.1 || turned > 0.1, "{name}: {size} J, {turned} N s");
            kept.run(60).check();
            assert_eq!(interventions(&kept).abs(), size, "{name}: once");
            let scale = kept.ledger.energies().kinetic + size + 10.0;
            let residual = kept.residual().abs();
            assert!(residual < 1e-8 * scale, "{name}, {method:?}: {residual:e}");
            assert!(
                kept.ledger.since_opening().momentum.residual.length() < 1e-7,
                "{name}, {method:?}"
            );
        }
    }
}

#[test]
fn a_set_velocity_is_worth_its_kinetic_energy_and_momentum() {
    let mut kept =
        Kept::of("bodies: [(name: \"a\", mass_kg: 2.0)]", Method::VelocityVerlet, 60.0, 1);
    let body = kept.body("a");
    kept.ask(Request::SetVelocity(body, DVec3::X * 3.0));
    let books = kept.tick().ledger.last_tick();
    assert_eq!((books.energy.interventions, books.energy.residual), (9.0, 0.0));
    assert_eq!(
        (books.momentum.interventions, books.momentum.residual),
        (DVec3::X * 6.0, DVec3::ZERO)
    );
    assert_eq!(kept.tick().ledger.last_tick().energy, motion::ledger::LedgerLines::default());
}

/// Keeping a ledger changes neither a bit of a state nor the schedule; without one nothing of it is in the world.
#[test]
fn books_change_nothing_and_cost_nothing_where_none_are_kept() {
    for shipped in scene::shipped() {
        let scene = shipped.load().unwrap();
        if scene.bodies.len() > 2_000 {
            continue;
        }
        let mut kept = Kept::of_scene(scene.clone());
        let mut plain = Simulation::new(scene);
        for _ in 0..90 {
            kept.tick();
            plain.tick();
        }
        kept.check();
        let booked = &kept.simulation;
        assert_eq!(booked.stepper.plan(), plain.stepper.plan(), "{}", shipped.name);
        assert_eq!(booked.stepper.systems(), plain.stepper.systems(), "{}", shipped.name);
        let bodies: Vec<_> =
            booked.bodies.iter().copied().zip(plain.bodies.iter().copied()).collect();
        let [booked, plain] = [&booked.world, &plain.world];
        for (a, b) in bodies {
            assert_eq!(booked.get::<Transform>(a), plain.get::<Transform>(b), "{}", shipped.name);
            assert_eq!(
                booked.get::<PhysicsBody>(a),
                plain.get::<PhysicsBody>(b),
                "{}",
                shipped.name
            );
        }
        let [counts, of_plain] =
            [booked, plain].map(|world| world.resource::<motion::Evaluations>());
        assert_eq!(counts.accelerations(), of_plain.accelerations(), "{}", shipped.name);
        assert_eq!(counts.laws(), of_plain.laws(), "{}", shipped.name);
        let names = |world: &World| {
            let components = world.components().iter_registered();
            components.map(|(_, component)| component.name().to_string()).collect::<String>()
        };
        assert!(
            !names(booked).contains("ledger") && !names(plain).contains("ledger"),
            "{}",
            shipped.name
        );
    }
}

#[test]
fn a_ledger_may_be_opened_at_any_time() {
    let mut kept = Kept::of(SCENE, Method::RungeKutta4, 240.0, 4);
    kept.run(30);
    kept.ledger = Ledger::open(&kept.simulation.world);
    assert_eq!((kept.ledger.seconds(), kept.ledger.mean_residual_rate()), (0.0, 0.0));
    assert_eq!(kept.ledger.last_second(), motion::ledger::LedgerTotals::default());
    kept.run(480).check();
    assert!((kept.ledger.seconds() - 2.0).abs() < 1e-12);
}
