//! Twins of a world: that they move as the world itself would with their method.

use glam::DVec3;
use history::{Change, Distances, Simulation, Twin};
use motion::effects::Effect;
use motion::snapshot::LastStep;
use motion::{Method, OwnMethod, Request};
use scene::Scene;

use crate::rigs::mixed;

type State = (u32, DVec3, DVec3);

fn states(simulation: &Simulation) -> Vec<State> {
    simulation.states().collect()
}

fn by(method: Method) -> Simulation {
    Simulation::new(Scene { method, ..mixed() })
}

/// The changes before tick number `tick`.
fn changes(run: &Simulation, tick: u32) -> Vec<Change> {
    let body = |name: &str| run.named(name).unwrap();
    let request = match tick {
        8 => Some(Request::Impulse(body("first"), DVec3::X)),
        11 => Some(Request::Switch(Effect::Gravity, true)),
        17 => Some(Request::Remove(body("spare"))),
        26 => Some(Request::SetInverseMass(body("ball"), 0.25)),
        31 => Some(Request::Switch(Effect::Drag, false)),
        _ => None,
    };
    let ball = body("ball");
    let request = request.and_then(|request| request.rename(|body| run.id(body)));
    let push = tick
        .is_multiple_of(5)
        .then(|| Change::Push(run.id(ball).unwrap(), DVec3::new(3.0, -1.0, f64::from(tick))));
    request.map(Change::request).into_iter().chain(push).collect()
}

fn run(leader: &mut Simulation, ticks: std::ops::Range<u32>, twins: &mut [Twin]) {
    for tick in ticks {
        for change in changes(leader, tick) {
            leader.give(&change);
            twins.iter_mut().for_each(|twin| twin.give(&change));
        }
        twins.iter_mut().for_each(Twin::tick);
        leader.tick();
    }
}

#[test]
fn a_twin_of_any_method_goes_on_as_the_world_does_after_that_change() {
    for leads in Method::ALL {
        let mut leader = by(leads);
        run(&mut leader, 0..20, &mut []);
        let mut twins = Method::ALL.map(|method| Twin::new(&leader, method, None));
        run(&mut leader, 20..45, &mut twins);
        for (method, twin) in Method::ALL.into_iter().zip(&twins) {
            let mut changed = by(leads);
            run(&mut changed, 0..20, &mut []);
            changed.set_method(method);
            assert_eq!(twin.method(), method);
            run(&mut changed, 20..45, &mut []);
            assert_eq!(states(twin.simulation()), states(&changed), "{method:?} after {leads:?}");
        }
        let mut undisturbed = by(leads);
        run(&mut undisturbed, 0..45, &mut []);
        assert_eq!(states(&leader), states(&undisturbed), "{leads:?} itself");
    }
}

#[test]
fn a_twin_starts_with_the_places_of_the_world_and_velocities_of_their_own_time() {
    let mut leader = by(Method::PositionVerlet);
    run(&mut leader, 0..20, &mut []);
    let lags = |run: &mut Simulation| {
        run.world.query::<&LastStep>().iter(&run.world).any(|last| last.0 > 0.0)
    };
    assert!(lags(&mut leader));
    let before = states(&leader);
    let twin = Twin::new(&leader, Method::RungeKutta4, None);
    assert!(lags(&mut leader) && states(&leader) == before, "the world is left as it is");
    let started = states(twin.simulation());
    let places = |states: &[State]| states.iter().map(|state| state.1).collect::<Vec<_>>();
    assert_eq!(places(&started), places(&before));
    let changed = started.iter().zip(&before).filter(|(a, b)| a.2 != b.2).count();
    assert!(changed >= 5, "velocities that lag half a step: {changed}");
    assert_eq!(states(Twin::new(&leader, Method::PositionVerlet, None).simulation()), before);
}

#[test]
fn every_body_of_a_twin_has_its_one_method() {
    let race = scene::load("orbits_race").unwrap();
    let method = Method::Yoshida4;
    for ticks in [0, 7] {
        let mut leader = Simulation::new(race.clone());
        leader.run(ticks);
        let mut changed = Simulation::new(race.clone());
        changed.run(ticks);
        for body in changed.bodies.clone() {
            changed.request(Request::SetBodyMethod(body, Some(method)));
        }
        let mut twin = Twin::new(&leader, method, None);
        for _ in 0..30 {
            twin.tick();
            changed.tick();
        }
        let Simulation { world, bodies, .. } = twin.simulation();
        assert!(!bodies.iter().any(|body| world.get::<OwnMethod>(*body).is_some()));
        assert_eq!(states(twin.simulation()), states(&changed), "after {ticks} ticks");
    }
}

#[test]
fn soft_bodies_and_particles_come_along() {
    for (name, ticks) in [("flag", 12), ("fountain", 90)] {
        let mut leader = Simulation::new(scene::load(name).unwrap());
        leader.run(ticks);
        let method = leader.method();
        let mut twin = Twin::new(&leader, method, None);
        for _ in 0..ticks {
            twin.tick();
            leader.tick();
        }
        assert_eq!(states(twin.simulation()), states(&leader), "{name}");
        let distances = Distances::between(twin.simulation(), &leader);
        assert!(distances.each.len() > 100, "{name}: {} bodies that live", distances.each.len());
        assert!(distances.each.iter().all(|(_, distance)| *distance == 0.0));
    }
}
