//! Every shipped scene by every method.

use history::Simulation;
use motion::{Evaluations, Method};
use sandbox::report::state_hash;
use sandbox::{Options, Session};
use scene::unsolvable;

use super::{caches, outcome, restored};

/// Ticks of a run that is interrupted, and when: at the start, while methods have just begun, and later.
const TICKS: u64 = 20;
const INTERRUPTED_AT: [u64; 4] = [0, 1, 2, 13];

#[test]
fn every_scene_by_every_method_goes_on_bit_for_bit_and_evaluates_only_once_more_what_was_cached() {
    for shipped in scene::shipped() {
        let scene = shipped.load().unwrap();
        // Some seconds for a large one.
        let ticks = if scene.bodies.len() > 3_000 { 6 } else { TICKS };
        for method in Method::ALL {
            let mut scene = scene.clone();
            if unsolvable(method, scene.mutual_gravity.is_some()).is_some() {
                continue;
            }
            scene.method = method;
            let caching =
                scene.bodies.iter().filter(|body| caches(body.method.unwrap_or(method))).count()
                    as u64;
            let evaluated = |run: &Simulation| run.world.resource::<Evaluations>().accelerations();
            let mut whole = Simulation::new(scene);
            let mut interrupted = Vec::new();
            let mut evaluations = Vec::new();
            for tick in 0..ticks {
                if INTERRUPTED_AT.contains(&tick) {
                    interrupted.push(restored(&mut whole));
                }
                whole.tick();
                evaluations.push(evaluated(&whole));
            }
            let expected = outcome(&mut whole);
            for (mut run, tick) in interrupted.into_iter().zip(INTERRUPTED_AT) {
                let what = format!("{} by {} from tick {tick}", shipped.name, method.name());
                run.tick();
                let again = evaluated(&run) - evaluations[usize::try_from(tick).unwrap()];
                assert!(
                    again <= if tick == 0 { 0 } else { caching },
                    "{what}: {again} evaluations more"
                );
                run.run(ticks - tick - 1);
                assert_eq!(evaluated(&run) - evaluated(&whole), again, "{what}");
                outcome(&mut run).assert_restored(&expected, again, &what);
            }
        }
    }
}

#[test]
fn a_snapshot_has_the_hash_that_summaries_have() {
    for name in ["tutorial", "flag", "fountain"] {
        let scene = scene::load(name).unwrap();
        let session = Session::new(scene.clone(), Options::default());
        assert_eq!(
            Simulation::new(scene).snapshot().state_hash(),
            state_hash(&session.stage),
            "{name}"
        );
    }
}
