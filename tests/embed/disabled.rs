//! Disabled entities, beside a world in which they are removed and come back; with panics that are caught and snapshots between.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::snapshot::{self, LastStep};
use motion::{
    BodyState, Dormant, Drag, Elastic, Emitter, EvaluationTime, Force, Gravity, Jacobians, Law,
    Laws, Link, Method, MutualGravity, PhysicsBody, PushQueue, SoftBody, Spring, StableId, Stepper,
    TimeStep, Transform,
};

use super::state;
use crate::rigs::{Bits, Dice};

/// Bodies, and those of them that are points of a soft body.
const BODIES: u32 = 10;
const POINTS: std::ops::Range<usize> = 6..10;

/// Particles of the emitter, with ids after those of the bodies.
const PARTICLES: u32 = 6;

/// A law that panics when it is told to, and moves nothing.
#[derive(Debug)]
struct Bomb(Arc<AtomicBool>);

impl Law for Bomb {
    fn name(&self) -> &'static str {
        "bomb"
    }

    fn acceleration(&self, _: EvaluationTime, _: BodyState) -> DVec3 {
        assert!(!self.0.load(Ordering::Relaxed), "this law panics");
        DVec3::ZERO
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians::zero()
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }
}

/// How an entity is left out of the ticks.
#[derive(Clone, Copy, Debug)]
enum Way {
    Disabled,
    WithoutForce,
    WithoutTransform,
}

/// What of a body is kept while it is out.
#[derive(Clone, Copy, Debug)]
struct Kept {
    at: Transform,
    body: PhysicsBody,
    last: Option<LastStep>,
}

/// A world and all that may be in it.
struct Side {
    world: World,
    ticks: Option<Ticks>,
    /// Whether what is out is removed, to come back as another entity.
    removes: bool,
    bodies: Vec<Entity>,
    /// The state of each body that is out.
    out: Vec<Option<Kept>>,
    springs: Vec<SpringSpec>,
    soft: Entity,
    emitter: Entity,
    spec: Emitter,
}

/// A spring and whether it is there.
#[derive(Clone, Copy, Debug)]
struct SpringSpec {
    ends: [usize; 2],
    stiffness: f64,
    entity: Entity,
    is_out: bool,
    is_gone: bool,
}

/// What makes ticks.
enum Ticks {
    Stepper(Box<Stepper>),
    Installed(Box<Schedule>),
}

impl Side {
    fn new(seed: u64, removes: bool, bomb: &Arc<AtomicBool>) -> Self {
        let mut dice = Dice(seed);
        let mut world = World::new();
        world.insert_resource(Gravity::EARTH);
        world.insert_resource(Drag::new(0.1, 0.05));
        world.insert_resource(Laws(vec![Box::new(Bomb(Arc::clone(bomb)))]));
        let attracts = seed.is_multiple_of(4);
        if attracts {
            world.insert_resource(MutualGravity { constant: 0.5, softening: 0.3 });
        }
        let mut body = |id: u32| {
            let mass = if id.is_multiple_of(5) { f64::INFINITY } else { 1.5 + dice.number() };
            (StableId(id), Transform::at(dice.vector() * 3.0), PhysicsBody::with_mass(mass))
        };
        let bodies: Vec<_> = (0..BODIES).map(|id| world.spawn(body(id)).id()).collect();
        let pool =
            (0..PARTICLES).map(|id| world.spawn((body(BODIES + id), Dormant)).id()).collect();
        let launches = (0..PARTICLES).map(|_| dice.vector()).collect();
        let (rate, life, position) = (20.0, 0.2, DVec3::X);
        let spec = Emitter { rate, life, position, pool, launches, inverse_mass: 2.0 };
        let spring = |dice: &mut Dice| SpringSpec {
            ends: [dice.below(6), dice.below(6)],
            stiffness: 30.0 + 10.0 * dice.number(),
            entity: Entity::PLACEHOLDER,
            is_out: false,
            is_gone: false,
        };
        let springs = (0..5).map(|_| spring(&mut dice)).collect();
        // Implicit Euler does not solve mutual gravity.
        let method = Method::ALL[dice.below(Method::ALL.len())];
        let method = if attracts { Method::VelocityVerlet } else { method };
        let [soft, emitter] = [world.spawn_empty().id(), world.spawn(spec.clone()).id()];
        let out = bodies.iter().map(|_| None).collect();
        let mut side =
            Self { world, ticks: None, removes, bodies, out, springs, soft, emitter, spec };
        for spring in &mut side.springs {
            spring.entity = side.world.spawn_empty().id();
        }
        side.join();
        let stepper = Stepper::new(&mut side.world, method, TimeStep(1.0 / 120.0));
        side.ticks = Some(Ticks::Stepper(Box::new(stepper)));
        side
    }

