//! Threads share the bodies and change no bit.

use glam::DVec3;
use motion::{Damping, DampingModel, Gravity, Method, Threads};

use super::{Bits, Dice, Environment, H, Start, wells};

/// Not a multiple of a block, so that the last share has a rest.
const BODIES: usize = Threads::FROM + 7;

/// The rows on both sides of where two threads part, and others.
const PUSHED: [usize; 9] = [0, 3, 10_002, 10_003, 10_004, 10_005, 10_007, 10_008, BODIES - 1];

/// The body that is pushed out of all bounds.
const VICTIM: usize = 15_001;

fn starts() -> Vec<Start> {
    let mut dice = Dice(3);
    let start = |i: usize| Start {
        x: dice.vector() * 5.0,
        v: dice.vector(),
        w: if i % 1000 == 999 { 0.0 } else { 1.0 + dice.number() * 0.5 },
    };
    (0..BODIES).map(start).collect()
}

fn run(
    scene: &Environment,
    method: Method,
    threads: usize,
    starts: &[Start],
) -> (Vec<Bits>, Vec<(usize, u64)>, u64) {
    let mut lab = scene.lab(method, H);
    if threads > 1 {
        let threads_of_it = Threads::new(threads);
        assert_eq!(threads_of_it.count(), threads);
        lab.world.insert_resource(threads_of_it);
    }
    let starts: Vec<_> = starts.iter().map(|start| start.components()).collect();
    lab.bodies = lab.world.spawn_batch(starts).collect();
    lab.recompile();
    for tick in 0..4 {
        for (k, body) in PUSHED.into_iter().enumerate() {
            lab.push(body, DVec3::new(k as f64, 10.0, f64::from(tick)));
        }
        if tick == 1 {
            lab.push(VICTIM, DVec3::X * f64::NAN);
        }
        lab.run(1);
    }
    let records =
        lab.quarantined().into_iter().zip(lab.records()).map(|(body, record)| (body, record.tick));
    (lab.all_bits(&[]), records.collect(), lab.evaluations().accelerations())
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let starts = starts();
    let damping = Some(Damping { model: DampingModel::Clamped, rate: 0.4 });
    let called = Environment {
        gravity: Some(Gravity::EARTH),
        wells: Some(wells()),
        ..Environment::default()
    };
    for method in Method::ALL {
        for scene in [Environment { damping, ..Environment::falling() }, called.clone()] {
            let one = run(&scene, method, 1, &starts);
            assert_eq!(one.1, [(VICTIM, 2)], "{method:?}");
            for threads in [2, 3] {
                let several = run(&scene, method, threads, &starts);
                assert!(one == several, "{method:?} {threads} {scene:?}");
            }
        }
    }
}
