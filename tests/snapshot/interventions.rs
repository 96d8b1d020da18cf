//! Runs in which people do things.

use glam::DVec3;
use motion::effects::Effect;
use motion::{
    Damping, DampingModel, Fault, Method, PushQueue, Quarantine, QuarantineRecord, Request, Requests,
    StableId,
};

use super::{Run, caches};
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
                // The dust is given velocity Verlet.
                let caching = if caches(method) { run.bodies.len() as u64 } else { 1 };
                let what = format!("{} from tick {from}", method.name());
                run.outcome().assert_restored(&expected, caching, &what);
            }
        }
    }
}

#[test]
fn a_run_goes_on_by_a_method_that_cannot_solve_what_is_switched_off() {
    let mut whole = Run::of(scene::load("figure_eight").unwrap());
    whole.ticks(10);
    whole.world.resource_mut::<Requests>().ask(Request::Switch(Effect::MutualGravity, false));
    whole.ticks(1);
    whole.stepper.set_method(&mut whole.world, Method::ImplicitEuler);
    whole.ticks(5);
    let mut restored = whole.restored();
    whole.ticks(5);
    restored.ticks(5);
    assert_eq!(restored.outcome(), whole.outcome());
    // With it there is no such run.
    whole.world.resource_mut::<Requests>().ask(Request::Switch(Effect::MutualGravity, true));
    whole.ticks(1);
    let error = whole.snapshot().restore(&whole.scene).err().unwrap();
    assert_eq!(error.to_string(), "its method cannot solve the scene");
}

#[test]
fn records_of_bodies_that_are_gone_go_along_with_the_springs_that_were_at_fault() {
    let text = r#"(version: 1, bodies: [
        (name: "wall", immovable: true), (name: "ball", position_m: (1e10, 0, 0)), (name: "free")],
        springs: [(between: ("wall", "ball"), stiffness_n_m: 1e300, rest_length_m: 1)])"#;
    let mut run = Run::of(scene::Scene::parse("test", text).unwrap());
    let [wall, ball, free] = run.bodies[..] else { panic!("three bodies") };
    run.ticks(10);
    run.world.resource_mut::<Requests>().ask(Request::SetVelocity(free, DVec3::NAN));
    run.ticks(10);
    [wall, ball, free].into_iter().for_each(|body| {
        run.world.resource_mut::<Requests>().ask(Request::Remove(body));
    });
    run.ticks(10);
    let records = run.world.resource::<Quarantine>().records().to_vec();
    let ids = |records: &[QuarantineRecord]| -> Vec<_> {
        records.iter().map(|record| (record.id, record.other_end, record.tick)).collect()
    };
    let (wall_id, ball_id, free_id) = (StableId(0), StableId(1), StableId(2));
    assert_eq!(ids(&records), [(Some(ball_id), Some(wall_id), 1), (Some(free_id), None, 11)]);
    let mut restored = run.restored();
    let again = restored.world.resource::<Quarantine>().records().to_vec();
    assert_eq!(ids(&again), ids(&records));
    let [wall, ball, _] = restored.bodies[..] else { panic!("three bodies") };
    assert_eq!((again[0].body, again[0].cause.fault), (ball, Fault::Spring(wall)));
    assert_eq!(restored.outcome(), run.outcome());
    assert_eq!(restored.snapshot(), run.snapshot());
}

#[test]
fn a_snapshot_of_another_scene_is_refused() {
    let snapshot = Run::of(scene::load("thousand").unwrap()).snapshot();
    let error = snapshot.restore(&mixed()).err().unwrap();
    assert_eq!(error.to_string(), "it has things that the scene has not");
}