    /// Gives springs and the soft body the entities of their bodies.
    fn join(&mut self) {
        let elastic = |stiffness| Elastic::new(stiffness, 1.0).damped(0.2);
        for SpringSpec { ends, stiffness, entity, is_out, is_gone } in &self.springs {
            let spring =
                Spring { ends: ends.map(|end| self.bodies[end]), elastic: elastic(*stiffness) };
            if *is_gone || self.removes && *is_out {
                self.world.entity_mut(*entity).remove::<Spring>();
            } else {
                self.world.entity_mut(*entity).insert(spring);
            }
        }
        let springs =
            [[0, 1], [1, 2], [2, 3], [0, 2]].map(|ends| Link { ends, elastic: elastic(40.0) });
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let points = self.bodies[POINTS].to_vec();
        self.world.entity_mut(self.soft).insert(SoftBody {
            points,
            springs: springs.into(),
            triangles,
            sheet: true,
        });
    }

    /// Takes a body out of the ticks, or back into them.
    fn turn(&mut self, id: usize, way: Way) {
        match self.out[id].take() {
            None => {
                let mut body = self.world.entity_mut(self.bodies[id]);
                let (at, state) = body.components::<(&Transform, &PhysicsBody)>();
                self.out[id] = Some(Kept { at: *at, body: *state, last: body.get().copied() });
                match way {
                    _ if self.removes => body.despawn(),
                    Way::Disabled => drop(body.insert(Disabled)),
                    Way::WithoutForce => drop(body.remove::<Force>()),
                    Way::WithoutTransform => drop(body.remove::<Transform>()),
                }
            }
            Some(Kept { at, body, last }) if self.removes => {
                let id = u32::try_from(id).unwrap();
                let mut entity = self.world.spawn((StableId(id), at, body));
                last.map(|last| entity.insert(last).id());
                self.bodies[id as usize] = entity.id();
                self.join();
            }
            Some(Kept { at, .. }) => {
                let mut body = self.world.entity_mut(self.bodies[id]);
                body.remove::<Disabled>();
                if !body.contains::<Force>() {
                    body.insert(Force::default());
                }
                if !body.contains::<Transform>() {
                    body.insert(at);
                }
            }
        }
    }

    fn turn_spring(&mut self, number: usize) {
        let SpringSpec { entity, is_out, .. } = &mut self.springs[number];
        *is_out = !*is_out;
        match (self.removes, *is_out) {
            (true, _) => self.join(),
            (false, true) => drop(self.world.entity_mut(*entity).insert(Disabled)),
            (false, false) => drop(self.world.entity_mut(*entity).remove::<Disabled>()),
        }
    }

    /// Removes a spring for ever.
    fn cut(&mut self, number: usize) {
        self.springs[number].is_gone = true;
        self.join();
    }

    fn turn_emitter(&mut self) {
        let there = self.world.get_entity(self.emitter);
        let is_out = there.is_ok_and(|emitter| emitter.contains::<Disabled>()) || there.is_err();
        match (self.removes, is_out) {
            (true, true) => self.emitter = self.world.spawn(self.spec.clone()).id(),
            (true, false) => drop(self.world.despawn(self.emitter)),
            (false, true) => drop(self.world.entity_mut(self.emitter).remove::<Disabled>()),
            (false, false) => drop(self.world.entity_mut(self.emitter).insert(Disabled)),
        }
    }

    fn push(&mut self, id: usize, newtons: DVec3) {
        // A push waits for a body that comes back before the tick, and not for another entity in its place.
        if self.out[id].is_none() {
            self.world.resource_mut::<PushQueue>().push_once(self.bodies[id], newtons);
        }
    }

