//! Runs in which people do things.

use glam::DVec3;
use motion::{Damping, DampingModel, Effect, Method, PushQueue, Request, Requests};

use super::Run;
use crate::ghosts::mixed;

/// What is asked for, and pushed, before tick number `tick`.
fn act(run: &mut Run, tick: u64) {
    let body = |name: &str| run.bodies[run.scene.names.find(name).unwrap() as usize];
    let requests = match tick {
        3 => vec![Request::Impulse(body("first"), DVec3::X)],
        5 => vec![Request::Switch(Effect::Gravity, true), Request::Switch(Effect::Drag, false)],
        7 => vec![Request::Remove(body("spare")), Request::Switch(Effect::Emitters, false)],
        9 => vec![Request::SetInverseMass(body("ball"), 0.25), Request::Switch(Effect::Thrusts, false)],
        11 => vec![Request::Switch(Effect::Emitters, true), Request::SetGravity(DVec3::new(0.0, -3.0, 1.0))],
        13 => vec![Request::SetBodyMethod(body("dust"), Some(Method::VelocityVerlet))],
        15 => vec![Request::SetVelocity(body("dust"), DVec3::splat(f64::NAN))],
        17 => vec![
            Request::SetDamping(Damping { model: DampingModel::Exact, rate: 0.3 }),
            Request::Switch(Effect::Wells, false),
        ],
        19 => vec![Request::Switch(Effect::Drag, true), Request::Switch(Effect::Thrusts, true)],
        21 => vec![Request::SetPosition(body("second"), DVec3::new(-3.0, 2.0, 0.5))],
        23 => vec![Request::ReverseVelocities, Request::Switch(Effect::Wells, true)],
        25 => vec![Request::Switch(Effect::Springs, false)],
        27 => vec![Request::Switch(Effect::Springs, true), Request::SwitchGravity(false)],
        _ => Vec::new(),
    };
    let (ball, second) = (body("ball"), body("second"));
    requests.into_iter().for_each(|request| run.world.resource_mut::<Requests>().ask(request));
    let mut queue = run.world.resource_mut::<PushQueue>();
    if tick.is_multiple_of(4) {
        queue.push_once(ball, DVec3::new(3.0, -1.0, 2.0));
    }
    if tick == 18 {
        // A member of a group is frozen.
        queue.push_once(second, DVec3::NAN);
    }
    match tick {
        6 => queue.sustain([motion::Push { body: second, newtons: DVec3::Y }]),
        12 => queue.sustain([]),
        _ => {}
    }
}

const TICKS: u64 = 32;

#[test]
fn a_run_with_inputs_goes_on_from_any_tick_also_with_inputs_waiting() {
    for method in Method::ALL {
        let mut scene = mixed();
        scene.method = method;
        let mut whole = Run::of(scene);
        let mut restored = Vec::new();
        for tick in 0..TICKS {
            let before = whole.restored();
            act(&mut whole, tick);
            restored.push((tick, before, whole.restored()));
            whole.ticks(1);
        }
        let expected = whole.outcome();
        assert_eq!(expected.frozen.len(), 2, "{expected:?}");
        for (from, mut before, mut waiting) in restored {
            act(&mut before, from);
            for mut run in [before, waiting.restored()] {
                run.ticks(1);
                for tick in from + 1..TICKS {
                    act(&mut run, tick);
                    run.ticks(1);
                }
                assert_eq!(run.outcome(), expected, "{} from tick {from}", method.name());
            }
        }
    }
}

#[test]
fn a_snapshot_of_another_scene_is_refused() {
    let snapshot = Run::of(scene::load("thousand").unwrap()).snapshot();
    let error = snapshot.restore(&mixed()).err().unwrap();
    assert_eq!(error.to_string(), "it has things that the scene has not");
}
