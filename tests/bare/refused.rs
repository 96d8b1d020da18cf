//! What would turn non-finite is refused and reported.

use glam::DVec3;
use history::Simulation;
use motion::arrays::{Bare, NotForArrays};
use motion::{Method, StableId, TimeStep};

use super::{arrays, run, states};
use crate::rigs::{all_bits, scene_of};

const SCENE: &str = r#"(version: 1, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [
    (name: "free", mass_kg: 2), (name: "a", position_m: (3, 0, 0)), (name: "b", position_m: (4.5, 0, 0)),
    (name: "wall", position_m: (9, 0, 0), immovable: true)],
    springs: [(between: ("a", "b"), stiffness_n_m: 50, rest_length_m: 1)])"#;

fn twin(method: Method) -> Simulation {
    let scene = scene_of(SCENE);
    super::twin(scene, method, 1)
}

fn check(method: Method) {
    for (pushed, stay) in [(0, &[0][..]), (1, &[1, 2]), (2, &[1, 2])] {
        let mut bare = arrays(&mut twin(method));
        let mut other = arrays(&mut twin(method));
        run(&mut bare, 3);
        run(&mut other, 3);
        assert!(bare.refused().is_empty() && !bare.has_failed());
        let before = states(&bare);
        bare.push(pushed, [0.0, f64::INFINITY, 0.0]);
        run(&mut bare, 1);
        run(&mut other, 1);
        let (after, fine) = (states(&bare), states(&other));
        assert_eq!((bare.refused(), bare.has_failed()), (&[pushed][..], true), "{method:?}");
        for row in 0..4 {
            let expected = if stay.contains(&row) { &before[row] } else { &fine[row] };
            assert_eq!(all_bits([after[row]]), all_bits([*expected]), "{method:?}: row {row}");
        }
        run(&mut bare, 1);
        assert!(bare.refused().is_empty() && bare.has_failed(), "a push acts for one tick");
    }
}

#[test]
fn what_would_turn_non_finite_stays_and_is_reported() {
    for method in Method::ALL {
        check(method);
    }
}

#[test]
fn an_immovable_body_is_moved_by_nothing() {
    let mut bare = arrays(&mut twin(Method::RungeKutta4));
    bare.push(3, [f64::NAN, f64::INFINITY, 1.0]);
    run(&mut bare, 2);
    assert!(!bare.has_failed());
    assert_eq!(states(&bare)[3], (3, DVec3::X * 9.0, DVec3::ZERO));
    assert_eq!((bare.row_of(StableId(3)), bare.row_of(StableId(4))), (Some(3), None));
}

#[test]
fn a_world_without_a_time_step_is_refused() {
    let mut twin = twin(Method::RungeKutta4);
    twin.world.remove_resource::<TimeStep>();
    let refused = Bare::of_world(&mut twin.world, Method::RungeKutta4, &|_| Vec::new(), Vec::new());
    assert_eq!(refused.err(), Some(NotForArrays::NoTimeStep));
    assert!(NotForArrays::NoTimeStep.to_string().contains("TimeStep"));
}
