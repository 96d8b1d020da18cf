//! Runs in which people do things.

use glam::DVec3;
use history::Simulation;
use motion::effects::Effect;
use motion::{
    Damping, DampingModel, Fault, Method, PushQueue, Quarantine, QuarantineRecord, Request,
    StableId,
};

use super::{caches, outcome, restored};
use crate::rigs::{mixed, scene_of};

/// What is asked for, and pushed, before tick number `tick`.
pub(super) fn act(run: &mut Simulation, tick: u64) {
    let body = |name: &str| run.named(name).unwrap();
    let requests = match tick {
        3 => vec![Request::Impulse(body("first"), DVec3::X)],
        5 => vec![Request::Switch(Effect::Gravity, true), Request::Switch(Effect::Drag, false)],
        7 => vec![Request::Remove(body("spare")), Request::Switch(Effect::Emitters, false)],
        9 => vec![
            Request::SetInverseMass(body("ball"), 0.25),
            Request::Switch(Effect::Thrusts, false),
        ],
        11 => vec![
            Request::Switch(Effect::Emitters, true),
            Request::SetGravity(DVec3::new(0.0, -3.0, 1.0)),
        ],
        13 => vec![Request::SetBodyMethod(body("dust"), Some(Method::VelocityVerlet))],
        15 => vec![Request::SetVelocity(body("dust"), DVec3::NAN)],
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
    requests.into_iter().for_each(|request| run.request(request));
    let mut queue = run.world.resource_mut::<PushQueue>();
    if tick.is_multiple_of(4) {
        queue.push_once(ball, DVec3::new(3.0, -1.0, 2.0));
    }
    if tick == 18 {
        // A member of a group is quarantined.
        queue.push_once(second, DVec3::NAN);
    }
    match tick {
        6 => queue.sustain([motion::Push { body: second, newtons: DVec3::Y }]),
        12 => queue.sustain([]),
        _ => {}
    }
}

pub(super) const TICKS: u64 = 32;

#[test]
fn a_run_with_inputs_goes_on_from_any_tick_also_with_inputs_waiting() {
    for method in Method::ALL {
        let mut scene = mixed();
        scene.method = method;
        let mut whole = Simulation::new(scene);
        let mut interrupted = Vec::new();
        for tick in 0..TICKS {
            let before = restored(&mut whole);
            act(&mut whole, tick);
            interrupted.push((tick, before, restored(&mut whole)));
            whole.tick();
        }
        let expected = outcome(&mut whole);
        assert_eq!(expected.quarantined.len(), 2, "{expected:?}");
        for (from, mut before, mut waiting) in interrupted {
            act(&mut before, from);
            for mut run in [before, restored(&mut waiting)] {
                run.tick();
                for tick in from + 1..TICKS {
                    act(&mut run, tick);
                    run.tick();
                }
                // The dust is given velocity Verlet.
                let caching = if caches(method) { run.bodies.len() as u64 } else { 1 };
                let what = format!("{} from tick {from}", method.name());
                outcome(&mut run).assert_restored(&expected, caching, &what);
            }
        }
    }
}

#[test]
fn a_run_goes_on_by_a_method_that_cannot_solve_what_is_switched_off() {
    let mut whole = Simulation::new(scene::load("figure_eight").unwrap());
    whole.run(10);
    whole.request(Request::Switch(Effect::MutualGravity, false));
    whole.tick();
    whole.set_method(Method::ImplicitEuler);
    whole.run(5);
    let mut again = restored(&mut whole);
    whole.run(5);
    again.run(5);
    assert_eq!(outcome(&mut again), outcome(&mut whole));
    // With it there is no such run.
    whole.request(Request::Switch(Effect::MutualGravity, true));
    whole.tick();
    let snapshot = whole.snapshot();
    let error = Simulation::restore(whole.scene, &snapshot).err().unwrap();
    assert_eq!(error.to_string(), "its method cannot solve the scene");
}

#[test]
fn records_of_bodies_that_are_gone_go_along_with_the_springs_that_were_at_fault() {
    let text = r#"(version: 1, bodies: [
        (name: "wall", immovable: true), (name: "ball", position_m: (1e10, 0, 0)), (name: "free")],
        springs: [(between: ("wall", "ball"), stiffness_n_m: 1e300, rest_length_m: 1)])"#;
    let mut run = Simulation::new(scene_of(text));
    let [wall, ball, free] = run.bodies[..] else { panic!("three bodies") };
    run.run(10);
    run.request(Request::SetVelocity(free, DVec3::NAN));
    run.run(10);
    [wall, ball, free].into_iter().for_each(|body| {
        run.request(Request::Remove(body));
    });
    run.run(10);
    let records = run.world.resource::<Quarantine>().records().to_vec();
    let ids = |records: &[QuarantineRecord]| -> Vec<_> {
        records.iter().map(|record| (record.id, record.other_end, record.tick)).collect()
    };
    let (wall_id, ball_id, free_id) = (StableId(0), StableId(1), StableId(2));
    assert_eq!(ids(&records), [(Some(ball_id), Some(wall_id), 1), (Some(free_id), None, 11)]);
    let mut other = restored(&mut run);
    let again = other.world.resource::<Quarantine>().records().to_vec();
    assert_eq!(ids(&again), ids(&records));
    let [wall, ball, _] = other.bodies[..] else { panic!("three bodies") };
    assert_eq!((again[0].body, again[0].cause.fault), (ball, Fault::Spring(wall)));
    assert_eq!(outcome(&mut other), outcome(&mut run));
    assert_eq!(other.snapshot(), run.snapshot());
}

#[test]
fn a_snapshot_of_another_scene_is_refused() {
    let snapshot = Simulation::new(scene::load("thousand").unwrap()).snapshot();
    let error = Simulation::restore(mixed(), &snapshot).err().unwrap();
    assert_eq!(error.to_string(), "it has things that the scene lacks");
}
