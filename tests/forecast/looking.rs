//! Looking at a run changes nothing, and what is seen between two ticks is what the next tick meets.

use history::Simulation;
use lab::trial::{Ahead, Trial};
use motion::margin::Margins;
use motion::{Request, totals};
use scene::Scene;

/// Two beads of 1 kg on a spring in thick air, and a third one on a spring to a wall.
const BEADS: &str = r#"(version: 1, step_hz: 60, drag: (linear_per_s: 1000), bodies: [
    (name: "a", position_m: (0, 0, 0), mass_kg: 1),
    (name: "b", position_m: (1, 0, 0), mass_kg: 1),
    (name: "c", position_m: (5, 0, 0), mass_kg: 1),
    (name: "wall", position_m: (6, 0, 0), immovable: true),
], springs: [
    (between: ("a", "b"), stiffness_n_m: 10, rest_length_m: 1),
    (between: ("c", "wall"), stiffness_n_m: 20, rest_length_m: 1),
])"#;

fn simulation(text: &str) -> Simulation {
    Simulation::new(Scene::parse("s", text).unwrap())
}

#[test]
fn margins_of_a_world_that_has_changed_are_those_of_its_next_tick() {
    let margins = |run: &Simulation| Margins::of(&run.world, run.method()).list().to_vec();
    let changes: [fn(&mut Simulation); 3] = [
        |run| run.request(Request::Remove(run.named("b").unwrap())),
        |run| run.request(Request::SetInverseMass(run.named("wall").unwrap(), 1.0)),
        |run| run.request(Request::SetInverseMass(run.named("a").unwrap(), 0.0)),
    ];
    for change in changes {
        let mut run = simulation(BEADS);
        change(&mut run);
        run.carry_out_requests();
        let before = margins(&run);
        run.stepper.recompile(&mut run.world);
        assert_eq!(before, margins(&run));
        assert!(before.iter().any(|margin| margin.is_unstable()), "{before:?}");
    }
}

#[test]
fn looking_leaves_every_bit_of_a_run() {
    let mut looked = simulation(BEADS);
    let mut alone = simulation(BEADS);
    for tick in 0..20 {
        if tick % 3 == 0 {
            let _ = (totals(&looked.world), Margins::of(&looked.world, looked.method()));
            Trial::new(&looked, Ahead { work: 1e4, ..Ahead::DEFAULT }).finish();
            let _ = motion::ledger::Ledger::open(&looked.world);
        }
        if tick == 7 {
            for run in [&mut looked, &mut alone] {
                run.request(Request::Remove(run.named("b").unwrap()));
                run.carry_out_requests();
            }
        }
        looked.tick();
        alone.tick();
        assert_eq!(looked.snapshot(), alone.snapshot(), "tick {tick}");
    }
}

#[test]
fn nothing_but_gravity_off_has_a_potential_energy_of_plus_0() {
    let run = simulation("(version: 1, bodies: [(position_m: (0, 1, 0), mass_kg: 1)])");
    assert_eq!(totals(&run.world).potential_energy.to_bits(), 0.0_f64.to_bits());
}

#[test]
fn a_trial_in_slices_finds_what_one_in_a_single_call_finds() {
    // With a cure; with a truth that is made finer; of several parts.
    let scenes = [
        r#"(version: 1, step_hz: 1, method: velocity_verlet, mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
            (name: "sun", position_m: (0, 0, 0), mass_kg: 10000), (name: "planet", position_m: (100, 0, 0), velocity_m_s: (0, 10, 0), mass_kg: 1),
            (name: "moon", position_m: (100.5, 0, 0), velocity_m_s: (0, 11.4142136, 0), mass_kg: 0.001)])"#,
        BEADS,
        r#"(version: 1, step_hz: 4, method: semi_implicit_euler, bodies: [(name: "a", position_m: (0, 0, 0), immovable: true),
            (name: "b", position_m: (2, 0, 0), mass_kg: 1), (name: "c", position_m: (2, 1, 0), mass_kg: 1)],
            springs: [(between: ("a", "b"), stiffness_n_m: 90, rest_length_m: 1), (between: ("b", "c"), stiffness_n_m: 90, rest_length_m: 2)])"#,
    ];
    for text in scenes {
        let run = simulation(text);
        let ahead = Ahead { work: 3e5, ..Ahead::DEFAULT };
        let mut at_once = Trial::new(&run, ahead);
        at_once.finish();
        let mut in_slices = Trial::new(&run, ahead);
        let mut calls = 0;
        while !in_slices.advance(1.0) {
            calls += 1;
        }
        assert!(calls > 10, "{calls}");
        assert_eq!(at_once.found(), in_slices.found());
    }
}
