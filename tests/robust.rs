//! Numbers and times that a careless simulation breaks on.

mod damping;
mod extremes;
mod fall;
mod far;
mod frames;
mod subnormal;

use glam::DVec3;
use history::Simulation;
use motion::{Method, Quarantine};

use crate::rigs::scene_of;

#[test]
fn where_a_force_has_no_direction_there_is_none_by_every_method() {
    let scene = |keys: &str, method: Method| {
        scene_of(&format!(
            "(version: 1, step_hz: 60, method: {}, {keys} bodies: [(name: \"a\", position_m: (5, 0, 0)), (name: \"b\", position_m: (5, 0, 0))])",
            method.name()
        ))
    };
    for (what, keys) in [
        ("a well", "wells: [(position_m: (5, 0, 0), strength_m3_s2: 10)],"),
        ("a pair", "mutual_gravity: (constant_m3_kg_s2: 1),"),
        ("a spring", "springs: [(between: (\"a\", \"b\"), stiffness_n_m: 10, rest_length_m: 1)],"),
    ] {
        for method in Method::ALL {
            if what == "a pair" && method == Method::ImplicitEuler {
                continue;
            }
            let mut run = Simulation::new(scene(keys, method));
            run.run(30);
            let rest = run.states().all(|(_, x, v)| x == DVec3::X * 5.0 && v == DVec3::ZERO);
            assert!(rest, "{what} by {method:?}: {:?}", run.states().collect::<Vec<_>>());
            assert!(
                run.world.resource::<Quarantine>().records().is_empty(),
                "{what} by {method:?}"
            );
        }
    }
}