    fn tick(&mut self) {
        match self.ticks.as_mut().unwrap() {
            Ticks::Stepper(stepper) => stepper.tick(&mut self.world),
            Ticks::Installed(schedule) => schedule.run(&mut self.world),
        }
        self.world.clear_trackers();
    }

    /// Installs the stepper into a schedule, or takes it out of one.
    fn reinstall(&mut self) {
        self.ticks = Some(match self.ticks.take().unwrap() {
            Ticks::Stepper(stepper) => {
                let mut schedule = Schedule::default();
                stepper.install(&mut self.world, &mut schedule);
                Ticks::Installed(Box::new(schedule))
            }
            Ticks::Installed(_) => Ticks::Stepper(Box::new(Stepper::uninstall(&mut self.world))),
        });
    }

    fn with_stepper<R>(&mut self, use_it: impl FnOnce(&mut Stepper, &mut World) -> R) -> R {
        match self.ticks.as_mut().unwrap() {
            Ticks::Stepper(stepper) => use_it(stepper, &mut self.world),
            Ticks::Installed(_) => Stepper::installed(&mut self.world, use_it),
        }
    }

    /// A tick in which a law panics, and back to where it began.
    fn blow_up(&mut self, bomb: &AtomicBool) {
        let saved = self.with_stepper(|stepper, world| snapshot::take(world, stepper));
        bomb.store(true, Ordering::Relaxed);
        let blown = catch_unwind(AssertUnwindSafe(|| self.tick()));
        bomb.store(false, Ordering::Relaxed);
        self.with_stepper(|stepper, world| snapshot::restore(world, stepper, &saved)).unwrap();
        if blown.is_err() && matches!(self.ticks, Some(Ticks::Installed(_))) {
            // A schedule in which a system panicked skips systems in its next run.
            self.reinstall();
            self.reinstall();
        }
    }

    /// The bits of the bodies that are in the ticks.
    fn state(&mut self) -> Vec<(StableId, Bits, bool)> {
        let out = |id: &StableId| self.out.get(id.0 as usize).is_some_and(Option::is_some);
        state(&mut self.world).into_iter().filter(|(id, ..)| !out(id)).collect()
    }
}

/// Fewer operations than ticks, of every kind.
fn operate(dice: &mut Dice, sides: &mut [Side; 2], bomb: &AtomicBool) {
    let (body, spring) = (dice.below(BODIES as usize), dice.below(5));
    let way =
        [Way::Disabled, Way::Disabled, Way::WithoutForce, Way::WithoutTransform][dice.below(4)];
    match dice.below(11) {
        0..4 => sides.iter_mut().for_each(|side| side.turn(body, way)),
        4 | 5 => sides.iter_mut().for_each(|side| side.turn_spring(spring)),
        6 if dice.below(3) == 0 => sides.iter_mut().for_each(|side| side.cut(spring)),
        7 => sides.iter_mut().for_each(Side::turn_emitter),
        8 => sides[0].blow_up(bomb),
        9 => sides[0].reinstall(),
        _ => {}
    }
}

#[test]
fn what_is_disabled_is_out_as_if_it_were_removed_and_comes_back() {
    let bomb = Arc::new(AtomicBool::new(false));
    for seed in 0..200 {
        let mut sides = [false, true].map(|removes| Side::new(seed, removes, &bomb));
        let mut dice = Dice(seed ^ 0xd15a_b1ed);
        let mut moved = false;
        for tick in 0..60 {
            let before = sides[0].state();
            while dice.below(2) == 0 {
                operate(&mut dice, &mut sides, &bomb);
            }
            let (pushed, newtons) = (dice.below(BODIES as usize), dice.vector() * 20.0);
            sides.iter_mut().for_each(|side| side.push(pushed, newtons));
            sides.iter_mut().for_each(Side::tick);
            let [ours, theirs] = sides.each_mut().map(Side::state);
            assert_eq!(ours, theirs, "seed {seed}, tick {tick}");
            let [clock, other] = sides.each_ref().map(|side| *side.world.resource::<StepClock>());
            assert_eq!(clock, other);
            moved |= ours != before;
        }
        assert!(moved);
    }
}
