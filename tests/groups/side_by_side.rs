//! Groups of one shape are integrated side by side: each has the bits, counts and records of the same group alone.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::effects::Effect;
use motion::internals::{Groups, Solver};
use motion::ledger::Ledger;
use motion::snapshot;
use motion::{
    AxisLocks, BodyState, Damping, DampingModel, DampingRate, Drag, Elastic, EvaluationTime,
    Evaluations, Gravity, GravityOff, Jacobians, Law, Laws, Method, OwnSubsteps, PhysicsBody,
    PushQueue, Quarantine, Range, Request, Requests, SpeedLimit, Spring, StableId, Stepper,
    Substeps, TimeStep, Transform, Well, Wells,
};

use crate::rigs::{Bits, Dice, bits};

/// Groups of each shape: more than a block of them, and no whole number of vectors.
const GROUPS: usize = 41;

/// Worlds of each method.
const WORLDS: u64 = 30;

/// Bodies that move, and the joined bodies: of a mass on a post, a pair, a chain between two posts.
const SHAPES: [(usize, &[[usize; 2]]); 3] =
    [(1, &[[0, 1]]), (2, &[[0, 1]]), (3, &[[0, 1], [1, 2], [0, 3], [2, 4]])];

/// Bodies with different ones of these are in different tables, and so their groups in no bundle.
#[derive(Component)]
struct Mark<const N: u32>;

/// A force that grows and jumps: its steps are split.
#[derive(Debug)]
struct Gust([f64; 1]);

impl Law for Gust {
    fn name(&self) -> &'static str {
        "gust"
    }

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> DVec3 {
        let strength = if at.within_step < self.0[0] { 1.0 } else { -2.0 };
        DVec3::new(strength, 0.0, at.time) * body.inverse_mass
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians::zero()
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn discontinuities(&self) -> &[f64] {
        &self.0
    }
}

/// A world of groups, side by side or each alone.
struct Side {
    world: World,
    stepper: Stepper,
    ledger: Option<Ledger>,
    bodies: Vec<Entity>,
    springs: Vec<Entity>,
}

impl Side {
    fn new(method: Method, seed: u64, alone: bool) -> Self {
        let mut dice = Dice(seed);
        let mut world = World::new();
        world.insert_resource(Gravity::EARTH);
        environment(&mut world, &mut dice);
        let damping = if dice.below(3) == 0 { 0.3 } else { 0.0 };
        let rest_length = if dice.below(3) == 0 { 0.0 } else { 1.0 };
        let (with_options, kind, with_ledger) =
            (dice.below(3) > 0, dice.below(5), dice.below(4) == 0);
        let elastic = |dice: &mut Dice| {
            Elastic::new(40.0 + 20.0 * dice.number(), rest_length).damped(damping)
        };
        let (mut bodies, mut springs, mut id) = (Vec::new(), Vec::new(), 0);
        for group in 0..u32::try_from(GROUPS).unwrap() {
            for (movable, joined) in SHAPES {
                let all = joined.iter().flatten().max().unwrap() + 1;
                let first = bodies.len();
                for row in 0..all {
                    let inverse_mass = if row < movable { 1.0 + dice.number() } else { 0.0 };
                    // Few posts move.
                    let velocity = if row < movable || dice.below(40) == 0 {
                        dice.vector()
                    } else {
                        DVec3::ZERO
                    };
                    let at = Transform::at(dice.vector() * 2.0);
                    let mut body =
                        world.spawn((StableId(id), at, PhysicsBody { velocity, inverse_mass }));
                    id += 1;
                    if row < movable && with_options {
                        options(&mut body, &mut dice, kind);
                    }
                    if alone {
                        mark(&mut body, group);
                    }
                    bodies.push(body.id());
                }
                springs.extend(joined.iter().map(|ends| {
                    let spring = Spring {
                        ends: ends.map(|end| bodies[first + end]),
                        elastic: elastic(&mut dice),
                    };
                    world.spawn(spring).id()
                }));
            }
        }
        let mut stepper = Stepper::new(&mut world, method, TimeStep(1.0 / 60.0));
        let ledger = with_ledger.then(|| {
            stepper.recompile(&mut world);
            Ledger::open(&world)
        });
        Self { world, stepper, ledger, bodies, springs }
    }

