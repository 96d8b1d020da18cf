//! Every shipped scene by every method.

use motion::Method;
use sandbox::report::state_hash;
use sandbox::{Options, Session};
use scene::unsolvable;

use super::Run;

/// Ticks of a run that is interrupted, and when: at the start, while methods have just begun, and later.
const TICKS: u64 = 20;
const INTERRUPTED_AT: [u64; 4] = [0, 1, 2, 13];

#[test]
fn every_scene_by_every_method_goes_on_bit_for_bit_and_evaluation_for_evaluation() {
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
            let mut whole = Run::of(scene);
            let mut restored = Vec::new();
            for tick in 0..ticks {
                if INTERRUPTED_AT.contains(&tick) {
                    restored.push(whole.restored());
                }
                whole.ticks(1);
            }
            let expected = whole.outcome();
            for (mut run, tick) in restored.into_iter().zip(INTERRUPTED_AT) {
                run.ticks(ticks - tick);
                let what = format!("{} by {} from tick {tick}", shipped.name, method.name());
                assert_eq!(run.outcome(), expected, "{what}");
            }
        }
    }
}

#[test]
fn a_snapshot_has_the_hash_that_summaries_have() {
    for name in ["tutorial", "flag", "fountain"] {
        let scene = scene::load(name).unwrap();
        let session = Session::new(scene.clone(), Options::default());
        assert_eq!(Run::of(scene).snapshot().state_hash(), state_hash(&session), "{name}");
    }
}
