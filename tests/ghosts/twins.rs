//! Twins of a world: that they go on as the world itself would with their method.

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::{Distances, Leader, Twin, pending};
use motion::effects::Effect;
use motion::snapshot::LastStep;
use motion::{
    Method, OwnMethod, PhysicsBody, PushQueue, Request, Requests, StableId, Stepper, TimeStep, Transform,
};
use scene::Scene;

use super::mixed;

/// A world of a scene on its way.
struct Run {
    scene: Scene,
    world: World,
    stepper: Stepper,
    bodies: Vec<Entity>,
}

type State = (u32, DVec3, DVec3);

fn states(world: &mut World) -> Vec<State> {
    let mut states: Vec<_> = world
        .query::<(&StableId, &Transform, &PhysicsBody)>()
        .iter(world)
        .map(|(id, transform, body)| (id.0, transform.position, body.velocity))
        .collect();
    states.sort_by_key(|state| state.0);
    states
}

fn states_of(twin: &Twin) -> Vec<State> {
    let world = twin.world();
    let state = |entity: &Entity| {
        let body = world.get_entity(*entity).ok()?;
        let state = body.get::<PhysicsBody>()?;
        Some((body.get::<StableId>()?.0, body.get::<Transform>()?.position, state.velocity))
    };
    twin.bodies().entities.iter().filter_map(state).collect()
}

impl Run {
    fn of(scene: Scene) -> Self {
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        let stepper = Stepper::new(&mut world, scene.method, TimeStep(1.0 / scene.step_hz));
        Self { scene, world, stepper, bodies }
    }

    fn by(method: Method) -> Self {
        Self::of(Scene { method, ..mixed() })
    }

    fn twin(&mut self, method: Method) -> Twin {
        let mut leader = Leader { scene: &self.scene, world: &mut self.world, method: self.stepper.method() };
        Twin::new(&mut leader, method, None)
    }

    /// What acts in tick number `tick` from outside.
    fn act(&mut self, tick: u32) {
        let body = |name: &str| self.bodies[self.scene.names.find(name).unwrap() as usize];
        let mut requests = Vec::new();
        match tick {
            8 => requests.push(Request::Impulse(body("first"), DVec3::X)),
            11 => requests.push(Request::Switch(Effect::Gravity, true)),
            17 => requests.push(Request::Remove(body("spare"))),
            26 => requests.push(Request::SetInverseMass(body("ball"), 0.25)),
            31 => requests.push(Request::Switch(Effect::Drag, false)),
            _ => {}
        }
        let ball = body("ball");
        requests.into_iter().for_each(|request| self.world.resource_mut::<Requests>().ask(request));
        if tick.is_multiple_of(5) {
            self.world.resource_mut::<PushQueue>().push_once(ball, DVec3::new(3.0, -1.0, f64::from(tick)));
        }
    }

    fn run(&mut self, ticks: std::ops::Range<u32>, twins: &mut [Twin]) {
        for tick in ticks {
            self.act(tick);
            let (step, inputs) = (*self.world.resource::<TimeStep>(), pending(&self.world));
            twins.iter_mut().for_each(|twin| twin.tick(step, &inputs));
            self.stepper.tick(&mut self.world);
        }
    }
}

#[test]
fn a_twin_of_any_method_goes_on_as_the_world_does_after_that_change() {
    for leads in Method::ALL {
        let mut leader = Run::by(leads);
        leader.run(0..20, &mut []);
        let mut twins = Method::ALL.map(|method| leader.twin(method));
        leader.run(20..45, &mut twins);
        for (method, twin) in Method::ALL.into_iter().zip(&twins) {
            let mut changed = Run::by(leads);
            changed.run(0..20, &mut []);
            changed.stepper.set_method(&mut changed.world, method);
            assert_eq!(twin.method(), method);
            changed.run(20..45, &mut []);
            assert_eq!(states_of(twin), states(&mut changed.world), "{method:?} after {leads:?}");
        }
        let mut undisturbed = Run::by(leads);
        undisturbed.run(0..45, &mut []);
        assert_eq!(states(&mut leader.world), states(&mut undisturbed.world), "{leads:?} itself");
    }
}

#[test]
fn a_twin_starts_with_the_places_of_the_world_and_velocities_of_their_own_time() {
    let mut leader = Run::by(Method::PositionVerlet);
    leader.run(0..20, &mut []);
    let lags = |run: &mut Run| run.world.query::<&LastStep>().iter(&run.world).any(|last| last.0 > 0.0);
    assert!(lags(&mut leader));
    let before = states(&mut leader.world);
    let twin = leader.twin(Method::RungeKutta4);
    assert!(lags(&mut leader) && states(&mut leader.world) == before, "the world is left as it is");
    let started = states_of(&twin);
    let places = |states: &[State]| states.iter().map(|state| state.1).collect::<Vec<_>>();
    assert_eq!(places(&started), places(&before));
    let changed = started.iter().zip(&before).filter(|(a, b)| a.2 != b.2).count();
    assert!(changed >= 5, "velocities that lag half a step: {changed}");
    assert_eq!(states_of(&leader.twin(Method::PositionVerlet)), before);
}

#[test]
fn every_body_of_a_twin_has_its_one_method() {
    let race = scene::load("orbits_race").unwrap();
    let method = Method::Yoshida4;
    for ticks in [0, 7] {
        let mut leader = Run::of(race.clone());
        (0..ticks).for_each(|_| leader.stepper.tick(&mut leader.world));
        let mut changed = Run::of(race.clone());
        (0..ticks).for_each(|_| changed.stepper.tick(&mut changed.world));
        for body in changed.bodies.clone() {
            changed.world.resource_mut::<Requests>().ask(Request::SetBodyMethod(body, Some(method)));
        }
        let mut twin = leader.twin(method);
        for _ in 0..30 {
            twin.tick(*leader.world.resource::<TimeStep>(), &[]);
            changed.stepper.tick(&mut changed.world);
        }
        let own = |body: &Entity| twin.world().get::<OwnMethod>(*body).is_some();
        assert!(!twin.bodies().entities.iter().any(own));
        assert_eq!(states_of(&twin), states(&mut changed.world), "after {ticks} ticks");
    }
}

#[test]
fn soft_bodies_and_particles_come_along() {
    for (name, ticks) in [("flag", 12), ("fountain", 90)] {
        let mut leader = Run::of(scene::load(name).unwrap());
        (0..ticks).for_each(|_| leader.stepper.tick(&mut leader.world));
        let method = leader.stepper.method();
        let mut twin = leader.twin(method);
        for _ in 0..ticks {
            let step = *leader.world.resource::<TimeStep>();
            twin.tick(step, &pending(&leader.world));
            leader.stepper.tick(&mut leader.world);
        }
        assert_eq!(states_of(&twin), states(&mut leader.world), "{name}");
        let own = history::Bodies { world: &leader.world, entities: &leader.bodies };
        let distances = Distances::between(twin.bodies(), own);
        assert!(distances.each.len() > 100, "{name}: {} bodies that live", distances.each.len());
        assert_eq!(distances.rms(), Some(0.0));
    }
}
