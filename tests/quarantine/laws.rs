//! A NaN written into what acts on bodies: the record names it, and nothing stays that is not a number.

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::{
    Cause, Damping, Drag, Elastic, Fault, Gravity, GravityOff, Method, MutualGravity, PhysicsBody,
    Range, Request, SoftBody, SourceMass, Spring, StableId, Static, Transform, Wells,
};
use scene::Scene;

use super::rig::{Harm, bits, is_finite, records, run, run_harmed, scenes, start, systems};
use crate::rigs::scene_of;

const LEAD: u64 = 3;

/// Resources that act on every body, with what overwrites them; the world has to have the first.
fn resources() -> [(&'static str, fn(&World) -> bool, fn() -> Harm); 6] {
    fn change<R: Resource<Mutability = bevy_ecs::component::Mutable>>(edit: fn(&mut R)) -> Harm {
        Box::new(move |world| edit(&mut world.resource_mut::<R>()))
    }
    [
        ("Gravity", World::contains_resource::<Gravity>, || {
            change::<Gravity>(|gravity| gravity.acceleration.y = f64::NAN)
        }),
        ("Damping", World::contains_resource::<Damping>, || {
            change::<Damping>(|damping| damping.rate = f64::NAN)
        }),
        ("Drag", World::contains_resource::<Drag>, || {
            change::<Drag>(|drag| drag.linear = f64::NAN)
        }),
        ("Wells", World::contains_resource::<Wells>, || {
            change::<Wells>(|wells| wells.0[0].strength = f64::INFINITY)
        }),
        ("MutualGravity", World::contains_resource::<MutualGravity>, || {
            change::<MutualGravity>(|law| law.constant = f64::NAN)
        }),
        (
            "Range",
            |_| true,
            || Box::new(|world| world.insert_resource(Range { speed: f64::NAN, ..Range::FINITE })),
        ),
    ]
}

/// Bodies that something acts on.
fn movable(rig: &mut Simulation, weightless: bool) -> usize {
    let mut bodies =
        rig.world.query_filtered::<(&PhysicsBody, Has<GravityOff>), Without<motion::Dormant>>();
    bodies
        .iter(&rig.world)
        .filter(|(body, off)| body.inverse_mass > 0.0 && (weightless || !off))
        .count()
}

#[test]
fn a_resource_that_is_not_a_number_is_named_by_every_body_that_it_breaks() {
    for (name, scene) in scenes() {
        for (resource, there, harm) in resources() {
            let mut rig = start(&scene);
            run(&mut rig, LEAD);
            if !there(&rig.world) {
                continue;
            }
            for at in [0, systems(&mut rig).len() - 1] {
                let what = format!("{name}: {resource} before system {at}");
                let mut rig = start(&scene);
                run(&mut rig, LEAD);
                let bodies = movable(&mut rig, resource != "Gravity");
                run_harmed(&mut rig, at, harm());
                run(&mut rig, 2);
                assert!(is_finite(&mut rig), "{what}");
                let records = records(&rig);
                assert!(!records.is_empty() || bodies == 0, "{what}");
                for record in records {
                    let cause = record.cause;
                    assert_eq!((cause.component, cause.fault), (resource, Fault::Found), "{what}");
                    // Before the last system every other one was over.
                    let first = if at == 0 { LEAD + 1 } else { LEAD + 2 };
                    assert!(record.tick >= first, "{what}: {record:?}");
                }
            }
        }
    }
}

/// Every way in which a spring is not a number.
fn broken(elastic: Elastic) -> [Elastic; 4] {
    [
        Elastic { stiffness: f64::NAN, ..elastic },
        Elastic { damping: f64::NAN, ..elastic },
        Elastic { rest_length: f64::NAN, ..elastic },
        Elastic { stiffness: f64::INFINITY, ..elastic },
    ]
}

/// Replaces the first spring that a body hangs on.
fn break_a_spring(rig: &mut Simulation, how: usize) -> bool {
    let mut springs = rig.world.query::<(Entity, &Spring)>();
    let first = springs
        .iter(&rig.world)
        .min_by_key(|(entity, _)| *entity)
        .map(|(entity, spring)| (entity, *spring));
    if let Some((entity, spring)) = first {
        rig.world
            .entity_mut(entity)
            .insert(Spring { elastic: broken(spring.elastic)[how], ..spring });
        return true;
    }
    let mut softs = rig.world.query::<(Entity, &SoftBody)>();
    let first = softs.iter(&rig.world).next().map(|(entity, soft)| (entity, soft.clone()));
    let Some((entity, mut soft)) = first else { return false };
    // Nothing comes of a spring between two points that are held.
    let moves = |end: &u32| {
        let point = soft.points[*end as usize];
        rig.world.get::<PhysicsBody>(point).is_some_and(|body| body.inverse_mass > 0.0)
    };
    let middle = (soft.springs.len() / 2..soft.springs.len())
        .find(|at| soft.springs[*at].ends.iter().any(moves))
        .unwrap();
    let springs = std::sync::Arc::make_mut(&mut soft.springs);
    springs[middle].elastic = broken(springs[middle].elastic)[how];
    rig.world.entity_mut(entity).insert(soft);
    true
}

#[test]
fn a_spring_that_is_not_a_number_is_named_and_takes_one_end_and_nothing_else() {
    let mut checked = 0;
    for (name, scene) in scenes() {
        for how in 0..4 {
            let mut rig = start(&scene);
            run(&mut rig, LEAD);
            if !break_a_spring(&mut rig, how) {
                continue;
            }
            checked += 1;
            let what = format!("{name}, {how}");
            run(&mut rig, 1);
            let records = records(&rig);
            assert_eq!(records.len(), 1, "{what}: {records:?}");
            let expected =
                Cause { system: "integrate_groups", component: "Spring", fault: Fault::Found };
            assert_eq!((records[0].cause, records[0].tick), (expected, LEAD + 1), "{what}");
            let victim = records[0].body;
            let id = *rig.world.get::<StableId>(victim).unwrap();
            let mut without = start(&scene);
            run(&mut without, LEAD);
            without.request(Request::Remove(without.bodies[id.0 as usize]));
            for tick in 0..3 {
                if tick > 0 {
                    run(&mut rig, 1);
                }
                run(&mut without, 1);
                let same = bits(&rig, id) == bits(&without, id);
                assert!(is_finite(&mut rig) && same, "{what}, {tick} ticks later");
            }
        }
    }
    assert!(checked >= 12, "{checked}");
}

/// Two bodies and a fixed one that attract each other, under a method that can solve it.
fn attracting(method: Method) -> Scene {
    let text = format!(
        "(version: 1, method: {}, mutual_gravity: (constant_m3_kg_s2: 1.0), bodies: [
            (name: \"sun\", position_m: (0, 0, 0), immovable: true, mass_kg: 10),
            (name: \"a\", position_m: (3, 0, 0), velocity_m_s: (0, 1, 0)),
            (name: \"b\", position_m: (0, -4, 0), velocity_m_s: (1, 0, 0)),
        ])",
        method.name()
    );
    scene_of(&text)
}

#[test]
fn what_a_group_hangs_on_is_named_and_no_longer_pulls() {
    type Case = (&'static str, fn(Entity, &mut World));
    let cases: [Case; 3] = [
        ("SourceMass", |sun, world| {
            world.entity_mut(sun).insert(SourceMass(f64::NAN));
        }),
        ("Transform.position", |sun, world| {
            world.get_mut::<Transform>(sun).unwrap().position.x = f64::NAN;
        }),
        ("PhysicsBody.velocity", |sun, world| {
            world.get_mut::<PhysicsBody>(sun).unwrap().velocity.x = f64::NAN;
        }),
    ];
    for method in Method::ALL.into_iter().filter(|method| *method != Method::ImplicitEuler) {
        for (component, harm) in cases {
            let what = format!("{method:?}, {component}");
            let scene = attracting(method);
            let (mut rig, mut without) = (start(&scene), start(&scene));
            run(&mut rig, LEAD);
            run(&mut without, LEAD);
            let sun = rig.bodies[0];
            harm(sun, &mut rig.world);
            without.request(Request::Remove(without.bodies[0]));
            for tick in 0..3 {
                run(&mut rig, 1);
                run(&mut without, 1);
                assert!(
                    bits(&rig, StableId(0)) == bits(&without, StableId(0)),
                    "{what}, {tick} ticks later"
                );
            }
            let records = records(&rig);
            assert_eq!(records.len(), 1, "{what}: {records:?}");
            let (record, cause) = (records[0], records[0].cause);
            assert_eq!((record.body, record.tick), (sun, LEAD + 1), "{what}");
            assert_eq!((cause.system, cause.component), ("integrate_groups", component), "{what}");
            assert!(is_finite(&mut rig), "{what}");
        }
    }
}

#[test]
fn a_body_at_rest_that_holds_nothing_costs_nothing_and_is_not_named() {
    let scene = scene::load("tutorial").unwrap();
    let mut rig = start(&scene);
    run(&mut rig, LEAD);
    let mut resting = rig.world.query_filtered::<Entity, With<Static>>();
    let floor = resting.iter(&rig.world).next().unwrap();
    rig.world.get_mut::<Transform>(floor).unwrap().position = DVec3::NAN;
    run(&mut rig, 2);
    assert_eq!(records(&rig), []);
}