    fn tick(&mut self) {
        match &mut self.ledger {
            Some(ledger) => ledger.tick(&mut self.stepper, &mut self.world),
            None => self.stepper.tick(&mut self.world),
        }
    }

    /// Everything that two sides are compared in.
    fn state(&mut self) -> (Vec<(StableId, Bits)>, String) {
        let mut query = self.world.query::<(&StableId, &Transform, &PhysicsBody)>();
        let rows = query.iter(&self.world);
        let mut rows: Vec<_> =
            rows.map(|(id, at, body)| (*id, bits(at.position, body.velocity))).collect();
        rows.sort_by_key(|(id, _)| *id);
        let records = self.world.resource::<Quarantine>().records();
        let records: Vec<_> =
            records.iter().map(|record| (record.id, record.tick, record.cause)).collect();
        let totals = self.ledger.as_ref().map(Ledger::last_second);
        let counts = self.world.resource::<Evaluations>();
        (rows, format!("{counts:?} {records:?} {totals:?}"))
    }
}

/// Damping, laws of position, velocity and time, substeps.
fn environment(world: &mut World, dice: &mut Dice) {
    if let model @ 0..3 = dice.below(5) {
        world.insert_resource(Damping { model: DampingModel::ALL[model], rate: 0.4 });
    }
    match dice.below(8) {
        0 => world.insert_resource(Drag::new(0.1, 0.0)),
        1 => world.insert_resource(Drag::new(0.1, 0.05)),
        2 => world.insert_resource(Wells(vec![Well {
            position: DVec3::Y,
            strength: 3.0,
            softening: 0.5,
        }])),
        3 => world.insert_resource(Laws(vec![Box::new(Gust([0.125]))])),
        _ => {}
    }
    if dice.below(3) == 0 {
        world.insert_resource(Substeps(3));
    }
    world.insert_resource(Range { position: 60.0, speed: 80.0 });
    world.insert_resource(match dice.below(4) {
        0 => Solver { most_iterations: u32::try_from(dice.below(4)).unwrap(), ..Solver::default() },
        1 => Solver { newton_iterations: 3, ..Solver::default() },
        _ => Solver::default(),
    });
}

/// Options of a body: few of each kind.
fn options(body: &mut EntityWorldMut, dice: &mut Dice, kind: usize) {
    match kind {
        0 => drop(body.insert(SpeedLimit([1.5, 4.0][dice.below(2)]))),
        1 => drop(body.insert(AxisLocks { x: dice.below(2) == 0, y: false, z: true })),
        2 => drop(body.insert(DampingRate::new([0.2, 0.9][dice.below(2)]))),
        3 => drop(body.insert(GravityOff)),
        _ => {}
    }
}

fn mark(body: &mut EntityWorldMut, group: u32) {
    macro_rules! marks {
        ($($bit:literal)*) => {
            $(if group >> $bit & 1 == 1 {
                body.insert(Mark::<$bit>);
            })*
        };
    }
    marks!(0 1 2 3 4 5);
}

/// Changes that a group may see between two ticks.
fn operate(dice: &mut Dice, sides: &mut [Side; 2]) {
    let (body, spring) = (dice.below(sides[0].bodies.len()), dice.below(sides[0].springs.len()));
    let (vector, number, kind) = (dice.vector(), dice.number(), dice.below(16));
    for side in sides {
        let (entity, world) = (side.bodies[body], &mut side.world);
        let mut ask = |request| world.resource_mut::<Requests>().ask(request);
        match kind {
            0 => ask(Request::SetVelocity(entity, vector)),
            1 => ask(Request::SetPosition(entity, vector)),
            2 => ask(Request::SwitchGravity(number > 0.0)),
            3 => ask(Request::ReverseVelocities),
            4 => ask(Request::SetInverseMass(entity, if number > 0.7 { 0.0 } else { 1.5 })),
            5 => ask(Request::SetBodyMethod(entity, Some(Method::VelocityVerlet))),
            6 => ask(Request::Switch(Effect::Springs, number > -0.7)),
            7 if number > 0.5 => ask(Request::Remove(entity)),
            8 => {
                let old = world.get::<Spring>(side.springs[spring]).copied();
                if let Some(Spring { ends, elastic }) = old {
                    let elastic = Elastic { stiffness: 60.0, ..elastic };
                    world.entity_mut(side.springs[spring]).insert(Spring { ends, elastic });
                }
            }
            9 if world.get::<SpeedLimit>(entity).is_some() => {
                world.entity_mut(entity).insert(SpeedLimit(2.0));
            }
            10 if let Ok(mut body) = world.get_entity_mut(entity) => {
                body.insert(OwnSubsteps(if number > 0.0 { 2 } else { 3 }));
            }
            11 if let Some(mut at) = world.get_mut::<Transform>(entity) => {
                at.position =
                    if number > 0.9 { DVec3::splat(f64::NAN) } else { at.position + vector };
            }
            12 if let Some(mut body) = world.get_mut::<PhysicsBody>(entity) => {
                body.velocity = if number > 0.9 { DVec3::splat(1e3) } else { vector };
            }
            14 if let Ok(mut body) = world.get_entity_mut(entity) => {
                if body.contains::<GravityOff>() {
                    body.remove::<GravityOff>();
                } else {
                    body.insert(GravityOff);
                }
            }
            _ => {}
        }
        if world.get_entity(entity).is_ok() {
            let newtons = if kind == 13 && number > 0.8 {
                DVec3::splat(f64::INFINITY)
            } else {
                vector * 20.0
            };
            world.resource_mut::<PushQueue>().push_once(entity, newtons);
        }
    }
}

#[test]
fn groups_side_by_side_have_the_bits_counts_and_records_of_groups_alone() {
    let worlds =
        Method::ALL.into_iter().flat_map(|method| (0..WORLDS).map(move |seed| (method, seed)));
    for (method, seed) in worlds {
        let mut sides = [false, true].map(|alone| Side::new(method, seed, alone));
        let mut dice = Dice(seed ^ 0x51de_b451);
        let before = sides[0].state().0;
        for tick in 0..40 {
            if tick > 3 && dice.below(2) == 0 {
                operate(&mut dice, &mut sides);
            }
            if dice.below(20) == 0 {
                for Side { world, stepper, .. } in &mut sides {
                    let saved = snapshot::take(world, stepper);
                    snapshot::restore(world, stepper, &saved).unwrap();
                }
            }
            sides.iter_mut().for_each(Side::tick);
            let [(rows, all), (others, of_others)] = sides.each_mut().map(Side::state);
            assert!(
                rows == others,
                "{method:?}, seed {seed}, tick {tick}: {:?}",
                first_difference(&rows, &others)
            );
            assert_eq!(all, of_others, "{method:?}, seed {seed}, tick {tick}");
        }
        assert_ne!(before, sides[0].state().0);
    }
}

fn first_difference<T: PartialEq + Copy>(rows: &[T], others: &[T]) -> Option<(T, T)> {
    rows.iter().zip(others).find(|(a, b)| a != b).map(|(a, b)| (*a, *b))
}

/// The worlds of this test have bundles, and the others have none.
#[test]
fn groups_alone_are_in_no_bundle() {
    let mut sides = [false, true].map(|alone| Side::new(Method::RungeKutta4, 7, alone));
    sides.iter_mut().for_each(Side::tick);
    let bundled = sides.each_ref().map(|side| side.world.resource::<Groups>().side_by_side());
    assert_eq!(bundled, [GROUPS * SHAPES.len(), 0]);
}
